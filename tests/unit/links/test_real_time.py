"""A simulated robot that lives on while nobody asks."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, TypeVar

import pytest

from turtlewire.errors import LinkClosedError, PortNotFoundError
from turtlewire.links.faults import Faults, FaultyLink
from turtlewire.links.memory import MemoryLink
from turtlewire.links.real_time import RealTimeLink
from turtlewire.robots.walter import AsyncWalter, Settings
from turtlewire.simulator.walter import SimulatedWalter

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

T = TypeVar("T")
# Fast: a second of the robot's time takes ten milliseconds.
PACE = 100.0


def run(coroutine: Coroutine[object, None, T]) -> T:
    return asyncio.run(coroutine)


async def until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < deadline
        await asyncio.sleep(0.002)


def test_a_driver_drives_it_as_a_real_one() -> None:
    async def drive() -> None:
        robot = SimulatedWalter()
        link = RealTimeLink(MemoryLink(robot, "sim:walter"), PACE)
        assert (link.url, link.in_background) == ("sim:walter", True)
        async with AsyncWalter(link, Settings()) as walter:
            await walter.connect()
            await walter.forward(100)
            await walter.right(90)
            await walter.finish()
            assert robot.pose == pytest.approx((0.0, 100.0, 90.0), abs=0.5)
            await walter.drive(0.5, 0.0)
            before = robot.pose.x_mm
            # Nobody pumps, and yet it moves; it is where it is now whenever somebody looks at the clock.
            await until(lambda: link.now() > 0.0 and robot.pose.x_mm > before + 100.0)
            await walter.drive(0.5, 0.0, valid_s=1.0)
            await until(lambda: link.now() > 0.0 and not robot.is_moving)

    run(drive())


def test_time_passes_at_its_pace_and_reads_wait() -> None:
    async def wait() -> None:
        robot = SimulatedWalter()
        link = RealTimeLink(MemoryLink(robot), PACE)
        wall_s, start = time.monotonic(), link.now()
        assert await link.read(link.now() + 5.0) == b""
        passed = link.now() - start
        assert 5.0 <= passed <= (time.monotonic() - wall_s) * PACE
        assert robot.now == pytest.approx(link.now(), abs=PACE)
        link.write(b"QP\r")
        answer = b""
        while answer != b"QP\0\r":
            answer += await link.read(link.now() + 100.0)
        waiting = asyncio.create_task(link.read(float("inf")))
        await asyncio.sleep(0)
        link.wake()
        assert await waiting == b""
        before = link.now()
        await link.sleep(before + 3.0)
        assert link.now() >= before + 3.0

    run(wait())


def test_what_had_not_gone_out_is_taken_back() -> None:
    async def write() -> None:
        robot = SimulatedWalter()
        link = RealTimeLink(MemoryLink(robot), 0.001)
        link.write(b"X" * 100)
        link.write_urgent(b" ")
        assert robot.bytes_on_line <= 2

    run(write())


def test_a_link_that_ends_and_is_opened_again() -> None:
    async def end() -> None:
        robot = SimulatedWalter()
        link = RealTimeLink(FaultyLink(MemoryLink(robot, "sim:walter"), Faults(close_at_s=1.0)), PACE)
        with pytest.raises(LinkClosedError, match="a fault that was asked for"):
            await link.read(float("inf"))
        with pytest.raises(LinkClosedError):
            link.write(b" ")
        assert link.now() > 1.0
        link = RealTimeLink(MemoryLink(robot), PACE)
        await link.close()
        with pytest.raises(LinkClosedError, match="closed"):
            await link.read(link.now() + 1.0)
        await link.reopen()
        assert await link.read(link.now() + 1.0) == b""

    run(end())


def test_a_robot_whose_plug_is_pulled_drives_on() -> None:
    async def unplug() -> None:
        robot = SimulatedWalter()
        link = FaultyLink(RealTimeLink(MemoryLink(robot, "sim:walter"), PACE), Faults())
        link.write(b"2\rA")  # direct control, start forward
        await until(lambda: link.now() > 0.0 and robot.pose.y_mm > 10.0)
        reading = asyncio.create_task(link.read(float("inf")))
        await asyncio.sleep(0)
        link.unplug(5.0)
        assert await reading == b""  # woken
        with pytest.raises(LinkClosedError, match="asked for"):
            await link.read(float("inf"))
        await link.close()
        with pytest.raises(PortNotFoundError):
            await link.reopen()
        before, pulled_s = robot.pose.y_mm, link.now()
        await link.sleep(pulled_s + 2.0)
        assert robot.now >= pulled_s + 2.0
        assert robot.pose.y_mm > before + 20.0
        await link.sleep(pulled_s + 5.0)
        await link.reopen()
        link.write(b" ")
        await until(lambda: link.now() > 0.0 and not robot.is_moving)

    run(unplug())
