"""Robots that know no distances: driven by set-points that hold for a time, their place reckoned from calibration.

The car and the two-engine robot share this: a clock at the host's end (``timed_host``), the account of where the
robot is (``reckoning``), how a motion is held for its time (``motions``), and the Logo vocabulary by it (``driver``,
and ``synchronous`` for those who do not write asynchronous programs).
"""
