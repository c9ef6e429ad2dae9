"""How long a car command takes for the driver's caller: seven bytes out over a pty, the robot's one byte back.

Against the floor (``os.write`` and ``os.read``, nothing else), and what serial libraries need to write the same bytes
and wait for the same byte. They know nothing of robots; the driver checks and encodes the command, lets a stop overtake
it, watches the time, keeps account of where the car gets, and understands the answer.

Every contender has a pty of its own, with the same minimal robot at the other end in a process of its own. They take
turns, a few dozen commands each, in changing order: what the machine does besides happens to all of them. Only ratios
within one run count.
"""

from __future__ import annotations

import asyncio
import contextlib
import importlib
import multiprocessing
import os
import random
import time
import tty
from typing import TYPE_CHECKING, Any, TypeAlias

import turtlewire
from turtlewire.robots.car import Settings

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    # Does so many commands; how long each of them took, in nanoseconds.
    Turn: TypeAlias = Callable[[int], list[int]]

TURNS = 150
COMMANDS_PER_TURN = 80
COMMAND = b"F123000"
BAUD = 9600
LIMIT = 3.0  # times the floor, at the median
FLOOR, DRIVER = "os.write, os.read", "turtlewire, asyncio"

serial: Any = importlib.import_module("serial")
serialx: Any = importlib.import_module("serialx")
serial_asyncio_fast: Any = importlib.import_module("serial_asyncio_fast")
uvloop: Any = importlib.import_module("uvloop")


def be_a_robot(near: int) -> None:
    """Answer ``K`` to every seven bytes, for ever."""
    begun = 0
    while True:
        begun += len(os.read(near, 4096))
        if begun >= len(COMMAND):
            os.write(near, b"K" * (begun // len(COMMAND)))
            begun %= len(COMMAND)


class Contest(contextlib.ExitStack):
    """The contenders, their robots, and the two event loops that the asynchronous ones share."""

    def __init__(self) -> None:
        super().__init__()
        self.turns: dict[str, Turn] = {}
        self.asyncio = asyncio.new_event_loop()
        self.uvloop: asyncio.AbstractEventLoop = uvloop.new_event_loop()
        self.callback(self.asyncio.close)
        self.callback(self.uvloop.close)

    def robot(self) -> str:
        """Start a robot; where it is."""
        near, far = os.openpty()
        tty.setraw(far)
        robot = multiprocessing.get_context("fork").Process(target=be_a_robot, args=(near,), daemon=True)
        robot.start()
        self.callback(robot.join)
        self.callback(robot.terminate)
        os.close(near)
        self.callback(os.close, far)
        return os.ttyname(far)

    # ---------------------------------------------------------------- bytes

    def floor(self) -> Turn:
        """What no library can be faster than."""
        fd = os.open(self.robot(), os.O_RDWR | os.O_NOCTTY)
        self.callback(os.close, fd)
        return blocking(lambda: os.write(fd, COMMAND), lambda: os.read(fd, 1))

    def blocking(self, port: Any) -> Turn:
        """A port of pyserial, or of what is used like it."""
        if not port.is_open:
            port.open()
        self.callback(port.close)
        return blocking(lambda: port.write(COMMAND), lambda: port.read(1))

    def add_reader(self) -> Turn:
        """The least that can be done with asyncio."""
        loop = self.asyncio
        fd = os.open(self.robot(), os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        self.callback(os.close, fd)
        answer: asyncio.Future[bytes] = loop.create_future()
        loop.add_reader(fd, lambda: answer.set_result(os.read(fd, 1)))
        self.callback(loop.remove_reader, fd)

        async def exchange(_: int) -> None:
            nonlocal answer
            answer = loop.create_future()
            os.write(fd, COMMAND)
            await answer

        return asynchronous(loop, exchange)

    def protocol(self, library: Any) -> Turn:
        """A transport and a protocol."""
        loop = self.asyncio
        opened = library.create_serial_connection(loop, Answers, self.robot(), baudrate=BAUD)
        transport, answers = loop.run_until_complete(opened)

        async def close() -> None:
            transport.close()
            await answers.lost

        self.callback(lambda: loop.run_until_complete(close()))

        async def exchange(_: int) -> None:
            answers.next = loop.create_future()
            transport.write(COMMAND)
            await answers.next

        return asynchronous(loop, exchange)

    # ---------------------------------------------------------------- commands

    def driver(self, loop: asyncio.AbstractEventLoop) -> Turn:
        """``turtlewire.connect_async``, with a window of one command."""
        connected = turtlewire.connect_async(self.robot(), Settings(baud=BAUD, boot_s=0.0))
        car = loop.run_until_complete(connected)
        self.callback(lambda: loop.run_until_complete(car.close(finish=False)))
        motor = car.motor

        async def exchange(i: int) -> None:
            await motor(i % 256)

        return asynchronous(loop, exchange)

    def synchronous_driver(self) -> Turn:
        """``turtlewire.connect``: each call goes to an event loop in another thread, and back."""
        car = turtlewire.connect(self.robot(), Settings(baud=BAUD, boot_s=0.0))
        self.callback(lambda: car.close(finish=False))

        def turn(count: int) -> list[int]:
            clock, times = time.perf_counter_ns, []
            for i in range(count):
                begun = clock()
                car.motor(i % 256)
                times.append(clock() - begun)
            return times

        return turn


class Answers(asyncio.Protocol):
    """Waits for the next byte."""

    next: asyncio.Future[bytes]

    def __init__(self) -> None:
        self.lost = asyncio.get_running_loop().create_future()

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002 - asyncio's signature
        """asyncio: closed."""
        self.lost.set_result(None)

    def data_received(self, data: bytes) -> None:
        """asyncio: bytes came."""
        self.next.set_result(data)


def blocking(write: Callable[[], object], read: Callable[[], object]) -> Turn:
    """Write, and wait for the byte."""

    def turn(count: int) -> list[int]:
        clock, times = time.perf_counter_ns, []
        for _ in range(count):
            begun = clock()
            write()
            read()
            times.append(clock() - begun)
        return times

    return turn


def asynchronous(loop: asyncio.AbstractEventLoop, exchange: Callable[[int], Awaitable[None]]) -> Turn:
    """The same with an event loop."""

    async def turn(count: int) -> list[int]:
        clock, times = time.perf_counter_ns, []
        for i in range(count):
            begun = clock()
            await exchange(i)
            times.append(clock() - begun)
        return times

    return lambda count: loop.run_until_complete(turn(count))


def main() -> None:
    """Print the table."""
    chance = random.Random(1)
    with Contest() as contest:
        turns: dict[str, Turn] = {
            FLOOR: contest.floor(),
            "pyserial": contest.blocking(serial.Serial(contest.robot(), BAUD)),
            "serialx": contest.blocking(serialx.Serial(contest.robot(), BAUD)),
            "asyncio, add_reader": contest.add_reader(),
            "pyserial-asyncio-fast": contest.protocol(serial_asyncio_fast),
            "serialx, asyncio": contest.protocol(serialx),
            DRIVER: contest.driver(contest.asyncio),
            "turtlewire, uvloop": contest.driver(contest.uvloop),
            "turtlewire, blocking": contest.synchronous_driver(),
        }
        times: dict[str, list[int]] = {name: [] for name in turns}
        names = list(turns)
        for turn in turns.values():
            turn(COMMANDS_PER_TURN)  # warm
        for _ in range(TURNS):
            chance.shuffle(names)
            for name in names:
                times[name] += turns[name](COMMANDS_PER_TURN)
    print(f"round trip of a car command, {TURNS * COMMANDS_PER_TURN:,} of each; microseconds")
    print(f"{'':24} {'median':>8} {'p99':>8} {'x floor':>8}")
    floor = quantile(times[FLOOR], 0.5)
    for name in turns:
        median, p99 = quantile(times[name], 0.5), quantile(times[name], 0.99)
        print(f"{name:24} {median:8.1f} {p99:8.1f} {median / floor:8.2f}")
    ratio = quantile(times[DRIVER], 0.5) / floor
    print(f"the driver takes {ratio:.2f} times the floor (at most {LIMIT:g} is the aim)")


def quantile(times: list[int], part: float) -> float:
    """In microseconds."""
    return sorted(times)[int(part * len(times))] / 1000.0


if __name__ == "__main__":
    main()
