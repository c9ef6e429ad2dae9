"""A whole capture at once, to columns: the streaming decoder's result, by NumPy (the extra ``turtlewire[bulk]``).

Commands are seven bytes each, so a capture is a table of seven columns; what stands where is looked at for all commands
of a type at once. The texts of what is wrong come from the codec, one of each.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from turtlewire.protocols.message import Decoded, Malformed
from turtlewire.protocols.simple.codec import Item, ReplyDecoder, decode, layouts
from turtlewire.protocols.simple.messages import LENGTH, REPLIES, SimpleCommand, SimpleMessage

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from turtlewire.protocols.simple.codec import Column, Layout

_DTYPES = {"u8": np.uint8, "u16": np.uint16, "bit": np.uint8}
_NONE = 255  # the number of no type
_ZERO = 0x30

Values = Any  # NDArray of the field's kind


class Messages(NamedTuple):
    """All messages of one type, in order.

    Attributes:
        offset: where in the capture each begins.
        fields: a column for each field, by name.
    """

    offset: NDArray[np.int64]
    fields: dict[str, Values]


class Errors(NamedTuple):
    """All bytes that are no message, in order.

    Attributes:
        offset: where in the capture they begin.
        length: how many they are.
        reason: why, as an index of ``reasons``.
        reasons: the texts.
    """

    offset: NDArray[np.int64]
    length: NDArray[np.int64]
    reason: NDArray[np.int64]
    reasons: tuple[str, ...]


class Capture(NamedTuple):
    """All that a streaming decoder makes of a capture.

    Attributes:
        data: the capture.
        length: how many bytes a message has.
        messages: by the messages' classes; a class of which there is none has empty columns.
        errors: what is no message.
    """

    data: bytes
    length: int
    messages: dict[type[SimpleMessage], Messages]
    errors: Errors

    def items(self) -> list[Item]:
        """What ``receive_data`` of the streaming decoder returns: one object for each, which takes its time."""
        data = self.data
        items: list[Item] = []
        for message_type, (offsets, fields) in self.messages.items():
            columns = [column.tolist() for column in fields.values()]
            items += (
                Decoded(offset, data[offset : offset + self.length], message_type(*values))
                for offset, *values in zip(offsets.tolist(), *columns, strict=True)
            )
        of_errors = (column.tolist() for column in self.errors[:3])
        items += (
            Malformed(offset, data[offset : offset + length], self.errors.reasons[reason])
            for offset, length, reason in zip(*of_errors, strict=True)
        )
        return sorted(items, key=lambda item: item.offset)


def decode_commands(data: bytes, extensions: tuple[type[SimpleCommand], ...] = ()) -> Capture:
    """Decode a whole capture from host to robot, as ``CommandDecoder`` does.

    What is left of an unfinished command at the end has no place in the columns.
    Raises ``UsageError`` if an extension cannot be told from another command, or does not fit.
    """
    table = layouts(extensions)
    count = len(data) // LENGTH
    rows = np.frombuffer(data, np.uint8, count * LENGTH).reshape(count, LENGTH)
    columns = np.ascontiguousarray(rows.T)
    numbers = np.full(256, _NONE, np.uint8)
    numbers[list(table)] = range(len(table))
    groups = _groups(numbers[columns[0]], len(table))
    messages: dict[type[SimpleMessage], Messages] = {}
    wrong = [groups[-1]]
    codes = [columns[0][wrong[0]].astype(np.int64)]
    for layout, group in zip(table.values(), groups[:-1], strict=True):
        good, fields = _values(columns, group, layout)
        if good.all():
            messages[layout.command_type] = Messages(group * LENGTH, fields)
            continue
        right = {name: column[good] for name, column in fields.items()}
        messages[layout.command_type] = Messages(group[good] * LENGTH, right)
        wrong.append(group[~good])
        codes.append(_codes(columns, wrong[-1], layout) << 8 | layout.command_type.LETTER[0])
    row, code = np.concatenate(wrong), np.concatenate(codes)
    order = np.argsort(row)
    row = row[order]
    _, first, reason = np.unique(code[order], return_index=True, return_inverse=True)
    texts = tuple(str(decode(rows[at].tobytes(), table)) for at in row[first])
    return Capture(data, LENGTH, messages, Errors(row * LENGTH, np.full(len(row), LENGTH), reason, texts))


def decode_replies(data: bytes) -> Capture:
    """Decode a whole capture from robot to host, as ``ReplyDecoder`` does."""
    capture = np.frombuffer(data, np.uint8)
    numbers = np.full(256, _NONE, np.uint8)
    numbers[[reply_type.LETTER[0] for reply_type in REPLIES]] = range(len(REPLIES))
    *groups, wrong = _groups(numbers[capture], len(REPLIES))
    messages: dict[type[SimpleMessage], Messages] = {
        reply_type: Messages(offset, {}) for reply_type, offset in zip(REPLIES, groups, strict=True)
    }
    found, reason = np.unique(capture[wrong], return_inverse=True)
    texts = tuple(str(item[2]) for item in ReplyDecoder().receive_data(found.tobytes()))
    return Capture(data, 1, messages, Errors(wrong, np.ones(len(wrong), np.int64), reason, texts))


def _groups(numbers: NDArray[np.uint8], count: int) -> list[NDArray[np.int64]]:
    """Where each number below ``count`` stands, and last where any other does."""
    order = np.argsort(numbers, kind="stable")
    ends = np.cumsum(np.bincount(numbers, minlength=count)[:count])
    return np.split(order, ends)


def _values(
    columns: NDArray[np.uint8], index: NDArray[np.int64], layout: Layout
) -> tuple[NDArray[np.bool_], dict[str, Values]]:
    """Which of some commands of one type are right, and the values of their fields."""
    good = np.ones(len(index), np.bool_)
    fields: dict[str, Values] = {}
    for column in layout.columns:
        digits, value = _number(columns, index, column)
        field = column.field
        good &= digits & (value >= field.low) & (value <= field.high)
        fields[field.name] = value.astype(_DTYPES[field.kind])
    return good, fields


def _number(
    columns: NDArray[np.uint8], index: NDArray[np.int64], column: Column
) -> tuple[NDArray[np.bool_], NDArray[np.uint16]]:
    """Whether digits stand in a field, and their number."""
    good = np.ones(len(index), np.bool_)
    number = np.zeros(len(index), np.uint16)
    for place in range(column.start, column.end):
        digit = columns[place][index] - np.uint8(_ZERO)
        good &= digit <= 9
        number *= 10
        number += digit
    return good, np.minimum(number, 1) if column.field.kind == "bit" else number


def _codes(columns: NDArray[np.uint8], index: NDArray[np.int64], layout: Layout) -> NDArray[np.int64]:
    """A number for each of some wrong commands of one type: the same number, the same reason.

    It is made of the first field that is wrong, and of the first byte there that is no digit, or else of the value.
    """
    code = np.zeros(len(index), np.int64)
    for at, column in enumerate(layout.columns, 1):
        digits, value = _number(columns, index, column)
        reason = 256 + value.astype(np.int64)
        for place in reversed(range(column.start, column.end)):
            byte = columns[place][index]
            reason = np.where((byte >= _ZERO) & (byte <= _ZERO + 9), reason, byte)
        wrong = ~digits | (value < column.field.low) | (value > column.field.high)
        code = np.where((code == 0) & wrong, at << 17 | reason, code)
    return code
