"""Obstacles for many robots at once: ``world.contact`` in NumPy, and a grid that knows which can matter where."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from turtlewire.simulator.world import ALONG, TOUCH_MM

if TYPE_CHECKING:
    from turtlewire.simulator.world import World

Floats = npt.NDArray[np.float64]
CELL_MM = 100.0
MAX_CELLS = 1 << 16


class Obstacles:
    """Walls and round obstacles: all of them are lines of some thickness, a disc a very short one.

    Args:
        world: where they stand.
        radius_mm: of the largest robot.
        step_mm: how far any robot gets in one step, at most.
    """

    def __init__(self, world: World, radius_mm: float, step_mm: float) -> None:
        rows = [(*wall, 0.0) for wall in world.walls]
        rows += [(disc.x_mm, disc.y_mm, disc.x_mm, disc.y_mm, disc.radius_mm) for disc in world.discs]
        self.are_none = not rows
        # The last one is nowhere: it fills up the lists of cells that have fewer.
        rows.append((np.inf, np.inf, np.inf, np.inf, 0.0))
        x1, y1, x2, y2, thick = np.array(rows, dtype=np.float64).T
        x1[-1] = y1[-1] = x2[-1] = y2[-1] = 1e12
        self._x1, self._y1, self._dx, self._dy, self._thick = x1, y1, x2 - x1, y2 - y1, thick
        self._length = np.hypot(self._dx, self._dy)
        self._margin_mm = max(CELL_MM / 2.0, 2.0 * step_mm)
        if not self.are_none:
            self._make_grid(radius_mm + self._margin_mm)

    def _make_grid(self, reach_mm: float) -> None:
        edge = reach_mm + self._thick[:-1].max()
        xs = np.concatenate([self._x1[:-1], (self._x1 + self._dx)[:-1]])
        ys = np.concatenate([self._y1[:-1], (self._y1 + self._dy)[:-1]])
        self._left, self._bottom = xs.min() - edge, ys.min() - edge
        width, height = xs.max() + edge - self._left, ys.max() + edge - self._bottom
        self._cell_mm = max(CELL_MM, float(np.sqrt(width * height / MAX_CELLS)))
        self._columns, self._rows = int(width // self._cell_mm) + 1, int(height // self._cell_mm) + 1
        near_mm = self._cell_mm * np.sqrt(0.5) + reach_mm
        middle_x = self._left + (np.arange(self._columns) + 0.5) * self._cell_mm
        lists: list[npt.NDArray[np.intp]] = []
        every = np.arange(len(self._x1) - 1)
        for row in range(self._rows):
            y = np.full((self._columns, 1), self._bottom + (row + 0.5) * self._cell_mm)
            apart, _, _ = self._nearest(middle_x[:, None], y, every[None, :])
            lists += [np.flatnonzero(cell) for cell in apart - self._thick[:-1] <= near_mm]
        longest = max(len(found) for found in lists)
        # The last cell is everywhere outside.
        self._cells = np.full((len(lists) + 1, longest), len(self._x1) - 1)
        for number, found in enumerate(lists):
            self._cells[number, : len(found)] = found

    def _nearest(self, x: Floats, y: Floats, who: npt.NDArray[np.intp]) -> tuple[Floats, Floats, Floats]:
        """How far a point is from each obstacle's line, and the way there."""
        dx, dy = self._dx[who], self._dy[who]
        to_x, to_y = x - self._x1[who], y - self._y1[who]
        square = dx * dx + dy * dy
        along = np.clip((to_x * dx + to_y * dy) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
        way_x, way_y = along * dx - to_x, along * dy - to_y
        return np.hypot(way_x, way_y), way_x, way_y

    def meet(self, x: Floats, y: Floats, to_x: Floats, to_y: Floats, radius: Floats) -> tuple[Floats, Floats]:
        """How far discs get on straight ways before they touch something they run into; infinite: all the way.

        And how far each is from everything at its beginning, as far as that is known.
        """
        column = ((x - self._left) // self._cell_mm).astype(np.intp)
        row = ((y - self._bottom) // self._cell_mm).astype(np.intp)
        inside = (column >= 0) & (column < self._columns) & (row >= 0) & (row < self._rows)
        who = self._cells[np.where(inside, row * self._columns + column, len(self._cells) - 1)]
        x, y, radius = x[:, None], y[:, None], radius[:, None] + self._thick[who]
        apart, way_x, way_y = self._nearest(x, y, who)
        gap = apart - radius
        free_mm = np.minimum(gap.min(axis=1), self._margin_mm)
        go_x, go_y = to_x[:, None] - x, to_y[:, None] - y
        way_mm = np.hypot(go_x, go_y)
        go_x, go_y = go_x / np.where(way_mm > 0.0, way_mm, 1.0), go_y / np.where(way_mm > 0.0, way_mm, 1.0)
        far = np.minimum(
            self._to_side(x, y, go_x, go_y, radius, who),
            np.minimum(
                _to_point(self._x1[who] - x, self._y1[who] - y, go_x, go_y, radius),
                _to_point((self._x1 + self._dx)[who] - x, (self._y1 + self._dy)[who] - y, go_x, go_y, radius),
            ),
        )
        far = np.where(gap <= TOUCH_MM, 0.0, far)
        meets = (far <= way_mm) & (way_mm > 0.0)
        far = np.where(meets, far, 0.0)
        apart, way_x, way_y = self._nearest(x + far * go_x, y + far * go_y, who)
        pressure = (way_x * go_x + way_y * go_y) / np.where(apart > 0.0, apart, 1.0)
        far = np.where(meets & (pressure > ALONG), far, np.inf)
        return far.min(axis=1), free_mm

    def _to_side(
        self, x: Floats, y: Floats, go_x: Floats, go_y: Floats, radius: Floats, who: npt.NDArray[np.intp]
    ) -> Floats:
        length = self._length[who]
        is_wall = length > 0.0
        length = np.where(is_wall, length, 1.0)
        dx, dy = self._dx[who], self._dy[who]
        normal_x, normal_y = -dy / length, dx / length
        beside = (x - self._x1[who]) * normal_x + (y - self._y1[who]) * normal_y
        side = np.where(beside < 0.0, -1.0, 1.0)
        approach = -(go_x * normal_x + go_y * normal_y) * side
        comes = is_wall & (approach > 0.0) & (beside * side > radius)
        far = np.where(comes, (beside * side - radius) / np.where(comes, approach, 1.0), 0.0)
        along = (x + far * go_x - self._x1[who]) * dx + (y + far * go_y - self._y1[who]) * dy
        return np.where(comes & (along >= 0.0) & (along <= length * length), far, np.inf)


def _to_point(px: Floats, py: Floats, go_x: Floats, go_y: Floats, radius: Floats) -> Floats:
    ahead = px * go_x + py * go_y
    aside = px * go_y - py * go_x
    inside = radius * radius - aside * aside
    comes = (ahead > 0.0) & (inside > 0.0)
    far = ahead - np.sqrt(np.where(comes, inside, 0.0))
    return np.where(comes & (far >= 0.0), far, np.inf)
