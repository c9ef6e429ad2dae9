"""The path of a robot, for a map: bounded, with a running index, so that whoever shows it fetches only what is new.

Points that say nothing (they lie on the straight line between others, to within a tolerance) are merged as they come;
when there are too many all the same, the tolerance is doubled and all are merged again, and when that is of no use, the
older half is forgotten. That is a new generation: who shows the path fetches it anew. It is done a few points at a
time, because it is done in the thread that drives the robot.
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
# While all are merged again, so many with each that is new.
PART = 200
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


class Line:
    """Points, those that say nothing merged. The last one may still move.

    Args:
        tolerance_mm: how far it may be from the true one.
    """

    def __init__(self, tolerance_mm: float) -> None:
        self.tolerance_mm = tolerance_mm
        self.x, self.y, self.pen = array("d"), array("d"), bytearray()
        self._cone = Cone(tolerance_mm)

    def __len__(self) -> int:
        return len(self.pen)

    def add(self, x: float, y: float, pen: int) -> None:
        """It goes on to this point."""
        count = len(self.pen)
        if count > 1 and pen == self.pen[-1] and self._cone.takes(x, y):
            self.x[-1], self.y[-1] = x, y
            return
        if count:
            self._cone.begin(self.x[-1], self.y[-1])
            self._cone.takes(x, y)
        self.x.append(x)
        self.y.append(y)
        self.pen.append(pen)

    def add_part(self, other: Line, start: int, end: int) -> None:
        """It goes on as a part of another one."""
        for index in range(start, end):
            self.add(other.x[index], other.y[index], other.pen[index])

    def forget(self, count: int) -> None:
        """Leave out the first so many."""
        self.x, self.y, self.pen = self.x[count:], self.y[count:], self.pen[count:]
        self.pen[0] = 0


class Path:
    """Where a robot has been. One thread may add to it while others read.

    Args:
        limit: about so many points it has at most.
        tolerance_mm: how far the path may be from the true one, to begin with.
    """

    def __init__(self, limit: int = MAX_POINTS, tolerance_mm: float = TOLERANCE_MM) -> None:
        self._limit = limit
        self._finest_mm = tolerance_mm
        self._lock = Lock()
        self._generation = 0
        self._changes = 0
        self._drawn = self._sheets = 0
        self._begin(Line(tolerance_mm))

    def _begin(self, line: Line) -> None:
        self._line = line
        # The same merged more boldly, as far as that has come.
        self._coarser: Line | None = None
        self._remade = 0
        # Where a motion under way has got: it gives way to what comes.
        self._tip: list[tuple[float, float, int]] = []

    def __len__(self) -> int:
        return len(self._line) + len(self._tip)

    @property
    def tolerance_mm(self) -> float:
        """How far it may be from the true one now."""
        return self._line.tolerance_mm

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
            line = self._line
            if self._tip or not line or (pose.x_mm, pose.y_mm) != (line.x[-1], line.y[-1]):
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
            line = self._line
            self._begin(Line(self._finest_mm))
            self._generation += 1
            self._changes += 1
            if line:
                self._line.add(line.x[-1], line.y[-1], 0)

    # ------------------------------------------------------------------ showing it

    def since(self, start: int, limit: int = MAX_POINTS) -> Piece:
        """The points from an index on, at most so many; from an index beyond the end, none.

        The last of them may still move, see ``settled``.
        """
        with self._lock:
            line, count = self._line, len(self._line)
            start = max(0, min(start, count + len(self._tip)))
            end = min(start + limit, count)
            settled = line.x[start:end], line.y[start:end], line.pen[start:end]
            tip = self._tip[max(0, start - count) : max(0, start + limit - count)]
            generation = self._generation
        points = [*zip(*settled, strict=True), *tip]
        return Piece(generation, start, [(round(x, 2), round(y, 2), pen) for x, y, pen in points])

    @property
    def settled(self) -> int:
        """So many points will not move any more in this generation."""
        return max(0, len(self._line) - 1)

    # ------------------------------------------------------------------ merging

    def _go_to(self, x: float, y: float, pen: int) -> None:
        self._line.add(x, y, pen)
        if self._coarser is not None:
            self._thin(self._coarser)
        elif len(self._line) > self._limit:
            self._coarser, self._remade = Line(2.0 * self.tolerance_mm), 0

    def _thin(self, coarser: Line) -> None:
        """Merge some more again, more boldly; when that is of no use, forget the older half."""
        settled = len(self._line) - 1
        start, self._remade = self._remade, min(self._remade + PART, settled)
        coarser.add_part(self._line, start, self._remade)
        if self._remade < settled:
            return
        coarser.add_part(self._line, settled, settled + 1)
        self._begin(coarser)
        self._generation += 1
        if len(coarser) > 0.75 * self._limit:
            if coarser.tolerance_mm < COARSEST_MM:
                self._coarser = Line(2.0 * coarser.tolerance_mm)
            else:
                coarser.forget(len(coarser) - self._limit // 2)
