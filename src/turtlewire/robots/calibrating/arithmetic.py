"""The arithmetic of calibration: from millimetres on the floor to what a driver has to know. Pure functions."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.robots.calibration import FULL_PWM, SpeedCurve

if TYPE_CHECKING:
    from collections.abc import Sequence

# A curve that is nowhere off by more than this part of its full speed is taken for a straight line.
LINEAR_PART = 0.02
# Steering that is nowhere off by more than this part of the full lock is taken for that of two front wheels.
MODEL_PART = 0.03


class Way(NamedTuple):
    """How far a robot has driven, along the arc that it drove, back when negative; and turned, clockwise, meanwhile."""

    length_mm: float
    turned_rad: float

    @property
    def curvature(self) -> float:
        """1 / radius in mm: positive when the middle of the circle is on the robot's right."""
        return self.turned_rad / self.length_mm


def way(ahead_mm: float, aside_mm: float, *, backwards: bool = False) -> Way:
    """The arc that leads from where a robot stood to where it stands: it leaves in the direction in which it looked.

    Half of the angle by which it bends is that between its start and its chord.

    Args:
        ahead_mm: how far ahead of its start it stands; negative: behind it.
        aside_mm: how far to the right; negative: left.
        backwards: whether it drove backwards.
    """
    sign = -1.0 if backwards else 1.0
    half = math.atan2(aside_mm, sign * ahead_mm)
    chord = math.hypot(ahead_mm, aside_mm)
    length = chord * (half / math.sin(half) if half else 1.0)
    return Way(sign * length, sign * 2.0 * half)


class Timed(NamedTuple):
    """A motion that was held for some seconds, and how far it went: millimetres or degrees."""

    seconds: float
    amount: float


def rate_and_overrun(short: Timed, long: Timed) -> tuple[float, float]:
    """The rate per second of two motions of the same strength, and how much longer than told each lasted, in seconds.

    What starting and coasting make of a motion is the same in both, so their difference is free of it.
    """
    rate = (long.amount - short.amount) / (long.seconds - short.seconds)
    return rate, short.amount / rate - short.seconds


def rounded(value: float) -> float:
    """To four digits: nobody measures better than that."""
    return float(f"{value:.4g}")


def speed_curve(dead_pwm: int, points: Sequence[tuple[int, float]]) -> SpeedCurve:
    """The curve through measured points (PWM, mm/s): a slope where they lie on a line from the dead band, else a table.

    Raises ``DataError`` for points that are no curve.
    """
    points = sorted(points)
    beyond = [pwm - dead_pwm for pwm, _ in points]
    slope = sum(b * speed for b, (_, speed) in zip(beyond, points, strict=True)) / sum(b * b for b in beyond)
    slope = rounded(slope)
    limit = LINEAR_PART * slope * (FULL_PWM - dead_pwm)
    if all(abs(speed - slope * b) <= limit for b, (_, speed) in zip(beyond, points, strict=True)):
        return SpeedCurve(dead_pwm=dead_pwm, mm_per_s_per_pwm=slope)
    return SpeedCurve(dead_pwm=dead_pwm, mm_per_s_per_pwm=slope, table=tuple(points))


def with_dead_band(curve: SpeedCurve, dead_pwm: int) -> SpeedCurve:
    """The curve with another dead band, and what of the rest of it still makes sense."""
    table = tuple(point for point in curve.table if point[0] > dead_pwm)
    return SpeedCurve(dead_pwm=dead_pwm, mm_per_s_per_pwm=curve.mm_per_s_per_pwm, table=table)


def dead_band(slow: tuple[int, float], fast: tuple[int, float]) -> float:
    """The PWM at which a line through two points (PWM, mm/s) comes to a standstill."""
    (x0, y0), (x1, y1) = slow, fast
    return x0 - y0 * (x1 - x0) / (y1 - y0)


class Steering(NamedTuple):
    """What two front wheels do: their angle at full steering, and at none, clockwise; and how far that is off.

    ``off`` is the largest difference from a measured curvature, as a part of that at full lock.
    """

    lock_deg: float
    trim_deg: float
    off: float


def steering(wheelbase_mm: float, points: Sequence[tuple[int, float]]) -> Steering:
    """The front wheels of a car that drove measured curvatures (steering -255..255, 1/mm): two points or more.

    The wheels' angles, whose tangents are wheelbase times curvature, are on one line: by least squares.
    """
    angles = [(steer, math.atan(wheelbase_mm * curvature)) for steer, curvature in points]
    mean_x = sum(x for x, _ in angles) / len(angles)
    mean_y = sum(y for _, y in angles) / len(angles)
    slope = sum((x - mean_x) * (y - mean_y) for x, y in angles) / sum((x - mean_x) ** 2 for x, _ in angles)
    trim = mean_y - slope * mean_x
    full = math.tan(slope * FULL_PWM) / wheelbase_mm
    off = max(abs(math.tan(trim + slope * x) / wheelbase_mm - curvature) for x, curvature in points)
    return Steering(math.degrees(slope * FULL_PWM), math.degrees(trim), off / full)


class Wheels(NamedTuple):
    """How fast two wheels roll, mm/s, ahead above 0."""

    left: float
    right: float


def wheels(driven: Way, seconds: float, track_mm: float) -> Wheels:
    """How fast the wheels of a robot roll that drove so far in so many seconds."""
    half = driven.turned_rad * track_mm / 2.0
    return Wheels((driven.length_mm + half) / seconds, (driven.length_mm - half) / seconds)


def track(turned_rad_per_s: float, ahead: tuple[Way, float], back: tuple[Way, float]) -> float:
    """The distance between the wheels of a robot that turns on the spot, in mm.

    Its left wheel turned as in a drive ahead, its right wheel as in a drive back: each a way and its seconds. What
    the wheels' own speeds are depends on the track, too; all of it is linear.

    Args:
        turned_rad_per_s: of the turn on the spot, clockwise.
        ahead: the drive ahead.
        back: the drive back.
    """
    (ahead_way, ahead_s), (back_way, back_s) = ahead, back
    # left = (length + turned * track / 2) / seconds, right likewise; turned per second * track = left - right
    sum_mm_per_s = ahead_way.length_mm / ahead_s - back_way.length_mm / back_s
    bent_rad_per_s = ahead_way.turned_rad / ahead_s + back_way.turned_rad / back_s
    return sum_mm_per_s / (turned_rad_per_s - bent_rad_per_s / 2.0)
