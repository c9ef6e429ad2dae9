"""Where in a capture's frames the messages stand, and what they say, by NumPy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from turtlewire.protocols.frame.message import HEADER
from turtlewire.protocols.message import KINDS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from turtlewire.protocols.frame.bulk_frames import Frames
    from turtlewire.protocols.frame.layout import Layout

COUNTS, UNKNOWN_TYPE, INCONSISTENT = 0, 1, 2

Column = Any  # NDArray of the field's kind
_DTYPES = {"u8": "u1", "bool": "u1", "u16": ">u2", "i16": ">i2", "u32": ">u4", "i32": ">i4", "f32": ">f4"}


class Places(NamedTuple):
    """Where messages of one type stand: the indices of their frames, and where their type bytes are.

    ``step`` is how far it is from each to the next if that is always the same; else it is 0.
    """

    frame: NDArray[np.int64]
    offset: NDArray[np.int64]
    step: int


NOWHERE = Places(np.empty(0, np.int64), np.empty(0, np.int64), 0)


def places(
    capture: NDArray[np.uint8], frames: Frames, sizes: NDArray[np.uint8]
) -> tuple[NDArray[np.uint8], dict[int, Places]]:
    """Which of the frames are ignored, and by type where the messages of the others stand.

    ``sizes`` are those of type and fields, by type; 0: there is no such type.
    """
    if frames.step:
        found = _in_columns(capture, frames, sizes)
        if found is not None:
            return np.zeros(len(frames.offset), np.uint8), found
    return _one_after_the_other(capture, frames, sizes)


def _in_columns(
    capture: NDArray[np.uint8], frames: Frames, sizes: NDArray[np.uint8]
) -> dict[int, Places] | None:
    """Frames side by side; None if their messages do not stand in columns, or one is ignored."""
    offset, step = frames.offset, frames.step
    count, start = len(offset), int(offset[0])
    table = capture[start : start + count * step].reshape(count, step)
    columns: list[tuple[int, NDArray[np.uint8]]] = []
    place = HEADER
    while place < step - 1:
        kinds = table[:, place]
        length = int(sizes[kinds[0]])
        if not length or place + length >= step:
            return None
        if not (kinds == kinds[0]).all() and not (sizes.take(kinds) == length).all():
            return None
        columns.append((place, kinds))
        place += length
    if not columns:
        return {}
    number = np.arange(count)
    first = [int(kinds[0]) for _, kinds in columns]
    if len(set(first)) == len(first) and all((kinds == kinds[0]).all() for _, kinds in columns):
        return {
            kind: Places(number, offset + place, step)
            for kind, (place, _) in zip(first, columns, strict=True)
        }
    kinds = np.stack([kinds for _, kinds in columns], axis=1).reshape(-1)
    where = (offset[:, None] + np.array([place for place, _ in columns])).reshape(-1)
    return _by_type(np.repeat(number, len(columns)), where, kinds)


def _one_after_the_other(
    capture: NDArray[np.uint8], frames: Frames, sizes: NDArray[np.uint8]
) -> tuple[NDArray[np.uint8], dict[int, Places]]:
    """Any frames: the first messages of all, then the second ones, and so on."""
    ignored = np.zeros(len(frames.offset), np.uint8)
    frame = np.flatnonzero(frames.size)
    at = frames.offset.take(frame) + HEADER
    stop = at + frames.size.take(frame)
    found: list[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.uint8]]] = []
    while len(frame):
        kind = capture.take(at)
        length = sizes.take(kind)
        after = at + length
        good = after <= stop
        good &= length > 0
        if not good.all():
            ignored[frame[~good]] = INCONSISTENT
            ignored[frame[length == 0]] = UNKNOWN_TYPE
            frame, at, stop, kind, after = frame[good], at[good], stop[good], kind[good], after[good]
        found.append((frame, at, kind))
        more = after < stop
        if not more.any():
            break
        frame, at, stop = frame[more], after[more], stop[more]
    if ignored.any():
        counts = [ignored.take(frame) == COUNTS for frame, _, _ in found]
        found = [(f[c], a[c], k[c]) for (f, a, k), c in zip(found, counts, strict=True)]
    if len(found) <= 1:
        return ignored, _by_type(*found[0]) if found else {}
    number = np.zeros(len(frames.offset), np.int64)  # of messages in each
    for frame, _, _ in found:
        number[frame] += 1
    return ignored, _by_type(*_in_order(found, number))


def _in_order(
    found: list[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.uint8]]], number: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.uint8]]:
    """First messages, second messages and so on of frames which have so many: now frame by frame."""
    before = np.cumsum(number) - number
    total = int(number.sum())
    frames, where, kinds = np.empty(total, np.int64), np.empty(total, np.int64), np.empty(total, np.uint8)
    for turn, (frame, at, kind) in enumerate(found):
        index = before.take(frame) + turn
        frames[index], where[index], kinds[index] = frame, at, kind
    return frames, where, kinds


def _by_type(
    frame: NDArray[np.int64], where: NDArray[np.int64], kinds: NDArray[np.uint8]
) -> dict[int, Places]:
    """Messages, in order, by their types."""
    present = np.flatnonzero(np.bincount(kinds, minlength=256)).tolist()
    if len(present) == 1:
        return {present[0]: Places(frame, where, 0)}
    chosen = {kind: np.flatnonzero(kinds == kind) for kind in present}
    return {kind: Places(frame.take(some), where.take(some), 0) for kind, some in chosen.items()}


def fields(capture: NDArray[np.uint8], there: Places, layout: Layout) -> dict[str, Column]:
    """A column for each field of the messages that stand there."""
    columns: dict[str, Column] = {}
    place = 1
    for field in layout.message_type.FIELDS:
        width = KINDS[field.kind][0]
        column = _column(capture, there, place, np.dtype(_DTYPES[field.kind]))
        columns[field.name] = column != 0 if field.kind == "bool" else column
        place += width
    return columns


def _column(capture: NDArray[np.uint8], there: Places, place: int, wire: np.dtype[Any]) -> Column:
    """What stands so many bytes behind the type bytes."""
    offset, step = there.offset, there.step
    if not len(offset):
        return np.empty(0, wire.newbyteorder("="))
    if step:
        start = int(offset[0]) + place
        return np.ndarray((len(offset),), wire, capture, start, (step,)).astype(wire.newbyteorder("="))
    if wire.itemsize == 1:
        return capture[place:].take(offset)
    # One value for each byte where one could begin.
    begins = np.ndarray((len(capture) - place - wire.itemsize + 1,), wire, capture, place, (1,))
    return begins[offset].astype(wire.newbyteorder("="))


def refused(columns: dict[str, Column], layout: Layout, count: int) -> NDArray[np.bool_]:
    """Which of so many messages break their restriction (F4)."""
    broken = np.zeros(count, np.bool_)
    ordered = list(columns.values())
    for limit in layout.limits:
        column = ordered[limit.place]
        broken |= ~((column >= limit.low) & (column <= limit.high))
        if limit.among is not None:
            broken |= ~np.isin(column, list(limit.among))
    return broken
