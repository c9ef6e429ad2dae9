"""How long a robot takes to answer: what a bug report wants to know of a line."""

from __future__ import annotations

from collections import deque

# For the median. The longest is that of all.
KEPT = 1001


class RoundTrips:
    """From when a message was handed over until its answer came, seconds."""

    __slots__ = ("_longest_s", "_recent")

    def __init__(self) -> None:
        self._recent: deque[float] = deque(maxlen=KEPT)
        self._longest_s = 0.0

    def add(self, seconds: float) -> None:
        """One more."""
        self._recent.append(seconds)
        if seconds > self._longest_s:
            self._longest_s = seconds

    @property
    def median_s(self) -> float | None:
        """Of the last thousand; None: there was none yet."""
        return sorted(self._recent)[len(self._recent) // 2] if self._recent else None

    @property
    def longest_s(self) -> float | None:
        """The longest there ever was; None: there was none yet."""
        return self._longest_s if self._recent else None
