"""The account of a robot that is driven by hand: lines, pens, and who looks when."""

from __future__ import annotations

from turtlewire.robots.timed.reckoning import STILL, Motion, Reckoning
from turtlewire.trace import Stroke


def test_straight_on_is_one_line_however_many_set_points_it_takes() -> None:
    account = Reckoning()
    for number in range(1000):
        account.begin(Motion(100.0 + number % 7, 0.0), number * 0.5)
    account.begin(Motion(100.0, 0.0), 500.0)
    account.end(501.0)
    (stroke,) = account.trace.strokes
    (start, end) = stroke.points
    assert start == (0.0, 0.0)
    assert end == (0.0, account.distance_mm)
    assert account.robot[:2] == end


def test_there_and_back_are_two_lines() -> None:
    account = Reckoning()
    for at, speed in ((0.0, 10.0), (1.0, 20.0), (2.0, -5.0), (4.0, -10.0), (5.0, 30.0)):
        account.begin(Motion(speed, 0.0), at)
    account.end(6.0)
    assert account.trace.strokes == [
        Stroke(pen_down=True, points=[(0.0, 0.0), (0.0, 30.0), (0.0, 10.0), (0.0, 40.0)])
    ]
    assert (account.distance_mm, account.rolled_mm) == (80.0, 40.0)


def test_what_was_driven_before_the_pen_moved_is_drawn_as_it_was() -> None:
    account = Reckoning()
    account.begin(Motion(10.0, 0.0), 0.0)
    account.begin(Motion(10.0, 0.0), 1.0)
    account.pen_down = False
    account.begin(Motion(10.0, 0.0), 3.0)
    account.end(4.0)
    assert not account.pen_down
    assert account.trace.strokes == [
        Stroke(pen_down=True, points=[(0.0, 0.0), (0.0, 10.0)]),
        Stroke(pen_down=False, points=[(0.0, 10.0), (0.0, 40.0)]),
    ]


def test_what_is_not_to_be_seen_is_not_in_the_trace() -> None:
    account = Reckoning()
    account.begin(Motion(10.0, 0.0), 0.0)
    account.begin(Motion(-10.0, 0.0), 1.0, is_drawn=False)
    account.begin(Motion(10.0, 0.0), 2.0)
    account.end(3.0)
    assert account.robot.y_mm == 10.0
    # Out and home unseen, then over the same line again: no ink where it was not seen.
    assert [stroke.points[-1] for stroke in account.trace.strokes] == [(0.0, 10.0)]


def test_a_look_on_the_way_sees_where_it_is() -> None:
    account = Reckoning()
    account.begin(Motion(10.0, 0.0), 0.0)
    account.begin(Motion(20.0, 0.0), 1.0)
    assert account.robot.y_mm == 10.0
    assert account.trace.pose.y_mm == 10.0
    assert account.at(2.0).y_mm == 30.0
    account.begin(Motion(20.0, 90.0), 2.0)
    account.settle()
    assert account.exact.y_mm == 30.0
    account.begin(STILL, 3.0)
    assert account.robot.heading_deg == 90.0
    assert not account.is_moving
