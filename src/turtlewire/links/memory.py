"""A link to a robot in this very process, in virtual time: nothing ever waits."""

from __future__ import annotations

import math
import time
from typing import Protocol

from turtlewire.errors import LinkClosedError
from turtlewire.links.link import Link

LONGEST_SLEEP_S = 0.01


class VirtualEnd(Protocol):
    """The far end of the wire, with the clock that both ends live by. A simulated robot is one."""

    @property
    def now(self) -> float:
        """Seconds since its power-on."""

    def write(self, data: bytes) -> None:
        """The host puts bytes on the line now."""

    def discard_output(self) -> None:
        """The host takes back its bytes that have not begun to go out."""

    def read(self, until: float) -> bytes:
        """Let time pass until something has arrived for the host, or until a time."""

    def awaits_host(self) -> bool:
        """Whether nothing will happen by itself any more, but that what drives drives on: time could pass for ever."""

    def port_opened(self) -> None:
        """The host has opened the port once more: many a robot is reset by that (section 4)."""


class MemoryLink(Link):
    """A link to a ``VirtualEnd``.

    Args:
        end: the far end.
        url: what to call it.
        pace: seconds of the far end's time for each second on the wall, at most; None: as fast as can be.

    Attributes:
        end: the far end.
    """

    in_background = False

    def __init__(self, end: VirtualEnd, url: str = "memory:", pace: float | None = None) -> None:
        self.url = url
        self.end = self._end = end
        self._pace = pace
        self._start_s = end.now
        self._start_wall_s = time.monotonic()
        self._closed = False

    def now(self) -> float:
        """Seconds of the robot's time."""
        return self._end.now

    def write(self, data: bytes) -> None:
        """Put bytes on the line."""
        self._check()
        self._end.write(data)

    def write_urgent(self, data: bytes) -> None:
        """Take back what has not gone out, and put these bytes on the line."""
        self._check()
        self._end.discard_output()
        self._end.write(data)

    async def read(self, until: float) -> bytes:
        """Let the robot's time pass."""
        self._check()
        if until == math.inf and self._end.awaits_host():
            raise RuntimeError("the host waits for something that will never happen")
        return self._read(until)

    def _read(self, until: float) -> bytes:
        return self._end.read(until) if self._pace is None else self._read_at_pace(until, self._pace)

    def _read_at_pace(self, until: float, pace: float) -> bytes:
        """Let time pass no faster than on the wall: whoever interrupts this finds the robot where it has come to.

        It blocks, as everything does over a virtual link.
        """
        while True:
            allowed_s = self._start_s + (time.monotonic() - self._start_wall_s) * pace
            data = self._end.read(min(until, allowed_s))
            if data or self._end.now >= until or (until == math.inf and self._end.awaits_host()):
                return data
            time.sleep(min(LONGEST_SLEEP_S, (until - self._end.now) / pace))

    def wake(self) -> None:
        """Nothing waits here."""

    async def close(self) -> None:
        """Let go of the robot."""
        self._closed = True

    async def reopen(self) -> None:
        """Take hold of the same robot again; what it has said meanwhile nobody has heard."""
        self._end.read(self._end.now)
        self._end.port_opened()
        self._closed = False

    async def sleep(self, until: float) -> None:
        """Let the robot's time pass; what it says meanwhile nobody hears."""
        while self._end.now < until:
            self._read(until)

    def _check(self) -> None:
        if self._closed:
            raise LinkClosedError(f"the link to {self.url} is closed")
