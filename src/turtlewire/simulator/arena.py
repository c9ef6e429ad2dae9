"""Arena files: walls, obstacles and the start, in TOML (here) or drawn as SVG (``arena_svg``).

TOML, in millimetres::

    [start]                                      # all three may be left out: 0; [[start]], as often as there are robots
    x_mm = 0
    y_mm = 0
    heading_deg = 0
    [[wall]]                                     # a polyline
    points = [[-500, -500], [500, -500], [500, 500]]
    [[polygon]]                                  # closed: nothing gets in, or out
    points = [[0, 200], [100, 200], [50, 300]]
    [[disc]]
    x_mm = 300
    y_mm = 300
    radius_mm = 50
"""

from __future__ import annotations

import math
import tomllib
from itertools import pairwise
from pathlib import Path
from typing import Any

from turtlewire.errors import DataError, UsageError
from turtlewire.simulator.world import TOUCH_MM, Disc, Wall, World
from turtlewire.turtle import Pose

# Coordinates that an arena may have: beyond, the arithmetic would lose micrometres.
FURTHEST_MM = 1e6


def load_arena(path: str | Path) -> World:
    """Read an arena file: SVG if its name ends so, TOML otherwise.

    Raises ``UsageError`` if there is no such file, ``DataError`` with the place if something in it is wrong.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise DataError(f"{path}: this is no arena file: byte {error.start} is not UTF-8 text") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise UsageError(f"{path}: the arena file cannot be read: {reason}") from None
    if Path(path).suffix.lower() == ".svg":
        from turtlewire.simulator.arena_svg import read_svg

        return read_svg(text, str(path))
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
        self._known(content, ("start", "wall", "polygon", "disc"), "an arena")
        walls: list[Wall] = []
        points = "points = [[x, y], [x, y], ...]"
        for where, entry in self._entries(content, "wall", points):
            walls += self._wall(entry, where)
        for where, entry in self._entries(content, "polygon", points):
            walls += self._wall(entry, where, closed=True)
        round_ones = self._entries(content, "disc", "x_mm, y_mm and radius_mm")
        discs = tuple(self._disc(entry, where) for where, entry in round_ones)
        first, *more = self._starts(content.get("start", {}))
        return World(tuple(walls), first, discs, tuple(more))

    def _entries(self, content: dict[str, Any], name: str, what: str) -> list[tuple[str, dict[str, Any]]]:
        entries = content.get(name, [])
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            raise self._wrong(name, f"{name}s are written [[{name}]], with {what}")
        return [(f"{name} {number}", entry) for number, entry in enumerate(entries, 1)]

    def _starts(self, entry: object) -> list[Pose]:
        if isinstance(entry, list) and entry:
            return [self._start(each, f"start {number}") for number, each in enumerate(entry, 1)]
        return [self._start(entry, "start")]

    def _start(self, entry: object, where: str) -> Pose:
        if not isinstance(entry, dict):
            raise self._wrong(
                where,
                "the start is written [start], several are written [[start]], with x_mm, y_mm and heading_deg",
            )
        self._known(entry, Pose._fields, where)
        x, y, heading = (self._number(entry.get(name, 0), f"{where}: {name}") for name in Pose._fields)
        return Pose(x, y, heading % 360.0)

    def _disc(self, entry: dict[str, Any], where: str) -> Disc:
        self._known(entry, Disc._fields, where)
        if missing := [name for name in Disc._fields if name not in entry]:
            raise self._wrong(where, f"it needs {', '.join(missing)}")
        x, y, radius = (self._number(entry[name], f"{where}: {name}") for name in Disc._fields)
        if radius <= 0.0:
            raise self._wrong(f"{where}: radius_mm", f"{radius:g} is not above 0")
        return Disc(x, y, radius)

    def _wall(self, entry: dict[str, Any], where: str, *, closed: bool = False) -> list[Wall]:
        self._known(entry, ("points",), where)
        points = entry.get("points")
        fewest = "three" if closed else "two"
        if not isinstance(points, list) or len(points) < (3 if closed else 2):
            raise self._wrong(where, f"it needs points = [[x, y], [x, y], ...], at least {fewest} of them")
        corners = [self._point(point, f"{where}, point {i}") for i, point in enumerate(points, 1)]
        if closed and math.dist(corners[0], corners[-1]) < TOUCH_MM:
            raise self._wrong(where, "the last point is the first one: a polygon is closed without")
        for i, (one, other) in enumerate(pairwise(corners), 1):
            if math.dist(one, other) < TOUCH_MM:
                raise self._wrong(where, f"points {i} and {i + 1} are the same")
        ways = pairwise([*corners, corners[0]] if closed else corners)
        return [Wall(*one, *other) for one, other in ways]

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
