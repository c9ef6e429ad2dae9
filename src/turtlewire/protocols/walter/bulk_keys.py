"""Direct control in a whole capture: which bytes are keys, and which are taken by the key before."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from turtlewire.protocols.walter.bulk_tables import NONE, NOTHING, WRONG_KEY
from turtlewire.protocols.walter.codec import CR, LF

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from turtlewire.protocols.walter.bulk_tables import Tables

    Integers = NDArray[np.int64]


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
    ret = np.flatnonzero((byte[:-1] == CR) & (byte[1:] == LF))
    kind[ret.compress(kind.take(ret) != NOTHING) + 1] = NOTHING  # W1
    taker, byte_taken = kind.take(place), byte.take(place + 1)
    taken = {number: byte_taken.compress(taker == number) for number in tables.key_fields}
    right, wrong = np.flatnonzero(kind < NOTHING), np.flatnonzero(kind == NONE)
    code = byte.take(wrong).astype(np.int64) + WRONG_KEY
    kind = kind.take(right)
    return Keys(
        _in_capture(right, parts), kind, taken, (_in_capture(wrong, parts), np.ones_like(wrong), code)
    )


def _in_capture(place: Integers, parts: list[tuple[int, int]]) -> Integers:
    """Places in the parts one behind the other, as places in the capture."""
    if len(parts) <= 1 or not len(place):
        return place + parts[0][0] if parts and parts[0][0] else place
    begins, ends = np.array(parts, np.int64).reshape(-1, 2).T
    joined = np.cumsum(ends - begins)
    return place + np.repeat(ends - joined, np.diff(place.searchsorted(joined), prepend=0))


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
