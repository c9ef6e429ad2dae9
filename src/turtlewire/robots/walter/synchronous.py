"""WALTER for people who do not write asynchronous programs: the same names, one implementation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.robots.synchronous import SynchronousRobot
from turtlewire.robots.walter.driver import AsyncWalter

if TYPE_CHECKING:
    from turtlewire.protocols.walter.messages import DirectKey, LogoCommand, RobotMessage
    from turtlewire.robots.walter.settings import Statistics
    from turtlewire.turtle import Pose


class Walter(SynchronousRobot[AsyncWalter]):
    """A WALTER. ``turtlewire.connect`` makes one; it is a context manager, a ``Turtle`` and a ``Drive``.

    The methods do what ``Turtle`` and ``Drive`` say, and raise what ``AsyncWalter`` says.
    """

    @property
    def groups(self) -> frozenset[str]:
        """The capability groups (C, Q, H, E) that the robot has, as far as is known (W10)."""
        return self._robot.groups

    @property
    def statistics(self) -> Statistics:
        """Figures of this connection."""
        return self._robot.statistics

    def reported_pose(self) -> Pose:
        """Where the robot itself says it is. Raises ``NotSupportedError`` if it answers no queries."""
        return self._runner.run(self._robot.reported_pose())

    def ask(self, query: LogoCommand) -> RobotMessage:
        """Send any query of the protocol; its answer. Raises ``NotSupportedError`` if it answers none."""
        return self._runner.run(self._robot.ask(query))

    def hold(self, speed: int, seconds: float, *, turning: bool = False) -> None:
        """Drive ahead, or turn clockwise, for a time, in direct control."""
        self._runner.run(self._robot.hold(speed, seconds, turning=turning))

    def press(self, *keys: DirectKey) -> None:
        """Press keys of direct control. The next command of the turtle stops the robot and leaves it."""
        self._runner.run(self._robot.press(*keys))
