"""Motions of a two-engine robot that are held for a time, and another calibration meanwhile."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import pytest

from turtlewire.errors import MessageError, NotSupportedError, UsageError
from turtlewire.protocols.frame.dialect import shipped
from turtlewire.robots.calibration import SpeedCurve, TwoEngineCalibration

if TYPE_CHECKING:
    from tests.unit.robots.two_engine.conftest import MakeBench
    from turtlewire.simulator.frame_robot import Action


def test_it_drives_for_as_long_as_it_is_told(bench: MakeBench) -> None:
    made = bench(calibration=TwoEngineCalibration(overrun_s=0.3))
    made.turtle.hold(130, 130, 0.5)
    # (130 - 30) * 1.6 mm/s
    assert made.robot.pose == pytest.approx((0.0, 80.0, 0.0), abs=0.01)
    made.turtle.hold(-130, 130, 0.5)
    # 80 mm of each wheel, 140 mm apart
    assert made.robot.pose.heading_deg == pytest.approx(360.0 - 65.48, abs=0.01)
    assert not made.goes_on(1.0)


def test_afterwards_the_turtle_is_where_the_robot_is(bench: MakeBench) -> None:
    made = bench()
    made.turtle.hold(130, 90, 0.5)
    assert made.turtle.pose == pytest.approx(made.robot.pose, abs=0.01)
    made.turtle.set_position(0.0, 0.0)
    assert made.off_mm < 0.1


@pytest.mark.parametrize("dialect", ["0.1", "telemetry"])
@pytest.mark.parametrize("settle_s", [0.0, 0.3])
def test_how_long_to_wait_until_it_stands(bench: MakeBench, settle_s: float, dialect: str) -> None:
    made = bench(dialect=dialect)
    log: list[Action] = []
    made.robot.events = log.append
    made.turtle.hold(130, 130, 0.5, settle_s)
    ended_s = next(action.time_s for action in log if action.what.endswith(("speed=0", "right_mm_per_s=0")))
    # That is sent twice; at 115200 baud it takes a millisecond.
    assert settle_s - 1e-6 < made.robot.now - ended_s < settle_s + 0.002


@pytest.mark.parametrize(
    "values", [(256, 0, 1.0), (0, -256, 1.0), (9, 9, 0.0), (9, 9, 61.0), (9, 9, 1.0, 61.0)]
)
def test_what_is_out_of_range_moves_nothing(bench: MakeBench, values: tuple[int, ...]) -> None:
    made = bench()
    made.wire.forget()
    with pytest.raises(MessageError):
        made.turtle.hold(*values)
    assert made.wire.sent == []


def test_where_it_cannot_be_told_backward(bench: MakeBench) -> None:
    made = bench(dialect="0.1-literal")
    assert not made.turtle.goes_backward
    with pytest.raises(NotSupportedError):
        made.turtle.hold(-9, 9, 1.0)
    assert bench().turtle.goes_backward


def test_from_now_on_by_another_calibration(bench: MakeBench) -> None:
    made = bench(robot={"left_engine": 1, "right_engine": 0, "left_reversed": True})
    made.turtle.hold(130, 0, 0.5)
    assert made.robot.wheels_mm == pytest.approx((0.0, 80.0), abs=0.01)
    right = TwoEngineCalibration(left_engine=1, right_engine=0, left_reversed=True, track_mm=140.0)
    made.turtle.recalibrate(right)
    made.turtle.hold(130, 0, 0.5)
    assert made.robot.wheels_mm == pytest.approx((80.0, 80.0), abs=0.01)
    with pytest.raises(UsageError, match="left_engine is 7"):
        made.turtle.recalibrate(msgspec.structs.replace(right, left_engine=7))
    made.turtle.hold(130, 130, 0.5)
    assert made.robot.wheels_mm == pytest.approx((160.0, 160.0), abs=0.01)


def test_a_reverse_of_its_own(bench: MakeBench) -> None:
    slow = SpeedCurve(dead_pwm=30, mm_per_s_per_pwm=1.2)
    made = bench(
        robot={"backward_factor": 0.75},
        calibration=TwoEngineCalibration(left_backward=slow, right_backward=slow),
    )
    for command in (
        made.turtle.forward,
        made.turtle.back,
        made.turtle.right,
        made.turtle.back,
        made.turtle.left,
    ):
        command(90)
    made.turtle.finish()
    assert made.off_mm < 0.1
    made.turtle.drive(-0.5, 0.0)
    made.goes_on(1.0)
    made.turtle.stop()
    made.goes_on(0.1)
    assert made.off_mm < 1.0


def test_ticks(bench: MakeBench) -> None:
    assert bench().turtle.ticks is None
    made = bench(dialect="telemetry", robot={"mm_per_tick": 0.25, "dialect": shipped("telemetry")})
    made.goes_on(0.5)
    assert made.turtle.ticks == (0, 0)
    made.turtle.hold(160, -160, 0.5)  # mm/s, in this dialect
    made.goes_on(0.5)
    assert made.turtle.ticks == pytest.approx((320, -320), abs=1)
