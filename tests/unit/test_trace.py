"""What a turtle drew, as strokes."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from turtlewire import trace as trace_module
from turtlewire.trace import Stroke, Trace, simplified
from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

A, B, C = Pose(0, 10, 0), Pose(10, 10, 90), Pose(10, 0, 180)


def test_lines_with_the_same_pen_are_one_stroke() -> None:
    trace = Trace()
    trace.move(A, pen_down=True)
    trace.move(B, pen_down=True)
    trace.move(C, pen_down=False)
    trace.move(HOME, pen_down=True)
    assert trace.strokes == [
        Stroke(pen_down=True, points=[(0, 0), (0, 10), (10, 10)]),
        Stroke(pen_down=False, points=[(10, 10), (10, 0)]),
        Stroke(pen_down=True, points=[(10, 0), (0, 0)]),
    ]
    assert trace.pose == HOME


def test_a_turn_draws_nothing() -> None:
    trace = Trace(A)
    trace.move(A.turned(90), pen_down=True)
    assert trace.strokes == []
    assert trace.pose.heading_deg == 90
    trace.move(B, pen_down=True)
    assert len(trace.strokes) == 1


def test_a_new_sheet_starts_where_the_turtle_is() -> None:
    trace = Trace(A)
    assert trace.start == A
    trace.move(B, pen_down=True)
    trace.clear()
    assert (trace.strokes, trace.start, trace.pose) == ([], B, B)
    trace.move(C, pen_down=True)
    assert trace.strokes[0].points[0] == B[:2]


def circles(count: int) -> Iterator[Pose]:
    for i in range(count):
        yield Pose(300.0 * math.sin(i / 100.0), 300.0 * math.cos(i / 100.0) + i / 1000.0)


def distance_mm(point: tuple[float, float], one: tuple[float, float], other: tuple[float, float]) -> float:
    dx, dy = other[0] - one[0], other[1] - one[1]
    x, y = point[0] - one[0], point[1] - one[1]
    length = dx * dx + dy * dy
    along = max(0.0, min(1.0, (x * dx + y * dy) / length)) if length else 0.0
    return math.hypot(x - along * dx, y - along * dy)


coordinates = st.floats(-1000.0, 1000.0, allow_nan=False)
polylines = st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=40)


@given(polylines, st.floats(0.01, 100.0))
def test_what_is_left_out_lies_on_what_is_left(
    points: list[tuple[float, float]], tolerance_mm: float
) -> None:
    kept = simplified(points, tolerance_mm)
    assert kept[0] == points[0]
    assert kept[-1] == points[-1]
    lines = [*pairwise(kept)] or [(kept[0], kept[0])]
    first = 0  # the line that the last point was on: they come in order
    for point in points:
        first = next(
            i
            for i in range(first, len(lines))
            if distance_mm(point, *lines[i]) <= 1.001 * tolerance_mm + 1e-6
        )


def test_points_on_a_line_say_nothing_and_the_way_back_does() -> None:
    way = [(float(x), 0.0) for x in range(50)]
    assert simplified(way, 0.1) == [way[0], way[-1]]
    assert simplified([*way, (10.0, 0.0)], 0.1) == [way[0], way[-1], (10.0, 0.0)]


def test_a_long_trace_is_thinned_and_stays_where_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trace_module, "LIMIT", 5000)
    trace = Trace(next(circles(1)))
    poses = list(circles(20_000))
    for pose in poses:
        trace.move(pose, pen_down=True)
        assert len(trace) <= 5010
    assert len(trace) == sum(len(stroke.points) for stroke in trace.strokes)
    assert 0.0 < trace.tolerance_mm < 2.0
    points = trace.strokes[0].points
    lines = list(pairwise(points))
    assert points[0] == poses[0][:2]
    assert points[-100:] == [pose[:2] for pose in poses[-100:]]
    for pose in poses[::499]:
        assert min(distance_mm(pose[:2], *line) for line in lines) <= 2.0 * trace.tolerance_mm


@pytest.mark.parametrize("pen", [lambda _: True, lambda i: i % 3 == 0], ids=["one stroke", "many strokes"])
def test_a_trace_is_bounded_whatever_is_drawn(
    monkeypatch: pytest.MonkeyPatch, pen: Callable[[int], bool]
) -> None:
    monkeypatch.setattr(trace_module, "LIMIT", 2000)
    trace = Trace()
    for i in range(20_000):
        trace.move(Pose(1000.0 * (i % 2), float(i)), pen_down=pen(i))
    assert len(trace) == sum(len(stroke.points) for stroke in trace.strokes) < 3000
    assert trace.strokes[-1].points[-1] == trace.pose[:2]
    assert trace.start[:2] == trace.strokes[0].points[0]


def test_the_newest_points_across_strokes_and_the_tip() -> None:
    trace = Trace()
    trace.move(A, pen_down=True)
    trace.move(B, pen_down=False)
    assert trace.newest(1) == [(10, 10, False)]
    assert trace.newest(2) == [(0, 10, True), (10, 10, False)]
    further = trace.extended([C, HOME], pen_down=True)
    assert (further.drawn, further.tip) == (trace.drawn, 2)
    assert further.newest(1) == [(10, 10, False), (10, 0, True), (0, 0, True)]
    assert trace.newest(1) == [(10, 10, False)]
    assert trace.strokes[-1].points == [(0, 10), (10, 10)]
    trace.clear()
    assert trace.newest(2) == []
    assert (trace.sheets, trace.drawn) == (1, 2)
