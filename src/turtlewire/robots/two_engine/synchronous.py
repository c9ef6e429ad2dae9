"""A two-engine robot for people who do not write asynchronous programs: the same names, one implementation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.robots.timed.synchronous import TimedRobot
from turtlewire.robots.two_engine.driver import AsyncTwoEngine

if TYPE_CHECKING:
    from turtlewire.robots.calibration import TwoEngineCalibration
    from turtlewire.robots.two_engine.settings import Statistics


class TwoEngine(TimedRobot[AsyncTwoEngine]):
    """A two-engine robot. ``turtlewire.connect`` makes one; it is a context manager, a ``Turtle`` and a ``Drive``.

    The methods do what ``Turtle`` and ``Drive`` say, and raise what ``AsyncTwoEngine`` says.
    """

    @property
    def statistics(self) -> Statistics:
        """Figures of this connection."""
        return self._robot.statistics

    def engine(self, number: int, speed: int, *, valid_s: float | None = None) -> None:
        """Turn one engine, until told otherwise: -255 (full speed backward) .. 255 (full speed forward)."""
        self._runner.run(self._robot.engine(number, speed, valid_s=valid_s))

    def hold(self, left: int, right: int, seconds: float, settle_s: float | None = None) -> None:
        """Turn the wheels for a time, and stand still again."""
        self._runner.run(self._robot.hold(left, right, seconds, settle_s))

    def recalibrate(self, calibration: TwoEngineCalibration) -> None:
        """From now on, drive by another calibration."""
        self._runner.run(self._robot.recalibrate(calibration))

    @property
    def ticks(self) -> tuple[int, int] | None:
        """The ticks of the encoders, left and right, since the first report; None: the robot reports none."""
        return self._robot.ticks

    @property
    def goes_backward(self) -> bool:
        """Whether it can be told to (F1)."""
        return self._robot.goes_backward

    def set_servo(self, number: int, position_deg: int) -> None:
        """Move a servo to 0..180 degrees."""
        self._runner.run(self._robot.set_servo(number, position_deg))
