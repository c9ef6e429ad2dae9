"""What all parts of the console share: the robots, the sessions, the clock."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

from turtlewire.console.pictures import Painter
from turtlewire.console.sessions import Sessions
from turtlewire.console.stations import Stations
from turtlewire.console.views import FRESH_S, Sight

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from turtlewire.console.programs import Programs
    from turtlewire.console.sessions import Session
    from turtlewire.console.station import Station
    from turtlewire.console.stations import Berth


class Console:
    """The console of some robots.

    Args:
        berths: the robots.
        announce: told where a robot has to be, for a new pty.
        programs: those that are kept.

    Attributes:
        stations: the robots.
        sessions: who uses it.
        painter: makes pictures.
    """

    def __init__(self, berths: Iterable[Berth], announce: Callable[[str], None], programs: Programs) -> None:
        self.programs = programs
        self.stations = Stations(berths, announce, self.now, programs.folder)
        self.sessions = Sessions()
        self.painter = Painter()
        self._sights = {station.name: Sight(station, self.sessions) for station in self.stations}
        self._robots: list[dict[str, Any]] = []
        self._robots_s = -math.inf

    @staticmethod
    def now() -> float:
        """Seconds, to the millisecond: what pages are told, they say again."""
        return round(time.monotonic(), 3)

    def sight(self, station: Station) -> Sight:
        """Who makes the state of a robot."""
        return self._sights[station.name]

    def robots(self) -> list[dict[str, Any]]:
        """What is known of the robots; the same list while nothing of it changes."""
        now = self.now()
        if now - self._robots_s >= FRESH_S:
            self._robots_s = now
            robots = [station.about for station in self.stations]
            if robots != self._robots:
                self._robots = robots
        return self._robots

    def leave(self, session: Session) -> None:
        """A session is over."""
        self.sessions.close(session)
        self.stations.leave(session)

    def forget_unused(self) -> None:
        """Sessions that nobody uses are over."""
        for session in self.sessions.unused(self.now()):
            self.leave(session)
