"""How much of a serial line commands can fill: by baud rate, by window, and by what a USB adapter keeps back.

A command is seven bytes; the line is in use while they go out. With a window of one, nothing goes out while host,
adapter and robot are busy with the answer. A simulated car receives at the line's pace, byte by byte, and answers.

First in virtual time, where neither host nor robot needs any time of its own: what the protocol allows. An adapter
hands answers over when its timer has run out: 16 ms is what many come with, 1 ms what Linux sets for ``low_latency``.
Then at the pace of the clock on the wall, over a pty, the car in a process of its own: what becomes of it.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import multiprocessing
from typing import TYPE_CHECKING

from turtlewire.links.memory import MemoryLink
from turtlewire.links.stream import open_port
from turtlewire.protocols.simple.events import Done
from turtlewire.protocols.simple.host import Host
from turtlewire.protocols.simple.messages import LENGTH, DriveForward, SteerRight
from turtlewire.robots.runner import InlineRunner
from turtlewire.robots.session import Session
from turtlewire.simulator.car import CarSettings, SimulatedCar
from turtlewire.simulator.server import serve

if TYPE_CHECKING:
    from collections.abc import Iterator
    from multiprocessing.connection import Connection

    from turtlewire.links.link import Link
    from turtlewire.links.memory import VirtualEnd
    from turtlewire.protocols.simple.events import Event

BAUDS = (9600, 115200)
WINDOWS = (1, 2, 4, 8)
TIMERS_S = (0.0, 0.001, 0.016)
BITS_PER_BYTE = 10
VIRTUAL_S = 4.0
REAL_S = 5.0
PATIENCE_S = 0.5  # a machine that is busy otherwise is no fault of the line
AIM, AIM_WINDOW = 0.99, 4


class Adapter:
    """A USB adapter before a robot in virtual time: what the robot says is kept until a timer runs out.

    The timer begins anew whenever it has run out, whether or not there was anything.
    """

    def __init__(self, robot: VirtualEnd, timer_s: float) -> None:
        self._robot = robot
        self._timer_s = timer_s
        self._kept = b""
        self._over_s = math.inf

    @property
    def now(self) -> float:
        """The robot's time."""
        return self._robot.now

    def write(self, data: bytes) -> None:
        """Nothing is kept on its way to the robot."""
        self._robot.write(data)

    def discard_output(self) -> None:
        """As without an adapter."""
        self._robot.discard_output()

    def port_opened(self) -> None:
        """As without an adapter."""
        self._robot.port_opened()

    def awaits_host(self) -> bool:
        """Whether nothing is to come."""
        return not self._kept and self._robot.awaits_host()

    def read(self, until: float) -> bytes:
        """Let time pass until something is handed over, or until a time."""
        while True:
            if not self._kept:
                self._kept = self._robot.read(until)
                if not self._kept:
                    return b""
                if self._timer_s:
                    self._over_s = math.floor(self.now / self._timer_s + 1.0) * self._timer_s
                else:
                    self._over_s = self.now
            if self.now >= self._over_s:
                data, self._kept = self._kept, b""
                return data
            if self.now >= until:
                return b""
            self._kept += self._robot.read(min(until, self._over_s))


class Stream:
    """Commands as fast as the window takes them: each answer brings the next one."""

    def __init__(self, link: Link, baud: int, window: int) -> None:
        self._baud = baud
        self._window = window
        self._host = Host(baud=baud, window=window, reply_delay_s=PATIENCE_S, boot_s=0.0)
        self._session: Session[Event] = Session(link, self._host, self._on_event, BITS_PER_BYTE / baud)
        self._submitted = self._answered = 0

    def _on_event(self, event: Event) -> None:
        if isinstance(event, Done):
            self._answered += 1
            self._submit()

    def _submit(self) -> None:
        self._submitted += 1
        value = self._submitted % 256
        self._host.submit(DriveForward(value) if self._submitted % 2 else SteerRight(value))
        self._session.flush()  # at once: the next one of its channel would take its place

    async def run(self, seconds: float) -> float:
        """The part of the time for which the line is in use."""
        session, host = self._session, self._host
        session.start()
        try:
            host.connect(session.link.now())
            await session.until(lambda: host.in_step)
            for _ in range(self._window):
                self._submit()
            begun_s, before = session.link.now(), self._answered
            await session.until(lambda: False, begun_s + seconds)
            took_s = session.link.now() - begun_s
            if host.resynchronisations > 1:
                raise RuntimeError("the car fell out of step: that figure would mean nothing")
            return (self._answered - before) * LENGTH * BITS_PER_BYTE / self._baud / took_s
        finally:
            await session.close()


def in_virtual_time(baud: int, window: int, timer_s: float) -> float:
    """Line use as the protocol allows it."""
    end = Adapter(SimulatedCar(CarSettings(baud=baud)), timer_s)
    return InlineRunner().run(Stream(MemoryLink(end), baud, window).run(VIRTUAL_S))


# ---------------------------------------------------------------- the clock on the wall


def be_a_car(baud: int, told: Connection) -> None:
    """Serve a car at a new pty, for ever."""
    asyncio.run(serve(SimulatedCar(CarSettings(baud=baud)), "pty", ready=told.send))


@contextlib.contextmanager
def car(baud: int) -> Iterator[str]:
    """A car in a process of its own; where it is."""
    told, tell = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.get_context("spawn").Process(target=be_a_car, args=(baud, tell), daemon=True)
    process.start()
    try:
        yield told.recv()
    finally:
        process.terminate()
        process.join()


async def at_the_wall_s_pace(path: str, baud: int, window: int) -> float:
    """Line use over a pty."""
    return await Stream(await open_port(path, baud=baud), baud, window).run(REAL_S)


def main() -> None:
    """Print the tables."""
    print(f"use of the line by commands, in virtual time ({VIRTUAL_S:g} s each)")
    print(f"{'baud':>7} {'timer':>7} " + "".join(f"{f'window {window}':>10}" for window in WINDOWS))
    for baud in BAUDS:
        for timer_s in TIMERS_S:
            used = [in_virtual_time(baud, window, timer_s) for window in WINDOWS]
            shown = f"{timer_s * 1000:g} ms" if timer_s else "none"
            print(f"{baud:7} {shown:>7} " + "".join(f"{part:10.1%}" for part in used))
    print(f"the same over a pty, at the pace of the clock on the wall ({REAL_S:g} s each)")
    for baud in BAUDS:
        with car(baud) as path:
            real = {window: asyncio.run(at_the_wall_s_pace(path, baud, window)) for window in WINDOWS}
        print(f"{baud:7} {'none':>7} " + "".join(f"{part:10.1%}" for part in real.values()))
        print(f"{'':16}the aim is {AIM:.0%} with a window of {AIM_WINDOW}: {real[AIM_WINDOW]:.1%}")


if __name__ == "__main__":
    main()
