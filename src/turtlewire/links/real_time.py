"""A link in virtual time, at the pace of the clock on the wall: its robot lives on while nobody asks."""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from typing import TYPE_CHECKING, TypeVar

from turtlewire.errors import LinkClosedError
from turtlewire.links.link import Link

if TYPE_CHECKING:
    from collections.abc import Coroutine

T = TypeVar("T")
# How often to look whether the robot has said something.
LOOK_S = 0.01


class RealTimeLink(Link):
    """Makes a link in the background of one that is in virtual time: what drives a real robot drives this one, too.

    Args:
        link: in virtual time, as fast as can be.
        pace: seconds of the robot's time for each second on the wall.
    """

    in_background = True

    def __init__(self, link: Link, pace: float = 1.0) -> None:
        self.url = link.url
        self._link = link
        self._pace = pace
        self._start_s = link.now()
        self._start_wall_s = time.monotonic()
        self._received = bytearray()
        self._ended: LinkClosedError | None = None
        self._woken = asyncio.Event()

    def now(self) -> float:
        """Seconds of the robot's time."""
        now = self._start_s + (time.monotonic() - self._start_wall_s) * self._pace
        while self._ended is None and self._link.now() < now:
            try:
                self._received += _run(self._link.read(now))
            except LinkClosedError as error:
                self._ended = error
        return now

    def write(self, data: bytes) -> None:
        """Put bytes on the line now."""
        self.now()
        self._link.write(data)

    def write_urgent(self, data: bytes) -> None:
        """Take back what has not gone out, and put these bytes on the line."""
        self.now()
        self._link.write_urgent(data)

    async def read(self, until: float) -> bytes:
        """Wait for bytes."""
        self._woken.clear()
        while self.now() < until and not (self._received or self._ended or self._woken.is_set()):
            await self._wait(until)
        if self._ended is not None and not self._received:
            raise self._ended
        data = bytes(self._received)
        self._received.clear()
        return data

    async def _wait(self, until: float) -> None:
        wait_s = LOOK_S if until == math.inf else min(LOOK_S, (until - self.now()) / self._pace)
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(max(0.0, wait_s)):
                await self._woken.wait()

    def wake(self) -> None:
        """End a read that waits."""
        self._woken.set()

    async def close(self) -> None:
        """Let go of the robot."""
        self.now()
        _run(self._link.close())
        self._ended = self._ended or LinkClosedError(f"the link to {self.url} is closed")

    async def reopen(self) -> None:
        """Take hold of the same robot again. Raises ``LinkError``."""
        _run(self._link.reopen())
        self._ended = None
        self._received.clear()

    async def sleep(self, until: float) -> None:
        """Let time pass, the robot's too; what it says meanwhile nobody hears."""
        await asyncio.sleep(max(0.0, (until - self.now()) / self._pace))
        now = self.now()
        if self._ended is not None:
            _run(self._link.sleep(now))  # it goes on with what it was told last


def _run(coroutine: Coroutine[object, None, T]) -> T:
    """In virtual time nothing ever waits: run it through."""
    try:
        coroutine.send(None)
    except StopIteration as end:
        result: T = end.value
        return result
    coroutine.close()
    raise RuntimeError("a link in virtual time must never wait")
