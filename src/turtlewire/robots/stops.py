"""Who has been told of which stop: whoever was driving does not go on as if nothing had happened.

A stop that falls between two commands of a program interrupts none of them. So the next command of every other thread
or task that was using the robot raises ``StoppedError``, once; whoever said stop goes on as it likes.
"""

from __future__ import annotations

import contextlib
import sys
import threading
import weakref
from contextvars import ContextVar
from typing import TYPE_CHECKING

from turtlewire.errors import StoppedError

if TYPE_CHECKING:
    from collections.abc import Iterator

# On whose behalf a coroutine runs, where that is not the task or the thread that it runs in.
_caller: ContextVar[object | None] = ContextVar("caller", default=None)


@contextlib.contextmanager
def on_behalf_of(caller: object) -> Iterator[None]:
    """What is said to robots here, and in tasks begun here, is said by this one, whatever thread or task that is in."""
    token = _caller.set(caller)
    try:
        yield
    finally:
        _caller.reset(token)


def _who() -> object:
    caller = _caller.get()
    if caller is not None:
        return caller
    asyncio = sys.modules.get("asyncio")  # without it, there are no tasks
    task = None
    if asyncio is not None:
        with contextlib.suppress(RuntimeError):  # no loop runs here
            task = asyncio.current_task()
    return task or threading.current_thread()


class Stops:
    """The stops of one robot."""

    def __init__(self) -> None:
        self._count = 0
        # How many stops each of those who use the robot knows of.
        self._known: weakref.WeakKeyDictionary[object, int] = weakref.WeakKeyDictionary()

    def add(self) -> None:
        """The caller stops the robot."""
        self._count += 1
        self.known()

    def known(self) -> None:
        """The caller knows of every stop so far."""
        self._known[_who()] = self._count

    def check(self) -> None:
        """Before everything that moves the robot.

        Raises ``StoppedError`` if somebody else has stopped it since the caller last used it.
        """
        who = _who()
        if self._known.setdefault(who, self._count) != self._count:
            self._known[who] = self._count
            raise StoppedError(
                "the robot was stopped since the last command, by somebody else: what was waiting is abandoned"
            )
