"""The near end of a new pseudo-terminal: the robot is whoever opens the far end."""

from __future__ import annotations

import asyncio
import os
from typing import TYPE_CHECKING

from turtlewire.errors import LinkError

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.links.stream import Connection

# So often it is looked whether somebody is there.
LOOK_S = 0.02
READ_BYTES = 1 << 12


async def open_pty(connection: Connection, announce: Callable[[str], None]) -> None:
    """Make a pseudo-terminal, announce the path of its far end, and wait until somebody opens that.

    Raises ``LinkError`` where there are none.
    """
    try:
        import pty
        import tty
    except ImportError:
        raise LinkError("this system has no pty; use socket://host:port") from None
    near, far = pty.openpty()
    try:
        tty.setraw(far)
        path = os.ttyname(far)
        os.close(far)
        far = -1
        announce(path)
        while not _is_anybody_at(near):  # noqa: ASYNC110 - of this the system tells nobody
            await asyncio.sleep(LOOK_S)
        # From now on it stays open here, too, so that the robot's program may come and go.
        far = os.open(path, os.O_RDWR | os.O_NOCTTY)
    except BaseException:
        for descriptor in (near, far):
            if descriptor >= 0:
                os.close(descriptor)
        raise
    connection.transport = PtyTransport(near, far, connection)


def _is_anybody_at(near: int) -> bool:
    """Whether the far end is open, or was, and bytes came of it."""
    import select

    poll = select.poll()
    poll.register(near, select.POLLIN)
    events = poll.poll(0)
    return not events or bool(events[0][1] & select.POLLIN)


class PtyTransport(asyncio.Transport):
    """The near end of a pty, read and written when ready."""

    def __init__(self, near: int, far: int, connection: Connection) -> None:
        super().__init__()
        self._near, self._far, self._connection = near, far, connection
        self._unsent = bytearray()
        self._loop = asyncio.get_running_loop()
        os.set_blocking(near, False)
        self._loop.add_reader(near, self._readable)

    def _readable(self) -> None:
        try:
            data = os.read(self._near, READ_BYTES)
        except BlockingIOError:
            return
        except OSError as error:
            self._end(error)
            return
        self._connection.data_received(data)

    def write(self, data: bytes | bytearray | memoryview) -> None:
        """asyncio: bytes are to go out."""
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
        """asyncio: let go."""
        self._end(None)

    def abort(self) -> None:
        """asyncio: let go at once."""
        self._end(None)

    def _end(self, error: OSError | None) -> None:
        if self._near < 0:
            return
        self._loop.remove_reader(self._near)
        self._loop.remove_writer(self._near)
        os.close(self._near)
        os.close(self._far)
        self._near = -1
        self._connection.connection_lost(error)
