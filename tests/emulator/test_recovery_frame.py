"""F13 on the chip: left in the middle of any frame, the robot hears the stop that the host repeats, and is in step.

Also behind bytes that were made to keep it busy.
"""

from __future__ import annotations

import subprocess
from functools import cache
from typing import TYPE_CHECKING

import pytest

from turtlewire.protocols.frame.codec import Frame, FrameDecoder, FrameEncoder, frame_bytes
from turtlewire.protocols.frame.dialect import TO_ROBOT
from turtlewire.protocols.frame.host import stop_bytes
from turtlewire.protocols.frame.message import MAX_FRAME, MAX_PAYLOAD

from .board import Board
from .test_frame_robot import BUMPER, DIALECT, PWM

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

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
    bytes.fromhex("A3 7C 7C") * 41,
    bytes.fromhex("A3 A3 7C 7C") * 31,
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
    assert len(cases) == 1029


@pytest.mark.nightly
@pytest.mark.timeout(3600)
def test_from_within_any_frame_whatever_the_hosts_number(robot: Board) -> None:
    cases = sorted(beginnings([0, 0xA3]))
    for begun in cases:
        for number in NUMBERS:
            check(robot, begun, number)
    assert len(cases) == 2056


# --------------------------------------------------------------------- bytes that are made to keep the robot busy

RING_BYTES = 63  # of 64 that Arduino's core has between its interrupt and the sketch
# HardwareSerial: vtable, write error, two times, six registers and a flag; then the ring's head and tail.
RING_HEAD, SERIAL_BYTES = 2 + 2 + 4 + 4 + 6 * 2 + 1, 0x9D


@cache
def ring_address(program: Path) -> int:
    """Where the ring's head stands in RAM, its tail behind it."""
    symbols = subprocess.run(["avr-nm", "-S", program], capture_output=True, text=True, check=True).stdout
    (serial,) = (line.split() for line in symbols.splitlines() if line.endswith(" Serial"))
    assert int(serial[1], 16) == SERIAL_BYTES
    return (int(serial[0], 16) & 0xFFFF) + RING_HEAD


def false_frames() -> bytes:
    """128 bytes that seem a frame, within which begin as many others as can, all of which end by then: as long ones,
    and with sizes that make as much work, as fit."""
    out = bytearray()
    for at in range(0, MAX_FRAME, 4):
        sizes = [
            max((size for size in (124, 60, 28, 12, 4) if begin + size + 4 <= MAX_FRAME), default=0)
            for begin in (at, at + 1)
        ]
        out += bytes([0xA3, 0xA3, *sizes])
    return bytes(out)


# What is repeated; what comes before it, and then a silence, in seconds: it is given up (F5) as the rest arrives.
BUSY = {
    "a false start in three bytes": (bytes.fromhex("A3 7C 7C"), b"", 0.0),
    "two in four bytes": (bytes.fromhex("A3 A3 7C 7C"), b"", 0.0),
    "all end at once": (false_frames(), b"", 0.0),
    "all are given up at once": (bytes.fromhex("A3 A3 7C 7C"), false_frames()[:-1], 0.099),
    "then everything is carried out": (
        false_frames() + frame_bytes(DIALECT, 0, bytes.fromhex("01 00 C8 02 01 96") * 20),
        b"",
        0.0,
    ),
    "too long": (b"\xa3", b"", 0.0),
    "as short as can be": (bytes.fromhex("A3 00 00 A3"), b"", 0.0),
}


@pytest.mark.parametrize("name", BUSY)
def test_nothing_that_comes_at_full_rate_fills_the_ring(built: Build, name: str) -> None:
    pattern, before, pause_s = BUSY[name]
    program = built("FrameRobot").elf
    head = ring_address(program)
    with Board(program, DIALECT.baud) as robot:
        robot.press(BUMPER, 1)
        robot.run(0.15)
        host = FrameEncoder(DIALECT)
        check_engines(robot, host.frame(DRIVING), 200, 150)
        robot.receive(before)
        robot.run(len(before) * BYTE_S + pause_s)
        data = (pattern * 4096)[:4096] + stop_bytes(host)
        robot.receive(data)
        most = 0
        for _ in range(2 * len(data)):
            robot.run(BYTE_S / 2)
            most = max(most, (robot.peek(head) - robot.peek(head + 1)) % (RING_BYTES + 1))
        assert 0 < most < RING_BYTES
        assert robot.overruns == 0
        check_engines(robot, b"", 0, 0)
        check_engines(robot, host.frame(bytes.fromhex("01 01 0A")), 0, 10)


def test_what_keeps_it_busy_is_no_frame() -> None:
    """Else the robot would take it whole, and not look within."""
    for pattern in (BUSY["a false start in three bytes"][0], BUSY["two in four bytes"][0], false_frames()):
        decoder = FrameDecoder(DIALECT)
        assert not any(isinstance(item, Frame) for item in decoder.receive_data((pattern * 4096)[:4096]))
        assert decoder.statistics.wrong_crc > 1000
