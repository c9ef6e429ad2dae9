"""WALTER as a turtle: the Logo vocabulary by the commands that this robot has (W9..W12)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.errors import MessageError, NotSupportedError
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
from turtlewire.robots.walter.absolute import AbsoluteMoves
from turtlewire.robots.walter.by_hand import ByHand
from turtlewire.robots.walter.connection import Connection
from turtlewire.robots.walter.settings import DEFAULTS, Settings, Statistics
from turtlewire.turtle import HOME, TONES, Pose, arc_polygon, arc_tangent

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from types import TracebackType
    from typing import Self

    from turtlewire.links.link import Link
    from turtlewire.robots.reconnecting import LinkState
    from turtlewire.trace import Obstacle, Paper, Trace

# What one command may ask for: a kilometre, or a million degrees or seconds. A robot is not meant to go on for days
# before the next command, nor the host to split a move into more commands than it has memory for.
LARGEST = 1e6
HORNS: dict[str, type[LogoCommand]] = dict(zip(TONES, (HornOff, HornLow, HornHigh), strict=True))


class AsyncWalter:
    """A WALTER, driven asynchronously. ``turtlewire.connect_async`` makes one; it is an async context manager.

    The methods are those of ``turtlewire.turtle.Turtle``, which says what they do. Each may raise ``LinkError`` when
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
        self._paper = paper
        self._step_by_step = False

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        await self.close(finish=kind is None)

    async def connect(self) -> None:
        """Get the robot's attention (W7), learn what it can (W10), and take its place as home.

        Raises ``NoReplyError`` if it answers rubbish, or nothing while ``require_replies`` is set.
        """
        await self._wire.connect()

    async def close(self, *, finish: bool = True) -> None:
        """Stop the robot and let go of it: after the motion is done, or with ``finish=False`` at once."""
        try:
            if finish and not self._wire.is_over:
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

    @property
    def link_state(self) -> LinkState:
        """How the link is: connected, or, after it was lost, reconnecting, stopped (until ``resume``) or closed."""
        return self._wire.session.state

    async def reconnected(self, timeout_s: float | None = None) -> None:
        """Wait until a robot whose link was lost is reached again, and stopped; not at all if it was not lost.

        Raises ``LinkLostError`` after a timeout, in seconds, ``LinkClosedError`` when it was given up or closed.
        """
        await self._wire.session.reached(timeout_s)

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
    def trace(self) -> Trace:
        """What the robot drew, where that can be seen; else the way that it is known to have gone.

        What was sent and is not confirmed yet is not in the latter.
        """
        return self._wire.where.trace if self._paper is None else self._paper.trace

    @property
    def obstacles(self) -> Sequence[Obstacle]:
        """What stands around the robot, where that can be seen (a simulated robot)."""
        return () if self._paper is None else self._paper.obstacles

    @property
    def statistics(self) -> Statistics:
        """Figures of this connection."""
        wire, host = self._wire, self._wire.host
        return Statistics(
            commands=host.commands_sent,
            bytes_sent=wire.session.bytes_sent,
            bytes_received=wire.session.bytes_received,
            distance_mm=wire.where.distance_mm,
            fences=host.fences_sent,
            fences_lost=host.fences_lost,
            corrections=wire.where.corrections,
            malformed_replies=host.malformed,
            unexpected_replies=host.unexpected,
            reconnections=wire.session.reconnections,
            seconds=wire.link.now() - wire.started,
        )

    def towards(self, x_mm: float, y_mm: float) -> float:
        """The heading that looks at a point."""
        return self.pose.bearing_to(x_mm, y_mm)

    async def reported_pose(self) -> Pose:
        """Where the robot itself says it is, when every motion is done.

        Raises ``NotSupportedError`` for a robot without group Q.
        """
        await self._wire.ready()
        self._need("Q", "answers no queries")
        return await self._wire.reported_pose()

    async def ask(self, query: LogoCommand) -> RobotMessage:
        """Send any query of the protocol; its answer. Raises ``NotSupportedError`` without group Q."""
        await self._wire.ready()
        self._need("Q", "answers no queries")
        return await self._wire.ask(query)

    # ------------------------------------------------------------------ motion

    async def forward(self, distance_mm: float) -> None:
        """Drive straight ahead; backwards when negative."""
        _check("distance_mm", distance_mm)
        await self._wire.ready()
        self._wire.drive(self._wire.where.position.move(distance_mm))
        await self._accepted()

    async def back(self, distance_mm: float) -> None:
        """Drive straight backwards; ahead when negative."""
        await self.forward(-distance_mm)

    async def right(self, angle_deg: float) -> None:
        """Turn clockwise on the spot; counter-clockwise when negative."""
        _check("angle_deg", angle_deg)
        await self._wire.ready()
        self._wire.drive(self._wire.where.position.turn(angle_deg))
        await self._accepted()

    async def left(self, angle_deg: float) -> None:
        """Turn counter-clockwise on the spot; clockwise when negative."""
        await self.right(-angle_deg)

    async def set_position(self, x_mm: float, y_mm: float) -> None:
        """Go straight to a point and keep the heading."""
        _check("x_mm", x_mm)
        _check("y_mm", y_mm)
        await self._wire.ready()
        if not await self._absolute.go_to(x_mm, y_mm):
            self._wire.drive(self._wire.where.position.go_to(x_mm, y_mm))
        await self._accepted()

    async def set_x(self, x_mm: float) -> None:
        """Go to an x coordinate, along a line parallel to the x axis."""
        await self.set_position(x_mm, self.pose.y_mm)

    async def set_y(self, y_mm: float) -> None:
        """Go to a y coordinate, along a line parallel to the y axis."""
        await self.set_position(self.pose.x_mm, y_mm)

    async def set_heading(self, heading_deg: float) -> None:
        """Turn, the shorter way, to an absolute heading."""
        _check("heading_deg", heading_deg)
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
            await self.set_position(0.0, 0.0)
            await self.set_heading(0.0)

    async def arc(self, angle_deg: float, radius_mm: float) -> None:
        """Draw a part of a circle around the turtle, starting at its heading; it ends where it was."""
        _check("angle_deg", angle_deg)
        _check("radius_mm", radius_mm)
        sides, chord_mm, turn_deg = arc_polygon(angle_deg, radius_mm)
        start, was_down = self.pose, self.is_pen_down
        if not sides:
            return
        await self.pen_up()
        await self.forward(radius_mm)
        await self.right(arc_tangent(angle_deg, radius_mm) + turn_deg / 2)
        if was_down:
            await self.pen_down()
        for _ in range(sides):
            await self.forward(chord_mm)
            await self.right(turn_deg)
        await self.pen_up()
        await self.set_position(start.x_mm, start.y_mm)
        await self.set_heading(start.heading_deg)
        if was_down:
            await self.pen_down()

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

    @property
    def features(self) -> frozenset[str]:
        """What else the robot has, as far as is known: a pen; by its groups (W10), a horn and a lamp."""
        return frozenset(
            {"pen"} | {name for group, name in (("H", "horn"), ("E", "lamp")) if group in self.groups}
        )

    # ------------------------------------------------------------------ pen, screen, speed, horn, lamp

    async def pen_up(self) -> None:
        """Lift the pen."""
        await self._pen(down=False)

    async def pen_down(self) -> None:
        """Lower the pen."""
        await self._pen(down=True)

    async def _pen(self, *, down: bool) -> None:
        await self._wire.ready()
        self._wire.set_pen(down=down)
        await self._accepted()

    async def clean(self) -> None:
        """Start a new sheet: forget the trace, when every motion is done."""
        await self.finish()
        self._wire.where.trace.clear()
        if self._paper is not None:
            self._paper.clear_trace()

    async def clear_screen(self) -> None:
        """``clean``, with the turtle home; it drives there with its pen up."""
        was_down = self.is_pen_down
        if self.pose != HOME:
            await self.pen_up()
            await self.home()
            if was_down:
                await self.pen_down()
        await self.clean()

    async def set_speed(self, speed: int) -> None:
        """Set the speed of moves and turns, 1..255."""
        _check("speed", speed)
        if not 1 <= speed <= 255:
            raise MessageError(
                f"speed is {speed}, but must be from 1 to 255: at 0 the robot would never arrive"
            )
        command = SetSpeed(speed).check()
        await self._wire.ready()
        self._wire.speed = speed
        self._wire.submit(command, 0.0)
        await self._accepted()

    async def horn(self, tone: str) -> None:
        """Sound the horn: off, low or high."""
        if tone not in HORNS:
            raise MessageError(f"there is no horn tone {tone!r}: the tones are {', '.join(TONES)}")
        await self._wire.ready()
        self._need("H", "has no horn")
        self._wire.submit(HORNS[tone](), 0.0)
        await self._accepted()

    async def lamp(self, on: bool) -> None:
        """Switch the lamp."""
        await self._wire.ready()
        self._need("E", "has no lamp")
        self._wire.submit(LampOn() if on else LampOff(), 0.0)
        await self._accepted()

    # ------------------------------------------------------------------ time

    async def wait(self, seconds: float) -> None:
        """Let the motion end, then let this much of the robot's time pass."""
        _check("seconds", seconds)
        await self.finish()
        await self._wire.until(lambda: False, self._wire.link.now() + max(0.0, seconds))

    async def finish(self) -> None:
        """Wait until every motion is done, and the robot looks where the turtle looks."""
        await self._wire.ready()
        self._wire.drive(self._wire.where.position.align())
        await self._wire.finish(verify=True)

    async def stop(self) -> None:
        """Stop at once, ahead of everything, and forget every motion not yet done (W8).

        Afterwards the turtle is where the robot stopped; the next command moves on from there.
        """
        self._wire.stop()

    async def set_step_by_step(self, on: bool) -> None:
        """Whether each motion ends before its method returns."""
        self._step_by_step = on

    async def _accepted(self) -> None:
        if self._step_by_step:
            await self._wire.finish()
        else:
            await self._wire.until(lambda: self._wire.host.unsent == 0)

    # ------------------------------------------------------------------ capability groups (W10)

    def _need(self, group: str, lack: str) -> None:
        if group not in self._wire.groups:
            raise NotSupportedError(f"the robot at {self._wire.link.url} {lack}")


def _check(name: str, value: float) -> None:
    # Not math.isfinite: an int may be larger than any float. Nor is nan between anything.
    if not -LARGEST <= value <= LARGEST:
        raise MessageError(f"{name} must be a number from {-LARGEST:.0f} to {LARGEST:.0f}")
