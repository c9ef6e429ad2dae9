"""A two-engine robot over its wire (PROTOCOLS F1 to F13; section 4)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.errors import UsageError
from turtlewire.protocols.frame.codec import Frame, FrameDecoder, FrameEncoder
from turtlewire.protocols.frame.dialect import FROM_ROBOT, Dialect, read_dialect, shipped
from turtlewire.protocols.frame.messages import EngineBackward, EngineForward, SetServoPosition
from turtlewire.simulator.frame_robot import Action, FrameRobotSettings, SimulatedFrameRobot
from turtlewire.simulator.world import Wall, World
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from turtlewire.protocols.frame.message import FrameMessage

Run = Callable[..., bytes]
BYTE_S = 10 / 115200
BASE = shipped("0.1")
TELEMETRY = shipped("telemetry")
# 100 mm/s at 150; a turn in place at that speed is a radian in 0.7 s.
PLAIN: dict[str, Any] = {
    "baud": None,
    "dead_pwm": 50,
    "mm_per_s_per_pwm": 1.0,
    "track_mm": 140.0,
    "servo_deg_per_s": 300.0,
}
AHEAD = World((Wall(-1000.0, 300.0, 1000.0, 300.0),))


def robot_with(**settings: Any) -> SimulatedFrameRobot:
    return SimulatedFrameRobot(FrameRobotSettings(**{**PLAIN, **settings}))


def sent(*messages: FrameMessage, dialect: Dialect = BASE, seq: int = 0) -> bytes:
    return b"".join(FrameEncoder(dialect, seq=seq).encode(messages))


def engines(left: int, right: int) -> bytes:
    pairs = enumerate((left, right))
    return sent(*(EngineForward(n, s) if s >= 0 else EngineBackward(n, -s) for n, s in pairs))


def told(robot: SimulatedFrameRobot) -> tuple[float, float]:
    # A call: mypy would take it that a property asked twice is the same twice.
    return robot.engines


def log_of(robot: SimulatedFrameRobot) -> list[Action]:
    log: list[Action] = []
    robot.events = log.append
    return log


def reports(data: bytes, dialect: Dialect = TELEMETRY) -> list[FrameMessage]:
    items = FrameDecoder(dialect, FROM_ROBOT).receive_data(data)
    assert all(isinstance(item, Frame) for item in items)
    return [message for item in items if isinstance(item, Frame) for message in item.messages]


# Engines


def test_messages_of_a_frame_take_effect_together_with_its_last_bit() -> None:
    robot = robot_with(baud=115200)
    log = log_of(robot)
    robot.write(engines(150, 150))
    assert robot.read(1.0) == b""
    assert [action.time_s for action in log] == pytest.approx([10 * BYTE_S] * 2)
    assert [action.what for action in log] == [str(EngineForward(0, 150)), str(EngineForward(1, 150))]
    assert robot.pose == pytest.approx(Pose(0.0, 100.0 * (1.0 - 10 * BYTE_S), 0.0))
    assert robot.statistics[:5] == (2, 10, 0, 0, 0)


@pytest.mark.parametrize(
    ("left", "right", "pose"),
    [
        (150, 150, (0.0, 200.0, 0.0)),
        (-150, -150, (0.0, -200.0, 0.0)),
        (150, -150, (0.0, 0.0, math.degrees(200.0 / 70.0))),
        (-150, 150, (0.0, 0.0, 360.0 - math.degrees(200.0 / 70.0))),
        (50, -50, (0.0, 0.0, 0.0)),
    ],
)
def test_two_engines(run: Run, left: int, right: int, pose: tuple[float, float, float]) -> None:
    robot = robot_with()
    run(robot, engines(left, right), 2.0)
    assert robot.pose == robot.odometer == pytest.approx(Pose(*pose))
    assert told(robot) == (left, right)


def test_one_wheel_alone_drives_round_the_other(run: Run) -> None:
    robot = robot_with()
    run(robot, sent(EngineForward(0, 150)), 140.0 * math.pi / 100.0)
    assert robot.pose == pytest.approx(Pose(140.0, 0.0, 180.0), abs=1e-6)
    assert robot.wheels_mm == pytest.approx((140.0 * math.pi, 0.0))


def test_no_two_engines_are_the_same(run: Run) -> None:
    robot = robot_with(right_factor=0.9)
    run(robot, engines(150, 150), 1.0)
    assert robot.pose.heading_deg == pytest.approx(math.degrees(10.0 / 140.0))


def test_engines_may_be_wired_otherwise(run: Run) -> None:
    robot = robot_with(left_engine=1, right_engine=0, right_reversed=True, backward_factor=0.5)
    run(robot, engines(150, 150), 1.0)
    assert told(robot) == (150, -150)
    assert robot.wheels_mm == pytest.approx((100.0, -50.0))


def test_engines_lag_each_on_its_own(run: Run) -> None:
    robot = robot_with(lag_s=0.2)
    run(robot, engines(150, -150), 0.2)
    assert robot.pose.heading_deg == pytest.approx(math.degrees(100.0 * 0.2 * math.exp(-1.0) / 70.0))
    run(robot, engines(0, 0), 9.0)
    total = 100.0 * 0.2 * math.exp(-1.0) + 100.0 * (1.0 - math.exp(-1.0)) * 0.2
    assert robot.pose.heading_deg == pytest.approx(math.degrees(total / 70.0), abs=0.01)
    assert not robot.is_moving


def test_the_literal_dialect_knows_no_backward(run: Run) -> None:
    literal = shipped("0.1-literal")
    robot = robot_with(dialect=literal)
    run(robot, sent(EngineForward(0, 150), EngineForward(1, 150), dialect=literal), 1.0)
    assert robot.pose.y_mm == pytest.approx(100.0)
    run(robot, sent(*literal.stop_messages(), dialect=literal), 1.0)
    assert told(robot) == (0, 0)


def test_engines_that_it_does_not_have_are_refused(run: Run) -> None:
    four = BASE.configured(counts={"engines": 4})
    robot = robot_with()
    run(robot, sent(EngineForward(3, 99), EngineForward(0, 99), dialect=four))
    assert told(robot) == (99, 0)
    assert robot.statistics.malformed == 1
    robot = robot_with(dialect=four)
    run(robot, sent(EngineForward(3, 99), dialect=four))
    assert told(robot) == (0, 0)  # known, but turning nothing


# Framing in virtual time


def test_a_partial_frame_is_given_up_after_a_pause(run: Run) -> None:
    frame, robot = engines(150, 150), robot_with()
    run(robot, b"\xa3\x00" + b"\x7c", 0.05)  # a header that promises 124 bytes
    run(robot, frame, 0.099)
    assert told(robot) == (0, 0)
    assert robot.next_event() == pytest.approx(0.15)
    run(robot, b"", 0.002)
    assert told(robot) == (150, 150)
    assert robot.pose.y_mm == pytest.approx(0.1, abs=1e-6)  # from then on
    assert robot.statistics.malformed == 1


def test_a_wrong_crc_changes_nothing(run: Run) -> None:
    robot = robot_with()
    damaged = bytearray(engines(150, 150))
    damaged[4] ^= 1
    run(robot, bytes(damaged))
    assert told(robot) == (0, 0)
    assert robot.statistics.malformed == 1


# Walls


def test_a_wall_holds_it_until_it_drives_away(run: Run) -> None:
    robot = robot_with(world=AHEAD)
    log = log_of(robot)
    run(robot, engines(150, 150), 5.0)
    assert robot.pose == pytest.approx(Pose(0.0, 210.0, 0.0), abs=1e-6)
    assert [a.what for a in log if "bump" in a.what] == ["bumped front"]
    assert robot.wheels_mm == pytest.approx((500.0, 500.0))
    run(robot, engines(-150, -150), 1.0)
    assert robot.pose == pytest.approx(Pose(0.0, 110.0, 0.0), abs=1e-6)
    assert robot.bumper is None


def test_held_by_a_wall_it_turns_in_place_until_it_is_free(run: Run) -> None:
    robot = robot_with(world=AHEAD)
    run(robot, engines(150, 150), 2.2)
    assert str(robot.bumper) == "front"
    run(robot, engines(160, 140), 0.5)
    # The rim's share of the speed, 10 mm/s, turns it.
    assert robot.pose == pytest.approx(Pose(0.0, 210.0, math.degrees(5.0 / 70.0)), abs=1e-6)
    run(robot, b"", 20.0)
    assert robot.pose.heading_deg > 90.0
    assert robot.pose.y_mm < 209.0
    assert str(robot.bumper) == "None"


# Servos and the pen


def test_servos_slew(run: Run) -> None:
    robot = robot_with()
    run(robot, sent(SetServoPosition(1, 180), SetServoPosition(0, 0)), 0.1)
    assert robot.servos_deg == pytest.approx((60.0, 120.0))
    run(robot, sent(SetServoPosition(1, 120)), 1.0)
    assert robot.servos_deg == (0.0, 120.0)


def test_the_pen_is_down_when_its_servo_is_nearer_to_down(run: Run) -> None:
    robot = robot_with(pen_up_deg=90.0, pen_down_deg=30.0)
    log = log_of(robot)
    run(robot, engines(150, 150) + sent(SetServoPosition(0, 30), seq=1), 1.0)
    run(robot, sent(SetServoPosition(0, 90)), 1.0)
    assert [stroke.pen_down for stroke in robot.trace.strokes] == [False, True, False]
    assert [stroke.points for stroke in robot.trace.strokes] == [
        [(0.0, 0.0), pytest.approx((0.0, 10.0))],
        [pytest.approx((0.0, 10.0)), pytest.approx((0.0, 110.0))],
        [pytest.approx((0.0, 110.0)), pytest.approx((0.0, 200.0))],
    ]
    assert [action.what for action in log[-3:]][::2] == ["pen down", "pen up"]


def test_a_pen_called_back_in_time_never_touches(run: Run) -> None:
    robot = robot_with()
    run(robot, sent(SetServoPosition(0, 30)), 0.09)
    run(robot, sent(SetServoPosition(0, 90)), 1.0)
    run(robot, sent(SetServoPosition(0, 61)), 1.0)
    assert str(robot.pen_is_down) == "False"
    run(robot, sent(SetServoPosition(0, 59)), 1.0)
    assert robot.pen_is_down


def test_a_robot_without_a_pen(run: Run) -> None:
    robot = robot_with(pen_servo=None, servo_deg=45.0)
    assert robot.servos_deg == (45.0, 45.0)
    run(robot, sent(SetServoPosition(0, 0)), 1.0)
    assert not robot.pen_is_down


# Watchdog and telemetry


def test_the_watchdog_stops_the_engines_and_empty_frames_feed_it(run: Run) -> None:
    robot = robot_with(watchdog_s=0.3)
    run(robot, engines(150, 150), 0.2)
    run(robot, sent(seq=1), 0.2)
    assert told(robot) == (150, 150)
    run(robot, b"\xa3", 0.2)  # nothing valid
    assert told(robot) == (0, 0)
    assert robot.pose.y_mm == pytest.approx(50.0)
    assert robot.statistics.watchdog_stops == 1


def test_it_says_nothing_in_the_base_dialect_and_while_it_boots(run: Run) -> None:
    assert run(robot_with(), engines(150, 150), 5.0) == b""
    assert robot_with().next_event() == math.inf
    silent = robot_with(dialect=TELEMETRY, telemetry_s=None)
    assert run(silent, b"", 5.0) == b""
    booting = robot_with(dialect=TELEMETRY, boot_s=0.5)
    assert run(booting, b"", 0.59) == b""
    assert len(reports(run(booting, b"", 0.02))) == 3


def test_telemetry_tells_what_wheels_battery_and_sensor_measure(run: Run) -> None:
    robot = robot_with(dialect=TELEMETRY, world=AHEAD, sag=0.5, battery_s=20.0, battery_v=8.0)
    wheels = sent(TELEMETRY["SetWheelSpeeds"](51, 101), dialect=TELEMETRY)
    assert reports(run(robot, b"", 0.1))[1] == TELEMETRY["Status"](0, 8.0, bumper=False)
    run(robot, wheels, 1.0)
    odometry, status, distance = reports(run(robot, b"", 0.1))
    assert odometry == TELEMETRY["Odometry"](1200, 112, 222)
    state, volts, touched = status.values()
    assert (state, touched) == (1, False)
    assert volts == pytest.approx(8.0 * (1.0 - 0.5 * 1.1 * 76.0 / 205.0 / 20.0), rel=1e-6)
    here = robot.pose
    expected = (300.0 - here.y_mm) / math.cos(math.radians(here.heading_deg)) - 90.0
    assert distance.values() == (0, round(expected))


def test_telemetry_of_a_robot_at_a_wall_and_of_one_that_was_stopped(run: Run) -> None:
    robot = robot_with(dialect=TELEMETRY, world=AHEAD, watchdog_s=3.0)
    run(robot, sent(TELEMETRY["SetWheelSpeeds"](100, 100), dialect=TELEMETRY), 2.95)
    _, status, distance = reports(run(robot, b"", 0.05))
    assert status.values()[0::2] == (1, True)
    assert distance.values() == (0, 0)
    _, status, _ = reports(run(robot, b"", 0.1))
    assert status.values()[0::2] == (2, True)
    run(robot, sent(TELEMETRY["SetWheelSpeeds"](-10, -100), dialect=TELEMETRY), 0.05)
    assert told(robot) == (-10, -100)
    _, status, distance = reports(run(robot, b"", 0.06))
    assert status.values()[0::2] == (1, False)


def test_wheels_are_no_faster_than_they_can(run: Run) -> None:
    robot = robot_with(dialect=TELEMETRY, telemetry_s=None)
    run(robot, sent(TELEMETRY["SetWheelSpeeds"](800, -800), dialect=TELEMETRY), 1.0)
    assert robot.wheels_mm == pytest.approx((205.0, -205.0))


def test_lamp_and_what_it_has_no_part_for(run: Run) -> None:
    robot = robot_with(dialect=TELEMETRY, telemetry_s=None)
    beep = TELEMETRY["Beep"](1, 200)
    run(robot, sent(TELEMETRY["SetLamp"](on=True), beep, dialect=TELEMETRY), 1.0)
    assert robot.lamp
    assert robot.last == {"beep": beep}
    run(robot, sent(TELEMETRY["SetLamp"](on=False), dialect=TELEMETRY), 1.0)
    assert robot.lamp is not True


def test_a_dialect_of_ones_own_reports_what_it_knows() -> None:
    text = """
protocol = "frame"
dialect = "mine"
title = "Mine"
baud = 9600
[crc]
algorithm = "CRC-8/SMBUS"
coverage = "magic"
[[message]]
name = "Odometry"
type = 1
direction = "from robot"
doc = "One wheel."
fields = [{ name = "left_ticks", kind = "i32", unit = "ticks" }]
[[message]]
name = "Status"
type = 2
direction = "from robot"
doc = "Something that nobody measures."
fields = [{ name = "mood", kind = "u8", unit = "mood" }]
"""
    mine = read_dialect(text)
    robot = robot_with(dialect=mine, pen_servo=None)
    assert robot.servos_deg == ()
    assert reports(robot.read(1.0), mine) == [mine["Odometry"](0)]


def test_a_dialect_with_engines_speeds_and_ranges_of_its_own(run: Run) -> None:
    number = '{ name = "engine_id", kind = "u8", unit = "number" }'
    mixed = read_dialect(
        f"""
protocol = "frame"
dialect = "mixed"
title = "Mixed"
baud = 9600
[crc]
algorithm = "CRC-8/SMBUS"
coverage = "magic"
[[message]]
name = "EngineBackward"
type = 1
direction = "to robot"
doc = "PWM."
fields = [{number}, {{ name = "speed", kind = "u8", unit = "PWM" }}]
[[message]]
name = "SetWheelSpeeds"
type = 2
direction = "to robot"
doc = "Speeds."
fields = [
  {{ name = "left_mm_per_s", kind = "i16", unit = "mm/s" }},
  {{ name = "right_mm_per_s", kind = "i16", unit = "mm/s" }},
]
[[message]]
name = "SetServoPosition"
type = 3
direction = "to robot"
doc = "A servo that this robot does not have."
fields = [
  {{ name = "servo_id", kind = "u8", unit = "number" }},
  {{ name = "position_deg", kind = "u8", unit = "degrees" }},
]
[[message]]
name = "Odometry"
type = 4
direction = "from robot"
doc = "A small counter."
fields = [{{ name = "left_ticks", kind = "i32", max = 100, unit = "ticks" }}]
"""
    )
    robot = robot_with(dialect=mixed, pen_servo=None)
    log = log_of(robot)
    run(robot, sent(mixed["SetWheelSpeeds"](40, 60), mixed["SetServoPosition"](5, 20), dialect=mixed), 1.0)
    assert told(robot) == (40, 60)
    assert robot.servos_deg == ()
    run(robot, sent(mixed["EngineBackward"](1, 150), dialect=mixed), 1.0)
    assert told(robot) == (0, -150)
    assert robot.wheels_mm == pytest.approx((40.0, 60.0 - 100.0))
    run(robot, sent(mixed["SetWheelSpeeds"](50, 0), dialect=mixed), 2.0)
    assert "not reported: odometry: left_ticks" in log[-1].what


def test_reading_for_ever_ends_where_only_driving_on_is_left() -> None:
    robot = robot_with(lag_s=0.1)
    robot.write(engines(150, 150) + sent(SetServoPosition(0, 30), seq=1))
    assert robot.read(math.inf) == b""
    assert robot.pen_is_down
    assert robot.is_moving
    assert 0.5 < robot.now < 2.0
    assert robot_with(world=AHEAD).obstacles == AHEAD.walls


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("timeout_s", 0.0),
        ("dead_pwm", 255),
        ("mm_per_s_per_pwm", -1.0),
        ("right_factor", 0.0),
        ("lag_s", -1.0),
        ("coast_s", -1.0),
        ("backward_factor", 0.0),
        ("left_engine", -1),
        ("right_engine", 0),
        ("servo_deg_per_s", 0.0),
        ("servo_deg", 181.0),
        ("pen_up_deg", -1.0),
        ("pen_down_deg", 90.0),
        ("pen_servo", 2),
        ("pen_servo", -1),
        ("telemetry_s", 0.0),
        ("mm_per_tick", 0.0),
        ("battery_v", 0.0),
    ],
)
def test_a_value_that_makes_no_robot_is_named(name: str, value: float) -> None:
    with pytest.raises(UsageError, match=f"{name} is .*but must be"):
        robot_with(**{name: value})
