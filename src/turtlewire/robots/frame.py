"""Home is where the robot stood when the program began: between the turtle's coordinates and the robot's own."""

from __future__ import annotations

from turtlewire.turtle import Pose, direction


class Frame:
    """The turtle's coordinates, seen from the robot's.

    Args:
        origin: the pose that the robot reported when the turtle was at home.
        scale: how far the robot truly goes when it believes that it goes a millimetre.
    """

    def __init__(self, origin: Pose, scale: float = 1.0) -> None:
        self.origin = origin
        self._scale = scale
        self._dx, self._dy = direction(origin.heading_deg)

    @classmethod
    def matching(cls, pose: Pose, robot: Pose, scale: float = 1.0) -> Frame:
        """The frame in which a pose of the turtle is what the robot calls by another."""
        turned = Pose(heading_deg=(robot.heading_deg - pose.heading_deg) % 360.0)
        x, y, _ = cls(turned, scale).to_robot(pose)
        return cls(turned._replace(x_mm=robot.x_mm - x, y_mm=robot.y_mm - y), scale)

    def to_robot(self, pose: Pose) -> Pose:
        """A pose of the turtle, in the robot's coordinates."""
        x, y = pose.x_mm / self._scale, pose.y_mm / self._scale
        return Pose(
            self.origin.x_mm + x * self._dy + y * self._dx,
            self.origin.y_mm - x * self._dx + y * self._dy,
            (pose.heading_deg + self.origin.heading_deg) % 360.0,
        )

    def from_robot(self, pose: Pose) -> Pose:
        """A pose in the robot's coordinates, in the turtle's."""
        x, y = (pose.x_mm - self.origin.x_mm) * self._scale, (pose.y_mm - self.origin.y_mm) * self._scale
        return Pose(
            x * self._dy - y * self._dx,
            x * self._dx + y * self._dy,
            (pose.heading_deg - self.origin.heading_deg) % 360.0,
        )
