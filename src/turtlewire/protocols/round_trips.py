"""How long a robot takes to answer: what a bug report wants to know of a line."""

from __future__ import annotations

from array import array

# For the median. The longest is that of all.
KEPT = 1001


class RoundTrips:
    """From when a message was handed over until its answer came, seconds."""

    __slots__ = ("_longest_s", "_recent")

    def __init__(self) -> None:
        self._recent = array("d")  # one of these for each of a thousand links
        self._longest_s = 0.0

    def add(self, seconds: float) -> None:
        """One more."""
        recent = self._recent
        recent.append(seconds)
        if len(recent) == 2 * KEPT:
            del recent[:KEPT]
        if seconds > self._longest_s:
            self._longest_s = seconds

    @property
    def median_s(self) -> float | None:
        """Of the last thousand; None: there was none yet."""
        recent = sorted(self._recent[-KEPT:])
        return recent[len(recent) // 2] if recent else None

    @property
    def longest_s(self) -> float | None:
        """The longest there ever was; None: there was none yet."""
        return self._longest_s if self._recent else None
