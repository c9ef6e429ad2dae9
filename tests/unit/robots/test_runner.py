"""Whoever waits for a coroutine of a driver may be interrupted at any moment."""

from __future__ import annotations

import asyncio
import inspect
import threading
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.errors import LinkClosedError, UsageError
from turtlewire.robots.runner import ThreadRunner

if TYPE_CHECKING:
    from collections.abc import Iterator

DEADLINE_S = 30.0


@pytest.fixture
def runner() -> Iterator[ThreadRunner]:
    made = ThreadRunner()
    yield made
    made.close()


class Motion:
    """Goes on until it is cancelled."""

    def __init__(self) -> None:
        self.begun, self.ended = threading.Event(), threading.Event()

    async def run(self) -> None:
        try:
            self.begun.set()
            await asyncio.sleep(1e6)
        finally:
            self.ended.set()


@pytest.mark.parametrize("got_there", [True, False])
def test_an_interrupt_while_it_is_handed_over_ends_it(
    runner: ThreadRunner, monkeypatch: pytest.MonkeyPatch, got_there: bool
) -> None:
    hand_over = asyncio.run_coroutine_threadsafe
    motion = Motion()

    def interrupted(coroutine: Any, loop: asyncio.AbstractEventLoop) -> Any:
        if got_there:
            hand_over(coroutine, loop)
            assert motion.begun.wait(DEADLINE_S)
        raise KeyboardInterrupt

    coroutine = motion.run()
    with monkeypatch.context() as patched:
        patched.setattr(asyncio, "run_coroutine_threadsafe", interrupted)
        with pytest.raises(KeyboardInterrupt):
            runner.run(coroutine)
    if got_there:
        assert motion.ended.wait(DEADLINE_S)
    runner.run(asyncio.sleep(0))  # whatever was to be done over there is done
    assert inspect.getcoroutinestate(coroutine) == inspect.CORO_CLOSED  # ended, or closed without a beginning


def test_after_close_nothing_is_run(runner: ThreadRunner) -> None:
    runner.close()
    coroutine = Motion().run()
    with pytest.raises(LinkClosedError, match="connect again"):
        runner.run(coroutine)
    assert inspect.getcoroutinestate(coroutine) == inspect.CORO_CLOSED


def test_over_there_only_what_never_waits_runs_through(runner: ThreadRunner) -> None:
    async def at_once() -> int:
        return 7

    async def nested() -> int:
        coroutine = asyncio.sleep(1.0)
        with pytest.raises(UsageError, match=r"it can stop\(\) it, nothing else"):
            runner.run(coroutine)
        return runner.run(at_once())

    assert runner.run(nested()) == 7
