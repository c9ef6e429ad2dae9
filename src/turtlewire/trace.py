"""What a turtle drew: its path as strokes, ready to be made a picture of."""

from __future__ import annotations

from turtlewire.named_tuple import NamedTuple
from turtlewire.turtle import HOME, Pose

# What stands on the ground, in millimetres: a straight piece of wall (x1, y1, x2, y2), or a disc (x, y, radius).
Obstacle = tuple[float, float, float, float] | tuple[float, float, float]


class Stroke(NamedTuple):
    """A polyline that was driven with the pen up or down; points are (x, y) in millimetres."""

    pen_down: bool
    points: list[tuple[float, float]]


class Trace:
    """The path of one turtle since its start or since the last ``clear``."""

    def __init__(self, pose: Pose = HOME) -> None:
        self.strokes: list[Stroke] = []
        self.start = pose
        self.pose = pose

    def move(self, pose: Pose, *, pen_down: bool) -> None:
        """Add a straight line from the last pose to this one (a mere turn adds no line)."""
        before, self.pose = self.pose, pose
        if (pose.x_mm, pose.y_mm) == (before.x_mm, before.y_mm):
            return
        if not self.strokes or self.strokes[-1].pen_down != pen_down:
            self.strokes.append(Stroke(pen_down, [(before.x_mm, before.y_mm)]))
        self.strokes[-1].points.append((pose.x_mm, pose.y_mm))

    def clear(self) -> None:
        """Forget the strokes; the pose stays and is the new start."""
        self.strokes = []
        self.start = self.pose
