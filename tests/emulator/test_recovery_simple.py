"""S7 on the chip, from every state that a robot can be in, and after every single byte that a line can damage.

What a robot makes of seven bytes hangs on few things: which letter the first is (by its form: a number, four digits,
nothing, or none at all), whether the bytes at 1 to 3 (for headlights 1 to 4) are digits, and whether 1 to 3 make a
number above 255; the bytes at 5 and 6 it never looks at. So the alphabets below stand for all bytes: digits on either
side of those of 255, and each time something that is no digit. The host's own S is one of those.
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import pytest

from turtlewire.protocols.simple.robot import Robot

from .board import Board

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from .conftest import Build

BAUD = 115200
LETTERS = b"FBLRSHf\x00"
POSITIONS = (b"023-", b"056/", b"056:", b"01A", b"0\xff", b"0S")
DRIVE, STEER = 5, 6
BYTE_S = 10.0 / BAUD
# The firmware's share is below 60 us (there is a test of that); the rest is the answer's own time on the wire.
PATIENCE_S = 3 * BYTE_S
DRIVING = b"F201000L102000"
# A joystick's: what a damaged byte turns into another command, or into one too many or too few.
SEQUENCE = b"F200000R090000H101000B050000S000000F120000"
# One for each thing that a robot may take a byte for.
SOME_BYTES = b"FBLRSHf0259-\x00\xff"


@pytest.fixture
def car(built: Build) -> Iterator[Board]:
    """A car at 115200 baud; the cases follow one another without a reset, each from where the last one ended."""
    with Board(built("SimpleCar", BAUD=str(BAUD), SELF_TEST="false").elf, BAUD) as board:
        board.run(0.01)
        yield board
        assert board.overruns == 0


def send(car: Board, data: bytes) -> bytes:
    """What it answers until all has arrived, and a little longer."""
    car.receive(data)
    car.run(len(data) * BYTE_S + PATIENCE_S)
    return bytes(sent.byte for sent in car.sent())


def pwm(car: Board, pin: int) -> int:
    """Drive or steering, by the pins of the motor driver: PWM, and direction two pins further."""
    return car.pwm(pin) if car.level(pin + 2) else -car.pwm(pin)


def recover(car: Board) -> int:
    """S7, as the host does it; how many S it took to an answer."""
    for spent in range(1, 8):
        car.receive(b"S")
        reply = car.reply(1, BYTE_S + PATIENCE_S)
        if reply:
            assert reply in (b"K", b"F")
            assert send(car, b"S000000") == b"K"
            return spent
    raise AssertionError("seven S and no answer")


def check_recovery(car: Board, pending: int) -> None:
    """In step after as many S as were missing, and it stands: the motors are off and stay off."""
    assert recover(car) == 7 - pending
    assert (car.pwm(DRIVE), car.pwm(STEER)) == (0, 0)


def begun(letters: bytes, positions: Iterable[bytes]) -> Iterator[bytes]:
    """Every beginning of a command, of none to six bytes, over these alphabets."""
    alphabets = [letters, *positions][:6]
    for count in range(7):
        yield from (bytes(some) for some in product(*alphabets[:count]))


def check_from(car: Board, states: Iterable[bytes]) -> int:
    cases = 0
    for state in states:
        assert send(car, DRIVING) == b"KK"
        assert (car.pwm(DRIVE), car.pwm(STEER)) == (201, 102)
        assert send(car, state) == b""
        check_recovery(car, len(state))
        cases += 1
    return cases


def test_from_within_any_command_at_all(car: Board) -> None:
    """S7: from every state that there is, up to which of two bytes of a kind it is."""
    assert check_from(car, begun(LETTERS, POSITIONS)) == 1 + 8 * (1 + 4 + 16 + 64 + 192 + 384)


def damaged(data: bytes, values: Iterable[int]) -> Iterator[bytes]:
    """Each way to lose, change or add one byte."""
    alphabet = list(values)
    for at in range(len(data)):
        yield data[:at] + data[at + 1 :]
        yield from (data[:at] + bytes([value]) + data[at + 1 :] for value in alphabet if value != data[at])
    for at in range(len(data) + 1):
        yield from (data[:at] + bytes([value]) + data[at:] for value in alphabet)


def check_damaged(car: Board, values: Iterable[int]) -> int:
    cases = 0
    for data in damaged(SEQUENCE, values):
        robot = Robot()
        robot.receive_data(b"S000000")
        assert send(car, data) == robot.receive_data(data).replies
        assert (pwm(car, DRIVE), pwm(car, STEER)) == (robot.drive, robot.steer)
        check_recovery(car, len(robot.pending))
        cases += 1
    return cases


def test_after_any_damaged_byte(car: Board) -> None:
    """One byte lost, changed or added anywhere: the answers are Python's, and S7 ends it."""
    assert check_damaged(car, SOME_BYTES) == 42 + (42 * 14 - 39) + 43 * 14


@pytest.mark.nightly
def test_after_any_damaged_byte_of_any_value(car: Board) -> None:
    """The same with all 256 bytes there are."""
    assert check_damaged(car, range(256)) == 42 + 42 * 255 + 43 * 256
