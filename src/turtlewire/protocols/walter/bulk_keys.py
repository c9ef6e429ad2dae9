"""Direct control in a whole capture: which bytes are keys, and which are taken by the key before."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from turtlewire.protocols.walter.bulk_tables import NONE, NOTHING, WRONG_KEY
from turtlewire.protocols.walter.codec import CR, LF

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from turtlewire.protocols.walter.bulk_tables import Tables

    Integers = NDArray[np.int64]

BLOCK = 1 << 17  # of a capture are worked on at a time, so that they stay in the processor's cache


class Keys(NamedTuple):
    """What stands in direct control, in order.

    Attributes:
        offset: where each key stands, with the byte that it takes.
        kind: the numbers of their types.
        taken: by number, the bytes that keys of this type take.
        wrong: of bytes that are no keys, where each stands, how long it is, and its code.
    """

    offset: Integers
    kind: NDArray[np.uint8]
    taken: dict[int, NDArray[np.uint8]]
    wrong: tuple[Integers, Integers, Integers]


def find_keys(data: bytes, parts: list[tuple[int, int]], tables: Tables) -> Keys:
    """All keys of some parts of a capture; each part but the last ends with a key that takes no byte."""
    keys = b"".join([data[begin:end] for begin, end in parts])
    splits_not = tables.takes + b"\r"
    blocks = []
    at = 0
    while at < len(keys):
        end = min(at + BLOCK, len(keys))
        while at < end < len(keys) and keys[end - 1] in splits_not:
            end -= 1
        if end == at:
            end = len(keys)
        blocks.append(_block(keys[at:end], at, tables))
        at = end
    offset, kind, takes, taken, wrong = (
        np.concatenate(column) for column in zip(*blocks or [_block(b"", 0, tables)], strict=True)
    )
    code = np.frombuffer(keys, np.uint8).take(wrong).astype(np.int64) + WRONG_KEY
    begins, ends = np.array(parts, np.int64).reshape(-1, 2).T
    joined = np.cumsum(ends - begins)
    offset += np.repeat(ends - joined, np.diff(offset.searchsorted(joined), prepend=0))
    wrong += np.repeat(ends - joined, np.diff(wrong.searchsorted(joined), prepend=0))
    of_type = {number: taken.compress(takes == number) for number in tables.key_fields}
    return Keys(offset, kind, of_type, (wrong, np.ones_like(wrong), code))


def _block(keys: bytes, at: int, tables: Tables) -> tuple[NDArray[Any], ...]:
    """Where the keys are and their numbers; the numbers of those that take a byte, and the bytes; what is no key."""
    byte = np.frombuffer(keys, np.uint8)
    kind = np.frombuffer(bytearray(keys).translate(tables.keys), np.uint8)
    takes = np.zeros(len(keys), np.bool_)
    for number in tables.key_fields:
        takes |= kind == number
    place = _alternate(np.flatnonzero(takes))
    if len(place) and place[-1] == len(keys) - 1:
        kind[-1] = NOTHING
        place = place[:-1]
    kind[place + 1] = NOTHING
    line_feed = np.flatnonzero((byte[1:] == LF) & (byte[:-1] == CR) & (kind[:-1] != NOTHING)) + 1
    kind[line_feed] = NOTHING  # W1
    right = np.flatnonzero(kind < NOTHING)
    wrong = np.flatnonzero(kind == NONE)
    return right + at, kind.take(right), kind.take(place), byte.take(place + 1), wrong + at


def _alternate(place: Integers) -> Integers:
    """Without every second one in a row: it is taken by the one before."""
    follows = np.flatnonzero(place[1:] == place[:-1] + 1)
    if not len(follows):
        return place
    index = np.arange(len(follows))
    begins = np.concatenate([[True], follows[1:] != follows[:-1] + 1])
    begin = np.maximum.accumulate(np.where(begins, index, 0))
    is_key = np.ones(len(place), np.bool_)
    is_key[follows.compress((index - begin) % 2 == 0) + 1] = False
    return place.compress(is_key)
