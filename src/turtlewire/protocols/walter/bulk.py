"""A whole capture at once, to columns: the streaming decoder's result, by NumPy (the extra ``turtlewire[bulk]``).

The first two bytes of a line tell how long it is. So it can be told of every byte of a capture whether a well-formed
line would begin there, if a line began there. Mostly each of these lines begins where the one before ends: such runs
are taken whole. Only where one ends must somebody look: there is a line to drop, a change of mode, an empty line, or
bytes that look like a line but are arguments.
"""

from __future__ import annotations

from bisect import bisect_left
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from turtlewire.protocols.message import KINDS, Decoded, Malformed
from turtlewire.protocols.walter.codec import (
    ALL_GROUPS,
    CR,
    LF,
    MAX_RAW,
    CommandDecoder,
    Item,
    Mode,
    ReplyDecoder,
)
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

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from turtlewire.protocols.message import Field

    # where each line begins, where the next one does, and what it is
    _Lines = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.uint8]]

BLOCK = 1 << 17  # of a capture are worked on at a time, so that they stay in the processor's cache
LONGEST = 8  # no line with the LF behind it is longer
_DTYPES = {"u16": np.uint16, "i16": np.int16}
_NONE = 255  # the number of no type

Types = tuple[type[WalterMessage], ...]
Column = Any  # NDArray of the field's kind


class Messages(NamedTuple):
    """All messages of one type, in order.

    Attributes:
        offset: where in the capture each begins.
        fields: a column for each field, by name.
    """

    offset: NDArray[np.int64]
    fields: dict[str, Column]


class Errors(NamedTuple):
    """All bytes that are no message, in order: dropped lines, in pieces as the streaming decoder's, and wrong keys.

    Attributes:
        offset: where in the capture they begin.
        length: how many they are.
        reason: why, as an index of ``reasons``, the texts.
    """

    offset: NDArray[np.int64]
    length: NDArray[np.int64]
    reason: NDArray[np.int64]
    reasons: tuple[str, ...]


class Capture(NamedTuple):
    """All that a streaming decoder makes of a capture.

    Attributes:
        data: the capture.
        messages: by the messages' classes; a class of which there is none has empty columns.
        errors: what is no message.
        mode: what the robot takes the next bytes for.
    """

    data: bytes
    messages: dict[type[WalterMessage], Messages]
    errors: Errors
    mode: Mode

    def items(self) -> list[Item]:
        """What ``receive_data`` of the streaming decoder returns: one object for each, which takes its time."""
        data = self.data
        items: list[Item] = []
        for message_type, (offsets, fields) in self.messages.items():
            length = _length(message_type)
            columns = [column.tolist() for column in fields.values()]
            items += (
                Decoded(offset, data[offset : offset + length], message_type(*values))
                for offset, *values in zip(offsets.tolist(), *columns, strict=True)
            )
        of_errors = (column.tolist() for column in self.errors[:3])
        items += (
            Malformed(offset, data[offset : offset + length], self.errors.reasons[reason])
            for offset, length, reason in zip(*of_errors, strict=True)
        )
        return sorted(items, key=lambda item: item.offset)


class _Tables(NamedTuple):
    """What is looked up; numbers are indices of ``types``.

    ``span`` tells which byte of a line that begins with two bytes decides about it, from 1: RET, or a wrong letter.
    """

    types: Types
    begins: bytes  # whether a line can begin with a byte
    number: NDArray[np.uint8]
    span: NDArray[np.uint8]
    narrow: tuple[int, ...]  # types of which not every value is one
    key: NDArray[np.uint8]
    takes: NDArray[np.bool_]  # keys that take a byte
    changes: NDArray[np.bool_]  # types that change to direct control
    decoder: Callable[[Mode], CommandDecoder | ReplyDecoder]


def _length(message_type: type[WalterMessage]) -> int:
    ret = not issubclass(message_type, DirectKey)
    return len(message_type.LETTERS) + sum(KINDS[field.kind][0] for field in message_type.FIELDS) + ret


def _cases(letters: bytes) -> list[list[int]]:
    """Both cases of each letter (W2)."""
    return [sorted({letter, *bytes([letter]).lower()}) for letter in letters]


def _tables(types: Types, decoder: Callable[[Mode], CommandDecoder | ReplyDecoder]) -> _Tables:
    number = np.full((256, 256), _NONE, np.uint8)
    span = np.ones((256, 256), np.uint8)
    key = np.full(256, _NONE, np.uint8)
    takes = np.zeros(256, np.bool_)
    for at, message_type in enumerate(types):
        if issubclass(message_type, DirectKey):
            (keys,) = _cases(message_type.LETTERS)
            key[keys] = at
            takes[keys] = bool(message_type.FIELDS)
        elif message_type is EmptyLine:
            key[CR] = at
        else:
            first, *second = _cases(message_type.LETTERS)
            if second:
                span[first] = np.maximum(span[first], 2)
            place = np.ix_(first, *second) if second else (first,)
            number[place] = at
            span[place] = _length(message_type)
    begins = bytes((span > 1).any(axis=1).astype(np.uint8))
    narrow = tuple(at for at, message_type in enumerate(types) if any(map(_is_narrow, message_type.FIELDS)))
    changes = np.array([message_type is SelectDirect for message_type in types])
    return _Tables(types, begins, number.ravel(), span.ravel(), narrow, key, takes, changes, decoder)


def _is_narrow(field: Field) -> bool:
    return field.high - field.low + 1 < 1 << 8 * KINDS[field.kind][0]


@cache
def _commands(groups: frozenset[str]) -> _Tables:
    lines = tuple(t for t in LOGO_COMMANDS if not t.GROUP or t.GROUP in groups)
    return _tables((*lines, *DIRECT_KEYS), lambda mode: CommandDecoder(mode, groups))


@cache
def _replies() -> _Tables:
    return _tables((*ROBOT_MESSAGES, EmptyLine), lambda _: ReplyDecoder())


def decode_commands(data: bytes, mode: Mode = Mode.LOGO, groups: frozenset[str] = ALL_GROUPS) -> Capture:
    """Decode a whole capture from host to robot, as ``CommandDecoder`` does.

    What is left of an unfinished message at the end has no place in the columns.
    """
    return _decode(data, mode, _commands(frozenset(groups)))


def decode_replies(data: bytes) -> Capture:
    """Decode a whole capture from robot to host, as ``ReplyDecoder`` does."""
    return _decode(data, Mode.LOGO, _replies())


def _decode(data: bytes, mode: Mode, tables: _Tables) -> Capture:
    capture = np.frombuffer(data + bytes(LONGEST), np.uint8)
    walk = _Walk(data, tables, _lines(capture, len(data), tables))
    mode = walk.whole(mode)
    place, key, wrong = _keys(capture, walk.direct, tables)
    byte, which = np.unique(capture[wrong], return_inverse=True)
    reasons = [walk.reason(1 << 17 | key, Mode.DIRECT, bytes([key])) for key in byte.tolist()]
    of_keys = [wrong, np.ones(len(wrong), np.int64), np.array(reasons, np.int64)[which]]
    errors = np.hstack([np.array(walk.errors, np.int64).reshape(-1, 3).T, of_keys])
    if len(wrong):
        errors = errors[:, np.argsort(errors[0])]
    start, number = walk.taken()
    empty = tables.types.index(EmptyLine)
    start = np.concatenate([start, place, np.array(walk.empty, np.int64)])
    number = np.concatenate([number, key, np.full(len(walk.empty), empty, np.uint8)])
    ends = np.cumsum(np.bincount(number, minlength=len(tables.types)))
    groups = np.split(start[np.argsort(number, kind="stable")], ends[:-1])
    groups[empty].sort()  # the only ones of both modes
    messages = {
        message_type: Messages(offset, _fields(capture, offset, message_type))
        for message_type, offset in zip(tables.types, groups, strict=True)
    }
    return Capture(data, messages, Errors(errors[0], errors[1], errors[2], tuple(walk.texts)), mode)


def _fields(
    capture: NDArray[np.uint8], offset: NDArray[np.int64], message_type: type[WalterMessage]
) -> dict[str, Column]:
    """The columns of messages of one type."""
    fields: dict[str, Column] = {}
    at = offset + len(message_type.LETTERS)
    for field in message_type.FIELDS:
        width = KINDS[field.kind][0]
        column: Column = capture[at]
        if width == 2:
            column = (column.astype(np.uint16) << 8 | capture[at + 1]).view(_DTYPES[field.kind])
        elif field.kind == "bit":
            column = np.where(column >> 1 == 0x18, column & 1, column)  # W4: ASCII 0 and 1 are read too
        fields[field.name] = column
        at = at + width
    return fields


def _lines(capture: NDArray[np.uint8], size: int, tables: _Tables) -> _Lines:
    """Wherever a well-formed line would begin, if a line began there: that place, where the next is, its number."""
    blocks = [_lines_of(capture[at : at + BLOCK + LONGEST], at, tables) for at in range(0, size or 1, BLOCK)]
    start, end, number = (np.concatenate(column) for column in zip(*blocks, strict=True))
    for narrow in tables.narrow:
        message_type = tables.types[narrow]
        of_type = np.flatnonzero(number == narrow)
        right = np.ones(len(of_type), np.bool_)
        columns = _fields(capture, start[of_type], message_type).values()
        for field, column in zip(message_type.FIELDS, columns, strict=True):
            right &= (column >= field.low) & (column <= field.high)
        wrong = of_type[~right]
        start, end, number = (np.delete(column, wrong) for column in (start, end, number))
    return start, end, number


def _lines_of(block: NDArray[np.uint8], at: int, tables: _Tables) -> _Lines:
    letters = np.frombuffer(block[:-LONGEST].tobytes().translate(tables.begins), np.bool_)
    start = np.flatnonzero(letters)
    two = block[start].astype(np.uint16) << 8 | block[start + 1]
    number = tables.number[two]
    end = start + tables.span[two]
    right = (block[end - 1] == CR) & (number != _NONE)
    start, end, number = start[right], end[right], number[right]
    end += block[end] == LF
    return start + at, end + at, number


class _Walk:
    """From line to line, and from mode to mode."""

    def __init__(self, data: bytes, tables: _Tables, lines: _Lines) -> None:
        self._data, self._tables = data, tables
        self._start, self._end, self._number = lines
        self._runs: list[tuple[int, int]] = []
        self._span, self._numbers = tables.span.data, tables.number.data
        self._known: dict[int, int] = {}
        self.texts: dict[str, int] = {}
        self.errors: list[tuple[int, int, int]] = []
        self.empty: list[int] = []
        self.direct: list[tuple[int, int]] = []

    def taken(self) -> tuple[NDArray[np.int64], NDArray[np.uint8]]:
        """The well-formed lines: where they begin, and their numbers."""
        change = np.zeros(len(self._start) + 1, np.int8)
        for sign, places in zip((1, -1), np.array(self._runs, np.int64).reshape(-1, 2).T, strict=True):
            change[places] += sign
        taken = np.cumsum(change[:-1], dtype=np.int8).view(np.bool_)
        return self._start[taken], self._number[taken]

    def whole(self, mode: Mode) -> Mode:
        """Walk to the end of the capture; return the mode there."""
        size = len(self._data)
        start, end = self._start.data, self._end.data
        changes = self._tables.changes[self._number]
        breaks = changes | (self._end != np.append(self._start[1:], -1))
        last, is_change = np.flatnonzero(breaks).data, changes.data
        at = line = stop = 0
        while at < size:
            if mode is Mode.DIRECT:
                end_of_keys = self._after_logo(at)
                self.direct.append((at, end_of_keys or size))
                if not end_of_keys:
                    break
                at, mode = end_of_keys, Mode.LOGO
                continue
            line = _first(start, at, line)
            if line == len(start) or start[line] > at:
                at = self._other_line(at)
                continue
            stop = _first(last, line, stop)
            self._runs.append((line, last[stop] + 1))
            line = last[stop] + 1
            at = end[line - 1]
            if is_change[line - 1]:
                mode = Mode.DIRECT
        return mode

    def _after_logo(self, begin: int) -> int:
        """Where Logo control begins again if direct control begins here, or 0."""
        data, takes = self._data, self._tables.takes
        at = data.find(SelectLogo.LETTERS, begin)
        while at >= 0:
            before = at
            while before > begin and takes[data[before - 1]]:
                before -= 1
            if (at - before) % 2 == 0:
                return at + 1
            at = data.find(SelectLogo.LETTERS, at + 1)
        return 0

    def _other_line(self, at: int) -> int:
        """Take a line that is not well-formed, or an empty one; return where the next begins."""
        data = self._data
        size = len(data)
        if data[at] == CR:
            self.empty.append(at)
            end = at + 1
        else:
            two = data[at] << 8 | (data[at + 1] if at + 1 < size else 0)
            span = self._span[two]
            decisive = at + span - 1
            if decisive >= size:
                return size
            byte = data[decisive]
            if self._numbers[two] == _NONE:
                code = two if span > 1 else two & 0xFF00
            else:
                code = 1 << 18 | two if byte == CR else 1 << 16 | byte
            end = data.find(b"\r", decisive) + 1
            stop = end or size - (size - at) % MAX_RAW
            if stop > at:
                reason = self.reason(code, Mode.LOGO, data[at : decisive + 1] + b"\r")
                for piece in range(at, stop, MAX_RAW):
                    self.errors.append((piece, min(MAX_RAW, stop - piece), reason))
            if not end:
                return size
        return end + (data[end : end + 1] == b"\n")

    def reason(self, code: int, mode: Mode, example: bytes) -> int:
        """The index of the reason of all that is wrong as the example is, which the streaming decoder tells."""
        number = self._known.get(code)
        if number is None:
            text = str(self._tables.decoder(mode).receive_data(example)[0][2])
            number = self._known[code] = self.texts.setdefault(text, len(self.texts))
        return number


def _first(places: memoryview[int], least: int, index: int) -> int:
    """The index of the first place, from an index on, that is not below ``least``. They ascend."""
    if index == len(places) or places[index] >= least:
        return index
    return bisect_left(places, least, index + 1, min(index + least - places[index], len(places)))


def _keys(
    capture: NDArray[np.uint8], direct: list[tuple[int, int]], tables: _Tables
) -> tuple[NDArray[np.int64], NDArray[np.uint8], NDArray[np.int64]]:
    """What stands in the parts in direct control: the keys' places, their numbers, and the places of what is none.

    Each part but the last ends with a key that takes no byte, so that they may be put together.
    """
    begin, end = np.array(direct, np.int64).reshape(-1, 2).T
    length = end - begin
    index = np.arange(length.sum())
    if not len(index):
        return index, tables.key[:0], index
    place = index + np.repeat(begin - np.cumsum(length) + length, length)
    byte = capture[place]
    takes = tables.takes[byte]
    # In a row of bytes that would take another, every second one is taken.
    odd = (index - np.maximum.accumulate(np.where(takes, -1, index))) & 1 == 1
    is_key = np.concatenate([[True], ~odd[:-1]])
    is_key[1:] &= ~((byte[1:] == LF) & (byte[:-1] == CR) & is_key[:-1])  # W1
    is_key[-1] &= not takes[-1]
    number = tables.key[byte]
    right = is_key & (number != _NONE)
    return place[right], number[right], place[is_key & ~right]
