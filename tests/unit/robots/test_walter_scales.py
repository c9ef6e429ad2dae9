"""A WALTER that goes further, or turns more, than it believes: its host knows (calibration; W10, W11, W15)."""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import turtlewire
from turtlewire.errors import LimitReachedError, MessageError, UsageError
from turtlewire.protocols.walter.messages import StartForward
from turtlewire.robots.exact_pose import ExactPose, Move, Turn
from turtlewire.robots.frame import Frame
from turtlewire.robots.walter import Settings
from turtlewire.robots.walter.whereabouts import Target, Whereabouts
from turtlewire.simulator.world import Wall, World
from turtlewire.turtle import HOME, Pose, wrapped

if TYPE_CHECKING:
    from tests.unit.robots.conftest import Bench, MakeBench

SCALES = {"distance_scale": 1.04, "turn_scale": 0.97}
angles = st.floats(-720.0, 720.0)
poses = st.builds(Pose, st.floats(-900, 900), st.floats(-900, 900), st.floats(0.0, 359.0))


def scribble(made: Bench, count: int, seed: int = 1) -> None:
    chance = random.Random(seed)
    for _ in range(count):
        made.turtle.right(chance.uniform(-170.0, 170.0))
        made.turtle.forward(chance.uniform(5.0, 60.0))
    made.turtle.finish()


@given(poses, poses, st.floats(0.5, 2.0), poses)
def test_a_frame_between_two_names_of_a_pose(pose: Pose, robot: Pose, scale: float, other: Pose) -> None:
    frame = Frame.matching(pose, robot, scale)
    assert frame.to_robot(pose)[:2] == pytest.approx(robot[:2], abs=1e-6)
    assert wrapped(frame.to_robot(pose).heading_deg - robot.heading_deg) == pytest.approx(0.0, abs=1e-9)
    back = frame.from_robot(frame.to_robot(other))
    assert back[:2] == pytest.approx(other[:2], abs=1e-6)
    apart = frame.to_robot(pose).distance_to(*frame.to_robot(other)[:2])
    assert apart * scale == pytest.approx(pose.distance_to(*other[:2]), abs=1e-6)


@settings(deadline=None)
@given(st.lists(st.tuples(st.floats(-500.0, 500.0), angles), max_size=30), st.sampled_from([0.97, 1.0, 1.05]))
def test_the_error_depends_on_the_last_move_only(program: list[tuple[float, float]], scale: float) -> None:
    position, robot, last_mm = ExactPose(0.5 * scale, scale), HOME, 0.0
    for distance, angle in program:
        for step in [*position.move(distance), *position.turn(angle)]:
            if isinstance(step, Move):
                last_mm = abs(step.units) * 0.5 * scale
                robot = robot.moved(step.units * 0.5 * scale)
            else:
                assert isinstance(step, Turn)
                robot = robot.turned(step.angle_deg * scale)
            assert step.pose.distance_to(*robot[:2]) < 1e-6
        off_mm = position.exact.distance_to(*robot[:2])
        assert off_mm <= 0.5 * scale + last_mm * math.sin(math.radians(0.5 * scale)) + 1e-6
        off_deg = abs(wrapped(position.exact.heading_deg - robot.heading_deg))
        assert off_deg <= 0.5 * scale + 1e-9


@pytest.mark.parametrize("groups", ["CQHE", "Q", ""])
@pytest.mark.parametrize("scales", [SCALES, {"distance_scale": 0.9}, {"turn_scale": 1.02}])
def test_it_gets_where_the_turtle_is(bench: MakeBench, groups: str, scales: dict[str, float]) -> None:
    made = bench(robot={**scales, "groups": frozenset(groups)}, reply_timeout_s=0.1, boot_s=0.0, **scales)
    scribble(made, 40)
    assert made.error_mm < 2.0
    made.turtle.set_position(-120.0, 77.0)
    made.turtle.set_heading(33.0)
    made.turtle.finish()
    assert made.error_mm < 3.0
    assert wrapped(made.robot.pose.heading_deg - 33.0) == pytest.approx(0.0, abs=1.0)
    made.turtle.home()
    made.turtle.finish()
    assert made.error_mm < 3.0
    assert made.turtle.statistics.corrections == 0
    assert not [note for note in made.notes if "answers no queries" not in note]


def test_without_them_it_does_not(bench: MakeBench) -> None:
    made = bench(robot=SCALES)
    scribble(made, 40)
    assert made.error_mm > 10.0
    assert made.turtle.statistics.corrections == 0  # it believes that all is well


def test_what_it_reports_is_the_turtles_pose(bench: MakeBench) -> None:
    made = bench(robot=SCALES, **SCALES)
    scribble(made, 7)
    reported = made.turtle.reported_pose()
    assert reported.distance_to(*made.robot.pose[:2]) < 0.5
    assert wrapped(reported.heading_deg - made.robot.pose.heading_deg) == pytest.approx(0.0, abs=0.01)


def test_a_stop_on_the_way(bench: MakeBench) -> None:
    for seconds in (0.4, 1.1, 1.9, 2.6):
        made = bench(robot=SCALES, **SCALES)
        made.turtle.forward(100.0)
        made.turtle.right(120.0)
        made.turtle.forward(100.0)
        made.turtle.right(90.0)
        wire, end = made.wire, made.robot.now + seconds
        while wire.now < end:
            wire.read(end)
        made.turtle.stop()
        made.turtle.right(10.0)
        made.turtle.finish()
        assert made.error_mm < 1.0, seconds
        turned = wrapped(made.robot.pose.heading_deg - made.turtle.pose.heading_deg)
        assert abs(turned) < 1.1, seconds


def test_a_limit_says_where(bench: MakeBench) -> None:
    world = World((Wall(-1000.0, 400.0, 1000.0, 400.0),))
    made = bench(robot={**SCALES, "world": world}, **SCALES)
    made.turtle.right(-360.0)
    made.turtle.right(10.0)
    made.turtle.left(10.0)
    made.turtle.set_step_by_step(True)
    with pytest.raises(LimitReachedError) as caught:
        made.turtle.forward(1000.0)
    # The disc of 90 mm touches at 310.
    assert caught.value.y_mm == pytest.approx(310.0, abs=5.0)
    assert made.error_mm < 1.0


def test_turns_that_got_lost_are_made_again(bench: MakeBench) -> None:
    def lose(wire: Any) -> None:
        lost = iter([6, 11, 17])
        at, count = next(lost), 0

        def swallow(data: bytes) -> bytes:
            nonlocal at, count
            count += 1
            if count < 20 or count != at + 20:
                return data
            at = next(lost, -1)
            return b""

        wire.to_robot = swallow

    made = bench(robot=SCALES, prepare=lose, **SCALES)
    scribble(made, 30)
    assert made.turtle.statistics.corrections > 0
    assert made.error_mm < 3.0


def test_where_it_gets_by_hand(bench: MakeBench) -> None:
    made = bench(robot=SCALES, **SCALES)
    scribble(made, 5)
    made.turtle.hold(100, 2.0)
    made.turtle.hold(200, 2.5, turning=True)  # more than a whole turn
    made.turtle.forward(10.0)
    made.turtle.finish()
    assert made.error_mm < 2.0
    assert abs(wrapped(made.robot.pose.heading_deg - made.turtle.pose.heading_deg)) < 1.1
    scribble(made, 5)
    assert made.error_mm < 3.0


def test_what_is_uncertain_is_told_by_what_each_command_leads_to() -> None:
    where = Whereabouts(1.0, 0.5)
    for told, pose in ((90, Pose(0.0, 0.0, 45.0)), (90, Pose(0.0, 0.0, 90.0))):
        where.turning(pose, told)
        where.lost((where.target(pose, pen_down=True),))
    where.position.robot = Pose(0.0, 0.0, 90.0)
    # It says that it has turned once: the second turn got lost.
    again, _ = where.resolve(Pose(0.0, 0.0, 90.0))
    assert [target.pose.heading_deg for target in again] == [90.0]
    assert where.position.robot.heading_deg == 45.0
    assert where.frame.to_robot(Pose(0.0, 0.0, 45.0)).heading_deg == pytest.approx(90.0)
    assert isinstance(again[0], Target)


@pytest.mark.parametrize("name", ["distance_scale", "turn_scale"])
@pytest.mark.parametrize("value", [0.0, -1.0, 11.0, math.nan])
def test_scales_that_are_none(name: str, value: float) -> None:
    scales: Any = {name: value}
    with pytest.raises(UsageError, match=f"{name} is"):
        Settings(**scales).checked()
    with pytest.raises(UsageError, match=name):
        turtlewire.connect(f"sim:walter?{name}=0")


def test_motions_that_are_held_for_a_time(bench: MakeBench) -> None:
    made = bench(robot={"mm_per_s_per_unit": 1.3, "deg_per_s_per_unit": 0.9})
    made.turtle.hold(100, 1.5)
    assert made.robot.pose == pytest.approx((0.0, 195.0, 0.0), abs=0.2)
    made.turtle.hold(100, 1.0, turning=True)
    assert made.robot.pose.heading_deg == pytest.approx(90.0, abs=0.2)
    made.turtle.hold(-50, 1.0)
    assert made.robot.pose[:2] == pytest.approx((-65.0, 195.0), abs=0.5)
    assert not made.robot.is_moving
    made.turtle.hold(-100, 1.0, turning=True)
    made.turtle.forward(10.0)
    made.turtle.finish()
    assert made.error_mm < 1.0


@pytest.mark.parametrize(("speed", "seconds"), [(0, 1.0), (256, 1.0), (-256, 1.0), (100, 0.0), (100, 61.0)])
def test_what_cannot_be_held(bench: MakeBench, speed: int, seconds: float) -> None:
    made = bench()
    made.wire.forget()
    with pytest.raises(MessageError):
        made.turtle.hold(speed, seconds)
    assert StartForward.LETTERS not in made.wire.bytes_sent
