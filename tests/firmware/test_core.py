"""The firmware's core does what the Python ends of the robots do: on every vector, and on any bytes.

Compiled with all warnings as errors, and run under the address and undefined behaviour sanitizers.
"""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from turtlewire.protocols.frame.codec import INTER_BYTE_S, frame_bytes
from turtlewire.protocols.frame.dialect import TO_ROBOT, shipped
from turtlewire.protocols.frame.robot import Robot as FrameRobot
from turtlewire.protocols.message import Field
from turtlewire.protocols.simple import messages as s
from turtlewire.protocols.simple.robot import Robot as SimpleRobot
from turtlewire.protocols.walter.codec import Mode, encode
from turtlewire.protocols.walter.messages import (
    DIRECT_KEYS,
    LOGO_COMMANDS,
    DirectKey,
    EmptyLine,
    SelectDirect,
    WalterMessage,
)
from turtlewire.protocols.walter.robot import Robot as WalterRobot

from .core import SANITIZERS, Core, Outcome, arrive, build

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from turtlewire.protocols.frame.dialect import Dialect
    from turtlewire.protocols.frame.message import FrameMessage

VECTORS = Path(__file__).parents[2] / "spec" / "vectors"
GROUP_BITS = {"C": 1, "Q": 2, "H": 4, "E": 8}
# As the generated header numbers them.
IDS: tuple[type[WalterMessage], ...] = (
    EmptyLine,
    *(t for t in LOGO_COMMANDS if t is not EmptyLine),
    *DIRECT_KEYS,
)
INTER_BYTE_MS = 100
FEW = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Core]:
    with Core(build(tmp_path_factory.mktemp("core"), "-g", "-O1", *SANITIZERS)) as core:
        yield core


def vectors(protocol: str, what: str) -> list[Any]:
    paths = sorted((VECTORS / protocol).glob("*.json"))
    return [entry for path in paths for entry in json.loads(path.read_text("utf-8")).get(what, [])]


def to_robot(protocol: str) -> list[Any]:
    return [vector for vector in vectors(protocol, "vectors") if vector["direction"] == "to robot"]


def cut(data: bytes, cuts: Iterable[int]) -> list[bytes]:
    places = sorted({0, len(data), *(place % (len(data) + 1) for place in cuts)})
    return [data[a:b] for a, b in pairwise(places)] or [b""]


# ------------------------------------------------------------------------------------------------------ simple


class SetServos(s.SimpleCommand, frozen=True):
    """S10, as in the vectors: two servos."""

    LETTER: ClassVar[bytes] = b"V"
    CHANNEL: ClassVar[str] = "servos"
    FIELDS: ClassVar[tuple[Field, ...]] = (Field("left", "u8", 0, 180, ""), Field("right", "u8", 0, 180, ""))
    left: int
    right: int


def simple_events(robot: SimpleRobot, data: bytes) -> list[str]:
    events: list[str] = []
    for byte in data:
        reaction = robot.receive_data(bytes([byte]))
        for command in reaction.actions:
            if isinstance(command, s.Stop):
                events += ["drive 0", "steer 0"]
            elif isinstance(command, s.Headlights):
                events.append("headlights " + "".join(map(str, command.values())))
            elif isinstance(command, SetServos):
                events.append(f"extension V {command.left} {command.right}")
            else:
                events.append(f"{command.CHANNEL} {command.SIGN * command.values()[0]}")
        events += [f"answer {chr(reply)}" for reply in reaction.replies]
    return events


class Expected:
    """What the Python end makes of the same: commands for the core, and what each has to lead to."""

    def __init__(self) -> None:
        self.commands: list[str] = []
        self.outcomes: list[Outcome] = []

    def add(self, command: str, events: list[str], **state: object) -> None:
        self.commands.append(command)
        self.outcomes.append(Outcome(events, {name: str(value) for name, value in state.items()}))

    def check(self, core: Core) -> None:
        for command, found, expected in zip(
            self.commands, core.do(self.commands), self.outcomes, strict=True
        ):
            events = [event for event in without_stale(found.events) if event != "heard"]
            state = found.state | {"heard_now": str(len(found.events) - len(events))}
            assert (command, events) == (command, expected.events)
            assert {name: state[name] for name in expected.state} == expected.state


def simple(expected: Expected, pieces: list[bytes], extended: bool) -> None:
    robot = SimpleRobot((SetServos,) if extended else ())
    expected.add(f"simple {'V' * extended}", [], pending=0)
    for piece in pieces:
        events = simple_events(robot, piece)
        expected.add(arrive(piece), events, pending=len(robot.pending))


@pytest.mark.parametrize("vector", to_robot("simple"), ids=lambda vector: vector["id"])
def test_the_vectors_of_simple(core: Core, vector: dict[str, Any]) -> None:
    data, extended = bytes.fromhex(vector["bytes"]), vector.get("extensions", False)
    _, (events, state) = core.do([f"simple {'V' * extended}", arrive(data)])
    answers = [event for event in events if event.startswith("answer")]
    assert answers == [f"answer {chr(reply)}" for reply in bytes.fromhex(vector["replies"])]
    assert state["pending"] == str(vector["pending"])
    expected = Expected()
    for number in range(len(data) + 1):
        simple(expected, [data[:number], data[number:]], extended)
    expected.check(core)


LETTERS = st.sampled_from(b"FBLRSHVKfb\x00\xff")
DIGITS = st.sampled_from(b"0125679/:;A \x00\xff")
COMMANDS = st.builds(
    lambda letter, rest: bytes([letter, *rest]), LETTERS, st.lists(DIGITS, min_size=6, max_size=6)
)
SIMPLE_BYTES = st.lists(COMMANDS | st.binary(max_size=9), max_size=12).map(b"".join)


@given(SIMPLE_BYTES, st.lists(st.integers(0, 200), max_size=4), st.booleans())
@FEW
def test_any_bytes_of_simple(core: Core, data: bytes, cuts: list[int], extended: bool) -> None:
    expected = Expected()
    simple(expected, cut(data, cuts), extended)
    expected.check(core)


# ------------------------------------------------------------------------------------------------------ walter


def shown(what: str, message: WalterMessage) -> str:
    letters = len(message.LETTERS)
    arguments = encode(message)[letters:] if isinstance(message, DirectKey) else encode(message)[letters:-1]
    return f"{what} {IDS.index(type(message))} {arguments.hex().upper()}"


def without_stale(events: list[str]) -> list[str]:
    """A message of WALTER shows four bytes of arguments; those that it does not have mean nothing."""
    return [_without_stale(event) for event in events]


def _without_stale(event: str) -> str:
    what, *rest = event.split(" ")
    if what not in ("key", "command"):
        return event
    size = sum(2 if field.kind.endswith("16") else 1 for field in IDS[int(rest[0])].FIELDS)
    return f"{what} {rest[0]} {rest[1][: 2 * size]}"


def walter(
    expected: Expected, pieces: list[bytes], mode: Mode, groups: frozenset[str], takes: Iterable[int]
) -> None:
    robot = WalterRobot(mode, groups)
    expected.add(f"walter {mode.value} {sum(GROUP_BITS[group] for group in groups)}", [])
    take = iter(takes)
    for piece in pieces:
        at_once = robot.receive_data(piece)
        acts = ["direct" if isinstance(m, SelectDirect) else shown("key", m) for m in at_once]
        state = {"mode": robot.mode.value, "queued": robot.queued, "heard": robot.heard}
        expected.add(arrive(piece), acts, **state, malformed=robot.malformed, overflowed=robot.overflowed)
        for _ in range(next(take, 0)):
            command = robot.next_command()
            taken = "none" if command is None else shown("command", command)
            expected.add("take", [taken], queued=robot.queued)


@pytest.mark.parametrize("vector", to_robot("walter"), ids=lambda vector: vector["id"])
def test_the_vectors_of_walter(core: Core, vector: dict[str, Any]) -> None:
    data, mode = bytes.fromhex(vector["bytes"]), Mode(vector["mode"])
    groups = frozenset(vector.get("groups", "CQHE"))
    mask = sum(GROUP_BITS[group] for group in groups)
    _, (_, state) = core.do([f"walter {mode.value} {mask}", arrive(data)])
    assert (state["mode"], state["pending"]) == (vector["mode_after"], str(vector["pending"]))
    items = vector["items"]
    assert int(state["malformed"]) == sum("error" in item for item in items)
    assert int(state["heard"]) == sum("message" in item for item in items)
    expected = Expected()
    for number in range(len(data) + 1):
        walter(expected, [data[:number], data[number:]], mode, groups, [20, 20])
    expected.check(core)


WALTER_BYTES = st.lists(
    st.sampled_from([encode(t(*(0 for _ in t.FIELDS))) for t in IDS])
    | st.sampled_from(
        [b"2\r", b"\r", b"\r\n", b"1", b"F\x0d\x0a\x0d", b"q", b"x" * 70, b"fd", b"CL\x01\x02\x03\x04\r"]
    )
    | st.lists(st.sampled_from(b"2FBVLRPUDHECXYQT01LHSAZGf\r\n\x00 ,.\xff"), max_size=8).map(bytes)
    | st.binary(max_size=4),
    max_size=30,
).map(b"".join)


@given(
    WALTER_BYTES,
    st.lists(st.integers(0, 400), max_size=6),
    st.sampled_from(Mode),
    st.sets(st.sampled_from("CQHE")),
    st.lists(st.integers(0, 5), max_size=6),
)
@FEW
def test_any_bytes_of_walter(
    core: Core, data: bytes, cuts: list[int], mode: Mode, groups: set[str], takes: list[int]
) -> None:
    expected = Expected()
    walter(expected, cut(data, cuts), mode, frozenset(groups), takes)
    expected.check(core)


# ------------------------------------------------------------------------------------------------------- frame

COUNTED = ("frames", "oversized", "wrong_crc", "incomplete", "unknown_type", "inconsistent", "lost")


def frame(expected: Expected, name: str, steps: list[tuple[int, bytes]]) -> None:
    """Bytes at times, in milliseconds; b"": time passes."""
    dialect = shipped(name)
    # In milliseconds, too: their sums are exact.
    robot = FrameRobot(dialect, timeout_s=INTER_BYTE_MS)
    expected.add(f"frame {name}", [])
    for at_ms, data in steps:
        heard = robot.heard
        messages = robot.receive_data(data, at_ms)
        events = [f"{packed(dialect, message).hex().upper()} message" for message in messages]
        counts = robot.statistics
        state = {each: getattr(counts, each) for each in (*COUNTED, "repeats", "restarts")}
        state |= {"pending": robot.pending, "refused": sum(counts.refused.values())}
        command = arrive(data, at_ms) if data else f"pass {at_ms}"
        expected.add(command, events, heard_now=robot.heard - heard, **state)


def packed(dialect: Dialect, message: FrameMessage) -> bytes:
    entry = dialect.entry(message)
    assert entry.goes(TO_ROBOT)
    return entry.layout.pack(entry.type, *message.values())


def test_a_frames_robot_has_the_same_patience() -> None:
    assert INTER_BYTE_S * 1000 == INTER_BYTE_MS


@pytest.mark.parametrize(
    "vector",
    [v for v in to_robot("frame") if "crc" not in v and "counts" not in v],
    ids=lambda vector: vector["id"],
)
def test_the_vectors_of_frame(core: Core, vector: dict[str, Any]) -> None:
    data = bytes.fromhex(vector["bytes"])
    _, (_, state) = core.do([f"frame {vector['dialect']}", arrive(data)])
    assert int(state["frames"]) == sum("messages" in item for item in vector["items"])
    assert state["pending"] == str(vector["pending"])
    expected = Expected()
    for number in range(len(data) + 1):
        frame(expected, vector["dialect"], [(0, data[:number]), (0, data[number:])])
    expected.check(core)


@pytest.mark.parametrize(
    "session",
    [v for v in vectors("frame", "sessions") if "counts" in v and "receive" in v["steps"][0]],
    ids=lambda session: session["id"],
)
def test_the_timed_sessions_of_frame(core: Core, session: dict[str, Any]) -> None:
    steps = [(step["at_ms"], bytes.fromhex(step["receive"])) for step in session["steps"]]
    expected = Expected()
    frame(expected, session["dialect"], steps)
    expected.check(core)


def frames(dialect: Dialect) -> st.SearchStrategy[bytes]:
    """Frames with right CRCs, of messages and of nonsense."""
    types = st.sampled_from([*(entry.type for entry in dialect.entries), 0x02, 0x77, 0xA3])
    nonsense = st.builds(lambda number, rest: bytes([number]) + rest, types, st.binary(max_size=12))
    sizes = {entry.type: entry.layout.size for entry in dialect.entries if entry.goes(TO_ROBOT)}
    right = st.sampled_from(sorted(sizes)).flatmap(
        lambda number: st.binary(min_size=sizes[number] - 1, max_size=sizes[number] - 1).map(
            lambda fields: bytes([number]) + fields
        )
    )
    payloads = st.lists(right, max_size=12) | st.lists(nonsense, max_size=4)
    seq = st.integers(0, 255) | st.sampled_from([0, 1, 2, 3])
    return st.builds(lambda number, parts: frame_bytes(dialect, number, b"".join(parts)[:124]), seq, payloads)


@pytest.mark.parametrize("name", ["0.1", "0.1-literal", "telemetry"])
@given(data=st.data())
@FEW
def test_any_bytes_of_frame(core: Core, name: str, data: st.DataObject) -> None:
    whole = frames(shipped(name))
    odd = [b"", b"\xa3", b"\xa3" * 130, b"\xa3\x00\x7c", b"\xa3\x00\x7d", b"\xa3\x00\xff", bytes(128)]
    cut_off = st.builds(lambda some, less: some[: len(some) - less], whole, st.integers(1, 8))
    piece = whole | cut_off | st.binary(max_size=6) | st.sampled_from(odd)
    waits = st.sampled_from([0, 0, 0, 1, 99, 100, 101, 5000])
    at_ms, steps = 2**32 - 300, []  # the clock of a robot wraps
    for wait_ms, some in data.draw(st.lists(st.tuples(waits, piece), max_size=12)):
        at_ms += wait_ms
        steps.append((at_ms, some))
    expected = Expected()
    frame(expected, name, steps)
    expected.check(core)
