"""A car for people who do not write asynchronous programs: the same names, one implementation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.robots.car.driver import AsyncCar
from turtlewire.robots.timed.synchronous import TimedRobot

if TYPE_CHECKING:
    from turtlewire.robots.car.settings import Statistics


class Car(TimedRobot[AsyncCar]):
    """A car. ``turtlewire.connect`` makes one; it is a context manager, a ``Turtle`` and a ``Drive``.

    The methods do what ``Turtle`` and ``Drive`` say, and raise what ``AsyncCar`` says.
    """

    @property
    def statistics(self) -> Statistics:
        """Figures of this connection."""
        return self._robot.statistics

    @property
    def turning_radius_mm(self) -> float:
        """The radius of the narrowest circle that the car can drive, of the middle of its rear axle."""
        return self._robot.turning_radius_mm

    def motor(self, pwm: int, *, valid_s: float | None = None) -> None:
        """Drive ahead, or backwards when negative, -255..255, until told otherwise."""
        self._runner.run(self._robot.motor(pwm, valid_s=valid_s))

    def steer(self, steering: int) -> None:
        """Turn the front wheels: -255 (full lock left) .. 255 (full lock right), until told otherwise."""
        self._runner.run(self._robot.steer(steering))

    def hold(self, pwm: int, steering: int, seconds: float, settle_s: float | None = None) -> None:
        """Turn the front wheels, drive for a time, and stand still again."""
        self._runner.run(self._robot.hold(pwm, steering, seconds, settle_s))

    def turn_wheels(self, steering: int, seconds: float) -> None:
        """Turn the front wheels of the standing car, and wait."""
        self._runner.run(self._robot.turn_wheels(steering, seconds))

    def headlights(self, *, left_upper: bool, left_lower: bool, right_upper: bool, right_lower: bool) -> None:
        """Switch all four headlights."""
        self._runner.run(
            self._robot.headlights(
                left_upper=left_upper,
                left_lower=left_lower,
                right_upper=right_upper,
                right_lower=right_lower,
            )
        )
