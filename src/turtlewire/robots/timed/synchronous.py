"""Such robots for people who do not write asynchronous programs: the same names, one implementation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

from turtlewire.robots.synchronous import SynchronousRobot
from turtlewire.robots.timed.driver import AsyncTimedRobot

if TYPE_CHECKING:
    from turtlewire.turtle import Pose

RobotT = TypeVar("RobotT", bound=AsyncTimedRobot[Any])


class TimedRobot(SynchronousRobot[RobotT]):
    """A robot driven by set-points, as a turtle and by hand; a context manager."""

    @property
    def reckoned_pose(self) -> Pose:
        """Where the robot itself is by reckoning: off from ``pose`` by what its next moves will make good."""
        return self._robot.reckoned_pose
