"""Links over what the operating system offers: serial ports, TCP, and the near end of a new pty."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import math
import os
import time
from typing import TYPE_CHECKING

from turtlewire.errors import LinkClosedError, LinkError, PortBusyError, PortNotFoundError
from turtlewire.links.line_rate import baud_of
from turtlewire.links.link import Link
from turtlewire.links.port import Port
from turtlewire.links.pseudo_terminal import open_pty

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

CONNECT_TIMEOUT_S = 5.0
CLOSE_TIMEOUT_S = 1.0
# A robot that floods a host that does not read: what is beyond is dropped, counted nowhere, and was lost anyway.
MAX_UNREAD_BYTES = 1 << 20
# How much is read at once: memory for much more would be fetched from the operating system, and given back, each time.
READ_BYTES = 1 << 12
PTYS = "/dev/pts/"
ENDED = "the link to {url} ended{reason}. Is the robot still plugged in and switched on?"
# Further apart than this, two ends of a line no longer understand each other for sure.
BAUD_TOLERANCE = 0.03


class Connection(asyncio.Protocol):
    """A port while it is open, as asyncio sees it. Each opening has its own: nothing of an earlier one can mix in.

    Attributes:
        transport: what bytes are written to; None: not open yet.
        fileno: of a serial port.
        straight: where bytes can be written at once, ahead of the transport: nothing waits there; None: they cannot.
        receive: who takes bytes as they come; None: they are kept.
        received: bytes that nobody has taken yet.
        ended: how it came to its end, for people; None: it has not. was_cut: by no doing of ours.
        something: set when there is something to look at.
        gone: set when the port is free again.
    """

    def __init__(self, url: str) -> None:
        self.url = url
        self.transport: asyncio.Transport | None = None
        self.fileno: int | None = None
        self.straight: int | None = None
        self.receive: Callable[[bytes], None] | None = None
        self.received = bytearray()
        self.ended: str | None = None
        self.was_cut = False
        self.something = asyncio.Event()
        self.gone = asyncio.Event()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """asyncio: open."""
        assert isinstance(transport, asyncio.Transport)
        self.transport = transport

    def data_received(self, data: bytes) -> None:
        """asyncio: bytes came."""
        if self.receive is not None:
            self.receive(data)
            return
        if len(self.received) < MAX_UNREAD_BYTES:
            self.received += data
        self.something.set()

    def connection_lost(self, exc: Exception | None) -> None:
        """asyncio: the other side or the device is gone."""
        self.end(exc)
        self.something.set()
        self.gone.set()

    def end(self, exc: Exception | None) -> str:
        """It came to its end; why, for people."""
        self.straight = None
        if self.ended is None:
            self.was_cut = exc is not None
            self.ended = ENDED.format(url=self.url, reason=f": {exc}" if exc else "")
        return self.ended

    # serialx opens, sets and closes a serial port; its bytes go straight, which takes a fraction of the time

    def read_from(self, fileno: int) -> None:
        """Read the port itself from now on, whenever there is something."""
        self.fileno = self.straight = fileno
        asyncio.get_running_loop().add_reader(fileno, self._readable)

    def _readable(self) -> None:
        assert self.fileno is not None
        assert self.transport is not None
        try:
            data = os.read(self.fileno, READ_BYTES)
            if not data:
                if not _has_hung_up(self.fileno):
                    return  # what there was has been thrown away meanwhile
                raise OSError(errno.EIO, "the device has gone, or another program uses it")
        except BlockingIOError:
            return
        except OSError as error:
            self.end(error)
            self.something.set()
            self.transport.abort()
            return
        if self.receive is not None:
            self.receive(data)
        else:
            self.data_received(data)

    @property
    def is_open(self) -> bool:
        """Whether there is a port; without one, ``fileno`` may be another file's already."""
        return self.ended is None and self.transport is not None and not self.transport.is_closing()

    def write(self, data: bytes) -> None:
        """Write bytes behind those that wait, if any do. Raises ``LinkClosedError``."""
        if self.straight is not None:
            try:
                sent = os.write(self.straight, data)
            except OSError:
                sent = 0  # the transport tries again, and sees to it
            if sent == len(data):
                return
            data = data[sent:]
            self.straight = None
        if self.ended is not None or self.transport is None:
            raise LinkClosedError(self.ended or f"the link to {self.url} is not open")
        try:
            self.transport.write(data)
        except OSError as error:  # a device that is gone, while its number is being given back
            raise LinkClosedError(self.end(error)) from None
        if self.fileno is not None and self.is_open and not self.transport.get_write_buffer_size():
            self.straight = self.fileno


def _has_hung_up(fileno: int) -> bool:
    """Whether a serial port that gives no bytes is gone: one with nothing to give may do the same."""
    import select

    poll = select.poll()
    poll.register(fileno, select.POLLIN)
    return any(events & ~select.POLLIN for _, events in poll.poll(0))


class StreamLink(Link):
    """A link over an asyncio transport. Made by ``open_port``.

    Args:
        url: what it is called.
        opener: opens the port anew; raises ``OSError`` or ``LinkError``.
    """

    in_background = True

    def __init__(self, url: str, opener: Callable[[Connection], Awaitable[None]]) -> None:
        self.url = url
        self._opener = opener
        self._connection = Connection(url)
        self._receive: Callable[[bytes], None] | None = None

    now = staticmethod(time.monotonic)

    def write(self, data: bytes) -> None:
        """Hand bytes to the operating system."""
        self._connection.write(data)

    def write_urgent(self, data: bytes) -> None:
        """Throw away what the operating system has not sent, where it lets us, and send these bytes."""
        fileno = self._connection.fileno
        if fileno is not None and self._connection.is_open:
            with contextlib.suppress(ImportError):  # Windows
                import termios

                # termios.error is no OSError. The device is gone: write says that better.
                with contextlib.suppress(OSError, termios.error):
                    termios.tcflush(fileno, termios.TCOFLUSH)
        self.write(data)

    async def read(self, until: float) -> bytes:
        """Wait for bytes."""
        connection = self._connection
        if not connection.received and connection.ended is None:
            connection.something.clear()
            timeout = None if until == math.inf else max(0.0, until - time.monotonic())
            with contextlib.suppress(TimeoutError):
                # Not wait_for, which in Python 3.11 can swallow a cancellation.
                async with asyncio.timeout(timeout):
                    await connection.something.wait()
        if not connection.received and connection.ended is not None:
            raise LinkClosedError(connection.ended)
        data = bytes(connection.received)
        connection.received.clear()
        return data

    def listen(self, receive: Callable[[bytes], None]) -> bool:
        """Hand over bytes as they come; those that are there already first."""
        connection = self._connection
        self._receive = connection.receive = receive
        if connection.received:
            data = bytes(connection.received)
            connection.received.clear()
            receive(data)
        return True

    def wake(self) -> None:
        """End a read that waits."""
        self._connection.something.set()

    async def close(self) -> None:
        """Let the last bytes go, then let go of the port."""
        connection = self._connection
        if connection.transport is None:
            return
        connection.straight = None
        connection.ended = connection.ended or f"the link to {self.url} is closed"
        for let_go in (connection.transport.close, connection.transport.abort):
            let_go()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(CLOSE_TIMEOUT_S):
                    await connection.gone.wait()
                return

    async def reopen(self) -> None:
        """Open the port again; what came or was to go before is forgotten.

        Raises ``LinkClosedError`` for a pseudo-terminal whose program is gone: what has its name then is another's.
        """
        if self._connection.was_cut and Port.parse(self.url).path.startswith(PTYS):
            raise LinkClosedError(f"the program that made {self.url} has gone, and does not come back to it")
        connection = Connection(self.url)
        connection.receive = self._receive
        try:
            await self._opener(connection)
        except OSError as error:
            raise explained(self.url, Port.parse(self.url), error) from error
        self._connection = connection

    async def set_baud(self, baud: int) -> None:
        """Change the rate of a serial port that stays open: nothing is sent, and no robot is reset by it.

        What has come in and was not read is thrown away. Raises ``LinkError`` for a rate that the port does not have,
        ``LinkClosedError`` when the link has ended.
        """
        import serialx

        connection = self._connection
        transport = connection.transport
        if connection.ended is not None or not isinstance(transport, serialx.SerialTransport):
            raise LinkClosedError(connection.ended or f"{self.url} has no rate")
        refusal = f"{self.url} cannot be set to {baud} baud"
        try:
            await transport.reconfigure_port(baudrate=baud)
        except OSError as error:
            if error.errno in (errno.EIO, errno.ENODEV, errno.ENXIO, errno.EBADF):
                raise LinkClosedError(ENDED.format(url=self.url, reason=f": {error}")) from error
            raise LinkError(f"{refusal}: {error.strerror or error}") from error
        except (serialx.SerialException, ValueError) as error:
            raise LinkError(f"{refusal}: {error}") from error
        connection.received.clear()
        # Adapters take the nearest rate that they have, in silence.
        actual = None if connection.fileno is None else baud_of(connection.fileno)
        if actual is not None and abs(actual - baud) > baud * BAUD_TOLERANCE:
            raise LinkError(f"{refusal}: the nearest that it has is {actual}")


async def open_port(text: str, *, baud: int, announce: Callable[[str], None] = lambda _: None) -> StreamLink:
    """Open a port for this program alone.

    ``baud`` is used where the URL names none. For ``pty`` a new pseudo-terminal is made and the path of its far end
    is announced: whatever opens that is the robot, and is waited for.

    Raises ``UsageError`` (no port), ``PortNotFoundError``, ``PortBusyError`` or ``LinkError``.
    """
    port = Port.parse(text)

    async def opener(connection: Connection) -> None:
        if port.kind == "serial":
            await _open_serial(connection, port.path, port.baud or baud)
        elif port.kind == "socket":
            await _open_socket(connection, port.host, port.number)
        else:
            await open_pty(connection, announce)

    link = StreamLink(text, opener)
    await link.reopen()
    return link


async def _open_serial(connection: Connection, path: str, baud: int) -> None:
    import serialx

    refusals: tuple[type[Exception], ...] = (serialx.SerialException,)
    with contextlib.suppress(ImportError):  # Windows
        import termios

        refusals += (termios.error,)
    loop = asyncio.get_running_loop()
    try:
        transport, _ = await serialx.create_serial_connection(
            loop, lambda: connection, path, baud, exclusive=True
        )
    except refusals as error:
        raise LinkError(f"cannot use {connection.url} as a serial port: {error.args[-1]}") from error
    with contextlib.suppress(OSError, ValueError):
        connection.read_from(transport.serial.fileno())


async def _open_socket(connection: Connection, host: str, number: int) -> None:
    loop = asyncio.get_running_loop()
    async with asyncio.timeout(CONNECT_TIMEOUT_S):
        await loop.create_connection(lambda: connection, host, number)


def explained(text: str, port: Port, error: OSError) -> LinkError:
    """What an error of the operating system means for somebody with a robot."""
    if isinstance(error, TimeoutError):
        return PortNotFoundError(f"nobody answers at {text}: is the host right, and is it switched on?")
    if error.errno == errno.ECONNREFUSED:
        return PortNotFoundError(f"nobody listens at {text}: start the robot or the simulator there first")
    if port.kind == "socket":
        return PortNotFoundError(f"cannot reach {text}: {error.strerror or error}")
    if error.errno in (errno.EBUSY, errno.EAGAIN):
        return PortBusyError(
            f"{text} is in use by another program: a robot has one host at a time. Close that program and try again"
        )
    if error.errno in (errno.ENOENT, errno.ENXIO, errno.ENODEV):
        return PortNotFoundError(
            f"there is no port {text}: is the robot plugged in? `ls /dev/tty*` shows the ports"
        )
    if error.errno in (errno.ENOTTY, errno.EISDIR, errno.EINVAL):
        return LinkError(f"{text} is no serial port: `ls /dev/tty*` shows the ports")
    if error.errno in (errno.EACCES, errno.EPERM):
        return LinkError(
            f"no permission to open {text}: on Linux, add yourself to the group dialout and log in again"
        )
    return LinkError(f"cannot open {text}: {error.strerror or error}")
