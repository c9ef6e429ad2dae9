from __future__ import annotations

import math
from typing import Any

import pytest

from turtlewire.errors import UsageError
from turtlewire.simulator.walter import Settings, SimulatedWalter
from turtlewire.simulator.world import Wall, World
from turtlewire.turtle import Pose


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("baud", -1),
        ("groups", frozenset("X")),
        ("slip", -0.01),
        ("slip", 1.0),
        ("noise", -1.0),
        ("noise", math.nan),
        ("mm_per_s_per_unit", 0.0),
        ("deg_per_s_per_unit", math.inf),
        ("speed", 256),
        ("speed", -1),
        ("pen_s", -0.1),
        ("boot_s", math.inf),
        ("radius_mm", 0.0),
        ("track_mm", -140.0),
        ("watchdog_s", 0.0),
        ("start", Pose(math.nan, 0.0, 0.0)),
    ],
)
def test_a_value_that_makes_no_robot_is_named(name: str, value: object) -> None:
    settings: dict[str, Any] = {name: value}
    with pytest.raises(UsageError, match=f"{name} is .*but must be"):
        Settings(**settings)


def test_the_bounds_themselves_are_fine() -> None:
    Settings(
        baud=0, groups=frozenset(), slip=0.0, noise=0.0, speed=255, pen_s=0.0, boot_s=0.0, watchdog_s=0.1
    )
    Settings(baud=None, speed=0)


def test_a_robot_must_fit_where_it_starts() -> None:
    world = World((Wall(-100.0, 89.0, 100.0, 89.0),))
    with pytest.raises(UsageError, match=r"\(radius 90 mm\) does not fit at its start, x 0 mm, y 0 mm"):
        Settings(world=world)
    assert Settings(world=world, radius_mm=89.0).radius_mm == 89.0
    assert Settings(world=world, start=Pose(0.0, -1.0, 0.0)).start == Pose(0.0, -1.0, 0.0)


def test_the_world_says_where_the_robot_starts_unless_the_settings_do() -> None:
    world = World(start=Pose(5.0, 6.0, 7.0))
    assert SimulatedWalter(Settings(world=world)).pose == Pose(5.0, 6.0, 7.0)
    robot = SimulatedWalter(Settings(world=world, start=Pose(1.0, 2.0, 363.0)))
    assert robot.pose == Pose(1.0, 2.0, 3.0)
    assert robot.trace.start == Pose(1.0, 2.0, 3.0)
    assert robot.odometer == Pose(0.0, 0.0, 0.0)
