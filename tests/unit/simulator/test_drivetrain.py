from __future__ import annotations

import math

import pytest

from turtlewire.simulator.drivetrain import Battery, Motor, Servo, SpeedCurve


@pytest.mark.parametrize(
    ("pwm", "speed"), [(0, 0.0), (40, 0.0), (-40, 0.0), (41, 2.5), (-41, -2.5), (255, 537.5), (-255, -537.5)]
)
def test_a_motor_turns_beyond_its_dead_band(pwm: int, speed: float) -> None:
    assert SpeedCurve(40, 2.5).speed_mm_per_s(pwm) == speed


def test_backwards_a_motor_may_be_slower() -> None:
    curve = SpeedCurve(40, 2.5, 0.8)
    assert [curve.speed_mm_per_s(pwm) for pwm in (140, -140, -40)] == [250.0, -200.0, 0.0]


def test_a_motor_may_coast_longer_than_it_takes_to_start() -> None:
    motor, way = Motor(0.1, 0.3), 0.0
    for target, seconds in ((100.0, 2.0), (0.0, 9.0)):
        motor.set_target(target)
        way += motor.mean(seconds) * seconds
        motor.advance(seconds)
    # 2 s less what it lost at the start, and what it rolled on at the end.
    assert way == pytest.approx(100.0 * (2.0 - 0.1 + 0.3), abs=1e-3)
    at_once = Motor(0.5, 0.0)
    at_once.set_target(100.0)
    at_once.advance(9.0)
    at_once.set_target(0.0)
    assert at_once.speed == 0.0


def test_without_lag_a_motor_has_its_speed_at_once() -> None:
    motor = Motor()
    motor.set_target(100.0)
    assert motor.is_settled
    assert motor.speed == motor.mean(0.5) == 100.0


def test_a_motor_that_lags_has_changed_by_63_percent_after_its_time_constant() -> None:
    motor = Motor(0.2)
    motor.set_target(100.0)
    # The mean is the integral: 0.2 s of exponential.
    assert motor.mean(0.2) == pytest.approx(100.0 * math.exp(-1.0))
    motor.advance(0.2)
    assert motor.speed == pytest.approx(100.0 * (1.0 - math.exp(-1.0)))
    assert motor.speed != motor.target
    motor.advance(0.2 * 10.0)
    assert motor.is_settled
    assert motor.speed == 100.0


def test_the_way_of_a_motor_does_not_depend_on_how_time_is_cut() -> None:
    whole, cut = Motor(0.3), Motor(0.3)
    for motor in (whole, cut):
        motor.set_target(-200.0)
    way = 0.0
    for seconds in (0.1, 0.05, 0.35):
        way += cut.mean(seconds) * seconds
        cut.advance(seconds)
    assert way == pytest.approx(whole.mean(0.5) * 0.5)


def test_a_servo_turns_evenly_and_stops_where_it_was_told_to() -> None:
    servo = Servo(100.0, 90.0)
    servo.set_target(60.0)
    assert servo.needs_s == pytest.approx(0.3)
    assert servo.at(0.1) == 80.0
    assert servo.at(0.3) == servo.at(9.0) == 60.0
    assert servo.mean(0.2) == pytest.approx(80.0)
    assert servo.mean(0.6) == pytest.approx(67.5)  # 0.3 s at 75 on average, 0.3 s at 60
    servo.advance(0.1)
    assert servo.angle == 80.0
    assert servo.angle != servo.target
    servo.advance(0.5)
    assert servo.is_settled
    assert servo.mean(1.0) == 60.0


def test_a_servo_without_a_rate_is_there_at_once() -> None:
    servo = Servo()
    servo.set_target(-20.0)
    assert servo.is_settled
    assert servo.angle == servo.mean(0.1) == -20.0


def test_a_battery_gets_weaker_with_what_is_drawn_until_it_is_empty() -> None:
    battery = Battery(0.2, 100.0)
    assert battery.draw(1.0, 0.0) == 1.0
    assert battery.draw(0.5, 25.0) == pytest.approx(0.95)
    assert battery.level(75.0) == pytest.approx(0.9)
    assert battery.draw(0.0, 75.0) == pytest.approx(0.9)
    assert battery.draw(1.0, 1000.0) == pytest.approx(0.9)
    assert battery.level(2000.0) == pytest.approx(0.8)
