"""Faults of a simulated robot's link, turned up and down while it drives, so that a class can watch recovery."""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from typing import TYPE_CHECKING, Any

from turtlewire.links.faults import RATES, Faults, FaultyLink

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.configuration import Target
    from turtlewire.links.link import Link

# The longest that anything may be late, held back, or unplugged, seconds; and the largest pieces, bytes.
MAX_DELAY_S, MAX_STALL_S, MAX_UNPLUG_S = 5.0, 30.0, 60.0
MAX_SPLIT = 64
NONE = Faults()


class Faulting:
    """What goes wrong on the way to one robot. For any thread, except ``over``.

    Args:
        target: the robot. A real one has no faults but its own.
        pace: of a simulated one: seconds of its time for each second on the wall.
        clock: seconds on the wall, that do not go back.

    Attributes:
        is_possible: whether there can be any: with a simulated robot.
    """

    def __init__(
        self, target: Target, pace: float = 1.0, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.is_possible = target.is_simulated
        self._faults = target.faults or NONE
        self._pace = pace
        self._clock = clock
        self._link: FaultyLink | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._stalled_until = self._unplugged_until = -math.inf

    def over(self, link: Link) -> Link:
        """The link with the faults; for who opens it, in the robot's thread. A new link has those that the last had."""
        if not self.is_possible:
            return link
        self._link = FaultyLink(link, self._faults)
        self._loop = asyncio.get_running_loop()
        self._stalled_until = self._unplugged_until = -math.inf
        return self._link

    def set(self, faults: Faults) -> None:
        """From now on these go wrong; ``Faults()``: nothing does."""
        self._faults = faults
        self._have(lambda link: link.adjust(faults))

    def stall(self, seconds: float) -> bool:
        """Let nothing through for so long, of the robot's time; False: it is not connected."""
        if not self._have(lambda link: link.stall(seconds)):
            return False
        self._stalled_until = self._clock() + seconds / self._pace
        return True

    def unplug(self, seconds: float) -> bool:
        """Pull the plug, and put it back after so long, of the robot's time; False: it is not connected."""
        if not self._have(lambda link: link.unplug(seconds)):
            return False
        self._unplugged_until = self._clock() + seconds / self._pace
        return True

    def _have(self, act: Callable[[FaultyLink], None]) -> bool:
        """Have something done by the thread that uses the link."""
        link, loop = self._link, self._loop
        if link is None or loop is None:
            return False
        with contextlib.suppress(RuntimeError):  # that thread has ended
            loop.call_soon_threadsafe(act, link)
            return True
        return False

    @property
    def is_on(self) -> bool:
        """Whether anything goes wrong."""
        return self._faults != NONE or self._left_s(max(self._stalled_until, self._unplugged_until)) > 0

    def state(self) -> dict[str, Any] | None:
        """What goes wrong, for people; None: nothing can. Seconds are whole ones: they would change all the time."""
        if not self.is_possible:
            return None
        faults, link = self._faults, self._link
        return {
            "on": self.is_on,
            **{rate: getattr(faults, rate) for rate in RATES},
            "delay_s": faults.delay_s,
            "split": faults.split,
            "to": faults.to,
            "stalled_s": self._left_s(self._stalled_until),
            "unplugged_s": self._left_s(self._unplugged_until),
            "lost": link.lost if link else 0,
            "added": link.added if link else 0,
            "flipped": link.flipped if link else 0,
            "duplicated": link.duplicated if link else 0,
        }

    def _left_s(self, until: float) -> int:
        return max(0, math.ceil(until - self._clock())) if until > -math.inf else 0
