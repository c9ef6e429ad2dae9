"""What must hold of each decoder for any bytes in any chunking.

The items are the same, every byte is in one of them, and little is kept.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from turtlewire.capture import MAX_LINE_BYTES, Header, Parser, encode_header
from turtlewire.errors import DataError
from turtlewire.protocols import forms
from turtlewire.protocols.catalogue import Settings, codec
from turtlewire.protocols.message import Decoded
from turtlewire.protocols.stream import SKIPPED_BYTES

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from turtlewire.protocols.catalogue import Codec, Sender
    from turtlewire.protocols.stream import Item

# The longest thing that any of the protocols waits for is a frame.
MAX_KEPT_BYTES = SKIPPED_BYTES + 127
# The forms are looked at in one of so many inputs: they take longest.
FORMS_OF = 8
HEADER = encode_header(Header.of(0, protocol="", baud=0, host="", robot=""))


def chunks(data: bytes, seed: int) -> Iterator[bytes]:
    """Pieces whose sizes follow from a byte: 0 makes single bytes, 255 one piece."""
    at = 0
    while at < len(data):
        size = len(data) if seed == 255 else 1 + (seed * (at + 3)) % (1 + seed)
        yield data[at : at + size]
        at += size


@cache
def _codec(name: str, settings: Settings) -> Codec:
    return codec(name, settings)


def _decoder_check(name: str, sender: Sender, settings: Settings) -> Callable[[bytes], None]:
    def check(data: bytes) -> None:
        seed, data = (data[0], data[1:]) if data else (0, b"")
        protocol = _codec(name, settings)
        whole, chunked = protocol.decoder(sender), protocol.decoder(sender)
        items: list[Item] = []
        for chunk in chunks(data, seed):
            items += chunked.receive_data(chunk)
            assert len(chunked.kept) <= MAX_KEPT_BYTES
        items += chunked.finish()
        assert items == [*whole.receive_data(data), *whole.finish()]
        assert b"".join(item.raw for item in items) == data
        at = 0
        for item in items:
            assert item.offset == at
            assert item.raw
            at += len(item.raw)
            if seed % FORMS_OF == 0:
                _check_forms(item, protocol, sender)

    return check


def _check_forms(item: Item, protocol: Codec, sender: Sender) -> None:
    """What is shown of it means the same again."""
    said = forms.read_text_line(forms.text_line(item, sender=sender, t_ns=at_ns(item)), protocol)
    again = forms.read_json_line(forms.json_line(item, protocol, sender), protocol)
    assert said == again
    assert isinstance(item, Decoded) or said is None


def at_ns(item: Item) -> int:
    return item.offset * 1_000_003


def _check_capture(data: bytes) -> None:
    """Any file is read or refused, alike in any chunking. Half of them begin as a recording does."""
    seed, data = (data[0], data[1:]) if data else (0, b"")
    if seed % 2:
        data = HEADER + data
    outcomes = []
    for pieces in ([data], chunks(data, seed)):
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


TARGETS: dict[str, Callable[[bytes], None]] = {
    "walter-host": _decoder_check("walter", "host", Settings()),
    "walter-host-direct": _decoder_check("walter", "host", Settings(mode="direct")),
    "walter-robot": _decoder_check("walter", "robot", Settings()),
    "simple-host": _decoder_check("simple", "host", Settings()),
    "simple-robot": _decoder_check("simple", "robot", Settings()),
    "frame-host": _decoder_check("frame", "host", Settings()),
    "frame-robot": _decoder_check("frame", "robot", Settings(dialect="telemetry", coverage="payload")),
    "capture": _check_capture,
}
