"""Python's recursion limit, raised while Logo runs: a deep recursion in Logo is one in Python."""

from __future__ import annotations

import sys

_found: list[int] = []  # for each running program, the limit to be put back


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
        _found.append(self._limit)
        sys.setrecursionlimit(max(self._limit, self._frames))

    def __exit__(self, *_: object) -> None:
        _found.remove(self._limit)
        if not _found:
            sys.setrecursionlimit(self._limit)
