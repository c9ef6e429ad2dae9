"""A car over its wire: what it answers and when, and where it gets (PROTOCOLS S1 to S6; section 4)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import pytest

from turtlewire.errors import UsageError
from turtlewire.simulator.car import Action, CarSettings, SimulatedCar
from turtlewire.simulator.world import Disc, Wall, World
from turtlewire.turtle import HOME, Pose

Run = Callable[..., bytes]
BYTE_S = 10 / 9600
# Speed (255 - 55) * 2 = 400 mm/s; wheels at 45 degrees: a circle of 100 mm.
PLAIN: dict[str, Any] = {
    "baud": None,
    "dead_pwm": 55,
    "mm_per_s_per_pwm": 2.0,
    "wheelbase_mm": 100.0,
    "max_lock_deg": 45.0,
    "steer_deg_per_s": math.inf,
    "radius_mm": 90.0,
}
AHEAD = World((Wall(-1000.0, 500.0, 1000.0, 500.0),))


def car(**settings: Any) -> SimulatedCar:
    return SimulatedCar(CarSettings(**{**PLAIN, **settings}))


def log_of(robot: SimulatedCar) -> list[Action]:
    log: list[Action] = []
    robot.events = log.append
    return log


# The line


def test_each_seven_bytes_are_answered_at_the_pace_of_the_line() -> None:
    robot = SimulatedCar()
    robot.write(b"F100000X999999")
    assert robot.read(1.0) == b"K"
    assert robot.now == pytest.approx(8 * BYTE_S)
    assert robot.drive == 100
    assert robot.read(1.0) == b"F"
    assert robot.now == pytest.approx(15 * BYTE_S)
    assert robot.read(1.0) == b""
    assert robot.statistics[:5] == (1, 14, 2, 0, 1)


def test_drive_and_steering_hold_and_a_stop_releases_both_but_not_the_lights(run: Run) -> None:
    robot = car()
    assert run(robot, b"B100000L255000H1010--") == b"KKK"
    assert (robot.drive, robot.steer, robot.lights) == (-100, -255, (True, False, True, False))
    assert robot.speed_mm_per_s == -90.0
    assert run(robot, b"S------") == b"K"
    assert (robot.drive, robot.steer, robot.lights) == (0, 0, (True, False, True, False))
    assert not robot.is_moving
    assert robot.speed_mm_per_s == 0.0


def test_what_an_invalid_command_does_not_change(run: Run) -> None:
    robot = car()
    assert run(robot, b"F255000F256000f000000", 1.0) == b"KFF"
    assert robot.drive == 255
    assert robot.pose == pytest.approx(Pose(0.0, 400.0, 0.0))


def test_bytes_that_arrive_during_the_boot_are_lost(run: Run) -> None:
    robot = car(boot_s=0.5)
    assert run(robot, b"F255000", 0.4) == b""
    assert run(robot, b"F255000", 0.2) == b""
    robot = car(boot_s=0.5)
    run(robot, b"", 0.5)
    assert run(robot, b"F255000", 0.2) == b"K"


# Driving


def test_it_drives_straight_at_the_speed_of_its_curve(run: Run) -> None:
    robot = car(start=Pose(10.0, 20.0, 90.0))
    run(robot, b"F155000", 3.0)
    assert robot.pose == pytest.approx(Pose(610.0, 20.0, 90.0))
    assert robot.odometer == pytest.approx(Pose(0.0, 600.0, 0.0))
    assert robot.wheels_mm == pytest.approx((600.0, 600.0))
    assert robot.next_event() == math.inf
    assert robot.is_moving


def test_within_the_dead_band_it_stands(run: Run) -> None:
    robot = car()
    assert run(robot, b"F055000", 3.0) == b"K"
    assert robot.pose == HOME
    assert not robot.is_moving


@pytest.mark.parametrize(("steer", "side"), [(b"R255000", 1.0), (b"L255000", -1.0)])
def test_the_rear_axle_goes_in_a_circle_about_a_point_on_its_line(
    run: Run, steer: bytes, side: float
) -> None:
    robot = car()
    assert robot.settings.turning_radius_mm(255 * side) == pytest.approx(side * 100.0)
    quarter_s = 100.0 * math.pi / 2.0 / 400.0
    run(robot, steer + b"F255000", quarter_s)
    assert robot.pose == pytest.approx(Pose(side * 100.0, 100.0, (side * 90.0) % 360.0), abs=1e-6)
    run(robot, b"", quarter_s)
    assert robot.pose == pytest.approx(Pose(side * 200.0, 0.0, 180.0), abs=1e-6)
    outer = 100.0 + robot.settings.track_mm / 2.0
    assert max(robot.wheels_mm) == pytest.approx(outer * math.pi)


def test_backwards_with_wheels_to_the_right_turns_counter_clockwise(run: Run) -> None:
    robot = car()
    run(robot, b"R255000B255000", 100.0 * math.pi / 2.0 / 400.0)
    assert robot.pose == pytest.approx(Pose(100.0, -100.0, 270.0), abs=1e-6)


def test_half_the_steering_is_half_the_angle() -> None:
    settings = CarSettings(**{**PLAIN, "max_lock_deg": 51.0, "trim_deg": 2.0})
    assert settings.wheel_angle_deg(0) == 2.0
    assert settings.wheel_angle_deg(-255) == -49.0
    assert settings.wheel_angle_deg(25) == pytest.approx(7.0)
    assert settings.turning_radius_mm(-10) == math.inf


def test_a_car_out_of_true_does_not_go_straight(run: Run) -> None:
    robot = car(trim_deg=3.0)
    run(robot, b"F255000", 1.0)
    assert robot.pose.heading_deg == pytest.approx(math.degrees(400.0 * math.tan(math.radians(3.0)) / 100.0))


def test_the_motor_lags(run: Run) -> None:
    robot = car(lag_s=0.5)
    run(robot, b"F255000", 1.0)
    expected = 400.0 * (1.0 - 0.5 * (1.0 - math.exp(-2.0)))
    assert robot.pose.y_mm == pytest.approx(expected, abs=1e-6)
    run(robot, b"S000000", 20.0)
    # What it had of speed runs out: 0.5 s times its speed at the stop.
    assert robot.pose.y_mm == pytest.approx(expected + 400.0 * (1.0 - math.exp(-2.0)) * 0.5, abs=0.01)
    assert not robot.is_moving
    assert robot.next_event() == math.inf


def test_backwards_it_may_be_slower(run: Run) -> None:
    robot = car(backward_factor=0.5)
    run(robot, b"B255000", 1.0)
    assert robot.pose.y_mm == pytest.approx(-200.0)


def test_it_may_coast_longer_than_it_takes_to_start(run: Run) -> None:
    robot = car(lag_s=0.1, coast_s=0.4)
    run(robot, b"F255000", 2.0)
    run(robot, b"F000000", 9.0)
    assert robot.pose.y_mm == pytest.approx(400.0 * (2.0 + 0.3), abs=0.1)


def test_its_way_can_be_followed(run: Run) -> None:
    robot = car()
    robot.follow(pen_down=True)
    run(robot, b"F255000", 0.5)
    run(robot, b"F000000")
    assert robot.wheels_deg == 0.0
    robot.follow(pen_down=None)
    run(robot, b"R255000F255000", 0.25)
    assert robot.wheels_deg == 45.0
    assert [stroke.pen_down for stroke in robot.trace.strokes] == [True]
    assert robot.trace.strokes[0].points[-1] == pytest.approx((0.0, 200.0))
    robot.follow(pen_down=None)
    robot.follow(pen_down=False)
    run(robot, b"S000000F255000", 0.1)
    (drawn, went) = robot.trace.strokes
    assert not went.pen_down
    # What was not followed is a straight line to where it is followed again.
    assert went.points[0] == drawn.points[-1]
    assert went.points[1][0] > 10.0
    robot.follow(pen_down=None)
    robot.clear_trace()
    assert robot.trace.strokes == []
    assert robot.trace.pose == robot.pose


def test_the_front_wheels_take_their_time(run: Run) -> None:
    robot = car(steer_deg_per_s=90.0)
    run(robot, b"F255000R255000", 0.5)
    # The heading is the integral of tan(90 t) * 400 / 100: -ln cos(45 degrees) / (pi / 2) * 4.
    expected = math.degrees(4.0 * -math.log(math.cos(math.radians(45.0))) / (math.pi / 2.0))
    assert robot.pose.heading_deg == pytest.approx(expected, abs=0.01)
    robot = car(steer_deg_per_s=90.0)
    run(robot, b"R255000", 0.5)  # standing, it steers too
    run(robot, b"F255000", 100.0 * math.pi / 2.0 / 400.0)
    assert robot.pose == pytest.approx(Pose(100.0, 100.0, 90.0), abs=1e-6)


def test_the_battery_sags(run: Run) -> None:
    robot = car(sag=0.5, battery_s=10.0)
    run(robot, b"F255000", 10.0)
    assert robot.pose.y_mm == pytest.approx(400.0 * 7.5, rel=1e-3)
    before = robot.pose.y_mm
    run(robot, b"", 1.0)
    assert robot.pose.y_mm - before == pytest.approx(200.0, rel=1e-3)


def test_slip_and_noise_are_reproducible_and_differ_by_seed(run: Run) -> None:
    def end(**settings: Any) -> tuple[Pose, Pose]:
        robot = car(**settings)
        run(robot, b"F255000", 5.5)
        return robot.pose, robot.odometer

    assert end(slip=0.1, seed=1) == end(slip=0.1, seed=1)
    assert end(slip=0.1, seed=1) != end(slip=0.1, seed=2)
    slipped, measured = end(slip=0.1, seed=1)
    assert measured == pytest.approx(Pose(0.0, 2200.0, 0.0))
    assert 1980.0 < math.hypot(*slipped[:2]) < 2200.0
    noisy, felt = end(noise=3.0, seed=1)
    assert noisy == pytest.approx(felt)
    assert noisy != pytest.approx(Pose(0.0, 2200.0, 0.0), abs=0.1)


def test_the_odometer_keeps_no_grip_of_the_last_second(run: Run) -> None:
    robot = car(slip=0.3, seed=4)
    parts = []
    for _ in range(4):
        before = robot.pose
        run(robot, b"F255000", 1.0)
        parts.append(math.dist(before[:2], robot.pose[:2]))
    assert len({round(part, 1) for part in parts}) == 4


# Walls


def test_a_wall_stops_it_where_its_disc_touches_and_it_stands_until_driven_away(run: Run) -> None:
    robot = car(world=AHEAD)
    log = log_of(robot)
    run(robot, b"F255000", 5.0)
    # The disc of 90 mm is 50 mm ahead of the rear axle.
    assert robot.pose == pytest.approx(Pose(0.0, 360.0, 0.0), abs=1e-6)
    assert robot.bumper == "front"
    (bump,) = (action for action in log if action.what.startswith("bumped"))
    assert bump.what == "bumped front"
    assert bump.time_s == pytest.approx(0.9)
    assert robot.is_moving  # its wheels spin
    assert robot.next_event() == math.inf
    assert robot.odometer.y_mm == pytest.approx(2000.0)
    run(robot, b"R255000", 1.0)
    assert robot.pose.y_mm == pytest.approx(360.0, abs=1e-6)
    run(robot, b"S000000", 1.0)
    assert str(robot.bumper) == "front"
    run(robot, b"B255000", 0.5)
    assert robot.pose == pytest.approx(Pose(0.0, 160.0, 0.0), abs=1e-6)
    assert str(robot.bumper) == "None"
    assert robot.statistics.bumps == 1


def test_a_post_beside_the_way_is_met_by_the_side(run: Run) -> None:
    robot = car(world=World(discs=(Disc(100.0, 700.0, 20.0),)))
    run(robot, b"F255000", 5.0)
    aside = math.degrees(math.asin(100.0 / 110.0))
    assert robot.pose.y_mm + 50.0 == pytest.approx(700.0 - 110.0 * math.cos(math.radians(aside)), abs=1e-6)
    assert robot.bumper == "right"
    assert car(world=World(discs=(Disc(0.0, 200.0, 20.0),))).pose == HOME


def test_it_drives_along_a_wall_freely(run: Run) -> None:
    robot = car(world=World((Wall(90.0, -1000.0, 90.0, 5000.0),)))
    run(robot, b"F255000", 5.0)
    assert robot.pose == pytest.approx(Pose(0.0, 2000.0, 0.0))
    assert robot.statistics.bumps == 0


def test_it_must_fit_where_its_disc_is(run: Run) -> None:
    with pytest.raises(UsageError, match="does not fit"):
        car(world=World((Wall(-100.0, 130.0, 100.0, 130.0),)))
    car(world=World((Wall(-100.0, -50.0, 100.0, -50.0),)))


# Watchdog, trace and time


def test_the_watchdog_stops_it_unless_it_is_fed(run: Run) -> None:
    robot = car(watchdog_s=0.5)
    log = log_of(robot)
    run(robot, b"F255000", 0.4)
    run(robot, b"F255000", 0.4)
    assert robot.drive == 255
    run(robot, b"F2550", 1.0)  # nothing valid
    assert (robot.drive, robot.statistics.watchdog_stops) == (0, 1)
    assert robot.pose.y_mm == pytest.approx(0.9 * 400.0)
    assert log[-1].what == "watchdog"
    assert log[-1].time_s == pytest.approx(0.9)
    run(robot, b"", 5.0)
    assert robot.statistics.watchdog_stops == 1


def test_a_watchdog_releases_the_steering_too(run: Run) -> None:
    robot = car(watchdog_s=0.5)
    run(robot, b"R100000", 1.0)
    assert robot.steer == 0


def test_the_trace_is_its_way(run: Run) -> None:
    robot = car(pen_down=True)
    run(robot, b"F255000", 0.5)
    (first,) = robot.trace.strokes
    assert first.pen_down
    assert first.points == [(0.0, 0.0), pytest.approx((0.0, 200.0))]
    assert robot.trace.pose == robot.pose
    run(robot, b"F155000", 0.5)
    run(robot, b"R255000", 0.1)
    (stroke,) = robot.trace.strokes
    assert stroke.points[1] == pytest.approx((0.0, 300.0))  # one line for what is straight
    assert len(stroke.points) > 3
    assert stroke.points[-1] == robot.pose[:2]
    robot.clear_trace()
    assert robot.trace.strokes == []
    before = robot.pose
    run(robot, b"", 0.1)
    assert robot.trace.strokes[0].points[0] == before[:2]
    assert not car().trace.strokes


def test_an_arc_that_is_over_stays_drawn(run: Run) -> None:
    robot = car(pen_down=True)
    run(robot, b"R255000F255000", 100.0 * math.pi / 400.0)
    run(robot, b"S000000", 1.0)
    (stroke,) = robot.trace.strokes
    for x_mm, y_mm in stroke.points:
        assert math.dist((x_mm, y_mm), (100.0, 0.0)) == pytest.approx(100.0, abs=1e-6)
    assert len(stroke.points) > 50


def test_a_new_sheet_in_one_arc_leaves_the_next_one_whole(run: Run) -> None:
    robot = car(pen_down=True)
    run(robot, b"R255000F255000", 0.1)
    robot.clear_trace()
    run(robot, b"L255000", 0.05)
    (stroke,) = robot.trace.strokes
    length = sum(math.dist(one, other) for one, other in itertools.pairwise(stroke.points))
    assert length == pytest.approx(20.0, rel=0.01)


def test_reading_for_ever_ends_where_only_driving_on_is_left(run: Run) -> None:
    robot = car(lag_s=0.1)
    robot.write(b"F255000")
    assert robot.read(math.inf) == b"K"
    assert robot.read(math.inf) == b""
    assert 0.5 < robot.now < 2.0  # until its speed stays as it is
    assert robot.read(math.inf) == b""


def test_the_watchdog_is_waited_for(run: Run) -> None:
    robot = car(watchdog_s=3.0)
    robot.write(b"F255000")
    robot.read(math.inf)
    assert robot.read(math.inf) == b""
    assert robot.now == 3.0
    assert not robot.is_moving


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("dead_pwm", 255),
        ("dead_pwm", -1),
        ("mm_per_s_per_pwm", 0.0),
        ("lag_s", -0.1),
        ("coast_s", -0.1),
        ("backward_factor", 0.0),
        ("wheelbase_mm", 0.0),
        ("max_lock_deg", 0.0),
        ("max_lock_deg", 81.0),
        ("trim_deg", 45.0),
        ("steer_deg_per_s", 0.0),
        ("sag", 1.0),
        ("battery_s", 0.0),
        ("slip", 1.0),
    ],
)
def test_a_value_that_makes_no_car_is_named(name: str, value: float) -> None:
    with pytest.raises(UsageError, match=f"{name} is .*but must be"):
        car(**{name: value})
