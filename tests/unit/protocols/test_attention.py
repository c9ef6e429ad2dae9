"""W7 and W8, proven by exhaustion: from every state a parser can be in, the sequence ends where it must.

Two proofs. The first walks the *bytes*: every prefix of every command in both modes with every choice of argument
bytes that could be mistaken for something. The second walks the decoder's *states*: a search over all bytes from
reset, so that no state is missed by the first. The numbers of cases are computed by hand, in comments, and asserted.
"""

from __future__ import annotations

from collections import deque
from functools import cache
from itertools import combinations, product
from typing import TYPE_CHECKING, NamedTuple

import pytest

from turtlewire.protocols.message import Decoded
from turtlewire.protocols.walter.codec import ALL_GROUPS, MAX_RAW, CommandDecoder, Mode
from turtlewire.protocols.walter.messages import (
    ATTENTION,
    DIRECT_KEYS,
    EMERGENCY_STOP,
    LOGO_COMMANDS,
    EmptyLine,
    Forward,
    SelectDirect,
    SelectLogo,
    SetMoveSpeed,
    SetTurnSpeed,
    StartBackward,
    StartForward,
    StartLeft,
    StartRight,
    Stop,
    WalterMessage,
)
from turtlewire.protocols.walter.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

BASIC: frozenset[str] = frozenset()
QUEUE = bytes.fromhex("46 00 64 0D 52 00 5A 0D 42 0D 0A 0D")  # forward 50 mm, right 90, back 1669 mm
STARTS = (StartForward, StartBackward, StartLeft, StartRight)

STARTS_OR_STOPS = (*STARTS, Stop)
NOT_MOVING = {SelectDirect, SelectLogo, EmptyLine, Stop}

# What each sequence says, written out from the source's tables rather than taken from the package.
W7 = bytes([0, 0, 0, 0, 0, 0x0D, ord("2"), 0x0D, ord(" "), ord("1"), 0x0D])
W8 = bytes([0, 0, 0, 0, 0, 0x0D, ord("2"), 0x0D, ord(" ")])


class Sequence(NamedTuple):
    """A sequence, the mode that it must end in, and what it must say to each mode, message by message."""

    data: bytes
    mode: Mode
    logo: tuple[WalterMessage, ...]
    direct: tuple[WalterMessage, ...]


SEQUENCES = {
    "attention": Sequence(
        W7,
        Mode.LOGO,
        (SelectDirect(), Stop(), SelectLogo(), EmptyLine()),
        (EmptyLine(), EmptyLine(), Stop(), SelectLogo(), EmptyLine()),
    ),
    "emergency stop": Sequence(W8, Mode.DIRECT, (SelectDirect(), Stop()), (EmptyLine(), EmptyLine(), Stop())),
}
each_sequence = pytest.mark.parametrize("sequence", SEQUENCES.values(), ids=SEQUENCES.keys())


def test_the_sequences_are_those_of_the_protocol() -> None:
    assert W7 == ATTENTION
    assert W8 == EMERGENCY_STOP


def is_moving(actions: Iterable[WalterMessage], before: bool) -> bool:
    """Whether direct motion or a Logo command's motion runs after these actions."""
    moving = before
    for action in actions:
        if isinstance(action, STARTS):
            moving = True
        elif isinstance(action, (Stop, SelectDirect, SelectLogo)):
            moving = False
    return moving


def twin(decoder: CommandDecoder) -> CommandDecoder:
    """Another decoder in the same state."""
    other = object.__new__(CommandDecoder)
    vars(other).update(vars(decoder))
    other._raw = bytearray(decoder._raw)
    return other


def prove(sequence: Sequence, robot: Robot, where: str) -> None:
    """From the state that ``robot`` is in: the sequence ends as stated, and none of its bytes starts a motion."""
    begun_in = robot.mode
    items = twin(robot._decoder).receive_data(sequence.data)  # what each byte of the sequence completes
    said = [item.message for item in items if isinstance(item, Decoded)]
    actions = robot.receive_data(sequence.data)
    assert actions == [message for message in said if type(message) is not EmptyLine], where
    if begun_in is Mode.LOGO:
        assert tuple(said) == sequence.logo, where
    else:
        if isinstance(said[0], (SetMoveSpeed, SetTurnSpeed)):
            assert said.pop(0).values() == (0,), where  # the zero that a pending speed takes
        assert tuple(said) == sequence.direct, where
    # No byte completed a command that moves: neither a direct key nor one for the queue.
    assert NOT_MOVING.issuperset(map(type, said)), where
    # A motion that ran before, of either mode, has been ended.
    assert not is_moving(actions, before=True), where
    assert [a for a in actions if isinstance(a, STARTS_OR_STOPS)] == [Stop()], where
    assert robot.mode is sequence.mode, where
    assert (robot.queued, robot.next_command()) == (0, None), where
    assert robot._decoder.pending == 0, where
    # And the robot is all ears: the next command is understood.
    if sequence.mode is Mode.LOGO:
        assert robot.receive_data(b"\nF\x00\xc8\r") == [], where
        assert robot.next_command() == Forward(200), where
    else:
        assert robot.receive_data(b"A") == [StartForward()], where


def robot_after(
    prefix: bytes, mode: Mode = Mode.LOGO, groups: frozenset[str] = ALL_GROUPS, before: bytes = b""
) -> Robot:
    robot = Robot(mode, groups)
    robot.receive_data(before)
    robot.receive_data(prefix)
    return robot


# ------------------------------------------------------------------------------- by bytes: every cut-off command

# What argument bytes may be mistaken for: 00, RET, LF, stop, both mode changes, no byte of a text, and the letters and
# keys that begin motions.
LARGE = bytes.fromhex("00 0D 0A 20 31 32 FF") + b"FBLRCAZ,."  # 7 + 9 = 16
SMALL = bytes.fromhex("00 0D 0A 20 31 46")  # 6

# The tables of the source, by hand: letters -> argument bytes.
NO_ARGUMENTS = ("2", "PU", "PD", "H0", "HL", "HH", "E1", "E0", "CR", "C0", "QH", "QL", "QX", "QY", "QP")  # 15
ARGUMENTS = {"V": 1, "F": 2, "B": 2, "L": 2, "R": 2, "CH": 2, "CX": 2, "CY": 2, "CL": 4, "QT": 4}
KEYS = " 1AZDCFVSXGB,."  # 14; G and B take a byte


def logo_prefixes() -> Iterator[bytes]:
    """Every command cut off after every byte, and whole with RET; the empty state last."""
    for first in "PHECQ":
        yield first.encode()
    for letters in NO_ARGUMENTS:
        yield letters.encode()
        yield letters.encode() + b"\r"
    for letters, size in ARGUMENTS.items():
        for taken in range(size + 1):
            for arguments in product(LARGE if size <= 2 else SMALL, repeat=taken):
                yield letters.encode() + bytes(arguments)
                if taken == size:
                    yield letters.encode() + bytes(arguments) + b"\r"
    yield b""
    yield b"\r"


# 5 first letters
# 15 without arguments:                     cut 15, whole 15
# V:                                        cut 1 + 16 = 17, whole 16
# F B L R CH CX CY (7):                     cut 1 + 16 + 256 = 273, whole 256
# CL QT (2):                                cut 1 + 6 + 36 + 216 + 1296 = 1555, whole 1296
# empty, and after an empty line:           2
# 5 + 30 + 33 + 7 * 529 + 2 * 2851 + 2 = 9475
LOGO_PREFIXES = 9475


def test_the_tables_here_are_the_protocols() -> None:
    ours = {*NO_ARGUMENTS, *ARGUMENTS, ""}
    assert ours == {command.LETTERS.decode() for command in LOGO_COMMANDS}
    assert set(KEYS) == {key.LETTERS.decode() for key in DIRECT_KEYS}
    assert len(KEYS) == 14


@each_sequence
@pytest.mark.parametrize("groups", [ALL_GROUPS, BASIC], ids=["full", "basic"])
def test_from_every_prefix_of_every_logo_command(sequence: Sequence, groups: frozenset[str]) -> None:
    proven = 0
    for n, prefix in enumerate(logo_prefixes()):
        # With a queue and without one by turns; each state with both in the next test.
        robot = robot_after(prefix, groups=groups, before=QUEUE if n % 2 else b"")
        prove(sequence, robot, prefix.hex(" "))
        proven += 1
    assert proven == LOGO_PREFIXES


@each_sequence
@pytest.mark.parametrize("queue", [b"", QUEUE], ids=["idle", "queue"])
@pytest.mark.parametrize("lower", [False, True], ids=["upper", "lower"])
def test_from_every_prefix_in_either_case_with_and_without_a_queue(
    sequence: Sequence, queue: bytes, lower: bool
) -> None:
    proven = 0
    prefixes = [b"", *(first.encode() for first in "PHECQ")]
    prefixes += [letters.encode() for letters in NO_ARGUMENTS]
    prefixes += [
        letters.encode() + bytes([byte]) * taken
        for letters, size in ARGUMENTS.items()
        for taken in range(size + 1)
        for byte in SMALL
    ]
    for prefix in prefixes:
        robot = robot_after(prefix.lower() if lower else prefix, before=queue)
        assert (robot.mode, robot.queued) == (Mode.LOGO, 3 if queue else 0)
        prove(sequence, robot, prefix.hex(" "))
        proven += 1
    # 1 + 5 + 15, and 6 for each argument position: V 2, seven times 3, twice 5 positions
    assert proven == 21 + 6 * (2 + 7 * 3 + 2 * 5)


def direct_prefixes() -> Iterator[bytes]:
    """Nothing, every single byte (keys, half keys and bytes that are no key), and both speeds with every byte."""
    yield b""
    for byte in range(256):
        yield bytes([byte])
    for key in b"GBgb":
        for byte in range(256):
            yield bytes([key, byte])


@each_sequence
@pytest.mark.parametrize("motion", [b"", b"A", b"Z", b",", b"."])
def test_from_every_prefix_in_direct_control(sequence: Sequence, motion: bytes) -> None:
    proven = 0
    for prefix in direct_prefixes():
        robot = robot_after(prefix, Mode.DIRECT, before=motion)
        assert robot.queued == 0  # nothing can be queued in direct control
        prove(sequence, robot, prefix.hex(" "))
        proven += 1
    assert proven == 1 + 256 + 4 * 256


@each_sequence
@pytest.mark.parametrize("queue", [b"", QUEUE], ids=["idle", "queue"])
def test_from_every_length_of_a_dropped_line(sequence: Sequence, queue: bytes) -> None:
    lines = [
        b"?" + bytes([byte]) * n for byte in (0x00, 0x0A, 0x20, 0x31, 0x46) for n in range(2 * MAX_RAW + 3)
    ]
    for line in lines:
        prove(sequence, robot_after(line, before=queue), f"{len(line)} bytes of {line[-1]:02X}")
    assert len(lines) == 5 * 131


# ------------------------------------------------------------------------- by states: nothing else can be reached


class State(NamedTuple):
    """All of a decoder that decides what it does next; the values of argument bytes do not."""

    mode: Mode
    letters: bytes  # in upper case; empty while a line is dropped
    arguments: int  # how many argument bytes have been taken
    dropping: int  # 1 + bytes kept of a line that is being dropped, or 0
    lf_skipped: bool  # RET was the last byte: one LF would be skipped


def state_of(decoder: CommandDecoder) -> State:
    raw, form = decoder._raw, decoder._form
    dropping = 1 + len(raw) if decoder._reason else 0
    size = 0 if dropping else len(form.message_type.LETTERS) if form else len(raw)
    letters = bytes(raw[:size]).upper()
    taken = 0 if dropping else len(raw) - size
    return State(decoder.mode, letters, taken, dropping, decoder._may_skip_lf)


# Argument bytes by which representatives of one state differ.
TELLING = frozenset(SMALL + b"\x01\xff")


@cache
def reachable(groups: frozenset[str]) -> dict[State, bytes]:
    """Every state that bytes can lead to from either power-on mode, and the shortest bytes that lead there.

    Bytes are those after power-on in Logo control. A state is explored once for each telling last byte that led
    to it, and must behave alike each time: that is what entitles ``State`` to forget the values of arguments.
    """
    paths: dict[State, bytes] = {}
    behaviour: dict[State, tuple[State, ...]] = {}
    explored: set[tuple[State, int]] = set()
    start = CommandDecoder(Mode.LOGO, groups)
    paths[state_of(start)] = b""
    todo = deque([(b"", start)])
    while todo:
        path, decoder = todo.popleft()
        before = state_of(decoder)
        after = []
        for byte in range(256):
            follower = twin(decoder)
            follower.receive_data(bytes([byte]))
            state = state_of(follower)
            after.append(state)
            new = state not in paths
            paths.setdefault(state, path + bytes([byte]))
            # A dropped line's bytes are never looked at again: one representative each.
            telling = byte in TELLING and state.arguments > 0
            if new or (telling and (state, byte) not in explored):
                explored.add((state, byte))
                todo.append((path + bytes([byte]), follower))
        assert behaviour.setdefault(before, tuple(after)) == tuple(after), (before, path)
    return paths


# Logo control, every robot:
#   between commands 2 (after RET or not); letters: P 1; 2 1; F B L R 4 * 3; V 2; PU PD 2; dropping 0..63 kept 64
# direct control: between keys 2, G 1, B 1
EVERY_ROBOT = 2 + 1 + 1 + 12 + 2 + 2 + 64 + 4
GROUP_STATES = {
    "C": 1 + 2 + 3 * 3 + 5,  # C; CR C0; CH CX CY with 0..2 bytes; CL with 0..4
    "Q": 1 + 5 + 5,  # Q; QH QL QX QY QP; QT with 0..4
    "H": 1 + 3,  # H; H0 HL HH
    "E": 1 + 2,  # E; E1 E0
}
SUBSETS = [frozenset(subset) for n in range(5) for subset in combinations("CEHQ", n)]


def test_the_states_are_as_many_as_counted_by_hand() -> None:
    assert len(SUBSETS) == 16
    assert EVERY_ROBOT == 88
    assert EVERY_ROBOT + sum(GROUP_STATES.values()) == 123


@pytest.mark.parametrize("groups", SUBSETS, ids=lambda groups: "".join(sorted(groups)) or "basic")
def test_from_every_state_that_bytes_can_lead_to(groups: frozenset[str]) -> None:
    paths = reachable(groups)
    assert len(paths) == EVERY_ROBOT + sum(GROUP_STATES[group] for group in groups)
    for state, path in paths.items():
        for sequence in SEQUENCES.values():
            for queue in (b"", QUEUE):
                robot = robot_after(path, groups=groups, before=queue)
                assert state_of(robot._decoder) == state or path == b""  # a queue ends with RET
                prove(sequence, robot, path.hex(" "))


def test_the_prefixes_miss_no_state() -> None:
    walked = set()
    for prefix in logo_prefixes():
        walked.add(state_of(robot_after(prefix)._decoder))
    for prefix in direct_prefixes():
        walked.add(state_of(robot_after(prefix, Mode.DIRECT)._decoder))
    for kept in range(MAX_RAW):
        walked.add(state_of(robot_after(b"?" * (kept or MAX_RAW))._decoder))
    assert walked == set(reachable(ALL_GROUPS))


# ------------------------------------------------------------------------------ a host that is interrupted itself


@each_sequence
@pytest.mark.parametrize("groups", [ALL_GROUPS, BASIC], ids=["full", "basic"])
def test_cut_anywhere_and_sent_again_from_the_start(sequence: Sequence, groups: frozenset[str]) -> None:
    proven = 0
    for path in reachable(groups).values():
        for first in SEQUENCES.values():
            for cut in range(len(first.data) + 1):  # the whole of it too: sent twice
                robot = robot_after(path, groups=groups, before=QUEUE)
                actions = robot.receive_data(first.data[:cut])
                assert not any(isinstance(action, STARTS) for action in actions)
                prove(sequence, robot, f"{path.hex(' ')}, then {cut} bytes")
                proven += 1
    # A cut of 0..11 bytes of attention, 0..9 of emergency stop.
    assert proven == (123 if groups else 88) * (12 + 10)


@each_sequence
def test_a_motion_that_runs_is_ended_when_the_sequence_has_gone(sequence: Sequence) -> None:
    robot = Robot()
    robot.receive_data(QUEUE)
    assert robot.next_command() == Forward(100)  # on its way: no longer in the queue
    actions = robot.receive_data(sequence.data)
    assert [type(action) for action in actions][:2] == [SelectDirect, Stop]
    assert not is_moving(actions, before=True)


# ----------------------------------------------------------- what W7 and W8 do not promise: a line cut by its args


def test_a_basic_robot_takes_the_rest_of_an_unknown_commands_arguments_for_a_line() -> None:
    # CL with X = 0D46: a robot without C drops the line up to the argument byte 0D, and what follows is F 00 C8 RET.
    line = bytes.fromhex("43 4C 0D 46 00 C8 0D")
    robot = robot_after(line, groups=BASIC)
    assert robot.queued == 1  # a move nobody asked for: a host must not send C to a robot that has none (W10)
    for sequence in SEQUENCES.values():
        robot = robot_after(line, groups=BASIC)
        prove(sequence, robot, "after the accident")  # the sequence abandons it, and starts nothing itself
        for cut in range(len(line)):
            prove(sequence, robot_after(line[:cut], groups=BASIC), f"after {cut} bytes of it")


def test_a_basic_robot_can_be_led_astray_into_direct_control_and_is_stopped_all_the_same() -> None:
    # QT with X = 0D32, Y = 0D41: the second RET completes 2 RET, and 41 is a key that starts it.
    robot = Robot(Mode.LOGO, BASIC)
    assert robot.receive_data(bytes.fromhex("51 54 0D 32 0D 41")) == [SelectDirect(), StartForward()]
    for sequence in SEQUENCES.values():
        robot = robot_after(bytes.fromhex("51 54 0D 32 0D 41"), groups=BASIC)
        prove(sequence, robot, "astray")


def test_a_full_robot_is_never_led_astray_by_arguments() -> None:
    for letters, size in ARGUMENTS.items():
        for arguments in product(SMALL, repeat=size):
            robot = robot_after(letters.encode() + bytes(arguments) + b"\r")
            assert (robot.mode, robot.queued, robot.malformed) == (Mode.LOGO, 1, 0)
