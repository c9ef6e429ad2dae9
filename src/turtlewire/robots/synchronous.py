"""Robots for people who do not write asynchronous programs: the same names, one implementation."""

from __future__ import annotations

import threading
import weakref
from typing import TYPE_CHECKING, Generic, TypeVar

from turtlewire.drive import Drive
from turtlewire.robots.asynchronous import AsyncRobot
from turtlewire.turtle import Pose, Turtle

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import TracebackType
    from typing import Self

    from turtlewire.protocols.message import AnyMessage
    from turtlewire.robots.reconnecting import LinkState
    from turtlewire.robots.runner import Runner
    from turtlewire.trace import Obstacle, Trace

RobotT = TypeVar("RobotT", bound=AsyncRobot)


class SynchronousRobot(Turtle, Drive, Generic[RobotT]):
    """A robot as a turtle and by hand; a context manager.

    Leaving the ``with`` block waits until the motion is done and stops the robot; an error in it stops it at once. So
    do the end of the interpreter and the loss of the last reference. ``stop`` may be called from any thread.

    The methods do what ``Turtle`` and ``Drive`` say, and raise what the asynchronous robot says.
    """

    def __init__(self, robot: RobotT, runner: Runner) -> None:
        self._robot = robot
        self._runner = runner
        # Also runs when the interpreter ends; must not know this object, or it would never be lost.
        self._finalizer = weakref.finalize(self, _let_go, robot, runner)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close(finish=kind is None)

    def close(self, *, finish: bool = True) -> None:
        """Stop the robot and let go of it: after the motion is done, or with ``finish=False`` at once."""
        if not self._finalizer.alive:
            return
        try:
            if finish:
                self._runner.run(self._robot.close())
        finally:
            self._finalizer()

    # ------------------------------------------------------------------ the link

    @property
    def link_state(self) -> LinkState:
        """How the link is: connected, or, after it was lost, reconnecting, stopped (until ``resume``) or closed."""
        return self._robot.link_state

    def reconnected(self, timeout_s: float | None = None) -> None:
        """Wait until a robot whose link was lost is reached again, and stopped; not at all if it was not lost."""
        self._runner.run(self._robot.reconnected(timeout_s))

    def resume(self) -> None:
        """Let motion go on after the link was lost and the robot was reached again."""
        self._runner.run(self._robot.resume())

    def stop(self) -> None:
        """Stop at once, ahead of everything, and forget every motion not yet done."""
        self._runner.run(self._robot.stop())

    # ------------------------------------------------------------------ what is known

    @property
    def pose(self) -> Pose:
        """Where the exact turtle is; while the robot is driven by hand, where that is by reckoning."""
        return self._robot.pose

    @property
    def is_pen_down(self) -> bool:
        """Whether the pen is down."""
        return self._robot.is_pen_down

    @property
    def features(self) -> frozenset[str]:
        """What else the robot has: see ``Drive``."""
        return self._robot.features

    @property
    def trace(self) -> Trace:
        """What the robot drew, where that can be seen; else the way that it is known to have gone."""
        return self._robot.trace

    @property
    def obstacles(self) -> Sequence[Obstacle]:
        """What stands around the robot, where that can be seen."""
        return self._robot.obstacles

    # ------------------------------------------------------------------ motion

    def forward(self, distance_mm: float) -> None:
        """Drive straight ahead; backwards when negative."""
        self._runner.run(self._robot.forward(distance_mm))

    def right(self, angle_deg: float) -> None:
        """Turn clockwise; counter-clockwise when negative."""
        self._runner.run(self._robot.right(angle_deg))

    def set_position(self, x_mm: float, y_mm: float) -> None:
        """Go straight to a point and keep the heading."""
        self._runner.run(self._robot.set_position(x_mm, y_mm))

    def set_heading(self, heading_deg: float) -> None:
        """Turn, the shorter way, to an absolute heading."""
        self._runner.run(self._robot.set_heading(heading_deg))

    def home(self) -> None:
        """Go to the origin and look up."""
        self._runner.run(self._robot.home())

    def arc(self, angle_deg: float, radius_mm: float) -> None:
        """Draw a part of a circle around the turtle."""
        self._runner.run(self._robot.arc(angle_deg, radius_mm))

    def drive(self, speed: float, turn: float, *, valid_s: float | None = None) -> None:
        """Go on so until told otherwise: see ``Drive.drive``."""
        self._runner.run(self._robot.drive(speed, turn, valid_s=valid_s))

    def send(self, *messages: AnyMessage, valid_s: float | None = None) -> None:
        """Send messages of the protocol as somebody wrote them; the driver keeps account of what they do.

        See ``AsyncRobot.send`` for what they may be; those of frame go out in one frame if they fit (F9).
        """
        self._runner.run(self._robot.send(*messages, valid_s=valid_s))

    # ------------------------------------------------------------------ pen, screen, speed, horn, lamp

    def pen_up(self) -> None:
        """Lift the pen."""
        self._runner.run(self._robot.pen_up())

    def pen_down(self) -> None:
        """Lower the pen."""
        self._runner.run(self._robot.pen_down())

    def clean(self) -> None:
        """Start a new sheet: forget the trace."""
        self._runner.run(self._robot.clean())

    def clear_screen(self) -> None:
        """``clean``, with the turtle home."""
        self._runner.run(self._robot.clear_screen())

    def set_speed(self, speed: int) -> None:
        """Set the speed of moves and turns, 1..255."""
        self._runner.run(self._robot.set_speed(speed))

    def horn(self, tone: str) -> None:
        """Sound the horn: off, low or high. Raises ``NotSupportedError`` for a robot without one."""
        self._runner.run(self._robot.horn(tone))

    def lamp(self, on: bool) -> None:
        """Switch the lamp. Raises ``NotSupportedError`` for a robot without one."""
        self._runner.run(self._robot.lamp(on))

    # ------------------------------------------------------------------ time

    def wait(self, seconds: float) -> None:
        """Let the motion end, then let this much of the robot's time pass."""
        self._runner.run(self._robot.wait(seconds))

    def finish(self) -> None:
        """Wait until every motion is done, and the robot looks where the turtle looks."""
        self._runner.run(self._robot.finish())

    def set_step_by_step(self, on: bool) -> None:
        """Whether each motion ends before its method returns."""
        self._runner.run(self._robot.set_step_by_step(on))


def _let_go(robot: AsyncRobot, runner: Runner) -> None:
    if runner.is_here:
        # The garbage collector calls in any thread: in this one it would wait for itself.
        threading.Thread(target=_let_go, args=(robot, runner)).start()
        return
    try:
        runner.run(robot.close(finish=False))
    finally:
        runner.close()
