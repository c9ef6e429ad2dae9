"""The Logo vocabulary and ``Drive`` by timed motions: what the drivers of such robots share."""

from __future__ import annotations

import contextlib
import math
from abc import abstractmethod
from typing import TYPE_CHECKING

from turtlewire.errors import NotSupportedError
from turtlewire.robots.asynchronous import AsyncRobot
from turtlewire.robots.checks import FULL_SPEED, check, check_speed, check_tone
from turtlewire.robots.timed.motions import EventT, TimedMotions
from turtlewire.robots.timed.reckoning import LEAST_MOVE_MM
from turtlewire.turtle import Pose, wrapped

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from turtlewire.links.link import Link
    from turtlewire.robots.paper import Paper
    from turtlewire.robots.timed.motions import SetPointHost
    from turtlewire.trace import Trace

# A motion is slowed down so that it takes at least so long: the wire and the clock are not exact.
LEAST_HOLD_S = 0.1


class AsyncTimedRobot(TimedMotions[EventT], AsyncRobot):
    """A robot driven by set-points, as a turtle and by hand. Each kind says how it turns, moves and lifts its pen.

    Every motion ends before its method returns: this host is the clock by which the robot moves. A turn is made
    together with the next move, or by ``finish``: turns that follow one another are one. Each method may raise
    ``LinkError`` when the link ends, and ``StoppedError`` when ``stop`` or ``drive`` is called meanwhile.
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

    @property
    def _way(self) -> Trace:
        return self.account.trace

    async def close(self, *, finish: bool = True) -> None:
        """Stop the robot and let go of it: after the motion is done, or with ``finish=False`` at once."""
        try:
            if finish and not self.is_over and not self._is_driven:
                self._stops_told.known()  # there is nothing to finish of what was stopped
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

    # ------------------------------------------------------------------ motion

    async def forward(self, distance_mm: float) -> None:
        """Drive straight ahead; backwards when negative."""
        check("distance_mm", distance_mm)
        await self._turtle_ready()
        self.account.exact = self.account.exact.moved(distance_mm)
        await self._approach()

    async def right(self, angle_deg: float) -> None:
        """Turn clockwise on the spot; counter-clockwise when negative. Whole turns are made."""
        check("angle_deg", angle_deg)
        await self._turtle_ready()
        self.account.turn(angle_deg)
        if self._step_by_step:
            await self._align()

    async def set_position(self, x_mm: float, y_mm: float) -> None:
        """Go straight to a point and keep the heading."""
        check("x_mm", x_mm)
        check("y_mm", y_mm)
        await self._turtle_ready()
        self.account.exact = Pose(x_mm, y_mm, self.account.exact.heading_deg)
        await self._approach()
        if self._step_by_step:
            await self._align()

    async def set_heading(self, heading_deg: float) -> None:
        """Turn, the shorter way, to an absolute heading."""
        check("heading_deg", heading_deg)
        await self._turtle_ready()
        await self.right(wrapped(heading_deg - self.account.exact.heading_deg))

    async def _turtle_ready(self) -> None:
        self._stops_told.check()
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

    async def _set_pen(self, *, down: bool) -> None:
        await self._turtle_ready()
        if down != self.account.pen_down:
            await self._move_pen(down=down)
            self.account.pen_down = down

    async def set_speed(self, speed: int) -> None:
        """Set the speed of moves and turns, 1..255; 255 is as fast as the robot can."""
        check_speed(speed)
        await self._ready()
        self._speed = speed

    async def horn(self, tone: str) -> None:
        """Sound the horn: off, low or high. Raises ``NotSupportedError`` for a robot without one."""
        check_tone(tone)
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

    def _stop(self) -> None:
        self.abandon()

    async def set_step_by_step(self, on: bool) -> None:
        """Whether turns are made at once, too: each motion ends before its method returns."""
        self._step_by_step = on
        if on:
            await self.finish()
