"""A whole capture at once, to columns: the streaming decoder's result, by NumPy (the extra ``turtlewire[bulk]``).

A CRC is linear but for what its initial value and final XOR add. With T what the register becomes by a byte of zeros,
and P[j] the XOR of all T^-i(byte i) before j, the linear part of the CRC over bytes s..e-1 is T^e(P[e] ^ P[s]). So one
pass over a capture gives P, and one look at P tells of every A3 whether a frame with a right CRC begins there.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from turtlewire.protocols.frame.dialect import TO_ROBOT
from turtlewire.protocols.frame.layout import layouts
from turtlewire.protocols.frame.message import HEADER, MAGIC, MAX_FRAME, MAX_PAYLOAD, OVERHEAD, FrameMessage
from turtlewire.protocols.message import KINDS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from turtlewire.protocols.checksums import Checksum
    from turtlewire.protocols.frame.dialect import Dialect
    from turtlewire.protocols.frame.layout import Layout

# So much of a capture is worked on at a time: what is looked up again and again stays in the processor's cache.
BLOCK = 1 << 18
_DTYPES = {"u8": "u1", "bool": "?", "u16": ">u2", "i16": ">i2", "u32": ">u4", "i32": ">i4", "f32": ">f4"}

COUNTS, UNKNOWN_TYPE, INCONSISTENT = 0, 1, 2

Column = Any  # NDArray of the field's kind


class Messages(NamedTuple):
    """All messages of one type, in order.

    Attributes:
        frame: of each, the index of its frame.
        offset: where in the capture its type byte stands.
        refused: whether it breaks its restriction (F4): not to be carried out.
        fields: a column for each field, by name.
    """

    frame: NDArray[np.int64]
    offset: NDArray[np.int64]
    refused: NDArray[np.bool_]
    fields: dict[str, Column]


class Capture(NamedTuple):
    """Every frame with a right CRC that a receiver takes, and its messages.

    Attributes:
        offset: where in the capture each frame's magic byte stands.
        seq: the sequence numbers.
        size: how many bytes of messages each carries.
        ignored: COUNTS; or UNKNOWN_TYPE or INCONSISTENT: then none of its messages is here (F3).
        messages: by the messages' classes.
    """

    offset: NDArray[np.int64]
    seq: NDArray[np.uint8]
    size: NDArray[np.uint8]
    ignored: NDArray[np.uint8]
    messages: dict[type[FrameMessage], Messages]


class _Tables(NamedTuple):
    """What the trick looks up: T^k(v) at k * 256 + v, the period of T, and what a right CRC leaves, by length."""

    powers: NDArray[np.uint8]
    period: int
    base: NDArray[np.int32]
    left: NDArray[np.uint8]


@lru_cache(maxsize=8)
def _tables(checksum: Checksum) -> _Tables:
    step = checksum.algorithm.table()
    rows = [bytes(range(256))]
    while (row := rows[-1].translate(step)) != rows[0]:
        rows.append(row)
    period = len(rows)
    base = ((-np.arange(BLOCK + MAX_FRAME)) % period * 256).astype(np.int32)
    crc, residue = checksum.algorithm.crc, checksum.algorithm.residue
    left = np.array([residue ^ crc(bytes(length)) for length in range(MAX_FRAME + 1)], np.uint8)
    return _Tables(np.frombuffer(b"".join(rows), np.uint8), period, base, left)


def decode(data: bytes, dialect: Dialect, direction: str = TO_ROBOT) -> Capture:
    """Decode a whole capture: what ``FrameDecoder.receive_data`` and then ``end`` take for frames.

    What is damaged has no place in the columns; the streaming decoder tells about it.
    """
    capture = np.frombuffer(data, np.uint8)
    table = layouts(dialect, direction)
    parts: list[Capture] = []
    taken = frames = 0  # where the last frame ended; how many there have been
    for at in range(0, max(1, len(capture)), BLOCK):
        offset = _starts(capture, at, dialect.checksum)
        offset = offset[np.searchsorted(offset, taken) :]
        size = capture[offset + 2]
        keep = _not_within_another(offset, offset + size + OVERHEAD)
        if keep is not None:
            offset, size = offset[keep], size[keep]
        if len(offset):
            taken = int(offset[-1]) + int(size[-1]) + OVERHEAD
        parts.append(_messages(capture, offset, size, table, frames))
        frames += len(offset)
    return parts[0] if len(parts) == 1 else _joined(parts)


def _joined(parts: list[Capture]) -> Capture:
    """The columns of all blocks, one behind the other."""
    messages = {}
    for message_type in parts[0].messages:
        of_type = [part.messages[message_type] for part in parts]
        frame, offset, refused = (np.concatenate([found[n] for found in of_type]) for n in range(3))
        fields = {
            name: np.concatenate([found.fields[name] for found in of_type]) for name in of_type[0].fields
        }
        messages[message_type] = Messages(frame, offset, refused, fields)
    offset, seq, size, ignored = (np.concatenate([part[n] for part in parts]) for n in range(4))
    return Capture(offset, seq, size, ignored, messages)


def _starts(capture: NDArray[np.uint8], at: int, checksum: Checksum) -> NDArray[np.int64]:
    """Where in a block a frame with a right CRC could begin."""
    block = capture[at : at + BLOCK + MAX_FRAME]
    tables = _tables(checksum)
    start = np.flatnonzero(block[: min(BLOCK, len(block) - HEADER)] == MAGIC) if len(block) > HEADER else None
    if start is None or not len(start):
        return np.empty(0, np.int64)
    size = block[start + 2]
    end = start + size + OVERHEAD
    fits = (size <= MAX_PAYLOAD) & (end <= len(block))
    if not fits.all():
        start, end = start[fits], end[fits]
    index = tables.base[: len(block)] + block
    xor = np.empty(len(block) + 1, np.uint8)
    xor[0] = 0
    np.bitwise_xor.accumulate(tables.powers.take(index, mode="clip"), out=xor[1:])
    first = start + checksum.coverage.first
    found = xor[end] ^ xor[first]
    if tables.left.any():
        found ^= tables.powers[(-end) % tables.period * 256 + tables.left[end - first]]
    right: NDArray[np.int64] = start[found == 0] + at
    return right


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


def _messages(
    capture: NDArray[np.uint8],
    offset: NDArray[np.int64],
    size: NDArray[np.uint8],
    table: list[Layout | None],
    before: int,
) -> Capture:
    """What stands in a block's frames: all first messages, then all second ones, and so on.

    ``before`` frames stand in the blocks before.
    """
    sizes = np.array([0 if layout is None else layout.size for layout in table], np.uint8)
    ignored = np.zeros(len(offset), np.uint8)
    frame = np.flatnonzero(size)
    at = offset[frame] + HEADER
    stop = at + size[frame]
    found: list[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.uint8]]] = []
    while len(frame):
        kind = capture[at]
        length = sizes[kind]
        after = at + length
        good = (length > 0) & (after <= stop)
        if not good.all():
            ignored[frame[~good]] = INCONSISTENT
            ignored[frame[length == 0]] = UNKNOWN_TYPE
            frame, at, stop, kind, after = frame[good], at[good], stop[good], kind[good], after[good]
        found.append((frame, at, kind))
        more = after < stop
        frame, at, stop = frame[more], after[more], stop[more]
    frames, places, kinds = (
        (np.concatenate(column) for column in zip(*found, strict=True))
        if len(found) > 1
        else (found[0] if found else (frame, at, capture[:0]))
    )
    if ignored.any():
        counts = ignored[frames] == COUNTS
        frames, places, kinds = frames[counts], places[counts], kinds[counts]
    if len(found) > 1:
        order = np.argsort(places, kind="stable")
        frames, places, kinds = frames[order], places[order], kinds[order]
    messages = {}
    for number, layout in enumerate(table):
        if layout is not None:
            of_kind = kinds == number
            whole = bool(of_kind.all())
            mine, where = (frames, places) if whole else (frames[of_kind], places[of_kind])
            messages[layout.message_type] = _columns(capture, mine + before, where, layout)
    return Capture(offset, capture[offset + 1], size, ignored, messages)


def _columns(
    capture: NDArray[np.uint8], frame: NDArray[np.int64], at: NDArray[np.int64], layout: Layout
) -> Messages:
    fields: dict[str, Column] = {}
    place = 1
    for field in layout.message_type.FIELDS:
        width = KINDS[field.kind][0]
        if width == 1:
            column = capture[at + place]
            fields[field.name] = column != 0 if field.kind == "bool" else column
        else:
            raw = capture[(at + place)[:, None] + np.arange(width)]
            wire = np.dtype(_DTYPES[field.kind])
            fields[field.name] = raw.view(wire)[:, 0].astype(wire.newbyteorder("="))
        place += width
    refused = np.zeros(len(at), np.bool_)
    columns = list(fields.values())
    for limit in layout.limits:
        column = columns[limit.place]
        refused |= ~((column >= limit.low) & (column <= limit.high))
        if limit.among is not None:
            refused |= ~np.isin(column, list(limit.among))
    return Messages(frame, at, refused, fields)
