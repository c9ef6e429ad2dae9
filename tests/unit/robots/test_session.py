"""A session over a real port: bytes as they come, one alarm, and who is woken by what."""

from __future__ import annotations

import asyncio
import os
import pty
import tty
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.errors import LinkClosedError
from turtlewire.links.stream import open_port
from turtlewire.protocols.simple.events import Done, Event
from turtlewire.protocols.simple.host import Host
from turtlewire.protocols.simple.messages import DriveForward, SteerLeft
from turtlewire.protocols.simple.robot import Robot
from turtlewire.robots.session import Session

if TYPE_CHECKING:
    from collections.abc import Coroutine, Iterator

BYTE_S = 10.0 / 9600


def run(main: Coroutine[Any, Any, None]) -> None:
    """Run to the end; never for ever."""
    asyncio.run(asyncio.wait_for(main, 20.0))


class Car:
    """A robot at the near end of a pty, which answers when it is let."""

    def __init__(self) -> None:
        self.near, self._far = pty.openpty()
        tty.setraw(self._far)
        os.set_blocking(self.near, False)
        self.path = os.ttyname(self._far)
        self.robot = Robot()
        self.answers = True
        self.silenced = b""
        self.is_full = asyncio.Event()

    def attend(self) -> None:
        """Read what has come; answer."""
        replies = self.robot.receive_data(os.read(self.near, 4096)).replies
        if self.answers:
            os.write(self.near, replies)
        else:
            self.silenced += replies
            if len(self.silenced) == 2:
                self.is_full.set()

    def close(self) -> None:
        """Let go of the pty."""
        os.close(self.near)
        os.close(self._far)


@pytest.fixture
def car() -> Iterator[Car]:
    made = Car()
    yield made
    made.close()


class Served:
    """A session with it, in step, and what its machine told."""

    def __init__(self, car: Car) -> None:
        self.car = car
        self.events: list[Event] = []
        self.host = Host(boot_s=0.0, window=2, reply_delay_s=20.0)

    async def __aenter__(self) -> Session[Event]:
        link = await open_port(self.car.path, baud=9600)
        asyncio.get_running_loop().add_reader(self.car.near, self.car.attend)
        self.session: Session[Event] = Session(link, self.host, self.events.append, BYTE_S)
        self.session.start()
        self.host._line._reply_s = 0.3  # get in step quickly, but in earnest where there is much else to do
        self.host.connect(link.now())
        await self.session.until(lambda: self.host.in_step)
        self.host._line._reply_s = 20.0
        return self.session

    async def __aexit__(self, *_: object) -> None:
        await self.session.close()
        asyncio.get_running_loop().remove_reader(self.car.near)


def test_an_alarm_rings_though_everything_was_sent_and_nothing_comes(car: Car) -> None:
    async def main() -> None:
        async with Served(car) as session:
            now = session.link.now()
            rung: list[float] = []
            # The pump sleeps for ever before the first, and until the second while the third is set.
            await session.until(lambda: False, now + 0.01)
            session.set_alarm(now + 0.02, rung.append)
            await session.until(lambda: bool(rung))
            assert rung[0] >= now + 0.02
            session.set_alarm(now + 1e6, rung.append)
            await session.until(lambda: False, now + 0.03)
            session.set_alarm(now + 0.04, rung.append)
            await session.until(lambda: len(rung) == 2)
            session.set_alarm(now + 0.05, rung.append)
            session.clear_alarm()
            await session.until(lambda: False, now + 0.06)
            assert len(rung) == 2

    run(main())


def test_who_waits_is_woken_when_it_has_come_and_not_before(car: Car) -> None:
    async def main() -> None:
        served = Served(car)
        async with served as session:
            car.answers = False
            order: list[str] = []

            async def wait(name: str, tag: str) -> None:
                await session.until(lambda: any(isinstance(e, Done) and e.tag == tag for e in served.events))
                order.append(name)

            served.host.submit(DriveForward(7), "drive")
            served.host.submit(SteerLeft(9), "steer")
            both = [asyncio.create_task(wait("second", "steer")), asyncio.create_task(wait("first", "drive"))]
            await car.is_full.wait()
            assert len(session._waiting) == 2
            os.write(car.near, car.silenced[:1])
            await both[1]
            assert order == ["first"]
            assert len(session._waiting) == 1
            os.write(car.near, car.silenced[1:])
            await both[0]
            assert order == ["first", "second"]
            assert not session._waiting
            assert (car.robot.drive, car.robot.steer) == (7, -9)

    run(main())


def test_whoever_gives_up_waiting_leaves_nothing_behind(car: Car) -> None:
    async def main() -> None:
        async with Served(car) as session:
            for deadline in (session.link.now() + 1e6, float("inf")):
                waiting = asyncio.create_task(session.until(lambda: False, deadline))
                await asyncio.sleep(0)
                assert session._waiting
                waiting.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await waiting
                assert not session._waiting

    run(main())


def test_whoever_is_woken_first_may_close_the_session(car: Car) -> None:
    async def main() -> None:
        served = Served(car)
        async with served as session:

            async def close() -> None:
                await session.until(lambda: served.host.idle)
                await session.close()

            async def wait() -> None:
                await session.until(lambda: False)

            served.host.submit(DriveForward(7))
            first, second = asyncio.create_task(close()), asyncio.create_task(wait())
            await first
            with pytest.raises(LinkClosedError):
                await second

    run(main())


def broken(_: Event) -> None:
    raise ZeroDivisionError


def test_what_is_wrong_with_taking_bytes_ends_the_session(car: Car) -> None:
    async def main() -> None:
        complaints: list[Any] = []
        asyncio.get_running_loop().set_exception_handler(lambda _, context: complaints.append(context))
        served = Served(car)
        async with served as session:
            session._on_event = broken
            served.host.submit(DriveForward(7))
            with pytest.raises(LinkClosedError, match="not served any more"):
                await session.until(lambda: False)
            received = session.bytes_received
            os.write(car.near, b"K")
            with pytest.raises(LinkClosedError):
                session.flush()
        assert session.bytes_received == received
        assert isinstance(complaints[0]["exception"], ZeroDivisionError)

    run(main())


def test_bytes_are_taken_while_nobody_waits(car: Car) -> None:
    async def main() -> None:
        served = Served(car)
        async with served as session:
            told = asyncio.Event()
            session._on_event = lambda event: told.set() if event == Done(DriveForward(200), "tag") else None
            served.host.submit(DriveForward(200), "tag")
            session.mark()
            session.flush()
            assert session.sent_at is not None
            assert session.arrived_at == session.sent_at + 7 * BYTE_S
            assert session.free_at >= session.arrived_at  # behind what the way into step took
            await told.wait()
            assert served.host.idle

    run(main())
