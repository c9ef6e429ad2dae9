"""A car as a turtle: it turns on the spot by a multi-point turn, and what the reckoning knows never adds up."""

from __future__ import annotations

import math
import random
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from tests.unit.robots.car.wires import corners
from turtlewire.errors import NotSupportedError, UsageError
from turtlewire.logo import Interpreter, ScreenTurtle
from turtlewire.robots.calibration import CarCalibration, SpeedCurve
from turtlewire.robots.car.turning import Turning
from turtlewire.robots.timed.reckoning import Motion
from turtlewire.turtle import HOME, Pose, wrapped

if TYPE_CHECKING:
    from tests.unit.robots.car.conftest import MakeBench

EXAMPLES = Path(__file__).parents[4] / "examples"


# ---------------------------------------------------------------- the multi-point turn


@pytest.mark.parametrize("angle", [0.5, 5, 37.5, 90, 120, 180, 359, 720, -1, -90, -179.5])
@pytest.mark.parametrize("space", [20.0, 150.0, 600.0])
@pytest.mark.parametrize("trim", [0.0, 3.0])
def test_a_turn_ends_where_it_began_within_its_space(angle: float, space: float, trim: float) -> None:
    calibration = CarCalibration(trim_deg=trim)
    pose, furthest = HOME, 0.0
    for arc in Turning(calibration, space).plan(angle):
        length = math.radians(arc.angle_deg) / calibration.curvature(arc.steer)
        assert math.copysign(1.0, length) == arc.direction
        for _ in range(20):
            pose = Motion(length / 20.0, arc.angle_deg / 20.0).after(pose, 1.0)
            furthest = max(furthest, HOME.distance_to(pose.x_mm, pose.y_mm))
    assert wrapped(pose.heading_deg - angle) == pytest.approx(0.0, abs=1e-6)
    assert HOME.distance_to(pose.x_mm, pose.y_mm) < 1e-6
    assert furthest <= space + 1e-6


def test_a_turn_takes_as_few_arcs_as_its_space_allows() -> None:
    assert len(Turning(CarCalibration(), 400.0).plan(90)) == 3
    assert len(Turning(CarCalibration(), 150.0).plan(90)) == 3
    assert len(Turning(CarCalibration(), 50.0).plan(90)) == 7
    assert len(Turning(CarCalibration(), 150.0).plan(360)) == 9


def test_a_space_too_small_to_turn_in_is_refused() -> None:
    with pytest.raises(UsageError, match="needs a radius of 301 mm"):
        Turning(CarCalibration(), 0.5)


def test_what_the_car_truly_does_in_a_turn(bench: MakeBench) -> None:
    made = bench({"pen_down": True}, turn_space_mm=60.0)
    made.turtle.right(90)
    made.turtle.finish()
    (stroke,) = made.robot.trace.strokes
    assert 35.0 < max(math.hypot(x, y) for x, y in stroke.points) <= 60.0
    assert made.robot.pose.heading_deg == pytest.approx(90.0, abs=0.01)
    assert made.off_mm < 0.05
    assert made.turtle.trace.strokes == []  # no turtle draws when it turns on the spot


# ---------------------------------------------------------------- the vocabulary


@pytest.mark.parametrize(
    ("robot", "calibration"),
    [
        ({}, {}),
        ({"trim_deg": 2.0}, {"trim_deg": 2.0}),
        (
            {"wheelbase_mm": 100.0, "max_lock_deg": 40.0},
            {"wheelbase_mm": 100.0, "lock_deg": 40.0, "steer_s": 0.3},
        ),
        (
            {"dead_pwm": 10, "mm_per_s_per_pwm": 1.0},
            {"forward": SpeedCurve(dead_pwm=10, table=((100, 90.0), (200, 190.0)))},
        ),
        ({"lag_s": 0.05}, {"settle_s": 0.5}),
        ({"steer_deg_per_s": 30.0}, {"steer_s": 2.0}),
        ({"baud": None}, {}),
    ],
)
def test_with_a_true_calibration_a_car_is_where_the_turtle_is(
    bench: MakeBench, robot: dict[str, Any], calibration: dict[str, Any]
) -> None:
    made = bench(robot, calibration=CarCalibration(**calibration))
    assert corners(made.turtle, made.robot) < 0.2
    assert made.turtle.pose == Pose(*made.turtle.pose[:2], 330.0)
    assert made.notes == []


@pytest.mark.parametrize("window", [1, 3])
@pytest.mark.parametrize("speed", [1, 30, 255])
def test_at_any_speed(bench: MakeBench, window: int, speed: int) -> None:
    made = bench(window=window)
    made.turtle.set_speed(speed)
    start = made.robot.now
    made.turtle.forward(10)
    made.turtle.right(10)
    made.turtle.back(5)
    assert made.off_mm < 0.05
    assert (made.robot.now - start > 5.0) == (speed == 1)


def test_a_wrong_calibration_shows(bench: MakeBench) -> None:
    made = bench(calibration=CarCalibration(forward=SpeedCurve(mm_per_s_per_pwm=2.0)))
    made.turtle.forward(100)
    assert made.robot.pose.y_mm == pytest.approx(125.0, abs=0.1)


def test_what_a_car_coasts_belongs_to_its_motion(bench: MakeBench) -> None:
    # It is told to stop 0.1 s early; this one does not coast.
    made = bench(calibration=CarCalibration(overrun_s=0.1))
    made.turtle.forward(200)
    speed = CarCalibration().forward.speed_mm_per_s(124)
    assert made.robot.pose.y_mm == pytest.approx(200.0 - 0.1 * speed, abs=0.1)
    assert made.turtle.reckoned_pose.y_mm == pytest.approx(200.0)


def test_backwards_may_be_another_curve(bench: MakeBench) -> None:
    made = bench(calibration=CarCalibration(backward=SpeedCurve(mm_per_s_per_pwm=5.0)))
    made.turtle.forward(100)
    made.turtle.back(100)
    assert made.robot.pose.y_mm == pytest.approx(50.0, abs=0.1)


def test_nothing_adds_up(bench: MakeBench) -> None:
    made = bench()
    for _ in range(72):
        made.turtle.forward(7.03)
        made.turtle.right(5)
    made.turtle.finish()
    assert made.turtle.pose.distance_to(0, 0) < 1e-6
    assert made.off_mm < 0.1


def test_turns_that_follow_one_another_are_one(bench: MakeBench) -> None:
    made = bench()
    made.wire.forget()
    made.turtle.right(30)
    made.turtle.left(30)
    made.turtle.finish()
    assert made.wire.bytes_sent == b""
    made.turtle.set_step_by_step(True)
    made.turtle.right(30)
    assert made.robot.pose.heading_deg == pytest.approx(30.0, abs=0.01)
    made.turtle.set_position(10, 10)
    assert made.robot.pose.heading_deg == pytest.approx(30.0, abs=0.01)
    made.turtle.right(360)
    assert made.robot.statistics.turned_deg > 360.0


def test_what_is_too_little_is_left_to_the_next_move(bench: MakeBench) -> None:
    made = bench()
    made.wire.forget()
    made.turtle.forward(0.04)
    made.turtle.forward(0)
    made.turtle.right(0.2)
    made.turtle.finish()
    assert made.wire.bytes_sent == b""
    made.turtle.forward(0.04)
    assert made.robot.pose.y_mm == pytest.approx(0.08, abs=0.01)
    assert made.robot.pose.heading_deg == 0.0
    made.turtle.right(0.2)
    made.turtle.finish()
    assert made.robot.pose.heading_deg == pytest.approx(0.4, abs=0.01)


def test_a_car_that_is_off_to_the_side_makes_it_good(bench: MakeBench) -> None:
    made = bench(tolerance_mm=0.5)
    account = made.turtle._robot.account
    account.place(Pose(3.0, 0.0, 0.0))
    made.turtle.forward(100)
    assert made.turtle.reckoned_pose[:2] == pytest.approx((0.0, 100.0), abs=0.1)


def test_going_back_takes_no_turn(bench: MakeBench) -> None:
    made = bench()
    made.turtle.back(50)
    made.turtle.set_position(0, -80)
    made.turtle.set_position(0, 20)
    assert made.robot.statistics.turned_deg == 0.0
    made.turtle.set_position(30, -80)  # behind, and a little aside
    assert made.robot.statistics.turned_deg == pytest.approx(math.degrees(math.atan(0.3)), abs=0.1)
    assert made.off_mm < 0.05


def test_a_stop_releases_the_steering_and_a_turn_sets_it_again(bench: MakeBench) -> None:
    made = bench()
    made.turtle.steer(255)
    made.turtle.stop()
    made.turtle.right(90)
    made.turtle.finish()
    assert made.robot.pose.heading_deg == pytest.approx(90.0, abs=0.01)
    assert made.off_mm < 0.05


def test_the_pen_is_on_the_trace_and_in_the_lights(bench: MakeBench) -> None:
    made = bench(pen_light=True)
    assert made.robot.lights == (False, True, False, True)
    made.turtle.forward(10)
    made.turtle.pen_up()
    assert not made.turtle.is_pen_down
    assert made.robot.lights == (False,) * 4
    made.turtle.forward(10)
    made.turtle.pen_down()
    made.turtle.right(90)
    made.turtle.forward(10)
    drawn = [(stroke.pen_down, stroke.points[-1]) for stroke in made.turtle.trace.strokes]
    assert [pen_down for pen_down, _ in drawn] == [True, False, True]
    assert drawn[-1][1] == pytest.approx((10.0, 20.0), abs=0.05)
    made.turtle.clear_screen()
    assert made.turtle.trace.strokes == []
    assert (made.turtle.pose, made.turtle.is_pen_down) == (HOME, True)
    assert made.off_mm < 0.1


def test_without_a_light_the_pen_costs_no_byte(bench: MakeBench) -> None:
    made = bench()
    made.wire.forget()
    made.turtle.pen_up()
    assert made.wire.bytes_sent == b""
    assert made.turtle.obstacles == ()
    assert made.turtle.towards(10, 0) == 90.0


def test_waiting_takes_the_cars_time(bench: MakeBench) -> None:
    made = bench()
    start = made.robot.now
    made.turtle.wait(2.5)
    assert made.robot.now == pytest.approx(start + 2.5)


# ---------------------------------------------------------------- in circles


def test_turning_in_circles_changes_the_place(bench: MakeBench) -> None:
    made = bench(turn="arc")
    made.turtle.forward(100)
    made.turtle.right(90)
    radius = made.turtle.turning_radius_mm
    assert made.turtle.pose == pytest.approx((radius, 100.0 + radius, 90.0), abs=0.01)
    assert made.robot.pose == pytest.approx(made.turtle.pose, abs=0.01)
    made.turtle.left(180)
    made.turtle.set_heading(0)
    made.turtle.forward(-20)
    made.turtle.finish()
    assert made.off_mm < 0.1
    assert made.robot.pose.heading_deg == pytest.approx(0.0, abs=0.01)
    (stroke,) = made.turtle.trace.strokes
    assert len(stroke.points) > 70  # the circles are drawn


def test_in_circles_a_car_cannot_get_everywhere_and_says_so(bench: MakeBench) -> None:
    made = bench(turn="arc")
    made.wire.forget()
    with pytest.raises(NotSupportedError, match="turn=arc"):
        made.turtle.set_position(10, 10)
    with pytest.raises(NotSupportedError, match="turn=arc"):
        made.turtle.home()
    with pytest.raises(NotSupportedError, match="turn=arc"):
        made.turtle.arc(90, 10)
    assert made.wire.bytes_sent == b""


# ---------------------------------------------------------------- whole pictures


@pytest.mark.parametrize("program", ["rose.logo"])
def test_a_picture_is_the_ideal_one(bench: MakeBench, program: str) -> None:
    # Wheels that are there at once: each of the many legs of a slow servo costs the simulator time.
    quick = {"steer_deg_per_s": math.inf}
    made, ideal = bench(quick, calibration=CarCalibration(steer_s=0.0)), ScreenTurtle()
    source = (EXAMPLES / program).read_text("utf-8")
    for turtle in (made.turtle, ideal):
        Interpreter(turtle, write=lambda _: None, random=random.Random(0)).run(source, program)
    made.turtle.finish()
    drawn, wanted = ([s for s in t.trace.strokes if s.pen_down] for t in (made.turtle, ideal))
    assert len(drawn) == len(wanted)
    for stroke, other in zip(drawn, wanted, strict=True):
        for point, corner in ((stroke.points[0], other.points[0]), (stroke.points[-1], other.points[-1])):
            assert math.dist(point, corner) < 0.1
    assert made.off_mm < 0.1
