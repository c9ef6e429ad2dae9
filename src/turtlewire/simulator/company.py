"""One world, many robots: where they start, and that they share its time and are in one another's way."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations, count, islice, product
from typing import TYPE_CHECKING

from turtlewire.errors import UsageError
from turtlewire.simulator.world import TOUCH_MM
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from turtlewire.simulator.body import Body
    from turtlewire.simulator.settings import BodySettings
    from turtlewire.simulator.world import Disc

# How many places are tried for a robot before its arena counts as full.
MOST_PLACES = 10_000


def find_starts(robots: Sequence[Body[BodySettings]], spacing_mm: float) -> list[Body[BodySettings]]:
    """Robots like these, with a start each.

    Those whose settings name one stay there. The others get the starts of the world, in order, and where there are no
    more the free places of a grid around the first one, from its right-hand side on, that a robot could drive to.

    Args:
        robots: new ones, whose settings have the same world.
        spacing_mm: of the grid, above 0.

    Raises ``UsageError`` if there is no room for one.
    """
    placed = [robot for robot in robots if robot.settings.start is not None]
    found: list[Body[BodySettings]] = []
    places = _places(robots[0].settings.world.starts, spacing_mm)
    for number, robot in enumerate(robots, 1):
        if robot.settings.start is None:
            placed.append(_placed(robot, placed, places, number))
            found.append(placed[-1])
        else:
            found.append(robot)
    return found


def _placed(
    robot: Body[BodySettings], others: Sequence[Body[BodySettings]], places: Iterator[Pose], number: int
) -> Body[BodySettings]:
    """The robot at the next place where it fits; those before it are taken, or too narrow for any."""
    world, radius_mm = robot.settings.world, robot.settings.radius_mm
    first = world.start
    for start in islice(places, MOST_PLACES):
        if start not in world.starts:
            way_mm = first.distance_to(start.x_mm, start.y_mm)
            ahead = ((start.x_mm - first.x_mm) / way_mm, (start.y_mm - first.y_mm) / way_mm)
            if world.contact(first.x_mm, first.y_mm, ahead, way_mm + radius_mm, radius_mm):
                continue
        new = type(robot)(replace(robot.settings, start=start))
        if all(_apart_mm(new.disc(), other.disc()) >= -TOUCH_MM for other in others):
            return new
    raise UsageError(f"simulated robots: there is no room for robot {number} in this arena")


def _places(starts: Sequence[Pose], spacing_mm: float) -> Iterator[Pose]:
    """The starts, then a grid around the first: square rings, each from the right-hand side on."""
    yield from starts
    x_mm, y_mm, heading_deg = starts[0]
    for ring in count(1):
        cells = product(range(-ring, ring + 1), repeat=2)
        edge = [cell for cell in cells if max(map(abs, cell)) == ring]
        for x, y in sorted(edge, key=lambda cell: (abs(cell[1]), -cell[0], -cell[1])):
            yield Pose(x_mm + x * spacing_mm, y_mm + y * spacing_mm, heading_deg)


def share_world(robots: Sequence[Body[BodySettings]], *, solid: bool = True) -> None:
    """Let robots live in one world, from power-on: each on its own line, all in one time.

    What one of them waits for, all live through; whoever reads lets time pass for all.

    Args:
        robots: new ones, whose settings have the same world.
        solid: whether they bump into one another, as discs; else they drive through one another.

    Raises ``UsageError`` if their worlds differ, if one has lived already, or if solid ones overlap.
    """
    if len({id(robot) for robot in robots}) < len(robots):
        raise UsageError("simulated robots: one is there twice")
    for number, robot in enumerate(robots, 1):
        world, first = robot.settings.world, robots[0].settings.world
        if (world.walls, world.discs) != (first.walls, first.discs):
            raise UsageError(f"simulated robots: robot {number} is in another world than robot 1")
        if robot.now > 0.0 or len(robot.company) > 1:
            raise UsageError(
                f"simulated robots: robot {number} has lived already: a world is shared from power-on"
            )
    if solid:
        _check_apart(robots)
    for robot in robots:
        robot.company = tuple(robots)
        robot.others = tuple(other for other in robots if other is not robot) if solid else ()


def _check_apart(robots: Sequence[Body[BodySettings]]) -> None:
    for (number, one), (other_number, other) in combinations(enumerate(robots, 1), 2):
        apart = _apart_mm(one.disc(), other.disc())
        if apart < -TOUCH_MM:
            raise UsageError(
                f"simulated robots: robots {number} and {other_number} overlap at their starts, by {-apart:.0f} mm"
            )


def _apart_mm(one: Disc, other: Disc) -> float:
    """How far two discs are from one another; negative when they overlap."""
    return math.dist(one[:2], other[:2]) - one.radius_mm - other.radius_mm
