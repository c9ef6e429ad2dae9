"""What a task waits for when it wants to go on the moment it can."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Generator
    from contextvars import Context


class Waiter:
    """Like a future with a truth value; but whoever awaits it goes on within ``wake``, not in the loop's next round.

    In between, the loop would ask the operating system for news once more: a tenth of what a command takes over a port.
    Where ``wake`` is called by another task, which cannot be left in the middle, it is the next round all the same.

    This is asyncio's contract of what may be awaited like a future. One task may await it, once.
    """

    __slots__ = ("_asyncio_future_blocking", "_context", "_go_on", "_is_cancelled", "_loop", "_value")

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._asyncio_future_blocking = False
        self._go_on: Callable[[Any], object] | None = None
        self._context: Context | None = None
        self._is_cancelled = False
        self._value: bool | None = None

    def wake(self) -> None:
        """It has come: let whoever awaits this go on, with True. Nothing happens if it goes on already."""
        if not self.done():
            self._let_go_on(value=True)

    def give_up(self) -> None:
        """It does not come: let whoever awaits this go on, with False. Nothing happens if it goes on already."""
        if not self.done():
            self._let_go_on(value=False)

    def _let_go_on(self, *, value: bool) -> None:
        self._value = value
        if self._go_on is None:
            return  # it has not begun to wait
        if asyncio.current_task(self._loop) is None:
            assert self._context is not None
            self._context.run(self._go_on, self)
        else:
            self._loop.call_soon(self._go_on, self, context=self._context)

    def __await__(self) -> Generator[Any, None, bool]:
        if not self.done():
            self._asyncio_future_blocking = True
            yield self
        return self.result()

    # what a task asks of it

    def get_loop(self) -> asyncio.AbstractEventLoop:
        """asyncio: the loop that it belongs to."""
        return self._loop

    def done(self) -> bool:
        """asyncio: whether there is nothing to wait for any more."""
        return self._value is not None or self._is_cancelled

    def result(self) -> bool:
        """asyncio: the value. Raises ``CancelledError``."""
        if self._is_cancelled:
            raise asyncio.CancelledError
        assert self._value is not None
        return self._value

    def add_done_callback(self, go_on: Callable[[Any], object], *, context: Context) -> None:
        """asyncio: how the task goes on."""
        self._go_on, self._context = go_on, context

    def cancel(self, msg: object = None) -> bool:  # noqa: ARG002 - asyncio's signature
        """asyncio: the task is to end; False if it goes on already."""
        if self.done():
            return False
        self._is_cancelled = True
        if self._go_on is not None:
            self._loop.call_soon(self._go_on, self, context=self._context)
        return True
