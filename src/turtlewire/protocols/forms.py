"""The two forms in which tools show what a wire carries, one line an item: text for people, JSON for programs.

Text: times and parties (of recordings), the offset, the message, and after ``#`` the bytes::

    0.001500  host        0  forward distance_half_mm=200            # 46 00 C8 0D
                          4  error: unknown letter '?'               # 3F 0D

JSON: the same, and more::

    {"offset":0,"raw":"46 00 C8 0D","from":"host","message":{"name":"forward","fields":{"distance_half_mm":200}}}
    {"offset":4,"raw":"3F 0D","from":"host","error":{"reason":"unknown letter '?'"}}

Both can be read back: what decodes to a line encodes to its canonical bytes.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import msgspec

from turtlewire.errors import DataError, MessageError
from turtlewire.protocols.catalogue import Packet
from turtlewire.protocols.message import Decoded, Malformed

if TYPE_CHECKING:
    from turtlewire.protocols.catalogue import Codec, Sender
    from turtlewire.protocols.message import AnyMessage
    from turtlewire.protocols.stream import Item

# Where the bytes begin in a line of text, when the message is not longer.
TEXT_WIDTH = 48
_PREFIX = re.compile(r"(?:\d+\.\d+\s+)?(?:(?:host|robot)\s+)?(?:\d+\s+)?(?P<text>.*)")
_encode = msgspec.json.Encoder().encode
_decode = msgspec.json.Decoder().decode


def hexadecimal(raw: bytes) -> str:
    """Bytes as they are written everywhere: ``46 00 C8 0D``."""
    return raw.hex(" ").upper()


def says(item: Item) -> str:
    """What an item says, without its bytes."""
    if isinstance(item, Decoded):
        return str(item.message)
    return f"error: {item.reason}" if isinstance(item, Malformed) else f"skipped: {item.reason}"


def text_line(item: Item, *, sender: Sender | None = None, t_ns: int | None = None) -> str:
    """An item as a line of text, without its line feed; sender and time stand first where they are given."""
    prefix = "" if t_ns is None else f"{t_ns / 1e9:12.6f}  "
    if sender is not None:
        prefix += f"{sender:5}  "
    return f"{prefix}{item.offset:>8}  {says(item):{TEXT_WIDTH}}  # {hexadecimal(item.raw)}"


def json_line(item: Item, codec: Codec, sender: Sender, t_ns: int | None = None) -> str:
    """An item as a line of JSON, without its line feed."""
    form: dict[str, Any] = {} if t_ns is None else {"t_ns": t_ns}
    form |= {"offset": item.offset, "raw": hexadecimal(item.raw), "from": sender}
    if isinstance(item, Decoded):
        form["message"] = codec.to_json(item.message)
    else:
        form["error" if isinstance(item, Malformed) else "skipped"] = {"reason": item.reason}
    return _encode(form).decode()


def read_text_line(line: str, codec: Codec) -> AnyMessage | None:
    """The message of a line of text, or of a bare text form; None of an error, of skipped bytes, and of nothing.

    Raises ``MessageError``.
    """
    match = _PREFIX.fullmatch(line.partition("#")[0].strip())
    text = match["text"] if match else line
    if not text or text.startswith(("error:", "skipped:")):
        return None
    return _sendable(codec.parse(text))


def _sendable(message: AnyMessage) -> AnyMessage | None:
    """None of a frame with messages that were refused: it is one of a decoder's errors, too."""
    return None if isinstance(message, Packet) and message.refused else message


def read_json_line(line: str, codec: Codec) -> AnyMessage | None:
    """The message of a line of JSON; None of an error, of skipped bytes, and of an empty line.

    Raises ``DataError`` for what is no such line, ``MessageError`` for a message that there is not.
    """
    if not line.strip():
        return None
    try:
        form = _decode(line)
    except msgspec.DecodeError as error:
        raise DataError(f"{line[:80]!r} is not JSON: {error}") from None
    match form:
        case {"error": _} | {"skipped": _}:
            return None
        case {"message": message}:
            return _sendable(codec.from_json(message))
    raise MessageError(f"{line[:80]!r} has neither a message nor an error")
