"""Whoever waits goes on at once; otherwise it is as with a future."""

from __future__ import annotations

import asyncio
import contextvars
from typing import TYPE_CHECKING

import pytest

from turtlewire.robots.waiter import Waiter

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

NAME: contextvars.ContextVar[str] = contextvars.ContextVar("name", default="nobody")


def run(main: Callable[[], Coroutine[None, None, None]]) -> None:
    """Run to the end; never for ever. With asyncio looking more closely."""
    asyncio.run(asyncio.wait_for(main(), 20.0), debug=True)


class Waiting:
    """A task that waits, and notes what it sees."""

    def __init__(self) -> None:
        self.waiter = Waiter(asyncio.get_running_loop())
        self.seen: list[object] = []
        self.task = asyncio.create_task(self._wait(), name="waiting")

    async def _wait(self) -> bool:
        NAME.set("waiting")
        self.seen.append("begun")
        try:
            value = await self.waiter
        except asyncio.CancelledError:
            self.seen.append("cancelled")
            raise
        task = asyncio.current_task()
        self.seen += [value, task.get_name() if task else None, NAME.get()]
        return value


async def from_the_loop(act: Callable[[], None]) -> None:
    """Do something as a transport's callback does, not within a task."""
    done: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    def call() -> None:
        try:
            assert asyncio.current_task() is None
            act()
        except AssertionError as error:
            done.set_exception(error)
        else:
            done.set_result(None)

    asyncio.get_running_loop().call_soon(call)
    await done


@pytest.mark.parametrize("value", [True, False])
def test_whoever_waits_goes_on_before_wake_returns(*, value: bool) -> None:
    async def main() -> None:
        one = Waiting()
        await asyncio.sleep(0)

        def wake() -> None:
            assert one.seen == ["begun"]
            (one.waiter.wake if value else one.waiter.give_up)()
            assert one.seen == ["begun", value, "waiting", "waiting"]
            assert asyncio.current_task() is None
            assert NAME.get() == "nobody"

        await from_the_loop(wake)
        assert await one.task is value
        # What has come stays as it is.
        one.waiter.wake()
        one.waiter.give_up()
        assert not one.waiter.cancel()
        assert one.waiter.result() is value

    run(main)


def test_another_task_is_not_left_in_the_middle() -> None:
    async def main() -> None:
        one = Waiting()
        await asyncio.sleep(0)
        one.waiter.wake()
        assert one.seen == ["begun"]
        assert asyncio.current_task() is not one.task
        assert await one.task
        assert one.seen == ["begun", True, "waiting", "waiting"]

    run(main)


def test_what_has_come_before_anybody_waits_is_not_waited_for() -> None:
    async def main() -> None:
        one = Waiting()
        one.waiter.wake()
        assert await one.task

    run(main)


def test_a_task_that_is_cancelled_hears_it_once() -> None:
    async def main() -> None:
        one = Waiting()
        await asyncio.sleep(0)
        one.task.cancel()
        await from_the_loop(one.waiter.wake)  # too late
        with pytest.raises(asyncio.CancelledError):
            await one.task
        assert one.seen == ["begun", "cancelled"]
        assert one.waiter.done()
        with pytest.raises(asyncio.CancelledError):
            one.waiter.result()

    run(main)


def test_a_task_that_is_cancelled_after_it_was_woken_is_cancelled_later() -> None:
    async def main() -> None:
        one = Waiting()
        await asyncio.sleep(0)
        one.waiter.wake()
        one.task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await one.task

    run(main)


def test_a_timeout_ends_it() -> None:
    async def main() -> None:
        waiter = Waiter(asyncio.get_running_loop())
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.0):
                await waiter
        assert waiter.done()

    run(main)


def test_what_goes_wrong_where_it_goes_on_is_the_task_s_own() -> None:
    async def main() -> None:
        waiter = Waiter(asyncio.get_running_loop())

        async def fail() -> None:
            await waiter
            raise ZeroDivisionError

        task = asyncio.create_task(fail())
        await asyncio.sleep(0)
        await from_the_loop(waiter.wake)
        with pytest.raises(ZeroDivisionError):
            await task

    run(main)


def test_a_loop_of_another_kind_is_refused_by_asyncio() -> None:
    async def main() -> None:
        other = asyncio.new_event_loop()
        waiter = Waiter(other)

        async def wait() -> None:
            await waiter

        with pytest.raises(RuntimeError, match="different loop"):
            await asyncio.create_task(wait())
        other.close()

    run(main)
