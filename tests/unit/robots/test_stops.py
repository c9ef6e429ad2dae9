"""Whoever was driving is told of a stop, even of one that falls between two commands."""

from __future__ import annotations

import asyncio
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import pytest

import turtlewire
from turtlewire.errors import StoppedError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

each_robot = pytest.mark.parametrize("url", ["sim:walter", "sim:simple", "sim:frame"])


@pytest.fixture
def elsewhere() -> Iterator[Callable[[Callable[[], Any]], Any]]:
    """Runs things in another thread, always the same."""
    with ThreadPoolExecutor(1) as pool:
        yield lambda act: pool.submit(act).result(60.0)


@each_robot
def test_a_stop_between_two_commands_of_another_thread(url: str, elsewhere: Any) -> None:
    with turtlewire.connect(url) as robot:
        robot.set_step_by_step(True)
        elsewhere(lambda: robot.forward(20))
        robot.stop()
        robot.forward(10)  # who says stop knows of it
        for move in (lambda: robot.forward(500), robot.finish):
            with pytest.raises(StoppedError, match="by somebody else"):
                elsewhere(move)
            assert robot.pose.y_mm == pytest.approx(30, abs=1.0)
            elsewhere(lambda: robot.forward(10))  # once
            robot.stop()
            robot.back(10)


@each_robot
def test_who_was_not_using_the_robot_is_told_nothing(url: str, elsewhere: Any) -> None:
    with turtlewire.connect(url) as robot:
        robot.set_step_by_step(True)
        robot.forward(20)
        elsewhere(robot.stop)
        elsewhere(lambda: robot.forward(10))
        late = threading.Thread(target=lambda: robot.forward(10))
        late.start()
        late.join()
        # Nor is this one, which lets go of it.
    assert robot.pose.y_mm == pytest.approx(40, abs=1.0)


@each_robot
def test_tasks(url: str) -> None:
    async def main() -> None:
        async with await turtlewire.connect_async(url) as robot:
            await robot.set_step_by_step(True)
            moved, stopped = asyncio.Event(), asyncio.Event()

            async def draw() -> None:
                await robot.forward(20)
                moved.set()
                await stopped.wait()
                await robot.forward(500)

            drawing = asyncio.create_task(draw())
            await moved.wait()
            await robot.stop()
            stopped.set()
            with pytest.raises(StoppedError, match="by somebody else"):
                await drawing
            await robot.forward(10)
            assert robot.pose.y_mm == pytest.approx(30, abs=1.0)

    asyncio.run(main())
