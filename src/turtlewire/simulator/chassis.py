"""A round robot on two wheels: what they turn, what of it arrives on the ground, and where that leads.

Wheel travel is in millimetres, positive ahead. The left wheel going further turns the robot clockwise.
"""

from __future__ import annotations

import math
import random
from typing import NamedTuple

from turtlewire.turtle import Pose, direction

# Headings are rounded to this many decimals of a degree. A billionth of a degree moves nothing, but it keeps
# right angles right after any number of turns, so that squares close.
HEADING_DECIMALS = 9


class Wheels(NamedTuple):
    """How far each wheel goes."""

    left_mm: float
    right_mm: float

    def times(self, factor: float) -> Wheels:
        """Both, times a factor."""
        return Wheels(self.left_mm * factor, self.right_mm * factor)


class Travel(NamedTuple):
    """What the wheels turn (an odometer measures it), and what of it they move the robot over the ground."""

    turned: Wheels
    ground: Wheels


def drive(pose: Pose, wheels: Wheels, track_mm: float) -> Pose:
    """Where a robot gets when its wheels roll so far, evenly: along an exact arc.

    ``track_mm`` is the distance between the wheels' points of contact.
    """
    left, right = wheels
    if left == right:
        return pose.moved(left)
    middle = (left + right) / 2.0
    half = (left - right) / track_mm / 2.0
    half_deg = math.degrees(half)
    x, y = pose.x_mm, pose.y_mm
    if middle:
        dx, dy = direction(pose.heading_deg + half_deg)
        # A difference of travel may be too small to divide by.
        chord = middle * (math.sin(half) / half if half else 1.0)
        x, y = x + chord * dx, y + chord * dy
    return Pose(x, y, round((pose.heading_deg + 2.0 * half_deg) % 360.0, HEADING_DECIMALS) % 360.0)


def chords(wheels: Wheels, track_mm: float, tolerance_mm: float) -> int:
    """In how many equal pieces the way must be cut for chords to stay this near to it."""
    length = abs(wheels.left_mm + wheels.right_mm) / 2.0
    angle = abs(wheels.left_mm - wheels.right_mm) / track_mm
    if not length:
        return 1
    # The sagitta of a piece is its length times its angle / 8; no piece turns by more than a right angle.
    return max(
        1, math.ceil(math.sqrt(length * angle / (8.0 * tolerance_mm))), math.ceil(angle * 2.0 / math.pi)
    )


class Chassis:
    """A disc on two wheels, and their imperfections; the same seed gives the same imperfections.

    Args:
        radius_mm: of the disc.
        track_mm: the distance between the wheels.
        slip: each wheel loses, in each motion, between none and this fraction of its travel on the ground.
        noise_mm: the standard deviation of a wheel's own travel after one metre. It grows with the square root of
            the distance, so a metre in ten motions is as uncertain as a metre in one.
        seed: of the random numbers.
    """

    def __init__(
        self, radius_mm: float, track_mm: float, slip: float = 0.0, noise_mm: float = 0.0, seed: int = 0
    ) -> None:
        self.radius_mm = radius_mm
        self.track_mm = track_mm
        self.slip = slip
        self.noise_mm = noise_mm
        self._random = random.Random(seed)

    @property
    def is_ideal(self) -> bool:
        """Whether the wheels do exactly what they are told."""
        return not (self.slip or self.noise_mm)

    def turning(self, angle_deg: float) -> Wheels:
        """What the wheels have to do to turn clockwise on the spot."""
        rim = math.radians(angle_deg) * self.track_mm / 2.0
        return Wheels(rim, -rim)

    def travel(self, wanted: Wheels) -> Travel:
        """What the wheels make of what they are told to do in one motion."""
        if self.is_ideal:
            return Travel(wanted, wanted)
        turned, grip = self.turned(wanted), self.grip()
        return Travel(turned, Wheels(turned.left_mm * grip[0], turned.right_mm * grip[1]))

    def turned(self, wanted: Wheels) -> Wheels:
        """How far the wheels turn when they are told to: noise."""
        if not self.noise_mm:
            return wanted
        return Wheels(self._turned(wanted.left_mm), self._turned(wanted.right_mm))

    def grip(self) -> tuple[float, float]:
        """The part of its travel that each wheel, left and right, makes on the ground: slip."""
        if not self.slip:
            return 1.0, 1.0
        return 1.0 - self.slip * self._random.random(), 1.0 - self.slip * self._random.random()

    def _turned(self, wanted_mm: float) -> float:
        spread = self.noise_mm * math.sqrt(abs(wanted_mm) / 1000.0)
        turned = wanted_mm + spread * self._random.gauss(0.0, 1.0)
        return turned if turned * wanted_mm > 0.0 else 0.0  # a motor may miss a step, not turn the other way
