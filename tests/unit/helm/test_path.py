from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from turtlewire.helm.path import PART, Line, Path
from turtlewire.trace import Trace
from turtlewire.turtle import HOME, Pose


def points(path: Path) -> list[tuple[float, float, int]]:
    return path.since(0).points


def same(pose: Pose) -> Pose:
    return pose


def test_a_straight_line_is_one_however_often_it_was_looked_at() -> None:
    path = Path()
    for x in range(100):
        path.move(Pose(float(x)), pen_down=True)
    path.move(Pose(99.0, 5.0), pen_down=True)
    path.move(Pose(99.0, 9.0), pen_down=False)
    assert points(path) == [(0, 0, 1), (99, 0, 1), (99, 5, 1), (99, 9, 0)]


@given(
    st.lists(st.tuples(st.integers(-50, 50), st.integers(-50, 50), st.booleans()), min_size=1, max_size=60),
    st.lists(st.integers(1, 5), min_size=1, max_size=60),
)
def test_whoever_fetches_what_is_new_has_it_all(moves: list[tuple[int, int, bool]], looks: list[int]) -> None:
    path = Path()
    seen: list[tuple[float, float, int]] = []
    settled, generation = 0, path.generation
    left = iter(moves)
    for count in looks:
        for x, y, pen_down in (move for _, move in zip(range(count), left, strict=False)):
            path.move(Pose(float(x), float(y)), pen_down=pen_down)
        piece = path.since(settled, 7)
        assert piece.generation == generation
        assert piece.start == settled
        seen[piece.start :] = piece.points
        settled = min(path.settled, len(seen))
    while len(seen) < len(path) or settled < path.settled:
        piece = path.since(settled, 7)
        seen[piece.start :] = piece.points
        settled = min(path.settled, len(seen))
    assert seen == points(path)


def test_a_path_is_bounded_and_stays_near_the_true_one() -> None:
    path = Path(limit=1000)
    generations = set()
    for i in range(6_000):
        angle = i / 40.0
        path.move(Pose(200.0 * math.sin(angle), 200.0 * math.cos(angle) + i / 100.0), pen_down=True)
        generations.add(path.generation)
        assert len(path) <= 1100
    assert 1 < len(generations) < 20
    kept = points(path)
    assert kept[0] == pytest.approx((0, 200, 1))
    longest = max(math.dist(one[:2], other[:2]) for one, other in pairwise(kept))
    # the sagitta of a chord is within the tolerances of all thinnings, added up
    assert longest <= 2.0 * math.sqrt(2.0 * 200.0 * 2.0 * path.tolerance_mm) + 5.0


def test_no_point_has_to_wait_until_all_are_merged_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """The robot's own thread does it."""
    added = [0]
    add = Line.add

    def counted(line: Line, x: float, y: float, pen: int) -> None:
        added[0] += 1
        add(line, x, y, pen)

    monkeypatch.setattr(Line, "add", counted)
    path = Path(limit=5000)
    generations = set()
    for i in range(30_000):
        added[0] = 0
        path.move(Pose(100.0 * (i % 2), float(i)), pen_down=bool(i % 3))
        assert added[0] <= PART + 2
        assert len(path) <= 1.1 * 5000
        generations.add(path.generation)
    assert len(generations) > 5
    assert points(path)[-1][:2] == (100, 29_999)


def test_what_cannot_be_merged_is_forgotten() -> None:
    path = Path(limit=100)
    for i in range(1000):
        path.move(Pose(1000.0 * (i % 2), float(i)), pen_down=bool(i % 3))
        assert len(path) <= 110
    assert points(path)[-1][:2] == (1000, 999)


def test_it_follows_a_trace_to_the_last_point_and_its_tip() -> None:
    path, trace = Path(), Trace()
    path.begin(HOME, trace)
    trace.move(Pose(0, 10), pen_down=True)
    trace.move(Pose(10, 10), pen_down=False)
    under_way = trace.extended([Pose(10, 5)], pen_down=True)
    path.follow(under_way, same, under_way.pose)
    assert points(path) == [(0, 0, 0), (0, 10, 1), (10, 10, 0), (10, 5, 1)]
    changes = path.changes
    path.follow(under_way, same, under_way.pose)
    assert path.changes == changes
    trace.move(Pose(10, 2), pen_down=True)
    path.follow(trace, same, trace.pose)
    assert points(path) == [(0, 0, 0), (0, 10, 1), (10, 10, 0), (10, 2, 1)]
    trace.clear()
    trace.move(Pose(20, 2), pen_down=True)
    before = path.generation
    path.follow(trace, same, trace.pose)
    assert path.generation > before
    assert points(path)[-1] == (20, 2, 0)
    assert len(path) == 2


def test_it_is_in_the_turtles_coordinates() -> None:
    path, trace = Path(), Trace(Pose(100, 0))
    path.begin(HOME, trace)
    trace.move(Pose(100, 50), pen_down=True)
    path.follow(trace, lambda pose: pose._replace(x_mm=pose.x_mm - 100), Pose(0, 50))
    assert points(path) == [(0, 0, 0), (0, 50, 1)]


def test_after_a_gap_it_goes_on_where_the_robot_is() -> None:
    path, trace = Path(), Trace()
    path.begin(HOME, trace)
    for i in range(1, 1000):
        trace.move(Pose(float(i % 7), float(i)), pen_down=True)
    path.follow(trace, same, trace.pose)
    assert points(path) == [(0, 0, 0), (999 % 7, 999, 0)]


@pytest.mark.parametrize("start", [0, 1, 2, 3, 4, 100])
def test_an_index_beyond_the_end_gives_none(start: int) -> None:
    path = Path()
    for pose in (HOME, Pose(0, 1), Pose(1, 1)):
        path.move(pose, pen_down=True)
    piece = path.since(start)
    assert piece.start == min(start, 3)
    assert len(piece.points) == 3 - piece.start
