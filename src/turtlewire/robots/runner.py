"""What lets people call the asynchronous drivers without asyncio: one implementation, two ways to run it."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Coroutine

T = TypeVar("T")


class Runner(ABC):
    """Runs coroutines of a driver to their end, from any thread."""

    @abstractmethod
    def run(self, coroutine: Coroutine[object, None, T]) -> T:
        """Run it, and return or raise what it does."""

    @abstractmethod
    def close(self) -> None:
        """Let go of what the runner holds."""


class InlineRunner(Runner):
    """For links in virtual time: a coroutine over one never suspends, so it simply runs through."""

    def __init__(self) -> None:
        self._lock = threading.RLock()

    def run(self, coroutine: Coroutine[object, None, T]) -> T:
        """Run it here."""
        with self._lock:
            try:
                coroutine.send(None)
            except StopIteration as end:
                result: T = end.value
                return result
            coroutine.close()
            raise RuntimeError("a link in virtual time must never wait")

    def close(self) -> None:
        """There is nothing to let go of."""


class ThreadRunner(Runner):
    """For links in the background: an event loop in a thread of its own."""

    def __init__(self) -> None:
        import asyncio

        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="turtlewire", daemon=True)
        self._thread.start()

    def run(self, coroutine: Coroutine[object, None, T]) -> T:
        """Run it over there. An exception that comes here meanwhile (Ctrl-C) ends it there too."""
        import asyncio

        future = asyncio.run_coroutine_threadsafe(coroutine, self._loop)
        try:
            return future.result()
        except BaseException:
            future.cancel()
            raise

    def close(self) -> None:
        """End the loop and its thread."""
        if self._loop.is_closed():
            return
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.run_until_complete(self._loop.shutdown_default_executor())
        self._loop.close()
