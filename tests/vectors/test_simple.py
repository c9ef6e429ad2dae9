"""The vectors of simple, run against the codec, the robot's end and the host's: whole, byte by byte and cut anywhere.

The files in ``spec/vectors/simple`` were written by hand from the protocol; the firmware runs them too.
"""

from __future__ import annotations

import re
from itertools import product
from typing import Annotated, ClassVar, Literal

import pytest
from msgspec import Meta, Struct

from tests.vectors import runner
from tests.vectors.runner import AnySession, Bad, Good, Hex, Natural, Runner, Topic, chunkings
from turtlewire.protocols.message import Field, Malformed, parse
from turtlewire.protocols.simple.codec import CommandDecoder, ReplyDecoder, encode
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

Section = Annotated[str, Meta(pattern=r"^(ENKELT PROTOKOLL|EXEMPEL|FELKONTROLL|S\d+|Section 4)$")]


class State(Struct, forbid_unknown_fields=True, frozen=True):
    """What a robot that was just switched on does after the bytes."""

    drive: Annotated[int, Meta(ge=-255, le=255)]
    steer: Annotated[int, Meta(ge=-255, le=255)]
    lights: Annotated[str, Meta(pattern=r"^[01]{4}$")]


class Vector(runner.Vector, forbid_unknown_fields=True, frozen=True, kw_only=True):
    section: Section
    extensions: bool = False
    replies: Hex | None = None
    state: State | None = None


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


class Session(AnySession, forbid_unknown_fields=True, frozen=True, kw_only=True):
    section: Section
    settings: Settings
    steps: list[Step]
    state: str
    counts: Counts


TOPICS = runner.read_topics("simple", Topic[Vector, Session])
VECTORS = [vector for topic in TOPICS.values() for vector in topic.vectors]
SESSIONS = [session for topic in TOPICS.values() for session in topic.sessions]
BY_NAME = {message.name(): message for message in ALL}

each_vector = pytest.mark.parametrize("vector", VECTORS, ids=lambda vector: vector.id)
each_session = pytest.mark.parametrize("session", SESSIONS, ids=lambda session: session.id)


def test_there_are_all_the_topics() -> None:
    names = {
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
    runner.check_topics("simple", TOPICS, names)
    assert (len(VECTORS), len(SESSIONS)) == (90, 30)


def test_ids_are_unique_and_begin_with_the_topic() -> None:
    runner.check_ids(TOPICS, SESSIONS)


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
            runner.check_message(item, ALL)
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


def rest(decoder: CommandDecoder | ReplyDecoder, vector: Vector) -> tuple[object, object]:
    """A reply is one byte: nothing is ever left of one."""
    left = decoder.pending if isinstance(decoder, CommandDecoder) else b""
    return left, vector.data()[len(vector.data()) - vector.pending :]


SIMPLE = Runner(decoder_for, lambda vector, moved: runner.items_of(vector, ALL, moved), rest)


@each_vector
def test_decoding_in_every_chunking(vector: Vector) -> None:
    SIMPLE.check_decoding(vector)


@each_vector
def test_encoding_gives_the_canonical_bytes(vector: Vector) -> None:
    runner.check_encoding(vector, ALL, encode)


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
    SIMPLE.check_decoding_again(vector)


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
    runner.check_times(session.steps)
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
