"""Who drives one robot: one at a time, the others watch, ask, and are handed the wheel or take it after a while.

No clock: time is an argument, seconds on any clock. Whoever drives is named by the number of a session.

::

    free --take, press--> held --release, leave, a stop by anybody--> free
                          held --ask--> the driver gives it, keeps it, or does not answer in time: the asker has it
"""

from __future__ import annotations

from typing import NamedTuple

from turtlewire.console.refusals import Refused

# The driver has so long to answer, and may do nothing for so long, before the asker has the wheel.
ANSWER_S, IDLE_S = 10.0, 30.0
# So many may ask at a time: the next ones wait to ask.
MAX_ASKING = 8


class Asking(NamedTuple):
    """Somebody would like to drive; ``until`` is when the wheel is theirs without an answer."""

    session: int
    until: float


class Wheel:
    """The wheel of one robot.

    Attributes:
        driver: the session that drives; None: it is free.
        asking: who would like to, in the order in which they asked.
        barred: sessions that somebody else's stop took it from: no press takes it again, only ``take`` and ``ask``.
    """

    def __init__(self) -> None:
        self.driver: int | None = None
        self.asking: list[Asking] = []
        self.barred: set[int] = set()
        self._active_s = 0.0

    def take(self, session: int, now: float) -> None:
        """Take the wheel if it is free. Raises ``Refused`` when somebody else has it."""
        self.tick(now)
        if self.driver not in (None, session):
            raise Refused(409, "wheel_held", "somebody else drives this robot: ask for the wheel")
        self._hand_to(session, now)

    def press(self, session: int, now: float) -> None:
        """A new press drives: it takes a free wheel by itself. Raises ``Refused`` if it may not."""
        self.tick(now)
        if self.driver is None and session in self.barred:
            raise Refused(
                409, "wheel_taken_away", "somebody stopped the robot while you drove: take the wheel first"
            )
        self.take(session, now)

    def ask(self, session: int, now: float) -> None:
        """Would like to drive: at once, if nobody does, or nobody has done anything for ``IDLE_S``."""
        self.tick(now)
        if self.driver in (None, session) or now - self._active_s >= IDLE_S:
            self._hand_to(session, now)
        elif not any(asking.session == session for asking in self.asking):
            if len(self.asking) >= MAX_ASKING:
                raise Refused(429, "many_ask", "many are asking for this wheel already: ask later")
            self.asking.append(Asking(session, now + ANSWER_S))

    def give(self, session: int, to: int | None, now: float) -> None:
        """The driver hands it to somebody who asks; None: to the first of them. Raises ``Refused``."""
        self.need(session, now)
        self._hand_to(self._asker(to), now)

    def keep(self, session: int, to: int | None, now: float) -> None:
        """The driver does not hand it over. Raises ``Refused``."""
        self.need(session, now)
        asker = self._asker(to)
        self.asking = [asking for asking in self.asking if asking.session != asker]
        self._active_s = now

    def release(self, session: int, now: float) -> None:
        """The driver lets go, for whoever asked first, or for anybody. Raises ``Refused``."""
        self.need(session, now)
        self._free(now)

    def leave(self, session: int, now: float) -> None:
        """A session is over."""
        self.asking = [asking for asking in self.asking if asking.session != session]
        self.barred.discard(session)
        if self.driver == session:
            self._free(now)

    def stopped(self, by: int | None) -> None:
        """Somebody has stopped the robot: the wheel is free, and nobody is asking any more."""
        if self.driver is not None and self.driver != by:
            self.barred.add(self.driver)
        self.driver = None
        self.asking = []

    def active(self, session: int, now: float) -> None:
        """A session does something with the robot."""
        if session == self.driver:
            self._active_s = now

    def need(self, session: int, now: float) -> None:
        """Raises ``Refused`` unless this session drives."""
        self.tick(now)
        if self.driver != session:
            raise Refused(
                409, "not_the_driver", "this needs the wheel: take it, or ask whoever drives for it"
            )

    def tick(self, now: float) -> None:
        """Time has come to this: whoever asked long enough ago has the wheel."""
        if not self.asking:
            return
        first = self.asking[0]
        if now >= first.until or now - self._active_s >= IDLE_S:
            self._hand_to(first.session, now)

    def idle_s(self, now: float) -> float:
        """For how long the driver has done nothing."""
        return max(0.0, now - self._active_s) if self.driver is not None else 0.0

    def _asker(self, to: int | None) -> int:
        for asking in self.asking:
            if to in (None, asking.session):
                return asking.session
        raise Refused(409, "nobody_asks", "nobody asks for the wheel any more, or not this one")

    def _free(self, now: float) -> None:
        self.driver = None
        if self.asking:
            self._hand_to(self.asking[0].session, now)

    def _hand_to(self, session: int, now: float) -> None:
        """To this one; who asked as well asks the new driver, who has as long to answer."""
        if self.driver != session:
            self.asking = [
                asking._replace(until=now + ANSWER_S) for asking in self.asking if asking.session != session
            ]
        self.driver = session
        self.barred.discard(session)
        self._active_s = now
