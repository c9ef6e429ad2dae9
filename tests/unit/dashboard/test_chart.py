"""The ground, seen from above."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import pytest

from turtlewire.dashboard import chart
from turtlewire.dashboard.chart import Chart, Path
from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from turtlewire.trace import Obstacle

if TYPE_CHECKING:
    from turtlewire.dashboard.canvas import Cell


def text(cells: list[list[Cell]]) -> list[str]:
    return ["".join(cell.character for cell in row) for row in cells]


def where(cells: list[list[Cell]], layer: int) -> list[tuple[int, int]]:
    return [(x, y) for y, row in enumerate(cells) for x, cell in enumerate(row) if cell.layer == layer]


@pytest.mark.parametrize(
    ("heading", "arrow"),
    [
        (0, "↑"),
        (22, "↑"),
        (23, "↗"),
        (90, "→"),
        (135, "↘"),
        (180, "↓"),
        (225, "↙"),
        (270, "←"),
        (315, "↖"),
        (359, "↑"),
    ],
)
def test_the_robot_is_an_arrow(heading: float, arrow: str) -> None:
    rows = text(Chart().draw(21, 11, Path(), Pose(0.0, 0.0, heading)))
    assert rows[5][10] == arrow
    assert rows[10].startswith("├───┤ ")


def test_up_is_up_and_right_is_right() -> None:
    path = Path()
    for pose in (HOME, Pose(0.0, 200.0), Pose(200.0, 200.0)):
        path.move(pose, pen_down=True)
    cells = Chart().draw(30, 15, path, Pose(200.0, 200.0, 90.0))
    [(x, y)] = where(cells, chart.ROBOT)
    ink = where(cells, chart.PEN_DOWN)
    assert min(row for _, row in ink) == y
    assert max(column for column, _ in ink) == x - 1
    assert (min(column for column, _ in ink), max(row for _, row in ink)) in ink


def test_the_bar_says_how_long_it_is() -> None:
    # Ten dots, of four to a row: what is so long is so high.
    for far_mm, bar, mm_per_row in (
        (320.0, "80 mm", 32.0),
        (3000.0, "600 mm", 240.0),
        (30000.0, "6 m", 2400.0),
    ):
        path = Path()
        path.move(HOME, pen_down=True)
        path.move(Pose(0.0, far_mm), pen_down=True)
        cells = Chart().draw(60, 15, path, HOME)
        assert text(cells)[-1].startswith(f"├───┤ {bar} ")
        rows = {y for _, y in where(cells, chart.PEN_DOWN)}
        assert len(rows) == pytest.approx(far_mm / mm_per_row, abs=1.0)
    assert "├" not in "".join(text(Chart().draw(9, 5, Path(), HOME)))


def test_the_scale_stays_while_everything_fits() -> None:
    path, one = Path(), Chart()
    cells = one.draw(40, 12, path, HOME)
    bars: list[str] = []
    columns: list[int] = []
    for step in range(200):
        pose = Pose(10.0 * step, 0.0, 90.0)
        path.move(pose, pen_down=True)
        cells = one.draw(40, 12, path, pose)
        bars.append(text(cells)[-1])
        columns.append(where(cells, chart.ROBOT)[0][0])
    assert len(set(bars)) <= 8
    assert sum(after < before for before, after in itertools.pairwise(columns)) <= 16
    bars = [text(one.draw(40, 12, Path(), HOME))[-1]]
    assert bars == [text(cells)[-1]]  # it does not shrink again
    assert text(one.draw(60, 20, Path(), HOME))[-1] != bars[0]  # another size is a new beginning


def test_walls_and_discs_and_all_of_them_fit() -> None:
    obstacles: list[Obstacle] = [(-500.0, -300.0, -500.0, 300.0), (500.0, 0.0, 100.0)]
    cells = Chart().draw(40, 15, Path(), HOME, obstacles)
    things = where(cells, chart.OBSTACLE)
    assert min(x for x, _ in things) < 8
    assert max(x for x, _ in things) > 32
    left = [y for x, y in things if x < 10]
    assert max(left) - min(left) >= 4


def test_with_the_pen_up_it_is_dotted() -> None:
    path = Path()
    path.move(HOME, pen_down=True)
    path.move(Pose(200.0, 0.0), pen_down=True)
    path.move(Pose(400.0, 0.0), pen_down=False)
    path.move(Pose(600.0, 0.0), pen_down=False)
    cells = Chart().draw(60, 10, path, Pose(600.0, 0.0))
    down, up = where(cells, chart.PEN_DOWN), where(cells, chart.PEN_UP)
    assert len(up) > 5
    assert all(cells[y][x].character in "⠉⠒⠤⣀" for x, y in down[1:-1])
    assert not any(cells[y][x].character in "⠉⠒⠤⣀" for x, y in up)
    assert max(x for x, _ in down) <= min(x for x, _ in up)


def test_a_jump_is_no_way() -> None:
    path = Path()
    path.jump(HOME)
    assert not path.legs
    path.move(HOME, pen_down=True)
    path.jump(Pose(400.0, 0.0))
    path.move(Pose(400.0, 300.0), pen_down=True)
    assert [leg.points for leg in path.legs] == [[(0.0, 0.0)], [(400.0, 0.0), (400.0, 300.0)]]


def test_a_path_has_no_more_points_than_can_be_looked_at() -> None:
    path = Path()
    for step in range(20_000):
        path.move(Pose(step * 3.0, (step % 7) * 5.0), pen_down=step % 5000 < 4000)
    points = [point for leg in path.legs for point in leg.points]
    assert len(points) <= chart.MAX_POINTS + 10
    assert points[0] == (0.0, 0.0)
    assert points[-1][0] == pytest.approx(60_000.0, abs=300.0)
    path = Path()
    for step in range(10_000):
        path.move(Pose(step * 30.0, 0.0), pen_down=bool(step % 2))
    assert len(path.legs) <= chart.MAX_POINTS
    assert path.legs[-1].points[-1][0] == 9999 * 30.0


def test_small_steps_are_one() -> None:
    path = Path()
    for step in range(1000):
        path.move(Pose(step * 0.01, 0.0), pen_down=True)
    assert len(path.legs[0].points) == 5


def test_a_chart_of_almost_no_size() -> None:
    for columns, rows in ((1, 1), (2, 1), (1, 30), (200, 1)):
        assert len(Chart().draw(columns, rows, Path(), HOME)) == rows
