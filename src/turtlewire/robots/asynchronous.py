"""What every asynchronous driver has: the words of a turtle that follow from others, its sheet, and its link."""

from __future__ import annotations

import contextlib
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

from turtlewire.errors import LinkLostError
from turtlewire.robots.checks import check
from turtlewire.turtle import HOME, Pose, arc_polygon, arc_tangent

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import TracebackType
    from typing import Self

    from turtlewire.protocols.message import AnyMessage
    from turtlewire.robots.paper import Paper
    from turtlewire.robots.reconnecting import LinkState
    from turtlewire.robots.session import Session
    from turtlewire.robots.stops import Stops
    from turtlewire.trace import Obstacle, Trace


class AsyncRobot(ABC):
    """A robot, driven asynchronously; an async context manager.

    The methods are those of ``turtlewire.turtle.Turtle`` and ``turtlewire.drive.Drive``, which say what they do.
    """

    _session: Session[Any]
    _stops_told: Stops
    _paper: Paper | None  # what it draws on, where that can be seen

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        await self.close(finish=kind is None)

    @abstractmethod
    async def close(self, *, finish: bool = True) -> None:
        """Stop the robot and let go of it: after the motion is done, or with ``finish=False`` at once."""

    # ------------------------------------------------------------------ the link

    @property
    def link_state(self) -> LinkState:
        """How the link is: connected, or, after it was lost, reconnecting, stopped (until ``resume``) or closed."""
        return self._session.state

    async def reconnected(self, timeout_s: float | None = None) -> None:
        """Wait until a robot whose link was lost is reached again, and stopped; not at all if it was not lost.

        Raises ``LinkLostError`` after a timeout, in seconds, ``LinkClosedError`` when it was given up or closed.
        """
        await self._session.reached(timeout_s)

    @abstractmethod
    async def resume(self) -> None:
        """Let motion go on after the link was lost and the robot was reached again; nothing to do otherwise.

        Nothing that was under way is sent again (W15, S8). Raises ``LinkLostError`` while it is not reached yet.
        """

    async def stop(self) -> None:
        """Stop at once, ahead of everything, and forget every motion not yet done.

        Afterwards the turtle is where the robot stopped; the next command moves on from there. Of another task, or
        thread, that was using the robot, the next command raises ``StoppedError``, once. A robot that cannot be reached
        now is stopped when it is.
        """
        self._stops_told.add()
        if self.link_state != "reconnecting":
            with contextlib.suppress(LinkLostError):
                self._stop()

    @abstractmethod
    def _stop(self) -> None:
        """Send the stop. Raises ``LinkError``."""

    # ------------------------------------------------------------------ what is known

    @property
    @abstractmethod
    def pose(self) -> Pose:
        """Where the exact turtle is; while the robot is driven by hand, where that is by reckoning."""

    @property
    @abstractmethod
    def is_pen_down(self) -> bool:
        """Whether the pen is down."""

    @property
    @abstractmethod
    def features(self) -> frozenset[str]:
        """What else the robot has: see ``Drive``."""

    @property
    @abstractmethod
    def _way(self) -> Trace:
        """The way that the robot is known to have gone."""

    @property
    def trace(self) -> Trace:
        """What the robot drew, where that can be seen (a simulated robot); else the way that it is known to have gone.

        What was sent and is not confirmed yet is not in the latter.
        """
        return self._way if self._paper is None else self._paper.trace

    @property
    def obstacles(self) -> Sequence[Obstacle]:
        """What stands around the robot, where that can be seen (a simulated robot)."""
        return () if self._paper is None else self._paper.obstacles

    def towards(self, x_mm: float, y_mm: float) -> float:
        """The heading that looks at a point."""
        return self.pose.bearing_to(x_mm, y_mm)

    # ------------------------------------------------------------------ motion

    @abstractmethod
    async def forward(self, distance_mm: float) -> None:
        """Drive straight ahead; backwards when negative."""

    async def back(self, distance_mm: float) -> None:
        """Drive straight backwards; ahead when negative."""
        await self.forward(-distance_mm)

    @abstractmethod
    async def right(self, angle_deg: float) -> None:
        """Turn clockwise on the spot; counter-clockwise when negative. Whole turns are made."""

    async def left(self, angle_deg: float) -> None:
        """Turn counter-clockwise on the spot; clockwise when negative."""
        await self.right(-angle_deg)

    @abstractmethod
    async def set_position(self, x_mm: float, y_mm: float) -> None:
        """Go straight to a point and keep the heading."""

    async def set_x(self, x_mm: float) -> None:
        """Go to an x coordinate, along a line parallel to the x axis."""
        await self.set_position(x_mm, self.pose.y_mm)

    async def set_y(self, y_mm: float) -> None:
        """Go to a y coordinate, along a line parallel to the y axis."""
        await self.set_position(self.pose.x_mm, y_mm)

    @abstractmethod
    async def set_heading(self, heading_deg: float) -> None:
        """Turn, the shorter way, to an absolute heading."""

    async def home(self) -> None:
        """Go to the origin and look up."""
        await self.set_position(0.0, 0.0)
        await self.set_heading(0.0)

    async def arc(self, angle_deg: float, radius_mm: float) -> None:
        """Draw a part of a circle around the turtle, starting at its heading; it ends where it was."""
        check("angle_deg", angle_deg)
        check("radius_mm", radius_mm)
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

    @abstractmethod
    async def drive(self, speed: float, turn: float, *, valid_s: float | None = None) -> None:
        """Go on so until told otherwise: see ``Drive.drive``."""

    @abstractmethod
    async def send(self, *messages: AnyMessage, valid_s: float | None = None) -> None:
        """Send messages of the protocol as somebody wrote them; the driver keeps account of what they do.

        Returns when they are on their way, or, of those that are answered, when they are. ``valid_s``: what goes on
        until told otherwise is stopped when nothing newer has come for so long; None: it goes on.

        Raises ``MessageError``, before any byte leaves, for what is no message to this robot or has a field out of
        range, ``UsageError`` for one that would take the robot out of the driver's hands, and ``NotSupportedError``
        for one that this robot lacks.
        """

    # ------------------------------------------------------------------ pen, screen, speed, horn, lamp

    async def pen_up(self) -> None:
        """Lift the pen."""
        await self._set_pen(down=False)

    async def pen_down(self) -> None:
        """Lower the pen."""
        await self._set_pen(down=True)

    @abstractmethod
    async def _set_pen(self, *, down: bool) -> None:
        """Lift or lower the pen, if it is not so already."""

    async def clean(self) -> None:
        """Start a new sheet: forget the trace, when every motion is done."""
        await self.finish()
        self._way.clear()
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

    @abstractmethod
    async def set_speed(self, speed: int) -> None:
        """Set the speed of moves and turns, 1..255. Raises ``MessageError`` for a number outside."""

    @abstractmethod
    async def horn(self, tone: str) -> None:
        """Sound the horn: off, low or high. Raises ``NotSupportedError`` for a robot without one."""

    @abstractmethod
    async def lamp(self, on: bool) -> None:
        """Switch the lamp. Raises ``NotSupportedError`` for a robot without one."""

    # ------------------------------------------------------------------ time

    @abstractmethod
    async def wait(self, seconds: float) -> None:
        """Let the motion end, then let this much of the robot's time pass."""

    @abstractmethod
    async def finish(self) -> None:
        """Wait until every motion is done, and the robot looks where the turtle looks."""

    @abstractmethod
    async def set_step_by_step(self, on: bool) -> None:
        """Whether each motion ends before its method returns."""
