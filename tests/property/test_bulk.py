"""Bulk decoding gives what the streaming decoders give, whatever the bytes are."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, ClassVar

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from turtlewire.protocols.message import Field
from turtlewire.protocols.simple import bulk as simple_bulk
from turtlewire.protocols.simple import codec as simple
from turtlewire.protocols.simple.messages import COMMANDS, SimpleCommand
from turtlewire.protocols.walter import bulk as walter_bulk
from turtlewire.protocols.walter import bulk_lines
from turtlewire.protocols.walter import codec as walter
from turtlewire.protocols.walter.messages import ATTENTION, DIRECT_KEYS, LOGO_COMMANDS, ROBOT_MESSAGES

if TYPE_CHECKING:
    from collections.abc import Iterator


class Servos(SimpleCommand, frozen=True):
    LETTER: ClassVar[bytes] = b"V"
    CHANNEL: ClassVar[str] = "servos"
    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("left", "u16", 10, 900, "units"),
        Field("on", "bit", 1, 1, "on"),
    )
    left: int
    on: int


@st.composite
def of(draw: st.DrawFn, types: tuple[type[Any], ...]) -> Any:
    message_type = draw(st.sampled_from(types))
    return message_type(*(draw(st.integers(field.low, field.high)) for field in message_type.FIELDS))


def bytes_of(telling: bytes) -> st.SearchStrategy[bytes]:
    return st.lists(st.sampled_from(telling) | st.integers(0, 255), max_size=12).map(bytes)


simple_streams = st.lists(
    st.one_of(
        of((*COMMANDS, Servos)).map(simple.encode),
        st.tuples(
            st.sampled_from(b"FBLRSHV"), st.lists(st.sampled_from(b"0123456789/:x"), min_size=6, max_size=6)
        ).map(lambda parts: bytes([parts[0], *parts[1]])),
        bytes_of(b"0123456789FBLRSHVK"),
    ),
    max_size=12,
).map(b"".join)

walter_streams = st.lists(
    st.one_of(
        of((*LOGO_COMMANDS, *DIRECT_KEYS, *ROBOT_MESSAGES)).map(walter.encode),
        of((*LOGO_COMMANDS, *ROBOT_MESSAGES)).map(walter.encode).map(bytes.lower),
        st.sampled_from((b"\n", b"\r", b"\r\n", b"2\r", b"2\r\n", b"1", ATTENTION, b"QP0\r", b"QP1\r")),
        bytes_of(b"12FBVLRPUDHECQTXYgbGB0 \r\n\x00"),
        st.integers(60, 140).map(bytes),
    ),
    max_size=20,
).map(b"".join)

block_sizes = st.sampled_from((0, 1, 2, 5, 9, 30))


@settings(deadline=None)
@given(simple_streams, st.sampled_from(((), (Servos,))))
def test_simple_commands(data: bytes, extensions: tuple[type[SimpleCommand], ...]) -> None:
    items = simple.CommandDecoder(extensions).receive_data(data)
    assert simple_bulk.decode_commands(data, extensions).items() == items


@settings(deadline=None)
@given(bytes_of(b"KF"))
def test_simple_replies(data: bytes) -> None:
    assert simple_bulk.decode_replies(data).items() == simple.ReplyDecoder().receive_data(data)


@contextmanager
def walter_blocks(size: int) -> Iterator[None]:
    """Captures are worked on in blocks of so many bytes, if size is not 0."""
    with pytest.MonkeyPatch.context() as patch:
        if size:
            patch.setattr(bulk_lines, "BLOCK", size)
        yield


@settings(deadline=None)
@given(walter_streams, st.sampled_from(walter.Mode), st.frozensets(st.sampled_from("CQHE")), block_sizes)
def test_walter_commands(data: bytes, mode: walter.Mode, groups: frozenset[str], block: int) -> None:
    decoder = walter.CommandDecoder(mode, groups)
    items = decoder.receive_data(data)
    with walter_blocks(block):
        capture = walter_bulk.decode_commands(data, mode, groups)
    assert capture.items() == items
    assert capture.mode is decoder.mode


@settings(deadline=None)
@given(walter_streams, block_sizes)
def test_walter_replies(data: bytes, block: int) -> None:
    with walter_blocks(block):
        capture = walter_bulk.decode_replies(data)
    assert capture.items() == walter.ReplyDecoder().receive_data(data)
