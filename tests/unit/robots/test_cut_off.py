"""What a driver knows of the way of a robot that was stopped on it, and of wheels that are not exact."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

import turtlewire
from turtlewire.errors import LimitReachedError
from turtlewire.simulator.world import Wall, World

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.unit.robots.conftest import Bench
    from turtlewire.simulator.walter import SimulatedWalter
    from turtlewire.turtle import Pose, Turtle


def test_a_turtle_that_is_closed_midway_knows_its_way(
    bench: Callable[..., Bench], settle: Callable[[SimulatedWalter, float], Pose]
) -> None:
    at = bench()
    for _ in range(3):
        at.turtle.forward(30)
        at.turtle.right(90)
    robot, trace = at.robot, at.turtle._robot._wire.where.trace
    settle(robot, 2.0)
    at.turtle.close(finish=False)
    assert not robot.is_moving
    drawn = [point for stroke in robot.trace.strokes if stroke.pen_down for point in stroke.points]
    known = [point for stroke in trace.strokes if stroke.pen_down for point in stroke.points]
    assert len(drawn) >= 2
    assert len(known) == len(drawn)
    for (x1, y1), (x2, y2) in zip(drawn, known, strict=True):
        assert (x1, y1) == pytest.approx((x2, y2), abs=0.5)


def stairs(turtle: Turtle) -> None:
    for _ in range(2):
        turtle.forward(20)
        turtle.right(90)
        turtle.forward(200)
    turtle.finish()


def test_the_way_to_a_wall_keeps_its_corners(bench: Callable[..., Bench]) -> None:
    at = bench({"world": World((Wall(150.0, -500.0, 150.0, 500.0),))})
    with pytest.raises(LimitReachedError) as caught:
        stairs(at.turtle)
    assert (caught.value.x_mm, caught.value.y_mm) == pytest.approx((60.0, 20.0), abs=0.5)
    points = at.turtle._robot._wire.where.trace.strokes[0].points
    assert (0.0, 20.0) in points
    assert points[-1] == pytest.approx((60.0, 20.0), abs=0.5)


@pytest.mark.parametrize("seed", range(8))
def test_noisy_wheels_settle(seed: int) -> None:
    with turtlewire.connect(f"sim:walter?noise=2&seed={seed}", notify=lambda _: None) as robot:
        for side in (123, 101, 147, 130):
            robot.forward(side)
            robot.right(90)
        robot.finish()
        reported: Pose = robot.reported_pose()
        assert reported.distance_to(robot.pose.x_mm, robot.pose.y_mm) <= 2.5
