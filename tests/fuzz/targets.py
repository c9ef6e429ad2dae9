"""What must hold of each decoder for any bytes in any chunking.

The items are the same, every byte is in one of them, and little is kept. Now and then it is also seen that what a
message is encoded to and what an item shows of itself mean the same again, and that bulk decoding finds the same.
How an input is looked at follows from its checksum: what leads somewhere new must not lead to what takes longest.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol
from zlib import crc32

from turtlewire.capture import MAX_LINE_BYTES, Header, Parser, encode_header
from turtlewire.errors import DataError, MessageError
from turtlewire.protocols import forms
from turtlewire.protocols.catalogue import Packet, Settings, codec
from turtlewire.protocols.message import Decoded, Malformed
from turtlewire.protocols.simple import bulk as simple_bulk
from turtlewire.protocols.stream import SKIPPED_BYTES, Skipped
from turtlewire.protocols.walter import bulk as walter_bulk
from turtlewire.protocols.walter.codec import Mode
from turtlewire.protocols.walter.messages import DirectKey

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from turtlewire.protocols.catalogue import Codec, Sender
    from turtlewire.protocols.columns import Capture
    from turtlewire.protocols.message import AnyMessage
    from turtlewire.protocols.stream import Item

# The longest thing that any of the protocols waits for is a frame.
MAX_KEPT_BYTES = SKIPPED_BYTES + 127
# How many bytes of an input are looked at: many short ones find more than few long ones. Protocols of longer messages
# or with faster decoders get a multiple. One in 64 is of the second kind.
LENGTHS = (10, 14, 10, 20, 10, 14, 10, 28, 10, 14, 10, 20, 10, 14, 10, 40)
LONG = (64, 128, 128, 512)
# What takes longer is done for one in so many.
ENCODED, SHOWN, IN_BULK = 16, 16, 128
UNFINISHED = "the stream ends within a message"
HEADER = encode_header(Header.of(0, protocol="", baud=0, host="", robot=""))


class Check(Protocol):
    """Sees that all holds for an input, or for all of it in one chunking."""

    def __call__(self, data: bytes, chunking: int | None = None) -> None:
        """Raises ``AssertionError``, or whatever a decoder raises."""


class Look(NamedTuple):
    """How an input is looked at: how much of it, how it is cut into chunks, and what is done besides."""

    length: int
    chunking: int
    besides: int


def look(data: bytes) -> Look:
    """By an input's checksum."""
    chance = crc32(data)
    length = LENGTHS[chance & 15] if chance >> 4 & 63 else LONG[chance & 3]
    return Look(length, chance >> 10 & 255, chance >> 18)


def chunks(data: bytes, seed: int) -> Iterator[bytes]:
    """Pieces whose sizes follow from a byte: 0 makes single bytes, 255 one piece."""
    at = 0
    while at < len(data):
        size = len(data) if seed == 255 else 1 + (seed * (at + 3)) % (1 + seed)
        yield data[at : at + size]
        at += size


def _decoder_check(
    name: str,
    sender: Sender,
    settings: Settings = Settings(),  # noqa: B008 - it cannot be changed
    bulk: Callable[[bytes], Capture[Any]] | None = None,
    times: int = 1,
) -> Check:
    protocol = codec(name, settings)

    def check(data: bytes, chunking: int | None = None) -> None:
        length, by_chance, besides = look(data)
        if chunking is None:
            data, chunking = data[: length * times], by_chance
        whole, chunked = protocol.decoder(sender), protocol.decoder(sender)
        items: list[Item] = []
        for chunk in chunks(data, chunking):
            items += chunked.receive_data(chunk)
            assert len(chunked.kept) <= MAX_KEPT_BYTES
        items += chunked.finish()
        assert items == [*whole.receive_data(data), *whole.finish()]
        at = 0
        for item in items:
            assert item.offset == at
            assert item.raw
            at += len(item.raw)
        assert b"".join([item.raw for item in items]) == data
        if items and besides % ENCODED == 0:
            _check_encoding(items[chunking % len(items)], protocol, sender)
        if items and besides % SHOWN == 1:
            _check_forms(items[chunking % len(items)], protocol, sender)
        if bulk is not None and besides % IN_BULK == 2:
            assert bulk(data).items() == [item for item in items if _is_in_bulk(item)]

    return check


def _is_in_bulk(item: Item) -> bool:
    """Bulk decoding says nothing of what is passed over in silence, and of what is unfinished."""
    return not isinstance(item, Skipped) and not (isinstance(item, Malformed) and item.reason == UNFINISHED)


def _check_encoding(item: Item, protocol: Codec, sender: Sender) -> None:
    """What was received can be sent, and is then received; only what breaks a restriction cannot."""
    if not isinstance(item, Decoded):
        return
    message: AnyMessage = item.message
    if isinstance(message, Packet):
        message = Packet(message.seq, message.messages, message.refused)
    try:
        raw = protocol.encode(message)
    except MessageError:
        assert isinstance(message, Packet)
        assert message.refused
        return
    direct = isinstance(message, DirectKey)
    receiver = codec("walter", Settings(mode="direct")) if direct else codec_of_lines(protocol)
    (again,) = receiver.decoder(sender).receive_data(raw)
    assert again == Decoded(0, raw, message)


def codec_of_lines(protocol: Codec) -> Codec:
    """What understands a message that is not of direct control, from the beginning."""
    return codec("walter") if protocol.name == "walter" else protocol


def _check_forms(item: Item, protocol: Codec, sender: Sender) -> None:
    """What is shown of it means the same again."""
    said = forms.read_text_line(forms.text_line(item, sender=sender, t_ns=at_ns(item)), protocol)
    again = forms.read_json_line(forms.json_line(item, protocol, sender), protocol)
    assert said == again
    assert isinstance(item, Decoded) or said is None


def at_ns(item: Item) -> int:
    return item.offset * 1_000_003


def _check_capture(data: bytes, chunking: int | None = None) -> None:
    """Any file is read or refused, alike in any chunking. Half of them begin as a recording does."""
    _, by_chance, besides = look(data)
    if chunking is None:
        chunking = by_chance
    if besides % 2:
        data = HEADER + data
    outcomes = []
    for pieces in ([data], chunks(data, chunking)):
        parser = Parser("it")
        records: list[object] = []
        try:
            for piece in pieces:
                records += parser.receive_data(piece)
                assert len(parser._rest) <= MAX_LINE_BYTES
            rest, torn = parser.close()
            outcomes.append((parser.header, [*records, *rest], torn))
        except DataError as error:
            # How many records came out before it depends on the chunking.
            outcomes.append((parser.header, [], str(error)))
    assert outcomes[0] == outcomes[1]


TARGETS: dict[str, Check] = {
    "walter-host": _decoder_check("walter", "host", bulk=walter_bulk.decode_commands),
    "walter-host-direct": _decoder_check(
        "walter", "host", Settings(mode="direct"), partial(walter_bulk.decode_commands, mode=Mode.DIRECT)
    ),
    "walter-robot": _decoder_check("walter", "robot", bulk=walter_bulk.decode_replies),
    "simple-host": _decoder_check("simple", "host", bulk=simple_bulk.decode_commands, times=3),
    "simple-robot": _decoder_check("simple", "robot", bulk=simple_bulk.decode_replies),
    "frame-host": _decoder_check("frame", "host", times=2),
    "frame-robot": _decoder_check(
        "frame", "robot", Settings(dialect="telemetry", coverage="payload"), times=2
    ),
    "capture": _check_capture,
}
