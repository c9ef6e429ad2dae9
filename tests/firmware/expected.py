"""What the Python ends of the robots make of the commands of the runner: what the core has to make of them, too."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from turtlewire.protocols.frame.codec import frame_bytes
from turtlewire.protocols.frame.dialect import FROM_ROBOT, TO_ROBOT, shipped
from turtlewire.protocols.frame.message import MAX_PAYLOAD
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
    RobotMessage,
    SelectDirect,
    WalterMessage,
)
from turtlewire.protocols.walter.robot import Robot as WalterRobot

from .core import Core, Outcome, arrive

if TYPE_CHECKING:
    from collections.abc import Iterable

    from turtlewire.protocols.frame.dialect import Dialect, Entry
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


def vectors(protocol: str, what: str) -> list[Any]:
    paths = sorted((VECTORS / protocol).glob("*.json"))
    return [entry for path in paths for entry in json.loads(path.read_text("utf-8")).get(what, [])]


def to_robot(protocol: str) -> list[Any]:
    return [vector for vector in vectors(protocol, "vectors") if vector["direction"] == "to robot"]


def cut(data: bytes, cuts: Iterable[int]) -> list[bytes]:
    places = sorted({0, len(data), *(place % (len(data) + 1) for place in cuts)})
    return [data[a:b] for a, b in pairwise(places)] or [b""]


class Expected:
    """What the Python end makes of the same: commands for the core, and what each has to lead to."""

    def __init__(self) -> None:
        self.commands: list[str] = []
        self.outcomes: list[Outcome] = []

    def add(self, command: str, events: list[str], **state: object) -> None:
        self.commands.append(command)
        self.outcomes.append(Outcome(events, {name: str(value) for name, value in state.items()}))

    def check(self, core: Core) -> None:
        """Run the commands. Raises ``AssertionError`` for the first that the core takes otherwise."""
        self.compare(core.do(self.commands))

    def compare(self, outcomes: Iterable[Outcome]) -> None:
        """Raises ``AssertionError`` for the first that is another."""
        for command, found, expected in zip(self.commands, outcomes, self.outcomes, strict=True):
            events = [event for event in without_stale(found.events) if event != "heard"]
            state = found.state | {"heard_now": str(len(found.events) - len(events))}
            assert (command, events) == (command, expected.events)
            assert {name: state[name] for name in expected.state} == expected.state


# ----------------------------------------------------------------------------------------------------- simple


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


def simple(expected: Expected, pieces: list[bytes], extended: bool) -> None:
    robot = SimpleRobot((SetServos,) if extended else ())
    expected.add(f"simple {'V' * extended}", [], pending=0)
    for piece in pieces:
        events = simple_events(robot, piece)
        expected.add(arrive(piece), events, pending=len(robot.pending))


# ----------------------------------------------------------------------------------------------------- walter


def shown(what: str, message: WalterMessage) -> str:
    letters = len(message.LETTERS)
    arguments = encode(message)[letters:] if isinstance(message, DirectKey) else encode(message)[letters:-1]
    values = "".join(f" {value}" for value in message.values())
    return f"{what} {IDS.index(type(message))} {arguments.hex().upper()}{values}"


def without_stale(events: list[str]) -> list[str]:
    """A message of WALTER shows four bytes of arguments and their readings; those it does not have mean nothing."""
    return [_without_stale(event) for event in events]


def _without_stale(event: str) -> str:
    what, *rest = event.split(" ")
    if what not in ("key", "command"):
        return event
    fields = IDS[int(rest[0])].FIELDS
    readings = rest[2:]
    size = sum(2 if field.kind.endswith("16") else 1 for field in fields)
    places = [readings.index(field.kind) + 1 + number for number, field in enumerate(fields)]
    values = "".join(f" {readings[place]}" for place in places)
    return f"{what} {rest[0]} {rest[1][: 2 * size]}{values}"


def walter(
    expected: Expected, pieces: list[bytes], mode: Mode, groups: frozenset[str], takes: Iterable[int]
) -> None:
    expected.add(f"walter {mode.value} {sum(GROUP_BITS[group] for group in groups)}", [])
    walter_receives(expected, WalterRobot(mode, groups), pieces, takes)


def walter_receives(
    expected: Expected, robot: WalterRobot, pieces: Iterable[bytes], takes: Iterable[int]
) -> None:
    """Bytes arrive; after each piece so many commands are taken."""
    take = iter(takes)
    for piece in pieces:
        at_once = robot.receive_data(piece)
        acts = ["direct" if isinstance(m, SelectDirect) else shown("key", m) for m in at_once]
        state = {"mode": robot.mode.value, "queued": robot.queued, "pending": robot.pending}
        state |= {"heard": robot.heard}
        expected.add(arrive(piece), acts, **state, malformed=robot.malformed, overflowed=robot.overflowed)
        for _ in range(next(take, 0)):
            command = robot.next_command()
            taken = "none" if command is None else shown("command", command)
            expected.add("take", [taken], queued=robot.queued)


def sends(expected: Expected, command: str, message: RobotMessage) -> None:
    """The core makes the bytes of a reply or event of WALTER."""
    expected.add(command, [f"sends {encode(message).hex().upper()}"])


# ------------------------------------------------------------------------------------------------------ frame


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


class Telemetry:
    """A robot of a dialect that is shown messages and makes frames of the valid ones."""

    def __init__(self, expected: Expected, name: str) -> None:
        self._expected = expected
        self._dialect = shipped(name)
        self._seq = 0
        self._payload = b""
        expected.add(f"frame {name}", [])

    def show(self, data: bytes) -> None:
        """Type and fields of a message, or some bytes more or less."""
        entries = [entry for entry in self._dialect.entries if entry.type == data[0]]
        sizes = {
            way: max((e.layout.size for e in entries if e.goes(way)), default=0)
            for way in (TO_ROBOT, FROM_ROBOT)
        }
        events = [f"sizes {sizes[TO_ROBOT]} {sizes[FROM_ROBOT]}"]
        if len(data) >= sizes[TO_ROBOT]:
            at_once = [e for e in entries if e.goes(TO_ROBOT) and e.is_decoded]
            done = [f"{again(e, data)} message" for e in at_once if is_valid(self._dialect, e, data)]
            events += done or ["refused"]
        for entry in entries:
            if len(data) >= entry.layout.size:
                events.append(self._read_as(entry, data))
        self._expected.add(f"message {data.hex()}", events)

    def _read_as(self, entry: Entry, data: bytes) -> str:
        if not is_valid(self._dialect, entry, data):
            return f"invalid {again(entry, data)}"
        if len(self._payload) + entry.layout.size > MAX_PAYLOAD:
            return f"valid {again(entry, data)} no room"
        self._payload += bytes.fromhex(again(entry, data))
        return f"valid {again(entry, data)}"

    def finish(self) -> None:
        """The frame with what was shown and had room."""
        made = frame_bytes(self._dialect, self._seq % 256, self._payload)
        self._seq, self._payload = self._seq + 1, b""
        self._expected.add("finish", [f"sends {made.hex().upper()}"])


def is_valid(dialect: Dialect, entry: Entry, data: bytes) -> bool:
    values = entry.layout.unpack_from(data)[1:]
    pairs = zip(entry.message_type.FIELDS, values, strict=True)
    return all(field.fits(value) and value <= dialect.high(entry, field) for field, value in pairs)


def again(entry: Entry, data: bytes) -> str:
    """The message read and written."""
    return entry.layout.pack(*entry.layout.unpack_from(data)).hex().upper()
