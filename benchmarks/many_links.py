"""A thousand cars at a thousand links in one process, each told something twenty times a second.

Each link has a task of its own that sets a speed, waits for the car's answer, and waits for its next turn; the turns
are spread evenly. How long a command takes is counted from when its turn came: a process that does not keep up has
nowhere to hide that. The cars are served by one other process, which answers ``K`` to every seven bytes and does
nothing else.

With asyncio's own event loop and with uvloop; with nothing but ``add_reader``, ``os.write`` and ``os.read``, to see
what the machine can do at all; and with pyserial-asyncio-fast, as many as it takes.
"""

from __future__ import annotations

import asyncio
import contextlib
import gc
import importlib
import multiprocessing
import os
import resource
import select
import socket
import time
import tty
from array import array
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import turtlewire
from turtlewire.robots.car import Settings

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator, Sequence
    from multiprocessing.connection import Connection

LINKS = 1000
PEER_LINKS = (100, 200, 250, 300)
PER_SECOND = 20
SECONDS, PEER_SECONDS = 20.0, 5.0
AIM_S = 0.05
COMMAND = b"F%03d000"
LENGTH = 7
BAUD = 9600
# A machine that is busy otherwise is no fault of the line: it shows in the times.
PATIENCE_S = 5.0


# ---------------------------------------------------------------- the cars


def be_cars(nears: list[int], listener: socket.socket) -> None:
    """Answer at each of these, and at whatever connects, for ever."""
    poll = select.epoll()
    begun = dict.fromkeys(nears, 0)
    for fd in nears:
        poll.register(fd, select.EPOLLIN)
    poll.register(listener, select.EPOLLIN)
    connections = []
    while True:
        for fd, _ in poll.poll():
            if fd == listener.fileno():
                connections.append(listener.accept()[0])
                connections[-1].setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                begun[connections[-1].fileno()] = 0
                poll.register(connections[-1], select.EPOLLIN)
                continue
            count = begun[fd] + len(os.read(fd, 4096))
            if count >= LENGTH:
                os.write(fd, b"K" * (count // LENGTH))
            begun[fd] = count % LENGTH


@contextlib.contextmanager
def cars(count: int) -> Iterator[list[str]]:
    """So many cars in a process of their own: where they are. At ptys, or at sockets when the system has no more."""
    ends: list[tuple[int, int]] = []
    with contextlib.suppress(OSError):
        while len(ends) < count:
            ends.append(os.openpty())
            tty.setraw(ends[-1][1])
    urls = [os.ttyname(far) for _, far in ends]
    listener = socket.create_server(("127.0.0.1", 0), backlog=count)
    urls += [f"socket://127.0.0.1:{listener.getsockname()[1]}"] * (count - len(urls))
    serve = multiprocessing.get_context("fork").Process(
        target=be_cars, args=([near for near, _ in ends], listener), daemon=True
    )
    serve.start()
    for near, _ in ends:
        os.close(near)
    listener.close()
    try:
        yield urls
    finally:
        serve.terminate()
        serve.join()
        for _, far in ends:
            os.close(far)


# ---------------------------------------------------------------- who drives them


class Car(Protocol):
    """A car at one link."""

    async def motor(self, pwm: int) -> None:
        """Set a speed, and wait for the answer."""

    async def close(self, *, finish: bool) -> None:
        """Let go of it."""


async def driven(url: str) -> Car:
    """By the driver, over a serial port (``connect_async``)."""
    settings = Settings(baud=BAUD, boot_s=0.0, reply_delay_s=PATIENCE_S)
    car: Car = await turtlewire.connect_async(url, settings, notify=lambda _: None)
    return car


class Bare:
    """Bytes, and nothing else: what the machine can do."""

    def __init__(self, fd: int) -> None:
        self._fd = fd
        self._loop = asyncio.get_running_loop()
        self._loop.add_reader(fd, self._read)
        self._answer: asyncio.Future[None] = self._loop.create_future()

    def _read(self) -> None:
        os.read(self._fd, 4096)
        self._answer.set_result(None)

    async def motor(self, pwm: int) -> None:
        """Write seven bytes, wait for one."""
        self._answer = self._loop.create_future()
        os.write(self._fd, COMMAND % pwm)
        await self._answer

    async def close(self, *, finish: bool) -> None:  # noqa: ARG002 - as a driver
        """Close the port."""
        self._loop.remove_reader(self._fd)
        os.close(self._fd)


async def bare(url: str) -> Car:
    """Without any library; only for ptys."""
    return Bare(os.open(url, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK))


class Peer(asyncio.Protocol):
    """The same by a transport and a protocol."""

    _transport: asyncio.WriteTransport

    def __init__(self) -> None:
        self._answer: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._lost: Exception | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """asyncio: open."""
        assert isinstance(transport, asyncio.WriteTransport)
        self._transport = transport

    def data_received(self, data: bytes) -> None:  # noqa: ARG002 - asyncio's signature
        """asyncio: bytes came."""
        self._answer.set_result(None)

    def connection_lost(self, exc: Exception | None) -> None:
        """asyncio: over."""
        self._lost = exc or ConnectionError("closed")
        if not self._answer.done():
            self._answer.set_exception(self._lost)

    async def motor(self, pwm: int) -> None:
        """Write seven bytes, wait for one."""
        if self._lost is not None:
            raise self._lost
        self._answer = asyncio.get_running_loop().create_future()
        self._transport.write(COMMAND % pwm)
        await self._answer

    async def close(self, *, finish: bool) -> None:  # noqa: ARG002 - as a driver
        """Close the port."""
        self._transport.close()
        self._answer.cancel()


async def peer(url: str) -> Car:
    """By pyserial-asyncio-fast; only for ptys."""
    library: Any = importlib.import_module("serial_asyncio_fast")
    _, protocol = await library.create_serial_connection(asyncio.get_running_loop(), Peer, url, baudrate=BAUD)
    car: Car = protocol
    return car


DRIVERS: dict[str, Callable[[str], Awaitable[Car]]] = {"turtlewire": driven, "bare": bare, "peer": peer}


# ---------------------------------------------------------------- turns


class Turns:
    """Tells each link when it is its turn: one timer for all of them, so that this costs little."""

    def __init__(self, links: int) -> None:
        self._loop = asyncio.get_running_loop()
        self._links = links
        self._step_s = 1.0 / PER_SECOND / links
        self._waiting: list[asyncio.Future[None] | None] = [None] * links
        self._begin_s = time.monotonic() + 0.1
        self._next = 0
        self._loop.call_soon(self._wake)

    async def turn(self, link: int, number: int) -> float:
        """Wait for a turn of a link; when it was to come."""
        due_s = self._begin_s + (number * self._links + link) * self._step_s
        while time.monotonic() < due_s:
            waiter = self._waiting[link] = self._loop.create_future()
            await waiter
        return due_s

    def _wake(self) -> None:
        due = int((time.monotonic() - self._begin_s) / self._step_s)
        while self._next <= due:
            link = self._next % self._links
            waiter, self._waiting[link] = self._waiting[link], None
            if waiter is not None and not waiter.done():
                waiter.set_result(None)
            self._next += 1
        self._loop.call_later(0.001, self._wake)


class Result(NamedTuple):
    """What became of it: times in seconds, memory in bytes."""

    per_second: float
    median_s: float
    p99_s: float
    longest_s: float
    cpu_s: float  # of a command
    memory: float  # of a link
    growth: float  # by a command


def resident() -> int:
    """How much memory this process uses."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


async def drive_all(connect: Callable[[str], Awaitable[Car]], urls: Sequence[str], seconds: float) -> Result:
    """Drive them all for a while."""
    gc.collect()
    before = resident()
    links = await asyncio.gather(*(connect(url) for url in urls))
    gc.collect()
    memory = (resident() - before) / len(urls)
    rounds = int(seconds * PER_SECOND)
    times = array("d", bytes(8 * rounds * len(links)))
    grown = [0, 0]
    turns = Turns(len(links))

    async def drive(number: int, car: Car) -> None:
        for turn in range(rounds):
            due_s = await turns.turn(number, turn)
            await car.motor(100 + turn % 100)
            times[turn * len(links) + number] = time.monotonic() - due_s
            if number == 0 and turn in (rounds // 2, rounds - 1):
                grown[turn == rounds - 1] = resident()

    # What a library lets go wrong in a callback, nobody else would hear of.
    failed: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    def fail(_: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        if not failed.done():
            failed.set_exception(context.get("exception") or RuntimeError(context["message"]))

    asyncio.get_running_loop().set_exception_handler(fail)
    cpu_s, wall_s = time.process_time(), time.monotonic()
    driving = asyncio.gather(*(drive(number, car) for number, car in enumerate(links)))
    await asyncio.wait((failed, driving), return_when=asyncio.FIRST_COMPLETED)
    if failed.done():
        await failed
    await driving
    cpu_s, wall_s = time.process_time() - cpu_s, time.monotonic() - wall_s
    await asyncio.gather(*(car.close(finish=False) for car in links))
    ordered = sorted(times)
    return Result(
        len(times) / wall_s,
        ordered[len(times) // 2],
        ordered[int(len(times) * 0.99)],
        ordered[-1],
        cpu_s / len(times),
        memory,
        (grown[1] - grown[0]) / (len(times) / 2),
    )


def measure(driver: str, loop: str, urls: Sequence[str], seconds: float, tell: Connection) -> None:
    """In a process of its own: drive cars, and tell what became of it, or why nothing did."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    new_loop = (
        importlib.import_module("uvloop").new_event_loop if loop == "uvloop" else asyncio.new_event_loop
    )
    try:
        tell.send(new_loop().run_until_complete(drive_all(DRIVERS[driver], urls, seconds)))
    except Exception as error:  # noqa: BLE001 - this is what is to be seen
        tell.send(f"{type(error).__name__}: {error}")
    os._exit(0)  # whatever else is under way


def result(driver: str, loop: str, links: int, seconds: float) -> Result | str:
    """Measure one of them."""
    with cars(links) as urls:
        told, tell = multiprocessing.Pipe(duplex=False)
        process = multiprocessing.get_context("spawn").Process(
            target=measure, args=(driver, loop, urls, seconds, tell), daemon=True
        )
        process.start()
        try:
            found: Result | str = told.recv() if told.poll(60.0 + 4.0 * seconds) else "it hangs"
            return found
        finally:
            process.terminate()
            process.join()


def main() -> None:
    """Print the table."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    ptys = int(Path("/proc/sys/kernel/pty/max").read_text())
    print(f"cars told something {PER_SECOND} times a second, at a pty each (this system has {ptys})")
    print(
        f"{'':30} {'links':>5} {'per s':>7} {'median':>8} {'p99':>8} {'longest':>8} {'CPU each':>9} {'memory':>16}"
    )
    contests = [
        ("turtlewire, asyncio", "turtlewire", "asyncio", LINKS, SECONDS),
        ("turtlewire, uvloop", "turtlewire", "uvloop", LINKS, SECONDS),
        ("bare bytes, asyncio", "bare", "asyncio", LINKS, PEER_SECONDS),
        ("bare bytes, uvloop", "bare", "uvloop", LINKS, PEER_SECONDS),
        *(("pyserial-asyncio-fast", "peer", "asyncio", links, PEER_SECONDS) for links in PEER_LINKS),
    ]
    for name, driver, loop, links, seconds in contests:
        found = result(driver, loop, links, seconds)
        if isinstance(found, str):
            print(f"{name:30} {links:5} {found}")
            continue
        print(
            f"{name:30} {links:5} {found.per_second:7,.0f} {found.median_s * 1e3:5.1f} ms {found.p99_s * 1e3:5.1f} ms "
            f"{found.longest_s * 1e3:5.0f} ms {found.cpu_s * 1e6:6.0f} us "
            f"{found.memory / 1024:6.1f} KiB a link {found.growth:+6.1f} B a command"
        )
    print(f"the aim is a p99 below {AIM_S * 1e3:g} ms at {LINKS:,} links")


if __name__ == "__main__":
    main()
