"""W7 and W8 on the chip, from every state that a parser can be in: stopped, nothing queued, in the mode wanted.

A robot's parser is within the letters of a line, so many bytes into the arguments of a form, before the RET of one,
behind a RET (which an LF may follow), or within a line that it drops; in direct control, behind a key or before the
byte of one. Every beginning of every command and key, and of what is none, brings it to all of them. Argument bytes it
must not look at: those that another parser would (RET, LF, letters, keys, zero) stand for all.
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import pytest

from turtlewire.protocols.message import KINDS
from turtlewire.protocols.walter.messages import ATTENTION, DIRECT_KEYS, EMERGENCY_STOP, LOGO_COMMANDS

from .board import Board
from .turtle import LEFT_AHEAD, LEFT_STEP, RIGHT_STEP

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from .conftest import Build

BAUD = 115200
BYTE_S = 10.0 / BAUD
ARGUMENTS = b"\x0d\x0a\x002 F\xff"
# No command, or no longer one; and as much of a line as is dropped at once.
NONE = (b"x", b"Px\n", b"F\x00\x00x", b"q\x0dx", *(b"x" * count for count in (62, 63, 64, 65)))
# A step takes 0.25 ms at this speed; a stop acts within one control tick, a millisecond.
FASTEST = b"V\xff\r"
TICK_S = 1e-3


@pytest.fixture(params=["Walter", "WalterBasic"])
def turtle(request: pytest.FixtureRequest, built: Build) -> Iterator[Board]:
    """A turtle at 115200 baud whose pen takes no time; the cases follow one another without a reset."""
    constants = {"BAUD_RATE": str(BAUD), "PEN_MS": "1"}
    with Board(built(request.param, **constants).elf, BAUD) as board:
        for pin in (14, 15, 16, 17):
            board.press(pin, 1)
        board.run(0.15)
        yield board
        assert board.overruns == 0


def send(turtle: Board, data: bytes) -> None:
    turtle.receive(data)
    turtle.run(len(data) * BYTE_S)


def made(turtle: Board) -> int:
    """Edges at a step pin so far: two for each step."""
    assert len(turtle.edges(LEFT_STEP)) == len(turtle.edges(RIGHT_STEP))
    return len(turtle.edges(LEFT_STEP))


def set_off(turtle: Board, *, direct: bool) -> None:
    """On its way, from Logo control; with more to come behind, or by a key that knows no end."""
    before = made(turtle)
    send(turtle, FASTEST + (b"2\rG\xffB\xffA" if direct else b"F\xff\xff\rB\x40\x00\r"))
    turtle.run(TICK_S)
    assert made(turtle) > before


def check_still(turtle: Board) -> None:
    """Within one control tick it stands, and goes on standing."""
    turtle.run(TICK_S)
    stood = made(turtle)
    turtle.run(2 * TICK_S)
    assert made(turtle) == stood


def check_logo_control(turtle: Board) -> None:
    """Half a millimetre is eight steps ahead, and none more: nothing else is queued."""
    before = made(turtle)
    send(turtle, FASTEST + b"F\x00\x01\r")
    for _ in range(10):  # it may wait for its pen first
        turtle.run(TICK_S)
        if made(turtle) == before + 16:
            break
    turtle.run(TICK_S)
    assert (made(turtle) - before, turtle.level(LEFT_AHEAD)) == (16, 1)


def check_direct_control(turtle: Board) -> None:
    """A key drives it, and another one stops it."""
    before = made(turtle)
    send(turtle, b"G\xffZ")
    turtle.run(TICK_S)
    assert made(turtle) > before
    assert turtle.level(LEFT_AHEAD) == 0
    send(turtle, b" ")
    check_still(turtle)


def check(turtle: Board, begun: bytes, *, direct: bool) -> None:
    """Attention, then the emergency stop, each from the same state."""
    set_off(turtle, direct=direct)
    send(turtle, begun + ATTENTION)
    check_still(turtle)
    check_logo_control(turtle)
    set_off(turtle, direct=direct)
    send(turtle, begun + EMERGENCY_STOP)
    check_still(turtle)
    check_direct_control(turtle)
    send(turtle, ATTENTION)
    check_logo_control(turtle)


def lines(values: Iterable[bytes]) -> set[bytes]:
    """Every beginning of every Logo command with arguments of these, as short as none; in both cases of letters."""
    found = set(NONE)
    for command in LOGO_COMMANDS:
        size = sum(KINDS[field.kind][0] for field in command.FIELDS)
        for letters in {command.LETTERS, command.LETTERS.lower()}:
            for some in values:
                line = letters + some[:size] + b"\r\n"
                found |= {line[:count] for count in range(len(line) + 1)}
    return found


def keys(values: Iterable[bytes]) -> set[bytes]:
    """Every key, in both cases, and those with a byte with and without it; and what is no key."""
    found = {*NONE, b"\r", b"\r\n"}
    for key in DIRECT_KEYS:
        for letter in {key.LETTERS, key.LETTERS.lower()}:
            found |= {letter, *(letter + some[:1] for some in values if key.FIELDS)}
    return found


# One value for all the bytes of a command; and every value at every place.
SAME = [bytes([value]) * 4 for value in ARGUMENTS]
ALL = [bytes(some) for some in product(ARGUMENTS[:5], repeat=4)] + SAME


def test_from_within_any_command_of_logo_control(turtle: Board) -> None:
    cases = sorted(lines(SAME))
    for begun in cases:
        check(turtle, begun, direct=False)
    assert len(cases) == 730


def test_from_within_any_key_of_direct_control(turtle: Board) -> None:
    cases = sorted(keys(SAME))
    for begun in cases:
        check(turtle, begun, direct=True)
    assert len(cases) == 61


@pytest.mark.nightly
def test_from_within_any_command_with_any_arguments(turtle: Board) -> None:
    cases = sorted(lines(ALL))
    for begun in cases:
        check(turtle, begun, direct=False)
    assert len(cases) == 9570
