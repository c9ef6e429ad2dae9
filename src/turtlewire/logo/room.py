"""Room for programs, as long as one runs.

Python's recursion limit: a deep recursion in Logo is one in Python. How often Python looks for objects that hold one
another: lists never do, so in a program that makes many of them it would look in vain for a quarter of the time. And
memory for the way out of a program that has used up all the rest.
"""

from __future__ import annotations

import gc
import sys

_found: list[int] = []  # for each running program, the limit to be put back
_SELDOM = (50_000, 20, 50)  # after how many more objects; see Python's module gc
_often: list[tuple[int, int, int]] = []  # how often it was before

RESERVE = 64 << 20  # bytes; nothing is ever written there, so that no memory is taken before it is needed


def reserve() -> bytes:
    """As much as there is: the program before this one may have left little."""
    for size in (RESERVE, RESERVE // 8):
        try:
            return bytes(size)
        except MemoryError:
            gc.collect()
    return b""


class RoomForRecursion:
    """Lets Python functions nest this deep, while it is entered.

    Several threads may be within: the last puts back what the first found.

    Args:
        frames: how deep.
    """

    def __init__(self, frames: int) -> None:
        self._frames = frames
        self._limit = 0

    def __enter__(self) -> None:
        self._limit = _found[0] if _found else sys.getrecursionlimit()
        if not _found:
            _often.append(gc.get_threshold())
            gc.set_threshold(*_SELDOM)
        _found.append(self._limit)
        sys.setrecursionlimit(max(self._limit, self._frames))

    def __exit__(self, *_: object) -> None:
        _found.remove(self._limit)
        if not _found:
            sys.setrecursionlimit(self._limit)
            gc.set_threshold(*_often.pop())
