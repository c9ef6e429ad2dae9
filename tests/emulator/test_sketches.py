"""What all sketches have alike: a rate and a watchdog as constants, a self-test, a stop at once, and little stack."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from turtlewire.protocols.frame.codec import FrameEncoder, frame_bytes
from turtlewire.protocols.simple.messages import MAX_WINDOW
from turtlewire.protocols.walter.messages import ATTENTION

from .board import Board
from .turtle import LEFT_STEP, pen

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from turtlewire.firmware import Built

    from .conftest import Build

from .test_frame_robot import BUMPER, DIALECT

FAST = 115200
BOOTED_S = 0.15
TICK_S = 1e-3
RATES = {"SimpleCar": "BAUD", "FrameRobot": "BAUD", "Walter": "BAUD_RATE", "WalterBasic": "BAUD_RATE"}
SKETCHES = sorted(RATES)
HIGH = {"Walter": (14, 15, 16, 17), "FrameRobot": (BUMPER,)}
# As far as the stack has reached down from the end of RAM, of 2,048 bytes: what was measured, and a tenth.
STACK_BYTES = {"SimpleCar": 35, "FrameRobot": 50, "Walter": 70, "WalterBasic": 55}


def frame(*payload: int) -> bytes:
    return frame_bytes(DIALECT, 0, bytes(payload))


# What sets a robot off for long, what it must stop at, what only says that the host is there (section 4), and what does
# not even say that.
DRIVE = {
    "car": ("SimpleCar", b"F200000", b"S000000", b"H100000", b"X000000"),
    "frame": (
        "FrameRobot",
        frame(1, 0, 200, 1, 1, 200),
        frame(1, 0, 0, 1, 1, 0),
        frame(),
        frame()[:-1] + b"\x00",
    ),
    "logo": ("Walter", b"F\xff\xff\rB\xff\xff\r", b"2\r ", b"\r", b"x\r"),
    "direct": ("Walter", b"2\rA", b" ", b"\r", b"Q\x00"),
    "basic-logo": ("WalterBasic", b"F\xff\xff\rB\xff\xff\r", b"2\r ", b"\r", b"x\r"),
    "basic-direct": ("WalterBasic", b"2\rA", b" ", b"\r", b"Q\x00"),
}


def power_on(built: Callable[..., Built], name: str, **constants: str) -> Board:
    board = Board(built(name, **{RATES[name]: str(FAST)}, **constants).elf, FAST)
    for pin in HIGH.get(name, ()):
        board.press(pin, 1)
    return board


def send(board: Board, data: bytes) -> None:
    board.receive(data)
    board.run(len(data) * 10.0 / FAST)


def is_moving(board: Board, name: str) -> bool:
    """Whether a motor has power, or makes steps: at the lowest of speeds in use here, one in half a millisecond."""
    if name in ("SimpleCar", "FrameRobot"):
        return bool(board.pwm(5) or board.pwm(6))
    before = len(board.edges(LEFT_STEP))
    board.run(2 * TICK_S)
    return len(board.edges(LEFT_STEP)) > before


@pytest.mark.parametrize("kind", DRIVE)
def test_a_stop_acts_within_one_control_tick(built: Build, kind: str) -> None:
    name, drive, stop, *_ = DRIVE[kind]
    with power_on(built, name) as board:
        board.run(BOOTED_S)
        for _ in range(20):
            send(board, drive)
            board.run(5.3 * TICK_S)
            assert is_moving(board, name)
            send(board, stop)
            board.run(TICK_S)
            assert not is_moving(board, name)
            send(board, ATTENTION if name.startswith("Walter") else b"")


@pytest.mark.parametrize("kind", DRIVE)
def test_the_watchdog_stops_what_nobody_feeds(built: Build, kind: str) -> None:
    """Section 4: off unless it is wanted; fed by whatever is valid, not by noise; and what waited does not go on."""
    name, drive, stop, feed, noise = DRIVE[kind]
    with power_on(built, name) as board:
        board.run(BOOTED_S)
        send(board, drive)
        board.run(1.0)
        assert is_moving(board, name)
    with power_on(built, name, WATCHDOG_MS="50") as board:
        board.run(BOOTED_S)
        send(board, drive)
        for _ in range(5):
            board.run(0.045)
            assert is_moving(board, name)
            send(board, feed)
        board.run(0.040)
        assert is_moving(board, name)
        send(board, noise)
        board.run(0.015)
        assert not is_moving(board, name)
        board.run(0.1)
        assert not is_moving(board, name)
        send(board, stop if name.startswith("Walter") else b"")
        if name.startswith("Walter"):
            send(board, b"1")
        send(board, drive)
        board.run(2 * TICK_S)
        assert is_moving(board, name)


@pytest.mark.parametrize("name", SKETCHES)
@pytest.mark.parametrize("baud", [9600, 115200])
def test_the_rate_is_a_constant(built: Build, name: str, baud: int) -> None:
    """As near as a chip at 16 MHz gets: the "115200" of an Uno is 117,647."""
    own = DIALECT.baud if name == "FrameRobot" else 9600
    with Board(built(name, **({} if baud == own else {RATES[name]: str(baud)})).elf, baud) as board:
        board.run(BOOTED_S)
        assert round(board.rate) == {9600: 9615, 115200: 117647}[baud]


def test_bits_are_as_long_as_the_rate_says(built: Build) -> None:
    """From the end of one byte to the end of the next, back to back: ten bits."""
    for baud, bit_us, constants in ((9600, 104.0, {}), (115200, 8.5, {"BAUD_RATE": "115200"})):
        with Board(built("Walter", **constants).elf, baud) as board:
            for pin in HIGH["Walter"]:
                board.press(pin, 1)
            board.run(BOOTED_S)
            board.receive(b"QL\r")
            board.run(0.1)
            times = [sent.time_s for sent in board.sent()]
            assert len(times) == 7
            assert (times[-1] - times[0]) / 60 * 1e6 == pytest.approx(bit_us, rel=0.01)


@pytest.mark.parametrize(("name", "lamp"), [("Walter", 13), ("FrameRobot", 13)])
def test_a_lamp_shows_that_it_lives(built: Build, name: str, lamp: int) -> None:
    with power_on(built, name) as board:
        board.run(BOOTED_S)
        on, off = board.edges(lamp)[-2:]
        assert (on.level, off.level) == (1, 0)
        assert off.time_s - on.time_s == pytest.approx(0.1, abs=0.002)


def test_the_pen_shows_that_it_lives(built: Build) -> None:
    """WalterBasic has no lamp: the pen goes down and up again."""
    with power_on(built, "WalterBasic") as board:
        board.run(0.25)
        downs = [down for _, down in pen(board)]
        assert downs[0] == 1
        assert downs[-1] == 0


def test_the_firmwares_share_of_a_round_trip_at_full_rate(built: Build) -> None:
    """Between the last byte's stop bit and the answer's start bit, at 115200."""
    with power_on(built, "SimpleCar") as board:
        board.run(BOOTED_S)
        shares = []
        for number in range(100):
            board.run(1e-3 + number * 11e-6)  # whatever its clocks are just about
            start_s = board.now_s
            board.receive(b"F%03d000" % number)
            board.run(1.2e-3)
            (answer,) = board.sent()
            shares.append(answer.time_s - 10.0 / board.rate - start_s - 7 * 10.0 / FAST)
        assert 0.0 < max(shares) <= 60e-6


def test_two_hundred_commands_at_full_rate(built: Build) -> None:
    """S9: two hundred, eight under way at any time, each answered; the next one goes out with each answer."""
    with power_on(built, "SimpleCar") as board:
        board.run(BOOTED_S)
        commands = [b"F%03d000" % number for number in range(200)]
        board.receive(b"".join(commands[:MAX_WINDOW]))
        replies = b""
        for command in [*commands[MAX_WINDOW:], *[b""] * MAX_WINDOW]:
            replies += board.reply()
            board.receive(command)
        assert replies == b"K" * 200
        assert board.pwm(5) == 199
        assert board.overruns == 0


def damaged(data: bytes) -> Iterator[bytes]:
    """Each bit flipped, each byte lost, and one added at each place."""
    for at in range(len(data)):
        yield data[:at] + data[at + 1 :]
        for bit in range(8):
            yield data[:at] + bytes([data[at] ^ 1 << bit]) + data[at + 1 :]
    for at in range(len(data) + 1):
        for byte in (0x00, 0x7C, 0xA3, 0xFF):
            yield data[:at] + bytes([byte]) + data[at:]


def test_a_damaged_byte_costs_its_frame_and_no_other(built: Build) -> None:
    """The one before it and the one behind it are carried out; the one itself as it is, or not at all."""
    with power_on(built, "FrameRobot") as board:
        board.run(BOOTED_S)
        cases = 0
        for between in damaged(frame(1, 0, 77)):
            encoder = FrameEncoder(DIALECT)
            send(board, frame(1, 0, 5, 1, 1, 5))
            board.run(TICK_S)
            assert (board.pwm(5), board.pwm(6)) == (5, 5)
            send(board, encoder.frame(bytes([1, 0, 20])) + between + encoder.frame(bytes([1, 1, 30])))
            send(board, b"".join(encoder.frame(b"") for _ in range(32)))  # F5: what it may wait for is there
            board.run(TICK_S)
            assert board.pwm(6) == 30, between.hex(" ")
            assert board.pwm(5) in (20, 77), between.hex(" ")
            cases += 1
        assert cases == 7 * 9 + 8 * 4


# What goes deepest: everything at once, in all modes, with answers.
LOADS = {
    "SimpleCar": b"H101000F128000XB255000L100000S000000" * 8,
    "FrameRobot": (frame(1, 0, 9, 0, 1, 9) + frame(*[1, 1, 200] * 41)) * 4,
    "Walter": b"V\xff\rPD\rHL\rE1\rQT\x01\x02\x03\x04\rCL\x00\x04\x00\x05\rQL\rHH\rQH\rPU\rC0\rQX\rQP\r",
    "WalterBasic": b"V\xff\rPD\rF\x00\x10\rR\x00\x05\rPU\rL\x00\x06\rB\x00\x07\r",
}


@pytest.mark.parametrize("name", SKETCHES)
def test_the_stack_stays_small(built: Build, name: str) -> None:
    with power_on(built, name) as board:
        board.run(BOOTED_S)
        send(board, LOADS[name])
        board.run(3.0)
        if name.startswith("Walter"):
            send(board, b"2\rG\xffAX.S,Z 1" + ATTENTION)
            board.run(0.3)
        program = built(name, **{RATES[name]: str(FAST)})
        depth = 2048 - program.ram_bytes - board.untouched_bytes
        assert 0 < depth <= STACK_BYTES[name]
        assert board.overruns == 0
