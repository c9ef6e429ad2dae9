"""The vectors of WALTER, run against the codec and the robot's end: both ways, whole, byte by byte and cut anywhere.

The files in ``spec/vectors/walter`` were written by hand from the protocol; the firmware runs them too.
"""

from __future__ import annotations

import copy
import re
from typing import Annotated, Literal

import msgspec
import pytest
from msgspec import Meta, Struct

from tests.vectors import runner
from tests.vectors.runner import AnySession, Bad, Good, Hex, Natural, Runner, Text, Topic
from turtlewire.protocols.message import Malformed
from turtlewire.protocols.walter.codec import ALL_GROUPS, CommandDecoder, Mode, ReplyDecoder, encode
from turtlewire.protocols.walter.messages import (
    DIRECT_KEYS,
    MESSAGES,
    ROBOT_MESSAGES,
    EmptyLine,
    WalterMessage,
)
from turtlewire.protocols.walter.robot import Robot

# ------------------------------------------------------------------------------------------------- the schema

Section = Annotated[
    str,
    Meta(
        pattern=r"^(LOGO CONTROL \((To|From) the robot\)|DIRECT CONTROL \(To the robot\)|Notes|W\d+|Section 4)$"
    ),
]
Groups = Annotated[str, Meta(pattern=r"^C?Q?H?E?$")]
ModeName = Literal["logo", "direct"]


class Vector(runner.Vector, forbid_unknown_fields=True, frozen=True, kw_only=True):
    section: Section
    mode: ModeName
    groups: Groups = "CQHE"
    mode_after: ModeName


class Step(Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """At a time, one of: bytes arrive, the next command is taken, a limit sensor trips. Then: queue and mode."""

    at_ms: Natural
    receive: Hex | None = None
    at_once: list[Text] | None = None
    take: Text | msgspec.UnsetType | None = msgspec.UNSET
    limit: Literal["front", "back", "left", "right"] | None = None
    sends: Hex | None = None
    queue: list[Text]
    mode: ModeName


class Counts(Struct, forbid_unknown_fields=True, frozen=True):
    heard: Natural
    malformed: Natural
    overflowed: Natural


class Session(AnySession, forbid_unknown_fields=True, frozen=True, kw_only=True):
    section: Section
    mode: ModeName
    groups: Groups = "CQHE"
    steps: list[Step]
    counts: Counts


TOPICS = runner.read_topics("walter", Topic[Vector, Session])
VECTORS = [vector for topic in TOPICS.values() for vector in topic.vectors]
SESSIONS = [session for topic in TOPICS.values() for session in topic.sessions]
BY_NAME = {message.name(): message for message in MESSAGES}

each_vector = pytest.mark.parametrize("vector", VECTORS, ids=lambda vector: vector.id)
each_session = pytest.mark.parametrize("session", SESSIONS, ids=lambda session: session.id)


def test_there_are_all_the_topics() -> None:
    names = {
        "direct-keys",
        "logo-absolute",
        "logo-lines",
        "logo-moves",
        "logo-pen-horn-lamp",
        "logo-queries",
        "modes",
        "replies",
        "robots-without-groups",
        "sessions",
    }
    runner.check_topics("walter", TOPICS, names)


def test_ids_are_unique_and_begin_with_the_topic() -> None:
    runner.check_ids(TOPICS, SESSIONS)


@each_vector
def test_items_stand_in_the_bytes_where_they_say(vector: Vector) -> None:
    data = vector.data()
    end = 0
    for item in vector.expected():
        raw = bytes.fromhex(item.raw)
        assert raw
        assert data[item.offset : item.offset + len(raw)] == raw
        # Between two items nothing but one LF after RET is skipped.
        assert data[end : item.offset] in (b"", b"\n")
        end = item.offset + len(raw)
        if isinstance(item, Good):
            runner.check_message(item, MESSAGES)
    assert data[end : len(data) - vector.pending] in (b"", b"\n")
    if vector.attempts is not None:
        assert vector.attempts in BY_NAME
        assert vector.pending or any(isinstance(item, Bad) for item in vector.expected())


@each_session
def test_steps_are_each_one_thing_in_order_of_time(session: Session) -> None:
    runner.check_times(session.steps)
    for step in session.steps:
        taken = step.take is not msgspec.UNSET
        assert [step.receive is not None, taken, step.limit is not None].count(True) == 1
        assert (step.receive is None) == (step.at_once is None)
        assert (step.limit is None) == (step.sends is None)


# ------------------------------------------------------------------------------------------------- the runner


def decoder_for(vector: Vector) -> CommandDecoder | ReplyDecoder:
    if vector.direction == "from robot":
        return ReplyDecoder()
    return CommandDecoder(Mode(vector.mode), frozenset(vector.groups))


def rest(decoder: CommandDecoder | ReplyDecoder, vector: Vector) -> tuple[object, object]:
    return (decoder.mode.value, decoder.pending), (vector.mode_after, vector.pending)


WALTER = Runner(decoder_for, lambda vector, moved: runner.items_of(vector, MESSAGES, moved), rest)


@each_vector
def test_decoding_in_every_chunking(vector: Vector) -> None:
    WALTER.check_decoding(vector)


@each_vector
def test_encoding_gives_the_canonical_bytes(vector: Vector) -> None:
    runner.check_encoding(vector, MESSAGES, encode)


# Vectors after which a decoder stands where it began.
CLOSED = [v for v in VECTORS if not v.pending and v.mode_after == v.mode and v.data()[:1] != b"\n"]


@pytest.mark.parametrize("vector", CLOSED, ids=lambda vector: vector.id)
def test_nothing_is_left_behind_for_the_next(vector: Vector) -> None:
    WALTER.check_decoding_again(vector)


def waiting(robot: Robot) -> list[str]:
    """The queue, looked at without touching it."""
    other = copy.deepcopy(robot)
    return [str(other.next_command()) for _ in range(other.queued)]


def run(session: Session, cut: int | None, whole: bool) -> None:
    """Run a session: received bytes whole, byte by byte, or each step's cut at ``cut``."""
    robot = Robot(Mode(session.mode), frozenset(session.groups))
    for step in session.steps:
        if step.receive is not None:
            data = bytes.fromhex(step.receive)
            chunks = (
                [data] if whole else [bytes([b]) for b in data] if cut is None else [data[:cut], data[cut:]]
            )
            assert [str(a) for chunk in chunks for a in robot.receive_data(chunk)] == step.at_once, step
        elif step.limit is not None:
            assert robot.limit_tripped(step.limit).hex(" ").upper() == step.sends
        else:
            taken = robot.next_command()
            assert (None if taken is None else str(taken)) == step.take, step
        assert waiting(robot) == step.queue, step
        assert robot.mode.value == step.mode, step
    assert Counts(robot.heard, robot.malformed, robot.overflowed) == session.counts


@each_session
def test_sessions_with_a_robot(session: Session) -> None:
    run(session, cut=None, whole=True)
    run(session, cut=None, whole=False)
    longest = max(len(bytes.fromhex(step.receive or "")) for step in session.steps)
    for cut in range(longest + 1):
        run(session, cut=cut, whole=False)


# ----------------------------------------------------------------------------------------------- nothing is missing


def shape(reason: str) -> str:
    """What kind of error a reason is: bytes and letters taken out of it."""
    reason = re.sub(r"^no key [0-9A-F]{2}$", "no key _", reason)
    reason = re.sub(r"^[0-9A-F]{2} where", "_ where", reason)
    reason = re.sub(r" after .*$", " after _", reason)
    return re.sub(r"^unknown letter .+?(?=( after _)?$)", "unknown letter _", reason)


# Every error that can happen, by hand.
SHAPES = {
    "no key _",
    "_ where RET must be",
    "RET after _",
    "unknown letter _",
    "unknown letter _ after _",
    "heading_reply: value out of range",
    "towards_reply: value out of range",
    "pen_reply: value out of range",
}


def reasons_by_brute_force() -> set[str]:
    """The shapes of all reasons that any bytes can give: every two bytes, and every value of every message."""
    found = set()
    decoders: list[CommandDecoder | ReplyDecoder]
    decoders = [
        CommandDecoder(),
        CommandDecoder(groups=frozenset()),
        CommandDecoder(Mode.DIRECT),
        ReplyDecoder(),
    ]
    for decoder in decoders:
        mode = decoder.mode
        streams = [bytes([first, second, 0x0D]) for first in range(256) for second in range(256)]
        for message in MESSAGES:
            size = sum(2 if field.kind in ("u16", "i16") else 1 for field in message.FIELDS)
            streams += [message.LETTERS + bytes([byte]) * (size + 1) + b"\r" for byte in range(256)]
            streams += [message.LETTERS + bytes([byte]) * size + b"\r" for byte in range(256)]
        for stream in streams:
            decoder.mode = mode
            decoder.reset()
            found |= {item.reason for item in decoder.receive_data(stream) if isinstance(item, Malformed)}
    return {shape(reason) for reason in found}


def test_every_reason_has_a_vector() -> None:
    in_vectors = {
        shape(item.error) for vector in VECTORS for item in vector.expected() if isinstance(item, Bad)
    }
    assert in_vectors == SHAPES
    assert reasons_by_brute_force() == SHAPES


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: message.name())
def test_every_message_has_a_valid_and_an_invalid_vector(message: type[WalterMessage]) -> None:
    valid = [
        vector
        for vector in VECTORS
        for item in vector.expected()
        if isinstance(item, Good) and item.message.split()[0] == message.name()
    ]
    assert any(vector.origin == "source" for vector in valid) or message is EmptyLine
    assert any(vector.attempts == message.name() for vector in VECTORS)
    sides = {vector.direction for vector in valid}
    if message is not EmptyLine:
        assert sides == {"from robot" if message in ROBOT_MESSAGES else "to robot"}


# A bit can be neither: that pen_reply reads by length all the same is for an invalid vector to say.
BINARY = [m for m in MESSAGES if m.FIELDS and m.FIELDS[0].kind != "bit"]


@pytest.mark.parametrize("message", BINARY, ids=lambda message: message.name())
def test_every_message_with_arguments_has_a_vector_with_ret_or_lf_in_them(
    message: type[WalterMessage],
) -> None:
    raws = [
        bytes.fromhex(item.raw)[len(message.LETTERS) : None if message in DIRECT_KEYS else -1]
        for vector in VECTORS
        for item in vector.expected()
        if isinstance(item, Good) and item.message.split()[0] == message.name()
    ]
    assert any(b"\r" in raw or b"\n" in raw for raw in raws)


LETTERED = [m for m in MESSAGES if m.LETTERS.lower() != m.LETTERS]


@pytest.mark.parametrize("message", LETTERED, ids=lambda message: message.name())
def test_every_message_with_letters_has_a_vector_in_lower_case(message: type[WalterMessage]) -> None:
    letters = message.LETTERS
    assert any(
        isinstance(item, Good)
        and item.message.split()[0] == message.name()
        and bytes.fromhex(item.raw)[: len(letters)] != letters
        for vector in VECTORS
        for item in vector.expected()
    )


def test_every_group_is_missing_in_some_vector() -> None:
    lacking = {group for vector in VECTORS for group in ALL_GROUPS - set(vector.groups)}
    assert lacking == ALL_GROUPS
