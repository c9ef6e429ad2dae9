"""Where in a capture the frames stand, by NumPy.

Two ways, with one result. Where frames of one size follow one another undamaged, the capture is a table with a row for
each frame, and every column is checked at once. Everywhere else, the CRCs of all frames that there could be come from
one pass over the bytes:

A CRC is linear but for what its initial value and final XOR add. With T what the register becomes by a byte of zeros,
and P[j] the XOR of all T^-i(byte i) before j, the linear part of the CRC over bytes s..e-1 is T^e(P[e] ^ P[s]). So one
look at P tells of every A3 whether a frame with a right CRC begins there.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from turtlewire.protocols.frame.message import HEADER, MAGIC, MAX_FRAME, MAX_PAYLOAD, OVERHEAD

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from turtlewire.protocols.checksums import Checksum

# So many bytes are worked on at a time, and stay in the processor's cache. Near a place where frames of one size end,
# less: they may soon go on.
BLOCK = 1 << 18
NEAR = 1 << 14
_WORD = np.dtype("<u8")


class Frames(NamedTuple):
    """Some frames, one behind the other: where they begin, and how many bytes of messages each carries.

    ``step`` is their size if they are all of one size and nothing is between them; else it is 0.
    """

    offset: NDArray[np.int64]
    size: NDArray[np.uint8]
    step: int


class _Tables(NamedTuple):
    """What is looked up, for a CRC.

    Attributes:
        powers: T^k(byte) at k * 256 + byte.
        period: of T.
        left: what the linear part is of a right CRC, by the number of bytes that it goes over.
    """

    powers: NDArray[np.uint8]
    period: int
    left: NDArray[np.uint8]


@lru_cache(maxsize=8)
def _tables(checksum: Checksum) -> _Tables:
    step = checksum.algorithm.table()
    rows = [bytes(range(256))]
    while (row := rows[-1].translate(step)) != rows[0]:
        rows.append(row)
    period = len(rows)
    crc, residue = checksum.algorithm.crc, checksum.algorithm.residue
    left = np.array([residue ^ crc(bytes(length)) for length in range(MAX_FRAME + 1)], np.uint8)
    return _Tables(np.frombuffer(b"".join(rows), np.uint8), period, left)


@lru_cache(maxsize=8)
def _inverses(period: int, length: int) -> NDArray[np.uint16]:
    """Where in ``powers`` the T^-i begin, for i from 0 to below ``length``."""
    return ((-np.arange(length)) % period * 256).astype(np.uint16)


def frames(capture: NDArray[np.uint8], checksum: Checksum) -> Iterator[Frames]:
    """All frames with a right CRC that a receiver takes, in order."""
    at, block = 0, NEAR
    while at < len(capture):
        size = int(capture[at + 2]) if at + 2 < len(capture) else 0
        count = _in_a_row(capture, at, size, checksum)
        if count:
            step = size + OVERHEAD
            stop = at + count * step
            yield Frames(np.arange(at, stop, step), np.full(count, size, np.uint8), step)
            at, block = stop, NEAR
            continue
        offset = _starts(capture, at, at + block, checksum)
        sizes = capture[2:].take(offset)
        end = offset + sizes
        end += OVERHEAD
        keep = _not_within_another(offset, end)
        if keep is not None:
            offset, sizes, end = offset[keep], sizes[keep], end[keep]
        if len(offset):
            yield Frames(offset, sizes, 0)
        at = max(at + block, int(end[-1]) if len(end) else 0)
        block = min(2 * block, BLOCK)


def _in_a_row(capture: NDArray[np.uint8], at: int, size: int, checksum: Checksum) -> int:
    """How many frames of a size follow one another from ``at`` on; 0 if they are too few to care."""
    step = size + OVERHEAD
    if size > MAX_PAYLOAD or len(capture) - at < NEAR:
        return 0
    tables, first, algorithm = _tables(checksum), checksum.coverage.first, checksum.algorithm
    rows = tables.powers.reshape(-1, 256)
    # A frame of zeros but for what all have in common; to its CRC, the others' bytes add their share.
    right = algorithm.crc((bytes((MAGIC, 0, size)) + bytes(size))[first:])
    count, block = 0, NEAR
    while True:
        most = min(block, len(capture) - at) // step
        table = capture[at : at + most * step].reshape(most, step)
        crc = table[:, step - 1] ^ right
        for place in range(first, step - 1):
            if place not in (0, 2):
                crc ^= rows[(step - 1 - place) % tables.period].take(table[:, place])
        good = (table[:, 0] == MAGIC) & (table[:, 2] == size) & (crc == 0)
        fine = most if good.all() else int(good.argmin())
        if fine < most and not count:
            return 0
        count += fine
        at += fine * step
        if fine < most or not most:
            return count
        block = min(2 * block, BLOCK)


def _starts(capture: NDArray[np.uint8], at: int, stop: int, checksum: Checksum) -> NDArray[np.int64]:
    """Where from ``at`` to ``stop`` a frame with a right CRC could begin."""
    block = capture[at : stop + MAX_FRAME]
    tables = _tables(checksum)
    start = np.flatnonzero(block[: max(0, min(stop - at, len(block) - HEADER))] == MAGIC)
    size = block[2:].take(start)
    fits = size <= MAX_PAYLOAD
    if len(block) < stop - at + MAX_FRAME:
        fits &= start + size + OVERHEAD <= len(block)
    if not fits.all():
        start, size = start[fits], size[fits]
    end = start + size
    end += OVERHEAD
    index = _inverses(tables.period, BLOCK + MAX_FRAME)[: len(block)] + block
    xor = _xor_before(tables.powers.take(index, mode="clip"))
    first = checksum.coverage.first
    found = xor.take(end)
    found ^= xor[first:].take(start)
    if tables.left.any():
        found ^= tables.powers.take((-end) % tables.period * 256 + tables.left.take(end - start - first))
    right: NDArray[np.int64] = start[found == 0]
    right += at
    return right


def _xor_before(values: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The XOR of all bytes before each, and of all: first within words of eight bytes, then over the words."""
    padded = np.zeros((len(values) + 16) // 8 * 8, np.uint8)
    padded[8 : 8 + len(values)] = values
    words = padded.view(_WORD)
    for shift in (8, 16, 32):
        words ^= words << np.uint64(shift)
    of_words = np.bitwise_xor.accumulate((words >> np.uint64(56)).astype(np.uint8))
    words[1:] ^= of_words[:-1] * np.uint64(0x0101_0101_0101_0101)
    return padded[7 : 8 + len(values)]


def _not_within_another(start: NDArray[np.int64], end: NDArray[np.int64]) -> NDArray[np.bool_] | None:
    """Which frames are left when those that begin within one before are not taken; None: all."""
    over = np.flatnonzero(start[1:] < end[:-1])
    if not len(over):
        return None
    keep = np.ones(len(start), np.bool_)
    last = len(start)
    for index in over.tolist():
        if keep[index]:
            within = index + 1
            while within < last and start[within] < end[index]:
                keep[within] = False
                within += 1
    return keep
