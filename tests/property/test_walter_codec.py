"""What holds for all bytes, all chunkings and all messages."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from hypothesis import given, settings
from hypothesis import strategies as st

from turtlewire.protocols.message import Decoded, Malformed, parse
from turtlewire.protocols.walter.codec import ALL_GROUPS, MAX_RAW, CommandDecoder, Mode, ReplyDecoder, encode
from turtlewire.protocols.walter.messages import (
    ATTENTION,
    DIRECT_KEYS,
    EMERGENCY_STOP,
    LOGO_COMMANDS,
    MESSAGES,
    QUEUE_COMMANDS,
    ROBOT_MESSAGES,
    SelectDirect,
    SelectLogo,
    WalterMessage,
)
from turtlewire.protocols.walter.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Callable

Decoder = CommandDecoder | ReplyDecoder

# Bytes that mean something are likelier than chance would have them.
TELLING = sorted({*b"\r\n\x00 12", *b"".join(m.LETTERS + m.LETTERS.lower() for m in MESSAGES)})
telling_bytes = st.lists(st.sampled_from(TELLING) | st.integers(0, 255), max_size=200).map(bytes)


@st.composite
def messages(draw: st.DrawFn, types: tuple[type[WalterMessage], ...] = MESSAGES) -> WalterMessage:
    message_type = draw(st.sampled_from(types))
    return message_type(*(draw(st.integers(field.low, field.high)) for field in message_type.FIELDS))


def streams(types: tuple[type[WalterMessage], ...]) -> st.SearchStrategy[bytes]:
    """Noise between well-formed messages."""
    return st.lists(telling_bytes | messages(types).map(encode), max_size=20).map(b"".join)


any_stream = streams(MESSAGES)
groups = st.frozensets(st.sampled_from(sorted(ALL_GROUPS)))
new_decoders: st.SearchStrategy[Callable[[], Decoder]] = st.one_of(
    st.just(ReplyDecoder),
    st.builds(lambda mode, groups: lambda: CommandDecoder(mode, groups), st.sampled_from(Mode), groups),
)


def cut(data: bytes, points: list[int]) -> list[bytes]:
    ends = [0, *sorted(min(point, len(data)) for point in points), len(data)]
    return [data[start:end] for start, end in pairwise(ends)]


@settings(deadline=None)
@given(new_decoders, any_stream, st.lists(st.integers(0, 500), max_size=12))
def test_every_chunking_gives_the_same_items(
    new_decoder: Callable[[], Decoder], data: bytes, points: list[int]
) -> None:
    whole, chunked, single = new_decoder(), new_decoder(), new_decoder()
    items = whole.receive_data(data)
    assert [item for chunk in cut(data, points) for item in chunked.receive_data(chunk)] == items
    assert [item for byte in data for item in single.receive_data(bytes([byte]))] == items
    assert whole.mode is chunked.mode is single.mode
    assert whole.pending == chunked.pending == single.pending


@settings(deadline=None)
@given(new_decoders, any_stream)
def test_every_byte_is_accounted_for(new_decoder: Callable[[], Decoder], data: bytes) -> None:
    decoder = new_decoder()
    items = decoder.receive_data(data)
    end = 0
    skipped = 0
    for item in items:
        gap = data[end : item.offset]
        assert gap in (b"", b"\n")  # nothing is skipped but one LF, and that only after RET
        assert not gap or data[end - 1] == 0x0D
        assert data[item.offset : item.offset + len(item.raw)] == item.raw
        assert 0 < len(item.raw) <= MAX_RAW
        skipped += len(gap)
        end = item.offset + len(item.raw)
    rest = data[end : len(data) - decoder.pending]
    assert rest in (b"", b"\n")
    assert sum(len(item.raw) for item in items) + skipped + len(rest) + decoder.pending == len(data)


@settings(deadline=None)
@given(new_decoders, st.lists(any_stream, max_size=10))
def test_memory_is_bounded(new_decoder: Callable[[], Decoder], chunks: list[bytes]) -> None:
    decoder = new_decoder()
    for chunk in chunks:
        decoder.receive_data(chunk)
        assert decoder.pending < MAX_RAW


@settings(deadline=None)
@given(new_decoders, any_stream)
def test_what_is_decoded_fits_the_wire_and_says_the_same_again(
    new_decoder: Callable[[], Decoder], data: bytes
) -> None:
    for item in new_decoder().receive_data(data):
        if isinstance(item, Decoded):
            again = encode(item.message)
            assert len(again) == len(item.raw)
            if item.raw != again:  # other case of letters (W2), or ASCII for a bit (W4)
                assert item.raw.upper() == again.upper() or item.message.name() == "pen_reply"
        else:
            assert item.reason


@given(messages())
def test_messages_come_back_from_their_text(message: WalterMessage) -> None:
    assert parse(str(message), MESSAGES) == message


@settings(deadline=None)
@given(st.lists(messages(ROBOT_MESSAGES)), st.booleans())
def test_replies_come_back_from_their_bytes(replies: list[WalterMessage], lf: bool) -> None:
    data = b"".join(encode(reply) + b"\n" * lf for reply in replies)
    assert [item[2] for item in ReplyDecoder().receive_data(data)] == replies


@settings(deadline=None)
@given(st.data(), st.sampled_from(Mode), st.booleans())
def test_commands_come_back_from_their_bytes_through_changes_of_mode(
    data: st.DataObject, mode: Mode, lf: bool
) -> None:
    decoder = CommandDecoder(mode)
    for _ in range(data.draw(st.integers(0, 20))):
        message = data.draw(messages(LOGO_COMMANDS if mode is Mode.LOGO else DIRECT_KEYS))
        wire = encode(message)
        if lf and mode is Mode.LOGO:
            wire += b"\n"
        assert [item[2] for item in decoder.receive_data(wire)] == [message]
        mode = {SelectDirect: Mode.DIRECT, SelectLogo: Mode.LOGO}.get(type(message), mode)
        assert decoder.mode is mode


@settings(deadline=None)
@given(st.sampled_from(Mode), groups, any_stream, st.lists(st.integers(0, 500), max_size=12))
def test_a_robot_ends_alike_for_every_chunking(
    mode: Mode, groups: frozenset[str], data: bytes, points: list[int]
) -> None:
    whole, chunked = Robot(mode, groups), Robot(mode, groups)
    actions = whole.receive_data(data)
    assert [action for chunk in cut(data, points) for action in chunked.receive_data(chunk)] == actions
    assert whole.mode is chunked.mode
    assert whole.queued <= QUEUE_COMMANDS
    assert (whole.heard, whole.malformed, whole.overflowed) == (
        chunked.heard,
        chunked.malformed,
        chunked.overflowed,
    )
    assert [whole.next_command() for _ in range(17)] == [chunked.next_command() for _ in range(17)]
    assert whole.next_command() is None


@settings(deadline=None)
@given(st.sampled_from(Mode), groups, any_stream)
def test_after_any_bytes_attention_and_emergency_stop_end_in_their_state(
    mode: Mode, groups: frozenset[str], data: bytes
) -> None:
    for sequence, ends_in in ((ATTENTION, Mode.LOGO), (EMERGENCY_STOP, Mode.DIRECT)):
        robot = Robot(mode, groups)
        robot.receive_data(data)
        robot.receive_data(sequence)
        assert (robot.mode, robot.queued) == (ends_in, 0)


@settings(deadline=None)
@given(new_decoders, st.binary(max_size=80))
def test_a_line_that_is_dropped_ends_at_its_first_ret(
    new_decoder: Callable[[], Decoder], noise: bytes
) -> None:
    decoder = new_decoder()
    decoder.mode = Mode.LOGO
    line = b"?" + noise.replace(b"\r", b"") + b"\r"
    items = decoder.receive_data(line)
    assert all(isinstance(item, Malformed) for item in items)
    assert b"".join(item.raw for item in items) == line
    assert decoder.pending == 0
