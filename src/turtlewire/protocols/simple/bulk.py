"""A whole capture at once, to columns: the streaming decoder's result, by NumPy (the extra ``turtlewire[bulk]``).

Commands are seven bytes each, so a capture is a table of seven columns, and what stands in a place is looked at for all
commands at once. The texts of what is wrong come from the codec, by an example of each.
"""

from __future__ import annotations

from bisect import bisect
from functools import cache, lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from turtlewire.protocols.columns import Capture, Errors, Fields, Reasons
from turtlewire.protocols.simple.codec import Column, Layout, ReplyDecoder, decode, layouts
from turtlewire.protocols.simple.messages import LENGTH, REPLIES, Reply, SimpleCommand

if TYPE_CHECKING:
    from numpy.typing import NDArray

_DTYPES = {"u8": np.uint8, "u16": np.uint16, "bit": np.uint8}
_BYTES = 256
_NONE = 255  # the number of no type
_ZERO = 0x30


class _Cell(NamedTuple):
    """One field of one command, and its codes: of each byte that may be no digit, then of each number.

    Attributes:
        code: the first of them.
    """

    layout: Layout
    column: Column
    code: int

    def example(self, code: int) -> bytes:
        """A command in which nothing is wrong but what a code stands for."""
        data = bytearray(self.layout.command_type.LETTER)
        for field, start, end in self.layout.columns:
            data += b"%0*d" % (end - start, field.low)
        _, start, end = self.column
        what = code - self.code
        data[start:end] = (
            bytes([what]) * (end - start) if what < _BYTES else b"%0*d" % (end - start, what - _BYTES)
        )
        return bytes(data)


class _Tables(NamedTuple):
    """What is looked up.

    Attributes:
        types: all commands, and how long they are.
        numbers: of each letter, the number of its command.
        cells: the fields of each command that has any, by its number.
        reasons: what is wrong; the first codes are the unknown letters.
    """

    types: dict[type[SimpleCommand], int]
    numbers: bytes
    cells: dict[int, tuple[_Cell, ...]]
    reasons: Reasons


@lru_cache(maxsize=32)
def _tables(extensions: tuple[type[SimpleCommand], ...]) -> _Tables:
    table = layouts(extensions)
    numbers = bytearray([_NONE]) * _BYTES
    cells: list[_Cell] = []
    of_number: dict[int, tuple[_Cell, ...]] = {}
    codes = _BYTES
    for number, (letter, layout) in enumerate(table.items()):
        numbers[letter] = number
        for column in layout.columns:
            cells.append(_Cell(layout, column, codes))
            of_number[number] = (*of_number.get(number, ()), cells[-1])
            codes += _BYTES + 10 ** (column.end - column.start)

    def text(code: int) -> str:
        cell = bisect(cells, code, key=lambda cell: cell.code)
        return str(decode(cells[cell - 1].example(code) if cell else bytes([code]), table))

    types = {layout.command_type: LENGTH for layout in table.values()}
    return _Tables(types, bytes(numbers), of_number, Reasons(codes, text))


class _Table:
    """All commands of a capture, position by position."""

    def __init__(self, data: bytes) -> None:
        count = len(data) // LENGTH
        rows = np.frombuffer(data, np.uint8, count * LENGTH).reshape(count, LENGTH)
        self.bytes = np.ascontiguousarray(rows.T)
        self._digit = self.bytes - np.uint8(_ZERO)
        self._is_digit = self._digit <= 9
        self._numbers: dict[tuple[int, int], tuple[NDArray[np.bool_], NDArray[np.uint16]]] = {}

    def number(self, start: int, end: int) -> tuple[NDArray[np.bool_], NDArray[np.uint16]]:
        """Whether digits stand in some positions, and their number; a single digit is 0 or not."""
        if (start, end) not in self._numbers:
            digits = self._is_digit[start]
            number = self._digit[start].astype(np.uint16)
            for place in range(start + 1, end):
                digits = digits & self._is_digit[place]
                number *= 10
                number += self._digit[place]
            self._numbers[start, end] = digits, np.minimum(number, 1) if end - start == 1 else number
        return self._numbers[start, end]

    def right(self, cell: _Cell) -> NDArray[np.bool_]:
        """Whether a value of this field stands there."""
        field, start, end = cell.column
        digits, number = self.number(start, end)
        return digits & (number >= field.low) & (number <= field.high)

    def values(self, cell: _Cell, row: NDArray[np.int64]) -> NDArray[np.uint16] | NDArray[np.uint8]:
        """The values of this field."""
        field, start, end = cell.column
        return self.number(start, end)[1].take(row).astype(_DTYPES[field.kind])

    def codes(self, cells: tuple[_Cell, ...], row: NDArray[np.int64]) -> NDArray[np.int64]:
        """What is wrong with some commands of one type: the first field, and the first byte there that is no digit."""
        code = np.zeros(len(row), np.int64)
        for cell in reversed(cells):
            _, start, end = cell.column
            what = self.number(start, end)[1].take(row) + _BYTES
            for place in reversed(range(start, end)):
                what = np.where(self._is_digit[place].take(row), what, self.bytes[place].take(row))
            code = np.where(self.right(cell).take(row), code, cell.code + what.astype(np.int64))
        return code


def decode_commands(data: bytes, extensions: tuple[type[SimpleCommand], ...] = ()) -> Capture[SimpleCommand]:
    """Decode a whole capture from host to robot, as ``CommandDecoder`` does.

    What is left of an unfinished command at the end has no place in the columns.
    Raises ``UsageError`` if an extension cannot be told from another command, or does not fit.
    """
    tables = _tables(extensions)
    table = _Table(data)
    letter = table.bytes[0]
    number = np.frombuffer(letter.tobytes().translate(tables.numbers), np.uint8)
    good = number != _NONE
    for mine, cells in tables.cells.items():
        good &= np.logical_and.reduce([table.right(cell) for cell in cells]) | (number != mine)
    row = np.flatnonzero(good)
    kind = number.take(row)
    fields: dict[type[SimpleCommand], Fields] = {}
    for mine, cells in tables.cells.items():
        of_mine = row.take(np.flatnonzero(kind == mine))
        fields[cells[0].layout.command_type] = {
            cell.column.field.name: table.values(cell, of_mine) for cell in cells
        }
    wrong = np.flatnonzero(~good)
    code = letter.take(wrong).astype(np.int64)
    for mine, cells in tables.cells.items():
        of_mine = np.flatnonzero(number.take(wrong) == mine)
        if len(of_mine):
            code[of_mine] = table.codes(cells, wrong.take(of_mine))
    errors = Errors(wrong * LENGTH, np.full(len(wrong), LENGTH), *tables.reasons.numbered(code))
    return Capture(data, tables.types, row * LENGTH, kind, fields, errors)


@cache
def _replies() -> tuple[dict[type[Reply], int], bytes, Reasons]:
    numbers = bytearray([_NONE]) * _BYTES
    for number, reply_type in enumerate(REPLIES):
        numbers[reply_type.LETTER[0]] = number
    reasons = Reasons(_BYTES, lambda code: str(ReplyDecoder().receive_data(bytes([code]))[0][2]))
    return dict.fromkeys(REPLIES, 1), bytes(numbers), reasons


def decode_replies(data: bytes) -> Capture[Reply]:
    """Decode a whole capture from robot to host, as ``ReplyDecoder`` does."""
    types, numbers, reasons = _replies()
    kind = np.frombuffer(data.translate(numbers), np.uint8)
    is_wrong = kind == _NONE
    wrong = np.flatnonzero(is_wrong)
    if len(wrong):
        offset = np.flatnonzero(~is_wrong)
        kind = kind.take(offset)
    else:
        offset = np.arange(len(data))
    code = np.frombuffer(data, np.uint8).take(wrong)
    errors = Errors(wrong, np.ones(len(wrong), np.int64), *reasons.numbered(code))
    return Capture(data, types, offset, kind, {}, errors)
