"""What lies between a command and the ground: calibration, motors that lag, servos that slew, a battery that sags.

Each part is asked for its mean over the coming time, then told how much of it has passed: no path is
approximated but by pieces of even speed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

# A motor this near to the speed that it is going for has got there.
SETTLED_MM_PER_S = 0.01


class SpeedCurve(NamedTuple):
    """What speed a motor comes to by its PWM: none within the dead band, and evenly more beyond.

    Attributes:
        dead_pwm: 0..254; up to this PWM it does not move.
        mm_per_s_per_pwm: speed for each unit of PWM beyond.
        backward_factor: what it makes of it backwards, as a part of that.
    """

    dead_pwm: int
    mm_per_s_per_pwm: float
    backward_factor: float = 1.0

    def speed_mm_per_s(self, pwm: float) -> float:
        """The speed at a PWM of -255..255; negative ones go backwards."""
        beyond = max(0.0, abs(pwm) - self.dead_pwm)
        speed = beyond * self.mm_per_s_per_pwm
        return speed if pwm >= 0 else -speed * self.backward_factor


class Motor:
    """A motor that follows its target with a lag (first order: after ``lag_s``, 63% of a change).

    Args:
        lag_s: when it is told a speed.
        coast_s: when it is told to stand still; None: the same.

    Attributes:
        lag_s: the lag of what it does now.
        speed: mm/s, now.
        target: mm/s, where it is going for.
    """

    def __init__(self, lag_s: float = 0.0, coast_s: float | None = None) -> None:
        self._lags_s = (lag_s if coast_s is None else coast_s, lag_s)
        self.lag_s = lag_s
        self.speed = 0.0
        self.target = 0.0

    def set_target(self, target: float) -> None:
        """Go for another speed from now on."""
        self.target = target
        self.lag_s = self._lags_s[target != 0.0]
        if not self.lag_s:
            self.speed = target

    @property
    def is_settled(self) -> bool:
        """Whether its speed stays as it is."""
        return self.speed == self.target

    def mean(self, seconds: float) -> float:
        """The mean speed during the coming time."""
        if self.is_settled:
            return self.target
        part = -math.expm1(-seconds / self.lag_s) * self.lag_s / seconds
        return self.target + (self.speed - self.target) * part

    def advance(self, seconds: float) -> None:
        """Time has passed."""
        if self.is_settled:
            return
        self.speed = self.target + (self.speed - self.target) * math.exp(-seconds / self.lag_s)
        if abs(self.speed - self.target) < SETTLED_MM_PER_S:
            self.speed = self.target


class Servo:
    """A servo that turns evenly to where it is told to be.

    Attributes:
        angle: degrees, now.
        target: degrees, where it turns to.
        rate: degrees per second; infinite: it is there at once.
    """

    def __init__(self, rate: float = math.inf, angle: float = 0.0) -> None:
        self.rate = rate
        self.angle = angle
        self.target = angle

    def set_target(self, target: float) -> None:
        """Turn to another angle from now on."""
        self.target = target
        if self.rate == math.inf:
            self.angle = target

    @property
    def is_settled(self) -> bool:
        """Whether it has got there."""
        return self.angle == self.target

    @property
    def needs_s(self) -> float:
        """How long until it gets there."""
        return abs(self.target - self.angle) / self.rate

    def at(self, seconds: float) -> float:
        """Its angle after some more time."""
        if seconds >= self.needs_s:
            return self.target
        return self.angle + math.copysign(self.rate * seconds, self.target - self.angle)

    def mean(self, seconds: float) -> float:
        """The mean angle during the coming time."""
        if self.is_settled:
            return self.target
        turning = min(seconds, self.needs_s)
        turned = (self.angle + self.at(turning)) / 2.0 * turning
        return (turned + self.target * (seconds - turning)) / seconds

    def advance(self, seconds: float) -> None:
        """Time has passed."""
        self.angle = self.at(seconds)


class Battery:
    """A battery whose robot gets slower, evenly with what has been drawn, until it is empty."""

    def __init__(self, sag: float, full_power_s: float) -> None:
        self.sag = sag
        self._full_power_s = full_power_s
        self._used_s = 0.0
        self._power = 0.0
        self._since = 0.0

    def draw(self, power: float, now: float) -> float:
        """Draw this part, 0..1, of full power from now on; return what is left of the speed, ``1 - sag``..1."""
        self._used_s += self._power * (now - self._since)
        self._power, self._since = power, now
        return self.level(now)

    def level(self, now: float) -> float:
        """What is left of the speed now, ``1 - sag``..1."""
        used_s = self._used_s + self._power * (now - self._since)
        return 1.0 - self.sag * min(1.0, used_s / self._full_power_s)
