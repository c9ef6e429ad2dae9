"""The vectors of frame, run against the codec and both ends: both ways, whole, byte by byte and cut anywhere.

The files in ``spec/vectors/frame`` were written by hand from the protocol; the firmware runs them too. That their CRCs
are right is computed here bit by bit, by nothing that the codec uses.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated, Literal

import msgspec
import pytest
from msgspec import Meta, Struct, field

from tests.vectors import runner
from tests.vectors.runner import AnySession, AnyVector, Bad, Hex, Natural, Runner, Topic
from turtlewire.protocols.frame.codec import FrameDecoder, FrameEncoder, Item
from turtlewire.protocols.frame.dialect import FROM_ROBOT, SHIPPED, TO_ROBOT, Dialect, shipped
from turtlewire.protocols.frame.host import Host
from turtlewire.protocols.frame.robot import Robot
from turtlewire.protocols.message import Malformed

if TYPE_CHECKING:
    from turtlewire.protocols.frame.message import FrameMessage

# ------------------------------------------------------------------------------------------------- the schema

Section = Annotated[str, Meta(pattern=r"^(1\.[1-4]|2\.[1-3]|F([1-9]|1[0-3]))$")]
Text = Annotated[str, Meta(pattern=r"^[a-z_]+( [a-z_]+=[-a-z0-9.]+)*$")]
Byte = Annotated[int, Meta(ge=0, le=255)]
DialectName = Literal["0.1", "0.1-literal", "telemetry"]


class Good(Struct, forbid_unknown_fields=True, frozen=True):
    """A frame; ``canonical`` is what an encoder makes of its messages where that is not ``raw``."""

    offset: Natural
    raw: Hex
    seq: Byte
    messages: list[Text]
    refused: list[Text] = []
    order: Literal["", "gap", "repeat", "restart"] = ""
    lost: Natural = 0
    canonical: Hex | None = None


class Vector(AnyVector, forbid_unknown_fields=True, frozen=True, kw_only=True):
    section: Section
    dialect: DialectName
    crc: str | None = None
    coverage: Literal["magic", "seq", "size", "payload"] | None = None
    counts: dict[str, int] = field(default_factory=dict)
    types: dict[str, int] = field(default_factory=dict)

    def expected(self) -> list[Good | Bad]:
        return runner.read_items(self.items, Good)

    def spoken(self) -> Dialect:
        dialect = shipped(self.dialect)
        return dialect.configured(counts=self.counts, types=self.types, crc=self.crc, coverage=self.coverage)


class Step(Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """At a time, bytes arrive at a robot (or none: its timer)."""

    at_ms: Natural
    receive: Hex
    carries_out: list[Text]
    pending: Natural


class Counts(Struct, forbid_unknown_fields=True, frozen=True):
    frames: Natural
    incomplete: Natural
    skipped_bytes: Natural


class RobotSession(AnySession, forbid_unknown_fields=True, frozen=True, kw_only=True):
    section: Section
    dialect: DialectName
    steps: list[Step]
    counts: Counts


class HostStep(Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """At a time, a host is told to do something; then what it sends: ahead of everything, and in its turn."""

    at_ms: Natural
    do: Literal["connect", "send", "emergency stop", "exit", "nothing"]
    messages: list[Text] = []
    urgent: Hex = ""
    data: Hex = ""


class HostSession(AnySession, forbid_unknown_fields=True, frozen=True, kw_only=True):
    section: Section
    dialect: DialectName
    counts: dict[str, int]
    repeat_ms: Natural | None = None
    heartbeat_ms: Natural | None = None
    steps: list[HostStep]


TOPICS = runner.read_topics("frame", Topic[Vector, dict[str, object]])
VECTORS = [vector for topic in TOPICS.values() for vector in topic.vectors]
ROBOT_SESSIONS = [msgspec.convert(session, RobotSession) for session in TOPICS["timeouts"].sessions]
HOST_SESSIONS = [msgspec.convert(session, HostSession) for session in TOPICS["host"].sessions]

each_vector = pytest.mark.parametrize("vector", VECTORS, ids=lambda vector: vector.id)


def messages_of(dialect: Dialect, texts: list[str]) -> tuple[FrameMessage, ...]:
    """Messages from their text, whether they keep their restrictions or not."""
    made = []
    for text in texts:
        name, *pairs = text.split()
        values = {
            f.name: f.read(pair.partition("=")[2])
            for f, pair in zip(dialect[name].FIELDS, pairs, strict=True)
        }
        assert list(values) == [pair.partition("=")[0] for pair in pairs]
        made.append(dialect[name](**values))
    return tuple(made)


# ------------------------------------------------------------------------------------------ an independent CRC

PARAMETERS = {
    "CRC-8/SMBUS": (0x07, 0x00, False, 0x00),
    "CRC-8/MAXIM-DOW": (0x31, 0x00, True, 0x00),
    "CRC-8/AUTOSAR": (0x2F, 0xFF, False, 0xFF),
    "CRC-8/SAE-J1850": (0x1D, 0xFF, False, 0xFF),
    "CRC-8/ROHC": (0x07, 0xFF, True, 0x00),
    "CRC-8/CDMA2000": (0x9B, 0xFF, False, 0x00),
}


def crc_bit_by_bit(name: str, data: bytes) -> int:
    poly, register, reflected, xorout = PARAMETERS[name]
    for byte in data:
        for n in range(8):
            bit = byte >> (n if reflected else 7 - n) & 1
            out = register >> 7 ^ bit
            register = register << 1 & 0xFF ^ (poly if out else 0)
    if reflected:
        register = int(f"{register:08b}"[::-1], 2)
    return register ^ xorout


@each_vector
def test_the_crcs_are_right_where_they_should_be(vector: Vector) -> None:
    first = ["magic", "seq", "size", "payload"].index(vector.coverage or "magic")
    for item in vector.expected():
        raw = bytes.fromhex(item.raw)
        right = crc_bit_by_bit(vector.crc or "CRC-8/SMBUS", raw[first:-1])
        if isinstance(item, Good) or "cut short" in item.error or "unknown type" in item.error:
            assert raw[-1] == right
        elif item.error.startswith("CRC"):
            assert item.error == f"CRC is {raw[-1]:02X}, but must be {right:02X}"
            assert raw[-1] != right


# ------------------------------------------------------------------------------------------- the vectors themselves


def test_there_are_all_the_topics() -> None:
    names = {
        "crc",
        "host",
        "literal",
        "messages",
        "packing",
        "recovery",
        "sequence",
        "telemetry",
        "timeouts",
    }
    runner.check_topics("frame", TOPICS, names)


def test_ids_are_unique_and_begin_with_the_topic() -> None:
    runner.check_ids(TOPICS, [*ROBOT_SESSIONS, *HOST_SESSIONS])


@each_vector
def test_items_stand_in_the_bytes_where_they_say(vector: Vector) -> None:
    data = vector.data()
    dialect = vector.spoken()
    for item in vector.expected():
        raw = bytes.fromhex(item.raw)
        assert data[item.offset : item.offset + len(raw)] == raw
        assert raw[0] == 0xA3
        if isinstance(item, Good):
            assert raw[1] == item.seq
            made = messages_of(dialect, item.messages + item.refused)
            assert [str(message) for message in made] == item.messages + item.refused
    if vector.attempts is not None:
        assert vector.attempts in [t.name() for t in dialect.types]
        assert any(isinstance(item, Bad) or item.refused for item in vector.expected())


# ------------------------------------------------------------------------------------------------- the runner


def texts(messages: tuple[FrameMessage, ...]) -> list[tuple[type[FrameMessage], str]]:
    """As the wire has them: NaN equals itself, and a number what an f32 makes of it."""
    return [(type(message), str(message)) for message in messages]


def shown(item: Item) -> object:
    if isinstance(item, Malformed):
        return item
    said = item.offset, item.raw, item.seq, texts(item.messages), texts(item.refused)
    return said, (item.order, item.lost)


def expected(vector: Vector, moved: int) -> list[object]:
    dialect = vector.spoken()
    items: list[object] = []
    for item in vector.expected():
        offset, raw = item.offset + moved, bytes.fromhex(item.raw)
        if isinstance(item, Bad):
            items.append(Malformed(offset, raw, item.error))
        else:
            messages, refused = (texts(messages_of(dialect, of)) for of in (item.messages, item.refused))
            items.append(((offset, raw, item.seq, messages, refused), (item.order, item.lost)))
    return items


FRAME = Runner(
    decoder=lambda vector: FrameDecoder(vector.spoken(), vector.direction),
    expected=expected,
    rest=lambda decoder, vector: (decoder.pending, vector.pending),
    shown=shown,
    # The numbers of the frames begin again, which is a gap or a restart.
    again=lambda shown: shown if isinstance(shown, Malformed) else shown[0],
)


@each_vector
def test_decoding_in_every_chunking(vector: Vector) -> None:
    FRAME.check_decoding(vector)


@each_vector
def test_encoding_gives_the_canonical_bytes(vector: Vector) -> None:
    dialect = vector.spoken()
    for item in vector.expected():
        if isinstance(item, Good) and not item.refused and vector.dialect != "0.1-literal":
            encoder = FrameEncoder(dialect, vector.direction, item.seq)
            (frame,) = encoder.encode(dialect.parse(text) for text in item.messages)
            assert frame.hex(" ").upper() == (item.canonical or item.raw)


CLOSED = [vector for vector in VECTORS if not vector.pending]


@pytest.mark.parametrize("vector", CLOSED, ids=lambda vector: vector.id)
def test_nothing_is_left_behind_for_the_next(vector: Vector) -> None:
    FRAME.check_decoding_again(vector)


@pytest.mark.parametrize("session", ROBOT_SESSIONS, ids=lambda session: session.id)
def test_sessions_with_a_robot(session: RobotSession) -> None:
    longest = max(len(bytes.fromhex(step.receive)) for step in session.steps)
    for cut in range(longest + 1):
        robot = Robot(shipped(session.dialect))
        for step in session.steps:
            data = bytes.fromhex(step.receive)
            now = step.at_ms / 1000
            done = [m for chunk in (data[:cut], data[cut:]) for m in robot.receive_data(chunk, now)]
            assert [str(message) for message in done] == step.carries_out, step
            assert robot.pending == step.pending
        stats = robot.statistics
        assert Counts(stats.frames, stats.incomplete, stats.skipped_bytes) == session.counts
        assert robot.heard == stats.frames


def seconds(ms: int | None) -> float | None:
    return None if ms is None else ms / 1000


@pytest.mark.parametrize("session", HOST_SESSIONS, ids=lambda session: session.id)
def test_sessions_with_a_host(session: HostSession) -> None:
    dialect = shipped(session.dialect).configured(counts=session.counts)
    host = Host(dialect, repeat_s=seconds(session.repeat_ms), heartbeat_s=seconds(session.heartbeat_ms))
    for step in session.steps:
        now = step.at_ms / 1000
        if step.do == "connect":
            host.connect(now)
        elif step.do == "emergency stop":
            host.emergency_stop(now)
        elif step.do == "exit":
            host.exit(now)
        elif step.do == "send":
            host.send(*(dialect.parse(text) for text in step.messages))
        assert host.urgent_to_send().hex(" ").upper() == step.urgent, step
        assert host.data_to_send(now).hex(" ").upper() == step.data, step


# ----------------------------------------------------------------------------------------------- nothing is missing


def shape(reason: str) -> str:
    """What kind of error a reason is: numbers and names taken out of it."""
    reason = re.sub(r"^[a-z_]+ at byte \d+ is cut short: \d+ of \d+ bytes$", "cut short", reason)
    return re.sub(r"\b([0-9A-F]{2}|\d+)\b", "_", reason)


SHAPES = {
    "size _ is above _",
    "CRC is _, but must be _",
    "unknown type _ at byte _",
    "cut short",
}


def test_every_reason_has_a_vector() -> None:
    in_vectors = {shape(item.error) for v in VECTORS for item in v.expected() if isinstance(item, Bad)}
    # the fifth, of a frame that is given up, takes time: the sessions have it
    assert in_vectors == SHAPES
    assert any(session.counts.incomplete for session in ROBOT_SESSIONS)


CASES = [
    pytest.param(name, entry.message_type, direction, id=f"{name}-{entry.message_type.name()}-{direction}")
    for name in SHIPPED
    for entry in shipped(name).entries
    for direction in (TO_ROBOT, FROM_ROBOT)
    if entry.goes(direction) and entry.is_decoded
]


@pytest.mark.parametrize(("name", "message_type", "direction"), CASES)
def test_every_message_has_a_valid_and_an_invalid_vector(
    name: str, message_type: type[FrameMessage], direction: str
) -> None:
    vectors = [v for v in VECTORS if v.dialect == name and v.direction == direction]
    valid = [
        text
        for vector in vectors
        for item in vector.expected()
        if isinstance(item, Good)
        for text in item.messages
        if text.split()[0] == message_type.name()
    ]
    assert valid
    # 0.1-literal has the servo message of 0.1, class and all
    attempts = {v.attempts for v in VECTORS if v.direction == direction}
    assert message_type.name() in attempts


def test_every_algorithm_and_coverage_has_a_vector() -> None:
    crc = [vector for vector in VECTORS if vector.crc is not None]
    assert {vector.crc for vector in crc} == set(PARAMETERS)
    assert {vector.coverage for vector in crc} == {"magic", "seq", "size", "payload"}
