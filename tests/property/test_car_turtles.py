"""Any program of moves and turns: with a true calibration, what is driven by set-points is where the turtle is."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from turtlewire.links.memory import MemoryLink
from turtlewire.robots.calibration import CarCalibration, SpeedCurve
from turtlewire.robots.car import AsyncCar, Car
from turtlewire.robots.car import Settings as CarSettings
from turtlewire.robots.car.turning import Turning
from turtlewire.robots.runner import InlineRunner
from turtlewire.robots.timed.reckoning import Motion, Reckoning
from turtlewire.simulator.car import SimulatedCar
from turtlewire.turtle import HOME, wrapped

programs = st.lists(
    st.tuples(
        st.sampled_from(["forward", "right", "set_heading"]), st.floats(-200.0, 200.0, allow_nan=False)
    ),
    max_size=8,
)


@settings(max_examples=25, deadline=None)
@given(programs, st.integers(1, 255), st.floats(30.0, 300.0))
def test_a_car_is_where_the_turtle_is(program: list[tuple[str, float]], speed: int, space: float) -> None:
    robot, runner = SimulatedCar(), InlineRunner()
    driver = AsyncCar(MemoryLink(robot), CarSettings(speed=max(speed, 40), turn_space_mm=space))
    runner.run(driver.connect())
    with Car(driver, runner) as turtle:
        for name, value in program:
            getattr(turtle, name)(value)
            assert turtle.reckoned_pose.distance_to(*robot.pose[:2]) < 0.05
        turtle.finish()
        # Its tolerance to the side, and a turn that is not worth being made.
        assert turtle.pose.distance_to(*robot.pose[:2]) < 1.1
        assert abs(wrapped(turtle.pose.heading_deg - robot.pose.heading_deg)) < 0.26


@given(
    st.floats(-1080.0, 1080.0).filter(lambda a: abs(a) > 0.02), st.floats(5.0, 500.0), st.floats(-5.0, 5.0)
)
def test_a_multi_point_turn_keeps_the_place_and_its_space(angle: float, space: float, trim: float) -> None:
    calibration = CarCalibration(trim_deg=trim)
    pose, turned = HOME, 0.0
    for arc in Turning(calibration, space).plan(angle):
        length = math.radians(arc.angle_deg) / calibration.curvature(arc.steer)
        assert length * arc.direction > 0.0
        pose = Motion(length, arc.angle_deg).after(pose, 1.0)
        turned += arc.angle_deg
        assert HOME.distance_to(*pose[:2]) <= space + 1e-6
    assert abs(turned - angle) < 1e-6
    assert HOME.distance_to(*pose[:2]) < 1e-6


@given(
    st.lists(st.tuples(st.floats(-300.0, 300.0), st.floats(-300.0, 300.0), st.floats(0.0, 3.0)), max_size=20),
    st.lists(st.floats(-400.0, 400.0), max_size=10),
)
def test_what_is_owed_is_what_is_between_the_two_headings(
    motions: list[tuple[float, float, float]], turns: list[float]
) -> None:
    account, now = Reckoning(), 0.0
    for speed, turn, seconds in motions:
        account.begin(Motion(speed, turn), now)
        now += seconds
        account.end(now)
    for turn in turns:
        account.turn(turn)
    assert abs(wrapped(account.exact.heading_deg - account.robot.heading_deg - account.owed_deg)) < 1e-6
    account.settle()
    assert account.owed_deg == 0.0
    assert account.exact == account.robot


@given(
    st.lists(
        st.tuples(st.floats(-300.0, 300.0), st.sampled_from((0.0, 0.0, -30.0, 45.0)), st.floats(0.001, 3.0)),
        max_size=20,
    ),
    st.integers(0, 20),
)
def test_reckoning_does_not_depend_on_whether_anybody_looks(
    motions: list[tuple[float, float, float]], every: int
) -> None:
    looked, alone, now = Reckoning(), Reckoning(), 0.0
    for number, (speed, turn, seconds) in enumerate(motions):
        for account in (looked, alone):
            account.begin(Motion(speed, turn), now)
        if every and number % every == 0:
            assert looked.trace.pose == looked.robot
        now += seconds
    for account in (looked, alone):
        account.end(now)
    assert looked.robot == pytest.approx(alone.robot, abs=1e-6)
    assert looked.trace.pose == pytest.approx(alone.trace.pose, abs=1e-6)
    assert looked.distance_mm == alone.distance_mm
    assert looked.rolled_mm == alone.rolled_mm


@given(
    st.integers(0, 200),
    st.lists(st.tuples(st.integers(1, 20), st.floats(1.0, 100.0)), max_size=5),
    st.floats(0.0, 1000.0),
)
def test_a_curve_and_its_inverse_agree(dead_pwm: int, steps: list[tuple[int, float]], speed: float) -> None:
    table, pwm, top = [], dead_pwm, 0.0
    for more_pwm, faster in steps:
        pwm, top = pwm + more_pwm, top + faster
        if pwm <= 255:
            table.append((pwm, top))
    curve = SpeedCurve(dead_pwm=dead_pwm, table=tuple(table))
    found = curve.pwm(speed)
    off = abs(curve.speed_mm_per_s(found) - speed)
    if found > dead_pwm + 1 and speed:
        assert off <= abs(curve.speed_mm_per_s(found - 1) - speed) + 1e-6
    if 0 < found < 255:
        assert off <= abs(curve.speed_mm_per_s(found + 1) - speed) + 1e-6
