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
from turtlewire.links.link import Link
from turtlewire.links.port import Port

if TYPE_CHECKING:
    from collections.abc import Callable

CONNECT_TIMEOUT_S = 5.0
CLOSE_TIMEOUT_S = 1.0
# A robot that floods a host that does not read: what is beyond is dropped, counted nowhere, and was lost anyway.
MAX_UNREAD_BYTES = 1 << 20


class StreamLink(Link, asyncio.Protocol):
    """A link over an asyncio transport. Made by ``open_port``."""

    in_background = True

    def __init__(self, url: str) -> None:
        self.url = url
        self._transport: asyncio.Transport | None = None
        self._fileno: int | None = None
        self._received = bytearray()
        self._ended: str | None = None
        self._something = asyncio.Event()
        self._gone = asyncio.Event()

    # asyncio's side

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """asyncio: open."""
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport

    def data_received(self, data: bytes) -> None:
        """asyncio: bytes came."""
        if len(self._received) < MAX_UNREAD_BYTES:
            self._received += data
        self._something.set()

    def connection_lost(self, exc: Exception | None) -> None:
        """asyncio: the other side or the device is gone."""
        if self._ended is None:
            reason = f": {exc}" if exc else ""
            self._ended = (
                f"the link to {self.url} ended{reason}. Is the robot still plugged in and switched on?"
            )
        self._something.set()
        self._gone.set()

    # the robot's side

    def now(self) -> float:
        """Seconds on the monotonic clock."""
        return time.monotonic()

    def write(self, data: bytes) -> None:
        """Hand bytes to the operating system."""
        if self._ended is not None or self._transport is None:
            raise LinkClosedError(self._ended or f"the link to {self.url} is not open")
        self._transport.write(data)

    def write_urgent(self, data: bytes) -> None:
        """Throw away what the operating system has not sent, where it lets us, and send these bytes."""
        # Once the link has ended, the number may be another file's.
        if self._fileno is not None and self._ended is None:
            with contextlib.suppress(ImportError):  # Windows
                import termios

                # termios.error is no OSError. The device is gone: write says that better.
                with contextlib.suppress(OSError, termios.error):
                    termios.tcflush(self._fileno, termios.TCOFLUSH)
        self.write(data)

    async def read(self, until: float) -> bytes:
        """Wait for bytes."""
        if not self._received and self._ended is None:
            self._something.clear()
            timeout = None if until == math.inf else max(0.0, until - time.monotonic())
            with contextlib.suppress(TimeoutError):
                # Not wait_for, which in Python 3.11 can swallow a cancellation.
                async with asyncio.timeout(timeout):
                    await self._something.wait()
        if not self._received and self._ended is not None:
            raise LinkClosedError(self._ended)
        data = bytes(self._received)
        self._received.clear()
        return data

    def wake(self) -> None:
        """End a read that waits."""
        self._something.set()

    async def close(self) -> None:
        """Let the last bytes go, then let go of the port."""
        if self._transport is None:
            return
        self._ended = self._ended or f"the link to {self.url} is closed"
        self._transport.close()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._gone.wait(), CLOSE_TIMEOUT_S)


async def open_port(text: str, *, baud: int, announce: Callable[[str], None] = lambda _: None) -> StreamLink:
    """Open a port for this program alone.

    ``baud`` is used where the URL names none. For ``pty`` a new pseudo-terminal is made and the path of its far end
    is announced: whatever opens that is the robot.

    Raises ``UsageError`` (no port), ``PortNotFoundError``, ``PortBusyError`` or ``LinkError``.
    """
    port = Port.parse(text)
    link = StreamLink(text)
    try:
        if port.kind == "serial":
            await _open_serial(link, port.path, port.baud or baud)
        elif port.kind == "socket":
            await _open_socket(link, port.host, port.number)
        else:
            await _open_pty(link, announce)
    except OSError as error:
        raise explained(text, port, error) from error
    return link


async def _open_serial(link: StreamLink, path: str, baud: int) -> None:
    import serialx

    refusals: tuple[type[Exception], ...] = (serialx.SerialException,)
    with contextlib.suppress(ImportError):  # Windows
        import termios

        refusals += (termios.error,)
    loop = asyncio.get_running_loop()
    try:
        transport, _ = await serialx.create_serial_connection(loop, lambda: link, path, baud, exclusive=True)
    except refusals as error:
        raise LinkError(f"cannot use {link.url} as a serial port: {error.args[-1]}") from error
    with contextlib.suppress(OSError, ValueError):
        link._fileno = transport.serial.fileno()


async def _open_socket(link: StreamLink, host: str, number: int) -> None:
    loop = asyncio.get_running_loop()
    await asyncio.wait_for(loop.create_connection(lambda: link, host, number), CONNECT_TIMEOUT_S)


async def _open_pty(link: StreamLink, announce: Callable[[str], None]) -> None:
    try:
        import pty
        import tty
    except ImportError:
        raise LinkError("this system has no pty; use socket://host:port") from None
    near, far = pty.openpty()
    tty.setraw(far)
    # The far end stays open here, so that the robot's program may come and go.
    link._transport = _PtyTransport(near, far, link)
    announce(os.ttyname(far))


class _PtyTransport(asyncio.Transport):
    """The near end of a pty, read and written when ready."""

    def __init__(self, near: int, far: int, link: StreamLink) -> None:
        super().__init__()
        self._near, self._far, self._link = near, far, link
        self._unsent = bytearray()
        self._loop = asyncio.get_running_loop()
        os.set_blocking(near, False)
        self._loop.add_reader(near, self._readable)

    def _readable(self) -> None:
        try:
            data = os.read(self._near, 65536)
        except BlockingIOError:
            return
        except OSError as error:
            self._end(error)
            return
        self._link.data_received(data)

    def write(self, data: bytes | bytearray | memoryview) -> None:
        self._unsent += data
        self._writable()

    def _writable(self) -> None:
        try:
            del self._unsent[: os.write(self._near, self._unsent)]
        except BlockingIOError:
            pass
        except OSError as error:
            self._end(error)
            return
        if self._unsent:
            self._loop.add_writer(self._near, self._writable)
        else:
            self._loop.remove_writer(self._near)

    def close(self) -> None:
        self._end(None)

    def _end(self, error: OSError | None) -> None:
        if self._near < 0:
            return
        self._loop.remove_reader(self._near)
        self._loop.remove_writer(self._near)
        os.close(self._near)
        os.close(self._far)
        self._near = -1
        self._link.connection_lost(error)


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
