"""Braille dots."""

from __future__ import annotations

import math

import pytest

from turtlewire.dashboard.canvas import Canvas


def shown(canvas: Canvas) -> list[str]:
    return ["".join(cell.character for cell in row) for row in canvas.cells()]


@pytest.mark.parametrize(
    ("x", "y", "character"),
    [(0, 0, "⠁"), (0, 1, "⠂"), (0, 2, "⠄"), (0, 3, "⡀"), (1, 0, "⠈"), (1, 1, "⠐"), (1, 2, "⠠"), (1, 3, "⢀")],
)
def test_each_dot(x: int, y: int, character: str) -> None:
    canvas = Canvas(2, 1)
    canvas.dot(x + 2, y, 1)
    assert shown(canvas) == [" " + character]


def test_dots_outside_are_cut_off() -> None:
    canvas = Canvas(2, 1)
    for x, y in ((-1, 0), (0, -1), (4, 0), (0, 4)):
        canvas.dot(x, y, 1)
    assert shown(canvas) == ["  "]


def test_lines() -> None:
    canvas = Canvas(4, 2)
    canvas.line((0, 0), (7, 7), 1)
    assert shown(canvas) == ["⠑⢄  ", "  ⠑⢄"]
    canvas = Canvas(4, 2)
    canvas.polyline([(0, 7), (0, 0), (7, 0)], 1)
    assert shown(canvas) == ["⡏⠉⠉⠉", "⡇   "]
    canvas = Canvas(4, 1)
    canvas.line((0, 0), (7, 0), 1, every=3)
    assert shown(canvas) == ["⠁⠈ ⠁"]
    canvas = Canvas(1, 1)
    canvas.line((1, 1), (1, 1), 1)
    assert shown(canvas) == ["⠐"]


def test_lines_that_come_from_far_outside() -> None:
    canvas = Canvas(4, 1)
    canvas.line((-1e9, 0), (1e9, 0), 1)
    assert shown(canvas) == ["⠉⠉⠉⠉"]
    canvas = Canvas(4, 1)
    for start, end in (
        ((-5.0, -5.0), (-5.0, 50.0)),
        ((0.0, -3.0), (7.0, -3.0)),
        ((0.0, 9.0), (7.0, 9.0)),
        ((-9.0, 3.0), (3.0, -9.0)),
    ):
        canvas.line(start, end, 1)
    assert shown(canvas) == ["    "]


def test_circles() -> None:
    canvas = Canvas(4, 2)
    canvas.circle((3.5, 3.5), 3.5, 1)
    dots = [row.count(" ") for row in shown(canvas)]
    assert dots == [0, 0]
    canvas.circle((3.5, 3.5), math.inf, 2)
    canvas.circle((3.5, 3.5), 1e12, 2)
    assert all(cell.layer == 1 for row in canvas.cells() for cell in row)


def test_the_highest_layer_counts_and_characters_stand_above_dots() -> None:
    canvas = Canvas(2, 2)
    canvas.dot(0, 0, 2)
    canvas.dot(1, 1, 1)
    assert canvas.cells()[0][0] == ("⠑", 2)
    canvas.put(2, 4, "↑", 5)
    canvas.put(-1, 0, "x", 5)
    canvas.put(0, 8, "x", 5)
    assert shown(canvas) == ["⠑ ", " ↑"]
    assert canvas.cells()[1][1].layer == 5
