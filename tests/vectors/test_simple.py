"""The vectors of simple, run against the codec, the robot's end and the host's: whole, byte by byte and cut anywhere.

The files in ``spec/vectors/simple`` were written by hand from the protocol; the firmware runs them too.
"""

from __future__ import annotations

import re
from collections import Counter
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import msgspec
import pytest
from msgspec import Meta, Struct, field

from turtlewire.protocols.message import Decoded, Field, Malformed, parse
from turtlewire.protocols.simple.codec import CommandDecoder, Item, ReplyDecoder, encode
from turtlewire.protocols.simple.events import Event, InStep, LinkDead, OutOfStep
from turtlewire.protocols.simple.host import Host
from turtlewire.protocols.simple.messages import (
    COMMANDS,
    MESSAGES,
    REPLIES,
    SimpleCommand,
    SimpleMessage,
    Stop,
)
from turtlewire.protocols.simple.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Iterator

FOLDER = Path(__file__).parents[2] / "spec" / "vectors" / "simple"
FILES = sorted(FOLDER.glob("*.json"))


class SetServos(SimpleCommand, frozen=True):
    """The extension command of the vectors (S10)."""

    LETTER: ClassVar[bytes] = b"V"
    CHANNEL: ClassVar[str] = "servos"
    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("left_deg", "u8", 0, 180, "degrees"),
        Field("right_deg", "u8", 0, 180, "degrees"),
    )
    left_deg: int
    right_deg: int


EXTENSIONS = (SetServos,)
ALL: tuple[type[SimpleMessage], ...] = (*MESSAGES, SetServos)

# ------------------------------------------------------------------------------------------------- the schema

Id = Annotated[str, Meta(pattern=r"^[a-z-]+/[a-z0-9]+(-[a-z0-9]+)*$")]
Hex = Annotated[str, Meta(pattern=r"^([0-9A-F]{2}( [0-9A-F]{2})*)?$")]
Section = Annotated[str, Meta(pattern=r"^(ENKELT PROTOKOLL|EXEMPEL|FELKONTROLL|S\d+|Section 4)$")]
Origin = Literal["source", "by hand"]
Text = Annotated[str, Meta(pattern=r"^[a-z_]+( [a-z_]+=-?\d+)*$")]
Natural = Annotated[int, Meta(ge=0)]


class Good(Struct, forbid_unknown_fields=True, frozen=True):
    """A message; ``canonical`` is what an encoder makes of it where that is not ``raw``."""

    offset: Natural
    raw: Hex
    message: Text
    fields: dict[str, int]
    canonical: Hex | None = None


class Bad(Struct, forbid_unknown_fields=True, frozen=True):
    offset: Natural
    raw: Hex
    error: str


class State(Struct, forbid_unknown_fields=True, frozen=True):
    """What a robot that was just switched on does after the bytes."""

    drive: Annotated[int, Meta(ge=-255, le=255)]
    steer: Annotated[int, Meta(ge=-255, le=255)]
    lights: Annotated[str, Meta(pattern=r"^[01]{4}$")]


class Vector(Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """``attempts``: the message that ill-formed bytes were meant to be. ``pending``: bytes of an unfinished one."""

    id: Id
    section: Section
    origin: Origin
    direction: Literal["to robot", "from robot"]
    extensions: bool = False
    attempts: str | None = None
    wire: Hex = field(name="bytes")
    items: list[dict[str, object]]
    pending: Natural
    replies: Hex | None = None
    state: State | None = None

    def expected(self) -> list[Good | Bad]:
        return [
            msgspec.convert(item, Bad) if "error" in item else msgspec.convert(item, Good)
            for item in self.items
        ]

    def data(self) -> bytes:
        return bytes.fromhex(self.wire)


class Step(Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """At a time, one of: something is done, submitted or received; ``wait``: the time alone. Then: bytes, events."""

    at_ms: Natural
    do: Literal["connect", "emergency_stop", "wait"] | None = None
    submit: str | None = None
    receive: Hex | None = None
    sends: Hex
    urgent: Hex = ""
    events: list[str]


class Settings(Struct, forbid_unknown_fields=True, frozen=True):
    window: int = 1
    retries: int = 3
    boot_ms: int = 0
    heartbeat_ms: int | None = None


class Counts(Struct, forbid_unknown_fields=True, frozen=True):
    resynchronisations: Natural
    spent: Natural
    malformed: Natural
    unexpected: Natural


class Session(Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    id: Id
    section: Section
    origin: Origin
    settings: Settings
    steps: list[Step]
    state: str
    counts: Counts


class Topic(Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    protocol: Literal["simple"]
    topic: str
    about: str
    vectors: list[Vector] = []
    sessions: list[Session] = []


TOPICS = {path.stem: msgspec.json.decode(path.read_bytes(), type=Topic) for path in FILES}
VECTORS = [vector for topic in TOPICS.values() for vector in topic.vectors]
SESSIONS = [session for topic in TOPICS.values() for session in topic.sessions]
BY_NAME = {message.name(): message for message in ALL}

each_vector = pytest.mark.parametrize("vector", VECTORS, ids=lambda vector: vector.id)
each_session = pytest.mark.parametrize("session", SESSIONS, ids=lambda session: session.id)


def test_there_are_all_the_topics() -> None:
    assert set(TOPICS) == {
        "dont-care",
        "drive",
        "extension",
        "headlights",
        "replies",
        "sessions",
        "steer",
        "stop",
        "stream",
    }
    for name, topic in TOPICS.items():
        assert topic.topic == name
        assert topic.about.endswith(".")
        assert bool(topic.vectors) != bool(topic.sessions)
    assert (len(VECTORS), len(SESSIONS)) == (90, 30)


def test_ids_are_unique_and_begin_with_the_topic() -> None:
    for name, topic in TOPICS.items():
        assert all(vector.id.startswith(f"{name}/") for vector in topic.vectors)
        assert all(session.id.startswith(f"{name}/") for session in topic.sessions)
    ids = Counter([vector.id for vector in VECTORS] + [session.id for session in SESSIONS])
    assert [name for name, n in ids.items() if n > 1] == []


@each_vector
def test_items_stand_in_the_bytes_where_they_say(vector: Vector) -> None:
    data = vector.data()
    end = 0
    for item in vector.expected():
        raw = bytes.fromhex(item.raw)
        assert item.offset == end
        assert data[item.offset : item.offset + len(raw)] == raw
        assert len(raw) == (7 if vector.direction == "to robot" else 1)
        end = item.offset + len(raw)
        if isinstance(item, Good):
            message = parse(item.message, ALL)
            assert str(message) == item.message
            assert item.fields == {f.name: getattr(message, f.name) for f in message.FIELDS}
            assert item.canonical != item.raw, "canonical says something only where it differs"
    assert len(data) - end == vector.pending
    assert (vector.replies is None) == (vector.state is None) == (vector.direction == "from robot")
    if vector.attempts is not None:
        assert vector.attempts in BY_NAME
        assert vector.pending or any(isinstance(item, Bad) for item in vector.expected())


# ------------------------------------------------------------------------------------------------- the runner


def decoder_for(vector: Vector) -> CommandDecoder | ReplyDecoder:
    if vector.direction == "from robot":
        return ReplyDecoder()
    return CommandDecoder(EXTENSIONS if vector.extensions else ())


def items_for(vector: Vector) -> list[Item]:
    items: list[Item] = []
    for item in vector.expected():
        raw = bytes.fromhex(item.raw)
        if isinstance(item, Bad):
            items.append(Malformed(item.offset, raw, item.error))
        else:
            message = parse(item.message, ALL)
            assert isinstance(message, SimpleMessage)
            items.append(Decoded(item.offset, raw, message))
    return items


def chunkings(data: bytes) -> Iterator[list[bytes]]:
    """Whole, byte by byte, and cut at every single point (empty pieces at both ends included)."""
    yield [data]
    yield [bytes([byte]) for byte in data]
    for cut in range(len(data) + 1):
        yield [data[:cut], data[cut:]]


@each_vector
def test_decoding_in_every_chunking(vector: Vector) -> None:
    expected = items_for(vector)
    for chunks in chunkings(vector.data()):
        decoder = decoder_for(vector)
        assert [item for chunk in chunks for item in decoder.receive_data(chunk)] == expected
        if isinstance(decoder, CommandDecoder):
            assert decoder.pending == vector.data()[len(vector.data()) - vector.pending :]


@each_vector
def test_encoding_gives_the_canonical_bytes(vector: Vector) -> None:
    for item in vector.expected():
        if isinstance(item, Good):
            message = BY_NAME[item.message.split()[0]](**item.fields)
            assert encode(message).hex(" ").upper() == (item.canonical or item.raw)


TO_ROBOT = [vector for vector in VECTORS if vector.direction == "to robot"]


@pytest.mark.parametrize("vector", TO_ROBOT, ids=lambda vector: vector.id)
def test_a_robot_answers_and_does_what_it_should(vector: Vector) -> None:
    for chunks in chunkings(vector.data()):
        robot = Robot(EXTENSIONS if vector.extensions else ())
        reactions = [robot.receive_data(chunk) for chunk in chunks]
        assert b"".join(reaction.replies for reaction in reactions).hex(" ").upper() == vector.replies
        good = [item.message for item in vector.expected() if isinstance(item, Good)]
        assert [str(action) for reaction in reactions for action in reaction.actions] == good
        assert (robot.heard, robot.malformed) == (len(good), len(vector.items) - len(good))
        lights = "".join(str(int(light)) for light in robot.lights)
        assert State(robot.drive, robot.steer, lights) == vector.state


@pytest.mark.parametrize("vector", [v for v in VECTORS if not v.pending], ids=lambda vector: vector.id)
def test_nothing_is_left_behind_for_the_next(vector: Vector) -> None:
    decoder = decoder_for(vector)
    decoder.receive_data(vector.data())
    moved = [item._replace(offset=item.offset + len(vector.data())) for item in items_for(vector)]
    assert decoder.receive_data(vector.data()) == moved


def text_of(event: Event) -> str:
    name = re.sub(r"(?<!^)(?=[A-Z])", "_", type(event).__name__).lower()
    if isinstance(event, OutOfStep):
        return f"{name} {event.reason}: {', '.join(map(str, event.unknown))}"
    if isinstance(event, InStep):
        return f"{name} {event.state}"
    if isinstance(event, LinkDead):
        return f"{name} {event.reason}"
    return f"{name} {event.command}"


# Two times that differ by less are the same one, reckoned differently.
SAME_S = 1e-9


def run(session: Session, *, whole: bool) -> None:
    """Run a session: received bytes whole, or byte by byte."""
    settings = session.settings
    host = Host(
        baud=10_000,
        window=settings.window,
        reply_delay_s=0.05,
        retries=settings.retries,
        boot_s=settings.boot_ms / 1000,
        heartbeat_s=None if settings.heartbeat_ms is None else settings.heartbeat_ms / 1000,
    )
    for step in session.steps:
        now = step.at_ms / 1000
        events: list[Event] = []
        if step.do == "wait":
            assert host.next_timeout() == pytest.approx(now, abs=SAME_S), step
            now = host.next_timeout()
        else:
            assert host.next_timeout() > now + SAME_S, step
        if step.do == "connect":
            host.connect(now)
        elif step.do == "emergency_stop":
            host.emergency_stop(now)
        elif step.submit is not None:
            command = parse(step.submit, COMMANDS)
            assert isinstance(command, SimpleCommand)
            host.submit(command)
        elif step.receive is not None:
            data = bytes.fromhex(step.receive)
            for chunk in [data] if whole else [bytes([byte]) for byte in data]:
                events += host.receive_data(chunk, now)
        urgent, sends = host.urgent_to_send(), host.data_to_send(now)
        while host.next_timeout() <= now:
            events += host.timed_out(now)
            sends += host.data_to_send(now)
        assert [text_of(event) for event in events] == step.events, step
        assert (urgent.hex(" ").upper(), sends.hex(" ").upper()) == (step.urgent, step.sends), step
    assert str(host.state) == session.state
    counts = Counts(host.resynchronisations, host.spent, host.malformed, host.unexpected)
    assert counts == session.counts


@each_session
def test_sessions_with_a_host(session: Session) -> None:
    run(session, whole=True)
    run(session, whole=False)


@each_session
def test_steps_are_each_one_thing_in_order_of_time(session: Session) -> None:
    times = [step.at_ms for step in session.steps]
    assert times == sorted(times)
    for step in session.steps:
        assert [step.do, step.submit, step.receive].count(None) == 2


# ----------------------------------------------------------------------------------------------- nothing is missing


def shape(reason: str) -> str:
    """What kind of error a reason is: bytes and numbers taken out of it."""
    reason = re.sub(r"^(unknown letter|no reply) .*$", r"\1 _", reason)
    reason = re.sub(r": .+ where", ": _ where", reason)
    return re.sub(r"is \d+,", "is _,", reason)


def reasons_by_brute_force() -> set[str]:
    """The shapes of all reasons: every first byte, every byte in every place, every value."""
    streams = [bytes([byte]) + b"000000" for byte in range(256)]
    for letter in b"FBLRSHV":
        for position, byte in product(range(1, 7), range(256)):
            raw = bytearray([letter, *b"000000"])
            raw[position] = byte
            streams.append(bytes(raw))
        streams += [b"%c%03d000" % (letter, value) for value in range(1000)]
        streams += [b"%c000%03d" % (letter, value) for value in range(1000)]
    items = [*CommandDecoder(EXTENSIONS).receive_data(b"".join(streams))]
    items += ReplyDecoder().receive_data(bytes(range(256)))
    return {shape(item.reason) for item in items if isinstance(item, Malformed)}


def test_every_reason_has_a_vector() -> None:
    found = reasons_by_brute_force()
    # Four commands and the extension's two fields: no digit, out of range. Four lamps: no digit. Letters, replies.
    assert len(found) == (4 + 2) * 2 + 4 + 2
    in_vectors = {
        shape(item.error) for vector in VECTORS for item in vector.expected() if isinstance(item, Bad)
    }
    # The extension's first field differs from its second by the name alone.
    assert found - in_vectors == {"set_servos: _ where a digit of left_deg must be"}
    assert in_vectors <= found


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: message.name())
def test_every_message_has_a_valid_and_an_invalid_vector(message: type[SimpleMessage]) -> None:
    valid = [
        vector
        for vector in VECTORS
        for item in vector.expected()
        if isinstance(item, Good) and item.message.split()[0] == message.name()
    ]
    assert {vector.direction for vector in valid} == {"from robot" if message in REPLIES else "to robot"}
    assert any(vector.attempts == message.name() for vector in VECTORS)


@pytest.mark.parametrize("message", COMMANDS, ids=lambda message: message.name())
def test_every_command_has_a_vector_in_which_anything_will_do(message: type[SimpleCommand]) -> None:
    assert any(
        isinstance(item, Good) and item.message.split()[0] == message.name() and item.canonical
        for item in (item for vector in TOPICS["dont-care"].vectors for item in vector.expected())
    )


def test_every_event_has_a_session() -> None:
    found = {text.split()[0] for session in SESSIONS for step in session.steps for text in step.events}
    assert found == {"done", "superseded", "out_of_step", "in_step", "gave_up", "link_dead"}
    assert Stop in COMMANDS
