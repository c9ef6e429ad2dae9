"""Which set-points count: those that come in order and are fresh. The others are dropped, and never replayed.

The server knows by its own clock alone how old a set-point can be at most: a page says with each of them what the
newest stamp was that it had from the server, and how long ago it received that. What is left is the time both ways.
"""

from __future__ import annotations

import math
from typing import NamedTuple

# A set-point that may be older does not count; one that counts, counts for so long.
FRESH_S = LIFE_S = 0.3
# A page's clock and the server's may differ so much between a stamp and its use.
CLOCKS_DIFFER_S = 0.05


class SetPoint(NamedTuple):
    """What a page wants of a robot now.

    Attributes:
        number: strictly increasing, of a page's connection.
        grip: the press, or the touch, that it is of: never decreasing.
        speed, turn: -1..1; horn: whether it sounds.
        stamp: the server's newest that the page has received, seconds; age_s: how long ago it received it.
    """

    number: int
    grip: int
    speed: float
    turn: float
    horn: bool
    stamp: float
    age_s: float


class SetPoints:
    """Judges the set-points of one connection.

    Attributes:
        dropped: how many did not count.
    """

    def __init__(self) -> None:
        self.dropped = 0
        self._number = -math.inf
        self._grip = -math.inf

    def take(self, point: SetPoint, now: float) -> str:
        """Judge one; "" if it counts, otherwise why not: ``order``, ``clock`` or ``late``."""
        why = self._judge(point, now)
        if why != "order":
            self._number, self._grip = point.number, point.grip
        self.dropped += bool(why)
        return why

    def _judge(self, point: SetPoint, now: float) -> str:
        if point.number <= self._number or point.grip < self._grip:
            return "order"
        both_ways_s = now - point.stamp - point.age_s
        if point.stamp > now or point.age_s < 0.0 or both_ways_s < -CLOCKS_DIFFER_S:
            return "clock"  # it was not received before it was sent
        return "late" if both_ways_s > FRESH_S else ""


class Grips:
    """The grips on one robot, of all sessions, numbered. What a stop or an error has ended drives no more.

    Nor does a grip that was not heard of for longer than a set-point lives: the robot has stopped meanwhile, and
    whether anybody still means it, nobody knows.

    Attributes:
        number: of the newest grip, counted over all sessions; 0: there has been none.
    """

    def __init__(self) -> None:
        self.number = 0
        self._newest: dict[int, int] = {}
        self._ended: dict[int, int] = {}
        self._holder: tuple[int, int] | None = None
        self._held_until = -math.inf

    def is_new(self, session: int, grip: int) -> bool:
        """Whether it has not been heard of."""
        return grip > self._newest.get(session, -1)

    def hold(self, session: int, grip: int, now: float) -> bool:
        """This one is held now; False: it has ended before."""
        if (session, grip) == self._holder and now > self._held_until:
            self.end()
        if grip <= self._ended.get(session, -1):
            return False
        if (session, grip) != self._holder:
            self._holder = (session, grip)
            self.number += 1
        self._held_until = now + LIFE_S
        self._newest[session] = max(grip, self._newest.get(session, -1))
        return True

    def end(self) -> None:
        """Every grip is over."""
        self._holder = None
        self._ended |= self._newest

    def ended(self, session: int) -> int | None:
        """The newest grip of this session that has ended; None: none has."""
        return self._ended.get(session)

    def leave(self, session: int) -> None:
        """A session is over."""
        self._newest.pop(session, None)
        self._ended.pop(session, None)
