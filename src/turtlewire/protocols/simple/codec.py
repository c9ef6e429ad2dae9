"""simple: messages to bytes and back, streaming.

A command is exactly seven bytes, a reply one. There is nothing that marks a beginning: a decoder counts, as the robot
does, and one byte too many or too few puts it out of step until somebody gets it back (S7). Every decoder takes any
bytes in any chunking, gives the same items for every chunking, and keeps at most six bytes.
"""

from __future__ import annotations

from functools import cache
from operator import attrgetter
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.errors import UsageError
from turtlewire.protocols.message import Decoded, Field, Malformed
from turtlewire.protocols.simple.messages import (
    COMMANDS,
    DONT_CARE,
    LENGTH,
    REPLIES,
    SimpleCommand,
    SimpleMessage,
)

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

# How many digits a field of a kind takes, and the greatest number that they can say.
DIGITS = {"u8": (3, 255), "u16": (3, 999), "bit": (1, 1)}

Item = Decoded[SimpleMessage] | Malformed


class Column(NamedTuple):
    """Where the digits of one field stand in the seven bytes: from ``start`` to before ``end``."""

    field: Field
    start: int
    end: int


class Layout(NamedTuple):
    """How one command's seven bytes are laid out; what no column covers is don't care (S2)."""

    command_type: type[SimpleCommand]
    columns: tuple[Column, ...]


def _layout(command_type: type[SimpleCommand]) -> Layout:
    columns = []
    end = 1
    for field in command_type.FIELDS:
        digits, highest = DIGITS.get(field.kind, (LENGTH, 0))
        start, end = end, end + digits
        if end > LENGTH or not 0 <= field.low <= field.high <= highest:
            raise UsageError(
                f"{command_type.name()}: {field.name} ({field.kind}, {field.low} to {field.high}) does not fit: there "
                "are six positions for fields; u8 takes three of them (0 to 255), u16 three (0 to 999), bit one"
            )
        columns.append(Column(field, start, end))
    return Layout(command_type, tuple(columns))


@cache
def layouts(extensions: tuple[type[SimpleCommand], ...] = ()) -> dict[int, Layout]:
    """The layout of every command by its first byte, those of ``extensions`` included (S10).

    Raises ``UsageError`` if an extension has no capital letter or channel of its own, or fields that do not fit.
    """
    table: dict[int, Layout] = {}
    channels = {command_type.CHANNEL for command_type in COMMANDS}
    for command_type in extensions:
        if command_type.CHANNEL in channels:
            raise UsageError(
                f"{command_type.name()}: its channel {command_type.CHANNEL!r} must be one of its own "
                f"(taken are {', '.join(sorted(channels - {''}))})"
            )
    for command_type in (*COMMANDS, *extensions):
        letter = command_type.LETTER
        if len(letter) != 1 or not (letter.isalpha() and letter.isupper()) or letter[0] in table:
            raise UsageError(
                f"{command_type.name()}: its letter {letter!r} must be one capital letter A to Z that no other "
                f"command has (taken are {bytes(table).decode()})"
            )
        table[letter[0]] = _layout(command_type)
    return table


def encode(message: SimpleMessage) -> bytes:
    """The bytes of a message: seven of a command, with ``0`` wherever anything will do (S2); one of a reply.

    Raises ``MessageError`` if a field is out of range.
    """
    return _encoder(type(message))(message)


@cache
def _encoder(message_type: type[SimpleMessage]) -> Callable[[SimpleMessage], bytes]:
    """What encodes one kind of message: into its bytes with a place for each field, made once."""
    fields = message_type.FIELDS
    if not issubclass(message_type, SimpleCommand):
        return lambda _: message_type.LETTER
    places = [b"%%0%dd" % DIGITS[field.kind][0] for field in fields]
    template = message_type.LETTER + b"".join(places)
    template += DONT_CARE * (LENGTH - 1 - sum(DIGITS[field.kind][0] for field in fields))
    if not fields:
        return lambda _: template
    values: Callable[[SimpleMessage], Any] = attrgetter(*(field.name for field in fields))
    if len(fields) > 1:
        return lambda message: template % values(message.check())
    low, high = fields[0].low, fields[0].high

    def encode_one(message: SimpleMessage) -> bytes:
        value = values(message)
        if type(value) is not int or not low <= value <= high:
            message.check()
        encoded: bytes = template % value
        return encoded

    return encode_one


def _shown(byte: int) -> str:
    return repr(chr(byte)) if 0x20 < byte < 0x7F else f"{byte:02X}"


def decode(raw: bytes, table: dict[int, Layout]) -> SimpleCommand | str:
    """The command that seven bytes are, or why they are none (S3)."""
    layout = table.get(raw[0])
    if layout is None:
        return f"unknown letter {_shown(raw[0])}"
    values = []
    for field, start, end in layout.columns:
        text = raw[start:end]
        if not text.isdigit():
            wrong = next(byte for byte in text if not 0x30 <= byte <= 0x39)
            return f"{layout.command_type.name()}: {_shown(wrong)} where a digit of {field.name} must be"
        value = int(text)
        if field.kind == "bit":
            value = min(value, 1)  # any digit but 0 is on
        if not field.low <= value <= field.high:
            return f"{layout.command_type.name()}: {field.name} is {value}, but must be {field.low} to {field.high}"
        values.append(value)
    return layout.command_type(*values)


class CommandDecoder:
    """Host to robot: what a robot's end makes of the bytes it receives, seven by seven.

    ``extensions`` are commands beyond the source's that this robot knows (S10). Raises ``UsageError`` if one of them
    cannot be told from another command, or does not fit.
    """

    def __init__(self, extensions: tuple[type[SimpleCommand], ...] = ()) -> None:
        self._table = layouts(extensions)
        self._offset = 0
        self._raw = b""

    def reset(self) -> None:
        """Forget a command that has begun."""
        self._raw = b""

    @property
    def pending(self) -> bytes:
        """What has been taken of an unfinished command: at most six bytes."""
        return self._raw

    def receive_data(self, data: bytes) -> list[Item]:
        """Take bytes; return what they completed, in order."""
        first = self._offset - len(self._raw)
        self._offset += len(data)
        data = self._raw + data
        end = len(data) - len(data) % LENGTH
        self._raw = data[end:]
        items: list[Item] = []
        for start in range(0, end, LENGTH):
            raw = data[start : start + LENGTH]
            result = decode(raw, self._table)
            if isinstance(result, str):
                items.append(Malformed(first + start, raw, result))
            else:
                items.append(Decoded(first + start, raw, result))
        return items


_REPLIES: dict[int, SimpleMessage] = {reply_type.LETTER[0]: reply_type() for reply_type in REPLIES}


class ReplyDecoder:
    """Robot to host: every byte is a reply, or nothing that a robot says."""

    def __init__(self) -> None:
        self._offset = 0

    def receive_data(self, data: bytes) -> list[Item]:
        """Take bytes; return what each of them is."""
        items: list[Item] = []
        for offset, byte in enumerate(data, self._offset):
            raw = bytes([byte])
            reply = _REPLIES.get(byte)
            if reply is None:
                items.append(Malformed(offset, raw, f"no reply {_shown(byte)}"))
            else:
                items.append(Decoded(offset, raw, reply))
        self._offset += len(data)
        return items
