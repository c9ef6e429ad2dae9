"""W11: however long the program, the robot is never further from the exact turtle than one wire unit plus its last
move times sin 0.5 degrees."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from turtlewire.links.memory import MemoryLink
from turtlewire.robots.exact_pose import ExactPose, Move, Turn, is_gentle, wire_parts
from turtlewire.robots.frame import Frame
from turtlewire.robots.runner import InlineRunner
from turtlewire.robots.walter import AsyncWalter, Settings, Walter
from turtlewire.simulator.walter import Settings as RobotSettings
from turtlewire.simulator.walter import SimulatedWalter
from turtlewire.turtle import HOME, Pose, wrapped

UNIT_MM = 0.5
SIN_HALF_DEGREE = math.sin(math.radians(0.5))

sizes = st.one_of(
    st.floats(-1.0, 1.0), st.floats(-1000.0, 1000.0), st.floats(-20000.0, 20000.0), st.integers(-300, 300)
)
places = st.one_of(st.floats(-2.0, 2.0), st.floats(-2000.0, 2000.0), st.integers(-500, 500))
angles = st.one_of(st.floats(-2.0, 2.0), st.floats(-1000.0, 1000.0), st.sampled_from([90, -180, 720]))
steps = st.one_of(
    st.tuples(st.just("move"), sizes),
    st.tuples(st.just("turn"), angles),
    st.tuples(st.just("go_to"), places, places),
    st.tuples(st.just("set_heading"), angles),
)


def apart(pose: Pose, other: Pose) -> float:
    return pose.distance_to(other.x_mm, other.y_mm)


@settings(deadline=None)
@given(st.lists(steps, max_size=60))
def test_w11_the_error_depends_on_the_last_move_only(program: list[tuple[str, Any]]) -> None:
    position = ExactPose(UNIT_MM)
    robot, last_move_mm = HOME, 0.0
    for name, *arguments in program:
        for step in getattr(position, name)(*arguments):
            assert (step.angle_deg if isinstance(step, Turn) else step.units) != 0
            if isinstance(step, Move):
                last_move_mm = abs(step.units) * UNIT_MM
                robot = robot.moved(step.units * UNIT_MM)
            else:
                robot = robot.turned(step.angle_deg)
            assert apart(step.pose, robot) < 1e-6
        assert apart(position.robot, robot) < 1e-6
        assert robot.heading_deg == int(robot.heading_deg)
        assert apart(position.exact, robot) <= UNIT_MM + last_move_mm * SIN_HALF_DEGREE + 1e-6
        if name in ("turn", "set_heading"):
            assert abs(wrapped(robot.heading_deg - position.exact.heading_deg)) <= 0.5 + 1e-9
    position.align()
    assert abs(wrapped(position.robot.heading_deg - position.exact.heading_deg)) <= 0.5 + 1e-9


@given(st.integers(1, 5), st.floats(-0.4, 0.4))
def test_w11_whole_turns_are_made(turns: int, rest: float) -> None:
    position = ExactPose(UNIT_MM)
    (step,) = position.turn(360.0 * turns + rest)
    assert isinstance(step, Turn)
    assert step.angle_deg == 360 * turns


@given(st.floats(-180.0, 540.0), st.floats(-180.0, 540.0))
def test_set_heading_turns_the_shorter_way(one: float, other: float) -> None:
    position = ExactPose(UNIT_MM)
    position.set_heading(one)
    for step in position.set_heading(other):
        assert isinstance(step, Turn)
        assert abs(step.angle_deg) <= 180


@given(st.floats(-2000.0, 2000.0), st.floats(-2000.0, 2000.0), st.floats(0.0, 360.0))
def test_the_robot_drives_backwards_rather_than_turn_far(x_mm: float, y_mm: float, heading: float) -> None:
    position = ExactPose(UNIT_MM)
    position.set_heading(heading)
    for step in position.go_to(x_mm, y_mm):
        assert isinstance(step, Move) or abs(step.angle_deg) <= 90


def test_w11_the_issue_s_circle_closes() -> None:
    position = ExactPose(UNIT_MM)
    for _ in range(720):
        position.move(0.7)
        position.turn(0.5)
    assert apart(position.exact, HOME) < 1e-6
    assert apart(position.robot, position.exact) <= UNIT_MM + 1.0 * SIN_HALF_DEGREE


# ---------------------------------------------------------------- splitting (W5, W8, W12)


@given(st.integers(0, 0xFFFF * 40), st.booleans())
def test_w5_parts_add_up_and_fit_the_wire(value: int, gentle: bool) -> None:
    parts = wire_parts(value, gentle=gentle)
    assert sum(parts) == value
    assert all(0 <= part <= 0xFFFF for part in parts)
    assert all(part > 0 for part in parts) or value == 0
    assert len(parts) <= value // 0xF000 + 2


def test_w8_no_argument_byte_is_0d_or_0a_whatever_the_value() -> None:
    for value in range(0x10000):
        parts = wire_parts(value, gentle=True)
        assert sum(parts) == value
        assert len(parts) <= 2
        for part in parts:
            assert not set(part.to_bytes(2, "big")) & {0x0D, 0x0A}
            assert is_gentle(part)
        assert wire_parts(value, gentle=False) == [value]


# ---------------------------------------------------------------- frames


@given(
    st.builds(Pose, places, places, st.integers(0, 359)),
    st.builds(Pose, places, places, st.floats(0.0, 359.0)),
)
def test_a_frame_there_and_back(origin: Pose, pose: Pose) -> None:
    frame = Frame(origin)
    there = frame.to_robot(pose)
    back = frame.from_robot(there)
    assert apart(back, pose) < 1e-6
    assert abs(wrapped(back.heading_deg - pose.heading_deg)) < 1e-6
    assert apart(frame.to_robot(HOME), origin) < 1e-9
    # A frame keeps distances, and what is ahead stays ahead.
    assert apart(frame.to_robot(pose.moved(10.0)), there.moved(10.0)) < 1e-6


# ---------------------------------------------------------------- the whole driver and a robot (W10, W11)

FULL, BASIC = frozenset("CQHE"), frozenset[str]()
drawings = st.lists(
    st.one_of(
        st.tuples(st.just("forward"), st.one_of(st.floats(-2.0, 2.0), st.floats(-400.0, 400.0))),
        st.tuples(st.just("right"), angles),
        st.tuples(st.just("set_position"), places, places),
        st.tuples(st.just("set_x"), places),
        st.tuples(st.just("set_heading"), angles),
        st.tuples(st.just("home")),
        st.tuples(st.just("arc"), st.floats(-400.0, 400.0, width=16), st.floats(-30.0, 30.0, width=16)),
        st.tuples(st.just("pen_up")),
        st.tuples(st.just("pen_down")),
    ),
    max_size=12,
)
# What the robot was told to drive before the program began: its odometer is at (100.5, 27.5) then, looking down.
BEFORE = b"R\x00\x5a\rF\x00\xc9\rR\x00\x5a\rB\x00\x37\r"


@pytest.mark.parametrize(
    ("groups", "before"), [(FULL, b""), (FULL, BEFORE), (BASIC, b""), (frozenset("Q"), BEFORE)]
)
@settings(deadline=None, max_examples=60)
@given(program=drawings)
def test_w11_the_true_robot_stays_with_the_exact_turtle(
    groups: frozenset[str], before: bytes, program: list[tuple[Any, ...]]
) -> None:
    robot = SimulatedWalter(RobotSettings(groups=groups, baud=None, speed=255))
    robot.write(before)
    robot.read(math.inf)
    frame = Frame(robot.pose)
    driver = AsyncWalter(MemoryLink(robot), Settings(boot_s=0.0))
    runner = InlineRunner()
    turtle = Walter(driver, runner)
    runner.run(driver.connect())
    longest_mm = 0.0
    try:
        turtle.set_step_by_step(True)
        for name, *arguments in program:
            was = turtle.pose
            getattr(turtle, name)(*arguments)
            # The last move is at most the way from where the robot was; an arc's at most its diameter.
            way_mm = apart(was, turtle.pose)
            if name == "arc":
                longest_mm = max(longest_mm, 61.0)
            elif way_mm > UNIT_MM / 2:
                longest_mm = way_mm + 2.0 * UNIT_MM + longest_mm * SIN_HALF_DEGREE
            allowed = UNIT_MM + longest_mm * SIN_HALF_DEGREE + 1e-6
            assert apart(frame.to_robot(turtle.pose), robot.pose) <= allowed
        turtle.finish()
        turned = wrapped(frame.to_robot(turtle.pose).heading_deg - robot.pose.heading_deg)
        assert abs(turned) <= 0.5 + 1e-6
        assert turtle.statistics.corrections == 0
        assert robot.statistics.overflowed == 0
    finally:
        turtle.close(finish=False)


@pytest.mark.parametrize("groups", [FULL, BASIC])
def test_w11_the_issue_s_circle_closes_on_the_robot(groups: frozenset[str]) -> None:
    robot = SimulatedWalter(RobotSettings(groups=groups, baud=None))
    driver, runner = AsyncWalter(MemoryLink(robot), Settings(boot_s=0.0)), InlineRunner()
    runner.run(driver.connect())
    with Walter(driver, runner) as turtle:
        for _ in range(720):
            turtle.forward(0.7)
            turtle.right(0.5)
        turtle.finish()
        assert math.hypot(*turtle.pose[:2]) < 1e-6
        assert apart(robot.pose, turtle.pose) <= UNIT_MM + 1.0 * SIN_HALF_DEGREE
        assert wrapped(robot.pose.heading_deg) == 0.0
