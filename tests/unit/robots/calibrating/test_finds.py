"""What a calibration finds are the true values of the simulated robot, which are others than the defaults.

What it finds is compared by what it means (speeds, radii, times) rather than by its numbers.
"""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import turtlewire
from tests.unit.robots.calibrating.conftest import Bench, bench_of
from turtlewire.deviation import Followed, between
from turtlewire.logo import Interpreter
from turtlewire.robots.calibrating import SimulatedPerson, guide
from turtlewire.robots.calibration import CarCalibration, SpeedCurve, TwoEngineCalibration
from turtlewire.robots.car import Settings as CarSettings
from turtlewire.robots.two_engine import Settings as TwoEngineSettings
from turtlewire.robots.walter import Settings as WalterSettings

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tests.unit.robots.calibrating.conftest import MakeBench

EXACT, CLOSE = 0.003, 0.02
# A whole calibration takes a second: too long to look for the simplest one that fails.
PHASES = (Phase.explicit, Phase.reuse, Phase.generate)
ROUGH = "&slip=0.01&noise=1"
CAR = {
    "dead_pwm": 52,
    "mm_per_s_per_pwm": 2.1,
    "backward_factor": 0.8,
    "wheelbase_mm": 171.0,
    "max_lock_deg": 31.0,
    "trim_deg": -2.5,
    "lag_s": 0.05,
    "coast_s": 0.12,
    "steer_deg_per_s": 190.0,
}
ENGINES = {
    "dead_pwm": 41,
    "mm_per_s_per_pwm": 1.3,
    "right_factor": 1.07,
    "backward_factor": 0.9,
    "track_mm": 155.0,
    "lag_s": 0.06,
    "coast_s": 0.02,
    "left_engine": 1,
    "right_engine": 0,
    "right_reversed": "yes",
    "pen_servo": 1,
    "pen_up_deg": 20,
    "pen_down_deg": 110,
    "servo_deg_per_s": 250.0,
}
WALTER = {
    "mm_per_s_per_unit": 1.37,
    "deg_per_s_per_unit": 0.74,
    "distance_scale": 1.04,
    "turn_scale": 0.96,
}


def url(robot: str, values: Mapping[str, object]) -> str:
    return f"sim:{robot}?" + "&".join(f"{name}={value}" for name, value in values.items())


def check_car(made: Bench, found: Any, part: float) -> None:
    body, calibration = made.body.settings, found.calibration
    for pwm in (70, 120, 180, 255):
        for direction in (1, -1):
            speed = calibration.curve(direction).speed_mm_per_s(pwm)
            assert speed == pytest.approx(abs(body.curve.speed_mm_per_s(direction * pwm)), rel=part)
    assert calibration.forward.dead_pwm == body.dead_pwm
    full = 1.0 / body.turning_radius_mm(255)
    for steer in (-255, -100, 0, 100, 255):
        true = 1.0 / body.turning_radius_mm(steer)
        assert calibration.curvature(steer) == pytest.approx(true, abs=part * full)
    assert 1.0 / calibration.curvature(255) == pytest.approx(body.turning_radius_mm(255), rel=part)
    lock_s = 2.0 * body.max_lock_deg / body.steer_deg_per_s
    assert calibration.steer_s == pytest.approx(lock_s, rel=part, abs=0.011)


def check_engines(made: Bench, found: Any, part: float) -> None:
    body, calibration = made.body.settings, found.calibration
    for pwm in (70, 120, 180, 255):
        for direction in (1, -1):
            true = abs(body.curve.speed_mm_per_s(direction * pwm))
            assert calibration.left_curve(direction).speed_mm_per_s(pwm) == pytest.approx(
                true, rel=part, abs=0.5
            )  # mm/s: a crawl is hard to time
            right = calibration.right_curve(direction).speed_mm_per_s(pwm)
            assert right == pytest.approx(true * body.right_factor, rel=part, abs=0.5)
    # Half a millimetre in a second is not seen.
    unseen = math.ceil(0.6 / (body.mm_per_s_per_pwm * min(1.0, body.right_factor))) - 1
    for curve in (calibration.left, calibration.right):
        assert 0 <= curve.dead_pwm - body.dead_pwm <= max(unseen, 0)
    for name in ("left_engine", "right_engine", "left_reversed", "right_reversed", "pen_servo"):
        assert getattr(calibration, name) == getattr(body, name), name
    assert calibration.track_mm == pytest.approx(body.track_mm, rel=part)
    # Nobody can see more of a pen's angles than where it begins to touch.
    middle = (calibration.pen_up_deg + calibration.pen_down_deg) / 2.0
    assert middle == pytest.approx((body.pen_up_deg + body.pen_down_deg) / 2.0, abs=1.0)
    goes_up = body.pen_up_deg > body.pen_down_deg
    assert (calibration.pen_up_deg > calibration.pen_down_deg) == goes_up
    way_deg = abs(calibration.pen_up_deg - calibration.pen_down_deg)
    assert calibration.pen_s == pytest.approx(way_deg / body.servo_deg_per_s, abs=0.011)


def check_walter(made: Bench, found: Any, part: float) -> None:
    for name in WALTER:
        true = getattr(made.body.settings, name)
        assert getattr(found.settings, name) == pytest.approx(true, rel=part), name


CHECKS: dict[str, Any] = {"simple": check_car, "frame": check_engines, "walter": check_walter}
ROBOTS = [("simple", CAR), ("frame", ENGINES), ("walter", WALTER)]


@pytest.mark.parametrize(("robot", "values"), ROBOTS)
def test_an_exact_robot_is_found_exactly(bench: MakeBench, robot: str, values: dict[str, Any]) -> None:
    made = bench(url(robot, values))
    CHECKS[robot](made, made.calibrated(), EXACT)


@pytest.mark.parametrize(("robot", "values"), ROBOTS)
def test_what_was_calibrated_wrong_before_is_found_all_the_same(
    bench: MakeBench, robot: str, values: dict[str, Any]
) -> None:
    wrong = {
        "simple": CarSettings(
            calibration=CarCalibration(
                forward=SpeedCurve(dead_pwm=60, table=((90, 50.0), (255, 300.0))),
                backward=SpeedCurve(dead_pwm=20, mm_per_s_per_pwm=3.0),
                trim_deg=5.0,
                steering=((-255, -500.0), (0, 9000.0), (255, 300.0)),
                overrun_s=0.2,
                steer_s=0.9,
            )
        ),
        "frame": TwoEngineSettings(
            calibration=TwoEngineCalibration(
                left=SpeedCurve(dead_pwm=60, table=((90, 50.0), (255, 300.0))),
                right_backward=SpeedCurve(dead_pwm=20, mm_per_s_per_pwm=1.0),
                track_mm=120.0,
                pen_servo=None,
                overrun_s=-0.1,
            )
        ),
        "walter": WalterSettings(
            distance_scale=1.2, turn_scale=0.8, mm_per_s_per_unit=0.9, deg_per_s_per_unit=1.6
        ),
    }[robot]
    names = WALTER if robot == "walter" else ("calibration",)
    made = bench(url(robot, values), **{name: getattr(wrong, name) for name in names})
    assert getattr(made.settings, next(iter(names))) == getattr(wrong, next(iter(names)))
    CHECKS[robot](made, made.calibrated(), CLOSE)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(("robot", "values"), ROBOTS)
def test_wheels_that_slip_and_a_tape_that_is_held_badly(
    bench: MakeBench, robot: str, values: dict[str, Any], seed: int
) -> None:
    made = bench(url(robot, values) + f"{ROUGH}&seed={seed}")
    CHECKS[robot](made, made.calibrated(noise=1.0, seed=seed, repeats=3), CLOSE)


@pytest.mark.parametrize("robot", ["simple", "frame"])
@pytest.mark.parametrize(("lag_s", "coast_s"), [(0.05, 0.12), (0.1, 0.04), (0.0, 0.2)])
def test_what_starting_and_stopping_make_of_a_drive(
    bench: MakeBench, robot: str, lag_s: float, coast_s: float
) -> None:
    made = bench(url(robot, {"lag_s": lag_s, "coast_s": coast_s}))
    found: Any = made.calibrated("speed", "rest")
    assert found.calibration.overrun_s == pytest.approx(coast_s - lag_s, abs=0.003)
    # Its speed dies away exponentially; the last half millimetre of the way nobody sees.
    speed = found.calibration.full_mm_per_s if robot == "frame" else found.calibration.forward.full_mm_per_s
    rolls_s = coast_s * math.log(speed * 0.5 * coast_s / 0.5)
    assert found.calibration.settle_s == pytest.approx(rolls_s, abs=0.02)


@settings(max_examples=6, deadline=None, phases=PHASES, derandomize=True)
@given(
    dead=st.integers(0, 90),
    slope=st.floats(0.8, 4.0),
    wheelbase=st.floats(90.0, 300.0),
    lock=st.floats(15.0, 45.0),
    trim=st.floats(-4.0, 4.0),
    back=st.floats(0.6, 1.3),
)
def test_any_car(dead: int, slope: float, wheelbase: float, lock: float, trim: float, back: float) -> None:
    values = {"dead_pwm": dead, "mm_per_s_per_pwm": slope, "wheelbase_mm": wheelbase, "max_lock_deg": lock}
    found_of(url("simple", {**values, "trim_deg": trim, "backward_factor": back}), check_car)


@settings(max_examples=6, deadline=None, phases=PHASES, derandomize=True)
@given(
    dead=st.integers(0, 90),
    slope=st.floats(0.5, 3.0),
    right=st.floats(0.85, 1.15),
    back=st.floats(0.7, 1.2),
    track=st.floats(70.0, 250.0),
    down=st.integers(0, 80),
    way=st.integers(40, 100),
    is_swapped=st.booleans(),
)
def test_any_two_engine_robot(
    dead: int, slope: float, right: float, back: float, track: float, down: int, way: int, is_swapped: bool
) -> None:
    pen = (down, down + way) if is_swapped else (down + way, down)
    values = {"dead_pwm": dead, "mm_per_s_per_pwm": slope, "right_factor": right, "backward_factor": back}
    more = {"track_mm": track, "pen_up_deg": pen[0], "pen_down_deg": pen[1], "left_reversed": is_swapped}
    found_of(url("frame", {**values, **more}), check_engines)


@settings(max_examples=6, deadline=None, phases=PHASES, derandomize=True)
@given(
    st.floats(0.4, 3.0), st.floats(0.4, 3.0), st.floats(0.85, 1.2), st.floats(0.85, 1.2), st.integers(0, 99)
)
def test_any_walter(speed: float, rate: float, distance: float, turn: float, seed: int) -> None:
    values = dict(zip(WALTER, (speed, rate, distance, turn), strict=True))
    found_of(url("walter", {**values, "seed": seed}), check_walter)


def found_of(where: str, check: Any) -> None:
    made = bench_of(where)
    try:
        check(made, made.calibrated(repeats=1), CLOSE)
    finally:
        made.robot.close(finish=False)


def test_steering_of_another_kind_is_a_table(bench: MakeBench) -> None:
    made = bench("sim:simple")
    # Front wheels that turn much at once, and little towards the lock.
    made.body._rear.settings = Bent(made.body.settings)
    found: Any = made.calibrated("steering")
    assert len(found.calibration.steering) >= 4
    for steer in (-255, -127, 127, 255):
        true = 1.0 / made.body._rear.settings.turning_radius_mm(steer)
        assert found.calibration.curvature(steer) == pytest.approx(true, rel=CLOSE)


class Bent:
    """Settings of a car whose steering is not even."""

    def __init__(self, settings: Any) -> None:
        self._settings = settings

    def __getattr__(self, name: str) -> Any:
        return getattr(self._settings, name)

    def wheel_angle_deg(self, steer: float) -> float:
        part = abs(steer) / 255.0
        return math.copysign(28.0 * math.sqrt(part), steer)

    def turning_radius_mm(self, steer: float) -> float:
        return float(type(self._settings).turning_radius_mm(self, steer))


def test_a_motor_of_another_kind_is_a_table(bench: MakeBench) -> None:
    made = bench("sim:simple")
    made.body._rear.settings = Saturated(made.body.settings)
    found: Any = made.calibrated("speed", "dead_band", "backward")
    assert len(found.calibration.forward.table) == 3
    for pwm, _ in found.calibration.forward.table:
        true = Saturated.speed_mm_per_s(pwm)
        assert found.calibration.forward.speed_mm_per_s(pwm) == pytest.approx(true, rel=EXACT)
    assert found.calibration.forward.dead_pwm == 40
    assert found.calibration.backward is None  # it is the same


class Saturated(Bent):
    """Settings of a car whose motor gets no faster towards the end."""

    @property
    def curve(self) -> type[Saturated]:
        return Saturated

    def wheel_angle_deg(self, steer: float) -> float:
        return float(self._settings.wheel_angle_deg(steer))

    @staticmethod
    def speed_mm_per_s(pwm: float) -> float:
        return math.copysign(400.0 * math.pow(max(0.0, abs(pwm) - 40.0) / 215.0, 0.6), pwm)


@pytest.mark.parametrize(
    "values",
    [
        {"pen_up_deg": 30, "pen_down_deg": 90},  # the other way round
        {"pen_up_deg": 160, "pen_down_deg": 120},  # touches at both present angles
        {"pen_up_deg": 20, "pen_down_deg": 5},  # at neither
    ],
)
def test_a_pen_that_is_elsewhere(bench: MakeBench, values: dict[str, Any]) -> None:
    made = bench(url("frame", values))
    found: Any = made.calibrated("pen")
    made.robot.recalibrate(found.calibration)
    for is_down in (True, False, True):
        (made.robot.pen_down if is_down else made.robot.pen_up)()
        made.robot.wait(0.5)
        assert made.body.pen_is_down is is_down


def test_a_robot_without_a_pen(bench: MakeBench) -> None:
    made = bench("sim:frame")
    # Its pen has been taken off.
    object.__setattr__(made.body.settings, "pen_servo", None)
    found: Any = made.calibrated("pen")
    assert found.calibration.pen_servo is None
    assert found.lines()["calibration"]["pen_servo"] == "none"


def test_a_robot_that_keeps_its_speed_by_itself(bench: MakeBench) -> None:
    made = bench("sim:frame?dialect=telemetry&mm_per_s_per_pwm=1.2&track_mm=149&mm_per_tick=0.31&dead_pwm=20")
    found: Any = made.calibrated()
    calibration = found.calibration
    assert calibration.full_mm_per_s == pytest.approx(1.2 * 235.0, rel=EXACT)
    assert calibration.track_mm == pytest.approx(149.0, rel=EXACT)
    assert calibration.mm_per_tick == pytest.approx(0.31, rel=EXACT)
    assert not [name for name in found.found if "dead" in name or "engine" in name]


def test_a_robot_that_cannot_go_back(bench: MakeBench) -> None:
    made = bench("sim:frame?dialect=0.1-literal&mm_per_s_per_pwm=1.2")
    found: Any = made.calibrated("engines", "speed", "dead_band", "backward", "track")
    assert found.calibration.left.mm_per_s_per_pwm == pytest.approx(1.2, rel=EXACT)
    assert not [name for name in found.found if "back" in name or "track" in name]


@pytest.mark.parametrize("robot", ["simple", "frame"])
def test_no_drive_is_longer_than_there_is_space(bench: MakeBench, robot: str) -> None:
    """Also of a robot that is three times as fast as it is taken to be, or as slow."""
    for factor in (3.0, 1.0, 0.4):
        slope = factor * (2.5 if robot == "simple" else 1.6)
        made = bench(url(robot, {"mm_per_s_per_pwm": slope}))
        farthest = 0.0
        hold, progress = made.robot.hold, made.progress()

        def watched(*arguments: Any, made: Bench = made, hold: Any = hold) -> None:
            nonlocal farthest
            before = made.body.pose
            hold(*arguments)
            farthest = max(farthest, made.body.pose.distance_to(*before[:2]))

        made.robot.hold = watched
        guide(progress, SimulatedPerson(made.body))
        assert 300.0 < farthest < 1000.0, factor


PROGRAM = "REPEAT 4 [FD 120 RT 90 REPEAT 12 [FD 20 RT 30] PU FD 15 PD] BK 60 SETPOS [100 -100]"


@pytest.mark.parametrize(("robot", "values"), ROBOTS)
def test_what_was_found_makes_the_drawing_right(bench: MakeBench, robot: str, values: dict[str, Any]) -> None:
    # What a motor takes to start is made good on average only: short moves show it.
    values = {**values, "lag_s": 0.0, "coast_s": 0.0} if robot != "walter" else values
    made = bench(url(robot, values))
    found: Any = made.calibrated()
    before, after = drawn(url(robot, values), made.settings), drawn(url(robot, values), settings_of(found))
    assert before is None or before.largest > 20.0
    assert after is not None
    assert after.largest < 2.5
    assert after.mean < 0.6


def settings_of(found: Any) -> Any:
    if hasattr(found, "settings"):
        return found.settings
    kind = CarSettings if "steering" in found.STEPS else TwoEngineSettings
    return kind(calibration=found.calibration)


def drawn(where: str, driven_by: Any) -> Any:
    # A URL's own options count more: those that simulated robot and driver both have mean the robot.
    kinds = (WalterSettings, CarSettings, TwoEngineSettings)
    assert isinstance(driven_by, kinds)
    with turtlewire.connect(where, driven_by) as robot:
        turtle = Followed(robot)
        Interpreter(turtle, lambda _: None, random.Random(0)).run(PROGRAM)
        robot.finish()
        return between(robot.trace, turtle.ideal)
