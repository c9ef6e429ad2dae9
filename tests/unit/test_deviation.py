"""The deviation of what was drawn, against a plain search through all lines, and against what is known."""

from __future__ import annotations

import math
import random
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import turtlewire
from turtlewire.deviation import Followed, SquaredPaper, between, segments
from turtlewire.errors import LimitReachedError
from turtlewire.logo import Interpreter, ScreenTurtle
from turtlewire.trace import Trace
from turtlewire.turtle import HOME, Pose

Point = tuple[float, float]
ROOT = Path(__file__).parents[2]


def drawing(*strokes: list[Point], pen_down: bool = True) -> Trace:
    trace = Trace()
    for points in strokes:
        trace.move(Pose(*points[0]), pen_down=False)
        for point in points[1:]:
            trace.move(Pose(*point), pen_down=pen_down)
    return trace


def square(side: float) -> list[Point]:
    return [(0.0, 0.0), (0.0, side), (side, side), (side, 0.0), (0.0, 0.0)]


def test_the_same_drawing_has_none() -> None:
    found = between(drawing(square(100.0)), drawing(square(100.0)))
    assert found == pytest.approx((0.0, 0.0), abs=1e-9)


def test_a_line_aside_by_so_much() -> None:
    found = between(drawing([(3.0, 0.0), (3.0, 100.0)]), drawing([(0.0, 0.0), (0.0, 100.0)]))
    assert found is not None
    assert found == pytest.approx((3.0, 3.0))


def test_a_line_that_opens() -> None:
    # From none to 10 mm, evenly, both ways but for the angle.
    found = between(drawing([(0.0, 0.0), (10.0, 1000.0)]), drawing([(0.0, 0.0), (0.0, 1000.0)]))
    assert found is not None
    assert found.largest == pytest.approx(10.0, rel=0.01)
    assert found.mean == pytest.approx(5.0, rel=0.01)


@pytest.mark.parametrize("swapped", [False, True])
def test_a_line_too_much_or_too_few_counts(swapped: bool) -> None:
    less, more = (
        drawing([(0.0, 0.0), (0.0, 100.0)]),
        drawing([(0.0, 0.0), (0.0, 100.0)], [(0.0, 50.0), (40.3, 50.0), (0.0, 50.0)]),
    )
    found = between(more, less) if swapped else between(less, more)
    assert found is not None
    assert found.largest == pytest.approx(40.3, abs=1e-9)
    assert found.mean == pytest.approx(20.15 * 80.6 / 280.6, rel=0.05)


def test_lines_with_the_pen_up_do_not_count() -> None:
    away: list[Point] = [(0.0, 0.0), (900.0, 900.0)]
    line = drawing([(0.0, 0.0), (0.0, 100.0)])
    line.move(Pose(500.0, 500.0), pen_down=False)
    assert segments(line) == [(0.0, 0.0, 0.0, 100.0)]
    assert between(line, drawing([(0.0, 0.0), (0.0, 100.0)])) == (0.0, 0.0)
    assert between(line, drawing(away, pen_down=False)) is None
    assert between(drawing(away, pen_down=False), line) is None


@pytest.mark.parametrize("heading", [0.0, 90.0, 37.0])
def test_where_home_is(heading: float) -> None:
    origin = Pose(200.0, -50.0, heading)
    drawn, pose = Trace(origin), origin
    for _ in range(4):
        pose = pose.moved(100.0)
        drawn.move(pose, pen_down=True)
        pose = pose.turned(90.0)
    found = between(drawn, drawing(square(100.0)), origin)
    assert found is not None
    assert found.largest < 1e-9
    elsewhere = between(drawn, drawing(square(100.0)))
    assert elsewhere is not None
    assert elsewhere.largest > 50.0


coordinates = st.floats(-500.0, 500.0).map(lambda x: round(x, 3))
points = st.tuples(coordinates, coordinates)


@settings(max_examples=60, deadline=None)
@given(st.lists(points, min_size=2, max_size=30), st.lists(points, min_size=1, max_size=10))
def test_squared_paper_finds_the_nearest_of_all_lines(corners: list[Point], places: list[Point]) -> None:
    lines = [(*a, *b) for a, b in pairwise(corners)]
    paper = SquaredPaper(lines)
    for x, y in [*places, *corners]:
        assert paper.distance(x, y) == pytest.approx(min(plain(x, y, line) for line in lines), abs=1e-6)


def test_squared_paper_near_and_far() -> None:
    chance = random.Random(1)
    lines, x, y = [], 0.0, 0.0
    for _ in range(3000):
        to = x + chance.uniform(-4.0, 4.0), y + chance.uniform(-3.0, 5.0)
        lines.append((x, y, *to))
        x, y = to
    paper = SquaredPaper(lines)
    for spread in (1.0, 30.0, 1000.0):
        for _ in range(15):
            near = chance.choice(lines)
            x, y = near[0] + chance.uniform(-spread, spread), near[1] + chance.uniform(-spread, spread)
            assert paper.distance(x, y) == pytest.approx(min(plain(x, y, line) for line in lines), abs=1e-9)


def plain(x: float, y: float, line: tuple[float, float, float, float]) -> float:
    """By the angle at either end."""
    x1, y1, x2, y2 = line
    length = math.hypot(x2 - x1, y2 - y1)
    if not length:
        return math.hypot(x - x1, y - y1)
    along = ((x - x1) * (x2 - x1) + (y - y1) * (y2 - y1)) / length
    if not 0.0 < along < length:
        return min(math.hypot(x - x1, y - y1), math.hypot(x - x2, y - y2))
    return abs((x - x1) * (y2 - y1) - (y - y1) * (x2 - x1)) / length


def test_a_followed_turtle_draws_the_exact_path() -> None:
    program = """
    REPEAT 3 [FD 50 RT 120]
    PU SETPOS [10 20] PD SETX 40 SETY -10 SETHEADING 45 BK 20 LT 30
    ARC 90 30 HOME FD 5
    """
    wanted = ScreenTurtle()
    with turtlewire.connect("sim:walter") as robot:
        followed = Followed(robot)
        for turtle in (wanted, followed):
            Interpreter(turtle, lambda _: None, random.Random(0)).run(program)
        followed.finish()
        assert len(segments(followed.ideal)) == len(segments(wanted.trace))
        for one, other in zip(segments(followed.ideal), segments(wanted.trace), strict=True):
            assert one == pytest.approx(other, abs=1e-6)
        found = between(robot.trace, followed.ideal)
        assert found is not None
        assert 0.0 < found.mean < found.largest < 1.0
        assert followed.is_exact
        followed.clear_screen()
        assert followed.ideal.strokes == []
        assert (followed.pose, followed.is_pen_down) == (HOME, True)


def test_a_line_that_a_limit_ended_should_end_there() -> None:
    with turtlewire.connect(f"sim:walter?arena={ROOT}/examples/maze.toml&start=300,0,90") as robot:
        origin, followed = robot.trace.pose, Followed(robot)
        followed.set_step_by_step(True)
        with pytest.raises(LimitReachedError):
            followed.forward(5000.0)
        followed.right(90.0)
        found = between(robot.trace, followed.ideal, origin)
        assert found is not None
        assert found.largest < 1.0
        assert origin != HOME


def test_a_car_that_turns_in_an_arc_has_no_exact_path() -> None:
    with turtlewire.connect("sim:simple?turn=arc") as robot:
        followed = Followed(robot)
        followed.forward(50.0)
        assert followed.is_exact
        followed.right(90.0)
        assert not followed.is_exact
