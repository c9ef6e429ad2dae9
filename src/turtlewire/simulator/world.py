"""Where simulated robots live: walls, and how far a disc gets before it touches one.

Millimetres; bearings in degrees, 0 = +Y, clockwise. A world never changes, so robots may share one, and its
``walls`` are plain numbers that a kernel for many robots can take as they are.
"""

from __future__ import annotations

import math
import tomllib
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from turtlewire.errors import DataError, UsageError
from turtlewire.turtle import HOME, Pose

# A disc this near to a wall touches it. Far above the rounding of the arithmetic, far below any sensor.
TOUCH_MM = 0.001
# The sine of the angle below which a motion counts as along the wall that is touched, not into it.
ALONG = 1e-6
# Coordinates that an arena may have: beyond, the arithmetic would lose micrometres.
FURTHEST_MM = 1e6


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


class Contact(NamedTuple):
    """Where a moving disc meets a wall.

    Attributes:
        distance_mm: how far it gets.
        bearing_deg: from its centre to the point that it touches, -180 < b <= 180.
        pressure: how squarely it runs into the wall: 1 head on, 0 along it.
    """

    distance_mm: float
    bearing_deg: float
    pressure: float


class World:
    """Walls, and where the first robot starts."""

    def __init__(self, walls: tuple[Wall, ...] = (), start: Pose = HOME) -> None:
        self.walls = walls
        self.start = start

    def gap(self, x_mm: float, y_mm: float, radius_mm: float) -> float:
        """How far a disc is from the nearest wall; negative when a wall cuts it, infinite without walls."""
        nearest = math.inf
        for wall in self.walls:
            wx, wy = wall.nearest(x_mm, y_mm)
            nearest = min(nearest, math.hypot(wx - x_mm, wy - y_mm))
        return nearest - radius_mm

    def near(self, x_mm: float, y_mm: float, reach_mm: float) -> World:
        """The world as far as it can matter within this distance of a point."""
        walls = (wall for wall in self.walls if math.dist((x_mm, y_mm), wall.nearest(x_mm, y_mm)) <= reach_mm)
        return World(tuple(walls), self.start)

    def contact(
        self, x_mm: float, y_mm: float, direction: tuple[float, float], distance_mm: float, radius_mm: float
    ) -> Contact | None:
        """What a disc meets first on a straight way, at most ``distance_mm`` (may be infinite) long; None: nothing.

        ``direction`` is a unit vector. A disc that touches a wall already meets it at distance 0 if the way leads
        into the wall; away from it and along it the way is free.
        """
        first: Contact | None = None
        for wall in self.walls:
            found = _contact(wall, x_mm, y_mm, direction, radius_mm)
            if found is None or found.distance_mm > distance_mm:
                continue
            # Two walls at once (a corner): the one that is pressed harder.
            if first is None or (found.distance_mm, -found.pressure) < (first.distance_mm, -first.pressure):
                first = found
        return first


def _contact(wall: Wall, x: float, y: float, direction: tuple[float, float], radius: float) -> Contact | None:
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
    pressure = ((wx - x) * direction[0] + (wy - y) * direction[1]) / apart if apart else 0.0
    if pressure <= ALONG:
        return None
    return Contact(far, math.degrees(math.atan2(wx - x, wy - y)), pressure)


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
    """Read an arena file: TOML with ``[[wall]]`` polylines and an optional ``[start]``.

    ::

        [start]                                      # all three may be left out: 0
        x_mm = 0
        y_mm = 0
        heading_deg = 0
        [[wall]]
        points = [[-500, -500], [500, -500], [500, 500]]

    Raises ``UsageError`` if there is no such file, ``DataError`` with the place if something in it is wrong.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise DataError(f"{path}: this is no arena file: byte {error.start} is not UTF-8 text") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise UsageError(f"{path}: the arena file cannot be read: {reason}") from None
    try:
        content = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise DataError(f"{path}: this is no valid TOML: {error}") from None
    return _Arena(str(path)).world(content)


class _Arena:
    """Checks what an arena file says; every complaint names the file and the entry."""

    def __init__(self, path: str) -> None:
        self.path = path

    def world(self, content: dict[str, Any]) -> World:
        self._known(content, ("start", "wall"), "an arena")
        entries = content.get("wall", [])
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            raise self._wrong("wall", "walls are written [[wall]], with points = [[x, y], [x, y], ...]")
        walls: list[Wall] = []
        for number, entry in enumerate(entries, 1):
            walls += self._wall(entry, f"wall {number}")
        return World(tuple(walls), self._start(content.get("start", {})))

    def _start(self, entry: object) -> Pose:
        if not isinstance(entry, dict):
            raise self._wrong("start", "the start is written [start], with x_mm, y_mm and heading_deg")
        self._known(entry, Pose._fields, "start")
        x, y, heading = (self._number(entry.get(name, 0), f"start: {name}") for name in Pose._fields)
        return Pose(x, y, heading % 360.0)

    def _wall(self, entry: dict[str, Any], where: str) -> list[Wall]:
        self._known(entry, ("points",), where)
        points = entry.get("points")
        if not isinstance(points, list) or len(points) < 2:
            raise self._wrong(where, "it needs points = [[x, y], [x, y], ...], at least two of them")
        corners = [self._point(point, f"{where}, point {i}") for i, point in enumerate(points, 1)]
        for i, (one, other) in enumerate(pairwise(corners), 1):
            if math.dist(one, other) < TOUCH_MM:
                raise self._wrong(where, f"points {i} and {i + 1} are the same")
        return [Wall(*one, *other) for one, other in pairwise(corners)]

    def _point(self, point: object, where: str) -> tuple[float, float]:
        if not isinstance(point, list) or len(point) != 2:
            raise self._wrong(where, f"a point is [x, y], in millimetres, not {point!r}")
        return self._number(point[0], where), self._number(point[1], where)

    def _number(self, value: object, where: str) -> float:
        # bool is a kind of int, and TOML knows nan and inf.
        if not isinstance(value, int | float) or isinstance(value, bool) or not abs(value) <= FURTHEST_MM:
            raise self._wrong(
                where, f"{value!r} is not a number from {-FURTHEST_MM:.0f} to {FURTHEST_MM:.0f}"
            )
        return float(value)

    def _known(self, entry: dict[str, Any], names: tuple[str, ...], where: str) -> None:
        for name in entry:
            if name not in names:
                raise self._wrong(where, f"there is no {name!r}; known are {', '.join(names)}")

    def _wrong(self, where: str, what: str) -> DataError:
        return DataError(f"{self.path}: {where}: {what}")
