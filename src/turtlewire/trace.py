"""What a turtle drew: its path as strokes, ready to be made a picture of."""

from __future__ import annotations

import math
from itertools import pairwise

from turtlewire.named_tuple import NamedTuple
from turtlewire.turtle import HOME, Pose

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence

# About so many points a trace has at most. When it has more, so many are looked at with each that is new.
LIMIT, PART = 100_000, 400
# How far thinned strokes may be from the true ones: at first, and at last.
FINEST_MM, COARSEST_MM = 0.02, 2.0

# What stands on the ground, in millimetres: a straight piece of wall (x1, y1, x2, y2), or a disc (x, y, radius).
Obstacle = tuple[float, float, float, float] | tuple[float, float, float]


class Stroke(NamedTuple):
    """A polyline that was driven with the pen up or down; points are (x, y) in millimetres."""

    pen_down: bool
    points: list[tuple[float, float]]


class Cone:
    """Tells which points of a polyline say nothing: the line that leaves them out passes them within a tolerance.

    All points since the last one that was kept lie in a cone from there, which grows narrower with each.
    """

    def __init__(self, tolerance_mm: float) -> None:
        self._tolerance_mm = tolerance_mm
        self.begin(0.0, 0.0)

    def begin(self, x: float, y: float) -> None:
        """This point is kept: what follows is seen from here."""
        self._x, self._y = x, y
        self._reach = self._middle = 0.0
        self._low, self._high = -math.inf, math.inf

    def takes(self, x: float, y: float) -> bool:
        """Whether all since the point that was kept can be left out for a line to this one, which is the next."""
        dx, dy = x - self._x, y - self._y
        far = math.hypot(dx, dy)
        angle = math.atan2(dy, dx)
        if not self._reach:
            self._middle = angle
        angle = math.remainder(angle - self._middle, math.tau)
        if far < self._reach or not self._low <= angle <= self._high:
            return False
        half = math.asin(min(1.0, self._tolerance_mm / far)) if far else math.pi
        self._low, self._high = max(self._low, angle - half), min(self._high, angle + half)
        self._reach = far
        return True


def simplified(points: Sequence[tuple[float, float]], tolerance_mm: float) -> list[tuple[float, float]]:
    """A polyline without the points that say nothing; its ends stay."""
    kept = list(points[:1])
    cone = Cone(tolerance_mm)
    cone.begin(*kept[0])
    for before, point in pairwise(points):
        if not cone.takes(*point):
            kept.append(before)
            cone.begin(*before)
            cone.takes(*point)
    return [*kept, *points[1:][-1:]]


class Trace:
    """The path of one turtle since its start or since the last ``clear``.

    It is bounded: beyond ``LIMIT`` points, old ones that hardly say anything are left out, a few with each that is new.
    The strokes stay within a tolerance of the true ones, which grows as slowly as it can; when all that is left says
    something, the older half is forgotten.

    Attributes:
        drawn: how many points have ever been added; sheets: how often it was cleared.
        tip: so many of the last points are where a motion under way has got, and give way to others.
        tolerance_mm: of the last thinning; the strokes are within twice that of the true ones.
    """

    def __init__(self, pose: Pose = HOME) -> None:
        self.strokes: list[Stroke] = []
        self.start = pose
        self.pose = pose
        self.drawn = self.sheets = self.tip = 0
        self._begin()

    def _begin(self) -> None:
        self.tolerance_mm = 0.0
        self._count = 0
        # What is before this point has been thinned out to within the tolerance.
        self._stroke = self._point = 0

    def __len__(self) -> int:
        """How many points it has."""
        return self._count

    def __bool__(self) -> bool:
        return True

    def move(self, pose: Pose, *, pen_down: bool) -> None:
        """Add a straight line from the last pose to this one (a mere turn adds no line)."""
        before, self.pose = self.pose, pose
        if (pose.x_mm, pose.y_mm) == (before.x_mm, before.y_mm):
            return
        if not self.strokes or self.strokes[-1].pen_down != pen_down:
            self.strokes.append(Stroke(pen_down, [(before.x_mm, before.y_mm)]))
            self._count += 1
        self.strokes[-1].points.append((pose.x_mm, pose.y_mm))
        self._count += 1
        self.drawn += 1
        if self._count > LIMIT:
            self._thin()

    def clear(self) -> None:
        """Forget the strokes; the pose stays and is the new start."""
        self.strokes = []
        self.start = self.pose
        self.sheets += 1
        self._begin()

    def extended(self, poses: Sequence[Pose], *, pen_down: bool) -> Trace:
        """Another trace, which goes on to these poses for now: they are its tip."""
        copy = Trace(self.start)
        copy.pose, copy.drawn, copy.sheets, copy._count = self.pose, self.drawn, self.sheets, -len(poses)
        copy.strokes = [*self.strokes[:-1], *(s._replace(points=[*s.points]) for s in self.strokes[-1:])]
        for pose in poses:
            copy.move(pose, pen_down=pen_down)
        copy.drawn, copy.tip, copy._count = self.drawn, copy.drawn - self.drawn, self._count
        return copy

    def newest(self, count: int) -> list[tuple[float, float, bool]]:
        """The last points that were added, before the tip, and the tip: x, y, and whether the pen was down."""
        found: list[tuple[float, float, bool]] = []
        wanted = count + self.tip
        for stroke in reversed(self.strokes):
            missing = wanted - len(found)
            if missing <= 0:
                break
            points = stroke.points[max(1, len(stroke.points) - missing) :]
            found += [(x, y, stroke.pen_down) for x, y in reversed(points)]
        return found[::-1]

    # ------------------------------------------------------------------ staying bounded

    def _thin(self) -> None:
        """Leave out some of the points that say least, the oldest first."""
        looked_at = 0
        while looked_at < PART:
            if self._is_at_the_end or not self.tolerance_mm:
                # All has been gone through once, but for the newest: again, more boldly.
                self._stroke = self._point = 0
                self.tolerance_mm = max(FINEST_MM, 2.0 * self.tolerance_mm)
                if self.tolerance_mm > COARSEST_MM:
                    self._forget()
                return
            points = self.strokes[self._stroke].points
            part = points[self._point : self._point + PART]
            kept = simplified(part, self.tolerance_mm)
            points[self._point : self._point + PART] = kept
            looked_at += len(part)
            self._count -= len(part) - len(kept)
            self._point += len(kept) - 1
            if self._point >= len(points) - 1:
                self._stroke, self._point = self._stroke + 1, 0

    @property
    def _is_at_the_end(self) -> bool:
        """Whether nothing is left to thin out but the newest points of the last stroke."""
        last = len(self.strokes) - 1
        return self._stroke > last or (
            self._stroke == last and self._point + 2 * PART > len(self.strokes[last].points)
        )

    def _forget(self) -> None:
        """All that is left says something: the older half is forgotten."""
        gone = 0
        while self._count > LIMIT // 2 and gone < len(self.strokes) - 1:
            self._count -= len(self.strokes[gone].points)
            gone += 1
        self.strokes = self.strokes[gone:]
        points = self.strokes[0].points
        if self._count > LIMIT // 2:
            del points[: self._count - LIMIT // 2]
            self._count = LIMIT // 2
        self.start = Pose(*points[0], self.start.heading_deg)
        self.tolerance_mm = 0.0
