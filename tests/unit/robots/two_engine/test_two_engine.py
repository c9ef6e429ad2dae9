"""A two-engine robot by its own commands, by hand, as a turtle, and on every way out (decisions F4..F13)."""

from __future__ import annotations

import asyncio
import gc
import itertools
import math
import random
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from tests.unit.robots.car.wires import corners, pass_time
from turtlewire.drive import Drive
from turtlewire.errors import (
    LimitReachedError,
    LinkClosedError,
    LinkLostError,
    MessageError,
    NotSupportedError,
    PoseUncertainError,
    StoppedError,
    UsageError,
)
from turtlewire.links.faults import Faults, FaultyLink
from turtlewire.links.memory import MemoryLink
from turtlewire.links.stream import open_port
from turtlewire.logo import Interpreter, ScreenTurtle
from turtlewire.protocols.catalogue import codec
from turtlewire.protocols.frame.codec import Frame, FrameDecoder
from turtlewire.protocols.frame.dialect import TO_ROBOT, read_dialect, shipped
from turtlewire.protocols.frame.messages import EngineBackward, EngineForward, SetServoPosition
from turtlewire.robots.calibration import SpeedCurve, TwoEngineCalibration
from turtlewire.robots.runner import InlineRunner
from turtlewire.robots.two_engine import AsyncTwoEngine, Settings, TwoEngine
from turtlewire.robots.two_engine.odometry import Odometer
from turtlewire.robots.two_engine.wheels import wheels
from turtlewire.simulator.frame_robot import FrameRobotSettings, SimulatedFrameRobot
from turtlewire.simulator.server import serve
from turtlewire.simulator.world import Wall, World
from turtlewire.turtle import HOME, Pose, Turtle

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.unit.robots.car.wires import Wire
    from tests.unit.robots.two_engine.conftest import Bench, MakeBench
    from turtlewire.protocols.frame.message import FrameMessage

EXAMPLES = Path(__file__).parents[4] / "examples"
HALTS = (EngineForward(0, 0), EngineForward(1, 0))


def frames(data: bytes, dialect: str = "0.1") -> list[tuple[FrameMessage, ...]]:
    """The messages of each frame in what was sent."""
    items = FrameDecoder(shipped(dialect), TO_ROBOT).receive_data(data)
    return [item.messages for item in items if isinstance(item, Frame)]


def is_stop(data: bytes) -> bool:
    """F13: nothing but stops of all engines, for 128 bytes and two frames more."""
    found = frames(data)
    return len(data) >= 128 + 2 * 10 and all(messages == HALTS for messages in found)


# ---------------------------------------------------------------- connecting (F13)


def test_f13_connecting_stops_whatever_the_robot_was_in_the_middle_of(bench: MakeBench) -> None:
    def drive_first(wire: Wire) -> None:
        robot = wire.robot
        assert isinstance(robot, SimulatedFrameRobot)
        encoder = AsyncTwoEngine(MemoryLink(SimulatedFrameRobot()))._host._encoder
        robot.write(b"".join(encoder.encode([EngineForward(0, 200)])) + b"\xa3\x00\x7c")
        pass_time(robot, 0.05)
        assert list(robot.engines) == [200, 0]

    made = bench(prepare=drive_first)
    assert list(made.robot.engines) == [0, 0]
    assert is_stop(made.wire.sent[0][1])
    assert made.robot.pen_is_down
    assert made.turtle.pose == Pose()


def test_a_robot_that_boots_is_stopped_again_and_again(bench: MakeBench) -> None:
    made = bench({"boot_s": 1.9}, boot_s=2.5)
    assert made.robot.now == pytest.approx(2.77, abs=0.1)
    assert sum(is_stop(data) for _, data in made.wire.sent) == 6
    assert made.robot.pen_is_down


def test_a_robot_that_is_heard_has_booted(bench: MakeBench) -> None:
    made = bench({"boot_s": 1.0}, dialect="telemetry", boot_s=2.5)
    assert made.robot.now < 1.5
    assert made.robot.pen_is_down


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("baud", 1),
        ("speed", 0),
        ("tolerance_mm", 0.0),
        ("halts", 0),
        ("boot_s", -1.0),
        ("repeat_s", 0.0),
        ("heartbeat_s", float("nan")),
        ("odometry_s", 0.0),
        ("calibration", TwoEngineCalibration(right_engine=2)),
        ("calibration", TwoEngineCalibration(pen_servo=2)),
    ],
)
def test_a_setting_that_drives_no_robot_is_refused(name: str, value: object) -> None:
    wrong = {"calibration": "engine|servo"}.get(name, name)
    settings = Settings(**{name: value})  # type: ignore[arg-type] # that is the point
    with pytest.raises(UsageError, match=wrong):
        AsyncTwoEngine(MemoryLink(SimulatedFrameRobot()), settings)


def test_a_dialect_that_drives_nothing_is_refused() -> None:
    text = (
        'protocol = "frame"\ndialect = "mute"\ntitle = "Mute"\nbaud = 9600\n[crc]\nalgorithm = "CRC-8/SMBUS"\n'
        'coverage = "magic"\n[counts]\n[[message]]\nname = "Sing"\ntype = 1\ndirection = "to robot"\ndoc = "Sing."\n'
        'fields = [{ name = "note", kind = "u8", unit = "number" }]\n'
    )
    with pytest.raises(UsageError, match="drives no wheels"):
        AsyncTwoEngine(MemoryLink(SimulatedFrameRobot()), Settings(dialect=read_dialect(text)))


# ---------------------------------------------------------------- own commands


def test_f9_several_messages_are_one_frame(bench: MakeBench) -> None:
    made = bench(repeat_s=None)
    made.wire.forget()
    messages = (SetServoPosition(1, 45), EngineForward(0, 200), EngineBackward(1, 90))
    made.turtle.send(*messages)
    assert frames(made.wire.bytes_sent) == [messages]
    made.goes_on(0.5)
    assert list(made.robot.engines) == [200, -90]
    assert made.robot.servos_deg[1] == 45.0


def test_engines_and_servos(bench: MakeBench) -> None:
    made = bench(repeat_s=None)
    made.wire.forget()
    made.turtle.engine(0, 255)
    made.turtle.engine(1, -1)
    made.turtle.set_servo(1, 180)
    made.turtle.engine(0, 0)
    assert frames(made.wire.bytes_sent) == [
        (EngineForward(0, 255),),
        (EngineBackward(1, 1),),
        (SetServoPosition(1, 180),),
        (EngineForward(0, 0),),
    ]
    made.turtle.set_servo(0, 90)
    assert not made.turtle.is_pen_down
    made.turtle.set_servo(0, 40)
    assert made.turtle.is_pen_down


def test_f4_what_is_out_of_range_is_refused_before_any_byte_leaves(bench: MakeBench) -> None:
    made = bench(repeat_s=None)
    made.wire.forget()
    car = made.turtle
    refused: list[Callable[[], object]] = [
        lambda: car.engine(0, 256),
        lambda: car.engine(2, 1),
        lambda: car.engine(0, 1, valid_s=0),
        lambda: car.set_servo(0, 181),
        lambda: car.set_servo(2, 0),
        lambda: car.send(EngineForward(0, 100), SetServoPosition(9, 0)),
        lambda: car.send(shipped("telemetry").parse("set_lamp on=1")),
        lambda: car.send(codec("walter").parse("pen_up")),
        lambda: car.drive(0, 2),
        lambda: car.drive(float("inf"), 0),
        lambda: car.horn("loud"),
    ]
    for use in refused:
        with pytest.raises(MessageError):
            use()
    assert made.wire.bytes_sent == b""


def test_what_a_robot_says_it_is_not_told(bench: MakeBench) -> None:
    made = bench(dialect="telemetry", repeat_s=None)
    made.wire.forget()
    with pytest.raises(MessageError, match="odometry is what a robot says"):
        made.turtle.send(shipped("telemetry").parse("odometry 1 2 3"))
    assert made.wire.bytes_sent == b""


def test_what_a_robot_has_its_dialect_says(bench: MakeBench) -> None:
    made, other = bench(), bench(dialect="telemetry")
    assert isinstance(made.turtle, Turtle)
    assert isinstance(made.turtle, Drive)
    assert made.turtle.features == {"servos", "pen"}
    assert other.turtle.features == {"servos", "pen", "lamp", "horn"}
    other.turtle.lamp(on=True)
    other.turtle.horn("high")
    other.goes_on(0.1)
    assert other.robot.lamp
    assert other.robot.last["beep"].values() == (2, 5000)
    other.turtle.horn("off")
    other.goes_on(0.1)
    assert other.robot.last["beep"].values() == (0, 0)
    lacking: list[Callable[[], object]] = [
        lambda: made.turtle.lamp(on=True),
        lambda: made.turtle.horn("low"),
        lambda: other.turtle.engine(0, 1),
    ]
    for use in lacking:
        with pytest.raises(NotSupportedError):
            use()


def test_a_robot_without_a_pen_or_servos(bench: MakeBench) -> None:
    none = shipped("0.1").configured(counts={"servos": 0})
    made = bench({"pen_servo": None}, dialect=none)
    assert made.turtle.features == frozenset()
    made.turtle.pen_up()
    made.turtle.forward(10)
    assert made.off_mm < 0.01
    with pytest.raises(MessageError):
        made.turtle.set_servo(0, 0)
    other = bench({"pen_servo": None}, calibration=TwoEngineCalibration(pen_servo=None))
    assert other.turtle.features == {"servos"}


# ---------------------------------------------------------------- by hand


@pytest.mark.parametrize(
    ("speed", "turn", "engines"),
    [
        (1, 0, (255, 255)),
        (-0.5, 0, (-142, -142)),
        (0, 1, (255, -255)),
        (1, 1, (255, 0)),
        (0.5, -0.25, (86, 199)),
        (-1, 0.5, (-105, -255)),
        (0, 0, (0, 0)),
    ],
)
def test_speed_and_turn_are_mixed(
    bench: MakeBench, speed: float, turn: float, engines: tuple[int, int]
) -> None:
    made = bench()
    made.turtle.drive(speed, turn)
    made.goes_on(0.1)
    assert made.robot.engines == engines


def test_wheels_that_know_speeds_are_told_speeds(bench: MakeBench) -> None:
    made = bench(dialect="telemetry")
    made.turtle.drive(0.5, 0.25)
    made.goes_on(0.1)
    assert list(made.robot.engines) == [270, 90]


def test_a_set_point_lives_as_long_as_it_is_valid(bench: MakeBench) -> None:
    made = bench()
    made.turtle.drive(0.5, 0.2, valid_s=0.3)
    assert made.goes_on(0.25)
    made.turtle.drive(0.5, 0.2, valid_s=0.3)
    assert made.goes_on(0.25)
    made.turtle.set_servo(1, 20)  # does not make it live longer
    assert not made.goes_on(0.1)
    assert not made.goes_on(1.0)  # what is repeated is not that
    made.turtle.engine(0, 100, valid_s=0.1)
    made.turtle.engine(0, 100)
    assert made.goes_on(1.0)


def test_a_joystick_builds_no_backlog(bench: MakeBench) -> None:
    made = bench({"baud": 1200}, baud=1200)
    made.wire.forget()
    for n in range(100):
        made.turtle.drive(n / 100.0, 0)
    assert len(made.wire.bytes_sent) < 20
    before = made.wire.discards
    made.turtle.stop()
    assert made.wire.discards == before + 1
    pass_time(made.robot, 3.0)
    assert list(made.robot.engines) == [0, 0]


@pytest.mark.parametrize("dialect", ["0.1", "telemetry"])
def test_where_it_was_driven_by_hand_is_reckoned(bench: MakeBench, dialect: str) -> None:
    made = bench(dialect=dialect)
    made.turtle.drive(0.5, 0.2)
    made.goes_on(1.7)
    made.turtle.drive(-0.3, 0.5)
    made.goes_on(1.0)
    made.turtle.drive(0, 0)
    made.goes_on(0.3)
    assert made.off_mm < 1.0
    made.turtle.forward(50)
    assert made.off_mm < 1.0


def test_f6_set_points_are_repeated_and_f7_heartbeats_are_empty(bench: MakeBench) -> None:
    made = bench({"watchdog_s": 0.5}, repeat_s=0.2)
    made.turtle.drive(0.5, 0)
    assert made.goes_on(2.0)
    other = bench({"watchdog_s": 0.5}, repeat_s=None, heartbeat_s=0.2)
    other.turtle.drive(0.5, 0)
    assert other.goes_on(2.0)
    assert () in frames(other.wire.bytes_sent)
    last = bench({"watchdog_s": 0.5}, repeat_s=None)
    last.turtle.drive(0.5, 0)
    assert not last.goes_on(2.0)


# ---------------------------------------------------------------- as a turtle


@pytest.mark.parametrize(
    ("robot", "calibration"),
    [
        ({}, {}),
        ({"right_factor": 0.9}, {"right": SpeedCurve(dead_pwm=30, mm_per_s_per_pwm=1.44)}),
        (
            {"track_mm": 90.0, "dead_pwm": 5},
            {"track_mm": 90.0, "left": SpeedCurve(dead_pwm=5, mm_per_s_per_pwm=1.6)},
        ),
        ({"lag_s": 0.05}, {"settle_s": 0.6}),
        ({"pen_up_deg": 10.0, "pen_down_deg": 170.0}, {"pen_up_deg": 10, "pen_down_deg": 170, "pen_s": 0.6}),
        ({"baud": None}, {}),
    ],
)
def test_with_a_true_calibration_the_robot_is_where_the_turtle_is(
    bench: MakeBench, robot: dict[str, Any], calibration: dict[str, Any]
) -> None:
    if "dead_pwm" in robot:
        calibration = {**calibration, "right": calibration["left"]}
    made = bench(robot, calibration=TwoEngineCalibration(**calibration))
    # Two engines that are not alike turn the robot in whole steps of PWM: it leaves its place a little.
    assert corners(made.turtle, made.robot) < (0.3 if "right_factor" in robot else 0.1)
    assert made.turtle.pose == Pose(*made.turtle.pose[:2], 330.0)


@pytest.mark.parametrize("dialect", ["0.1", "telemetry"])
@pytest.mark.parametrize("speed", [1, 30, 255])
def test_at_any_speed(bench: MakeBench, dialect: str, speed: int) -> None:
    made = bench(dialect=dialect)
    made.turtle.set_speed(speed)
    made.turtle.forward(10)
    made.turtle.right(10)
    made.turtle.back(5)
    made.turtle.finish()
    assert made.off_mm < 0.05
    assert made.robot.pose.heading_deg == pytest.approx(10.0, abs=0.02)


def test_the_wheel_that_can_be_told_more_finely_follows_the_other() -> None:
    told = wheels(
        shipped("0.1"),
        TwoEngineCalibration(
            left=SpeedCurve(dead_pwm=30, mm_per_s_per_pwm=10.0),
            right=SpeedCurve(dead_pwm=30, mm_per_s_per_pwm=0.5),
        ),
    )
    assert told.nearest(14.0, 14.0) == (31, 50)
    assert told.motion(told.nearest(14.0, 14.0)) == (10.0, 0.0)
    assert told.motion(told.nearest(14.0, -14.0)).speed_mm_per_s == 0.0


def test_whole_turns_are_made_once(bench: MakeBench) -> None:
    made = bench()
    made.turtle.right(720)
    made.turtle.forward(10)
    made.turtle.left(360)
    made.turtle.finish()
    made.turtle.back(10)
    assert made.robot.statistics.turned_deg == pytest.approx(1080.0, abs=0.1)
    assert made.off_mm < 0.05


def test_engines_may_be_the_other_way_round(bench: MakeBench) -> None:
    made = bench(
        calibration=TwoEngineCalibration(
            left_engine=1, right_engine=0, left_reversed=True, right_reversed=True
        )
    )
    made.turtle.forward(50)  # to a robot that is not, that is: backwards
    assert made.robot.pose.y_mm == pytest.approx(-50.0, abs=0.01)
    made.turtle.right(90)
    made.turtle.finish()
    assert made.robot.pose.heading_deg == pytest.approx(90.0, abs=0.02)
    made.turtle.engine(1, -100)
    assert made.turtle._robot._told_wheels == (100, 0)
    made.turtle.engine(0, 80)
    assert made.turtle._robot._told_wheels == (100, -80)


def test_f1_a_robot_that_cannot_tell_backward_says_so(bench: MakeBench) -> None:
    made = bench(dialect="0.1-literal")
    made.turtle.forward(50)
    assert made.off_mm < 0.01
    made.wire.forget()
    with pytest.raises(NotSupportedError, match="same type"):
        made.turtle.right(90)
    assert made.turtle.pose.heading_deg == 0.0
    with pytest.raises(NotSupportedError, match="same type"):
        made.turtle.engine(0, -1)
    made.turtle.drive(0.5, 0.5)
    made.goes_on(0.1)
    assert list(made.robot.engines) == [255, 0]


def test_the_pen_is_a_servo_and_draws(bench: MakeBench) -> None:
    made = bench()
    made.turtle.forward(30)
    made.turtle.pen_up()
    assert made.robot.servos_deg[0] > 80.0
    made.turtle.forward(30)
    made.turtle.pen_down()
    made.turtle.right(90)
    made.turtle.forward(30)
    made.turtle.finish()
    first, second = [stroke.points for stroke in made.robot.trace.strokes if stroke.pen_down]
    assert [*first[0], *first[-1]] == pytest.approx([0, 0, 0, 30], abs=0.01)
    assert [*second[0], *second[-1]] == pytest.approx([0, 60, 30, 60], abs=0.01)
    assert made.turtle.trace.strokes == made.robot.trace.strokes
    made.turtle.clear_screen()
    assert made.turtle.trace.strokes == []
    assert made.turtle._robot.account.trace.strokes == []
    assert made.turtle.pose == HOME


def test_a_lost_frame_that_ends_a_motion_is_sent_again(bench: MakeBench) -> None:
    made = bench(repeat_s=None)
    made.wire.forget()
    count = itertools.count()
    made.wire.to_robot = lambda data: b"" if next(count) == 1 else data
    made.turtle.forward(100)
    assert not made.goes_on(0.1)
    assert 100.0 < made.robot.pose.y_mm < 115.0
    assert [messages == HALTS for messages in frames(made.wire.bytes_sent)] == [False, True, True]


@pytest.mark.parametrize("program", ["rose.logo"])
def test_a_picture_is_the_ideal_one(bench: MakeBench, program: str) -> None:
    made, ideal = bench(), ScreenTurtle()
    source = (EXAMPLES / program).read_text("utf-8")
    for turtle in (made.turtle, ideal):
        Interpreter(turtle, write=lambda _: None, random=random.Random(0)).run(source, program)
    made.turtle.finish()
    drawn, wanted = ([s for s in t.trace.strokes if s.pen_down] for t in (made.turtle, ideal))
    assert len(drawn) == len(wanted)
    for stroke, other in zip(drawn, wanted, strict=True):
        for point, corner in ((stroke.points[0], other.points[0]), (stroke.points[-1], other.points[-1])):
            assert math.dist(point, corner) < 0.3
    assert made.off_mm < 0.3


# ---------------------------------------------------------------- odometry and bumper (F11)


@pytest.mark.parametrize("ideal", [True, False])
def test_odometry_puts_right_what_the_calibration_gets_wrong(bench: MakeBench, ideal: bool) -> None:
    off = {}
    for telemetry_s in (0.1, None):
        made = bench(
            {"noise": 0.0 if ideal else 8.0, "seed": 2, "telemetry_s": telemetry_s}, dialect="telemetry"
        )
        for _ in range(12):
            made.turtle.forward(100)
            made.turtle.right(90)
        made.turtle.finish()
        off[telemetry_s] = made.off_mm
        assert bool(made.turtle.statistics.corrections) == (telemetry_s is not None and not ideal)
        assert bool(made.turtle.statistics.frames_received) == (telemetry_s is not None)
    if ideal:
        assert max(off.values()) < 0.01
    else:
        assert off[0.1] < 10.0
        assert off[None] > 2.0 * off[0.1]


def test_ticks_that_only_round_change_nothing_and_others_do() -> None:
    odometer = Odometer(0.5)
    assert odometer.travelled(3.0, 4.0) == (3.0, 4.0)  # nothing heard yet
    odometer = Odometer(0.5)
    odometer.report(1000, 2**31 - 3, -7, 1.0)
    odometer.report(2000, -(2**31) + 17, 3, 2.0)  # 20 and 10 ticks on, wrapped: 10 mm and 5 mm
    assert odometer.travelled(10.4, 4.6) == (10.4, 4.6)
    assert odometer.corrections == 0
    assert odometer.travelled(3.0, -3.0) == pytest.approx(
        (0.1, -0.1)
    )  # to the edge of what the ticks can mean
    assert odometer.corrections == 1
    assert odometer.heard_at == 2.0


def test_a_robot_that_is_reset_while_it_moves_is_stopped_and_not_believed(bench: MakeBench) -> None:
    made = bench({"boot_s": 0.3}, dialect="telemetry", boot_s=0.5)
    made.turtle.forward(50)
    made.wire.at(0.5, made.robot.port_opened)
    with pytest.raises(
        PoseUncertainError, match=r"was reset while it moved.*x 0 mm, y 50 mm.*Nothing was"
    ) as caught:
        made.turtle.forward(400)
    pass_time(made.robot, 0.5)
    assert list(made.robot.engines) == [0, 0]
    stood = made.robot.pose
    assert 50.0 < stood.y_mm < 250.0
    last_mm = float(re.findall(r"y (\d+) mm", str(caught.value))[1])
    assert 50.0 < made.turtle.pose.y_mm < last_mm < 300.0
    made.turtle.finish()
    assert made.robot.pen_is_down  # a reset lifts it
    made.turtle.forward(30)
    assert made.robot.pose.y_mm - stood.y_mm == pytest.approx(30.0, abs=0.5)


def test_a_robot_that_is_reset_while_it_stands_goes_on_from_there(bench: MakeBench) -> None:
    made = bench({"boot_s": 0.3}, dialect="telemetry", boot_s=0.5)
    made.turtle.forward(50)
    made.robot.port_opened()
    assert not made.goes_on(1.0)
    assert "was reset; its pen is set as it was" in made.notes[0]
    made.turtle.forward(30)
    assert made.robot.pen_is_down
    assert made.off_mm < 0.5
    assert made.turtle.statistics.corrections == 0


def test_a_bumper_ends_a_motion_and_only_the_way_back_is_free(bench: MakeBench) -> None:
    made = bench({"world": World((Wall(-300, 200, 300, 200),))}, dialect="telemetry")
    with pytest.raises(LimitReachedError, match="front") as caught:
        made.turtle.forward(500)
    assert caught.value.y_mm == pytest.approx(110.0, abs=30.0)  # its wheels turned on until it was told
    pass_time(made.robot, 0.1)
    assert list(made.robot.engines) == [0, 0]
    with pytest.raises(LimitReachedError, match="front"):
        made.turtle.forward(50)
    made.turtle.back(50)
    made.turtle.forward(10)
    assert made.robot.pose.y_mm == pytest.approx(70.0, abs=1.0)
    made.turtle.drive(1, 0)
    with pytest.raises(LimitReachedError):
        made.goes_on(5.0)
    made.turtle.back(20)
    made.turtle.right(180)
    with pytest.raises(LimitReachedError, match="back"):
        made.turtle.back(100)


# ---------------------------------------------------------------- stopping


def test_f13_a_stop_while_a_program_drives(bench: MakeBench) -> None:
    made = bench()
    made.wire.at(0.5, made.turtle.stop)
    with pytest.raises(StoppedError):
        made.turtle.forward(1000)
    assert is_stop(made.wire.sent[-1][1])
    pass_time(made.robot, 1.0)
    stood = made.robot.pose
    assert 50.0 < stood.y_mm < 90.0
    assert made.off_mm < 0.01
    made.turtle.forward(50)
    assert made.robot.pose.y_mm - stood.y_mm == pytest.approx(50.0, abs=0.01)


def test_driving_by_hand_takes_the_robot_from_a_program(bench: MakeBench) -> None:
    made = bench()
    made.wire.at(0.5, lambda: made.turtle.drive(-1, 0))
    with pytest.raises(StoppedError):
        made.turtle.forward(1000)
    assert made.goes_on(5.0)
    assert list(made.robot.engines) == [-255, -255]


def test_the_end_of_a_with_block_waits_and_then_stops(bench: MakeBench) -> None:
    made = bench()
    with made.turtle as turtle:
        turtle.forward(100)
        turtle.right(90)
    assert made.robot.pose.heading_deg == pytest.approx(90.0, abs=0.02)
    assert is_stop(made.wire.sent[-1][1])
    made.turtle.close()
    for use in (made.turtle.finish, lambda: made.turtle.engine(0, 1), made.turtle.stop):
        with pytest.raises(LinkClosedError):
            use()


@pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt])
def test_an_error_while_the_robot_drives_stops_it_at_once(
    bench: MakeBench, error: type[BaseException]
) -> None:
    made = bench()

    def fail() -> None:
        raise error

    made.wire.at(0.5, fail)
    with pytest.raises(error), made.turtle as turtle:
        turtle.forward(1000)
    assert is_stop(made.wire.sent[-1][1])
    pass_time(made.robot, 1.0)
    assert 50.0 < made.robot.pose.y_mm < 90.0


def test_a_robot_that_is_lost_is_stopped() -> None:
    robot, runner = SimulatedFrameRobot(), InlineRunner()
    driver = AsyncTwoEngine(MemoryLink(robot))
    runner.run(driver.connect())
    turtle = TwoEngine(driver, runner)
    turtle.drive(1, 0)
    del turtle
    gc.collect()
    assert list(robot.engines) == [0, 0]
    assert driver.is_over


def test_a_link_that_ends_while_the_robot_drives() -> None:
    async def drive() -> None:
        link = FaultyLink(MemoryLink(SimulatedFrameRobot()), Faults(close_at_s=4.0))
        async with AsyncTwoEngine(link) as robot:
            await robot.connect()
            await robot.forward(1000)

    with pytest.raises(LinkLostError):
        asyncio.run(drive())


def test_noise_never_leaves_it_driving() -> None:
    for seed in range(20):
        robot, runner = SimulatedFrameRobot(), InlineRunner()
        rate = 0.003
        link = FaultyLink(
            MemoryLink(robot), Faults(lose=rate, add=rate, flip=rate, duplicate=rate, seed=seed)
        )
        driver = AsyncTwoEngine(link, Settings(boot_s=0.0))
        runner.run(driver.connect())
        with TwoEngine(driver, runner) as turtle:
            for _ in range(4):
                turtle.forward(40)
                turtle.right(90)
        pass_time(robot, 0.5)
        assert list(robot.engines) == [0, 0]


def test_the_asynchronous_robot_over_a_real_pty() -> None:
    async def draw() -> tuple[Pose, Pose, tuple[float, float]]:
        robot = SimulatedFrameRobot(FrameRobotSettings(baud=None))
        url: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        stopped = asyncio.Event()
        server = asyncio.create_task(serve(robot, "pty", ready=url.set_result, stopped=stopped))
        async with AsyncTwoEngine(await open_port(await url, baud=115200), Settings(boot_s=0.0)) as turtle:
            await turtle.connect()
            await turtle.forward(60)
            await turtle.left(90)
            await turtle.back(30)
            await turtle.finish()
            pose = turtle.pose
        engines = robot.engines
        stopped.set()
        await server
        return pose, robot.pose, engines

    pose, true, engines = asyncio.run(draw())
    assert list(engines) == [0, 0]
    assert pose.distance_to(true.x_mm, true.y_mm) < 20.0  # as far as the scheduler lets it


def test_statistics_tell_what_happened(bench: MakeBench) -> None:
    made: Bench = bench(dialect="telemetry")
    made.turtle.forward(100)
    made.turtle.back(30)
    figures = made.turtle.statistics
    assert figures.distance_mm == pytest.approx(130.0, abs=0.01)
    assert figures.bytes_sent == len(made.wire.bytes_sent)
    assert figures.frames_received > 5
    assert (figures.frames_ignored, figures.frames_lost) == (0, 0)
    assert figures.seconds == made.robot.now
