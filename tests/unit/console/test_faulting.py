"""Faults that are turned up and down while a robot drives."""

from __future__ import annotations

import asyncio

import pytest

from turtlewire import configuration
from turtlewire.console.faulting import Faulting
from turtlewire.errors import LinkClosedError
from turtlewire.links.faults import Faults, FaultyLink
from turtlewire.links.memory import MemoryLink
from turtlewire.links.real_time import RealTimeLink
from turtlewire.simulator.walter import SimulatedWalter

QUIET = {"lose": 0.0, "add": 0.0, "flip": 0.0, "duplicate": 0.0, "delay_s": 0.0, "split": 0, "to": ""}
COUNTS = {"lost": 0, "added": 0, "flipped": 0, "duplicated": 0}


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def faulting(url: str = "sim:walter", pace: float = 1.0) -> tuple[Faulting, Clock]:
    clock = Clock()
    return Faulting(configuration.target(url), pace, clock), clock


def link() -> RealTimeLink:
    return RealTimeLink(MemoryLink(SimulatedWalter(), "sim:walter"), 100.0)


def test_a_real_robot_has_none() -> None:
    one, _ = faulting("/dev/ttyUSB0?faults=lose:0.5")
    real = link()
    assert one.over(real) is real
    assert (one.is_possible, one.state()) == (False, None)


def test_none_are_exactly_none_and_the_state_says_so() -> None:
    async def use() -> None:
        one, _ = faulting()
        off = {"on": False, **QUIET, "stalled_s": 0, "unplugged_s": 0, **COUNTS}
        assert one.state() == off
        over = one.over(link())
        assert isinstance(over, FaultyLink)
        assert over.faults == Faults()
        one.set(Faults(lose=1.0))
        await asyncio.sleep(0)
        over.write(b"QP\r")
        one.set(Faults())
        await asyncio.sleep(0)
        assert over.faults == Faults()
        assert one.state() == {**off, "lost": 3}
        over.write(b"QP\r")
        answer = b""
        while len(answer) < 4:
            answer += await over.read(over.now() + 10.0)
        assert answer == b"QP\0\r"

    asyncio.run(use())


def test_those_of_its_url_are_what_it_begins_with_and_a_new_link_has_the_last() -> None:
    async def use() -> None:
        one, _ = faulting("sim:walter?faults=lose:0.25,to:host")
        over = one.over(link())
        assert isinstance(over, FaultyLink)
        assert over.faults == Faults(lose=0.25, to="host")
        one.set(Faults(delay_s=1.0, split=2))
        again = one.over(link())
        assert isinstance(again, FaultyLink)
        assert again.faults == Faults(delay_s=1.0, split=2)
        state = one.state()
        assert state is not None
        assert state | {"delay_s": 0.0, "split": 0} == {
            "on": True,
            **QUIET,
            "stalled_s": 0,
            "unplugged_s": 0,
            **COUNTS,
        }

    asyncio.run(use())


def test_another_thread_has_it_done_by_that_of_the_link() -> None:
    async def use() -> None:
        one, clock = faulting(pace=2.0)
        over = one.over(link())
        assert await asyncio.to_thread(one.unplug, 10.0)
        state = one.state()
        assert state is not None
        assert (state["on"], state["unplugged_s"], state["stalled_s"]) == (True, 5, 0)
        with pytest.raises(LinkClosedError):
            await over.read(over.now() + 10.0)
        clock.now += 4.5
        state = one.state()
        assert state is not None
        assert (state["on"], state["unplugged_s"]) == (True, 1)
        clock.now += 0.5
        assert not one.is_on
        assert await asyncio.to_thread(one.stall, 3.0)
        state = one.state()
        assert state is not None
        assert state["stalled_s"] == 2

    asyncio.run(use())


def test_without_a_link_nothing_is_held_back() -> None:
    one, _ = faulting()
    assert not one.stall(3.0)
    assert not one.unplug(3.0)
    assert not one.is_on

    async def use() -> None:
        one.over(link())

    asyncio.run(use())  # and that thread is gone
    assert not one.stall(3.0)
    one.set(Faults(lose=0.1))
    assert one.is_on
