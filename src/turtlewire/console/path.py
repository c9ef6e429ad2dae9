"""The path of a robot, for a map: bounded, with a running index, so that whoever shows it fetches only what is new.

Points that say nothing (they lie on the straight line between others, to within a tolerance) are merged as they come;
when there are too many all the same, the tolerance is doubled and all are merged again. That is a new generation: who
shows the path fetches it anew.
"""

from __future__ import annotations

import math
from array import array
from threading import Lock
from typing import NamedTuple

# How far the merged path may be from the true one at first, millimetres.
TOLERANCE_MM = 0.25
MAX_POINTS = 100_000


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
    """

    def __init__(self, limit: int = MAX_POINTS, tolerance_mm: float = TOLERANCE_MM) -> None:
        self._limit = limit
        self._finest_mm = tolerance_mm
        self._lock = Lock()
        self._generation = 0
        self._begin(tolerance_mm)

    def _begin(self, tolerance_mm: float) -> None:
        self.tolerance_mm = tolerance_mm
        self._x, self._y, self._pen = array("d"), array("d"), bytearray()
        self._breaks()

    def __len__(self) -> int:
        return len(self._pen)

    @property
    def end(self) -> tuple[int, int, float, float]:
        """Changes whenever the path does."""
        with self._lock:
            last = (self._x[-1], self._y[-1]) if self._pen else (0.0, 0.0)
            return self._generation, len(self._pen), *last

    def move(self, x_mm: float, y_mm: float, *, pen_down: bool) -> None:
        """It went straight there."""
        with self._lock:
            if self._pen and (x_mm, y_mm) == (self._x[-1], self._y[-1]):
                return
            self._add(x_mm, y_mm, int(pen_down))
            if len(self._pen) > self._limit:
                self._thin()

    def jump(self, x_mm: float, y_mm: float) -> None:
        """It is there, and no way leads there: a stroke with the pen up."""
        self.move(x_mm, y_mm, pen_down=False)

    def clear(self) -> None:
        """Forget all but the last point."""
        with self._lock:
            last = [(self._x[-1], self._y[-1])] if self._pen else []
            self._begin(self._finest_mm)
            self._generation += 1
            for x, y in last:
                self._add(x, y, 0)

    def since(self, start: int, limit: int = MAX_POINTS) -> Piece:
        """The points from an index on, at most so many; an index beyond the end gives none.

        Whoever has all points up to ``start`` has to ask for the last of them again: it may have moved.
        """
        with self._lock:
            start = max(0, min(start, len(self._pen)))
            end = min(start + limit, len(self._pen))
            x, y, pen = self._x[start:end], self._y[start:end], self._pen[start:end]
            generation = self._generation
        return Piece(generation, start, [(round(x[i], 2), round(y[i], 2), pen[i]) for i in range(len(pen))])

    # ------------------------------------------------------------------ merging

    def _breaks(self) -> None:
        """The next point begins a line of its own."""
        self._low, self._high = -math.inf, math.inf
        self._middle = self._reach = 0.0
        self._is_open = False

    def _add(self, x: float, y: float, pen: int) -> None:
        """Replace the last point by this one if that changes the path by less than the tolerance.

        All points that were left out since the last kept one lie within a cone from there, which grows narrower.
        """
        count = len(self._pen)
        if count >= 2 and self._is_open and pen == self._pen[-1]:
            dx, dy = x - self._x[-2], y - self._y[-2]
            far = math.hypot(dx, dy)
            angle = _wrapped(math.atan2(dy, dx) - self._middle)
            if far >= self._reach and self._low <= angle <= self._high:
                self._x[-1], self._y[-1] = x, y
                self._narrow(angle, far)
                return
        self._x.append(x)
        self._y.append(y)
        self._pen.append(pen)
        if count:
            dx, dy = x - self._x[-2], y - self._y[-2]
            self._breaks()
            self._is_open = True
            self._middle = math.atan2(dy, dx)
            self._narrow(0.0, math.hypot(dx, dy))

    def _narrow(self, angle: float, far: float) -> None:
        self._reach = far
        half = math.asin(min(1.0, self.tolerance_mm / far)) if far else math.pi
        self._low, self._high = max(self._low, angle - half), min(self._high, angle + half)

    def _thin(self) -> None:
        while len(self._pen) > self._limit // 2:
            x, y, pen = self._x, self._y, self._pen
            self._begin(2.0 * self.tolerance_mm)
            for i in range(len(pen)):
                self._add(x[i], y[i], pen[i])
            if len(self._pen) > self._limit // 2 and self.tolerance_mm > math.hypot(*map(_span, (x, y))):
                self._halve()  # a pen that is lifted and lowered again and again
        self._generation += 1

    def _halve(self) -> None:
        """Forget the older half."""
        keep = len(self._pen) - self._limit // 2
        self._x, self._y, self._pen = self._x[keep:], self._y[keep:], self._pen[keep:]
        self._pen[0] = 0


def _span(values: array[float]) -> float:
    return max(values) - min(values)


def _wrapped(angle: float) -> float:
    return math.remainder(angle, math.tau)
