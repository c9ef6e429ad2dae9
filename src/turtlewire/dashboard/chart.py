"""The ground, seen from above: where the robot went, what stands there, and where it is now."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.dashboard.canvas import Canvas, Cell
from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from collections.abc import Sequence

    from turtlewire.trace import Obstacle

# Layers, the lowest first.
PEN_UP, OBSTACLE, PEN_DOWN, SCALE, ROBOT = 1, 2, 3, 4, 5
ARROWS = "↑↗→↘↓↙←↖"
# A path has points so far apart, at least, and so many, at most; then half as many.
LEAST_MM = 2.0
MAX_POINTS = 4000
# Less ground than this is never shown, in millimetres: what moves would not seem to.
LEAST_SPAN_MM = 400.0
# With the pen up, one dot in so many.
DOTTED = 3
# Room around everything, in dots.
MARGIN = 3
# The scale grows in steps; a bar of ten dots is a round number in each of them.
STEPS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
SCALE_DOTS = 10


class Leg(NamedTuple):
    """A part of the path: with the pen up or down; points in millimetres."""

    pen_down: bool
    points: list[tuple[float, float]]


class Path:
    """Where the robot went, in no more points than can be looked at."""

    def __init__(self) -> None:
        self.legs: list[Leg] = []
        self._size = 0
        self._least_mm = LEAST_MM

    def move(self, pose: Pose, *, pen_down: bool) -> None:
        """It is here now, and has come straight."""
        here = (pose.x_mm, pose.y_mm)
        if not self.legs:
            self._begin(pen_down, here)
        elif pen_down != self.legs[-1].pen_down:
            self._begin(pen_down, self.legs[-1].points[-1], here)
        elif math.dist(here, self.legs[-1].points[-1]) >= self._least_mm:
            self.legs[-1].points.append(here)
            self._size += 1
        if self._size > MAX_POINTS:
            self._thin()

    def jump(self, pose: Pose) -> None:
        """It is here, and has not come by a way that is known: no line leads here."""
        if self.legs:
            self._begin(self.legs[-1].pen_down, (pose.x_mm, pose.y_mm))

    def _begin(self, pen_down: bool, *points: tuple[float, float]) -> None:
        self.legs.append(Leg(pen_down, [*points]))
        self._size += len(points)

    def _thin(self) -> None:
        """Leave out every other point; and of legs that are only there because the pen moved, the oldest."""
        self._least_mm *= 2.0
        self.legs = [
            leg._replace(points=[*leg.points[:-1:2], leg.points[-1]]) for leg in self.legs[-MAX_POINTS // 4 :]
        ]
        self._size = sum(len(leg.points) for leg in self.legs)


class Scale(NamedTuple):
    """How the ground lies on the canvas: millimetres for each dot, and what is in its middle."""

    mm_per_dot: float
    x_mm: float
    y_mm: float


class Chart:
    """Draws it, again and again; the scale stays as it is as long as everything fits."""

    def __init__(self) -> None:
        self._scale: Scale | None = None
        self._size = (0, 0)

    def draw(
        self, columns: int, rows: int, path: Path, pose: Pose, obstacles: Sequence[Obstacle] = ()
    ) -> list[list[Cell]]:
        """Draw it into so many cells; +y is up."""
        canvas = Canvas(columns, rows)
        scale = self._fitted(canvas, _corners(path, pose, obstacles))

        def at(x_mm: float, y_mm: float) -> tuple[float, float]:
            return (
                (canvas.width - 1) / 2.0 + (x_mm - scale.x_mm) / scale.mm_per_dot,
                (canvas.height - 1) / 2.0 - (y_mm - scale.y_mm) / scale.mm_per_dot,
            )

        for obstacle in obstacles:
            if len(obstacle) == 4:
                canvas.line(at(*obstacle[:2]), at(*obstacle[2:]), OBSTACLE)
            else:
                canvas.circle(at(*obstacle[:2]), obstacle[2] / scale.mm_per_dot, OBSTACLE)
        for leg in path.legs:
            layer, every = (PEN_DOWN, 1) if leg.pen_down else (PEN_UP, DOTTED)
            canvas.polyline([at(*point) for point in leg.points], layer, every=every)
        _draw_bar(canvas, scale)
        arrow = ARROWS[round(pose.heading_deg / 45.0) % len(ARROWS)]
        canvas.put(*at(pose.x_mm, pose.y_mm), arrow, ROBOT)
        return canvas.cells()

    def _fitted(self, canvas: Canvas, corners: Corners) -> Scale:
        across, down = (max(1, dots - 2 * MARGIN) for dots in (canvas.width, canvas.height))
        old, size = self._scale, (canvas.width, canvas.height)
        if old is not None and size == self._size:
            half_x, half_y = across * old.mm_per_dot / 2.0, down * old.mm_per_dot / 2.0
            x_fits = old.x_mm - half_x <= corners.left and corners.right <= old.x_mm + half_x
            if x_fits and old.y_mm - half_y <= corners.low and corners.high <= old.y_mm + half_y:
                return old
        width, height = corners.right - corners.left, corners.high - corners.low
        needed = max(width / across, height / down, LEAST_SPAN_MM / min(across, down))
        x, y = (corners.left + corners.right) / 2.0, (corners.low + corners.high) / 2.0
        self._scale, self._size = Scale(_round_up(needed), x, y), size
        return self._scale


class Corners(NamedTuple):
    """What has to fit on the canvas, millimetres."""

    left: float
    right: float
    low: float
    high: float


def _corners(path: Path, pose: Pose, obstacles: Sequence[Obstacle]) -> Corners:
    points = [(pose.x_mm, pose.y_mm), (HOME.x_mm, HOME.y_mm)]
    points += [point for leg in path.legs for point in leg.points]
    for obstacle in obstacles:
        if len(obstacle) == 4:
            points += [obstacle[:2], obstacle[2:]]
        else:
            x, y, radius = obstacle
            points += [(x - radius, y - radius), (x + radius, y + radius)]
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return Corners(min(xs), max(xs), min(ys), max(ys))


def _round_up(mm_per_dot: float) -> float:
    """The next step: so that not every millimetre that the robot drives changes the whole picture."""
    power = 10.0 ** math.floor(math.log10(mm_per_dot))
    return next(power * step for step in STEPS if power * step >= mm_per_dot * (1.0 - 1e-9))


def _draw_bar(canvas: Canvas, scale: Scale) -> None:
    """A bar at the bottom left that says how long it is."""
    length_mm = scale.mm_per_dot * SCALE_DOTS
    text = f"{length_mm / 1000.0:g} m" if length_mm >= 1000.0 else f"{length_mm:g} mm"
    bar = "├" + "─" * (SCALE_DOTS // 2 - 2) + "┤ " + text
    if len(bar) > canvas.columns or canvas.rows < 2:
        return
    for column, character in enumerate(bar):
        canvas.put(2 * column, canvas.height - 1, character, SCALE)
