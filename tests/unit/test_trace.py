"""What a turtle drew, as strokes."""

from __future__ import annotations

from turtlewire.trace import Stroke, Trace
from turtlewire.turtle import HOME, Pose

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
