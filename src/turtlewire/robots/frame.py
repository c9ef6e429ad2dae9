"""Home is where the robot stood when the program began: between the turtle's coordinates and the robot's own."""

from __future__ import annotations

from turtlewire.turtle import Pose, direction


class Frame:
    """The turtle's coordinates, seen from the robot's.

    Args:
        origin: the pose that the robot reported when the turtle was at home.
    """

    def __init__(self, origin: Pose) -> None:
        self.origin = origin
        self._dx, self._dy = direction(origin.heading_deg)

    @classmethod
    def anew(cls, pose: Pose) -> Frame:
        """The frame of a robot that was switched on anew, with the turtle at a pose."""
        turned = Pose(heading_deg=-pose.heading_deg % 360.0)
        x, y, _ = cls(turned).to_robot(pose)
        return cls(turned._replace(x_mm=-x, y_mm=-y))

    def to_robot(self, pose: Pose) -> Pose:
        """A pose of the turtle, in the robot's coordinates."""
        return Pose(
            self.origin.x_mm + pose.x_mm * self._dy + pose.y_mm * self._dx,
            self.origin.y_mm - pose.x_mm * self._dx + pose.y_mm * self._dy,
            (pose.heading_deg + self.origin.heading_deg) % 360.0,
        )

    def from_robot(self, pose: Pose) -> Pose:
        """A pose in the robot's coordinates, in the turtle's."""
        x, y = pose.x_mm - self.origin.x_mm, pose.y_mm - self.origin.y_mm
        return Pose(
            x * self._dy - y * self._dx,
            x * self._dx + y * self._dy,
            (pose.heading_deg - self.origin.heading_deg) % 360.0,
        )
