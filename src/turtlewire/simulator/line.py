"""One direction of a serial line: bytes go in at once and come out one by one at the baud rate."""

from __future__ import annotations

import math
from collections import deque

BITS_PER_BYTE = 10  # 8N1: a start bit, eight of data, a stop bit


class Line:
    """Bytes under way; ``next_s`` is when the next one arrives (infinite: none is under way).

    A byte has arrived when its last bit has.
    """

    def __init__(self, baud: int | None) -> None:
        self._byte_s = BITS_PER_BYTE / baud if baud else 0.0
        self._under_way: deque[tuple[float, int]] = deque()
        # Times are counted from the start of a burst, not from byte to byte: no rounding adds up.
        self._burst_s = 0.0
        self._burst_bytes = 0
        self.next_s = math.inf

    def __len__(self) -> int:
        """How many bytes have not arrived."""
        return len(self._under_way)

    def write(self, data: bytes, now: float) -> None:
        """Put bytes on the line, behind those that are still going out."""
        if now >= self._burst_s + self._burst_bytes * self._byte_s:
            self._burst_s, self._burst_bytes = now, 0
        for byte in data:
            self._burst_bytes += 1
            self._under_way.append((self._burst_s + self._burst_bytes * self._byte_s, byte))
        self._update()

    def read_byte(self) -> int:
        """The next byte, whenever it arrives."""
        byte = self._under_way.popleft()[1]
        self._update()
        return byte

    def read(self, now: float) -> bytes:
        """All bytes that have arrived."""
        data = bytearray()
        while self.next_s <= now:
            data.append(self.read_byte())
        return bytes(data)

    def discard(self, now: float) -> None:
        """Drop the bytes that have not begun to go out."""
        while self._under_way and self._burst_s + (self._burst_bytes - 1) * self._byte_s > now:
            self._under_way.pop()
            self._burst_bytes -= 1
        self._update()

    def _update(self) -> None:
        self.next_s = self._under_way[0][0] if self._under_way else math.inf
