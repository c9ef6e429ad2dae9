"""Logo control in a whole capture: where its lines are.

Each line ends at a CR, whether it is well-formed or dropped, so the next begins behind one; and the first two bytes of
a line tell which byte decides about it. It ends at the first CR that is not before that byte: mostly the next one. So
for all CRs at once it is told what stands between it and the one before. Only where a line goes on beyond the next CR,
which is an argument then, or where the mode changes, must somebody look.
"""

from __future__ import annotations

from bisect import bisect_left
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from turtlewire.protocols.columns import in_order
from turtlewire.protocols.walter.bulk_tables import NONE, NOTHING, WRONG_RET
from turtlewire.protocols.walter.codec import CR, LF, MAX_RAW, Mode
from turtlewire.protocols.walter.messages import SelectLogo

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from turtlewire.protocols.walter.bulk_tables import Tables

    Integers = NDArray[np.int64]

BLOCK = 1 << 18  # of a capture are worked on at a time: so little stays in the processor's cache


class Lines(NamedTuple):
    """What stands in Logo control, in order.

    Attributes:
        offset: where each well-formed line begins.
        kind: the numbers of their types.
        wrong: of dropped lines, where each begins, how long it is, and the code of what is wrong.
        direct: from where to where there is direct control; each part but the last ends with a change of mode.
        mode: what the robot takes the next bytes for.
    """

    offset: Integers
    kind: NDArray[np.uint8]
    wrong: tuple[NDArray[np.int64], ...]
    direct: list[tuple[int, int]]
    mode: Mode


def find_lines(data: bytes, mode: Mode, tables: Tables) -> Lines:
    """All lines of a capture. Of an unfinished one that is wrong already, only whole pieces are there (W6)."""
    walk = _Walk(data, mode, tables)
    at = 0
    while at < len(data):
        at = walk.block(at) if walk.mode is Mode.LOGO else walk.keys(at)
    return walk.lines()


class _Between(NamedTuple):
    """What stands between the CRs of a block, as if a line began behind each.

    Attributes:
        start: where it begins in the block.
        ret: where the CR is that ends it.
        two: its first two bytes.
        found: what the tables tell of them.
        kind: its number; ``NONE`` if it is to be dropped, ``NOTHING`` if no line begins there.
    """

    start: Integers
    ret: Integers
    two: NDArray[np.uint16]
    found: NDArray[np.uint16]
    kind: NDArray[np.uint8]


class _Walk:
    """Block by block; what must be looked at, one by one."""

    def __init__(self, data: bytes, mode: Mode, tables: Tables) -> None:
        self.mode = mode
        self._data, self._tables = data, tables
        self._capture = np.frombuffer(data, np.uint8)
        self._lines, self._wrong_letters = tables.lines.data, tables.wrong_letters.data
        self._found: list[tuple[Integers, NDArray[np.uint8]]] = []
        self._wrong: list[tuple[Integers, Integers, Integers]] = []
        self._single: list[tuple[int, int]] = []
        self._single_wrong: list[tuple[int, int, int]] = []
        self._direct: list[tuple[int, int]] = []

    def lines(self) -> Lines:
        """What was found."""
        single, kinds = np.array(self._single, np.int64).reshape(-1, 2).T
        of_blocks = zip(*self._found, (single, kinds.astype(np.uint8)), strict=True)
        offset, kind = (np.concatenate(column) for column in of_blocks)
        if self._single:
            offset, kind = in_order(offset, kind)
        single_wrong = np.array(self._single_wrong, np.int64).reshape(-1, 3).T
        wrong = tuple(np.concatenate(column) for column in zip(*self._wrong, single_wrong, strict=True))
        if self._single_wrong:
            wrong = in_order(*wrong)
        return Lines(offset, kind, wrong, self._direct, self.mode)

    def block(self, at: int) -> int:
        """Take the lines from ``at`` on that end within a block. Return where it goes on."""
        window = self._capture[at : at + BLOCK]
        ret = np.flatnonzero(window == CR)
        after = self._between(at, window, ret) if len(ret) and at + 1 < len(self._data) else at
        return after if after > at else self._line(at)

    def keys(self, at: int) -> int:
        """Take direct control. Return where it ends."""
        data, takes = self._data, self._tables.takes
        end = data.find(SelectLogo.LETTERS, at)
        while end >= 0:
            before = end
            while before > at and data[before - 1] in takes:
                before -= 1
            # In a row of bytes that would take another, every second one is taken.
            if (end - before) % 2 == 0:
                self._direct.append((at, end + 1))
                self.mode = Mode.LOGO
                return end + 1
            end = data.find(SelectLogo.LETTERS, end + 1)
        self._direct.append((at, len(data)))
        return len(data)

    def _line(self, at: int) -> int:
        """Take the line at ``at``. Return where it goes on: at the end, if the line is not finished."""
        data = self._data
        size = len(data)
        second = data[at + 1] if at + 1 < size else 0
        two = data[at] << 8 | second
        found = self._lines[two]
        decides, kind = at + (found >> 8), found & 255
        if decides >= size:
            return size
        end = data.find(b"\r", decides)
        if end == decides and kind != NONE:
            self._single.append((at, kind))
            if kind == self._tables.direct:
                self.mode = Mode.DIRECT
        else:
            stop = end + 1 or size - (size - at) % MAX_RAW
            if stop > at:
                code = self._wrong_letters[two] if kind == NONE else WRONG_RET + data[decides]
                self._single_wrong.append((at, stop - at, code))
            if end < 0:
                return size
        return self._behind(end)

    def _behind(self, ret: int) -> int:
        """Where the next line begins behind a CR."""
        return ret + 1 + (self._data[ret + 1 : ret + 2] == b"\n")  # W1

    def _between(self, at: int, window: NDArray[np.uint8], ret: Integers) -> int:
        """Take the lines that end at these CRs; the first begins at ``at``. Return where it goes on."""
        start = np.empty_like(ret)
        start[0] = 0
        np.add(ret[:-1], 1, out=start[1:])
        first = window.take(start)
        skip = first[1:] == LF  # W1
        if skip.any():
            start[1:] += skip
            first = window.take(start)
        two = first.astype(np.uint16) << np.uint16(8) | self._capture[at + 1 :].take(start, mode="clip")
        found = self._tables.lines.take(two)
        decides = (found >> 8).astype(np.uint8)
        size = np.minimum(ret - start, 255).astype(np.uint8)
        kind = found.astype(np.uint8)
        kind |= (size == decides).view(np.uint8) - np.uint8(1)  # 255 where they are not
        look = np.flatnonzero((size < decides) | (kind == self._tables.direct))
        lines = _Between(start, ret, two, found, kind)
        after = self._look(at, lines, look) if len(look) else None
        wrong = np.flatnonzero(kind == NONE)
        if len(wrong):
            offset = start.take(wrong)
            of_wrong = found.take(wrong)
            byte = window.take(offset + (of_wrong >> 8)).astype(np.int64) + WRONG_RET
            letters = self._tables.wrong_letters.take(two.take(wrong))
            code = np.where(of_wrong & 255 == NONE, letters, byte)
            self._wrong.append((offset + at, ret.take(wrong) - offset + 1, code))
        if len(wrong) or len(look):
            right = np.flatnonzero(kind < NOTHING)
            start, kind = start.take(right), kind.take(right)
        start += at
        self._found.append((start, kind))
        return self._behind(at + int(ret[-1])) if after is None else after

    def _look(self, at: int, lines: _Between, look: Integers) -> int | None:
        """Correct what these lines are, where they end, and that others are none.

        Return where it goes on, unless that is behind the last CR.
        """
        start, ret, _, found, kind = lines
        decides = start.take(look) + (found.take(look) >> 8)
        last = ret.searchsorted(decides)
        end = ret.take(last, mode="clip")
        kinds = np.where(end == decides, found.take(look).astype(np.uint8), np.uint8(NONE))
        gone: list[int] = []
        ranges: list[tuple[int, int]] = []
        following = 0
        stopped = None
        for line, final in zip(look.tolist(), last.tolist(), strict=True):
            if line < following:
                continue
            following = final + 1
            if final == len(ret):  # it does not end in this block
                stopped = at + int(start[line])
                ranges.append((line, final))
                break
            if final == line:
                after = self._change(self._behind(at + int(ret[line])))
                following = bisect_left(ret.data, after - at, line + 1)
                ranges.append((line + 1, following))
                if following == len(ret):
                    stopped = after
                    break
            elif final == line + 1:
                gone.append(final)
            else:
                ranges.append((line + 1, following))
        kind[look], ret[look] = kinds, end
        kind[gone] = NOTHING
        for begin, stop in ranges:
            kind[begin:stop] = NOTHING
        return stopped

    def _change(self, at: int) -> int:
        """Take direct control, and the line behind it. Return where the next line begins that may be in a block."""
        self.mode = Mode.DIRECT
        while self.mode is Mode.DIRECT and at < len(self._data):
            at = self.keys(at)
            if at < len(self._data):
                at = self._line(at)
        return at
