"""How many robots can be simulated: robot-seconds for each second of one core, and how much faster than real time.

A mixed crowd (cars, two-engine robots, WALTERs) among 4 walls around it and 40 obstacles, half of the robots getting
new set-points ten times a second. Both kernels where both make sense: only their ratio in one run counts.
"""

from __future__ import annotations

import math
import os
import random
import time
from typing import TYPE_CHECKING

from turtlewire.errors import UsageError
from turtlewire.simulator.car import CarSettings
from turtlewire.simulator.fleet import ArrayFleet
from turtlewire.simulator.frame_robot import FrameRobotSettings
from turtlewire.simulator.scalar_fleet import MANY, ScalarFleet
from turtlewire.simulator.settings import Settings
from turtlewire.simulator.world import Disc, Wall, World
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from turtlewire.simulator.scalar_fleet import AnySettings, Fleet

COUNTS = (1, 20, 100, 1_000, 10_000)
HALF_MM = 10_000.0
OBSTACLES = 40
STEPS_PER_COMMAND = 10  # of 10 ms
SCALAR_AT_MOST = 1_000


def world(chance: random.Random) -> World:
    """A hall of 20 m by 20 m with 20 walls and 20 pillars."""

    def place() -> tuple[float, float]:
        return chance.uniform(-HALF_MM, HALF_MM), chance.uniform(-HALF_MM, HALF_MM)

    corners = [(-HALF_MM, -HALF_MM), (HALF_MM, -HALF_MM), (HALF_MM, HALF_MM), (-HALF_MM, HALF_MM)]
    walls = [Wall(*one, *other) for one, other in zip(corners, corners[1:] + corners[:1], strict=True)]
    for _ in range(OBSTACLES // 2):
        (x, y), angle, length = place(), chance.uniform(0.0, math.tau), chance.uniform(300.0, 3000.0)
        walls.append(Wall(x, y, x + length * math.cos(angle), y + length * math.sin(angle)))
    pillars = tuple(Disc(*place(), chance.uniform(50.0, 400.0)) for _ in range(OBSTACLES // 2))
    return World(tuple(walls), discs=pillars)


def crowd(count: int, around: World, chance: random.Random) -> list[AnySettings]:
    """So many robots of the three kinds, where there is room."""
    kinds: tuple[Callable[[Pose], AnySettings], ...] = (
        lambda start: CarSettings(world=around, start=start, lag_s=0.1),
        lambda start: FrameRobotSettings(world=around, start=start, lag_s=0.1),
        lambda start: Settings(world=around, start=start),
    )
    robots: list[AnySettings] = []
    while len(robots) < count:
        side = HALF_MM - 300.0
        start = Pose(chance.uniform(-side, side), chance.uniform(-side, side), chance.uniform(0.0, 360.0))
        try:
            robots.append(kinds[len(robots) % len(kinds)](start))
        except UsageError:
            continue  # in a wall
    return robots


def rate(fleet: Fleet, count: int, chance: random.Random, budget_s: float = 2.0) -> float:
    """Robot-seconds for each second of one core."""

    def told() -> Sequence[float]:
        return [chance.uniform(-255.0, 255.0) for _ in range(count)]

    first, second = list(told()), list(told())
    fleet.set_points(first, second)
    fleet.step()
    steps, used_s = 0, 0.0
    while used_s < budget_s:
        for i in range(0, count, 2):
            first[i], second[i] = chance.uniform(-255.0, 255.0), chance.uniform(-255.0, 255.0)
        begun_s = time.process_time()
        fleet.set_points(first, second)
        fleet.step(STEPS_PER_COMMAND)
        used_s += time.process_time() - begun_s
        steps += STEPS_PER_COMMAND
    return count * steps * 0.01 / used_s


def main() -> None:
    """Print the table."""
    chance = random.Random(1)
    around = world(chance)
    print(f"simulator: {OBSTACLES} obstacles, steps of 10 ms; robot-seconds per second of one core")
    print(f"{'robots':>7} {'scalar':>10} {'NumPy':>10} {'NumPy/scalar':>13} {'x real time':>12}")
    for count in COUNTS:
        robots = crowd(count, around, chance)
        scalar = rate(ScalarFleet(robots), count, chance) if count <= SCALAR_AT_MOST else math.nan
        array = rate(ArrayFleet(robots), count, chance)
        chosen = scalar if count <= MANY else array
        shown = [f"{value:10,.0f}" if value == value else f"{'-':>10}" for value in (scalar, array)]
        ratio = f"{array / scalar:13.2f}" if scalar == scalar else f"{'-':>13}"
        print(f"{count:7,} {shown[0]} {shown[1]} {ratio} {chosen / count:12.2f}")


if __name__ == "__main__":
    # One core: NumPy's own threads would not be counted as one.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    main()
