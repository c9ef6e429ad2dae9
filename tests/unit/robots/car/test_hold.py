"""Motions of a car that are held for a time: what calibration measures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

import turtlewire
from turtlewire.errors import MessageError
from turtlewire.robots.calibration import CarCalibration
from turtlewire.turtle import HOME

if TYPE_CHECKING:
    from tests.unit.robots.car.conftest import MakeBench


def test_it_drives_for_as_long_as_it_is_told(bench: MakeBench) -> None:
    made = bench()
    made.turtle.hold(140, 0, 0.8)
    # (140 - 40) * 2.5 mm/s
    assert made.robot.pose == pytest.approx((0.0, 200.0, 0.0), abs=0.01)
    made.turtle.hold(-140, 0, 0.4)
    assert made.robot.pose == pytest.approx((0.0, 100.0, 0.0), abs=0.01)
    assert made.turtle.pose == pytest.approx(made.robot.pose, abs=0.01)
    assert not made.goes_on(1.0)


def test_what_a_calibration_says_of_coasting_changes_nothing(bench: MakeBench) -> None:
    made = bench(calibration=CarCalibration(overrun_s=0.3, trim_deg=5.0))
    made.turtle.hold(140, 0, 0.8)
    assert made.robot.pose == pytest.approx((0.0, 200.0, 0.0), abs=0.01)


def test_the_front_wheels_turn_before_it_drives(bench: MakeBench) -> None:
    made = bench(robot={"steer_deg_per_s": 60.0}, calibration=CarCalibration(steer_s=1.0))
    made.turtle.hold(140, 255, 1.0)
    radius = made.robot.settings.turning_radius_mm(255)
    assert made.robot.pose.distance_to(radius, 0.0) == pytest.approx(radius, abs=0.01)


@pytest.mark.parametrize("settle_s", [0.0, 0.3])
def test_how_long_to_wait_until_it_stands(bench: MakeBench, settle_s: float) -> None:
    made = bench()
    made.turtle.hold(140, 0, 0.5, settle_s)
    # To be told takes as long each time; a reply takes a byte, and cannot be waited for any less.
    passed = made.robot.now - (made.wire.sent[-1][0] + 7 * 10 / 9600)
    assert passed == pytest.approx(max(settle_s, 10 / 9600), abs=1e-6)


def test_wheels_turn_while_it_stands(bench: MakeBench) -> None:
    made = bench(robot={"steer_deg_per_s": 60.0})
    made.turtle.turn_wheels(255, 0.1)
    assert made.robot.wheels_deg == pytest.approx(6.0, abs=0.01)
    made.turtle.turn_wheels(-255, 2.0)
    assert made.robot.wheels_deg == -28.0
    assert made.robot.pose == HOME


@pytest.mark.parametrize(
    ("pwm", "steering", "seconds", "settle_s", "name"),
    [
        (256, 0, 1.0, None, "pwm"),
        (100, -300, 1.0, None, "steering"),
        (100, 0, 0.0, None, "seconds"),
        (100, 0, 61.0, None, "seconds"),
        (100, 0, 1.0, -1.0, "settle_s"),
    ],
)
def test_what_is_out_of_range_moves_nothing(
    bench: MakeBench, pwm: int, steering: int, seconds: float, settle_s: float | None, name: str
) -> None:
    made = bench()
    made.wire.forget()
    with pytest.raises(MessageError, match=f"^{name} is"):
        made.turtle.hold(pwm, steering, seconds, settle_s)
    with pytest.raises(MessageError):
        made.turtle.turn_wheels(steering or 256, seconds)
    assert made.wire.sent == []


def test_where_it_can_be_seen_its_trace_is_where_it_truly_went() -> None:
    with turtlewire.connect("sim:simple?trim_deg=3") as car:
        car.forward(200)
        car.right(90)
        car.finish()
        (stroke,) = car.trace.strokes
        assert stroke.pen_down
        # 3 degrees of the front wheels: a circle of 3 m.
        assert stroke.points[-1] == pytest.approx((6.54, 199.86), abs=0.01)
        car.pen_up()
        car.forward(50)
        assert [stroke.pen_down for stroke in car.trace.strokes] == [True, False]
        car.clean()
        car.pen_down()
        car.motor(140)
        car.wait(0.1)
        assert [stroke.pen_down for stroke in car.trace.strokes] == [True]
