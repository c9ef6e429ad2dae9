"""Turning a car on the spot: a multi-point turn, back and forth within the lock, that ends where it began.

A car turns about a point on its rear axle's line. Ahead with the wheels to the right and back with the wheels to the
left both turn it clockwise. Three such arcs, symmetric about the middle one::

    ahead, radius r1, turning by a/2      back, radius r2, turning by a      ahead, radius r1, turning by a/2

turn it by 2a. By the symmetry it can end off its place only along the direction in which it looks half way, by
2 ((r1 + r2) sin(a/2) - r1 sin a): nothing, if r2 = r1 (2 cos(a/2) - 1). So the arcs ahead are a little wider than the
one back, and the position is kept. Larger turns are several of these one after another. On the way the car is
never further than 2 r1 sin(a/4) from its place: the space given limits a.

Steering values are whole numbers: of all pairs near the lock, the one that ends nearest to the place is taken.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.errors import UsageError
from turtlewire.robots.calibration import FULL_PWM

if TYPE_CHECKING:
    from turtlewire.robots.calibration import CarCalibration

# Wider turns than this are no narrower in the end: r1 grows beyond measure towards 120 degrees.
MOST_TURN_DEG = 60.0
# What part of the tightest curvature a steering must have to be tried.
TIGHT = 0.7
# A turn in more pieces than this is no turn that anybody wants to watch.
MOST_PIECES = 200


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
        self._space_mm = space_mm
        # By side: radius and steering, narrowest first.
        self._radii: dict[int, list[tuple[float, int]]] = {}
        for side in (1, -1):
            curvatures = [(side * calibration.curvature(side * s), side * s) for s in range(1, FULL_PWM + 1)]
            self._radii[side] = sorted((1.0 / k, steer) for k, steer in curvatures if k > 1e-9)
        self._pieces(360.0)

    def plan(self, angle_deg: float) -> list[Arc]:
        """The arcs of a turn clockwise (counter-clockwise when negative) that ends where it begins."""
        side = 1 if angle_deg > 0.0 else -1
        pieces = self._pieces(angle_deg)
        a_deg = abs(angle_deg) / (2 * pieces)
        ahead, back = self._pair(side, math.radians(a_deg))
        arcs = [Arc(1, ahead, side * a_deg / 2.0)]
        for _ in range(pieces):
            # The last arc of a piece and the first of the next are one.
            arcs += [Arc(-1, back, side * a_deg), Arc(1, ahead, side * a_deg)]
        arcs[-1] = arcs[0]
        return arcs

    def _pieces(self, angle_deg: float) -> int:
        """In how many times three arcs to turn so far."""
        least = max(1, math.ceil(abs(angle_deg) / (2.0 * MOST_TURN_DEG)))
        whole_turns = max(1.0, abs(angle_deg) / 360.0)
        narrow = max(self._radii[1][0][0], self._radii[-1][0][0])
        for pieces in range(least, math.ceil(MOST_PIECES * whole_turns) + 1):
            a = math.radians(abs(angle_deg) / (2 * pieces))
            if 2.0 * narrow / (2.0 * math.cos(a / 2.0) - 1.0) * math.sin(a / 4.0) <= self._space_mm:
                return pieces
        raise UsageError(
            f"turn_space_mm is {self._space_mm:g}, but a car that needs a radius of {narrow:.0f} mm cannot turn in that"
        )

    def _pair(self, side: int, a: float) -> tuple[int, int]:
        """The steering ahead and back that end nearest to the place: see above."""
        ahead, back = self._radii[side], self._radii[-side]
        best = (math.inf, 0, 0)
        for r2, steer_back in back:
            if r2 * TIGHT > back[0][0]:
                break
            wanted = r2 / (2.0 * math.cos(a / 2.0) - 1.0)
            i = bisect_left(ahead, (wanted, -FULL_PWM))
            for r1, steer_ahead in ahead[max(0, i - 1) : i + 1]:
                off = abs((r1 + r2) * math.sin(a / 2.0) - r1 * math.sin(a))
                best = min(best, (off, steer_ahead, steer_back))
        return best[1], best[2]
