"""Rows of bytes, all of one size, and the messages that stand in one place of each: read together, in C.

A row is a frame, or a message. What bytes, tuples and iterators do to all rows at once is several times faster than
a loop over them.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import chain, compress, starmap
from struct import Struct
from typing import TYPE_CHECKING

from turtlewire.protocols.frame.layout import keeps

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from turtlewire.protocols.frame.layout import Layout
    from turtlewire.protocols.frame.message import FrameMessage

# So many rows are cut at a time.
CUT = 64


def cut(rows: bytes, size: int, first: int = 0, last: int = 0) -> Sequence[bytes]:
    """Each of the rows of a size, without its ``first`` and its ``last`` so many bytes."""
    many, rest = divmod(len(rows) // size, CUT)
    inner = size - first - last
    if not many:
        return _cutter(rest, first, inner, last).unpack(rows)
    whole = many * CUT * size
    cuts = list(chain.from_iterable(_cutter(CUT, first, inner, last).iter_unpack(rows[:whole])))
    cuts += _cutter(rest, first, inner, last).unpack(rows[whole:])
    return cuts


@lru_cache(maxsize=128)
def _cutter(count: int, first: int, inner: int, last: int) -> Struct:
    return Struct(f"{first}x{inner}s{last}x" * count)


class Reader:
    """Reads the messages of one type that stand in the same place of rows.

    Args:
        layout: how the message stands there.
        at: the place of its type byte in a row.
        size: of a row, in bytes.
    """

    def __init__(self, layout: Layout, at: int, size: int) -> None:
        self._type, letters, length, _, self._limits, self._allowed = layout
        self._size = size
        self._fields = Struct(f">{at + 1}x{letters}{size - at - length}x")
        # Where each field is a byte that reads as itself, it is a column of bytes.
        self._columns = range(at + 1, at + length) if self._allowed is not None else None

    def read(self, rows: bytes) -> tuple[int, Iterator[FrameMessage]]:
        """How many rows there are up to the first whose message breaks its restriction; the messages."""
        size = self._size
        count = len(rows) // size
        if self._columns:
            columns = [rows[place::size] for place in self._columns]
            for limit, allowed in zip(self._limits, self._allowed or (), strict=True):
                column = columns[limit.place]
                if others := column.translate(None, allowed):
                    count = min(count, column.index(others[:1]))
            return count, map(self._type, *columns)
        if self._limits:
            kept = [keeps(self._limits, row) for row in self._fields.iter_unpack(rows)]
            count = kept.index(False) if False in kept else count
        return count, starmap(self._type, self._fields.iter_unpack(rows))


class Slot:
    """A place in rows where each has a message, of one size but not always of one type.

    Args:
        at: the place of the type byte in a row.
        length: of each of the messages, type and fields.
        size: of a row, in bytes.
        table: what a decoder looks up by the type byte.
    """

    def __init__(self, at: int, length: int, size: int, table: list[Layout | None]) -> None:
        self._at, self._length, self._size, self._table = at, length, size, table
        self._known = b""
        self._readers: dict[int, Reader] = {}
        self._only: Reader | None = None

    def fits(self, kind: int) -> bool:
        """Whether messages of a type have the right size here."""
        return kind in self._readers or self._learn(kind)

    def _learn(self, kind: int) -> bool:
        layout = self._table[kind]
        if layout is None or layout.size != self._length:
            return False
        self._only = None if self._known else Reader(layout, self._at, self._size)
        self._readers[kind] = Reader(layout, 0, self._length)
        self._known += bytes((kind,))
        return True

    def read(self, rows: bytes) -> tuple[int, Iterator[FrameMessage]]:
        """How many rows have a message here that fits and keeps its restrictions, up to the first that has not.

        The iterator gives the messages of so many rows, or of some more.
        """
        types = rows[self._at :: self._size]
        count = len(types)
        if others := types.translate(None, self._known):
            misfits = [kind for kind in set(others) if not self._learn(kind)]
            count = min(map(types.index, misfits), default=count)
            types, rows = types[:count], rows[: count * self._size]
        if self._only:
            return self._only.read(rows)
        messages = cut(rows, self._size, self._at, self._size - self._at - self._length)
        made = {}
        for kind in set(types):
            of_kind = types.translate(bytes(kind) + b"\1" + bytes(255 - kind))
            some = b"".join(compress(messages, of_kind))
            kept, made[kind] = self._readers[kind].read(some)
            if kept < len(some) // self._length:
                count = min(count, [n for n, other in enumerate(types) if other == kind][kept])
        return count, map(next, map(made.__getitem__, types))
