"""What lets people call the asynchronous drivers without asyncio: one implementation, two ways to run it."""

from __future__ import annotations

import contextlib
import threading
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, TypeVar

from turtlewire.errors import LinkClosedError, UsageError
from turtlewire.robots.session import PUMP
from turtlewire.robots.stops import on_behalf_of

if TYPE_CHECKING:
    from collections.abc import Coroutine

T = TypeVar("T")
WAITS_FOR_ITSELF = (
    "a function that the robot's driver calls (notify) must not wait for the robot: "
    "it can stop() it, nothing else"
)


class Runner(ABC):
    """Runs coroutines of a driver to their end, from any thread."""

    @abstractmethod
    def run(self, coroutine: Coroutine[object, None, T]) -> T:
        """Run it, and return or raise what it does."""

    @abstractmethod
    def close(self) -> None:
        """Let go of what the runner holds."""

    @property
    def is_here(self) -> bool:
        """Whether this thread is the one that runs the coroutines, and so cannot wait for them."""
        return False


def _run_through(coroutine: Coroutine[object, None, T], error: Exception) -> T:
    """Run it here and now; raises the error if it would wait."""
    try:
        coroutine.send(None)
    except StopIteration as end:
        result: T = end.value
        return result
    coroutine.close()
    raise error


class InlineRunner(Runner):
    """For links in virtual time: a coroutine over one never suspends, so it simply runs through."""

    def __init__(self) -> None:
        self._lock = threading.RLock()

    def run(self, coroutine: Coroutine[object, None, T]) -> T:
        """Run it here."""
        with self._lock:
            return _run_through(coroutine, RuntimeError("a link in virtual time must never wait"))

    def close(self) -> None:
        """There is nothing to let go of."""


class ThreadRunner(Runner):
    """For links in the background: an event loop in a thread of its own."""

    def __init__(self) -> None:
        import asyncio

        self._loop = asyncio.new_event_loop()
        self._lock = threading.Lock()
        self._closed = False
        self._thread = threading.Thread(target=self._loop.run_forever, name="turtlewire", daemon=True)
        self._thread.start()

    def run(self, coroutine: Coroutine[object, None, T]) -> T:
        """Run it over there. An exception that comes here meanwhile (Ctrl-C) ends it there too.

        Whoever is called from over there (``notify``) cannot wait for it: what never waits, as ``stop``, runs through.
        Raises ``LinkClosedError`` after ``close``, and ``UsageError`` for what would wait for itself.
        """
        if self.is_here:
            return _run_through(coroutine, UsageError(WAITS_FOR_ITSELF))
        import asyncio
        import concurrent.futures

        future: concurrent.futures.Future[T] | None = None
        try:
            with self._lock:  # what is handed over before ``close`` is seen by it
                if self._closed:
                    coroutine.close()
                    raise LinkClosedError("the link to the robot is closed: connect again")
                with on_behalf_of(threading.current_thread()):
                    future = asyncio.run_coroutine_threadsafe(coroutine, self._loop)
            return future.result()
        except LinkClosedError:
            raise
        except concurrent.futures.CancelledError:
            raise LinkClosedError("the link to the robot was closed meanwhile: connect again") from None
        except BaseException:
            if future is None:
                self._end_over_there(coroutine)
            else:
                future.cancel()
            raise

    def _end_over_there(self, coroutine: Coroutine[object, None, T]) -> None:
        """An exception came while it was handed over: it may have got there, or not."""
        import asyncio

        def end() -> None:
            for task in asyncio.all_tasks(self._loop):
                if task.get_coro() is coroutine:
                    task.cancel()
                    return
            coroutine.close()

        self._loop.call_soon_threadsafe(end)

    @property
    def is_here(self) -> bool:
        """Whether this is the thread of the event loop."""
        return threading.current_thread() is self._thread

    def close(self) -> None:
        """End what still runs, the loop and its thread."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.run_until_complete(self._end_tasks())
        with contextlib.suppress(RuntimeError):  # no new threads while the interpreter ends
            self._loop.run_until_complete(self._loop.shutdown_default_executor())
        self._loop.close()

    async def _end_tasks(self) -> None:
        """Let what was cut off (by Ctrl-C) stop its robot and let go of its port; only then end what serves it."""
        import asyncio

        rest = asyncio.all_tasks() - {asyncio.current_task()}
        pumps = {task for task in rest if task.get_name() == PUMP}
        for tasks in (rest - pumps, pumps):
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
