"""Simulated robots behind real ports: pseudo-terminals or TCP sockets, at the pace of the clock on the wall."""

from __future__ import annotations

import asyncio
import errno
import math
import os
import re
import socket
from typing import TYPE_CHECKING, Protocol
from urllib.parse import urlsplit

from turtlewire.errors import LinkError, PortBusyError, UsageError
from turtlewire.links.line_rate import baud_of
from turtlewire.links.uart import image

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

# What a serial adapter holds. What is beyond stays with the host, which can still take it back.
ADAPTER_BYTES = 64
# A host that does not read: what is beyond this is dropped, as on a real line.
MAX_UNREAD_BYTES = 1 << 16
PTY = ("pty", "pty:")
MAX_PORT = 65535
LISTEN_FORMS = "pty, or socket://host:port (port 0: any that is free)"


class ServedRobot(Protocol):
    """What a robot must be like to be served; every simulated robot is."""

    @property
    def now(self) -> float:
        """Seconds of its time."""

    @property
    def bytes_on_line(self) -> int:
        """How many of the host's bytes have not arrived."""

    def write(self, data: bytes) -> None:
        """The host puts bytes on the line."""

    def read(self, until: float) -> bytes:
        """Let time pass until something has arrived for the host, or until a time."""

    def next_event(self) -> float:
        """When something happens next by itself."""


class _Port(Protocol):
    """Where the host comes in."""

    def send(self, data: bytes) -> None:
        """Give bytes to the host, if there is one and it reads; never wait for it."""

    def listen(self, *, on: bool) -> None:
        """Whether to take bytes from the host; while off, they stay where they are."""

    def close(self) -> None:
        """Let go of the port."""


async def serve(
    robot: ServedRobot,
    listen: str,
    *,
    speed: float = 1.0,
    ready: Callable[[str], None] = lambda _: None,
    stopped: asyncio.Event | None = None,
) -> None:
    """Serve one robot to one host at a time: ``serve_all`` for one, whose ``ready`` gets its only URL."""
    await serve_all([robot], listen, speed=speed, ready=lambda urls: ready(urls[0]), stopped=stopped)


async def serve_all(
    robots: Sequence[ServedRobot],
    listen: str | Sequence[str] = "pty",
    *,
    speed: float = 1.0,
    bauds: Sequence[int | None] = (),
    ready: Callable[[list[str]], None] = lambda _: None,
    stopped: asyncio.Event | None = None,
) -> None:
    """Serve robots, each to one host at a time, until ``stopped`` is set or the task is cancelled.

    Args:
        robots: any number, of any kinds; in one world (``company.share_world``) or each in its own. Their time goes on
            whether or not a host is there. A host that leaves stops nothing, as with a real robot.
        listen: where: ``pty``, or ``socket://host:port``, where port 0 is any free one. One for each robot, or one for
            all: then each of them gets a pty of its own, or ports that follow one another.
        speed: seconds of the robots' time for each second on the wall.
        bauds: for each robot, the rate of its UART: at a pty, a host whose port is set to another rate is heard as such
            a UART hears it, and hears the robot so (``links.uart``). None, or no such list: whatever rate a host has
            set is the right one.
        ready: called once with the URLs for the hosts, in the robots' order: the path of a pty, or
            ``socket://127.0.0.1:40123``.
        stopped: ends serving.

    Raises ``UsageError`` for a port or speed that means nothing, ``PortBusyError`` or ``LinkError`` if a port cannot
    be had; then none is served.
    """
    if not 0.0 < speed < math.inf:
        raise UsageError(f"the speed of a simulator is {speed!r}, but must be a number above 0")
    wheres = _ports_for(len(robots), listen)
    pump = _Pump(speed)
    try:
        rates = bauds or [None] * len(robots)
        urls = [await pump.open(*one) for one in zip(robots, wheres, rates, strict=True)]
        ready(urls)
        await pump.run(stopped or asyncio.Event())
    finally:
        pump.close()
        await asyncio.sleep(0)  # asyncio closes sockets in its next round


def _ports_for(count: int, listen: str | Sequence[str]) -> list[str]:
    if not count:
        raise UsageError("there is no robot to serve")
    if not isinstance(listen, str):
        if len(listen) != count:
            raise UsageError(f"there are {count} robots, but {len(listen)} ports to serve them at")
        return list(listen)
    if listen in PTY:
        return [listen] * count
    host, number = _address(listen)
    if number and number + count - 1 > MAX_PORT:
        raise UsageError(f"{listen}: from there on there are no {count} ports")
    shown = f"[{host}]" if ":" in host else host
    return [f"socket://{shown}:{number + i if number else 0}" for i in range(count)]


class _Wire:
    """One robot, its port, and what its host has sent and the robot's adapter has no room for."""

    def __init__(self, robot: ServedRobot, baud: int | None, wake: Callable[[], None]) -> None:
        self.robot = robot
        self.baud = baud
        self._wake = wake
        self._inbox = bytearray()
        self.port: _Port | None = None
        self._start_s = robot.now

    async def open(self, listen: str) -> str:
        """Make its port; return its URL."""
        if listen in PTY:
            pty_port = _PtyPort(self)
            self.port = pty_port
            return pty_port.path
        address = _address(listen)
        socket_port = _SocketPort(self)
        self.port = socket_port
        return await socket_port.open(*address)

    def received(self, data: bytes) -> None:
        """The host sent bytes."""
        self._inbox += data
        self._wake()

    def next_event(self) -> float:
        """When something happens next, in seconds since it is served."""
        return self.robot.next_event() - self._start_s

    def advance(self, elapsed_s: float) -> None:
        """Let the robot's time pass; give its host what has come, its adapter what it has room for."""
        robot, port = self.robot, self.port
        assert port is not None
        now = self._start_s + elapsed_s
        replies = bytearray()
        while True:
            replies += robot.read(now)
            if robot.now >= now:
                break
        if replies:
            port.send(bytes(replies))
        room = ADAPTER_BYTES - robot.bytes_on_line
        if self._inbox and room > 0:
            robot.write(bytes(self._inbox[:room]))
            del self._inbox[:room]
        # Not for each byte that has gone out: half the adapter's memory at a time.
        if self._inbox:
            port.listen(on=False)
        elif robot.bytes_on_line <= ADAPTER_BYTES // 2:
            port.listen(on=True)


class _Pump:
    """Lets the robots' time follow the wall's, and carries the bytes."""

    def __init__(self, speed: float) -> None:
        self._speed = speed
        self._wires: list[_Wire] = []
        self._wake = asyncio.Event()

    async def open(self, robot: ServedRobot, listen: str, baud: int | None) -> str:
        """Open the port of one robot more; return its URL."""
        wire = _Wire(robot, baud, self._wake.set)
        self._wires.append(wire)
        return await wire.open(listen)

    async def run(self, stopped: asyncio.Event) -> None:
        """Go on until stopped; sleep whenever nothing happens."""
        loop = asyncio.get_running_loop()
        wall_s = loop.time()
        waiting = asyncio.ensure_future(stopped.wait())
        waiting.add_done_callback(lambda _: self._wake.set())
        try:
            while not stopped.is_set():
                self._wake.clear()
                elapsed_s = (loop.time() - wall_s) * self._speed
                for wire in self._wires:
                    wire.advance(elapsed_s)
                at = min(wire.next_event() for wire in self._wires)
                alarm = None
                if at < math.inf:
                    alarm = loop.call_at(wall_s + at / self._speed, self._wake.set)
                await self._wake.wait()
                if alarm is not None:
                    alarm.cancel()
        finally:
            waiting.cancel()

    def close(self) -> None:
        """Let go of all ports."""
        for wire in self._wires:
            if wire.port is not None:
                wire.port.close()


class _PtyPort:
    """The near end of a new pseudo-terminal; ``path`` is the end for the host."""

    def __init__(self, wire: _Wire) -> None:
        try:
            import tty  # Windows has none
        except ImportError:
            raise UsageError(
                "there are no pseudo-terminals on this system: use socket://127.0.0.1:0"
            ) from None
        try:
            # The host's end stays open here too, so that a host may come and go.
            self._fd, self._host_fd = os.openpty()
        except OSError as error:
            raise LinkError(f"no pseudo-terminal can be had: {error.strerror}") from None
        tty.setraw(self._host_fd)
        os.set_blocking(self._fd, False)
        self.path = os.ttyname(self._host_fd)
        self._wire = wire
        self._listening = False

    def send(self, data: bytes) -> None:
        host, robot = self._rates()
        try:
            os.write(self._fd, image(data, host / robot) if host != robot else data)
        except BlockingIOError:
            return  # nobody reads

    def listen(self, *, on: bool) -> None:
        if on and not self._listening:
            asyncio.get_running_loop().add_reader(self._fd, self._receive)
        elif self._listening and not on:
            asyncio.get_running_loop().remove_reader(self._fd)
        self._listening = on

    def _receive(self) -> None:
        data = os.read(self._fd, ADAPTER_BYTES)
        host, robot = self._rates()
        self._wire.received(image(data, robot / host) if host != robot else data)

    def _rates(self) -> tuple[int, int]:
        """At which rates the host and the robot listen and speak; 1 and 1 where that does not matter."""
        robot = self._wire.baud
        host = baud_of(self._fd) if robot else None
        return (host, robot) if host and robot else (1, 1)

    def close(self) -> None:
        self.listen(on=False)
        os.close(self._fd)
        os.close(self._host_fd)


class _SocketPort:
    """A TCP server for one host at a time."""

    def __init__(self, wire: _Wire) -> None:
        self.wire = wire
        self.host: asyncio.Transport | None = None
        self._server: asyncio.Server | None = None
        self._listening = False

    async def open(self, host: str, number: int) -> str:
        """Listen at one address; return the URL."""
        loop = asyncio.get_running_loop()
        where = f"socket://{f'[{host}]' if ':' in host else host}:{number}"
        try:
            found = await loop.getaddrinfo(host, number, type=socket.SOCK_STREAM)
            # IPv4 first: more programs take its addresses in a URL.
            address = min(found, key=lambda info: info[0] != socket.AF_INET)
            self._server = await loop.create_server(
                lambda: _Host(self), str(address[4][0]), number, family=address[0]
            )
        except (socket.gaierror, UnicodeError):
            raise LinkError(f"cannot listen at {where}: there is no address {host!r}") from None
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise PortBusyError(f"cannot listen at {where}: another program does already") from None
            reason = os.strerror(error.errno) if error.errno else str(error)
            raise LinkError(f"cannot listen at {where}: {reason}") from None
        bound, number = self._server.sockets[0].getsockname()[:2]
        # A wildcard is no address to connect to.
        bound = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(bound, bound)
        return f"socket://{f'[{bound}]' if ':' in bound else bound}:{number}"

    def send(self, data: bytes) -> None:
        if self.host is not None and self.host.get_write_buffer_size() < MAX_UNREAD_BYTES:
            self.host.write(data)

    def listen(self, *, on: bool) -> None:
        self._listening = on
        if self.host is None or self.host.is_closing():
            return
        if on:
            self.host.resume_reading()
        else:
            self.host.pause_reading()

    def arrived(self, host: asyncio.Transport) -> bool:
        """A host wants the robot: only if no other has it."""
        if self.host is not None:
            return False
        self.host = host
        self.listen(on=self._listening)
        return True

    def close(self) -> None:
        if self._server is not None:
            self._server.close()
        if self.host is not None:
            self.host.abort()


class _Host(asyncio.Protocol):
    """One connection."""

    def __init__(self, port: _SocketPort) -> None:
        self._port = port
        self._transport: asyncio.Transport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        if not self._port.arrived(transport):
            transport.abort()
            return
        self._transport = transport
        # A host that vanished without a word must not keep the robot for ever.
        transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)

    def data_received(self, data: bytes) -> None:
        self._port.wire.received(data)

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002 - asyncio's signature
        if self._transport is not None:
            self._port.host = None


def _address(listen: str) -> tuple[str, int]:
    """Host and port of ``socket://host:port``."""
    try:
        url = urlsplit(listen)
        host, number = url.hostname, url.port
    except ValueError:
        host, number = None, None
    # urlsplit is lenient: blanks and a path would go unnoticed.
    if not re.fullmatch(r"socket://\S+:\d+/?", listen) or not host or number is None:
        raise UsageError(f"cannot serve a robot at {listen!r}: write {LISTEN_FORMS}")
    return host, number
