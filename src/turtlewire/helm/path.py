"""The path of a robot, for a map: bounded, with a running index, so that whoever shows it fetches only what is new.

Points that say nothing (they lie on the straight line between others, to within a tolerance) are merged as they come;
when there are too many all the same, the tolerance is doubled and all are merged again, and when that is of no use, the
older half is forgotten. That is a new generation: who shows the path fetches it anew.
"""

from __future__ import annotations

from array import array
from threading import Lock
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.trace import Cone

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.trace import Trace
    from turtlewire.turtle import Pose

# How far the merged path may be from the true one at first, and at last, millimetres.
TOLERANCE_MM, COARSEST_MM = 0.1, 5.0
MAX_POINTS = 100_000
# When a path was left alone for so many points of a trace, what is between is not known any more.
LONGEST_GAP = 300


class Piece(NamedTuple):
    """A part of a path: its points replace everything from the index ``start`` on.

    Attributes:
        points: x and y in millimetres, and 1 where the pen was down on the way there, 0 where it was up.
    """

    generation: int
    start: int
    points: list[tuple[float, float, int]]


class Path:
    """Where a robot has been. One thread may add to it while others read.

    Args:
        limit: of its points.
        tolerance_mm: how far the path may be from the true one, to begin with.

    Attributes:
        tolerance_mm: how far it may be now.
    """

    def __init__(self, limit: int = MAX_POINTS, tolerance_mm: float = TOLERANCE_MM) -> None:
        self._limit = limit
        self._finest_mm = tolerance_mm
        self._lock = Lock()
        self._generation = 0
        self._changes = 0
        self._drawn = self._sheets = 0
        self._begin(tolerance_mm)

    def _begin(self, tolerance_mm: float) -> None:
        self.tolerance_mm = tolerance_mm
        self._x, self._y, self._pen = array("d"), array("d"), bytearray()
        self._cone = Cone(tolerance_mm)
        # Where a motion under way has got: it gives way to what comes.
        self._tip: list[tuple[float, float, int]] = []

    def __len__(self) -> int:
        return len(self._pen) + len(self._tip)

    @property
    def changes(self) -> int:
        """Another number whenever the path has changed."""
        return self._changes

    @property
    def generation(self) -> int:
        """Another number whenever the path has to be fetched anew."""
        return self._generation

    # ------------------------------------------------------------------ going on

    def begin(self, pose: Pose, trace: Trace) -> None:
        """A robot is met: from now on the path is this one's, and begins where it is."""
        self.clear()
        self._drawn, self._sheets = trace.drawn, trace.sheets
        self.move(pose, pen_down=False)

    def move(self, pose: Pose, *, pen_down: bool) -> None:
        """It went straight there."""
        with self._lock:
            if self._tip or not self._pen or (pose.x_mm, pose.y_mm) != (self._x[-1], self._y[-1]):
                self._tip = []
                self._go_to(pose.x_mm, pose.y_mm, int(pen_down))
                self._changes += 1

    def follow(self, trace: Trace, from_ground: Callable[[Pose], Pose], pose: Pose) -> None:
        """It went as its trace says, which is on the ground, where ``pose`` is the turtle's now."""
        if self.is_cleared(trace):
            self.clear()
            self.move(pose, pen_down=False)
            self._drawn = trace.drawn
        new, self._drawn = trace.drawn - self._drawn, trace.drawn
        if new > LONGEST_GAP:
            self.move(pose, pen_down=False)
            return
        points = [
            (*from_ground(trace.pose._replace(x_mm=x, y_mm=y))[:2], int(pen_down))
            for x, y, pen_down in trace.newest(new)
        ]
        settled = max(0, len(points) - trace.tip)
        if settled or points != self._tip:
            with self._lock:
                for point in points[:settled]:
                    self._go_to(*point)
                self._tip = points[settled:]
                self._changes += 1

    def is_cleared(self, trace: Trace) -> bool:
        """Whether its sheet is another one than when this was asked last."""
        before, self._sheets = self._sheets, trace.sheets
        return before != trace.sheets

    def clear(self) -> None:
        """Forget all but where it is."""
        with self._lock:
            last = (self._x[-1], self._y[-1], 0) if self._pen else None
            self._begin(self._finest_mm)
            self._generation += 1
            self._changes += 1
            if last is not None:
                self._add(*last)

    # ------------------------------------------------------------------ showing it

    def since(self, start: int, limit: int = MAX_POINTS) -> Piece:
        """The points from an index on, at most so many; from an index beyond the end, none.

        The last of them may still move, see ``settled``.
        """
        with self._lock:
            count = len(self._pen)
            start = max(0, min(start, count + len(self._tip)))
            end = min(start + limit, count)
            settled = self._x[start:end], self._y[start:end], self._pen[start:end]
            tip = self._tip[max(0, start - count) : max(0, start + limit - count)]
            generation = self._generation
        points = [*zip(*settled, strict=True), *tip]
        return Piece(generation, start, [(round(x, 2), round(y, 2), pen) for x, y, pen in points])

    @property
    def settled(self) -> int:
        """So many points will not move any more in this generation."""
        return max(0, len(self._pen) - 1)

    # ------------------------------------------------------------------ merging

    def _add(self, x: float, y: float, pen: int) -> None:
        count = len(self._pen)
        if count > 1 and pen == self._pen[-1] and self._cone.takes(x, y):
            self._x[-1], self._y[-1] = x, y
            return
        if count:
            self._cone.begin(self._x[-1], self._y[-1])
            self._cone.takes(x, y)
        self._x.append(x)
        self._y.append(y)
        self._pen.append(pen)

    def _go_to(self, x: float, y: float, pen: int) -> None:
        self._add(x, y, pen)
        if len(self._pen) > self._limit:
            self._thin()

    def _thin(self) -> None:
        """Merge all again, more boldly; when that is of no use, forget the older half."""
        while len(self._pen) > 0.75 * self._limit and self.tolerance_mm < COARSEST_MM:
            x, y, pen = self._x, self._y, self._pen
            self._begin(2.0 * self.tolerance_mm)
            for point in zip(x, y, pen, strict=True):
                self._add(*point)
        if len(self._pen) > 0.75 * self._limit:
            gone = len(self._pen) - self._limit // 2
            self._x, self._y, self._pen = self._x[gone:], self._y[gone:], self._pen[gone:]
            self._pen[0] = 0
        self._generation += 1
