"""What somebody at the keyboard wants: a wish, which holds for a time, and orders, which are carried out once.

No clock and no terminal: keys come with the time, in seconds.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from turtlewire.dashboard.holding import Axis, Grip, Holding
from turtlewire.dashboard.layouts import HORN, Layout
from turtlewire.helm.wishes import Action, Order, Wish

FULL_SPEED = 255
STEPS = 9
# Holding their keys does it once, holding those of speeds again and again.
ONCE = (Action.LAMP, Action.PEN, Action.RESUME)
SPEEDS = (
    Action.FASTER,
    Action.SLOWER,
    Action.MOVE_FASTER,
    Action.MOVE_SLOWER,
    Action.TURN_FASTER,
    Action.TURN_SLOWER,
)


class Entry(NamedTuple):
    """A speed that is being typed: which, and its digits so far."""

    action: Action
    digits: str = ""


class Controls:
    """Follows keys, and knows the speeds.

    Args:
        layout: the keys of this robot.
        speed: 1..255, to begin with.
        has_full_lock: a turn is always a full one: front wheels that are steered.
        first_s, hold_s, latched: see ``Holding``.

    Attributes:
        speed, turn_speed: 1..255; where the robot has only one of them, both are the same.
        entry: a speed that is being typed, if one is.
    """

    def __init__(
        self,
        layout: Layout,
        *,
        speed: int,
        has_full_lock: bool,
        first_s: float,
        hold_s: float,
        latched: bool = False,
    ) -> None:
        self.layout = layout
        self.speed = self.turn_speed = speed
        self.entry: Entry | None = None
        self._has_full_lock = has_full_lock
        self._first_s = first_s
        # When keys of what is done once were heard last.
        self._heard: dict[str, float] = {}
        self._moves = Holding(first_s=first_s, hold_s=hold_s, combines=layout.combines, latched=latched)
        self._horn = Holding(first_s=first_s, hold_s=hold_s, combines=False)

    @property
    def sees_releases(self) -> bool:
        """Whether the terminal tells when a key is released."""
        return self._moves.sees_releases

    @sees_releases.setter
    def sees_releases(self, sees: bool) -> None:
        self._moves.sees_releases = self._horn.sees_releases = sees

    # ------------------------------------------------------------------ keys

    def press(self, key: str, now: float) -> Order | None:
        """A key was pressed, or repeats; what is to be done once, if anything."""
        if self.entry is not None:
            return self._type(self.entry, key, now)
        if key in self.layout.moves:
            self._moves.press(key, *self.layout.moves[key], now)
            return None
        if key == HORN:
            self._horn.press(key, Axis.SPEED, 1, now)
            return None
        if len(key) == 1 and key in "123456789":
            self._set_speeds(round(int(key) * FULL_SPEED / STEPS))
            return None
        action = self.layout.actions.get(key)
        if action is None or (action in ONCE and self._is_repetition(key, now)):
            return None
        return self._act(action, now)

    def _is_repetition(self, key: str, now: float) -> bool:
        before = self._heard.get(key, -math.inf)
        self._heard[key] = now
        return not self.sees_releases and now - before < self._first_s

    def repeat(self, key: str, now: float) -> Order | None:
        """A key that is held repeats, in a terminal that tells that from a new press."""
        self._moves.repeat(key, now)
        self._horn.repeat(key, now)
        action = self.layout.actions.get(key)
        return self._act(action, now) if action in SPEEDS and self.entry is None else None

    def release(self, key: str, now: float) -> None:
        """A key was released."""
        self._moves.release(key, now)
        self._horn.release(key, now)

    def answered(self, now: float) -> None:
        """A terminal that tells releases has answered: see ``Holding``."""
        self._moves.answered(now)
        self._horn.answered(now)

    def let_go(self, now: float) -> None:
        """Whatever is held does not count any more."""
        self.entry = None
        self._moves.let_go(now)
        self._horn.let_go(now)

    def wish(self, now: float) -> Wish:
        """What is wished now."""
        moves, horn = self._moves.grip(now), self._horn.grip(now)
        speed, turn = self.speed / FULL_SPEED, self.turn_speed / FULL_SPEED
        if self._has_full_lock:
            turn = 1.0
        elif moves.speed:
            turn /= 2.0  # an arc, rather than a turn around one wheel
        return Wish(
            moves.speed * speed,
            moves.turn * turn,
            bool(horn.speed),
            _first_end(moves, horn),
            moves.number,
        )

    # ------------------------------------------------------------------ what they do once

    def _act(self, action: Action, now: float) -> Order | None:
        match action:
            case Action.STOP | Action.QUIT:
                self.let_go(now)
            case Action.FASTER:
                self._set_speeds(self._step(self.speed, 1))
                return None
            case Action.SLOWER:
                self._set_speeds(self._step(self.speed, -1))
                return None
            case Action.MOVE_FASTER | Action.MOVE_SLOWER:
                before = self.speed
                self.speed = _saturated(before + (1 if action is Action.MOVE_FASTER else -1))
                return Order(action, self.speed) if self.speed != before else None
            case Action.TURN_FASTER | Action.TURN_SLOWER:
                before = self.turn_speed
                self.turn_speed = _saturated(before + (1 if action is Action.TURN_FASTER else -1))
                return Order(action, self.turn_speed) if self.turn_speed != before else None
            case Action.ASK_MOVE_SPEED | Action.ASK_TURN_SPEED:
                self.let_go(now)
                self.entry = Entry(action)
                return Order(Action.STOP)
        return Order(action)

    def _type(self, entry: Entry, key: str, now: float) -> Order | None:
        """A key while a speed is typed."""
        if len(key) == 1 and key in "0123456789":
            if int(entry.digits + key) <= FULL_SPEED:
                self.entry = entry._replace(digits=entry.digits + key)
            return None
        if key == "backspace":
            self.entry = entry._replace(digits=entry.digits[:-1])
            return None
        self.entry = None
        if key != "enter":
            return self.press(key, now)
        if not int(entry.digits or "0"):
            return None
        if entry.action is Action.ASK_MOVE_SPEED:
            self.speed = int(entry.digits)
        else:
            self.turn_speed = int(entry.digits)
        return None

    def _set_speeds(self, speed: int) -> None:
        self.speed = self.turn_speed = _saturated(speed)

    @staticmethod
    def _step(speed: int, by: int) -> int:
        """The next of the nine steps."""
        steps = [round(n * FULL_SPEED / STEPS) for n in range(1, STEPS + 1)]
        if by > 0:
            return min((step for step in steps if step > speed), default=FULL_SPEED)
        return max((step for step in steps if step < speed), default=steps[0])


def _first_end(moves: Grip, horn: Grip) -> float:
    ends = [grip.until for grip in (moves, horn) if grip.until > -math.inf]
    return min(ends, default=-math.inf)


def _saturated(speed: int) -> int:
    return max(1, min(FULL_SPEED, speed))
