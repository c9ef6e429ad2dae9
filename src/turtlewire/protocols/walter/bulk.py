"""A whole capture at once, to columns: the streaming decoder's result, by NumPy (the extra ``turtlewire[bulk]``)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from turtlewire.protocols.columns import Capture, Errors, Fields, in_order
from turtlewire.protocols.message import KINDS
from turtlewire.protocols.walter.bulk_keys import find_keys
from turtlewire.protocols.walter.bulk_lines import find_lines
from turtlewire.protocols.walter.bulk_tables import WRONG_VALUE, Tables, of_commands, of_replies
from turtlewire.protocols.walter.codec import ALL_GROUPS, MAX_RAW, Mode
from turtlewire.protocols.walter.messages import WalterMessage

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Integers = NDArray[np.int64]

# Lines of few types are sorted out type by type, those of more together: this is told by the first lines.
SAMPLE, FEW = 256, 6
_DTYPES = {"u16": np.uint16, "i16": np.int16}


@dataclass(frozen=True, slots=True, eq=False)
class WalterCapture(Capture[WalterMessage]):
    """All that a streaming decoder makes of a capture of WALTER.

    Attributes:
        mode: what the robot takes the next bytes for.
    """

    mode: Mode


def decode_commands(
    data: bytes, mode: Mode = Mode.LOGO, groups: frozenset[str] = ALL_GROUPS
) -> WalterCapture:
    """Decode a whole capture from host to robot, as ``CommandDecoder`` does.

    What is left of an unfinished message at the end has no place in the columns.
    """
    return _decode(data, mode, of_commands(frozenset(groups)))


def decode_replies(data: bytes) -> WalterCapture:
    """Decode a whole capture from robot to host, as ``ReplyDecoder`` does."""
    return _decode(data, Mode.LOGO, of_replies())


def _decode(data: bytes, mode: Mode, tables: Tables) -> WalterCapture:
    lines = find_lines(data, mode, tables)
    offset, kind = lines.offset, lines.kind
    wrong = [_pieces(*lines.wrong)]
    capture = np.frombuffer(data, np.uint8)
    fields: dict[type[WalterMessage], Fields] = {}
    out_of_range = []
    for (number, message_type), of_type in zip(
        tables.line_fields.items(), _each(kind, len(tables.line_fields)), strict=True
    ):
        columns = (
            _fields(capture, offset.take(of_type), message_type) if len(of_type) else _none(message_type)
        )
        if number in tables.narrow and not (right := _right(columns, message_type)).all():
            columns = {name: column.compress(right) for name, column in columns.items()}
            out_of_range.append(of_type.compress(~right))
        fields[message_type] = columns
    refused = np.concatenate([np.empty(0, np.int64), *out_of_range])
    if len(refused):
        numbers = kind.take(refused).astype(np.int64)
        lengths = np.array(list(tables.types.values()), np.int64)
        wrong.append((offset.take(refused), lengths.take(numbers), numbers + WRONG_VALUE))
        offset, kind = np.delete(offset, refused), np.delete(kind, refused)
    keys = find_keys(data, lines.direct, tables)
    for number, message_type in tables.key_fields.items():
        (field,) = message_type.FIELDS
        fields[message_type] = {field.name: keys.taken[number]}
    if lines.direct:
        wrong.append(keys.wrong)
        if len(offset):
            both = np.concatenate([offset, keys.offset]), np.concatenate([kind, keys.kind])
            offset, kind = in_order(*both)
        else:
            offset, kind = keys.offset, keys.kind
    at, length, code = (np.concatenate(column) for column in zip(*wrong, strict=True))
    if len(wrong) > 1:
        at, length, code = in_order(at, length, code)
    errors = Errors(at, length, *tables.reasons.numbered(code))
    return WalterCapture(data, tables.types, offset, kind, fields, errors, lines.mode)


def _each(kind: NDArray[np.uint8], count: int) -> list[Integers]:
    """Where the lines of each type stand, by their numbers from 0 to below ``count``."""
    if not len(kind):
        return [np.empty(0, np.int64)] * count
    if len(set(kind[:SAMPLE].tolist())) <= FEW:
        return [np.flatnonzero(kind == number) for number in range(count)]
    some = np.flatnonzero(kind < count)
    kinds = kind.take(some)
    order = np.argsort(kinds, kind="stable")
    return np.split(some.take(order), kinds.take(order).searchsorted(np.arange(1, count)))


def _fields(capture: NDArray[np.uint8], offset: Integers, message_type: type[WalterMessage]) -> Fields:
    """The columns of messages of one type."""
    fields: Fields = {}
    place = len(message_type.LETTERS)
    for field in message_type.FIELDS:
        width = KINDS[field.kind][0]
        column = capture[place:].take(offset)
        if width == 2:
            column = column.astype(np.uint16) << np.uint16(8) | capture[place + 1 :].take(offset)
            column = column.view(_DTYPES[field.kind])
        elif field.kind == "bit":
            column = np.where(column >> 1 == 0x18, column & 1, column)  # W4: ASCII 0 and 1 are read too
        fields[field.name] = column
        place += width
    return fields


@cache
def _none(message_type: type[WalterMessage]) -> Fields:
    """The columns of no messages of one type."""
    return _fields(np.empty(0, np.uint8), np.empty(0, np.int64), message_type)


def _right(columns: Fields, message_type: type[WalterMessage]) -> NDArray[np.bool_]:
    """Whether each of these messages has values that the protocol knows."""
    bounds = [
        (columns[field.name] >= field.low) & (columns[field.name] <= field.high)
        for field in message_type.FIELDS
    ]
    right: NDArray[np.bool_] = np.logical_and.reduce(bounds)
    return right


def _pieces(offset: Integers, length: Integers, code: Integers) -> tuple[Integers, Integers, Integers]:
    """Dropped lines in pieces of at most ``MAX_RAW`` bytes, as the streaming decoder reports them."""
    if not (length > MAX_RAW).any():
        return offset, length, code
    count = (length + MAX_RAW - 1) // MAX_RAW
    line = np.repeat(np.arange(len(offset)), count)
    before = np.arange(len(line)) - np.repeat(np.cumsum(count) - count, count)
    before *= MAX_RAW
    return offset.take(line) + before, np.minimum(length.take(line) - before, MAX_RAW), code.take(line)
