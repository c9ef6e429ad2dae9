"""How far a program has come: its outermost loops and bodies, each as (index, total); and where it is."""

from __future__ import annotations

import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import CodeType, FrameType

    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.tokens import Place

_WATCHED = 6  # deeper loops move the estimate too little to be worth the time


class Progress:
    """The outermost levels of a running program. One thread moves it, any may ask."""

    def __init__(self) -> None:
        self._levels: list[list[int]] = []
        self._best: float | None = None

    def start(self, total: int) -> list[int]:
        """A program of this many top-level lines begins; see ``enter``."""
        level = [0, max(total, 1)]
        self._levels = [level]
        self._best = 0.0
        return level

    def finish(self) -> None:
        """The program has ended."""
        self._levels = []
        self._best = 1.0

    def enter(self, total: int) -> list[int] | None:
        """Begin a loop or body of this many parts; the caller keeps ``level[0]``, the index. ``None``: not watched."""
        if len(self._levels) >= _WATCHED:
            return None
        level = [0, max(total, 1)]
        self._levels.append(level)
        return level

    def leave(self) -> None:
        """End the loop or body entered last; only after an ``enter`` that gave a level."""
        self._levels.pop()

    @property
    def depth(self) -> int:
        """How many levels are watched right now."""
        return len(self._levels)

    def leave_to(self, depth: int) -> None:
        """End the levels that an error jumped out of."""
        del self._levels[depth:]

    def estimate(self) -> float | None:
        """0 to 1, never less than before; ``None`` before the first program."""
        if self._best is None:
            return None
        done, share = 0.0, 1.0
        for index, total in tuple(self._levels):
            done += share * min(index, total) / total
            share /= total
        self._best = max(self._best, min(done, 1.0))
        return self._best


def running_place(logo: Interpreter, evaluates: CodeType) -> Place:
    """Where a compiled function is, in whatever thread; ``None`` when the evaluator, which is this code, runs last."""
    for frame in sys._current_frames().values():
        here: FrameType | None = frame
        while here is not None:
            if here.f_code is evaluates and here.f_locals.get("self") is logo:
                break
            found = logo.compiler.place_in(here.f_code, here.f_lineno)
            if found is not None:
                return found
            here = here.f_back
    return None
