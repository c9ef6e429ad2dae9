"""How a car moves for every PWM and every steering: worked out once for a calibration, for it is asked all the time."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

from turtlewire.robots.calibration import FULL_PWM
from turtlewire.robots.timed.reckoning import Motion

if TYPE_CHECKING:
    from turtlewire.robots.calibration import CarCalibration

EVERY = range(-FULL_PWM, FULL_PWM + 1)


class Motions:
    """How one car moves.

    Attributes:
        straight: the steering, -255..255, that goes most nearly straight.
    """

    def __init__(self, calibration: CarCalibration) -> None:
        self.straight = calibration.straight
        self._mm_per_s = [
            math.copysign(calibration.curve(pwm).speed_mm_per_s(abs(pwm)), pwm) for pwm in EVERY
        ]
        self._deg_per_mm = [math.degrees(calibration.curvature(steer)) for steer in EVERY]

    def motion(self, pwm: int, steer: int) -> Motion:
        """The motion at a PWM and a steering of -255..255."""
        speed = self._mm_per_s[pwm + FULL_PWM]
        return Motion(speed, speed * self._deg_per_mm[steer + FULL_PWM])


@lru_cache(maxsize=16)
def motions(calibration: CarCalibration) -> Motions:
    """Those of all cars with this calibration."""
    return Motions(calibration)
