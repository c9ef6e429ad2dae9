"""WALTER as a turtle: the Logo vocabulary by the commands that this robot has (W9..W12)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.protocols.walter.messages import (
    DirectKey,
    HornHigh,
    HornLow,
    HornOff,
    LampOff,
    LampOn,
    LogoCommand,
    RobotMessage,
    SetSpeed,
)
from turtlewire.robots.asynchronous import AsyncRobot
from turtlewire.robots.checks import check, check_speed, check_tone, check_valid_s
from turtlewire.robots.walter.absolute import AbsoluteMoves
from turtlewire.robots.walter.by_hand import ByHand
from turtlewire.robots.walter.by_message import ByMessage
from turtlewire.robots.walter.connection import Connection
from turtlewire.robots.walter.settings import DEFAULTS, Settings, Statistics
from turtlewire.turtle import TONES, Pose

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.links.link import Link
    from turtlewire.protocols.message import AnyMessage
    from turtlewire.robots.paper import Paper
    from turtlewire.trace import Trace

HORNS: dict[str, type[LogoCommand]] = dict(zip(TONES, (HornOff, HornLow, HornHigh), strict=True))


class AsyncWalter(AsyncRobot):
    """A WALTER, driven asynchronously. ``turtlewire.connect_async`` makes one; it is an async context manager.

    Besides what ``AsyncRobot`` says, each method may raise ``LinkError`` when
    the link ends, ``NoReplyError`` or ``PoseUncertainError`` when the robot falls silent, ``LimitReachedError`` when a
    limit sensor trips, and ``StoppedError`` when ``stop`` is called meanwhile.

    Args:
        link: to the robot; the driver owns it from here on.
        settings: how to drive it.
        notify: told, in a sentence for people, what they should know and what is no error.
        paper: what the robot draws on, where that can be seen (a simulated robot); None: it is reckoned.
    """

    def __init__(
        self,
        link: Link,
        settings: Settings = DEFAULTS,
        notify: Callable[[str], None] = lambda _: None,
        paper: Paper | None = None,
    ) -> None:
        self._wire = Connection(link, settings.checked(), notify)
        self._absolute = AbsoluteMoves(self._wire)
        self._by_hand = ByHand(self._wire)
        self._by_message = ByMessage(self._wire, self._by_hand, self._absolute)
        self._session = self._wire.session
        self._stops_told = self._wire.stops
        self._paper = paper
        self._step_by_step = False

    @property
    def _way(self) -> Trace:
        return self._wire.where.trace

    async def connect(self) -> None:
        """Get the robot's attention (W7), learn what it can (W10), and take its place as home.

        Raises ``NoReplyError`` if it answers rubbish, or nothing while ``require_replies`` is set.
        """
        await self._wire.connect()

    async def close(self, *, finish: bool = True) -> None:
        """Stop the robot and let go of it: after the motion is done, or with ``finish=False`` at once."""
        try:
            if finish and not self._wire.is_over:
                self._stops_told.known()  # there is nothing to finish of what was stopped
                await self.finish()
        finally:
            await self._wire.close()

    # ------------------------------------------------------------------ what is known

    @property
    def pose(self) -> Pose:
        """Where the exact turtle is; while the robot is driven by hand, where that is by reckoning."""
        hand = self._wire.hand
        return self._wire.where.position.exact if hand is None else hand.at(self._wire.link.now())

    @property
    def is_pen_down(self) -> bool:
        """Whether the pen is down."""
        return self._wire.pen_down

    async def resume(self) -> None:
        """Let motion go on after the link was lost and the robot was reached again; nothing to do otherwise.

        The turtle is where the robot says that it is, or by reckoning; a robot that was reset cannot tell. Nothing that
        was under way is sent again (W15). Raises ``LinkLostError`` while the robot is not reached yet.
        """
        await self._wire.resume()

    @property
    def groups(self) -> frozenset[str]:
        """The capability groups (C, Q, H, E) that the robot has, as far as is known (W10)."""
        return self._wire.groups

    @property
    def statistics(self) -> Statistics:
        """Figures of this connection."""
        wire, host = self._wire, self._wire.host
        return Statistics(
            commands=host.commands_sent,
            bytes_sent=wire.session.bytes_sent,
            bytes_received=wire.session.bytes_received,
            distance_mm=wire.where.distance_mm,
            window_bytes=wire.settings.max_unfenced,
            fences=host.fences_sent,
            fences_lost=host.fences_lost,
            retries=host.retries,
            resynchronisations=host.attentions,
            corrections=wire.where.corrections,
            malformed_replies=host.malformed,
            unexpected_replies=host.unexpected,
            skipped_bytes=host.skipped_bytes,
            round_trip_median_s=host.round_trips.median_s,
            round_trip_max_s=host.round_trips.longest_s,
            reconnections=wire.session.reconnections,
            seconds=wire.link.now() - wire.started,
        )

    async def reported_pose(self) -> Pose:
        """Where the robot itself says it is, when every motion is done.

        Raises ``NotSupportedError`` for a robot without group Q.
        """
        await self._wire.ready()
        self._wire.need("Q", "answers no queries")
        return await self._wire.reported_pose()

    async def ask(self, query: LogoCommand) -> RobotMessage:
        """Send any query of the protocol; its answer. Raises ``NotSupportedError`` without group Q."""
        await self._wire.ready()
        self._wire.need("Q", "answers no queries")
        return await self._wire.ask(query)

    # ------------------------------------------------------------------ motion

    async def forward(self, distance_mm: float) -> None:
        """Drive straight ahead; backwards when negative."""
        check("distance_mm", distance_mm)
        await self._wire.ready()
        self._wire.drive(self._wire.where.position.move(distance_mm))
        await self._accepted()

    async def right(self, angle_deg: float) -> None:
        """Turn clockwise on the spot; counter-clockwise when negative."""
        check("angle_deg", angle_deg)
        await self._wire.ready()
        self._wire.drive(self._wire.where.position.turn(angle_deg))
        await self._accepted()

    async def set_position(self, x_mm: float, y_mm: float) -> None:
        """Go straight to a point and keep the heading."""
        check("x_mm", x_mm)
        check("y_mm", y_mm)
        await self._wire.ready()
        if not await self._absolute.go_to(x_mm, y_mm):
            self._wire.drive(self._wire.where.position.go_to(x_mm, y_mm))
        await self._accepted()

    async def set_heading(self, heading_deg: float) -> None:
        """Turn, the shorter way, to an absolute heading."""
        check("heading_deg", heading_deg)
        await self._wire.ready()
        position = self._wire.where.position
        before = position.robot
        if position.set_heading(heading_deg):
            after, position.robot = position.robot, before
            if not await self._absolute.turn_to(after):
                self._wire.drive(position.align())
        await self._accepted()

    async def home(self) -> None:
        """Go to the origin and look up."""
        await self._wire.ready()
        if await self._absolute.go_home():
            await self._accepted()
        else:
            await super().home()

    # ------------------------------------------------------------------ by hand

    async def drive(self, speed: float, turn: float, *, valid_s: float | None = None) -> None:
        """Go on so until told otherwise, in direct control: see ``Drive.drive``.

        The robot moves or turns, whichever is more; what it does already is not begun anew. Where it got, it is asked
        by the next command of the turtle.
        """
        await self._by_hand.drive(speed, turn, valid_s)

    async def hold(self, speed: int, seconds: float, *, turning: bool = False) -> None:
        """Drive ahead, or turn clockwise, for a time, in direct control: the motion that calibration measures.

        ``speed`` is 1..255 units (W14), or below 0 for the other way round; ``seconds`` above 0, at most 60, and
        counted from when the robot has heard it. Raises ``MessageError`` for a number outside.
        """
        await self._by_hand.hold(speed, seconds, turning=turning)

    async def press(self, *keys: DirectKey) -> None:
        """Press keys of direct control. The next command of the turtle stops the robot and changes to Logo control."""
        await self._by_hand.press(*keys)

    async def send(self, *messages: AnyMessage, valid_s: float | None = None) -> None:
        """Send commands and keys as they are, see ``AsyncRobot.send``; of a query, the answer has come, too.

        Arguments may have the bytes 0D and 0A, which the driver avoids otherwise (W8). Where a command of group C led,
        the robot is asked. Raises ``UsageError`` for what changes between Logo control and direct control.
        """
        check_valid_s(valid_s)
        for message in [self._by_message.checked(message) for message in messages]:
            await self._by_message.send(message, valid_s)

    @property
    def features(self) -> frozenset[str]:
        """What else the robot has, as far as is known: a pen, limit sensors; by its groups (W10), a horn and a lamp."""
        return frozenset(
            {"pen", "limits"}
            | {name for group, name in (("H", "horn"), ("E", "lamp")) if group in self.groups}
        )

    # ------------------------------------------------------------------ pen, screen, speed, horn, lamp

    async def _set_pen(self, *, down: bool) -> None:
        await self._wire.ready()
        self._wire.set_pen(down=down)
        await self._accepted()

    async def set_speed(self, speed: int) -> None:
        """Set the speed of moves and turns, 1..255."""
        check_speed(speed)
        command = SetSpeed(speed).check()
        await self._wire.ready()
        self._wire.speed = speed
        self._wire.submit(command, 0.0)
        await self._accepted()

    async def horn(self, tone: str) -> None:
        """Sound the horn: off, low or high."""
        check_tone(tone)
        await self._wire.ready()
        self._wire.need("H", "has no horn")
        self._wire.submit(HORNS[tone](), 0.0)
        await self._accepted()

    async def lamp(self, on: bool) -> None:
        """Switch the lamp."""
        await self._wire.ready()
        self._wire.need("E", "has no lamp")
        self._wire.submit(LampOn() if on else LampOff(), 0.0)
        await self._accepted()

    # ------------------------------------------------------------------ time

    async def wait(self, seconds: float) -> None:
        """Let the motion end, then let this much of the robot's time pass."""
        check("seconds", seconds)
        await self.finish()
        await self._wire.until(lambda: False, self._wire.link.now() + max(0.0, seconds))

    async def finish(self) -> None:
        """Wait until every motion is done, and the robot looks where the turtle looks."""
        await self._wire.ready()
        self._wire.drive(self._wire.where.position.align())
        await self._wire.finish(verify=True)

    def _stop(self) -> None:
        self._wire.stop()

    async def set_step_by_step(self, on: bool) -> None:
        """Whether each motion ends before its method returns."""
        self._step_by_step = on

    async def _accepted(self) -> None:
        if self._step_by_step:
            await self._wire.finish()
        else:
            await self._wire.until(lambda: self._wire.host.unsent == 0)
