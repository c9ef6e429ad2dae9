"""What holds of frame for all bytes, all chunkings, all dialects."""

from __future__ import annotations

from itertools import pairwise
from random import Random
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from turtlewire.protocols.checksums import CATALOGUE, Coverage
from turtlewire.protocols.frame.codec import Frame, FrameDecoder, FrameEncoder, Item, frame_bytes
from turtlewire.protocols.frame.description import (
    AmbiguousDescription,
    Description,
    MessageDescription,
)
from turtlewire.protocols.frame.dialect import FROM_ROBOT, TO_ROBOT, Dialect, Entry, read_dialect, shipped
from turtlewire.protocols.frame.message import MAX_FRAME, MAX_PAYLOAD, FrameMessage
from turtlewire.protocols.message import KINDS, AnyField, Field, RealField, parse

DIALECTS = [shipped("0.1"), shipped("0.1-literal"), shipped("telemetry")]

# Messages of the same sizes with fields of every kind, limited and not.
VARIED = read_dialect(
    """
protocol = "frame"
dialect = "varied"

[enumerations]
colour = { red = 1, green = 2, blue = 7 }

[[message]]
name = "BytesOfAnyValue"
type = 0
direction = "both"
fields = [{ name = "a", kind = "u8" }, { name = "b", kind = "u8" }]

[[message]]
name = "LimitedBytes"
type = 1
direction = "both"
fields = [{ name = "a", kind = "u8", max = 99 }, { name = "b", kind = "u8", min = 3, max = 250 }]

[[message]]
name = "Whole"
type = 2
direction = "both"
fields = [{ name = "a", kind = "i16", min = -500, max = 500 }]

[[message]]
name = "TruthAndChoice"
type = 3
direction = "both"
fields = [{ name = "a", kind = "bool" }, { name = "b", kind = "u8", enumeration = "colour" }]

[[message]]
name = "Real"
type = 4
direction = "both"
fields = [{ name = "a", kind = "f32", min = -1, max = 1 }]

[[message]]
name = "Wider"
type = 5
direction = "both"
fields = [{ name = "a", kind = "u8", enumeration = "colour" }, { name = "b", kind = "i32" }]

[[message]]
name = "Bare"
type = 6
direction = "both"
fields = []
"""
)

dialects = st.builds(
    lambda dialect, crc, coverage: dialect.configured(crc=crc, coverage=coverage),
    st.sampled_from([*DIALECTS, VARIED]),
    st.sampled_from(sorted(CATALOGUE)),
    st.sampled_from([coverage.value for coverage in Coverage]),
)
directions = st.sampled_from([TO_ROBOT, FROM_ROBOT])


def field_values(field: AnyField, high: float) -> st.SearchStrategy[Any]:
    if isinstance(field, RealField):
        return st.floats(field.low, field.high, width=32)
    if field.choices:
        return st.sampled_from([number for _, number in field.choices])
    if field.kind == "bool":
        return st.booleans()
    return st.integers(field.low, int(high))


@st.composite
def messages(draw: st.DrawFn, dialect: Dialect, direction: str) -> FrameMessage:
    """One that may be sent; a direction without any has none."""
    entries = [entry for entry in dialect.entries if entry.is_sent and entry.goes(direction)]
    entry = draw(st.sampled_from(entries))
    values = [draw(field_values(field, dialect.high(entry, field))) for field in entry.message_type.FIELDS]
    return entry.message_type(*values)


# Bytes that mean something are likelier than chance would have them: magics, small sizes, types.
telling_bytes = st.lists(st.sampled_from([0xA3, 0, 1, 2, 3, 6, 0x10, 0x11, 124, 125]) | st.integers(0, 255))


def payload_of(entry: Entry, dialect: Dialect, chance: Random, wild: float) -> bytes:
    """A message with fields within their limits; so often with any."""
    if chance.random() < wild:
        return bytes((entry.type,)) + chance.randbytes(entry.layout.size - 1)
    values: list[float] = []
    for field in entry.message_type.FIELDS:
        if isinstance(field, RealField):
            values.append(chance.uniform(field.low, field.high))
        elif field.choices:
            values.append(chance.choice(field.choices)[1])
        else:
            values.append(chance.randint(field.low, int(dialect.high(entry, field))))
    return entry.layout.pack(entry.type, *values)


def similar(dialect: Dialect, direction: str, chance: Random) -> list[bytes]:
    """Payloads with messages in the same places, perhaps now and then of another type of the same size."""
    by_size: dict[int, list[Entry]] = {}
    for entry in dialect.entries:
        if entry.goes(direction):
            by_size.setdefault(entry.layout.size, []).append(entry)
    many = chance.choice([0, 1, 1, 2, 3, 9, 41])
    pattern = [chance.choice(list(by_size))] * many if by_size else []
    pattern = [chance.choice(list(by_size)) if chance.random() < 0.2 else size for size in pattern]
    while sum(pattern) > MAX_PAYLOAD:
        pattern.pop()
    usual = [chance.choice(by_size[size]) for size in pattern]
    change, noise, wild = (
        chance.choice([0, 0, rare, often]) for rare, often in ((0.01, 0.5), (0.002, 0.02), (0.01, 0.1))
    )
    payloads = []
    for _ in range(chance.choice([20, 60])):
        payload = b""
        for entry in usual:
            other = chance.choice(by_size[entry.layout.size]) if chance.random() < change else entry
            message = payload_of(other, dialect, chance, wild)
            if chance.random() < noise:
                message = bytes((chance.randrange(8),)) + message[1:]
            payload += message
        payloads.append(payload[: chance.randrange(125)] if chance.random() < noise else payload)
    return payloads


@st.composite
def streams(draw: st.DrawFn, dialect: Dialect, direction: str) -> bytes:
    """Frames with right CRCs around any payload, in order or not, between noise, damaged here and there."""
    out = bytearray()
    seq = draw(st.integers(0, 255))
    payloads = telling_bytes.map(lambda values: bytes(values)[:MAX_PAYLOAD])
    copies = st.sampled_from([1, 1, 2, 40])
    for _ in range(draw(st.integers(0, 6))):
        out += bytes(draw(st.just([]) | telling_bytes))
        alike = draw(st.booleans())
        chance = Random(draw(st.integers(0, 1 << 32)))
        for payload in similar(dialect, direction, chance) if alike else [draw(payloads)] * draw(copies):
            out += frame_bytes(dialect, seq, payload)
            seq = (seq + chance.choices([1, 0, 2, 5], [98, 1, 1, 1])[0]) % 256
    chance = Random(draw(st.integers(0, 1 << 32)))
    for _ in range(chance.choice([0, 0, 1, 4, len(out) // 300]) if out else 0):
        out[chance.randrange(len(out))] = chance.choice([0, 0xA3, chance.randrange(256)])
    return bytes(out[: draw(st.integers(0, len(out)))] if draw(st.booleans()) else out)


def cut(data: bytes, points: list[int]) -> list[bytes]:
    ends = [0, *sorted(min(point, len(data)) for point in points), len(data)]
    return [data[start:end] for start, end in pairwise(ends)]


def shown(items: list[Item]) -> list[str]:
    """Items as text: NaN equals itself there."""
    return [repr(item) for item in items]


@settings(deadline=None, max_examples=300)
@given(st.data(), dialects, directions, st.lists(st.integers(0, 6000), max_size=12))
def test_every_chunking_gives_the_same_items(
    data: st.DataObject, dialect: Dialect, direction: str, points: list[int]
) -> None:
    stream = data.draw(streams(dialect, direction))
    whole, chunked, single = (FrameDecoder(dialect, direction) for _ in range(3))
    items = shown(whole.receive_data(stream))
    assert shown([i for chunk in cut(stream, points) for i in chunked.receive_data(chunk)]) == items
    assert shown([i for byte in stream for i in single.receive_data(bytes([byte]))]) == items
    assert whole.statistics == chunked.statistics == single.statistics
    assert whole.pending == chunked.pending == single.pending < MAX_FRAME
    assert shown(whole.end()) == shown(single.end())


@settings(deadline=None)
@given(
    st.lists(st.booleans(), min_size=60, max_size=60), st.lists(st.integers(0, 59), max_size=3), st.booleans()
)
def test_what_is_refused_is_refused_in_a_row_too(types: list[bool], places: list[int], mixed: bool) -> None:
    """Each field of a message beyond its limits now and then, among messages that are fine."""
    payloads = [bytes((kind if mixed else 1, 5, 5)) for kind in types]
    for number, place in enumerate(places):
        payloads[place] = bytes((1, 100, 5)) if number % 2 else bytes((1, 5, 2))
    stream = b"".join(frame_bytes(VARIED, seq, payload) for seq, payload in enumerate(payloads))
    items = FrameDecoder(VARIED).receive_data(stream)
    decoder = FrameDecoder(VARIED)
    assert items == [item for byte in stream for item in decoder.receive_data(bytes([byte]))]
    refused = [n for n, item in enumerate(items) if isinstance(item, Frame) and item.refused]
    assert refused == sorted(set(places))


def test_the_first_of_many_frames_has_the_last_number() -> None:
    stream = b"".join(frame_bytes(VARIED, n % 256, b"\x00\x05\x05") for n in range(255, 400))
    items = FrameDecoder(VARIED).receive_data(stream)
    assert [item.seq for item in items if isinstance(item, Frame)] == [n % 256 for n in range(255, 400)]
    assert not any(item.order for item in items if isinstance(item, Frame))


def test_a_size_above_124_is_none_whatever_the_crc() -> None:
    """With a right CRC, too, alone and in a row (F3)."""
    for size in (125, 255):
        stream = b"".join(frame_bytes(VARIED, n, b"\x06" * size) for n in range(20))
        decoder = FrameDecoder(VARIED)
        assert not any(isinstance(item, Frame) for item in decoder.receive_data(stream) + decoder.end())
        assert decoder.statistics.oversized == 20


def plain_decoder(dialect: Dialect, direction: str, data: bytes) -> tuple[list[tuple[int, bytes]], int]:
    """The frames with a right CRC that a receiver takes, and what is left: F5 said as plainly as it can be."""
    taken, at = [], 0
    while at < len(data):
        if data[at] == 0xA3:
            if at + 2 >= len(data):
                break
            end = at + data[at + 2] + 4
            if data[at + 2] <= 124:
                if end > len(data):
                    break
                raw = data[at:end]
                if dialect.checksum.algorithm.crc(raw[dialect.checksum.coverage.first : -1]) == raw[-1]:
                    taken.append((at, raw))
                    at = end
                    continue
        at += 1
    return taken, len(data) - at


@settings(deadline=None)
@given(st.data(), dialects, directions)
def test_it_takes_what_a_plain_receiver_takes(data: st.DataObject, dialect: Dialect, direction: str) -> None:
    stream = data.draw(streams(dialect, direction))
    decoder = FrameDecoder(dialect, direction)
    items = decoder.receive_data(stream)
    ignored = ("unknown type", "cut short")
    taken = [
        (item.offset, item.raw)
        for item in items
        if isinstance(item, Frame) or any(words in item.reason for words in ignored)
    ]
    stats = decoder.statistics
    assert (taken, decoder.pending) == plain_decoder(dialect, direction, stream)
    # Every byte belongs to a frame, is pending or was skipped.
    assert sum(len(raw) for _, raw in taken) + stats.skipped_bytes + decoder.pending == len(stream)
    frames = [item for item in items if isinstance(item, Frame)]
    assert stats.frames == len(frames)
    assert stats.messages == sum(len(frame.messages) for frame in frames)
    assert sum(stats.refused.values()) == sum(len(frame.refused) for frame in frames)
    assert stats.unknown_type + stats.inconsistent == len(taken) - len(frames)
    assert stats.wrong_crc == sum("CRC" in item.reason for item in items if not isinstance(item, Frame))
    assert stats.oversized == sum("above" in item.reason for item in items if not isinstance(item, Frame))


@settings(deadline=None)
@given(st.data(), dialects, directions)
def test_every_frame_says_what_its_bytes_say(data: st.DataObject, dialect: Dialect, direction: str) -> None:
    stream = data.draw(streams(dialect, direction))
    due = None
    entries = {e.type: e for e in dialect.entries if e.is_decoded and e.goes(direction)}
    for item in FrameDecoder(dialect, direction).receive_data(stream):
        if isinstance(item, Frame):
            assert stream[item.offset : item.offset + len(item.raw)] == item.raw
            follows = due in (None, item.seq)
            assert (item.order == "") == follows
            assert item.lost == (0 if item.order != "gap" else (item.seq - (due or 0)) % 256)
            left, kept, refused = item.raw[3:-1], list(item.messages), list(item.refused)
            while left:
                entry = entries[left[0]]
                size = entry.layout.size
                message = entry.message_type(*entry.layout.unpack(left[:size])[1:])
                left = left[size:]
                fits = all(
                    field.fits(value) and value <= dialect.high(entry, field)
                    for field, value in zip(message.FIELDS, message.values(), strict=True)
                )
                assert repr(message) == repr((kept if fits else refused).pop(0))
            assert not kept
            assert not refused
            due = (item.seq + 1) % 256
        elif "cut" in item.reason or "type" in item.reason:
            due = (item.raw[1] + 1) % 256


@settings(deadline=None)
@given(st.data(), dialects, st.integers(0, 255), st.booleans())
def test_messages_come_back_from_their_frames(
    data: st.DataObject, dialect: Dialect, seq: int, to_robot: bool
) -> None:
    direction = TO_ROBOT if to_robot or dialect.name != "telemetry" else FROM_ROBOT
    sent = data.draw(st.lists(messages(dialect, direction), max_size=60))
    frames = FrameEncoder(dialect, direction, seq).encode(sent)
    decoder = FrameDecoder(dialect, direction)
    received = decoder.receive_data(b"".join(frames))
    assert [item.raw for item in received] == frames
    assert all(len(frame) <= MAX_FRAME for frame in frames)
    got = [message for item in received if isinstance(item, Frame) for message in item.messages]
    if dialect.name == "0.1-literal":
        assert [m.values() for m in got] == [m.values() for m in sent]
        assert not {type(m).__name__ for m in got} & {"EngineForward", "EngineBackward"}
    else:
        assert got == sent
    # As few frames as it takes: no message would have fitted the frame before (F9).
    for one, other in pairwise(frames):
        first = next(e.layout.size for e in dialect.entries if e.type == other[3] and e.goes(direction))
        assert len(one) - 4 + first > MAX_PAYLOAD


@given(st.data(), st.sampled_from(DIALECTS))
def test_messages_come_back_from_their_text(data: st.DataObject, dialect: Dialect) -> None:
    message = data.draw(messages(dialect, TO_ROBOT))
    again = dialect.parse(str(message))
    assert again == message
    assert parse(str(message), dialect.types) == message


# ------------------------------------------------------------------------------------------------ any dialect

kinds = st.sampled_from([kind for kind in KINDS if kind != "bit"])


@st.composite
def fields(draw: st.DrawFn, name: str) -> AnyField:
    kind = draw(kinds)
    if kind == "f32":
        ends = draw(
            st.lists(st.floats(width=32, allow_nan=False, allow_infinity=False), min_size=2, max_size=2)
        )
        return RealField(name, kind, min(ends), max(ends), "unit")
    size, signed = KINDS[kind]
    top = 1 if kind == "bool" else (1 << (8 * size - signed)) - 1
    bottom = -top - 1 if signed else 0
    if kind == "bool":
        return Field(name, kind, 0, 1, "unit")
    if draw(st.booleans()):
        numbers = draw(st.lists(st.integers(bottom, top), min_size=1, max_size=4, unique=True))
        return Field(name, kind, bottom, top, "unit", tuple((f"choice{n}", n) for n in numbers))
    low, high = sorted([draw(st.integers(bottom, top)), draw(st.integers(bottom, top))])
    return Field(name, kind, low, high, "unit")


@st.composite
def any_dialect(draw: st.DrawFn) -> Dialect:
    types = draw(st.lists(st.integers(0, 255), min_size=1, max_size=6, unique=True))
    described = []
    for number in types:
        made = tuple(draw(fields(f"field{n}")) for n in range(draw(st.integers(0, 5))))
        described.append(MessageDescription(f"M{number}", number, TO_ROBOT, "Doc.", "", None, made, "", ""))
    ambiguous: tuple[AmbiguousDescription, ...] = ()
    crc = draw(st.sampled_from(sorted(CATALOGUE)))
    coverage = draw(st.sampled_from(list(Coverage))).value
    return Dialect(Description("any", "Any", 9600, crc, coverage, {}, {}, tuple(described), ambiguous))


@settings(deadline=None)
@given(st.data(), any_dialect())
def test_any_dialect_encodes_and_decodes_its_messages(data: st.DataObject, dialect: Dialect) -> None:
    sent = data.draw(st.lists(messages(dialect, TO_ROBOT), max_size=30))
    decoder = FrameDecoder(dialect)
    received = decoder.receive_data(b"".join(FrameEncoder(dialect).encode(sent)))
    assert [message for item in received if isinstance(item, Frame) for message in item.messages] == sent
    assert sum(decoder.statistics.refused.values()) == 0
    for message in sent:
        assert dialect.parse(str(message)) == message


@settings(deadline=None)
@given(st.data(), any_dialect())
def test_of_any_dialect_a_message_is_carried_out_or_refused_as_check_says(
    data: st.DataObject, dialect: Dialect
) -> None:
    entry = data.draw(st.sampled_from(dialect.entries))
    size = entry.layout.size
    payload = bytes([entry.type]) + data.draw(st.binary(min_size=size - 1, max_size=size - 1))
    copies = data.draw(st.sampled_from([1, 30]))  # alone, and in a run
    stream = b"".join(frame_bytes(dialect, seq, payload) for seq in range(copies))
    for item in FrameDecoder(dialect).receive_data(stream):
        assert isinstance(item, Frame)
        (message,) = item.messages + item.refused
        fits = all(f.fits(v) for f, v in zip(message.FIELDS, message.values(), strict=True))
        assert bool(item.messages) == fits
