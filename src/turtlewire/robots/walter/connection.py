"""A connection to a WALTER: attention, stop, what events mean, and knowing where the robot is (W7..W15).

When to send what is decided in ``protocols.walter.host``; what to aim at in ``robots.exact_pose``.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

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
    Back,
    Forward,
    HeadingReply,
    Left,
    LocationReply,
    LogoCommand,
    PenDown,
    PenReply,
    PenUp,
    QueryHeading,
    QueryLocation,
    QueryPen,
    Right,
    RobotMessage,
    SetSpeed,
    XReply,
    YReply,
)
from turtlewire.robots.exact_pose import ExactPose, Step, Turn, wire_parts
from turtlewire.robots.frame import Frame
from turtlewire.robots.session import Session
from turtlewire.trace import Trace
from turtlewire.turtle import HOME, Pose, wrapped

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.links.link import Link
    from turtlewire.robots.walter.settings import Settings

UNIT_MM = 0.5  # W5
PEN_S = 0.2
# A robot may round its pose to units and whole degrees; what is further off than this is corrected.
TOLERANCE_MM = 1.0
TOLERANCE_DEG = 1.0
# What is further off than this, people should know of.
NOTABLE_MM = 5.0
# Coordinates beyond what a reply can carry are not compared (W5).
LARGEST_MM = 16383.0
# A robot that tells its pen wrong so often cannot tell it.
MAX_PEN_DISAGREEMENTS = 3
# A robot that is elsewhere each time it is asked is not under control.
MAX_ROUNDS = 10
# The command for a positive amount, and its opposite for a negative one (W12).
TURNS = (Right, Left)
MOVES = (Forward, Back)


class Target(NamedTuple):
    """Where the robot is, and its pen, when a command is done."""

    pose: Pose
    pen_down: bool


class _Question:
    """A query whose answer somebody waits for."""

    reply: RobotMessage | None = None


class Connection:
    """A WALTER at the other end of a link.

    Attributes:
        position: the exact turtle and the robot that follows it.
        frame: the turtle's coordinates in the robot's.
        groups: the capability groups that the robot has, as far as is known (W10).
        knows_c: whether group C has been tried: its presence shows in the pose after a first C move.
        pen_down, speed: as they are when all that was submitted is done.
        confirmed: where the robot is known to be, or to have been.
        trace: the way that the robot is known to have gone.
    """

    def __init__(self, link: Link, settings: Settings, notify: Callable[[str], None]) -> None:
        self.link = link
        self.settings = settings
        self.groups = ALL_GROUPS if settings.groups is None else settings.groups
        self.knows_c = settings.groups is not None
        self.host = Host(
            baud=settings.baud, max_unfenced=settings.max_unfenced, heartbeat_s=settings.heartbeat_s
        )
        self.session: Session[Event] = Session(link, self.host, self._on_event)
        self.position = ExactPose(UNIT_MM)
        self.frame = Frame(HOME)
        self.pen_down = True
        self.speed = settings.speed
        self.confirmed = Target(HOME, pen_down=True)
        self.trace = Trace()
        self.distance_mm = 0.0
        self.corrections = 0
        self.started = link.now()
        self.notify = notify
        self._connected = False
        self._closed = False
        self._stops = 0
        # What an event has told, and the next operation has to see to.
        self._limit: str | None = None
        self._silent = False
        self._mismatch = False
        self._uncertain: list[Target] | None = None  # since a fence was lost, in order
        self._pen_disagreements = 0

    # ------------------------------------------------------------------ events

    def _on_event(self, event: Event) -> None:
        if isinstance(event, Done):
            self._confirm(event.tag)
        elif isinstance(event, Answer):
            if isinstance(event.tag, _Question):
                event.tag.reply = event.reply
            elif self._uncertain is None and self._is_off(event.reply):
                self._mismatch = True
        elif isinstance(event, FenceLost):
            self._uncertain = self._uncertain or []
            for tag in event.uncertain:
                self._confirm(tag)
        elif isinstance(event, Limit):
            self._limit = event.sensor
        elif isinstance(event, Silent):
            self._silent = True

    def _confirm(self, tag: object) -> None:
        if not isinstance(tag, Target):
            return
        if self._uncertain is not None:
            self._uncertain.append(tag)
            return
        self.distance_mm += self.confirmed.pose.distance_to(tag.pose.x_mm, tag.pose.y_mm)
        self.confirmed = tag
        self.trace.move(tag.pose, pen_down=tag.pen_down)

    def _is_off(self, reply: RobotMessage) -> bool:
        """A fence's answer also tells where the robot is: is it elsewhere than it should be?"""
        pose = self.frame.to_robot(self.confirmed.pose)
        if isinstance(reply, HeadingReply):
            return abs(wrapped(reply.heading_deg - pose.heading_deg)) > TOLERANCE_DEG
        if isinstance(reply, XReply):
            return abs(pose.x_mm) < LARGEST_MM and abs(reply.x_half_mm * UNIT_MM - pose.x_mm) > TOLERANCE_MM
        if isinstance(reply, YReply):
            return abs(pose.y_mm) < LARGEST_MM and abs(reply.y_half_mm * UNIT_MM - pose.y_mm) > TOLERANCE_MM
        return (
            self._trusts_pen and isinstance(reply, PenReply) and bool(reply.down) != self.confirmed.pen_down
        )

    # ------------------------------------------------------------------ connecting and stopping

    async def connect(self) -> None:
        """Get the robot's attention (W7), learn what it can (W10), and take its place as home.

        Raises ``NoReplyError`` if it answers rubbish, or nothing while ``require_replies`` is set.
        """
        self.session.start()
        try:
            await self._attend(self.settings.boot_s)
        except BaseException:
            await self.close()
            raise
        self._connected = True

    async def _attend(self, patience_s: float) -> None:
        """W7, again and again until the robot answers or is given up.

        Afterwards it is stopped and in Logo control, its pose is asked for, speed and pen are as they should be.
        """
        host, asks = self.host, "Q" in self.groups
        host.answers = True
        deadline = self.link.now() + patience_s
        while True:
            self._limit, self._silent, self._mismatch, self._uncertain = None, False, False, None
            malformed, question = host.malformed, _Question()
            host.attention(self.link.now())
            if not asks:
                break
            host.submit(QueryHeading(), tag=question)
            timeout = self.settings.reply_timeout_s + 300.0 / self.settings.baud
            if await self._is_answered(question, self.link.now() + timeout):
                break
            if self.link.now() >= deadline:
                self._without_answers(host.malformed - malformed)
                break
        host.answers = "Q" in self.groups
        self._place(await self._bearings())
        host.submit(SetSpeed(self.speed))
        self.submit(PenDown() if self.pen_down else PenUp(), PEN_S)
        await self.session.until(lambda: host.unsent == 0)

    async def _is_answered(self, question: _Question, deadline: float) -> bool:
        return await self.session.until(lambda: question.reply is not None, deadline)

    def _without_answers(self, rubbish: int) -> None:
        """The robot did not answer: go on as with a basic one, if that is possible."""
        url, settings = self.link.url, self.settings
        if rubbish:
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

    async def _bearings(self) -> Pose:
        """After an attention: where is the robot, in the turtle's coordinates?"""
        if self.host.answers:
            reported = await self._ask_pose()
            if not self._connected:
                self.frame = Frame(reported)
            return self.frame.from_robot(reported)
        if not self._connected:
            return HOME
        pose = self._reckoned()
        self.notify(
            f"the robot was stopped near x {pose.x_mm:.0f} mm, y {pose.y_mm:.0f} mm, by reckoning only"
        )
        return pose

    def _reckoned(self) -> Pose:
        """Where a robot that does not answer was when it was cut off, by the clock."""
        before = self.confirmed.pose
        if self.host.interrupted is None or not isinstance(self.host.interrupted[0], Target):
            return before
        after, part = self.host.interrupted[0].pose, self.host.interrupted[1]
        return Pose(
            before.x_mm + part * (after.x_mm - before.x_mm),
            before.y_mm + part * (after.y_mm - before.y_mm),
            round(before.heading_deg + part * wrapped(after.heading_deg - before.heading_deg)) % 360.0,
        )

    def _place(self, pose: Pose) -> None:
        """The robot is here, and so is the turtle; what is finer than the robot can tell is kept."""
        exact, near = self.position.exact, pose
        if exact.distance_to(pose.x_mm, pose.y_mm) <= UNIT_MM:
            near = Pose(exact.x_mm, exact.y_mm, pose.heading_deg)
        if abs(wrapped(exact.heading_deg - pose.heading_deg)) <= 0.5:
            near = Pose(near.x_mm, near.y_mm, exact.heading_deg)
        self.position.exact, self.position.robot = near, pose
        self._confirm(Target(pose, self.confirmed.pen_down))
        self.host.interrupted = None

    def arrived(self, pose: Pose) -> None:
        """The robot is known to be at a pose, whatever was reckoned."""
        self.position.robot = pose
        self._confirm(Target(pose, self.pen_down))

    @property
    def closed(self) -> bool:
        """Whether the connection is over: closed, or the link has ended."""
        return self._closed or self.session.failed

    def stop(self) -> None:
        """W8: stop at once, ahead of everything, and forget every motion not yet done."""
        self._stops += 1
        self.host.emergency_stop(self.link.now())
        self.session.flush()

    async def close(self) -> None:
        """Stop the robot, if it can be reached, and let go of it."""
        if self._closed:
            return
        self._closed = True
        try:
            self.stop()
            # Nothing more is expected: this lets the last bytes go out.
            await self.session.until(lambda: False, self.link.now() + 150.0 / self.settings.baud)
        except LinkError:
            pass
        finally:
            await self.session.close()

    # ------------------------------------------------------------------ operations

    async def ready(self) -> None:
        """Before every operation: see to it that the robot is in Logo control, and where the host thinks it is."""
        if self._closed:
            raise LinkClosedError(f"the link to {self.link.url} is closed: connect again")
        await self._raise_event()
        if self.host.mode is not Mode.LOGO:
            await self._attend(self.settings.reply_timeout_s)
        if self._mismatch or self._uncertain is not None:
            await self._reconcile()

    def submit(self, command: LogoCommand, duration_s: float, pose: Pose | None = None) -> None:
        """Have a command sent that ends at a pose (None: where the last one ends), with the pen as it is now."""
        self.host.submit(command, duration_s, Target(pose or self.position.robot, self.pen_down))

    def drive(self, steps: list[Step]) -> None:
        """Have the steps of the exact pose sent, in as many commands as the wire needs (W5, W12)."""
        for step in steps:
            value = step.angle_deg if isinstance(step, Turn) else step.units
            commands = TURNS if isinstance(step, Turn) else MOVES
            for rest, part in _with_rest(wire_parts(abs(value), gentle=self.settings.gentle)):
                left = math.copysign(rest, value)
                at = step.pose.turned(-left) if isinstance(step, Turn) else step.pose.moved(-left * UNIT_MM)
                self.submit(commands[value < 0](part), self.duration_s(step, part), at)

    def duration_s(self, step: Step, amount: int) -> float:
        """How long a step of so many degrees or units should take (W14)."""
        if isinstance(step, Turn):
            return amount / (self.speed * self.settings.deg_per_s_per_unit)
        return amount * UNIT_MM / (self.speed * self.settings.mm_per_s_per_unit)

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
        if stops != self._stops:
            raise StoppedError("the robot was stopped: what it was doing, and what was waiting, is abandoned")
        await self._raise_event()

    async def finish(self) -> None:
        """Wait until everything that was submitted is done; then the robot is where the host thinks it is."""
        for _ in range(MAX_ROUNDS):
            self.host.fence()
            await self.until(lambda: self.host.idle)
            if not self._mismatch and self._uncertain is None:
                return
            await self._reconcile()
        raise PoseUncertainError(
            f"the robot at {self.link.url} is elsewhere each time it is asked: something moves it, or the line is too "
            "noisy to go on"
        )

    async def ask(self, query: LogoCommand) -> RobotMessage:
        """The robot's answer to a query, when everything before it is done."""
        question = _Question()
        self.host.submit(query, tag=question)
        await self.until(lambda: question.reply is not None)
        assert question.reply is not None
        return question.reply

    async def reported_pose(self) -> Pose:
        """Where the robot says it is, in the turtle's coordinates."""
        return self.frame.from_robot(await self._ask_pose())

    async def _ask_pose(self) -> Pose:
        location = await self.ask(QueryLocation())
        heading = await self.ask(QueryHeading())
        assert isinstance(location, LocationReply)
        assert isinstance(heading, HeadingReply)
        return Pose(location.x_half_mm * UNIT_MM, location.y_half_mm * UNIT_MM, float(heading.heading_deg))

    async def _raise_event(self) -> None:
        """Raise the error of a limit event (W13) or of silence (W15), the robot stopped and its pose asked for."""
        if self._limit is not None:
            sensor = self._limit
            await self._attend(self.settings.reply_timeout_s)
            raise LimitReachedError(sensor, *self.position.exact)
        if self._silent:
            await self._attend(self.settings.boot_s)
            x, y, heading = self.position.exact
            raise PoseUncertainError(
                f"the robot at {self.link.url} stopped answering; it was stopped, and answers again: at x {x:g} mm, "
                f"y {y:g} mm, heading {heading:g} degrees as it says. If it was reset, that is wrong. "
                "Nothing was resumed"
            )

    # ------------------------------------------------------------------ lost or damaged on the way (W15)

    async def _reconcile(self) -> None:
        """Answers got lost, or the robot is not where it should be: ask where it is, and go on from there."""
        self.corrections += 1
        pose = await self.reported_pose()
        pen = await self.ask(QueryPen())
        uncertain, self._uncertain, self._mismatch = self._uncertain or [], None, False
        expected = self.position.robot
        if _matches(pose, expected):
            again: list[Target] = []
            for target in uncertain:
                self._confirm(target)
            if uncertain:
                self.notify("an answer of the robot got lost; its pose shows that every motion was done")
        else:
            again = self._still_to_do(uncertain, pose)
            self._tell_of_deviation(pose.distance_to(expected.x_mm, expected.y_mm), len(again))
            self.position.robot = pose
            self._confirm(Target(pose, self.confirmed.pen_down))
        self._go_again(again, pen_is_down=pen.values() == (1,))

    def _still_to_do(self, uncertain: list[Target], pose: Pose) -> list[Target]:
        """The commands that got lost, if the pose shows which: those after the one that ends there."""
        poses = [self.confirmed.pose, *(target.pose for target in uncertain)]
        done = max((i for i, p in enumerate(poses) if _matches(pose, p)), default=len(uncertain))
        for target in uncertain[:done]:
            self._confirm(target)
        return uncertain[done:]

    def _tell_of_deviation(self, off_mm: float, again: int) -> None:
        if again:
            self.notify(
                f"{again} commands got lost on the way; the robot's pose shows which, they are sent again"
            )
        elif off_mm > NOTABLE_MM:
            self.notify(
                f"the robot is {off_mm:.1f} mm from where it should be: a command got lost or damaged on the way, or "
                "its wheels were held; it goes on from where it is"
            )

    def _go_again(self, targets: list[Target], *, pen_is_down: bool) -> None:
        """Put the pen right, and send the way again that got lost: not blindly, for the pose was asked."""
        exact, wanted = self.position.exact, self.pen_down
        if self._trusts_pen and pen_is_down != self.confirmed.pen_down:
            self.pen_down = pen_is_down
            if not targets and pen_is_down != wanted:
                self._pen_disagreements += 1
                if self._pen_disagreements == MAX_PEN_DISAGREEMENTS:
                    self.notify(
                        "the robot's answers about its pen contradict what it was told; they are ignored"
                    )
        for target in targets:
            self.set_pen(down=target.pen_down)
            self.drive(self.position.go_to(target.pose.x_mm, target.pose.y_mm))
        self.set_pen(down=wanted)
        self.position.exact = exact

    @property
    def _trusts_pen(self) -> bool:
        return self._pen_disagreements < MAX_PEN_DISAGREEMENTS


def _with_rest(parts: list[int]) -> list[tuple[int, int]]:
    """Each part with what is still to come after it."""
    total = sum(parts)
    rests = []
    for part in parts:
        total -= part
        rests.append((total, part))
    return rests


def _matches(pose: Pose, other: Pose) -> bool:
    return (
        pose.distance_to(other.x_mm, other.y_mm) <= 2 * TOLERANCE_MM
        and abs(wrapped(pose.heading_deg - other.heading_deg)) <= TOLERANCE_DEG
    )
