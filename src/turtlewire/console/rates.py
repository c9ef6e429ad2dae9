"""How much may come in how little time: a bucket that fills again."""

from __future__ import annotations


class Bucket:
    """Lets so many through in a second, and some more at once after a pause. No clock: time is an argument.

    Args:
        per_s: how many a second.
        at_once: how many after a pause.
    """

    def __init__(self, per_s: float, at_once: float) -> None:
        self._per_s = per_s
        self._at_once = at_once
        self._left = at_once
        self._then: float | None = None

    def take(self, now: float) -> bool:
        """One more; False: that is too many."""
        if self._then is not None:
            self._left = min(self._at_once, self._left + max(0.0, now - self._then) * self._per_s)
        self._then = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True
