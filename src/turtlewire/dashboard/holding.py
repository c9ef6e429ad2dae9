"""Which keys are held, and for how long that counts: the dead-man's handle.

Most terminals tell that a key was pressed, and again while it is held, but not that it was released. So a key counts
for a time that covers the pause before it repeats, and then for a shorter one after each repetition. Only the newest
key repeats. Hence: a key that turns leaves the speed as it is, and lives for both; a key that drives begins anew.

Some terminals tell releases too (the kitty keyboard protocol). There, what is held is known exactly, as long as the
terminal answers at all: it is asked again and again, and each answer counts as a repetition of all keys held.
"""

from __future__ import annotations

import math
from enum import Enum
from typing import NamedTuple


class Axis(Enum):
    """What a key that is held acts on."""

    SPEED = "speed"
    TURN = "turn"


class Grip(NamedTuple):
    """What is held.

    Attributes:
        speed: -1 back, 1 ahead, 0 neither.
        turn: -1 left, 1 right, 0 neither.
        until: when that ends unless something is heard of the keys before, seconds; infinite while it is latched.
        number: of the key press that it is of; a repetition is none.
    """

    speed: int = 0
    turn: int = 0
    until: float = -math.inf
    number: int = 0


class Holding:
    """Follows keys.

    Args:
        first_s: for how long a key that was pressed counts, seconds: longer than the pause before it repeats.
        hold_s: for how long it counts after a repetition, or after an answer of a terminal that tells releases.
        combines: whether the robot drives and turns at the same time.
        latched: what was begun goes on until another key, or ``let_go``.

    Attributes:
        sees_releases: whether the terminal tells when a key is released.
    """

    def __init__(self, *, first_s: float, hold_s: float, combines: bool, latched: bool = False) -> None:
        self.sees_releases = False
        self._first_s = first_s
        self._hold_s = hold_s
        self._combines = combines
        self._latched = latched
        # The keys, in the order in which they were pressed, and what each does.
        self._held: dict[str, tuple[Axis, int]] = {}
        self._newest = ""
        self._until = -math.inf
        self._number = 0
        # Keys that were held when they were let go of, and when they were heard last: their repetitions begin nothing.
        self._refused: dict[str, float] = {}

    def press(self, key: str, axis: Axis, sign: int, now: float) -> None:
        """A key was pressed, or repeats."""
        if key in self._refused:
            if now - self._refused[key] < self._hold_s:
                self._refused[key] = now
                return
            del self._refused[key]
        if now >= self._until:
            self._held.clear()
        knows_all = self.sees_releases and not self._latched
        if key in self._held and (key == self._newest or knows_all):
            self.repeat(key, now)
            return
        if not knows_all:
            is_arc = axis is Axis.TURN and self._combines
            self._held = {k: v for k, v in self._held.items() if is_arc and v[0] is Axis.SPEED}
        self._held.pop(key, None)
        self._held[key] = (axis, sign)
        self._newest = key
        self._number += 1
        self._until = math.inf if self._latched else now + self._first_s

    def repeat(self, key: str, now: float) -> None:
        """A key that is held repeats; any other does nothing."""
        if key in self._refused:
            self._refused[key] = now
        elif key in self._held and now < self._until and not self._latched:
            self._until = now + self._hold_s

    def release(self, key: str, now: float) -> None:
        """A key was released."""
        self._refused.pop(key, None)
        if self._latched or key not in self._held:
            return
        del self._held[key]
        self._until = min(self._until, now + self._hold_s)

    def answered(self, now: float) -> None:
        """A terminal that tells releases has answered: what is held is held still."""
        if self.sees_releases and self._held and now < self._until and not self._latched:
            self._until = now + self._hold_s

    def let_go(self, now: float) -> None:
        """Nothing counts as held any more; a key that is, does not begin anything before it has been released."""
        if now < self._until:
            self._refused |= dict.fromkeys(self._held, now)
        self._held.clear()
        self._until = -math.inf

    def grip(self, now: float) -> Grip:
        """What is held now."""
        if now >= self._until or not self._held:
            return Grip(number=self._number)
        # Later keys count more.
        signs = dict(self._held.values())
        if not self._combines:
            signs = dict([list(self._held.values())[-1]])
        return Grip(
            signs.get(Axis.SPEED, 0),
            signs.get(Axis.TURN, 0),
            self._until,
            self._number,
        )
