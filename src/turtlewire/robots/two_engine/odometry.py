"""What the encoders of a robot say about how far its wheels have turned, between one tick and the next (F11)."""

from __future__ import annotations

from typing import NamedTuple

# Ticks are counted in 32 bits, and may wrap.
HALF_RANGE = 1 << 31


class Travel(NamedTuple):
    """How far each wheel has turned, mm; negative backwards."""

    left_mm: float = 0.0
    right_mm: float = 0.0


class Odometer:
    """Reckoned travel, put right by ticks.

    A tick more or less says nothing: reckoning is finer than that. Only what is beyond it is believed to the encoder,
    up to the edge of what it can mean. So an encoder never makes a good reckoning worse, and no error of reckoning
    grows beyond a tick.

    Args:
        mm_per_tick: how far a wheel goes for a tick.

    Attributes:
        mm_per_tick: how far a wheel goes for a tick.
        ticks: how many there have been, left and right, ahead less back, since the first report.
        heard_at: when the last report came; None: none has.
        corrections: how often the ticks contradicted the reckoning.
    """

    def __init__(self, mm_per_tick: float) -> None:
        self.heard_at: float | None = None
        self.corrections = 0
        self.mm_per_tick = mm_per_tick
        self.ticks = (0, 0)
        self._last = (0, 0)
        self._time_ms = 0
        self._total = Travel()

    def report(self, time_ms: int, left_ticks: int, right_ticks: int, now: float) -> bool:
        """The robot says how many ticks there have been since it was switched on, and how long ago that was.

        Returns whether that was before the last report; if not, it was reset meanwhile, and all begins anew.
        """
        new = (left_ticks, right_ticks)
        goes_on = self.heard_at is None or _wrapped(time_ms - self._time_ms) >= 0
        if not goes_on:
            self.forget()
        if self.heard_at is not None:
            left, right = (_wrapped(n - old) for n, old in zip(new, self._last, strict=True))
            self.ticks = (self.ticks[0] + left, self.ticks[1] + right)
        self._last, self._time_ms = new, time_ms
        self.heard_at = now
        return goes_on

    def forget(self) -> None:
        """Begin anew: the ticks of a robot that was reset go on from 0."""
        self.heard_at = None
        self.ticks = (0, 0)
        self._total = Travel()

    def travelled(self, left_mm: float, right_mm: float) -> Travel:
        """The wheels have turned so far by reckoning since this was last asked; how far by their ticks, too."""
        wanted = Travel(self._total.left_mm + left_mm, self._total.right_mm + right_mm)
        total = Travel(*(self._believed(mm, n) for mm, n in zip(wanted, self.ticks, strict=True)))
        self.corrections += total != wanted
        before, self._total = self._total, total
        return Travel(total.left_mm - before.left_mm, total.right_mm - before.right_mm)

    def _believed(self, mm: float, ticks: int) -> float:
        if self.heard_at is None:
            return mm
        # Nobody knows where between two ticks the wheel stood at the first report.
        return min(max(mm, (ticks - 1) * self.mm_per_tick), (ticks + 1) * self.mm_per_tick)


def _wrapped(ticks: int) -> int:
    return (ticks + HALF_RANGE) % (2 * HALF_RANGE) - HALF_RANGE
