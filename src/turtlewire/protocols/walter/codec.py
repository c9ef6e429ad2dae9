"""WALTER: messages to bytes and back, streaming.

Both ends parse **by length**, never by looking for RET, because arguments are binary and may be 0D or 0A (W1).
An ill-formed line is dropped up to its RET (W6). Every decoder takes any bytes in any chunking, gives the same
items for every chunking, and keeps at most ``MAX_RAW`` bytes.
"""

from __future__ import annotations

from enum import Enum
from functools import cache
from typing import NamedTuple

from turtlewire.protocols.message import KINDS, Decoded, Malformed
from turtlewire.protocols.walter.messages import (
    DIRECT_KEYS,
    LOGO_COMMANDS,
    ROBOT_MESSAGES,
    DirectKey,
    EmptyLine,
    SelectDirect,
    SelectLogo,
    WalterMessage,
)

CR, LF = 0x0D, 0x0A
ALL_GROUPS = frozenset("CQHE")
# A dropped line is reported in pieces of at most this many bytes: it may never end.
MAX_RAW = 64


class Mode(Enum):
    """What a robot takes bytes for."""

    LOGO = "logo"
    DIRECT = "direct"


Item = Decoded[WalterMessage] | Malformed


def encode(message: WalterMessage) -> bytes:
    """The bytes of a message, with RET (a lone CR) where it has one.

    Raises ``MessageError`` if a field is out of range.
    """
    message.check()
    data = message.LETTERS
    for field, value in zip(message.FIELDS, message.values(), strict=True):
        size, signed = KINDS[field.kind]
        data += value.to_bytes(size, "big", signed=signed)
    return data if isinstance(message, DirectKey) else data + b"\r"


class _Form(NamedTuple):
    """How one message is laid out: the letters, then ``size`` bytes in fields."""

    message_type: type[WalterMessage]
    size: int


class _Tables(NamedTuple):
    """What a decoder of some message types looks up."""

    forms: dict[Mode, dict[bytes, _Form]]
    prefixes: frozenset[bytes]  # all beginnings of letters after which another letter must come


@cache
def _tables(types: tuple[type[WalterMessage], ...]) -> _Tables:
    forms: dict[Mode, dict[bytes, _Form]] = {Mode.LOGO: {}, Mode.DIRECT: {}}
    for t in types:
        mode = Mode.DIRECT if issubclass(t, DirectKey) else Mode.LOGO
        forms[mode][t.LETTERS] = _Form(t, sum(KINDS[field.kind][0] for field in t.FIELDS))
    lines = forms[Mode.LOGO]
    return _Tables(forms, frozenset(letters[:n] for letters in lines for n in range(len(letters))))


def _message(form: _Form, arguments: bytes) -> WalterMessage | None:
    """The message with these argument bytes, or None if a value is none that the protocol knows."""
    values = []
    position = 0
    for field in form.message_type.FIELDS:
        size, signed = KINDS[field.kind]
        value = int.from_bytes(arguments[position : position + size], "big", signed=signed)
        position += size
        if field.kind == "bit" and value in (0x30, 0x31):  # W4: ASCII 0 and 1 are read too
            value -= 0x30
        if not field.low <= value <= field.high:
            return None
        values.append(value)
    return form.message_type(*values)


class _LineDecoder:
    """Letters, arguments by length, RET; and direct control's keys while ``mode`` says so."""

    def __init__(self, types: tuple[type[WalterMessage], ...], mode: Mode) -> None:
        self.mode = mode
        self._forms, self._prefixes = _tables(types)
        self._offset = 0
        self.reset()

    def reset(self) -> None:
        """Forget a message that has begun; the mode stays."""
        self._raw = bytearray()
        self._form: _Form | None = None
        self._reason = ""
        self._may_skip_lf = False

    @property
    def pending(self) -> int:
        """How many bytes of an unfinished message have been taken."""
        return len(self._raw)

    def receive_data(self, data: bytes) -> list[Item]:
        """Take bytes; return what they completed, in order."""
        items: list[Item] = []
        for byte in data:
            self._offset += 1
            if self._may_skip_lf:
                self._may_skip_lf = False
                if byte == LF:
                    continue
            item = self._line_byte(byte) if self.mode is Mode.LOGO else self._key_byte(byte)
            if item is not None:
                items.append(item)
        return items

    def _line_byte(self, byte: int) -> Item | None:
        raw = self._raw
        raw.append(byte)
        if self._reason:
            return self._drop(byte)
        if self._form is None:
            return self._letter(byte)
        end = len(self._form.message_type.LETTERS) + self._form.size
        if len(raw) <= end:
            return None
        if byte != CR:
            self._reason = f"{byte:02X} where RET must be"
            return None
        message = _message(self._form, bytes(raw[len(self._form.message_type.LETTERS) : end]))
        if message is None:
            self._reason = f"{self._form.message_type.name()}: value out of range"
            return self._drop(byte)
        return self._complete(message)

    def _letter(self, byte: int) -> Item | None:
        raw = self._raw
        if byte == CR and len(raw) == 1:
            return self._complete(EmptyLine())
        letters = bytes(raw).upper()  # W2: letters in either case
        self._form = self._forms[Mode.LOGO].get(letters)
        if self._form is None and letters not in self._prefixes:
            shown = repr(chr(byte)) if 0x20 < byte < 0x7F else f"{byte:02X}"
            after = f" after {chr(raw[0])!r}" if len(raw) > 1 else ""
            self._reason = f"RET{after}" if byte == CR else f"unknown letter {shown}{after}"
            return self._drop(byte)
        return None

    def _drop(self, byte: int) -> Item | None:
        """W6: up to its RET, which may be the wrong byte itself."""
        if byte != CR and len(self._raw) < MAX_RAW:
            return None
        item = Malformed(self._offset - len(self._raw), bytes(self._raw), self._reason)
        self._raw = bytearray()
        if byte == CR:
            self._end()
        return item

    def _key_byte(self, byte: int) -> Item | None:
        raw = self._raw
        raw.append(byte)
        if self._form is None:
            self._form = self._forms[Mode.DIRECT].get(bytes(raw).upper())
        if self._form is not None:
            if len(raw) <= self._form.size:
                return None
            message = _message(self._form, bytes(raw[1:]))
            assert message is not None, "every byte is a speed"
            return self._complete(message, ret=False)
        if byte == CR:
            return self._complete(EmptyLine())  # no key, but a sign of life (section 4)
        item = Malformed(self._offset - 1, bytes(raw), f"no key {byte:02X}")
        self.reset()
        return item

    def _complete(self, message: WalterMessage, *, ret: bool = True) -> Decoded[WalterMessage]:
        item = Decoded(self._offset - len(self._raw), bytes(self._raw), message)
        self._end(ret=ret)
        if isinstance(message, SelectDirect):
            self.mode = Mode.DIRECT
        elif isinstance(message, SelectLogo):
            self.mode = Mode.LOGO
        return item

    def _end(self, *, ret: bool = True) -> None:
        self.reset()
        self._may_skip_lf = ret  # W1


@cache
def _commands(groups: frozenset[str]) -> tuple[type[WalterMessage], ...]:
    """What a robot with these capability groups understands; an empty line is no letter's."""
    lines = tuple(t for t in LOGO_COMMANDS if t is not EmptyLine and (not t.GROUP or t.GROUP in groups))
    return (*lines, *DIRECT_KEYS)


class CommandDecoder(_LineDecoder):
    """Host to robot: what a robot's end makes of the bytes it receives.

    It follows the changes of mode in the stream. ``groups`` are the capability groups that the robot has (W10): to a
    robot that lacks one, its letters are unknown ones.
    """

    def __init__(self, mode: Mode = Mode.LOGO, groups: frozenset[str] = ALL_GROUPS) -> None:
        super().__init__(_commands(groups), mode)


class ReplyDecoder(_LineDecoder):
    """Robot to host: replies and limit events. An empty line is nothing and gives ``EmptyLine``."""

    def __init__(self) -> None:
        super().__init__(ROBOT_MESSAGES, Mode.LOGO)
