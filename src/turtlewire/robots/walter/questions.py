"""What a WALTER is asked, and what its answers say of its pose."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.robots.walter.whereabouts import UNIT_MM
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from turtlewire.protocols.walter.messages import RobotMessage


class Question:
    """A query whose answer somebody waits for; the tag of its command.

    Attributes:
        reply: the answer, when it has come.
        lost: there will be none.
    """

    reply: RobotMessage | None = None
    lost = False

    def is_settled(self) -> bool:
        """Whether there is an answer, or there will be none."""
        return self.lost or self.reply is not None


def reported(location: RobotMessage, heading: RobotMessage) -> Pose:
    """The pose, in the robot's own coordinates, that a ``LocationReply`` and a ``HeadingReply`` tell."""
    x, y = location.values()
    (degrees,) = heading.values()
    return Pose(x * UNIT_MM, y * UNIT_MM, float(degrees))
