"""A host's end with a clock of its own: set-points end when their time is up, whoever is or is not waiting for it.

Where the pump runs (in the background, or in whoever waits in virtual time), the alarm rings: a motion ends on time
though the program that began it was cancelled, and a joystick that fell silent stops its robot.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

from turtlewire.robots.session import HostMachine

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

EventT = TypeVar("EventT")
EventT_co = TypeVar("EventT_co", covariant=True)


class SetPointHost(HostMachine[EventT_co], Protocol[EventT_co]):
    """The host's end of a protocol of set-points."""

    @property
    def idle(self) -> bool:
        """Nothing to send, and everything that is answered at all is answered."""

    def emergency_stop(self, now: float) -> None:
        """Stop the robot from any state, ahead of everything."""


class TimedHost(Generic[EventT]):
    """A host machine, with one alarm.

    Args:
        host: the machine.
        byte_s: how long a byte takes on the line.

    Attributes:
        sent_at: when the first bytes since ``mark`` were sent, on the link's clock; None: none have been yet.
        arrived_at: when the robot had all of them, if the line was free.
        free_at: when all bytes that were sent so far will have left.
    """

    def __init__(self, host: SetPointHost[EventT], byte_s: float) -> None:
        self.sent_at: float | None = None
        self.arrived_at = -math.inf
        self.free_at = -math.inf
        self._urgent_size = 0
        self._host = host
        self._byte_s = byte_s
        self._alarm_at = math.inf
        self._act: Callable[[float], None] = lambda _: None

    def set_alarm(self, at: float, act: Callable[[float], None]) -> None:
        """Have ``act`` called once, with the time, as soon as it is ``at``; instead of any alarm set before."""
        self._alarm_at, self._act = at, act

    def clear_alarm(self) -> None:
        """Forget the alarm."""
        self._alarm_at = math.inf

    def mark(self) -> None:
        """From now on, ``sent_at`` and ``arrived_at`` are about the next bytes that go out."""
        self.sent_at = None

    def urgent_to_send(self) -> bytes:
        """Bytes that overtake everything."""
        data = self._host.urgent_to_send()
        self._urgent_size += len(data)
        return data

    def data_to_send(self, now: float) -> bytes:
        """Bytes to send now."""
        data = self._host.data_to_send(now)
        size, self._urgent_size = self._urgent_size + len(data), 0
        if size:
            self.free_at = max(self.free_at, now) + size * self._byte_s
        if data and self.sent_at is None:
            self.sent_at = now
            self.arrived_at = now + len(data) * self._byte_s
        return data

    def receive_data(self, data: bytes, now: float) -> Sequence[EventT]:
        """Take bytes from the robot."""
        return self._host.receive_data(data, now)

    def next_timeout(self) -> float:
        """When to call ``timed_out``."""
        return min(self._alarm_at, self._host.next_timeout())

    def timed_out(self, now: float) -> Sequence[EventT]:
        """Act on the time: the alarm first, for it stops something."""
        if now >= self._alarm_at:
            self.clear_alarm()
            self._act(now)
        return self._host.timed_out(now)

    def link_lost(self, now: float) -> Sequence[EventT]:
        """The link ended: nothing is to be ended on time any more."""
        self.clear_alarm()
        self._urgent_size = 0
        return self._host.link_lost(now)
