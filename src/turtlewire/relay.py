"""Between a host and a robot: every byte is passed on as it comes, and told to whoever listens.

Passing on comes first, in one thread that does nothing else: who listens is told after the bytes have gone, and must
not take long. Nothing is ever sent that did not come from the other end.

What a host sends is taken only as fast as the robot's line takes it, so that what has not gone out stays with the
host, which can still throw it away (an emergency stop does). A robot cannot be kept waiting: what a host does not
read is dropped after ``MAX_UNREAD_BYTES``, as on a real line, and said.
"""

from __future__ import annotations

import contextlib
import errno
import os
import select
import socket
import sys
import time
from typing import TYPE_CHECKING

from turtlewire.capture import Chunk, Note, Record
from turtlewire.errors import LinkClosedError, LinkError, PortBusyError, UsageError
from turtlewire.links import stream
from turtlewire.links.port import Port

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Self

    from turtlewire.protocols.catalogue import Sender

READ_BYTES = 1 << 12
MAX_UNREAD_BYTES = 1 << 16
# So much of what a host sends may wait in this computer for the robot's line: as in a serial adapter.
AHEAD_BYTES = 64
# How often to look whether the line has taken it.
LINE_MS = 2
# How long the last bytes may take to leave.
DRAIN_S = 1.0
LISTEN_FORMS = "pty, or socket://host:port (port 0: any that is free)"


class End:
    """One of the two ends: an open descriptor, or for a listener the one that is connected, if any.

    Args:
        sender: who is at this end.
        url: the port, for messages to people.

    Attributes:
        descriptor: to read from and write to; -1: nobody is there.
        listener: takes connections; None: there is only the one.
        unsent: what this end has not taken yet.
        dropped: how many bytes it would not take.
    """

    def __init__(self, sender: Sender, url: str) -> None:
        self.sender: Sender = sender
        self.url = url
        self.descriptor = -1
        self.listener: socket.socket | None = None
        self.unsent = bytearray()
        self.dropped = 0
        self._closing = contextlib.ExitStack()
        self._connection: socket.socket | None = None

    def open(self, *, baud: int) -> None:
        """Open the port. Raises ``UsageError`` or ``LinkError``."""
        port = Port.parse(self.url)
        try:
            if port.kind == "serial":
                self._open_serial(port.path, port.baud or baud)
            elif port.kind == "socket":
                self._connect(socket.create_connection((port.host, port.number), stream.CONNECT_TIMEOUT_S))
            else:
                self._open_pty()
        except OSError as error:
            raise stream.explained(self.url, port, error) from error

    def listen(self) -> None:
        """Be a new port: a pty, or a socket that takes one host at a time. ``url`` is then where it is.

        Raises ``UsageError``, ``PortBusyError`` or ``LinkError``.
        """
        try:
            port = Port.parse(self.url)
        except UsageError:
            port = Port("")
        if port.kind not in ("pty", "socket"):
            raise UsageError(f"cannot listen at {self.url!r}: write {LISTEN_FORMS}")
        try:
            if port.kind == "pty":
                self._open_pty()
            else:
                self._open_listener(port.host, port.number)
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise PortBusyError(f"cannot listen at {self.url}: another program does already") from None
            raise LinkError(f"cannot listen at {self.url}: {error.strerror or error}") from None

    def _open_serial(self, path: str, baud: int) -> None:
        import termios

        import serialx

        try:
            serial = self._closing.enter_context(serialx.serial_for_url(path, baud, exclusive=True))
        except (serialx.SerialException, termios.error) as error:
            raise LinkError(f"cannot use {self.url} as a serial port: {error.args[-1]}") from error
        self.descriptor = serial.fileno()

    def _open_pty(self) -> None:
        import tty

        near, far = os.openpty()
        # The far end stays open here, so that whoever is there may come and go.
        self._closing.callback(os.close, near)
        self._closing.callback(os.close, far)
        tty.setraw(far)
        os.set_blocking(near, False)
        self.descriptor = near
        self.url = os.ttyname(far)

    def _open_listener(self, host: str, number: int) -> None:
        family, _, _, _, address = socket.getaddrinfo(host, number, type=socket.SOCK_STREAM)[0]
        self.listener = self._closing.enter_context(socket.create_server(address[:2], family=family))
        self.listener.settimeout(0)
        bound, number = self.listener.getsockname()[:2]
        self.url = f"socket://{f'[{bound}]' if ':' in bound else bound}:{number}"

    def _connect(self, connection: socket.socket) -> None:
        connection.settimeout(0)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        self._connection = connection
        self.descriptor = connection.fileno()

    def accept(self) -> bool:
        """Somebody connects: whether they get in. There is room for one."""
        assert self.listener is not None
        try:
            connection, _ = self.listener.accept()
        except OSError:
            return False  # gone again already
        if self.descriptor >= 0:
            connection.close()
            return False
        self._connect(connection)
        return True

    def leave(self) -> None:
        """Whoever was connected is gone."""
        if self._connection is not None:
            self._connection.close()
            self._connection = None
        self.descriptor = -1
        self.unsent.clear()

    def read(self) -> bytes | None:
        """What has come; None when nothing has, ``b""`` when nothing will any more."""
        try:
            return os.read(self.descriptor, AHEAD_BYTES if self.sender == "host" else READ_BYTES)
        except BlockingIOError:
            return None
        except OSError:
            return b""

    def write(self) -> bool:
        """Send what is to be sent, as far as it is taken at once; False: the end is gone."""
        try:
            while self.unsent:
                del self.unsent[: os.write(self.descriptor, self.unsent)]
        except BlockingIOError:
            pass
        except OSError:
            return False
        return True

    def ahead(self) -> int:
        """How many bytes wait in this computer for the line."""
        waiting = len(self.unsent)
        # A socket has no line; nor has every system this question.
        with contextlib.suppress(OSError, ImportError, AttributeError):
            import fcntl
            import termios

            if self._connection is None:
                answer = fcntl.ioctl(self.descriptor, termios.TIOCOUTQ, b"\0" * 4)
                waiting += int.from_bytes(answer, sys.byteorder)
        return waiting

    def close(self) -> None:
        """Let go of everything."""
        self.leave()
        self._closing.close()


class Relay:
    """Passes bytes between two ends.

    Args:
        host, robot: the two, open.
        tell: told of everything that passes, and of what happens, with times from the start.
    """

    def __init__(self, host: End, robot: End, tell: Callable[[Record], object]) -> None:
        self._host, self._robot = host, robot
        self._tell = tell
        self._started_ns = time.monotonic_ns()
        self._woken, self._wake = os.pipe()
        self._is_stopped = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._woken)
        os.close(self._wake)

    def now_ns(self) -> int:
        """The time since the start."""
        return time.monotonic_ns() - self._started_ns

    def stop(self) -> None:
        """End ``run``; may be called from a signal's handler, or another thread."""
        self._is_stopped = True
        os.write(self._wake, b".")

    def run(self) -> None:
        """Pass on until stopped. Raises ``LinkClosedError`` when an end is gone."""
        try:
            while not self._is_stopped:
                self._round()
        finally:
            self._drain()

    def _round(self) -> None:
        host, robot = self._host, self._robot
        poll = select.poll()
        poll.register(self._woken, select.POLLIN)
        if host.listener is not None:
            poll.register(host.listener, select.POLLIN)
        # The host's bytes wait where they are while the robot's line is busy.
        is_busy = host.descriptor >= 0 and robot.ahead() >= AHEAD_BYTES
        for end, reads in ((host, not is_busy), (robot, True)):
            if end.descriptor >= 0:
                events = (select.POLLIN if reads else 0) | (select.POLLOUT if end.unsent else 0)
                poll.register(end.descriptor, events)
        # Whoever would be told of room in the line's memory is told of room for one byte: look again soon.
        for descriptor, event in poll.poll(LINE_MS if is_busy else None):
            if descriptor == host.descriptor:
                self._ready(host, robot, event)
            elif descriptor == robot.descriptor:
                self._ready(robot, host, event)
            elif host.listener is not None and descriptor == host.listener.fileno() and host.accept():
                self._note("the host has come")

    def _ready(self, end: End, other: End, event: int) -> None:
        """Something can be done at an end, or it is gone."""
        if event & select.POLLOUT and not end.write():
            self._gone(end)
            return
        # A hang-up is told even when nothing is to be read: then what is left is read, and after it the end.
        if not event & (select.POLLIN | select.POLLHUP | select.POLLERR | select.POLLNVAL):
            return
        data = end.read()
        if data is None:
            return
        if not data:
            self._gone(end)
            return
        t_ns = self.now_ns()
        is_there = self._pass_on(data, other)
        self._tell(Chunk(t_ns, end.sender, data))
        if not is_there:
            self._gone(other)

    def _pass_on(self, data: bytes, to: End) -> bool:
        """Send bytes to an end; False: it is gone."""
        if to.descriptor < 0:
            return True  # a listener with nobody there
        if len(to.unsent) > MAX_UNREAD_BYTES:
            if not to.dropped:
                self._note(f"the {to.sender} does not read: what it is sent is dropped from here on")
            to.dropped += len(data)
            return True
        to.unsent += data
        is_there = to.write()
        if to.dropped and not to.unsent:
            self._note(f"the {to.sender} reads again; {to.dropped} bytes for it were dropped")
            to.dropped = 0
        return is_there

    def _gone(self, end: End) -> None:
        if end.listener is not None:
            end.leave()
            self._note(f"the {end.sender} has left")
            return
        self._note(f"the {end.sender}'s end is gone")
        end.unsent.clear()
        raise LinkClosedError(
            f"the {end.sender}'s end of the wire is gone: {end.url}. Is it still plugged in and switched on?"
        )

    def _note(self, text: str) -> None:
        self._tell(Note(self.now_ns(), text))

    def _drain(self) -> None:
        """What has been taken from one end still goes to the other, if that takes no longer than a second."""
        deadline = time.monotonic() + DRAIN_S
        while True:
            ends = [end for end in (self._host, self._robot) if end.unsent and end.descriptor >= 0]
            left_s = deadline - time.monotonic()
            if not ends or left_s <= 0:
                return
            poll = select.poll()
            for end in ends:
                poll.register(end.descriptor, select.POLLOUT)
            for descriptor, _ in poll.poll(left_s * 1000):
                for end in ends:
                    if end.descriptor == descriptor and not end.write():
                        end.unsent.clear()
