"""A simulated robot behind a real port: a pseudo-terminal or a TCP socket, at the pace of the clock on the wall."""

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

if TYPE_CHECKING:
    from collections.abc import Callable

# What a serial adapter holds. What is beyond stays with the host, which can still take it back.
ADAPTER_BYTES = 64
# A host that does not read: what is beyond this is dropped, as on a real line.
MAX_UNREAD_BYTES = 1 << 16
LISTEN_FORMS = "pty, or socket://host:port (port 0: any that is free)"


class ServedRobot(Protocol):
    """What a robot must be like to be served; ``SimulatedWalter`` is."""

    now: float

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
    """Serve one robot to one host at a time, until ``stopped`` is set or the task is cancelled.

    Args:
        robot: its time goes on whether or not a host is there. A host that leaves stops nothing, as with a real robot.
        listen: ``pty``, or ``socket://host:port``, where port 0 is any free one.
        speed: seconds of the robot's time for each second on the wall.
        ready: called once with the URL for the host: the path of the pty, or ``socket://127.0.0.1:40123``.
        stopped: ends serving.

    Raises ``UsageError`` for a port or speed that means nothing, ``PortBusyError`` or ``LinkError`` if the port cannot
    be had.
    """
    if not 0.0 < speed < math.inf:
        raise UsageError(f"the speed of a simulator is {speed!r}, but must be a number above 0")
    pump = _Pump(robot, speed)
    if listen in ("pty", "pty:"):
        pty_port = _PtyPort(pump)
        port: _Port = pty_port
        url = pty_port.path
    else:
        socket_port = _SocketPort(pump)
        port = socket_port
        url = await socket_port.open(*_address(listen))
    try:
        ready(url)
        await pump.run(port, stopped or asyncio.Event())
    finally:
        port.close()
        await asyncio.sleep(0)  # asyncio closes sockets in its next round


class _Pump:
    """Lets the robot's time follow the wall's, and carries the bytes."""

    def __init__(self, robot: ServedRobot, speed: float) -> None:
        self._robot = robot
        self._speed = speed
        self._inbox = bytearray()
        self._wake = asyncio.Event()

    def received(self, data: bytes) -> None:
        """The host sent bytes."""
        self._inbox += data
        self._wake.set()

    async def run(self, port: _Port, stopped: asyncio.Event) -> None:
        """Go on until stopped; sleep whenever nothing happens."""
        loop = asyncio.get_running_loop()
        wall_s, robot_s = loop.time(), self._robot.now
        waiting = asyncio.ensure_future(stopped.wait())
        waiting.add_done_callback(lambda _: self._wake.set())
        try:
            while not stopped.is_set():
                self._wake.clear()
                self._advance(port, robot_s + (loop.time() - wall_s) * self._speed)
                at = self._robot.next_event()
                alarm = None
                if at < math.inf:
                    alarm = loop.call_at(wall_s + (at - robot_s) / self._speed, self._wake.set)
                await self._wake.wait()
                if alarm is not None:
                    alarm.cancel()
        finally:
            waiting.cancel()

    def _advance(self, port: _Port, now: float) -> None:
        robot = self._robot
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


class _PtyPort:
    """The near end of a new pseudo-terminal; ``path`` is the end for the host."""

    def __init__(self, pump: _Pump) -> None:
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
        self._pump = pump
        self._listening = False

    def send(self, data: bytes) -> None:
        try:
            os.write(self._fd, data)
        except BlockingIOError:
            return  # nobody reads

    def listen(self, *, on: bool) -> None:
        if on and not self._listening:
            asyncio.get_running_loop().add_reader(self._fd, self._receive)
        elif self._listening and not on:
            asyncio.get_running_loop().remove_reader(self._fd)
        self._listening = on

    def _receive(self) -> None:
        self._pump.received(os.read(self._fd, ADAPTER_BYTES))

    def close(self) -> None:
        self.listen(on=False)
        os.close(self._fd)
        os.close(self._host_fd)


class _SocketPort:
    """A TCP server for one host at a time."""

    def __init__(self, pump: _Pump) -> None:
        self.pump = pump
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
        self._port.pump.received(data)

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
