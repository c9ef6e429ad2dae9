"""Python's recursion limit, raised while Logo runs: a deep recursion in Logo is one in Python."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

_found: list[int] = []  # for each running program, the limit to be put back


@contextmanager
def room_for_recursion(frames: int) -> Iterator[None]:
    """Let Python functions nest this deep. Several threads may be within: the last puts back what the first found."""
    limit = _found[0] if _found else sys.getrecursionlimit()
    _found.append(limit)
    sys.setrecursionlimit(max(limit, frames))
    try:
        yield
    finally:
        _found.remove(limit)
        if not _found:
            sys.setrecursionlimit(limit)
