"""The Logo vocabulary and ``Drive`` by timed motions: what the drivers of such robots share."""

from __future__ import annotations

import contextlib
import math
from abc import abstractmethod
from typing import TYPE_CHECKING

from turtlewire.errors import LinkLostError, MessageError, NotSupportedError
from turtlewire.robots.timed.motions import EventT, TimedMotions
from turtlewire.robots.timed.reckoning import LEAST_MOVE_MM
from turtlewire.turtle import HOME, TONES, Pose, arc_polygon, arc_tangent, wrapped

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from types import TracebackType
    from typing import Self

    from turtlewire.links.link import Link
    from turtlewire.robots.timed.motions import SetPointHost
    from turtlewire.trace import Obstacle, Paper, Trace

# What one command may ask for: a kilometre, or a million degrees or seconds.
LARGEST = 1e6
FULL_SPEED = 255
# A motion is slowed down so that it takes at least so long: the wire and the clock are not exact.
LEAST_HOLD_S = 0.1
# By hand, no motion is held for longer than this.
LONGEST_HOLD_S = 60.0


class AsyncTimedRobot(TimedMotions[EventT]):
    """A robot driven by set-points, as a turtle and by hand. Each kind says how it turns, moves and lifts its pen.

    The methods are those of ``turtlewire.turtle.Turtle`` and ``turtlewire.drive.Drive``, which say what they do. Every
    motion ends before its method returns: this host is the clock by which the robot moves. A turn is made together with
    the next move, or by ``finish``: turns that follow one another are one. Each method may raise ``LinkError`` when
    the link ends, and ``StoppedError`` when ``stop`` or ``drive`` is called meanwhile.
    """

    def __init__(
        self,
        link: Link,
        host: SetPointHost[EventT],
        notify: Callable[[str], None],
        paper: Paper | None,
        *,
        baud: int,
        stop_size: int,
        speed: int,
        tolerance_mm: float,
        worth_deg: float,
        settle_s: float,
        overrun_s: float,
    ) -> None:
        super().__init__(
            link,
            host,
            notify,
            baud=baud,
            stop_size=stop_size,
            settle_s=settle_s,
            overrun_s=overrun_s,
        )
        self._paper = paper
        self._speed = speed
        self._tolerance_mm = tolerance_mm
        self._worth_deg = worth_deg
        self._step_by_step = False

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        await self.close(finish=kind is None)

    async def close(self, *, finish: bool = True) -> None:
        """Stop the robot and let go of it: after the motion is done, or with ``finish=False`` at once."""
        try:
            if finish and not self.is_over and not self._is_driven:
                await self.finish()
        finally:
            await self.let_go(self._last_bytes_s)

    # ------------------------------------------------------------------ what each robot does its own way

    @property
    @abstractmethod
    def _last_bytes_s(self) -> float:
        """How long the bytes of an emergency stop take."""

    @abstractmethod
    async def _turn_robot(self, angle_deg: float) -> None:
        """Turn the robot clockwise, as the turtle has turned already."""

    @abstractmethod
    async def _move_robot(self, distance_mm: float) -> None:
        """Drive the robot straight; backwards when negative."""

    @abstractmethod
    async def _move_pen(self, *, down: bool) -> None:
        """Lift or lower the pen, if the robot has one."""

    @abstractmethod
    async def drive(self, speed: float, turn: float, *, valid_s: float | None = None) -> None:
        """Go on so until told otherwise: see ``Drive.drive``."""

    @property
    @abstractmethod
    def features(self) -> frozenset[str]:
        """What else the robot has: see ``Drive``."""

    # ------------------------------------------------------------------ what is known

    @property
    def pose(self) -> Pose:
        """Where the exact turtle is; while the robot is driven by hand, where that is by reckoning."""
        return self.account.at(self.link.now()) if self._is_driven else self.account.exact

    @property
    def reckoned_pose(self) -> Pose:
        """Where the robot itself is by reckoning: off from ``pose`` by what its next moves will make good."""
        return self.account.at(self.link.now())

    @property
    def is_pen_down(self) -> bool:
        """Whether the pen is down."""
        return self.account.pen_down

    @property
    def trace(self) -> Trace:
        """What the robot drew, where that can be seen (a simulated robot); else the way that it went by reckoning."""
        return self.account.trace if self._paper is None else self._paper.trace

    @property
    def obstacles(self) -> Sequence[Obstacle]:
        """What stands around the robot, where that can be seen (a simulated robot)."""
        return () if self._paper is None else self._paper.obstacles

    def towards(self, x_mm: float, y_mm: float) -> float:
        """The heading that looks at a point."""
        return self.pose.bearing_to(x_mm, y_mm)

    # ------------------------------------------------------------------ motion

    async def forward(self, distance_mm: float) -> None:
        """Drive straight ahead; backwards when negative."""
        check("distance_mm", distance_mm)
        await self._turtle_ready()
        self.account.exact = self.account.exact.moved(distance_mm)
        await self._approach()

    async def back(self, distance_mm: float) -> None:
        """Drive straight backwards; ahead when negative."""
        await self.forward(-distance_mm)

    async def right(self, angle_deg: float) -> None:
        """Turn clockwise on the spot; counter-clockwise when negative. Whole turns are made."""
        check("angle_deg", angle_deg)
        await self._turtle_ready()
        self.account.turn(angle_deg)
        if self._step_by_step:
            await self._align()

    async def left(self, angle_deg: float) -> None:
        """Turn counter-clockwise on the spot; clockwise when negative."""
        await self.right(-angle_deg)

    async def set_position(self, x_mm: float, y_mm: float) -> None:
        """Go straight to a point and keep the heading."""
        check("x_mm", x_mm)
        check("y_mm", y_mm)
        await self._turtle_ready()
        self.account.exact = Pose(x_mm, y_mm, self.account.exact.heading_deg)
        await self._approach()
        if self._step_by_step:
            await self._align()

    async def set_x(self, x_mm: float) -> None:
        """Go to an x coordinate, along a line parallel to the x axis."""
        await self.set_position(x_mm, self.pose.y_mm)

    async def set_y(self, y_mm: float) -> None:
        """Go to a y coordinate, along a line parallel to the y axis."""
        await self.set_position(self.pose.x_mm, y_mm)

    async def set_heading(self, heading_deg: float) -> None:
        """Turn, the shorter way, to an absolute heading."""
        check("heading_deg", heading_deg)
        await self._turtle_ready()
        await self.right(wrapped(heading_deg - self.account.exact.heading_deg))

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

    async def _turtle_ready(self) -> None:
        await self._ready()
        await self._take_over()

    async def _approach(self) -> None:
        """Bring the robot to where the turtle is."""
        account = self.account
        with self._or_settled():
            turn_deg = account.aim(self._tolerance_mm)
            distance_mm = account.robot.distance_to(account.exact.x_mm, account.exact.y_mm)
            if distance_mm < LEAST_MOVE_MM:
                return
            # A little that the last turn was off by is not worth a turn of its own.
            aside_mm = distance_mm * abs(math.sin(math.radians(turn_deg)))
            if abs(turn_deg) > self._worth_deg or aside_mm > self._tolerance_mm:
                await self._turn_robot(turn_deg)
            if abs(account.ahead_mm) >= LEAST_MOVE_MM:
                await self._move_robot(account.ahead_mm)

    async def _align(self) -> None:
        """Turn the robot to where the turtle looks."""
        if abs(self.account.owed_deg) > self._worth_deg:
            with self._or_settled():
                await self._turn_robot(self.account.owed_deg)

    @contextlib.contextmanager
    def _or_settled(self) -> Iterator[None]:
        """Whatever ends a motion before its time, the turtle is where the robot is then."""
        try:
            yield
        except BaseException:
            self.account.settle()
            raise

    def _fitting(self, amount: float, full_per_s: float) -> float:
        """A speed for so much: that which was set, but slow enough for ``LEAST_HOLD_S``."""
        return min(full_per_s * self._speed / FULL_SPEED, abs(amount) / LEAST_HOLD_S)

    # ------------------------------------------------------------------ pen, screen, speed, horn, lamp

    async def pen_up(self) -> None:
        """Lift the pen."""
        await self._set_pen(down=False)

    async def pen_down(self) -> None:
        """Lower the pen."""
        await self._set_pen(down=True)

    async def _set_pen(self, *, down: bool) -> None:
        await self._turtle_ready()
        if down != self.account.pen_down:
            await self._move_pen(down=down)
            self.account.pen_down = down

    async def clean(self) -> None:
        """Start a new sheet: forget the trace, when every motion is done."""
        await self.finish()
        self.account.trace.clear()
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
        """Set the speed of moves and turns, 1..255; 255 is as fast as the robot can."""
        check_speed(speed)
        await self._ready()
        self._speed = speed

    async def horn(self, tone: str) -> None:
        """Sound the horn: off, low or high. Raises ``NotSupportedError`` for a robot without one."""
        if tone not in TONES:
            raise MessageError(f"there is no horn tone {tone!r}: the tones are {', '.join(TONES)}")
        await self._ready()
        raise NotSupportedError(f"the robot at {self.link.url} has no horn")

    async def lamp(self, on: bool) -> None:
        """Switch the lamp. Raises ``NotSupportedError`` for a robot without one."""
        await self._ready()
        raise NotSupportedError(f"the robot at {self.link.url} has no lamp to switch {'on' if on else 'off'}")

    # ------------------------------------------------------------------ time

    async def wait(self, seconds: float) -> None:
        """Let the motion end, then let this much of the robot's time pass."""
        check("seconds", seconds)
        await self.finish()
        await self._pause(seconds)

    async def finish(self) -> None:
        """Wait until every motion is done, and the robot looks where the turtle looks."""
        await self._turtle_ready()
        await self._align()
        await self._until(lambda: self._machine.idle)

    async def stop(self) -> None:
        """Stop at once, ahead of everything, and forget every motion not yet done.

        Afterwards the turtle is where the robot stopped; the next command moves on from there. A robot that cannot be
        reached now is stopped when it is.
        """
        if self.link_state != "reconnecting":
            with contextlib.suppress(LinkLostError):
                self.abandon()

    async def set_step_by_step(self, on: bool) -> None:
        """Whether turns are made at once, too: each motion ends before its method returns."""
        self._step_by_step = on
        if on:
            await self.finish()


def check(name: str, value: float) -> None:
    """Raises ``MessageError`` for what no command may ask for."""
    # Not math.isfinite: an int may be larger than any float. Nor is nan between anything.
    if not -LARGEST <= value <= LARGEST:
        raise MessageError(f"{name} must be a number from {-LARGEST:.0f} to {LARGEST:.0f}")


def check_hold(seconds: float, settle_s: float | None) -> None:
    """Raises ``MessageError`` for times that no motion is to be held for, or waited for."""
    if not 0.0 < seconds <= LONGEST_HOLD_S:
        raise MessageError(f"seconds is {seconds}, but must be above 0, and at most {LONGEST_HOLD_S:g}")
    if settle_s is not None and not 0.0 <= settle_s <= LONGEST_HOLD_S:
        raise MessageError(f"settle_s is {settle_s}, but must be from 0 to {LONGEST_HOLD_S:g}, or None")


def check_valid_s(valid_s: float | None) -> None:
    """Raises ``MessageError`` for a time to live that is none."""
    if valid_s is not None and not 0.0 < valid_s < math.inf:
        raise MessageError(f"valid_s is {valid_s}, but must be above 0 seconds, or None")


def check_speed(speed: int) -> None:
    """Raises ``MessageError`` for a speed at which nothing ever arrives."""
    if not 1 <= speed <= FULL_SPEED:
        raise MessageError(
            f"speed is {speed}, but must be from 1 to {FULL_SPEED}: at 0 the robot would never arrive"
        )
