"""Robots that know no distances: driven by set-points that hold for a time, their place reckoned from calibration.

The car and the two-engine robot share this: the account of where the robot is (``reckoning``), how a motion is held for
its time by the session's alarm (``motions``), and the Logo vocabulary by it (``driver``, and ``synchronous`` for those
who do not write asynchronous programs).
"""
