"""An emulated board as the far end of a wire: for the drivers, in its own time or behind a real port."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .board import Board, Sent

if TYPE_CHECKING:
    from pathlib import Path

# How long a board runs before somebody may look at it again: its own events nobody can foretell.
SLICE_S = 0.002


class Chip(Board):
    """A board with a host at its line. What the host has written goes out byte by byte, and can be taken back."""

    def __init__(self, program: Path, baud: int) -> None:
        super().__init__(program, baud)
        self._waiting = bytearray()
        self._next_s = 0.0
        self._sent: list[Sent] = []
        self.written = bytearray()

    @property
    def now(self) -> float:
        """Seconds since power-on."""
        return self.now_s

    @property
    def bytes_on_line(self) -> int:
        """How many of the host's bytes have not begun to go out."""
        return len(self._waiting)

    def write(self, data: bytes) -> None:
        """The host puts bytes on the line."""
        self._waiting += data
        self.written += data

    def discard_output(self) -> None:
        """The host takes back what has not begun to go out."""
        self._waiting.clear()

    def awaits_host(self) -> bool:
        """Nobody can tell of a program."""
        return False

    def port_opened(self) -> None:
        """This board has no line by which a host could reset it."""

    def next_event(self) -> float:
        """When it has to be looked at again."""
        return self.now + SLICE_S

    def read(self, until: float) -> bytes:
        """Let time pass until something that the chip has sent is there, or until a time."""
        until = until if until < math.inf else self.now + 1.0
        while True:
            if self._waiting and self.now >= self._next_s:
                self.receive(bytes([self._waiting.pop(0)]))
                self._next_s = max(self._next_s, self.now) + 10.0 / self.baud
            self._sent += self.sent()
            there = sum(sent.time_s <= self.now for sent in self._sent)
            if there or self.now >= until:
                data = bytes(sent.byte for sent in self._sent[:there])
                del self._sent[:there]
                return data
            due = [
                until,
                *([self._next_s] if self._waiting else []),
                *(sent.time_s for sent in self._sent[:1]),
            ]
            self.run_until_sent(min(due) - self.now)
