"""F13 on the chip: left in the middle of any frame, the robot hears the stop that the host repeats, and is in step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from turtlewire.protocols.frame.codec import FrameEncoder, frame_bytes
from turtlewire.protocols.frame.dialect import TO_ROBOT
from turtlewire.protocols.frame.host import stop_bytes
from turtlewire.protocols.frame.message import MAX_FRAME, MAX_PAYLOAD

from .board import Board
from .test_frame_robot import BUMPER, DIALECT, PWM

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from .conftest import Build

BYTE_S = 10.0 / DIALECT.baud
DRIVING = bytes.fromhex("01 00 C8 02 01 96")
# Every kind of message alone, none, as many of one kind as fit, and payloads that look like frames; A3 at every
# place of a message, and as the number and the CRC.
PAYLOADS = [
    b"",
    *(bytes([entry.type, 1, 0xA3]) for entry in DIALECT.entries if entry.goes(TO_ROBOT)),
    *(bytes([entry.type, 0, 0xFF]) * 41 for entry in DIALECT.entries if entry.goes(TO_ROBOT)),
    bytes.fromhex("01 01 A3") * 41,
    b"\xa3" * MAX_PAYLOAD,
    bytes.fromhex("A3 00 03 01 00 FF") * 20,
]
# The host's own number, on either side of those that its stop steers clear of.
NUMBERS = (0, 1, 123, 124, 125, 162, 163, 164, 254, 255)


@pytest.fixture
def robot(built: Build) -> Iterator[Board]:
    """The cases follow one another without a reset."""
    with Board(built("FrameRobot").elf, DIALECT.baud) as board:
        board.press(BUMPER, 1)
        board.run(0.15)
        yield board
        assert board.overruns == 0


def check_engines(robot: Board, data: bytes, *speeds: int) -> None:
    """These bytes lead there, at the latest when two of the longest frames more could have come: it may look again."""
    robot.receive(data)
    robot.run(len(data) * BYTE_S)
    until_s = robot.now_s + 2 * MAX_FRAME * BYTE_S
    while [robot.pwm(pin) for pin in PWM] != [*speeds]:
        assert robot.now_s < until_s, data.hex(" ")
        robot.run(BYTE_S)


def check(robot: Board, begun: bytes, number: int) -> None:
    """From a robot that drives, left behind these bytes by a host that goes on with this number; then in step."""
    host = FrameEncoder(DIALECT)
    check_engines(robot, host.frame(DRIVING), 200, 150)
    host.seq = number
    check_engines(robot, begun + stop_bytes(host), 0, 0)
    check_engines(robot, host.frame(bytes.fromhex("01 01 0A")), 0, 10)


def beginnings(numbers: Iterable[int]) -> set[bytes]:
    """All beginnings of all frames with these payloads, right and with a wrong CRC, and of one that is too long."""
    found = set()
    for number in numbers:
        for payload in PAYLOADS:
            frame = frame_bytes(DIALECT, number, payload)
            found |= {frame[:count] for count in range(len(frame) + 1)}
            found.add(frame[:-1] + bytes([frame[-1] ^ 1]))
        found |= {
            bytes([0xA3, number, size]) + b"\xa3" * more
            for size in (124, 125, 255)
            for more in (0, 1, 123, 124)
        }
    return found


def test_from_within_any_frame(robot: Board) -> None:
    cases = sorted(beginnings([0xA3]))
    for at, begun in enumerate(cases):
        check(robot, begun, NUMBERS[at % len(NUMBERS)])
    assert len(cases) == 780


@pytest.mark.nightly
def test_from_within_any_frame_whatever_the_hosts_number(robot: Board) -> None:
    cases = sorted(beginnings([0, 0xA3]))
    for begun in cases:
        for number in NUMBERS:
            check(robot, begun, number)
    assert len(cases) == 1558
