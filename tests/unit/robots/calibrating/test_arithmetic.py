"""The arithmetic of calibration, against arcs, lines and wheels that are known."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from turtlewire.errors import DataError
from turtlewire.robots.calibrating import arithmetic
from turtlewire.robots.calibrating.arithmetic import Timed, Way
from turtlewire.robots.calibration import CarCalibration, SpeedCurve
from turtlewire.simulator.chassis import Wheels, drive
from turtlewire.turtle import HOME


@pytest.mark.parametrize("backwards", [False, True])
@given(length=st.floats(50.0, 3000.0), turned_deg=st.floats(-300.0, 300.0))
def test_the_way_that_leads_to_a_place(backwards: bool, length: float, turned_deg: float) -> None:
    sign = -1.0 if backwards else 1.0
    turned = math.radians(turned_deg)
    end = drive(HOME, Wheels(sign * length + turned * 70.0, sign * length - turned * 70.0), 140.0)
    way = arithmetic.way(end.y_mm, end.x_mm, backwards=backwards)
    assert way.length_mm == pytest.approx(sign * length, rel=1e-6)
    assert way.turned_rad == pytest.approx(turned, abs=1e-6)
    assert way.curvature == pytest.approx(turned / (sign * length), abs=1e-9)


def test_ways_that_are_known() -> None:
    assert arithmetic.way(200.0, 0.0) == Way(200.0, 0.0)
    assert arithmetic.way(-200.0, 0.0, backwards=True) == pytest.approx((-200.0, 0.0))
    # A quarter of a circle of 100 mm to the right, and back to the left.
    assert arithmetic.way(100.0, 100.0) == pytest.approx((50.0 * math.pi, math.pi / 2.0))
    assert arithmetic.way(-100.0, -100.0, backwards=True) == pytest.approx((-50.0 * math.pi, math.pi / 2.0))
    # Half of one.
    assert arithmetic.way(0.0, 200.0).curvature == pytest.approx(0.01)


@given(
    rate=st.floats(1.0, 900.0),
    overrun=st.floats(-0.2, 0.2),
    short=st.floats(0.5, 1.0),
    long=st.floats(1.5, 8.0),
)
def test_the_rate_is_free_of_starting_and_stopping(
    rate: float, overrun: float, short: float, long: float
) -> None:
    timed = [Timed(seconds, rate * (seconds + overrun)) for seconds in (short, long)]
    found = arithmetic.rate_and_overrun(timed[0], timed[1])
    assert found == pytest.approx((rate, overrun), rel=1e-6, abs=1e-6)


def test_points_on_a_line_are_a_slope() -> None:
    curve = arithmetic.speed_curve(40, [(255, 538.0), (100, 149.0), (150, 277.0)])
    assert curve == SpeedCurve(dead_pwm=40, mm_per_s_per_pwm=2.504)


def test_points_on_no_line_are_a_table() -> None:
    points = [(100, 250.0), (150, 330.0), (255, 400.0)]
    curve = arithmetic.speed_curve(40, points)
    assert curve.table == tuple(points)
    assert [curve.speed_mm_per_s(pwm) for pwm, _ in points] == [250.0, 330.0, 400.0]
    with pytest.raises(DataError, match="points that grow"):
        arithmetic.speed_curve(40, [(100, 250.0), (150, 230.0), (255, 400.0)])


def test_where_a_line_comes_to_a_standstill() -> None:
    assert arithmetic.dead_band((100, 150.0), (200, 400.0)) == pytest.approx(40.0)


@given(wheelbase=st.floats(60.0, 400.0), lock=st.floats(5.0, 60.0), trim=st.floats(-4.0, 4.0))
def test_front_wheels_are_found_by_the_circles_they_drive(wheelbase: float, lock: float, trim: float) -> None:
    car = CarCalibration(wheelbase_mm=wheelbase, lock_deg=lock, trim_deg=trim)
    found = arithmetic.steering(
        wheelbase, [(steer, car.curvature(steer)) for steer in (-255, -60, 0, 200, 255)]
    )
    assert found[:2] == pytest.approx((lock, trim), abs=1e-6)
    assert found.off < 1e-9


def test_steering_of_another_kind_is_off() -> None:
    found = arithmetic.steering(
        160.0, [(-255, -1 / 300), (-128, -1 / 900), (0, 0.0), (128, 1 / 400), (255, 1 / 300)]
    )
    assert found.off > arithmetic.MODEL_PART


@given(track=st.floats(60.0, 400.0), left=st.floats(80.0, 120.0), right=st.floats(80.0, 120.0))
def test_the_track_by_how_it_drives_and_turns(track: float, left: float, right: float) -> None:
    def way(left_mm: float, right_mm: float) -> Way:
        return Way((left_mm + right_mm) / 2.0, (left_mm - right_mm) / track)

    ahead, back = (way(3.0 * left, 3.0 * right), 3.0), (way(-1.8 * left, -1.9 * right), 2.0)
    turned = (left + 0.95 * right) / track
    assert arithmetic.track(turned, ahead, back) == pytest.approx(track, rel=1e-6)
    wheels = arithmetic.wheels(ahead[0], 3.0, track)
    assert wheels == pytest.approx((left, right))


def test_four_digits() -> None:
    assert [arithmetic.rounded(x) for x in (1.23456, 12345.6, -0.00123456, 0.0)] == [
        1.235,
        12350.0,
        -0.001235,
        0.0,
    ]
