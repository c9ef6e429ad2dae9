"""One world, many robots: they share its time and, unless they are to be ghosts, are in one another's way."""

from __future__ import annotations

import math
from itertools import combinations
from typing import TYPE_CHECKING

from turtlewire.errors import UsageError
from turtlewire.simulator.world import TOUCH_MM

if TYPE_CHECKING:
    from collections.abc import Sequence

    from turtlewire.simulator.body import Body
    from turtlewire.simulator.settings import BodySettings


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
        here, there = one.disc(), other.disc()
        apart = math.dist(here[:2], there[:2]) - here.radius_mm - there.radius_mm
        if apart < -TOUCH_MM:
            raise UsageError(
                f"simulated robots: robots {number} and {other_number} overlap at their starts, by {-apart:.0f} mm"
            )
