"""The asynchronous driver and its session (decisions section 4)."""

from __future__ import annotations

import asyncio
import math
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.errors import LinkClosedError, NoReplyError
from turtlewire.links.link import Link
from turtlewire.links.memory import MemoryLink
from turtlewire.protocols.walter.host import Host
from turtlewire.robots.runner import InlineRunner
from turtlewire.robots.session import Session
from turtlewire.robots.walter import AsyncWalter, Settings
from turtlewire.simulator.walter import SimulatedWalter
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from tests.unit.robots.conftest import MakeBench


def test_the_asynchronous_names_do_what_they_say() -> None:
    async def main() -> None:
        robot = SimulatedWalter()
        driver = AsyncWalter(MemoryLink(robot), paper=robot)
        async with driver:
            await driver.connect()
            await driver.forward(10)
            await driver.back(30)
            await driver.right(30)
            await driver.left(120)
            assert driver.pose == pytest.approx((0.0, -20.0, 270.0))
            await driver.set_x(7)
            await driver.set_y(8)
            assert driver.pose == pytest.approx((7.0, 8.0, 270.0))
            assert driver.towards(7, 9) == 0.0
            await driver.set_heading(1)
            await driver.arc(0, 10)
            await driver.arc(90, 10)
            await driver.clear_screen()
            await driver.clear_screen()
            assert driver.trace.strokes == []
            await driver.pen_up()
            await driver.forward(1)
            await driver.clear_screen()
            await driver.arc(90, 10)
            assert not driver.is_pen_down
            await driver.set_step_by_step(True)
            await driver.wait(2.0)
        with pytest.raises(LinkClosedError):
            await driver.forward(1)
        await driver.close()

    InlineRunner().run(main())


def test_what_is_reckoned_is_drawn_where_nothing_can_be_seen(bench: MakeBench) -> None:
    made = bench()
    made.turtle.forward(10)
    made.turtle.finish()
    (stroke,) = made.turtle.trace.strokes
    assert stroke.points == [(0.0, 0.0), (0.0, 10.0)]
    made.turtle.clean()
    assert made.turtle.trace.strokes == []


class DeafLink(Link):
    """A link in the background that takes bytes and brings none; it can end, or break in a way that is a bug."""

    url = "deaf:"
    in_background = True

    def __init__(self) -> None:
        self.sent = b""
        self.ended = False
        self.broken = False
        self._something = asyncio.Event()

    def now(self) -> float:
        return asyncio.get_running_loop().time()

    def write(self, data: bytes) -> None:
        if self.ended:
            raise LinkClosedError("ended")
        self.sent += data

    def write_urgent(self, data: bytes) -> None:
        self.write(data)

    async def read(self, until: float) -> bytes:
        timeout = None if until == math.inf else max(0.0, until - self.now())
        self._something.clear()
        try:
            await asyncio.wait_for(self._something.wait(), timeout)
        except TimeoutError:
            return b""
        if self.broken:
            raise ZeroDivisionError
        if self.ended:
            raise LinkClosedError("ended")
        return b""

    def wake(self) -> None:
        self._something.set()

    async def close(self) -> None:
        self.ended = True


def session(link: Link) -> Session[Any]:
    made: Session[Any] = Session(link, Host(), lambda _: None, 0.001)
    made.start()
    return made


def test_whoever_waits_hears_that_the_link_ended() -> None:
    async def main() -> None:
        link = DeafLink()
        one = session(link)
        waiting = asyncio.create_task(one.until(lambda: False))
        await asyncio.sleep(0)
        link.ended = True
        link.wake()
        with pytest.raises(LinkClosedError):
            await waiting
        assert one.state == "closed"
        with pytest.raises(LinkClosedError):
            one.flush()
        await one.close()

    asyncio.run(main())


def test_a_write_that_finds_the_link_ended_is_the_end_of_the_session() -> None:
    async def main() -> None:
        link = DeafLink()
        host = Host()
        one: Session[Any] = Session(link, host, lambda _: None, 0.001)
        link.ended = True
        host.emergency_stop(0.0)
        with pytest.raises(LinkClosedError):
            one.flush()
        assert one.state == "closed"

    asyncio.run(main())


def test_whoever_waits_never_waits_for_a_pump_that_broke() -> None:
    async def main() -> None:
        link = DeafLink()
        one = session(link)
        waiting = asyncio.create_task(one.until(lambda: False))
        await asyncio.sleep(0)
        link.broken = True
        link.wake()
        with pytest.raises(LinkClosedError, match="not served"):
            await waiting
        with pytest.raises(ZeroDivisionError):  # the bug is not hidden
            await one.close()

    asyncio.run(main())


def test_whoever_waits_while_the_session_is_closed_hears_of_it() -> None:
    async def main() -> None:
        one = session(DeafLink())
        waiting = asyncio.create_task(one.until(lambda: False))
        await asyncio.sleep(0)
        await one.close()
        with pytest.raises(LinkClosedError, match="closed"):
            await waiting

    asyncio.run(main())


def test_a_deadline_ends_a_wait() -> None:
    async def main() -> None:
        link = DeafLink()
        one = session(link)
        assert not await one.until(lambda: False, link.now())
        assert not await one.until(lambda: False, link.now() + 0.001)
        assert await one.until(lambda: True)
        await one.close()

    asyncio.run(main())


def test_a_deaf_robot_that_must_answer_is_no_hang() -> None:
    async def main() -> None:
        settings = Settings(boot_s=0.0, reply_timeout_s=0.001, baud=1_000_000, require_replies=True)
        driver = AsyncWalter(DeafLink(), settings)
        with pytest.raises(NoReplyError):
            await driver.connect()
        with pytest.raises(LinkClosedError):
            await driver.finish()

    asyncio.run(main())


def test_a_driver_that_never_connected_can_be_closed(bench: MakeBench) -> None:
    driver = AsyncWalter(MemoryLink(SimulatedWalter()))
    InlineRunner().run(driver.close(finish=False))
    assert driver.pose == Pose()
