"""Somebody else than the helm has the robot do something: a program, a message."""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
from typing import TYPE_CHECKING, TypeVar

from turtlewire.errors import StoppedError
from turtlewire.robots.stops import on_behalf_of

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from turtlewire.connect import AsyncRobot

T = TypeVar("T")
# What a stop has not ended by itself after so long is ended from outside.
PATIENCE_S = 0.2
STOPPED = "the robot was stopped meanwhile: nothing more is done for whoever had borrowed it"


class Lease:
    """The robot, lent: until it is closed, the helm drives and asks nothing by itself. ``Helm.lend`` makes it.

    Args:
        robot: connected.
        hands: held while anything is done with the robot.
        loop: of the robot's thread.
        give_back: called in that thread when the lease is over.

    Attributes:
        granted: set once the helm has let go, in the robot's thread.
        stopped: a stop has ended it; whatever is called now raises ``StoppedError``.
    """

    def __init__(
        self,
        robot: AsyncRobot,
        hands: asyncio.Lock,
        loop: asyncio.AbstractEventLoop,
        give_back: Callable[[Lease], None],
    ) -> None:
        self.granted = asyncio.Event()
        self.stopped = False
        self._robot = robot
        self._hands = hands
        self._loop = loop
        self._give_back = give_back
        self._tasks: set[asyncio.Task[object]] = set()

    def call(self, work: Callable[[AsyncRobot], Coroutine[object, None, T]]) -> concurrent.futures.Future[T]:
        """Have this done with the robot, in its thread, after what was called before; from any thread.

        The future raises what the work raises; ``StoppedError`` after a stop, whatever the work was.
        """
        coroutine = self._carry_out(work)
        try:
            return asyncio.run_coroutine_threadsafe(coroutine, self._loop)
        except RuntimeError:  # the robot's thread has ended
            coroutine.close()
            future: concurrent.futures.Future[T] = concurrent.futures.Future()
            future.set_exception(StoppedError(STOPPED))
            return future

    def close(self) -> None:
        """The helm may go on; from any thread."""
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._give_back, self)

    # ------------------------------------------------------------------ in the robot's thread

    async def _carry_out(self, work: Callable[[AsyncRobot], Coroutine[object, None, T]]) -> T:
        caller = asyncio.current_task()
        assert caller is not None
        task = asyncio.create_task(self._in_turn(work), name="turtlewire lent")
        self._tasks.add(task)
        try:
            return await task
        except asyncio.CancelledError:
            task.cancel()
            if self.stopped and not caller.cancelling():
                raise StoppedError(STOPPED) from None
            raise  # whoever wanted it does not any more
        finally:
            self._tasks.discard(task)

    async def _in_turn(self, work: Callable[[AsyncRobot], Coroutine[object, None, T]]) -> T:
        await self.granted.wait()
        async with self._hands:
            if self.stopped:
                raise StoppedError(STOPPED)
            with on_behalf_of(self):
                return await work(self._robot)

    def end(self) -> None:
        """The robot has just been stopped: what is under way ends."""
        self.stopped = True
        self._loop.call_later(PATIENCE_S, self._cut_off, frozenset(self._tasks))

    @staticmethod
    def _cut_off(tasks: frozenset[asyncio.Task[object]]) -> None:
        for task in tasks:
            task.cancel()
