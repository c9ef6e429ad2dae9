"""Frames of one shape in a row are decoded together.

Nothing here but speed: what is not plainly in order (another shape, a wrong CRC, a message to refuse, a number that
does not follow) ends a run, and the decoder goes on from there frame by frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from itertools import groupby
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.protocols.frame.message import HEADER, MAGIC, MAX_FRAME, OVERHEAD, FrameMessage
from turtlewire.protocols.frame.rows import Slot, cut

if TYPE_CHECKING:
    from turtlewire.protocols.checksums import Checksum
    from turtlewire.protocols.frame.layout import Layout

# Fewer frames than this are not worth the preparation. It looks ahead so far at first, and never further.
FEWEST = 16
NEAR, FAR = 64, 4096
LONGEST_WAIT = 256
# So many messages of one size in a row are read as one long column.
MANY = 8
# CRCs are computed column by column where there are not many columns, and so many frames for each; else one by one.
COLUMNS = 10
COLUMN_FRAMES = 6
# Sequence numbers in a row are compared with a piece of this.
_MAGIC_BYTE = bytes((MAGIC,))
_SEQS = bytes(range(256)) * (FAR // 256 + 1)


# Frames plainly in order: their bytes, the messages of each, and how many each has.
Run = tuple[Sequence[bytes], Iterator[tuple[FrameMessage, ...]], int]


class _Messages(NamedTuple):
    """Some messages of a frame: the first and the last so many bytes are not theirs; of each, its ``length``.

    If they are more than one, the slot is one in rows which are the messages of all frames.
    """

    slot: Slot
    first: int
    last: int
    length: int
    number: int


class Shape:
    """Frames of one size whose messages stand in the same places.

    Args:
        frame: one of them.
        lengths: of its messages, type and fields.
        table: what a decoder looks up by the type byte.
        checksum: the dialect's.

    Attributes:
        size: of each of the frames, in bytes.
    """

    def __init__(
        self, frame: bytes, lengths: Sequence[int], table: list[Layout | None], checksum: Checksum
    ) -> None:
        self.size = size = len(frame)
        self._messages = []
        at = HEADER
        for length, some in groupby(lengths):
            number = len(list(some))
            if number >= MANY:
                slot = Slot(0, length, length, table)
                last = size - at - number * length
                self._messages.append(_Messages(slot, at, last, length, number))
            else:
                for first in range(at, at + number * length, length):
                    slot = Slot(first, length, size, table)
                    self._messages.append(_Messages(slot, first, size - first - length, length, 1))
            at += number * length
        self._crc = checksum.algorithm.crc
        self._residue = bytes((checksum.algorithm.residue,))
        self._first = checksum.coverage.first
        self._size_byte = frame[2:3]
        self._varying = [place for place in range(self._first, len(frame) - 1) if place not in (0, 2)]
        self._rows = _after_zeros(checksum.algorithm.table())
        bare = frame[:1] + b"\0" + frame[2:3] + bytes(len(frame) - OVERHEAD)
        self._left = bytes((self._crc(bare[self._first :]),))

    def fits(self, frame: bytes) -> bool:
        """Whether a frame has the shape."""
        return len(frame) == self.size and all(
            slot.fits(kind)
            for slot, first, last, length, _ in self._messages
            for kind in frame[first:-last:length]
        )

    def run(self, piece: bytes, due: int) -> Run | None:
        """The frames in order at the beginning of a piece, the first with the number ``due``; None: they are too few.

        The length of the piece is a multiple of the shape's.
        """
        size = self.size
        count = len(piece) // size
        if others := piece[::size].lstrip(_MAGIC_BYTE):
            count -= len(others)
        if others := piece[2 : count * size : size].lstrip(self._size_byte):
            count -= len(others)
        seqs = piece[1 : count * size : size]
        if seqs != _SEQS[due : due + count]:
            count = next(n for n, seq in enumerate(seqs) if seq != _SEQS[due + n])
        if count < FEWEST:
            return None
        piece = piece[: count * size]
        if len(self._varying) <= COLUMNS and count > COLUMN_FRAMES * len(self._varying):
            count = self._right_crcs(piece, count)
            raws = cut(piece[: count * size], size)
        else:
            raws = cut(piece, size)
            crcs = bytes(map(self._crc, cut(piece, size, self._first) if self._first else raws))
            if others := crcs.lstrip(self._residue):
                count -= len(others)
        piece = piece[: count * size]
        streams: list[Iterator[FrameMessage]] = []
        for slot, first, last, _, number in self._messages:
            rows = piece if number == 1 else b"".join(cut(piece, size, first, last))
            good, messages = slot.read(rows)
            if good < count * number:
                count = good // number
            streams.extend([messages] * number)
        if count < FEWEST:
            return None
        messages_of = zip(*streams, strict=False) if streams else iter([()] * count)
        return raws[:count], messages_of, len(streams)

    def _right_crcs(self, piece: bytes, count: int) -> int:
        """How many of the frames that a piece consists of have a right CRC, up to the first that has not.

        A CRC is linear but for what its initial value and final XOR add: the frames' first bytes are taken through the
        register together, then their second ones, and so on, and summed up.
        """
        size = self.size
        total = int.from_bytes(piece[size - 1 :: size], "little")
        for place in self._varying:
            column = piece[place::size]
            total ^= int.from_bytes(column.translate(self._rows[size - 2 - place]), "little")
        return count - len(total.to_bytes(count, "little").lstrip(self._left))


class Lookout:
    """Finds runs, and looks ahead no further and no oftener than pays off.

    It looks a few times as far as it has come before; after a disappointment not for a while, longer and longer.

    Args:
        table: what a decoder looks up by the type byte.
        checksum: the dialect's.

    Attributes:
        wait: so many frames go by before the next look.
    """

    def __init__(self, table: list[Layout | None], checksum: Checksum) -> None:
        self.wait = 0
        self._table = table
        self._checksum = checksum
        self._shape: Shape | None = None
        self._ahead = NEAR
        self._next_wait = 1

    def run(self, buffer: bytes, at: int, size: int, due: int) -> Run | None:
        """The run of frames of a size that begins at ``at`` with the number ``due``, if there is any."""
        most = (len(buffer) - at) // size
        if most < FEWEST or due < 0:
            return None
        if most > self._ahead:
            most = self._ahead
        piece = buffer[at : at + most * size]
        shape = self._shape
        run = shape.run(piece, due) if shape and shape.size == size else None
        if not run:
            like = piece[:size]
            if (not shape or not shape.fits(like)) and self._checksum.fits(like):
                shape = self._shape = self._shape_of(like)
                run = shape.run(piece, due) if shape else None
            if not run:
                self.wait = self._next_wait
                self._next_wait = min(2 * self.wait, LONGEST_WAIT)
                return None
        count = len(run[0])
        if count < most:
            self.wait = 1
        self._next_wait = 1
        self._ahead = NEAR if 4 * count < NEAR else min(4 * count, FAR)
        return run

    def _shape_of(self, frame: bytes) -> Shape | None:
        """The shape of a frame; None if it has an unknown type, or a message is cut short."""
        lengths = []
        at = HEADER
        while at < len(frame) - 1:
            layout = self._table[frame[at]]
            if layout is None or at + layout.size >= len(frame):
                return None
            lengths.append(layout.size)
            at += layout.size
        return Shape(frame, lengths, self._table, self._checksum)


@cache
def _after_zeros(step: bytes) -> tuple[bytes, ...]:
    """What a byte that goes into the register becomes when so many bytes of zeros follow it: 0, 1, 2 ..."""
    rows = [step]
    while len(rows) < MAX_FRAME:
        rows.append(rows[-1].translate(step))
    return tuple(rows)
