"""The same bytes for the chip and for Python: the same answers, and the same done (hypothesis).

The turtles are compared with the simulated ones, FrameRobot with the robot's end of its protocol; the car has its test
beside its others. The streams are of a kind whose outcome does not hang on a millisecond: what stops a motion comes
when it is well under way, or over.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from turtlewire.protocols.frame.codec import Frame, FrameDecoder, frame_bytes
from turtlewire.protocols.frame.dialect import FROM_ROBOT
from turtlewire.protocols.frame.robot import Robot
from turtlewire.protocols.message import Decoded
from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import ReplyDecoder, encode
from turtlewire.simulator.walter import Settings, SimulatedWalter

from .board import Board
from .test_frame_robot import BUMPER, DIALECT, OCR1, PWM
from .turtle import drawing, pen

if TYPE_CHECKING:
    from .conftest import Build

BAUD = 115200
BYTE_S = 10.0 / BAUD


def examples(count: int) -> settings:
    """So many, as long as they take."""
    return settings(
        max_examples=count, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
    )


# ----------------------------------------------------------------------------------------------------- turtles

HORN, LAMP, SWITCHES = 8, 13, (14, 15, 16, 17)
# The pen and the self-test take a millisecond instead of a hundred.
FAST = {"BAUD_RATE": str(BAUD), "PEN_MS": "1"}
BOOTED_S = 0.003
# The chip needs a moment for each command that the simulator does not need.
COMMAND_S = 0.002
# For the servo's next pulse, and to hear the horn.
LOOK_S = 0.045


class Piece(NamedTuple):
    """Bytes, and when to go on: after so many seconds, or (None) when all that was begun is over."""

    data: bytes
    wait_s: float | None = None


def sixteen(low: int, high: int) -> st.SearchStrategy[bytes]:
    return st.integers(low, high).map(lambda value: value.to_bytes(2, "big", signed=low < 0))


def line(letters: str, *arguments: st.SearchStrategy[bytes]) -> st.SearchStrategy[bytes]:
    """A command, in one of the cases of letters (W2), with RET or RET LF (W1)."""
    shown = st.sampled_from([letters.encode(), letters.lower().encode()])
    ends = st.sampled_from([b"\r", b"\r\n"])
    return st.tuples(shown, *arguments, ends).map(b"".join)


SHORT = st.one_of(
    *(line(letter, sixteen(0, 12)) for letter in "FBLR"),
    *(line(letters) for letters in ("PU", "PD", "H0", "HL", "HH", "E1", "E0", "CR")),
    *(line(letters) for letters in ("QH", "QL", "QX", "QY", "QP")),
    line("V", st.integers(100, 255).map(lambda speed: bytes([speed]))),
    line("CH", sixteen(0, 20)),
    # A bearing is sharp only far away.
    line("QT", sixteen(6000, 9000), sixteen(-9000, 9000)),
)
# W6: no command at all; no letter of one, or the wrong byte where RET must be.
ILL_FORMED = st.one_of(
    st.sampled_from([b"\r", b"\r\n", b"F\x00\x10x\r", b"PX\r", b"Q\r", b"V\xff\x00\r", b"c?\r", b"E2\r"]),
    st.tuples(
        st.sampled_from([b"x", b"1", b"\x00", b"A", b"\xff"]), st.binary(max_size=8), st.just(b"\r")
    ).map(lambda parts: parts[0] + parts[1].replace(b"\r", b"\n") + parts[2]),
)
LINES = st.lists(SHORT | ILL_FORMED, min_size=1, max_size=6).map(lambda some: [Piece(b"".join(some))])
# Not C0: which way it looks at home, if it was all but there, hangs on a hundredth of a millimetre.
FAR = st.one_of(
    line("CL", sixteen(-20, 20), sixteen(-20, 20)),
    line("CX", sixteen(-20, 20)),
    line("CY", sixteen(-20, 20)),
).map(lambda data: [Piece(data)])
UNDER_WAY_S = 0.008
INTERRUPTED = st.tuples(
    st.sampled_from([b"F", b"B", b"R", b"L"]),
    st.lists(SHORT, max_size=3).map(b"".join),
    st.sampled_from([m.ATTENTION, m.EMERGENCY_STOP + b"1", b"2\r1", b"2\rx A1"]),
).map(lambda some: [Piece(some[0] + b"\x0f\xa0\r" + some[1], UNDER_WAY_S), Piece(some[2])])
SPEED = st.integers(100, 255).map(lambda speed: bytes([speed]))
KEYS = st.one_of(
    st.sampled_from([b"A", b"Z", b",", b".", b"a", b"z"]),
    st.sampled_from([b" ", b"D", b"C", b"F", b"V", b"S", b"X", b"d" * 9, b"v" * 9, b"\r", b"Q", b"\x00"]),
    st.tuples(st.sampled_from([b"G", b"B", b"g"]), SPEED).map(b"".join),
)
BY_HAND = st.lists(KEYS, min_size=1, max_size=5).map(
    lambda keys: [Piece(b"2\r"), *(Piece(key, UNDER_WAY_S) for key in keys), Piece(b" 1")]
)
# What turns far is dear: seldom.
KINDS = [*[LINES] * 12, *[INTERRUPTED] * 5, *[BY_HAND] * 5, FAR]
STREAMS = st.lists(st.sampled_from(KINDS).flatmap(lambda kind: kind), min_size=1, max_size=4).map(
    lambda some: [piece for pieces in some for piece in pieces]
)
ASK = [encode(query) for query in (m.QueryLocation(), m.QueryHeading(), m.QueryPen())]


def until_rest(robot: SimulatedWalter, piece: Piece) -> bytes:
    """What it says until it has gone on."""
    said = b""
    end_s = robot.now + len(piece.data) * BYTE_S + (piece.wait_s or 0.0)
    robot.write(piece.data)
    while robot.now < end_s or (piece.wait_s is None and robot.next_event() < math.inf):
        said += robot.read(
            max(end_s, robot.now if piece.wait_s is not None else min(robot.next_event(), 1e9))
        )
    return said


def values(said: bytes) -> list[tuple[str, list[int]]]:
    """What was said, as messages."""
    found = []
    for item in ReplyDecoder().receive_data(said):
        assert isinstance(item, Decoded), said.hex(" ")
        found.append((type(item.message).__name__, list(item.message.values())))
    return found


def check_near(here: bytes, there: bytes, tolerance: int) -> None:
    """The same answers, up to so many of their units."""
    found, wanted = values(here), values(there)
    assert [name for name, _ in found] == [name for name, _ in wanted]
    for (name, some), (_, others) in zip(found, wanted, strict=True):
        for a, b in zip(some, others, strict=True):
            off = (a - b + 180) % 360 - 180 if name in ("HeadingReply", "TowardsReply") else a - b
            assert abs(off) <= (0 if name == "PenReply" else tolerance), (name, some, others)


def check_turtle(built: Build, name: str, stream: list[Piece]) -> None:
    groups = frozenset("CQHE" if name == "Walter" else "")
    simulated = SimulatedWalter(Settings(baud=BAUD, groups=groups, pen_s=0.001))
    # When something was stopped on its way, a millisecond is a quarter of a millimetre, or of a degree.
    timed = sum(piece.wait_s is not None for piece in stream)
    tolerance = 1 + 2 * timed
    constants = FAST | ({"SELF_TEST_MS": "1"} if groups else {})
    with Board(built(name, **constants).elf, BAUD) as chip:
        for pin in SWITCHES:
            chip.press(pin, 1)
        chip.run(BOOTED_S)
        here = there = b""
        for piece in [Piece(b"V\xff\r"), *stream, Piece(m.ATTENTION), *(Piece(query) for query in ASK)]:
            start_s = simulated.now
            there += until_rest(simulated, piece)
            chip.receive(piece.data)
            spare_s = 0.0 if piece.wait_s is not None else (2 + piece.data.count(b"\r")) * COMMAND_S
            chip.run(simulated.now - start_s + spare_s)
            here += bytes(sent.byte for sent in chip.sent())
        chip.run(LOOK_S)
        check_near(here, there, tolerance)
        pose = drawing(chip).pose
        near_mm = 0.1 + 0.6 * timed
        assert pose[:2] == pytest.approx(simulated.pose[:2], abs=near_mm)
        off_deg = (pose.heading_deg - simulated.pose.heading_deg + 180.0) % 360.0 - 180.0
        assert abs(off_deg) <= 0.1 + 0.6 * timed
        assert pen(chip)[-1][1] == simulated.pen_is_down
        assert chip.level(LAMP) == simulated.lamp
        heard = sum(edge.time_s > chip.now_s - LOOK_S for edge in chip.edges(HORN))
        assert round(heard / LOOK_S / 880) == {"off": 0, "low": 1, "high": 2}[simulated.horn]
        assert chip.overruns == 0


@pytest.mark.parametrize("name", ["Walter", "WalterBasic"])
@given(STREAMS)
@examples(60)
def test_a_turtle_does_what_the_simulated_one_does(built: Build, name: str, stream: list[Piece]) -> None:
    check_turtle(built, name, stream)


@pytest.mark.nightly
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", ["Walter", "WalterBasic"])
@given(STREAMS)
@examples(10_000)
def test_ten_thousand_streams_do(built: Build, name: str, stream: list[Piece]) -> None:
    check_turtle(built, name, stream)


# ------------------------------------------------------------------------------------------------- FrameRobot

DIRECTIONS = (7, 8)
TYPES = st.sampled_from([0x00, 0x01, 0x02])
NUMBERS = st.sampled_from([0, 1, 2, 0xA3])
VALUES = st.sampled_from([0, 1, 90, 180, 181, 0xA3, 255]) | st.integers(0, 255)
MESSAGES = st.tuples(TYPES, NUMBERS, VALUES).map(bytes)
PAYLOADS = st.one_of(
    st.lists(MESSAGES, max_size=8).map(b"".join),
    st.lists(MESSAGES, min_size=38, max_size=41).map(b"".join),
    st.tuples(
        st.lists(MESSAGES, max_size=3).map(b"".join), st.sampled_from([b"\x77", b"\x01", b"\x01\x00"])
    ).map(b"".join),
)
FRAMES = st.builds(
    lambda number, payload: frame_bytes(DIALECT, number, payload), st.integers(0, 255), PAYLOADS
)
DAMAGED = st.builds(
    lambda frame, at, value: frame[: at % len(frame)] + bytes([value]) + frame[at % len(frame) + 1 :],
    FRAMES,
    st.integers(0, 127),
    st.integers(0, 255),
)
CUT = st.builds(lambda frame, at: frame[: at % len(frame)], FRAMES, st.integers(0, 127))
NOISE = st.binary(max_size=6) | st.sampled_from([b"\xa3", b"\xa3" * 9, b"\xa3\x00\x7c", b"\xa3\x00\x7d"])
# A pause that is too short for what was begun to be given up, and one that is not (F5).
PAUSES_S = st.sampled_from([0.0, 0.0, 0.0, 0.0, 0.0, 0.06, 0.15])
FRAME_STREAMS = st.lists(st.tuples(st.one_of(FRAMES, FRAMES, DAMAGED, CUT, NOISE), PAUSES_S), max_size=8)
# Longer than it takes to look through all that was kept.
LOOK_AGAIN_S = 0.02


class Machine:
    """What the messages do to the pins, in Python."""

    def __init__(self) -> None:
        self.engines = [0, 0]
        self.servos = [90, 90]

    @property
    def state(self) -> tuple[list[int], list[int]]:
        """Engines, and the servos as their timer has them: half a microsecond a tick."""
        return self.engines, [999 + degrees * 4000 // 180 for degrees in self.servos]

    def carry_out(self, what: str, number: int, value: int) -> None:
        match what:
            case "SetServoPosition":
                self.servos[number] = value
            case "EngineForward":
                self.engines[number] = value
            case "EngineBackward":
                self.engines[number] = -value


def seen(chip: Board) -> tuple[list[int], list[int]]:
    """Engines and servos, as the pins and the servos' timer show them."""
    engines = [
        chip.pwm(pwm) * (1 if chip.level(direction) else -1)
        for pwm, direction in zip(PWM, DIRECTIONS, strict=True)
    ]
    return engines, [chip.peek(at) + 256 * chip.peek(at + 1) for at in OCR1]


def wait_for(chip: Board, machine: Machine) -> None:
    """Until it has come to what Python says, which may take it some looking again."""
    until_s = chip.now_s + LOOK_AGAIN_S
    while seen(chip) != machine.state:
        assert chip.now_s < until_s, (seen(chip), machine.state)
        chip.run(4 * BYTE_S)


def check_frame_robot(built: Build, stream: list[tuple[bytes, float]]) -> None:
    robot, machine = Robot(DIALECT), Machine()
    with Board(built("FrameRobot").elf, DIALECT.baud) as chip:
        chip.press(BUMPER, 1)
        chip.run(BOOTED_S)
        for data, pause_s in stream:
            for message in robot.receive_data(data, chip.now_s + len(data) * BYTE_S):
                machine.carry_out(type(message).__name__, *map(int, message.values()))
            chip.receive(data)
            chip.run(len(data) * BYTE_S)
            wait_for(chip, machine)
            chip.run(pause_s)
            for message in robot.receive_data(b"", chip.now_s):
                machine.carry_out(type(message).__name__, *map(int, message.values()))
            wait_for(chip, machine)
        chip.run(0.11)
        for message in robot.receive_data(b"", chip.now_s):
            machine.carry_out(type(message).__name__, *map(int, message.values()))
        assert seen(chip) == machine.state
        check_telemetry(bytes(sent.byte for sent in chip.sent()))
        assert chip.overruns == 0


def check_telemetry(said: bytes) -> None:
    """Whatever came: a status ten times a second, each in a frame, none missing."""
    decoder = FrameDecoder(DIALECT, FROM_ROBOT)
    frames = decoder.receive_data(said)
    assert frames
    assert all(isinstance(frame, Frame) for frame in frames)
    times = [frame.messages[0].values()[0] for frame in frames if isinstance(frame, Frame)]
    # It looks through what it has kept before it tells.
    assert all(90 <= after - before <= 110 for before, after in pairwise(times))
    assert decoder.statistics.lost == 0  # one more may be under way


@given(FRAME_STREAMS)
@examples(60)
def test_frame_robot_does_what_python_says(built: Build, stream: list[tuple[bytes, float]]) -> None:
    check_frame_robot(built, stream)


@pytest.mark.nightly
@pytest.mark.timeout(3600)
@given(FRAME_STREAMS)
@examples(10_000)
def test_frame_robot_does_so_ten_thousand_times(built: Build, stream: list[tuple[bytes, float]]) -> None:
    check_frame_robot(built, stream)
