"""What people are told of a robot: parts of the message ``state``, made once for all who watch."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec

from turtlewire.console.messages import encoder, raw

if TYPE_CHECKING:
    from turtlewire.console.sessions import Session, Sessions
    from turtlewire.console.station import Station
    from turtlewire.helm.view import Notice, View

# A robot of which nothing is new is told of so often, for its time.
STILL_S = 0.5
# What was made so short a time ago is still true.
FRESH_S = 0.02


class Parts(NamedTuple):
    """The parts of a state that all are told, and a number that changes with any of them."""

    revision: int
    view: msgspec.Raw
    wheel: msgspec.Raw
    program: msgspec.Raw
    faults: msgspec.Raw


NOTHING = msgspec.Raw(b"null")


class Sight:
    """Makes the parts of one robot's state, when something has changed.

    Args:
        station: the robot's.
        sessions: who is who.
    """

    def __init__(self, station: Station, sessions: Sessions) -> None:
        self._station = station
        self._sessions = sessions
        self._seen: View | None = None
        self._told_s = self._looked_s = -math.inf
        self.parts = Parts(0, NOTHING, NOTHING, NOTHING, NOTHING)

    def look(self, now: float) -> Parts:
        """The parts as they are now."""
        if now - self._looked_s < FRESH_S:
            return self.parts
        self._looked_s = now
        before, station = self.parts, self._station
        wheel = raw(wheel_of(station, self._sessions, now))
        program, faults = raw(station.program.state()), raw(station.faulting.state())
        view, seen = station.view, before.view
        is_new = self._seen is None or view._replace(time_s=0.0, lines=()) != self._seen
        if is_new or now - self._told_s >= STILL_S:
            self._seen, self._told_s = view._replace(time_s=0.0, lines=()), now
            seen = raw(view_of(view))
        made = Parts(before.revision, seen, wheel, program, faults)
        if made != before:
            self.parts = made._replace(revision=before.revision + 1)
        return self.parts


def view_of(view: View) -> dict[str, Any]:
    """A view, as people are told it."""
    told = view._asdict()
    del told["lines"]
    told["pose"] = view.pose._asdict()
    told["notices"] = [_notice(notice) for notice in view.notices]
    return told


def _notice(notice: Notice) -> dict[str, Any]:
    told: dict[str, Any] = {
        "number": notice.number,
        "time_s": notice.time_s,
        "level": notice.level,
        "code": notice.code,
        "text": notice.text,
    }
    if notice.pose is not None:
        told |= {"sensor": notice.sensor, "x_mm": notice.pose.x_mm, "y_mm": notice.pose.y_mm}
    return told


def wheel_of(station: Station, sessions: Sessions, now: float) -> dict[str, Any]:
    """Who drives, as people are told it. Seconds are whole ones: they would change all the time."""
    wheel = station.wheel
    first = wheel.asking[0] if wheel.asking else None
    return {
        "driver": wheel.driver,
        "driver_name": sessions.name(wheel.driver),
        "asker": first.session if first else None,
        "asker_name": sessions.name(first.session) if first else None,
        "asked_for_s": max(0, round(first.until - now)) if first else None,
        "asking": [asking.session for asking in wheel.asking],
        "barred": sorted(wheel.barred),
        "watchers": station.watchers,
        "idle_s": int(wheel.idle_s(now)),
    }


def state(station: Station, parts: Parts, session: Session | None, now: float) -> dict[str, Any]:
    """The message of a robot's state, for one of those who watch."""
    return {
        "type": "state",
        "stamp": now,
        "robot": station.name,
        "view": parts.view,
        "wheel": parts.wheel,
        "program": parts.program,
        "faults": parts.faults,
        "refused": station.refused(session) if session else None,
    }


def encoded(message: dict[str, Any]) -> bytes:
    """A message, as JSON."""
    return encoder.encode(message)
