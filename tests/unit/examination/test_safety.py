"""That nothing an examination sends before it knows the robot can set anything in motion: by exhaustion.

What a robot hears of a byte sent at another rate depends on the ratio of the rates alone, and changes only where a
moment at which its UART looks at the line passes an edge of it. Between these there are so many different ratios, and
no more. They are walked through one by one, for every kind of UART, with the project's own robot ends in every state
that they can be in, and with robots that boot at any moment. The numbers are those in docs/doctor.md.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise, product
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import pytest

from tests.unit.protocols.test_attention import SUBSETS, State, reachable, state_of, twin
from turtlewire.examination.plan import QUIET_S
from turtlewire.examination.probes import (
    BAUDS,
    BITS,
    DEAF_BELOW,
    FLUSH,
    LOGO_PROBE,
    MILD_PROBE,
    PULSES,
    SLOWEST_BAUD,
    byte_s,
    logo_probe,
    pause_s,
)
from turtlewire.links.uart import Receiver, image
from turtlewire.protocols.frame.codec import INTER_BYTE_S, FrameEncoder
from turtlewire.protocols.frame.dialect import SHIPPED, shipped
from turtlewire.protocols.frame.robot import Robot as FrameRobot
from turtlewire.protocols.message import Decoded
from turtlewire.protocols.simple.codec import decode, layouts
from turtlewire.protocols.simple.messages import LENGTH, Headlights, Stop
from turtlewire.protocols.simple.robot import Robot as Car
from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import ALL_GROUPS, CommandDecoder, Mode

if TYPE_CHECKING:
    from collections.abc import Iterator

PAGE = Path(__file__).parents[3] / "docs" / "doctor.md"

# ---------------------------------------------------------------- all ratios, all UARTs

# In the middle of a bit, or a sixteenth of a bit beside it: UARTs look at the line 16 times a bit.
SAMPLES = (7 / 16, 1 / 2, 9 / 16)
UARTS = [Receiver(*kind) for kind in product(SAMPLES, (True, False), (True, False))]
# The receiver's bit, in bits of the sender: below the least, it hears each bit of the sender as a byte or more, and
# nothing but pulses; above the greatest, nine bits are over before the middle of its start bit, and it hears nothing.
LEAST_BIT, GREATEST_BIT = 1 / 20, 21.0


@cache
def bits(sample: float) -> list[float]:
    """One length of the receiver's bit for each stretch of them in which everything is heard alike.

    It looks at the line ``n + sample`` of its bits after a fall; an edge is 1 to 9 of the sender's bits behind that.
    """
    limits = {
        edge / (n + sample)
        for edge in range(1, 10)
        for n in range(200)
        if LEAST_BIT < edge / (n + sample) < GREATEST_BIT
    }
    ends = [LEAST_BIT, *sorted(limits), GREATEST_BIT]
    # Two limits that are one, but for rounding, have nothing between them.
    return [(low + high) / 2 for low, high in pairwise(ends) if high - low > 1e-12]


class Ear(NamedTuple):
    """A UART that listens at a rate: its bit, in bits of the sender."""

    bit: float
    uart: Receiver

    def hears(self, byte: int) -> bytes:
        return heard(byte, self.bit, self.uart)


@cache
def heard(byte: int, bit: float, uart: Receiver) -> bytes:
    return image(bytes([byte]), 1.0 / bit, uart)


EARS = [Ear(bit, uart) for uart in UARTS for bit in bits(uart.sample)]
PULSE_IMAGES = frozenset(0xFF << shift & 0xFF for shift in range(9))
SENT = frozenset(FLUSH + LOGO_PROBE + MILD_PROBE)

STARTING_KEYS = frozenset(b"AaZz,.")
PEN_KEYS = frozenset(b"SsXx")
CAR_LETTERS = frozenset(b"FBLRSH")
MAGIC = 0xA3


def test_so_many_ratios() -> None:
    assert [len(bits(sample)) for sample in SAMPLES] == [901, 741, 901]
    assert len(EARS) == 4 * (901 + 741 + 901) == 10172


def test_below_and_above_these_there_is_nothing_else() -> None:
    for byte in SENT:
        for uart in UARTS:
            for ratio in (1 / LEAST_BIT, 33.0, 512.3, 1_000_000 / SLOWEST_BAUD):
                assert PULSE_IMAGES.issuperset(image(bytes([byte]), ratio, uart))
            assert image(bytes([byte]), 1 / GREATEST_BIT, uart) == b""


def test_bytes_are_so_far_apart_that_each_is_heard_alone() -> None:
    for baud in (*BAUDS, None):
        rate = BITS / byte_s(baud)
        for slowest in (SLOWEST_BAUD, 600, 1200, 4800, 9600, 115200):
            # A robot that is any slower than this part of it hears nothing at all.
            if slowest >= rate * DEAF_BELOW:
                assert pause_s(baud) > BITS / slowest
    assert all(not image(bytes([byte]), 0.99 * DEAF_BELOW) for byte in range(256))


def test_a_pulse_is_heard_as_a_pulse_and_who_hears_none_hears_nothing_else() -> None:
    deaf = 0
    for ear in EARS:
        of_pulses = [ear.hears(pulse[0]) for pulse in PULSES]
        assert PULSE_IMAGES.issuperset(b"".join(of_pulses))
        if not any(of_pulses):
            deaf += 1
            assert all(PULSE_IMAGES.issuperset(ear.hears(byte)) for byte in SENT)
    assert deaf == 1347


def test_what_the_bytes_can_be_heard_as() -> None:
    images = {byte: frozenset(b"".join(ear.hears(byte) for ear in EARS)) for byte in SENT}
    everything = frozenset().union(*images.values())
    # No letter of simple, whatever the ratio: no command of it can begin. No A3: no frame can.
    assert not everything & CAR_LETTERS
    assert MAGIC not in everything
    # One key that starts a motion, in one place.
    assert {
        chr(byte): bytes(images[byte] & STARTING_KEYS) for byte in SENT if images[byte] & STARTING_KEYS
    } == {"1": b"a"}
    # Those that move the pen of a robot in direct control.
    pens = {chr(byte): images[byte] & PEN_KEYS for byte in SENT if images[byte] & PEN_KEYS}
    lowers = frozenset(b"x")
    assert pens == {"\r": frozenset(b"sx"), "2": lowers, " ": lowers, "1": lowers, "q": lowers}


# ---------------------------------------------------------------- the rates that there are

# What robots may listen at: every rate that is tried, and others that are usual.
USUAL = sorted({*BAUDS, 300, 600, 14400, 28800, 31250, 74880, 76800, 460800, 921600, 2000000})
# How far two clocks may be apart.
TOLERANCE = 0.03


def start_ratios() -> list[float]:
    """Where ``1`` is heard as a key that starts a motion: the robot's rate in units of the sender's."""
    return [1 / ear.bit for ear in EARS if STARTING_KEYS & set(ear.hears(ord("1")))]


def test_at_no_usual_rate_is_a_key_heard_that_starts_a_motion() -> None:
    least, most = min(start_ratios()), max(start_ratios())
    assert 1.09 < least < most < 1.22
    pairs = list(product(BAUDS, USUAL))
    assert len(pairs) == 12 * 22 == 264
    near = [
        (tried, listening)
        for tried, listening in pairs
        if listening * (1 - TOLERANCE) < 1.22 * tried and listening * (1 + TOLERANCE) > 1.09 * tried
    ]
    assert near == [(230400, 250000)]
    # At which rates it is left out, and why: 250000 is 8.5 percent above 230400.
    assert [baud for baud in BAUDS if logo_probe(baud) == MILD_PROBE] == [250000, 230400, 500000, 1000000]
    assert b"1" not in MILD_PROBE


# ---------------------------------------------------------------- WALTER, from every state

MOVING = (
    m.StartForward, m.StartBackward, m.StartLeft, m.StartRight,
    m.Forward, m.Back, m.Left, m.Right, m.GoHome, m.TurnTo, m.GoTo, m.GoToX, m.GoToY,
)  # fmt: skip
PEN = (m.RaisePen, m.LowerPen, m.PenUp, m.PenDown)
SPEED = (m.MoveFaster, m.MoveSlower, m.TurnFaster, m.TurnSlower, m.SetMoveSpeed, m.SetTurnSpeed, m.SetSpeed)
HARMLESS = (m.EmptyLine, m.SelectDirect, m.SelectLogo, m.Stop, m.QueryPen)


class Step(NamedTuple):
    """What one byte does to a robot in a state."""

    state: State
    message: type[m.WalterMessage] | None


@cache
def steps(groups: frozenset[str]) -> dict[State, list[Step]]:
    """What every byte does in every state, by the robot's own decoder."""
    table: dict[State, list[Step]] = {}
    for state, path in reachable(groups).items():
        decoder = CommandDecoder(Mode.LOGO, groups)
        decoder.receive_data(path)
        table[state] = []
        for byte in range(256):
            after = twin(decoder)
            items = after.receive_data(bytes([byte]))
            messages = [type(item.message) for item in items if isinstance(item, Decoded)]
            assert len(messages) <= 1
            table[state].append(Step(state_of(after), messages[0] if messages else None))
    return table


Messages: TypeAlias = frozenset[type[m.WalterMessage]]


class Walters:
    """All robots of one kind, in every state at once."""

    def __init__(self, groups: frozenset[str]) -> None:
        self.steps = steps(groups)
        # One that boots meanwhile begins in one of these; which mode that is, nobody says (W7).
        self.booted = frozenset(state_of(CommandDecoder(mode, groups)) for mode in Mode)
        self._known: dict[tuple[frozenset[State], bytes], tuple[frozenset[State], Messages]] = {}

    def hear(self, states: frozenset[State], data: bytes) -> tuple[frozenset[State], Messages]:
        """Which states they are in after these bytes, those included that have just booted; and what was said."""
        if (states, data) not in self._known:
            after = states
            said: set[type[m.WalterMessage]] = set()
            for byte in data:
                each = [self.steps[state][byte] for state in after]
                after = frozenset(step.state for step in each)
                said.update(step.message for step in each if step.message is not None)
            self._known[states, data] = after | self.booted, frozenset(said)
        return self._known[states, data]


@cache
def sequences(probe: bytes) -> dict[tuple[bytes, ...], list[Ear]]:
    """All that can be heard of FLUSH and a probe, byte by byte; and by whom."""
    by_whom: dict[tuple[bytes, ...], list[Ear]] = {}
    for ear in EARS:
        by_whom.setdefault(tuple(ear.hears(byte) for byte in FLUSH + probe), []).append(ear)
    return by_whom


# One with everything, one that answers and no more, one with nothing; the others by night.
OFTEN = (ALL_GROUPS, frozenset("Q"), frozenset[str]())
KINDS = [pytest.param(groups, marks=() if groups in OFTEN else pytest.mark.nightly) for groups in SUBSETS]


@pytest.mark.parametrize("probe", [LOGO_PROBE, MILD_PROBE], ids=["logo", "mild"])
@pytest.mark.parametrize("groups", KINDS, ids=lambda groups: "".join(sorted(groups)) or "basic")
def test_no_walter_moves(groups: frozenset[str], probe: bytes) -> None:
    """From every state; cut off after every byte; sent again and again at any rates; and to one that boots."""
    robots = Walters(groups)
    begin = frozenset(robots.steps)
    assert robots.booted < begin
    started = 0
    for images, ears in sequences(probe).items():
        states = begin
        said: set[type[m.WalterMessage]] = set()
        for data in images:
            states, more = robots.hear(states, data)
            said |= more
        moving = said.intersection(MOVING)
        if moving:
            # The one place that test_at_no_usual_rate_... is about.
            started += 1
            assert moving == {m.StartForward}
            assert all(1.09 < 1 / ear.bit < 1.22 for ear in ears)
        assert said <= {*HARMLESS, *PEN, *SPEED, *moving}
    assert (len(sequences(probe)), started) == ((1374, 8) if probe == LOGO_PROBE else (952, 0))


# ---------------------------------------------------------------- simple, from every state

TABLE = layouts()
# A digit of each kind that matters to whether a number is at most 255, and a byte that is none.
DIGITS_AND_OTHERS = b"01256x"
LETTERS_AND_OTHERS = b"FBLRSHx\x00"


def pending() -> Iterator[bytes]:
    """What a robot may have of an unfinished command: every kind of it."""
    for size in range(LENGTH):
        for rest in product(DIGITS_AND_OTHERS, repeat=max(0, size - 1)):
            for letter in LETTERS_AND_OTHERS if size else (0,):
                yield bytes([letter, *rest][:size])


def test_pulses_are_no_part_of_any_command_of_simple() -> None:
    assert not PULSE_IMAGES & set(b"0123456789FBLRSH")


def test_a_car_is_set_in_motion_only_by_what_an_earlier_host_has_said_in_full() -> None:
    """S7's own limit: a command of which only positions are missing that mean nothing."""
    states = completed = moved = 0
    for before in pending():
        states += 1
        robot = Car()
        robot.receive_data(before)
        seven = bytes(sorted(PULSE_IMAGES))[:LENGTH]
        reaction = robot.receive_data(seven)
        assert len(reaction.replies) == 1
        digits = before[1:4]
        is_said = len(before) >= 4 and before[0] in b"FBLR" and digits.isdigit() and int(digits) <= 255
        moved += is_said
        completed += bool(reaction.actions)
        assert [action for action in reaction.actions if not isinstance(action, (Stop, Headlights))] == (
            [decode(before.ljust(LENGTH, b"0"), TABLE)] if is_said else []
        )
        # What it has now begins with a pulse: no command.
        assert robot.pending == seven[LENGTH - len(before) :]
        assert robot.receive_data(bytes(14)).actions == []
    assert states == 1 + 8 * (1 + 6 + 36 + 216 + 1296 + 7776)
    # Of these digits 2 * 25 numbers begin with 0 or 1, 3 * 5 with 20 to 22, and there are 250, 251, 252 and 255.
    assert moved == 4 * (50 + 15 + 4) * (1 + 6 + 36)
    assert completed > moved


def test_no_car_moves_that_has_heard_the_pulses_or_boots_meanwhile() -> None:
    proven = 0
    for images in sequences(LOGO_PROBE):
        flushed, probe = images[: len(FLUSH)], images[len(FLUSH) :]
        if b"".join(flushed):
            assert sum(map(bool, flushed)) >= LENGTH
        for begun in range(LENGTH):
            robot = Car()
            robot.receive_data(bytes(begun))
            assert robot.receive_data(b"".join(images)).actions == []
            robot = Car()
            robot.receive_data(bytes(begun))
            assert robot.receive_data(b"".join(probe)).actions == []
            proven += 1
        for start in range(len(images)):
            robot = Car()
            assert robot.receive_data(b"".join(images[start:])).actions == []
            proven += 1
    assert proven == 1374 * (7 + 23)


# ---------------------------------------------------------------- frame, from every state


MOVES = {
    "0.1": "engine_forward 0 200",
    "0.1-literal": "engine_forward 0 200",
    "telemetry": "set_wheel_speeds 300 300",
}


@pytest.mark.parametrize("name", SHIPPED)
def test_no_frame_robot_even_begins_a_frame(name: str) -> None:
    dialect = shipped(name)
    move = dialect.parse(MOVES[name])
    (long,) = FrameEncoder(dialect).encode([move] * 20)
    (short,) = FrameEncoder(dialect).encode([move])
    # With a whole frame within what was taken for the beginning of another, a robot finds it when it gives up the
    # other, and carries it out (F5): by its own clock, before anything is sent.
    hidden = b"\xa3\x00\x7c" + short + b"\x00"
    assert QUIET_S > 2 * INTER_BYTE_S
    everything = b"".join(b"".join(images) for images in sequences(LOGO_PROBE))
    for whole in (long, hidden):
        for cut in range(len(whole)):
            robot = FrameRobot(dialect)
            robot.receive_data(whole[:cut], 0.0)
            assert robot.next_timeout() < QUIET_S or not robot.pending
            robot.receive_data(b"", robot.next_timeout())
            heard_before = robot.heard
            assert robot.receive_data(everything, QUIET_S) == []
            assert (robot.pending, robot.heard) == (0, heard_before)


# ---------------------------------------------------------------- the page


def test_the_page_has_these_numbers() -> None:
    page = PAGE.read_text("utf-8")
    for number in ("10,172", "1,374", "952", "1,347"):
        assert number in page
