"""A WALTER at the other end of a link: what comes from it, what it is asked, and how it is stopped (W8).

When to send what is decided in ``protocols.walter.host``.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from turtlewire.errors import LinkClosedError, NotSupportedError, PoseUncertainError, StoppedError
from turtlewire.protocols.walter.codec import ALL_GROUPS
from turtlewire.protocols.walter.host import Answer, Done, Event, FenceLost, Host, Limit, Silent
from turtlewire.protocols.walter.messages import (
    EMERGENCY_STOP,
    LogoCommand,
    QueryHeading,
    QueryLocation,
    QueryX,
    QueryY,
    RobotMessage,
)
from turtlewire.robots.session import Session
from turtlewire.robots.stops import Stops
from turtlewire.robots.walter.questions import Question, reported
from turtlewire.robots.walter.whereabouts import Whereabouts

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.links.link import Link
    from turtlewire.robots.walter.by_hand import Account
    from turtlewire.robots.walter.settings import Settings
    from turtlewire.turtle import Pose

# A robot that is elsewhere each time it is asked is not under control.
MAX_ROUNDS = 10


class Wire(ABC):
    """What of a connection needs no attention of the robot.

    Attributes:
        where: the account of where the robot is.
        groups: the capability groups that the robot has, as far as is known (W10).
        knows_c: whether group C has been tried: its presence shows in the pose after a first C move.
        pen_down, speed: as they are when all that was submitted is done.
        hand: what it does while it is driven by hand; None: it is not.
        stops: who knows of which stop.
    """

    def __init__(self, link: Link, settings: Settings, notify: Callable[[str], None]) -> None:
        self.link = link
        self.settings = settings
        self.groups = ALL_GROUPS if settings.groups is None else settings.groups
        self.knows_c = settings.groups is not None
        self.host = Host(
            baud=settings.baud, max_unfenced=settings.max_unfenced, heartbeat_s=settings.heartbeat_s
        )
        self.session: Session[Event] = Session(link, self.host, self._on_event, 10.0 / settings.baud)
        self.where = Whereabouts(settings.distance_scale, settings.turn_scale)
        self.pen_down = True
        self.speed = settings.speed
        self.hand: Account | None = None
        self.started = link.now()
        self.notify = notify
        self._connected = False
        self._closed = False
        self._stops = 0
        self.stops = Stops()
        # What an event has told, and the next operation has to see to.
        self._limit: str | None = None
        self._silent = False
        self._attending = False
        # How many commands had been sent when all of the pose was last asked for.
        self._verified = -1

    # ------------------------------------------------------------------ events

    def _on_event(self, event: Event) -> None:
        if isinstance(event, Done):
            self.where.done(event.tag)
        elif isinstance(event, Answer):
            if isinstance(event.tag, Question):
                event.tag.reply = event.reply
            else:
                self.where.compare(event.reply)
        elif isinstance(event, FenceLost):
            self.where.lost(event.uncertain)
            for tag in event.uncertain:
                if isinstance(tag, Question):
                    tag.lost = True
        elif isinstance(event, Limit):
            if self.hand is not None:
                self.hand.end(self.link.now())  # it stands already
            self._limit = event.sensor
        elif isinstance(event, Silent):
            self._silent = True

    @abstractmethod
    async def raise_event(self) -> None:
        """Raise the error of an event that nobody has seen to yet, the robot stopped and its pose asked for."""

    async def until(self, condition: Callable[[], bool], deadline: float = math.inf) -> None:
        """Wait; and raise what comes meanwhile: a stop, a limit event (W13), silence."""
        stops = self._stops
        await self.session.until(
            lambda: condition() or self._limit is not None or self._silent or stops != self._stops, deadline
        )
        self._raise_stop(stops)
        await self.raise_event()

    def tell(self, text: str) -> None:
        """Tell people, in the middle of an operation. Raises ``StoppedError`` if one of them stops the robot there."""
        stops = self._stops
        self.notify(text)
        self._raise_stop(stops)

    def _raise_stop(self, stops: int) -> None:
        if stops != self._stops:
            self.stops.known()
            raise StoppedError("the robot was stopped: what it was doing, and what was waiting, is abandoned")

    @property
    def is_over(self) -> bool:
        """Whether there is nothing left to wait for: it is closed, or the link was lost, and people have been told."""
        return self._closed or self.session.is_over

    def check(self) -> None:
        """Before everything that is wanted of the robot. Raises ``LinkError`` when it cannot be had."""
        if self._closed:
            raise LinkClosedError(f"the link to {self.link.url} is closed: connect again")
        self.session.check()

    def need(self, group: str, lack: str) -> None:
        """Raises ``NotSupportedError`` for a robot without a capability group (W10)."""
        if group not in self.groups:
            raise NotSupportedError(f"the robot at {self.link.url} {lack}")

    # ------------------------------------------------------------------ stopping

    def stop(self) -> None:
        """W8: stop at once, ahead of everything, and forget every motion not yet done. Raises ``LinkError``."""
        self.halt()
        self.session.flush()

    def halt(self) -> None:
        """``stop``, as soon as something is sent: keys of direct control may go out with it."""
        self._stops += 1
        self.session.clear_alarm()
        self.end_hand(self.link.now())
        self.host.emergency_stop(self.link.now())

    def end_hand(self, now: float) -> None:
        """Whoever drives by hand does not any more, as soon as an emergency stop has arrived."""
        if self.hand is not None:
            self.hand.end(now + len(EMERGENCY_STOP) * 10.0 / self.settings.baud)

    # ------------------------------------------------------------------ sending and asking

    def submit(self, command: LogoCommand, duration_s: float, pose: Pose | None = None) -> None:
        """Have a command sent that ends at a pose (None: where the last one ends), with the pen as it is now."""
        target = self.where.target(pose or self.where.position.robot, pen_down=self.pen_down)
        self.host.submit(command, duration_s, target)

    def _out_of_control(self) -> PoseUncertainError:
        return PoseUncertainError(
            f"the robot at {self.link.url} is elsewhere, or its answer gets lost, each time it is asked: something "
            "moves it, or the line is too noisy to go on"
        )

    async def ask(self, query: LogoCommand) -> RobotMessage:
        """The robot's answer to a query, when everything before it is done."""
        for _ in range(MAX_ROUNDS):
            question = Question()
            self.host.submit(query, tag=question)
            await self.until(question.is_settled)
            if question.reply is not None:
                return question.reply
        raise self._out_of_control()

    async def reported_pose(self) -> Pose:
        """Where the robot says it is, in the turtle's coordinates."""
        return self.where.frame.from_robot(await self._ask_pose())

    async def _ask_pose(self) -> Pose:
        """The robot's pose, asked for twice: an answer has no checksum, and what it says is believed."""
        for _ in range(MAX_ROUNDS):
            location, heading = await self.ask(QueryLocation()), await self.ask(QueryHeading())
            x, y, again = await self.ask(QueryX()), await self.ask(QueryY()), await self.ask(QueryHeading())
            if (*x.values(), *y.values()) == location.values() and heading == again:
                return reported(location, heading)
        raise self._out_of_control()

    def whereabouts(self) -> Pose:
        """Where the robot is, or was cut off, as far as that is known without asking."""
        if self.hand is not None:
            return self.hand.at(self.link.now())
        if self.host.abandoned:
            return self.where.reckoned(self.host.interrupted)
        return self.where.position.exact
