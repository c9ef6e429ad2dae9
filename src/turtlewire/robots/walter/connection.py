"""A connection to a WALTER: attention, stop, what events mean, and knowing where the robot is (W7..W15).

When to send what is decided in ``protocols.walter.host``; what to aim at in ``robots.exact_pose``.
"""

from __future__ import annotations

import contextlib
import math
from itertools import count
from typing import TYPE_CHECKING

from turtlewire.errors import (
    LimitReachedError,
    LinkClosedError,
    LinkError,
    NoReplyError,
    PoseUncertainError,
    StoppedError,
)
from turtlewire.protocols.walter.codec import ALL_GROUPS, Mode
from turtlewire.protocols.walter.host import Answer, Done, Event, FenceLost, Host, Limit, Silent
from turtlewire.protocols.walter.messages import (
    EMERGENCY_STOP,
    Back,
    Forward,
    Left,
    LogoCommand,
    PenDown,
    PenUp,
    QueryHeading,
    QueryLocation,
    QueryPen,
    QueryX,
    QueryY,
    Right,
    RobotMessage,
    SetSpeed,
)
from turtlewire.robots.exact_pose import Step, Turn, wire_parts, with_rest
from turtlewire.robots.frame import Frame
from turtlewire.robots.reconnecting import Reconnecting
from turtlewire.robots.session import Session
from turtlewire.robots.walter.questions import Question, reported
from turtlewire.robots.walter.whereabouts import Whereabouts
from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.links.link import Link
    from turtlewire.robots.walter.by_hand import Account
    from turtlewire.robots.walter.settings import Settings

PEN_S = 0.2
# So often a robot that may be booting, and never answers, is told to stop.
BOOT_ATTENTION_S = 0.5
# A robot that is elsewhere each time it is asked is not under control.
MAX_ROUNDS = 10
# One lost answer does not make a robot silent.
LEAST_ATTEMPTS = 3
# The command for a positive amount, and its opposite for a negative one (W12).
TURNS = (Right, Left)
MOVES = (Forward, Back)


def text_of(pose: Pose) -> str:
    """A pose, for people."""
    return f"x {pose.x_mm:.0f} mm, y {pose.y_mm:.0f} mm, heading {pose.heading_deg:.0f} degrees"


class _DisturbedError(Exception):
    """A limit event, or silence, came while the robot was being attended to: it has to be done again."""


class Connection:
    """A WALTER at the other end of a link.

    Attributes:
        where: the account of where the robot is.
        groups: the capability groups that the robot has, as far as is known (W10).
        knows_c: whether group C has been tried: its presence shows in the pose after a first C move.
        pen_down, speed: as they are when all that was submitted is done.
        hand: what it does while it is driven by hand; None: it is not.
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

    # ------------------------------------------------------------------ connecting and stopping

    async def connect(self) -> None:
        """Get the robot's attention (W7), learn what it can (W10), and take its place as home.

        Raises ``NoReplyError`` if it answers rubbish, or nothing while ``require_replies`` is set.
        """
        self.session.start()
        try:
            await self._attend(self.settings.boot_s, boots=True)
        except BaseException:
            await self.close()
            raise
        self._connected = True
        if self.settings.reconnect_s:
            self.session.reconnect_by(
                Reconnecting(self.session, self, self.settings.reconnect_s, self.notify)
            )

    async def _attend(self, patience_s: float, *, boots: bool = False, moves: bool = True) -> None:
        """W7: get the robot's attention, and its pose; speed and pen are as they should be afterwards.

        ``boots``: its port was just opened, which may have reset it. ``moves``: its pen may be moved, too.

        A limit sensor that is held tells of it again and again, stopped robot or not, and a robot may fall silent in
        the middle of it: then all is done again, so often and no more.
        """
        self._attending = True
        try:
            for _ in range(MAX_ROUNDS):
                with contextlib.suppress(_DisturbedError):
                    await self._get_attention(patience_s, boots=boots)
                    await self._locate(boots=boots)
                    if moves:
                        await self._set_up()
                    return
            raise NoReplyError(
                f"the robot at {self.link.url} cannot be talked to: a limit trips, or it falls silent, each time"
            )
        except BaseException:
            # A robot of which nothing is known gets no command before another attention.
            self.host.emergency_stop(self.link.now())
            raise
        finally:
            self._attending = False

    async def _get_attention(self, patience_s: float, *, boots: bool) -> None:
        """W7, again and again until the robot answers or is given up: stopped, nothing queued, Logo control.

        One that answers nothing may hear nothing either until it has booted: it is told as long as it may take.
        """
        host, asks = self.host, "Q" in self.groups
        host.answers = True
        deadline = self.link.now() + patience_s
        for attempt in count(1):
            self._limit, self._silent = None, False
            self.where.forget()
            malformed, question = host.malformed, Question()
            host.attention(self.link.now())
            if not asks:
                if not boots or self.link.now() >= deadline:
                    break
                await self._is_answered(question, min(deadline, self.link.now() + BOOT_ATTENTION_S))
                continue
            host.submit(QueryHeading(), tag=question)
            timeout = self.settings.reply_timeout_s + 300.0 / self.settings.baud
            if await self._is_answered(question, self.link.now() + timeout):
                break
            if self.link.now() >= deadline and attempt >= LEAST_ATTEMPTS:
                self._without_answers(host.malformed - malformed)
                break
        host.answers = "Q" in self.groups

    async def _locate(self, *, boots: bool) -> None:
        """After an attention: where the robot is."""
        host = self.host
        pose = await self._bearings(boots=boots)
        self.hand = None
        self.where.cut_off(host.abandoned, pose)
        self.where.place(pose)
        host.interrupted, host.abandoned = None, ()

    async def _set_up(self) -> None:
        """Its speed and pen as they should be."""
        host = self.host
        host.submit(SetSpeed(self.speed))
        self.submit(PenDown() if self.pen_down else PenUp(), PEN_S)
        await self.until(lambda: host.unsent == 0)

    async def _is_answered(self, question: Question, deadline: float) -> bool:
        stops = self._stops
        done = await self.session.until(lambda: bool(question.reply or stops != self._stops), deadline)
        self._raise_stop(stops)
        return done

    def _without_answers(self, rubbish: int) -> None:
        """The robot did not answer: go on as with a basic one, if that is possible."""
        url, settings = self.link.url, self.settings
        if rubbish and not self._connected:
            raise NoReplyError(
                f"what answers at {url} does not speak WALTER's protocol ({rubbish} lines that mean nothing): "
                f"is the baud rate {settings.baud} right, and is it the right robot?"
            )
        if settings.require_replies or self._connected:
            raise NoReplyError(
                f"the robot at {url} does not answer: is it switched on, is the baud rate {settings.baud} right?"
            )
        self.notify(
            f"the robot at {url} answers no queries: it is run as a basic one, paced by its calibration "
            f"({settings.mm_per_s_per_unit:g} mm/s and {settings.deg_per_s_per_unit:g} degrees/s per unit of "
            "speed); where it is, is reckoned and not known"
        )
        self.groups = self.groups - {"Q"} if settings.groups is not None else frozenset()
        self.host.attention(self.link.now())

    async def _bearings(self, *, boots: bool) -> Pose:
        """After an attention: where is the robot, in the turtle's coordinates?"""
        if self.host.answers:
            reported = await self._ask_pose()
            if not self._connected:
                self.where.frame = Frame(reported, self.settings.distance_scale)
            elif boots and reported == HOME and not self._may_be_at(self.where.frame.from_robot(HOME)):
                pose = self.where.last_known if self.hand is None else self.whereabouts()
                self.where.frame = Frame.matching(pose, HOME, self.settings.distance_scale)
                self.notify(
                    f"the robot at {self.link.url} was reset, and no longer knows where it is: it is taken to be "
                    f"where it was last known to be, {text_of(pose)}"
                )
                return pose
            turned_deg = 0.0 if self.hand is None else self.hand.rotated_deg
            return self.where.found(self.host.abandoned, reported, turned_deg)
        if not self._connected:
            return HOME
        pose = self.whereabouts()
        self.notify(
            f"the robot was stopped near x {pose.x_mm:.0f} mm, y {pose.y_mm:.0f} mm, by reckoning only"
        )
        return pose

    def _may_be_at(self, pose: Pose) -> bool:
        """Whether a robot that was not reset may be there."""
        return self.hand is not None or self.where.may_be_at(self.host.abandoned, pose)

    def whereabouts(self) -> Pose:
        """Where the robot is, or was cut off, as far as that is known without asking."""
        if self.hand is not None:
            return self.hand.at(self.link.now())
        if self.host.abandoned:
            return self.where.reckoned(self.host.interrupted)
        return self.where.position.exact

    @property
    def is_over(self) -> bool:
        """Whether there is nothing left to wait for: it is closed, or the link was lost, and people have been told."""
        return self._closed or self.session.is_over

    def check(self) -> None:
        """Before everything that is wanted of the robot. Raises ``LinkError`` when it cannot be had."""
        if self._closed:
            raise LinkClosedError(f"the link to {self.link.url} is closed: connect again")
        self.session.check()

    # ------------------------------------------------------------------ a link that is lost (W15)

    def link_lost(self) -> str:
        """Where the robot may be now."""
        self._limit, self._silent, self._verified = None, False, -1
        target = self.where.position.robot
        if self.hand is not None:
            return f"was driven by hand, at {text_of(self.whereabouts())} by reckoning"
        pose = self.where.last_known
        way = "" if pose == target else f", on its way to {text_of(target)}"
        return f"was last known to be at {text_of(pose)}{way}"

    async def get_in_step(self) -> None:
        """The port is open again: W7, until the robot has booted and answers. It stands, and its pose is known."""
        await self._attend(self.settings.boot_s, boots=True, moves=False)

    async def resume(self) -> None:
        """After the link was lost, and the robot reached again: motion may go on, from where the robot is."""
        if not self._closed and self.session.state == "stopped":
            await self._attend(self.settings.reply_timeout_s)
            self.session.resumed()
        self.check()

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

    async def close(self) -> None:
        """Stop the robot, if it can be reached, and let go of it."""
        if self._closed:
            return
        self._closed = True
        try:
            if self.session.state == "reconnecting":
                await self.session.last_try(self._emergency_stop, 150.0 / self.settings.baud)
                return
            with contextlib.suppress(LinkError):
                self.stop()
                if self._connected and self.host.answers and self.host.abandoned:
                    await self._ask_how_far()
                    self.stop()
                # Nothing more is expected: this lets the last bytes go out.
                await self.session.until(lambda: False, self.link.now() + 150.0 / self.settings.baud)
        finally:
            await self.session.close()

    def _emergency_stop(self, now: float) -> bytes:
        self.host.emergency_stop(now)
        return self.host.urgent_to_send()

    async def _ask_how_far(self) -> None:
        """The robot was cut off and stands: how far did it get? For the trace alone, so it may fail."""
        host, now = self.host, self.link.now()
        host.attention(now)
        location, heading = Question(), Question()
        host.submit(QueryLocation(), tag=location)
        host.submit(QueryHeading(), tag=heading)
        await self._is_answered(heading, now + self.settings.reply_timeout_s + 600.0 / self.settings.baud)
        if location.reply is not None and heading.reply is not None:
            pose = reported(location.reply, heading.reply)
            self.where.cut_off(host.abandoned, self.where.found(host.abandoned, pose))

    # ------------------------------------------------------------------ operations

    async def ready(self) -> None:
        """Before every operation: see to it that the robot is in Logo control, and where the host thinks it is."""
        self.check()
        await self.raise_event()
        if self.host.mode is not Mode.LOGO:
            await self._attend(self.settings.reply_timeout_s)
        if self.where.in_doubt:
            await self._reconcile()

    def submit(self, command: LogoCommand, duration_s: float, pose: Pose | None = None) -> None:
        """Have a command sent that ends at a pose (None: where the last one ends), with the pen as it is now."""
        target = self.where.target(pose or self.where.position.robot, pen_down=self.pen_down)
        self.host.submit(command, duration_s, target)

    def drive(self, steps: list[Step]) -> None:
        """Have the steps of the exact pose sent, in as many commands as the wire needs (W5, W12)."""
        position = self.where.position
        for step in steps:
            value = step.angle_deg if isinstance(step, Turn) else step.units
            commands = TURNS if isinstance(step, Turn) else MOVES
            for rest, part in with_rest(wire_parts(abs(value), gentle=self.settings.gentle)):
                left = math.copysign(rest, value)
                if isinstance(step, Turn):
                    at = step.pose.turned(-left * position.unit_deg)
                    self.where.turning(at, math.copysign(part, value))
                else:
                    at = step.pose.moved(-left * position.unit_mm)
                self.submit(commands[value < 0](part), self.duration_s(step, part), at)

    def duration_s(self, step: Step, amount: int) -> float:
        """How long a step of so many degrees or units should take (W14)."""
        position = self.where.position
        if isinstance(step, Turn):
            return amount * position.unit_deg / (self.speed * self.settings.deg_per_s_per_unit)
        return amount * position.unit_mm / (self.speed * self.settings.mm_per_s_per_unit)

    def set_pen(self, *, down: bool) -> None:
        """Raise or lower the pen, if it is not so already."""
        if self.pen_down != down:
            self.pen_down = down
            self.submit(PenDown() if down else PenUp(), PEN_S)

    async def until(self, condition: Callable[[], bool], deadline: float = math.inf) -> None:
        """Wait; and raise what comes meanwhile: a stop, a limit event (W13), silence."""
        stops = self._stops
        await self.session.until(
            lambda: condition() or self._limit is not None or self._silent or stops != self._stops, deadline
        )
        self._raise_stop(stops)
        await self.raise_event()

    def _raise_stop(self, stops: int) -> None:
        if stops != self._stops:
            raise StoppedError("the robot was stopped: what it was doing, and what was waiting, is abandoned")

    async def finish(self, *, verify: bool = False) -> None:
        """Wait until everything that was submitted is done; then the robot is where the host thinks it is.

        A fence asks for one of four things; the others may be wrong, by a command that was damaged on the way.
        ``verify`` asks for all, unless nothing was sent since it was done last.
        """
        host = self.host
        for _ in range(MAX_ROUNDS):
            if verify and host.answers and self._verified != host.commands_sent + host.unsent:
                for query in (QueryPen(), QueryLocation(), QueryHeading()):
                    host.submit(query)
                self._verified = host.commands_sent + host.unsent
            host.fence()
            await self.until(lambda: host.idle)
            if not self.where.in_doubt:
                return
            await self._reconcile()
        raise self._out_of_control()

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

    async def raise_event(self) -> None:
        """Raise the error of a limit event (W13) or of silence (W15), the robot stopped and its pose asked for."""
        if self._attending and (self._silent or self._limit is not None):
            raise _DisturbedError
        if self._limit is not None:
            sensor = self._limit
            await self._attend(self.settings.reply_timeout_s)
            raise LimitReachedError(sensor, *self.where.position.exact)
        if self._silent:
            await self._attend(self.settings.boot_s)
            x, y, heading = self.where.position.exact
            raise PoseUncertainError(
                f"the robot at {self.link.url} stopped answering; it was stopped, and answers again: at x {x:g} mm, "
                f"y {y:g} mm, heading {heading:g} degrees as it says. If it was reset, that is wrong. "
                "Nothing was resumed"
            )

    # ------------------------------------------------------------------ lost or damaged on the way (W15)

    async def _reconcile(self) -> None:
        """Answers got lost, or the robot is not where it should be: ask where it is, and go on from there."""
        where, position, wanted = self.where, self.where.position, self.pen_down
        exact, expected = position.exact, position.robot
        reported = await self._ask_pose()
        pen = await self.ask(QueryPen())
        again, text = where.resolve(reported)
        if where.trusts_pen and pen.values() != (int(where.confirmed.pen_down),):
            self.pen_down = not where.confirmed.pen_down
            text = text or where.pen_disagrees()
        for target in again:
            self.set_pen(down=target.pen_down)
            self.drive(position.go_to(target.pose.x_mm, target.pose.y_mm))
        self.set_pen(down=wanted)
        position.exact = exact
        if position.robot != expected:
            self.drive(position.go_to(exact.x_mm, exact.y_mm) + position.align())
        if text:
            self.notify(text)
