"""What passes over the wire, as it is shown."""

from __future__ import annotations

import pytest

from turtlewire.configuration import Target
from turtlewire.helm.sight import Ear, title
from turtlewire.helm.wire import MAX_LINES, Messages, Tap
from turtlewire.links.memory import MemoryLink
from turtlewire.protocols.frame.codec import FrameEncoder
from turtlewire.protocols.frame.dialect import shipped
from turtlewire.protocols.frame.host import stop_bytes
from turtlewire.protocols.walter.messages import ATTENTION, EMERGENCY_STOP
from turtlewire.robots.runner import InlineRunner
from turtlewire.simulator.walter import SimulatedWalter


def heard(protocol: str, **options: object) -> Messages:
    return Ear(Target("a robot", "/dev/ttyUSB0", protocol, options), 1.0).messages


def shown(messages: Messages) -> list[tuple[str, str, int]]:
    return [(line.sender, line.text, line.times) for line in messages.lines()]


def test_both_directions_in_order() -> None:
    messages = heard("simple")
    messages.passed(b"F120000L0", "host", 1.0)
    messages.passed(b"K", "robot", 1.1)
    messages.passed(b"30000", "host", 1.2)
    messages.passed(b"F", "robot", 1.3)
    assert shown(messages) == [
        ("host", "drive_forward speed=120", 1),
        ("robot", "accepted", 1),
        ("host", "steer_left lock=30", 1),
        ("robot", "rejected", 1),
    ]
    assert [line.time_s for line in messages.lines()] == [1.0, 1.1, 1.2, 1.3]


def test_the_same_within_a_moment_is_counted() -> None:
    messages = heard("simple")
    for n in range(10):
        messages.passed(b"F120000", "host", n * 0.1)
        messages.passed(b"K", "robot", n * 0.1 + 0.02)
    messages.passed(b"F000000", "host", 1.0)
    assert shown(messages) == [
        ("host", "drive_forward speed=120", 10),
        ("robot", "accepted", 10),
        ("host", "drive_forward speed=0", 1),
    ]
    assert messages.lines()[0].time_s == 0.0
    messages.passed(b"F120000", "host", 2.5)  # later is another time
    assert shown(messages)[-1] == ("host", "drive_forward speed=120", 1)


def test_what_a_robot_tells_again_and_again_is_one_line_with_the_newest() -> None:
    dialect = shipped("telemetry")
    messages = heard("frame", dialect=dialect)
    encoder = FrameEncoder(dialect, "from robot")
    for n in range(5):
        report = dialect.parse(f"odometry time_ms={n} left_ticks={n} right_ticks=0")
        messages.passed(encoder.encode([report])[0], "robot", n * 0.1)
    assert shown(messages) == [("robot", "odometry time_ms=4 left_ticks=4 right_ticks=0", 5)]
    messages.passed(FrameEncoder(dialect).encode([])[0], "host", 1.0)
    assert shown(messages)[-1] == ("host", "empty frame", 1)


def test_stops_are_named_and_what_follows_is_decoded() -> None:
    messages = heard("walter")
    messages.passed(ATTENTION + b"QH\r", "host", 0.0)
    messages.passed(EMERGENCY_STOP * 2 + b"XG\x64A", "host", 0.5)
    messages.passed(EMERGENCY_STOP, "host", 0.6)
    assert shown(messages) == [
        ("host", "attention: stop, Logo control", 1),
        ("host", "query_heading", 1),
        ("host", "emergency stop", 3),
        ("host", "lower_pen", 1),
        ("host", "set_move_speed speed=100", 1),
        ("host", "start_forward", 1),
    ]
    messages = heard("frame", dialect=shipped("0.1"))
    messages.passed(stop_bytes(FrameEncoder(shipped("0.1"))), "host", 0.0)
    [(_, text, times)] = shown(messages)
    assert text.startswith("engine_forward engine_id=0 speed=0")
    assert times > 5


def test_what_means_nothing_is_seen() -> None:
    messages = heard("walter")
    messages.passed(b"?\r", "robot", 0.0)
    assert shown(messages)[0][1].startswith("error: ")


def test_memory_is_bounded() -> None:
    messages = heard("simple")
    for n in range(1000):
        messages.passed(f"F{n % 256:03}000".encode(), "host", n * 0.01)
    assert len(messages.lines()) == MAX_LINES


def test_a_tap_changes_nothing() -> None:
    messages = heard("walter")
    robot = SimulatedWalter()
    link = MemoryLink(robot)
    tap = Tap(link, messages)
    runner = InlineRunner()
    assert (tap.url, tap.in_background, tap.now()) == (link.url, False, 0.0)
    tap.write(b"QP\r")
    assert runner.run(tap.read(1.0)) == b"Q"
    while robot.now < 1.0:
        runner.run(tap.read(1.0))
    tap.write(b"FD" * 20)
    tap.write_urgent(EMERGENCY_STOP)
    assert robot.bytes_on_line <= len(EMERGENCY_STOP) + 1
    runner.run(tap.sleep(2.0))
    assert tap.now() == 2.0
    tap.wake()
    runner.run(tap.close())
    runner.run(tap.reopen())
    tap.write(b"A")
    runner.run(tap.read(3.0))
    assert robot.is_moving
    assert [line.text for line in messages.lines()][:2] == ["query_pen", "pen_reply down=0"]


@pytest.mark.parametrize(
    ("target", "called"),
    [
        (Target("sim:walter?slip=0.1", "sim:walter", "walter"), "simulated WALTER"),
        (Target("/dev/ttyUSB0", "/dev/ttyUSB0", "simple"), "car at /dev/ttyUSB0"),
        (Target("elsie", "/dev/ttyUSB0", "frame"), "elsie, a two-engine robot at /dev/ttyUSB0"),
    ],
)
def test_what_a_robot_is_called(target: Target, called: str) -> None:
    assert title(target) == called
