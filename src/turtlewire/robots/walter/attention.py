"""Getting the attention of a WALTER: from any state to stopped, nothing queued, Logo control, its pose known (W7, W10).

At connect, when it fell silent, when a limit sensor has tripped (W13), and when its link was lost (W15).
"""

from __future__ import annotations

import contextlib
from itertools import count
from typing import TYPE_CHECKING

from turtlewire.errors import LimitReachedError, LinkError, NoReplyError, PoseUncertainError
from turtlewire.protocols.walter.messages import PenDown, PenUp, QueryHeading, QueryLocation, SetSpeed
from turtlewire.robots.frame import Frame
from turtlewire.robots.reconnecting import Reconnecting
from turtlewire.robots.walter.questions import Question, reported
from turtlewire.robots.walter.wire import MAX_ROUNDS, Wire
from turtlewire.turtle import HOME

if TYPE_CHECKING:
    from turtlewire.turtle import Pose

PEN_S = 0.2
# So often a robot that may be booting, and never answers, is told to stop.
BOOT_ATTENTION_S = 0.5
# One lost answer does not make a robot silent.
LEAST_ATTEMPTS = 3


class _DisturbedError(Exception):
    """A limit event, or silence, came while the robot was being attended to: it has to be done again."""


class Attention(Wire):
    """What of a connection gets the robot's attention."""

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
        host.answers = asks
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
        self.tell(
            f"the robot at {url} answers no queries: it is run as a basic one, paced by its calibration "
            f"({settings.mm_per_s_per_unit:g} mm/s and {settings.deg_per_s_per_unit:g} degrees/s per unit of "
            "speed); where it is, is reckoned and not known"
        )
        self.groups = self.groups - {"Q"} if settings.groups is not None else frozenset()
        self.host.answers = False
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
                self.tell(
                    f"the robot at {self.link.url} was reset, and no longer knows where it is: it is taken to be "
                    f"where it was last known to be, {text_of(pose)}"
                )
                return pose
            turned_deg = 0.0 if self.hand is None else self.hand.rotated_deg
            return self.where.found(self.host.abandoned, reported, turned_deg)
        if not self._connected:
            return HOME
        pose = self.whereabouts()
        self.tell(f"the robot was stopped near x {pose.x_mm:.0f} mm, y {pose.y_mm:.0f} mm, by reckoning only")
        return pose

    def _may_be_at(self, pose: Pose) -> bool:
        """Whether a robot that was not reset may be there."""
        return self.hand is not None or self.where.may_be_at(self.host.abandoned, pose)

    # ------------------------------------------------------------------ what disturbs it

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

    # ------------------------------------------------------------------ letting go

    async def close(self) -> None:
        """Stop the robot, if it can be reached, and let go of it."""
        if self._closed:
            return
        self._closed = True
        try:
            if self.session.state != "reconnecting":
                with contextlib.suppress(LinkError):
                    await self._part()
            if self.session.state == "reconnecting":
                await self.session.last_try(self._emergency_stop, self._last_bytes_s)
        finally:
            await self.session.close()

    async def _part(self) -> None:
        self.stop()
        if self._connected and self.host.answers and self.host.abandoned:
            await self._ask_how_far()
            self.stop()
        # Nothing more is expected: this lets the last bytes go out.
        await self.session.until(lambda: False, self.link.now() + self._last_bytes_s)

    @property
    def _last_bytes_s(self) -> float:
        return 150.0 / self.settings.baud

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


def text_of(pose: Pose) -> str:
    """A pose, for people."""
    return f"x {pose.x_mm:.0f} mm, y {pose.y_mm:.0f} mm, heading {pose.heading_deg:.0f} degrees"
