"""What every simulated robot has: its own virtual time, a serial line, a watchdog, and the ink on the ground.

Time is virtual and nothing ticks by itself: a robot goes from one event to the next (a byte has arrived, a motion
has ended), and its pose between two of them follows from the first. Hence a robot is as fast as the processor, and
the same settings and the same bytes at the same times give the same result bit for bit, however the calls cut them up.

Robots that share a world (``company``) share its time: what one waits for, all live through, in one order.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Generic, TypeVar

from turtlewire.simulator.line import Line
from turtlewire.simulator.settings import Action, BodySettings
from turtlewire.simulator.world import Disc, World
from turtlewire.trace import Trace
from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from turtlewire.simulator.world import Contact, Wall

# How often a robot that moves looks what it meets next, where that cannot be told in advance.
LOOK_S = 0.01
S_co = TypeVar("S_co", bound=BodySettings, covariant=True)


def next_look_s(now: float) -> float:
    """The next time to look after ``now``; all robots look at the same times."""
    looks = math.floor(now / LOOK_S) + 1
    return looks * LOOK_S if looks * LOOK_S > now else (looks + 1) * LOOK_S


def last_look_s(until: float) -> float:
    """The last time to look up to ``until``; infinite if that is."""
    return math.floor(until / LOOK_S) * LOOK_S if until < math.inf else until


class Body(ABC, Generic[S_co]):
    """One robot, its line and its time; what it understands and how it moves is up to each kind.

    Attributes:
        now: seconds of the robot's time since power-on.
        events: called with each ``Action``, or None.
        settings: what it is like.
    """

    def __init__(self, settings: S_co) -> None:
        self.settings: S_co = settings
        self.now = 0.0
        self.events: Callable[[Action], object] | None = None
        # Those that share its time, itself included, and those of them that are in its way.
        self.company: Sequence[Body[BodySettings]] = (self,)
        self.others: Sequence[Body[BodySettings]] = ()
        self._from_host = Line(settings.baud)
        self._to_host = Line(settings.baud)
        self._true = settings.first_pose
        self._odometer = HOME
        self._trace = Trace(self._true)
        self._heard_s = 0.0
        self._booted_s = settings.boot_s
        self._bytes_in = self._bytes_out = self._lost_bytes = self._watchdog_stops = 0

    # The line

    def write(self, data: bytes) -> None:
        """The host puts bytes on the line now; they arrive one by one, behind those still going out."""
        self._from_host.write(data, self.now)

    def discard_output(self) -> None:
        """The host drops its bytes that have not begun to go out."""
        self._from_host.discard(self.now)

    @property
    def bytes_on_line(self) -> int:
        """How many of the host's bytes have not arrived."""
        return len(self._from_host)

    def read(self, until: float) -> bytes:
        """Let time pass until something has arrived for the host, or until ``until``; return what has arrived.

        b"" when only time has passed. With ``until`` infinite, time stops where nothing will happen any more but
        that robots drive on as they do.
        """
        arrived = b""
        until = max(until, self.now)
        while (at := self.next_event()) <= until:
            if at == math.inf or (until == math.inf and self.awaits_host()):
                return arrived
            self._set_time(max(self.now, at))
            for robot in self.company:
                if robot.due_s() <= self.now:
                    robot.happen()
                    break
            data = self._to_host.read(self.now)
            if data:
                arrived += data
                until = self.now
        if not arrived:
            self._set_time(until)
        return arrived

    def next_event(self) -> float:
        """When something happens next by itself, in seconds of the robot's time; infinite: nothing will."""
        return min(self._to_host.next_s, *(robot.due_s() for robot in self.company))

    def _set_time(self, now: float) -> None:
        for robot in self.company:
            robot.now = now

    def awaits_host(self) -> bool:
        """Whether all that is to come by itself is that robots drive on."""
        return self._to_host.next_s == math.inf and all(robot.only_drives_on() for robot in self.company)

    def port_opened(self) -> None:
        """The host has opened the port once more: a robot that takes time to boot is reset by that (section 4)."""
        if not self.settings.boot_s:
            return
        self._tell("reset")
        self._abandon()
        self._reset()
        self._from_host, self._to_host = Line(self.settings.baud), Line(self.settings.baud)
        self._booted_s = self.now + self.settings.boot_s

    # What is to be seen of it

    @property
    @abstractmethod
    def pose(self) -> Pose:
        """Where it truly is on the ground."""

    @property
    @abstractmethod
    def is_moving(self) -> bool:
        """Whether the wheels turn."""

    @property
    def trace(self) -> Trace:
        """What the pen has truly drawn on the ground up to now; a trace of its own while the robot moves."""
        undrawn = self._undrawn()
        return self._trace.extended(undrawn, pen_down=self._inks) if undrawn else self._trace

    @property
    def obstacles(self) -> Sequence[Wall | Disc]:
        """What stands around it."""
        return (*self.settings.world.walls, *self.settings.world.discs)

    def clear_trace(self) -> None:
        """A new sheet: forget what has been drawn up to now."""
        self._draw()
        self._trace.clear()

    def disc(self) -> Disc:
        """The ground that it covers now."""
        pose = self.pose
        middle = pose.moved(self.settings.offset_mm) if self.settings.offset_mm else pose
        return Disc(middle.x_mm, middle.y_mm, self.settings.radius_mm)

    @abstractmethod
    def claims(self) -> tuple[Disc, ...]:
        """The ground that nobody else may enter now: where it is, and where it is about to be."""

    def _surroundings(self) -> World:
        """What is in its way now: the walls, and other robots."""
        world = self.settings.world
        if not self.others:
            return world
        return World(world.walls, world.start, (*world.discs, *self._claimed()))

    def _claimed(self) -> tuple[Disc, ...]:
        return tuple(disc for robot in self.others for disc in robot.claims())

    def _met_on(self, here: Pose, there: Pose) -> tuple[float, Contact] | None:
        """Another robot on a short straight way, and after which part of it."""
        way_mm = here.distance_to(there.x_mm, there.y_mm)
        if not way_mm:
            return None
        ahead = ((there.x_mm - here.x_mm) / way_mm, (there.y_mm - here.y_mm) / way_mm)
        others = World(discs=self._claimed())
        contact = others.contact(here.x_mm, here.y_mm, ahead, way_mm, self.settings.radius_mm)
        return (contact.distance_mm / way_mm, contact) if contact else None

    # Time

    def due_s(self) -> float:
        """When something happens in the robot itself; infinite: nothing will."""
        at = min(self._from_host.next_s, self._next_s())
        if self.settings.watchdog_s is not None:
            at = min(at, self._watchdog_at())
        return at

    def happen(self) -> None:
        """Let one thing happen that is due now. What ends, ends before a byte that arrives at the same time acts."""
        if not self._act():
            if self._from_host.next_s <= self.now:
                self._receive(self._from_host.read_byte())
            elif self._watchdog_at() <= self.now:
                self._watchdog_stops += 1
                self._tell("watchdog")
                self._abandon()
        self._go_on()

    def only_drives_on(self) -> bool:
        """Whether nothing but driving on, for ever, is to come by itself."""
        return not len(self._from_host) and self._watchdog_at() == math.inf and self._is_settled()

    @abstractmethod
    def _next_s(self) -> float:
        """When something happens by itself, apart from bytes and the watchdog."""

    @abstractmethod
    def _is_settled(self) -> bool:
        """Whether ``_next_s`` is endless, or means no more than that the robot goes on as it does."""

    @abstractmethod
    def _act(self) -> bool:
        """Let the first of those things happen, if one is due; whether one was."""

    @abstractmethod
    def _understand(self, byte: int) -> bool:
        """Take one byte from the host; whether something valid was heard."""

    @abstractmethod
    def _abandon(self) -> None:
        """Stop where it is and forget everything that was to come."""

    def _reset(self) -> None:
        """Forget everything, as a robot that is switched on anew: where it is, too."""
        self._odometer = HOME

    @abstractmethod
    def _is_busy(self) -> bool:
        """Whether there is something that a watchdog would have to stop."""

    @abstractmethod
    def _undrawn(self) -> list[Pose]:
        """The way since the last drawing, up to now."""

    def _draw(self) -> None:
        """Put that way on the ground."""
        for pose in self._undrawn():
            self._trace.move(pose, pen_down=self._inks)

    @property
    @abstractmethod
    def _inks(self) -> bool:
        """Whether the pen is on the ground."""

    def _go_on(self) -> None:
        """Do what follows from what has just happened."""

    def _receive(self, byte: int) -> None:
        if self.now < self._booted_s:
            self._lost_bytes += 1
            return
        self._bytes_in += 1
        if self._understand(byte):
            self._heard_s = self.now

    def _watchdog_at(self) -> float:
        """When the watchdog stops the robot unless something is heard (section 4)."""
        if self.settings.watchdog_s is None or not self._is_busy():
            return math.inf
        return self._heard_s + self.settings.watchdog_s

    def _tell(self, what: str) -> None:
        if self.events is not None:
            self.events(Action(self.now, what))

    def _send(self, data: bytes) -> None:
        self._bytes_out += len(data)
        self._to_host.write(data, self.now)
