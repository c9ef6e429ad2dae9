"""Turning a car on the spot: a multi-point turn, back and forth at full lock, that ends where it began.

A car turns about a point on its rear axle's line. Ahead with the wheels to the right and back with the wheels to the
left both turn it clockwise. Three such arcs, symmetric about the middle one::

    ahead, radius r1, turning by b       back, radius r2, turning by c       ahead, radius r1, turning by b

turn it by 2a, where a = b + c/2. By the symmetry it can end off its place only along the direction in which it looks
half way, by 2 ((r1 + r2) sin(c/2) - r1 sin a). So the place is kept exactly, whatever the radii, if
sin(c/2) = sin(a) r1 / (r1 + r2). Larger turns are several of these one after another. The car is never further than
2 r1 sin(b/2) from its place: the space given limits a.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.errors import UsageError
from turtlewire.robots.calibration import FULL_PWM

if TYPE_CHECKING:
    from turtlewire.robots.calibration import CarCalibration

# Three arcs turn by no more than this: beyond it, they need more space and are no faster.
MOST_TURN_DEG = 120.0
# A half turn in more pieces than this is no turn that anybody wants to watch.
MOST_PIECES = 100


class Arc(NamedTuple):
    """A piece of a turn: ahead (1) or back (-1) with a steering of -255..255, turning by so much, clockwise."""

    direction: int
    steer: int
    angle_deg: float


class Turning:
    """How one car turns.

    Args:
        calibration: of its steering.
        space_mm: how far from its place the middle of the rear axle may get in a turn.

    Raises ``UsageError`` if that space is too small to turn in.
    """

    def __init__(self, calibration: CarCalibration, space_mm: float) -> None:
        self._calibration = calibration
        self._space_mm = space_mm
        for side in (1, -1):
            self._pieces(side, math.pi)

    def plan(self, angle_deg: float) -> list[Arc]:
        """The arcs of a turn clockwise (counter-clockwise when negative) that ends where it begins."""
        side = 1 if angle_deg > 0.0 else -1
        whole = math.radians(abs(angle_deg))
        pieces = self._pieces(side, whole)
        half_back = self._half_back(side, whole / (2 * pieces))
        ahead_deg = side * math.degrees(whole / (2 * pieces) - half_back)
        steer = side * FULL_PWM
        arcs = [Arc(1, steer, ahead_deg)]
        for _ in range(pieces):
            # The last arc of three and the first of the next three are one.
            arcs += [Arc(-1, -steer, side * math.degrees(2.0 * half_back)), Arc(1, steer, 2.0 * ahead_deg)]
        arcs[-1] = arcs[0]
        return arcs

    def _radius_mm(self, side: int) -> float:
        return 1.0 / abs(self._calibration.curvature(side * FULL_PWM))

    def _half_back(self, side: int, a: float) -> float:
        """c/2 for a, see above, radians."""
        ahead, back = self._radius_mm(side), self._radius_mm(-side)
        return math.asin(math.sin(a) * ahead / (ahead + back))

    def _pieces(self, side: int, whole: float) -> int:
        """In how many times three arcs to turn so far."""
        least = max(1, math.ceil(math.degrees(whole) / MOST_TURN_DEG - 1e-9))
        for pieces in range(least, least + MOST_PIECES * math.ceil(whole / math.pi)):
            a = whole / (2 * pieces)
            if 2.0 * self._radius_mm(side) * math.sin((a - self._half_back(side, a)) / 2.0) <= self._space_mm:
                return pieces
        raise UsageError(
            f"turn_space_mm is {self._space_mm:g}, but a car that needs a radius of {self._radius_mm(side):.0f} mm "
            "cannot turn in that"
        )
