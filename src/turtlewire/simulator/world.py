"""Where simulated robots live: walls and round obstacles, and how far a disc gets before it touches one.

Millimetres; bearings in degrees, 0 = +Y, clockwise. A world never changes, so robots may share one, and its
``walls`` and ``discs`` are plain numbers that a kernel for many robots can take as they are.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from pathlib import Path

# A disc this near to a wall touches it. Far above the rounding of the arithmetic, far below any sensor.
TOUCH_MM = 0.001
# The sine of the angle below which a motion counts as along the wall that is touched, not into it.
ALONG = 1e-6


class Wall(NamedTuple):
    """A straight piece of wall, without thickness, that bars the way from both sides."""

    x1_mm: float
    y1_mm: float
    x2_mm: float
    y2_mm: float

    def nearest(self, x_mm: float, y_mm: float) -> tuple[float, float]:
        """The point of the wall that is nearest to a point."""
        dx, dy = self.x2_mm - self.x1_mm, self.y2_mm - self.y1_mm
        along = ((x_mm - self.x1_mm) * dx + (y_mm - self.y1_mm) * dy) / (dx * dx + dy * dy)
        along = max(0.0, min(1.0, along))
        return self.x1_mm + along * dx, self.y1_mm + along * dy


class Disc(NamedTuple):
    """A round obstacle that stands on the ground."""

    x_mm: float
    y_mm: float
    radius_mm: float


class Contact(NamedTuple):
    """Where a moving disc meets an obstacle.

    Attributes:
        distance_mm: how far it gets.
        bearing_deg: from its centre to the point that it touches, -180 < b <= 180.
        pressure: how squarely it runs into the obstacle: 1 head on, 0 along it.
    """

    distance_mm: float
    bearing_deg: float
    pressure: float


class World:
    """Walls, round obstacles, and where robots start: the first one, and those after it."""

    def __init__(
        self,
        walls: tuple[Wall, ...] = (),
        start: Pose = HOME,
        discs: tuple[Disc, ...] = (),
        more_starts: tuple[Pose, ...] = (),
    ) -> None:
        self.walls = walls
        self.start = start
        self.discs = discs
        self.starts = (start, *more_starts)

    @property
    def is_empty(self) -> bool:
        """Whether nothing stands in anybody's way."""
        return not (self.walls or self.discs)

    def gap(self, x_mm: float, y_mm: float, radius_mm: float) -> float:
        """How far a disc is from the nearest obstacle; negative when one cuts it, infinite in an empty world."""
        nearest = math.inf
        for wall in self.walls:
            wx, wy = wall.nearest(x_mm, y_mm)
            nearest = min(nearest, math.hypot(wx - x_mm, wy - y_mm))
        for disc in self.discs:
            nearest = min(nearest, math.hypot(disc.x_mm - x_mm, disc.y_mm - y_mm) - disc.radius_mm)
        return nearest - radius_mm

    def near(self, x_mm: float, y_mm: float, reach_mm: float) -> World:
        """The world as far as it can matter within this distance of a point."""
        here = (x_mm, y_mm)
        walls = (wall for wall in self.walls if math.dist(here, wall.nearest(x_mm, y_mm)) <= reach_mm)
        discs = (disc for disc in self.discs if math.dist(here, disc[:2]) - disc.radius_mm <= reach_mm)
        return World(tuple(walls), self.start, tuple(discs))

    def contact(
        self, x_mm: float, y_mm: float, direction: tuple[float, float], distance_mm: float, radius_mm: float
    ) -> Contact | None:
        """What a disc meets first on a straight way, at most ``distance_mm`` (may be infinite) long; None: nothing.

        ``direction`` is a unit vector. A disc that touches an obstacle already meets it at distance 0 if the way
        leads into it; away from it and along it the way is free.
        """
        first: Contact | None = None
        met = [_wall_contact(wall, x_mm, y_mm, direction, radius_mm) for wall in self.walls]
        met += [_disc_contact(disc, x_mm, y_mm, direction, radius_mm) for disc in self.discs]
        for found in met:
            if found is None or found.distance_mm > distance_mm:
                continue
            # Two at once (a corner): the one that is pressed harder.
            if first is None or (found.distance_mm, -found.pressure) < (first.distance_mm, -first.pressure):
                first = found
        return first


def _wall_contact(
    wall: Wall, x: float, y: float, direction: tuple[float, float], radius: float
) -> Contact | None:
    wx, wy = wall.nearest(x, y)
    apart = math.hypot(wx - x, wy - y)
    if apart - radius <= TOUCH_MM:
        # What a disc can touch of one wall is convex: whoever does not move into it now never will.
        far = 0.0
    else:
        ways = (
            _way_to_side(wall, x, y, direction, radius),
            _way_to_point(wall.x1_mm, wall.y1_mm, x, y, direction, radius),
            _way_to_point(wall.x2_mm, wall.y2_mm, x, y, direction, radius),
        )
        far = min(ways)
        if far == math.inf:
            return None
        x, y = x + far * direction[0], y + far * direction[1]
        wx, wy = wall.nearest(x, y)
        apart = math.hypot(wx - x, wy - y)
    return _pressed(far, wx - x, wy - y, apart, direction)


def _disc_contact(
    disc: Disc, x: float, y: float, direction: tuple[float, float], radius: float
) -> Contact | None:
    dx, dy = disc.x_mm - x, disc.y_mm - y
    apart = math.hypot(dx, dy)
    far = 0.0
    if apart - radius - disc.radius_mm > TOUCH_MM:
        far = _way_to_point(disc.x_mm, disc.y_mm, x, y, direction, radius + disc.radius_mm)
        if far == math.inf:
            return None
        dx, dy = dx - far * direction[0], dy - far * direction[1]
        apart = math.hypot(dx, dy)
    return _pressed(far, dx, dy, apart, direction)


def _pressed(
    far: float, dx: float, dy: float, apart: float, direction: tuple[float, float]
) -> Contact | None:
    """The contact with what is at ``dx, dy`` then, if the way leads into it."""
    pressure = (dx * direction[0] + dy * direction[1]) / apart if apart else 0.0
    if pressure <= ALONG:
        return None
    return Contact(far, math.degrees(math.atan2(dx, dy)), pressure)


def _way_to_side(wall: Wall, x: float, y: float, direction: tuple[float, float], radius: float) -> float:
    """How far until the disc touches the wall between its ends; infinite: never."""
    dx, dy = wall.x2_mm - wall.x1_mm, wall.y2_mm - wall.y1_mm
    length = math.hypot(dx, dy)
    nx, ny = -dy / length, dx / length
    beside = (x - wall.x1_mm) * nx + (y - wall.y1_mm) * ny
    if beside < 0.0:
        beside, nx, ny = -beside, -nx, -ny
    approach = -(direction[0] * nx + direction[1] * ny)
    if approach <= 0.0 or beside <= radius:
        return math.inf
    far = (beside - radius) / approach
    along = (x + far * direction[0] - wall.x1_mm) * dx + (y + far * direction[1] - wall.y1_mm) * dy
    return far if 0.0 <= along <= length * length else math.inf


def _way_to_point(
    px: float, py: float, x: float, y: float, direction: tuple[float, float], radius: float
) -> float:
    """How far until the disc touches an end of a wall; infinite: never (or it only brushes past)."""
    ahead = (px - x) * direction[0] + (py - y) * direction[1]
    aside = (px - x) * direction[1] - (py - y) * direction[0]
    inside = radius * radius - aside * aside
    if ahead <= 0.0 or inside <= 0.0:
        return math.inf
    far = ahead - math.sqrt(inside)
    return far if far >= 0.0 else math.inf


def load_arena(path: str | Path) -> World:
    """Read an arena file: SVG if its name ends so, TOML otherwise (``turtlewire.simulator.arena``).

    Raises ``UsageError`` if there is no such file, ``DataError`` with the place if something in it is wrong.
    """
    from turtlewire.simulator import arena

    return arena.load_arena(path)
