"""How far what was drawn is from what should have been: two traces compared, in millimetres.

The deviation of a point of one drawing is its distance to the nearest line of the other. It is looked for both ways:
a line that is wrong is far from the lines that were wanted, and a line that is missing leaves a wanted one far
from all that was drawn. Lines with the pen up do not count.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.trace import Trace
from turtlewire.turtle import HOME, Pose, Turtle, direction

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

# How close to one another the points are that are compared; in a long drawing further apart, but no fewer than so many,
# and always the corners.
POINT_MM = 1.0
POINTS = 3_000
# Far from the other drawing, points may be apart by this part of their distance to it.
FAR_PART = 0.05
# The nearest line is looked for on squared paper with no more squares than this in a row: first in the squares around
# the point, so many to each side; then in whole blocks of squares.
SQUARES = 256
NEAR = 3
BLOCK = 16

Segment = tuple[float, float, float, float]


class Deviation(NamedTuple):
    """How far two drawings are apart, in millimetres: at most, and on average along both of them."""

    largest: float
    mean: float


def between(drawn: Trace, ideal: Trace, origin: Pose = HOME) -> Deviation | None:
    """The deviation of what was drawn from what should have been; None if there is nothing on one of the two.

    Args:
        drawn: what was drawn.
        ideal: what should have been drawn, as the turtle sees it: from its home, looking up.
        origin: where the turtle's home is in what was drawn.
    """
    lines, wanted = segments(drawn), [_placed(segment, origin) for segment in segments(ideal)]
    if not lines or not wanted:
        return None
    largest = total = length = 0.0
    for some, others in ((lines, SquaredPaper(wanted)), (wanted, SquaredPaper(lines))):
        for distance, weight in _distances(some, others):
            largest = max(largest, distance)
            total += distance * weight
            length += weight
    return Deviation(largest, total / length)


def segments(trace: Trace) -> list[Segment]:
    """The lines that were drawn with the pen down: x1, y1, x2, y2."""
    return [
        (*a, *b)
        for stroke in trace.strokes
        if stroke.pen_down
        for a, b in zip(stroke.points, stroke.points[1:], strict=False)
    ]


def _placed(segment: Segment, origin: Pose) -> Segment:
    if origin == HOME:
        return segment
    dx, dy = direction(origin.heading_deg)
    x1, y1, x2, y2 = segment
    return (
        origin.x_mm + x1 * dy + y1 * dx,
        origin.y_mm - x1 * dx + y1 * dy,
        origin.x_mm + x2 * dy + y2 * dx,
        origin.y_mm - x2 * dx + y2 * dy,
    )


def _distances(lines: Sequence[Segment], others: SquaredPaper) -> Iterator[tuple[float, float]]:
    """The distance to the nearest of the others, of points all along the lines; and what length each stands for."""
    step = max(POINT_MM, sum(_length(line) for line in lines) / POINTS)
    end: tuple[float, float] | None = None
    distance = skipped = 0.0
    for line in lines:
        x1, y1, x2, y2 = line
        if (x1, y1) != end:
            if end is not None and skipped:
                yield others.distance(*end), skipped
            distance = others.distance(x1, y1)
            yield distance, 0.0
            skipped = 0.0
        end = (x2, y2)
        length = _length(line)
        pieces = max(1, math.ceil(length / step))
        for piece in range(1, pieces + 1):
            skipped += length / pieces
            far_mm = distance * FAR_PART
            if skipped >= far_mm or (piece == pieces and length >= far_mm):  # corners count
                part = piece / pieces
                distance = others.distance(x1 + (x2 - x1) * part, y1 + (y2 - y1) * part)
                yield distance, skipped
                skipped = 0.0
    if end is not None and skipped:
        yield others.distance(*end), skipped


def _length(line: Segment) -> float:
    return math.hypot(line[2] - line[0], line[3] - line[1])


class SquaredPaper:
    """Lines on squared paper: the nearest one to a point is in the squares around it, or in a block further off."""

    def __init__(self, lines: Sequence[Segment]) -> None:
        low_x = min(min(line[0], line[2]) for line in lines)
        low_y = min(min(line[1], line[3]) for line in lines)
        high_x = max(max(line[0], line[2]) for line in lines)
        high_y = max(max(line[1], line[3]) for line in lines)
        mean_mm = sum(_length(line) for line in lines) / len(lines)
        self._side_mm = max(mean_mm, (high_x - low_x) / SQUARES, (high_y - low_y) / SQUARES, POINT_MM)
        self._low_x, self._low_y = low_x, low_y
        self._squares: dict[tuple[int, int], list[Segment]] = {}
        for line in lines:
            self._put(line)
        blocks: dict[tuple[int, int], list[tuple[int, int]]] = {}
        for x, y in self._squares:
            blocks.setdefault((x // BLOCK, y // BLOCK), []).append((x, y))
        self._blocks = [(x * BLOCK, y * BLOCK, squares) for (x, y), squares in blocks.items()]
        # The line that was nearest last time is likely to be near again.
        self._last = lines[0]

    def _put(self, line: Segment) -> None:
        """Into every square that it may touch, column by column."""
        x1, y1, x2, y2 = line if line[0] <= line[2] else (line[2], line[3], line[0], line[1])
        side_mm = self._side_mm
        x1, y1, x2, y2 = x1 - self._low_x, y1 - self._low_y, x2 - self._low_x, y2 - self._low_y
        first, last = int(x1 / side_mm), int(x2 / side_mm)
        for column in range(first, last + 1):
            a, b = y1, y2
            if first != last:
                slope = (y2 - y1) / (x2 - x1)
                a = y1 + slope * (max(x1, column * side_mm) - x1)
                b = y1 + slope * (min(x2, (column + 1) * side_mm) - x1)
            low, high = (a, b) if a <= b else (b, a)
            for row in range(int(low / side_mm), int(high / side_mm) + 1):
                self._squares.setdefault((column, row), []).append(line)

    def distance(self, x: float, y: float) -> float:
        """How far the nearest line is from a point, in millimetres."""
        side_mm, squares = self._side_mm, self._squares
        across, along = (x - self._low_x) / side_mm, (y - self._low_y) / side_mm
        column, row = math.floor(across), math.floor(along)
        # From the point to the end of its square, in squares.
        margin = min(across - column, column + 1 - across, along - row, row + 1 - along)
        nearest, best = self._last, _squared(x, y, self._last)
        for ring in range(NEAR + 1):
            if ring and ((ring - 1 + margin) * side_mm) ** 2 >= best:
                break
            for dx, dy in RINGS[ring]:
                for line in squares.get((column + dx, row + dy), ()):
                    squared = _squared(x, y, line)
                    if squared < best:
                        nearest, best = line, squared
        else:
            nearest, best = self._among_blocks(x, y, nearest, best)
        self._last = nearest
        return math.sqrt(best)

    def _among_blocks(self, x: float, y: float, nearest: Segment, best: float) -> tuple[Segment, float]:
        """The nearest line, and the square of its distance, if it is nearer than one that is known."""
        side_mm = self._side_mm
        across, along, limit = (x - self._low_x) / side_mm, (y - self._low_y) / side_mm, best / side_mm**2
        for left, low, squares in self._blocks:
            if _gap(across - left, along - low, BLOCK) >= limit:
                continue
            for square in squares:
                if _gap(across - square[0], along - square[1], 1) >= limit:
                    continue
                for line in self._squares[square]:
                    squared = _squared(x, y, line)
                    if squared < best:
                        nearest, best, limit = line, squared, squared / side_mm**2
        return nearest, best


# The squares around one, so many away.
RINGS = [
    [
        (dx, dy)
        for dx in range(-ring, ring + 1)
        for dy in range(-ring, ring + 1)
        if max(abs(dx), abs(dy)) == ring
    ]
    for ring in range(NEAR + 1)
]


def _gap(dx: float, dy: float, side: int) -> float:
    """The square of the distance between a point and a square, whose lower left corner is so far from it."""
    if dx > 0.0:
        dx = dx - side if dx > side else 0.0
    if dy > 0.0:
        dy = dy - side if dy > side else 0.0
    return dx * dx + dy * dy


def _squared(x: float, y: float, line: Segment) -> float:
    """The square of the distance between a point and a line."""
    x1, y1, x2, y2 = line
    dx, dy = x2 - x1, y2 - y1
    px, py = x - x1, y - y1
    along = px * dx + py * dy
    if along > 0.0:
        squared = dx * dx + dy * dy
        if along >= squared:
            px, py = x - x2, y - y2
        else:
            part = along / squared
            px, py = px - part * dx, py - part * dy
    return px * px + py * py


class Followed(Turtle):
    """A turtle that lets another one do everything, and keeps the exact path: what should be drawn.

    Attributes:
        ideal: the path from the turtle's home.
        is_exact: whether the turtle could do what it was told: a car that turns in an arc leaves its place when it
            turns, and there is no telling where that should have been.
    """

    def __init__(self, turtle: Turtle) -> None:
        self._turtle = turtle
        self.ideal = Trace(turtle.pose)
        self.is_exact = True

    def _follow(self) -> None:
        self.ideal.move(self._turtle.pose, pen_down=self._turtle.is_pen_down)

    @property
    def pose(self) -> Pose:
        """Where the exact turtle is."""
        return self._turtle.pose

    @property
    def is_pen_down(self) -> bool:
        """Whether the pen is down."""
        return self._turtle.is_pen_down

    # After an error, too, the turtle is where it says: a limit ends a line before its end.

    def forward(self, distance_mm: float) -> None:
        """Drive straight ahead; backwards when negative."""
        try:
            self._turtle.forward(distance_mm)
        finally:
            self._follow()

    def set_position(self, x_mm: float, y_mm: float) -> None:
        """Go straight to a point and keep the heading."""
        try:
            self._turtle.set_position(x_mm, y_mm)
        finally:
            self._follow()

    def home(self) -> None:
        """Go to the origin and look up."""
        try:
            self._turtle.home()
        finally:
            self._follow()

    def right(self, angle_deg: float) -> None:
        """Turn clockwise on the spot; counter-clockwise when negative. Whole turns are made."""
        place = self._turtle.pose[:2]
        try:
            self._turtle.right(angle_deg)
        finally:
            self.is_exact = self.is_exact and self._turtle.pose[:2] == place
            self._follow()

    def set_heading(self, heading_deg: float) -> None:
        """Turn, the shorter way, to an absolute heading."""
        place = self._turtle.pose[:2]
        try:
            self._turtle.set_heading(heading_deg)
        finally:
            self.is_exact = self.is_exact and self._turtle.pose[:2] == place
            self._follow()

    def pen_up(self) -> None:
        """Lift the pen."""
        self._turtle.pen_up()

    def pen_down(self) -> None:
        """Lower the pen."""
        self._turtle.pen_down()

    def clean(self) -> None:
        """Start a new sheet."""
        self._turtle.clean()
        self.ideal.clear()

    def set_speed(self, speed: int) -> None:
        """Set the speed, 1 (slow) to 255 (fast)."""
        self._turtle.set_speed(speed)

    def horn(self, tone: str) -> None:
        """Sound the horn."""
        self._turtle.horn(tone)

    def lamp(self, on: bool) -> None:
        """Switch the lamp."""
        self._turtle.lamp(on)

    def wait(self, seconds: float) -> None:
        """Let the motion end, then let this much of the robot's time pass."""
        self._turtle.wait(seconds)

    def finish(self) -> None:
        """Wait until every motion is done."""
        self._turtle.finish()

    def stop(self) -> None:
        """Stop at once and forget every motion not yet done."""
        self._turtle.stop()
        self._follow()

    def set_step_by_step(self, on: bool) -> None:
        """Whether each motion ends before its method returns."""
        self._turtle.set_step_by_step(on)
