"""Calibration is data: checked, read from TOML, and turned into numbers for the wire and back."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest

from turtlewire.errors import DataError
from turtlewire.robots.calibration import (
    Calibration,
    CarCalibration,
    SpeedCurve,
    TwoEngineCalibration,
    parse,
    read,
)

if TYPE_CHECKING:
    from pathlib import Path

TABLE = SpeedCurve(dead_pwm=38, table=((60, 35.0), (120, 140.0)))


@pytest.mark.parametrize("curve", [SpeedCurve(), TABLE, SpeedCurve(dead_pwm=0, table=((255, 400.0),))])
def test_every_pwm_is_the_nearest_to_its_own_speed(curve: SpeedCurve) -> None:
    speeds = [curve.speed_mm_per_s(pwm) for pwm in range(256)]
    assert speeds[: curve.dead_pwm + 1] == [0.0] * (curve.dead_pwm + 1)
    for pwm in range(curve.dead_pwm + 1, 256):
        assert speeds[pwm] > speeds[pwm - 1]
        assert curve.pwm(speeds[pwm]) == pwm
    assert curve.pwm(0.0) == 0
    assert curve.pwm(1e-9) == curve.dead_pwm + 1
    assert curve.pwm(1e9) == 255
    assert curve.full_mm_per_s == speeds[255]


def test_a_table_is_followed_and_goes_on_beyond_its_end() -> None:
    assert TABLE.speed_mm_per_s(60) == 35.0
    assert TABLE.speed_mm_per_s(90) == pytest.approx(87.5)
    assert TABLE.speed_mm_per_s(49) == pytest.approx(17.5)
    assert TABLE.speed_mm_per_s(255) == pytest.approx(140.0 + 135 * 1.75)


def test_parts_of_the_driving_range_begin_beyond_the_dead_band() -> None:
    assert [SpeedCurve().portion(part) for part in (0.0, 1e-6, 0.5, 1.0)] == [0, 41, 148, 255]


def test_steering_by_geometry() -> None:
    car = CarCalibration()
    assert car.straight == 0
    assert 1.0 / car.curvature(255) == pytest.approx(160.0 / math.tan(math.radians(28.0)))
    assert car.curvature(-100) == -car.curvature(100)
    crooked = CarCalibration(trim_deg=2.0)
    assert crooked.straight == -18
    assert crooked.turning_radius_mm == pytest.approx(160.0 / math.tan(math.radians(26.0)))


def test_steering_by_measured_points() -> None:
    car = CarCalibration(steering=((-255, -300.0), (-10, -4000.0), (10, math.inf), (255, 250.0)))
    assert car.straight == 10
    assert car.turning_radius_mm == pytest.approx(300.0)
    assert 1.0 / car.curvature(-255) == pytest.approx(-300.0)
    assert 1.0 / car.curvature(-10) == pytest.approx(-4000.0)
    assert car.curvature(0) == pytest.approx(-1.0 / 8000.0)
    assert car.curvature(132) == pytest.approx(122 / 245 / 250.0)


def test_backwards_is_as_forward_unless_it_is_told() -> None:
    assert CarCalibration().curve(-1.0) == SpeedCurve()
    back = SpeedCurve(dead_pwm=50)
    assert CarCalibration(backward=back).curve(-1.0) == back
    assert CarCalibration(backward=back).curve(1.0) == SpeedCurve()


def test_a_calibration_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(
        "track_mm = 152\npen_down_deg = 25\nright_reversed = true\n"
        "[left]\ndead_pwm = 38\ntable = [[60, 35.0], [120, 140]]\n",
        "utf-8",
    )
    found = read(TwoEngineCalibration, path)
    assert found == TwoEngineCalibration(track_mm=152.0, pen_down_deg=25, right_reversed=True, left=TABLE)


@pytest.mark.parametrize(
    ("kind", "text", "complaint"),
    [
        (TwoEngineCalibration, "track_mm = -1", "track_mm is -1.0, but must be above 0"),
        (TwoEngineCalibration, "track_mm = 'x'", "track_mm"),
        (TwoEngineCalibration, "mm_per_tick = 0", "mm_per_tick"),
        (TwoEngineCalibration, "left_engine = 256", "left_engine"),
        (TwoEngineCalibration, "left_engine = 1", "another than the left one"),
        (TwoEngineCalibration, "pen_servo = -1", "pen_servo"),
        (TwoEngineCalibration, "pen_up_deg = 181", "pen_up_deg"),
        (TwoEngineCalibration, "pen_s = -1", "from 0 to 60 seconds"),
        (TwoEngineCalibration, "overrun_s = 2", "overrun_s"),
        (TwoEngineCalibration, "wheels = 3", "unknown field `wheels`"),
        (TwoEngineCalibration, "[left]\ndead_pwm = 255", "dead_pwm is 255"),
        (TwoEngineCalibration, "[left]\nmm_per_s_per_pwm = inf", "mm_per_s_per_pwm"),
        (TwoEngineCalibration, "[left]\ntable = [[60, 3.0], [50, 9.0]]", "points that grow"),
        (TwoEngineCalibration, "[left]\ntable = [[256, 3.0]]", "points that grow"),
        (CarCalibration, "wheelbase_mm = 0", "wheelbase_mm"),
        (CarCalibration, "lock_deg = 81", "lock_deg"),
        (CarCalibration, "trim_deg = 28", "less than the lock"),
        (CarCalibration, "overrun_s = -1.1", "overrun_s"),
        (CarCalibration, "settle_s = 61", "settle_s"),
        (CarCalibration, "steering = [[-255, -300.0], [256, 300.0]]", "-255..255"),
        (CarCalibration, "steering = [[-255, -300.0], [255, 0.0]]", "no radius is 0"),
        (CarCalibration, "steering = [[-255, -300.0], [255, -400.0], [0, 1.0]]", "in order"),
        (CarCalibration, "steering = [[1, 300.0], [255, 200.0]]", "to both sides"),
        (CarCalibration, "wheelbase_mm =", "Invalid value"),
    ],
)
def test_what_makes_no_robot_is_refused(kind: type[Calibration], text: str, complaint: str) -> None:
    with pytest.raises(DataError, match=r"robot\.toml") as caught:
        parse(kind, text, "robot.toml")
    assert complaint in str(caught.value)


def test_a_program_is_refused_it_too() -> None:
    with pytest.raises(DataError, match="SpeedCurve: dead_pwm is 300"):
        SpeedCurve(dead_pwm=300)


def test_a_file_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="No such file"):
        read(CarCalibration, tmp_path / "none.toml")
    (tmp_path / "latin.toml").write_bytes(b"# \xe5")
    with pytest.raises(DataError, match="not UTF-8"):
        read(CarCalibration, tmp_path / "latin.toml")
