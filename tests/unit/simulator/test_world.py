from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest

from turtlewire.errors import DataError, UsageError
from turtlewire.simulator.world import Contact, Wall, World, load_arena
from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from pathlib import Path

UP, DOWN, RIGHT, LEFT = (0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0)
# A wall across the way up, 500 mm ahead, from -100 to 100.
ACROSS = World((Wall(-100.0, 500.0, 100.0, 500.0),))


def meet(
    world: World, x: float, y: float, direction: tuple[float, float], far: float = math.inf
) -> Contact | None:
    return world.contact(x, y, direction, far, 90.0)


def test_head_on_the_way_ends_a_radius_before_the_wall() -> None:
    assert meet(ACROSS, 0.0, 0.0, UP) == Contact(410.0, 0.0, 1.0)


def test_a_wall_bars_the_way_from_both_sides() -> None:
    assert meet(ACROSS, 0.0, 1000.0, DOWN) == Contact(410.0, 180.0, 1.0)


def test_a_shorter_way_is_free_and_one_that_just_touches_is_not() -> None:
    assert meet(ACROSS, 0.0, 0.0, UP, 409.999) is None
    assert meet(ACROSS, 0.0, 0.0, UP, 410.0) is not None


@pytest.mark.parametrize("direction", [DOWN, LEFT, RIGHT])
def test_other_ways_are_free(direction: tuple[float, float]) -> None:
    assert meet(ACROSS, 0.0, 0.0, direction) is None


def test_a_slanting_way_meets_the_wall_where_the_disc_is_a_radius_away() -> None:
    direction = (math.sin(math.radians(10.0)), math.cos(math.radians(10.0)))
    found = meet(ACROSS, 0.0, 0.0, direction)
    assert found is not None
    assert found.distance_mm == pytest.approx(410.0 / math.cos(math.radians(10.0)))
    assert found.bearing_deg == pytest.approx(0.0)
    assert found.pressure == pytest.approx(math.cos(math.radians(10.0)))


def test_the_end_of_a_wall_is_touched_with_the_side_of_the_disc() -> None:
    found = meet(ACROSS, 154.0, 0.0, UP)
    assert found is not None
    assert found.distance_mm == pytest.approx(500.0 - 72.0)  # 54, 72, 90: a right triangle
    assert found.bearing_deg == pytest.approx(-math.degrees(math.atan2(54.0, 72.0)))
    found = meet(ACROSS, -154.0, 0.0, UP)
    assert found is not None
    assert found.bearing_deg == pytest.approx(math.degrees(math.atan2(54.0, 72.0)))


def test_a_slanting_wall_is_met_between_its_ends_and_not_beyond() -> None:
    world = World((Wall(0.0, 500.0, 400.0, 800.0),))  # 3, 4, 5
    found = meet(world, 200.0, 0.0, UP)
    assert found is not None
    assert found.distance_mm == pytest.approx(650.0 - 90.0 * 5.0 / 4.0)
    assert found.pressure == pytest.approx(0.8)
    # 90 mm square to the wall's first end the disc comes past the end before it touches the side.
    found = meet(world, 20.0, 0.0, UP)
    assert found is not None
    assert found.distance_mm == pytest.approx(500.0 - (90.0**2 - 20.0**2) ** 0.5)
    assert found.bearing_deg < 0.0


def test_brushing_past_an_end_is_free() -> None:
    assert meet(ACROSS, 190.0, 0.0, UP) is None
    assert meet(ACROSS, 189.9, 0.0, UP) is not None


def test_driving_onto_the_narrow_end_of_a_wall() -> None:
    assert meet(ACROSS, 500.0, 500.0, LEFT) == Contact(310.0, -90.0, 1.0)


def test_who_touches_a_wall_may_go_away_and_along_but_not_into_it() -> None:
    assert meet(ACROSS, 0.0, 410.0, UP) == Contact(0.0, 0.0, 1.0)
    assert meet(ACROSS, 0.0, 410.0, DOWN) is None
    assert meet(ACROSS, 0.0, 410.0, LEFT) is None
    assert meet(ACROSS, 0.0, 410.0, RIGHT) is None
    one_degree = math.radians(1.0)
    assert meet(ACROSS, 0.0, 410.0, (math.cos(one_degree), math.sin(one_degree))) is not None


def test_a_disc_that_a_wall_cuts_a_little_is_not_stuck() -> None:
    assert meet(ACROSS, 0.0, 410.5, DOWN) is None
    assert meet(ACROSS, 0.0, 410.5, UP) == Contact(0.0, 0.0, 1.0)


def test_the_nearest_wall_counts_whatever_their_order() -> None:
    far, near = Wall(-100.0, 900.0, 100.0, 900.0), Wall(-100.0, 300.0, 100.0, 300.0)
    for walls in ((far, near), (near, far)):
        assert meet(World(walls), 0.0, 0.0, UP) == Contact(210.0, 0.0, 1.0)


def test_in_a_corner_the_wall_that_is_pressed_harder_counts() -> None:
    ahead, beside = Wall(-500.0, 90.0, 500.0, 90.0), Wall(90.0, -500.0, 90.0, 500.0)
    angle = math.radians(30.0)
    for walls in ((ahead, beside), (beside, ahead)):
        found = meet(World(walls), 0.0, 0.0, (math.sin(angle), math.cos(angle)))
        assert found is not None
        assert found.bearing_deg == pytest.approx(0.0)


def test_the_gap_to_the_nearest_wall() -> None:
    assert ACROSS.gap(0.0, 0.0, 90.0) == 410.0
    assert ACROSS.gap(103.0, 504.0, 90.0) == -85.0
    assert World().gap(0.0, 0.0, 90.0) == math.inf


@pytest.mark.parametrize(
    ("x_mm", "y_mm", "nearest"),
    [
        (300.0, 350.0, (300.0, 350.0)),  # on the wall
        (270.0, 390.0, (300.0, 350.0)),  # beside it
        (100.0, 100.0, (100.0, 200.0)),  # before its first end
        (600.0, 600.0, (500.0, 500.0)),  # beyond its last one
    ],
)
def test_the_nearest_point_of_a_slanting_wall(x_mm: float, y_mm: float, nearest: tuple[float, float]) -> None:
    assert Wall(100.0, 200.0, 500.0, 500.0).nearest(x_mm, y_mm) == pytest.approx(nearest)


def test_a_disc_centred_on_a_wall_may_leave_it_either_way() -> None:
    assert meet(ACROSS, 0.0, 500.0, UP) is None
    assert meet(ACROSS, 0.0, 500.0, DOWN) is None


def test_the_walls_near_a_point() -> None:
    walls = (Wall(0.0, 10.0, 1.0, 10.0), Wall(0.0, 20.0, 1.0, 20.0))
    world = World(walls, Pose(1.0, 2.0, 3.0)).near(0.0, 0.0, 10.0)
    assert (world.walls, world.start) == (walls[:1], Pose(1.0, 2.0, 3.0))


# Arena files


def arena(folder: Path, text: str | bytes) -> World:
    path = folder / "arena.toml"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return load_arena(path)


def test_an_arena_has_polylines_and_a_start(tmp_path: Path) -> None:
    world = arena(
        tmp_path,
        """
        [start]
        x_mm = 10
        y_mm = 20.5
        heading_deg = 450
        [[wall]]
        points = [[0, 0], [100, 0], [100, 50.5]]
        [[wall]]
        points = [[-1, -1], [-1000000, 1000000]]
        """,
    )
    assert world.start == Pose(10.0, 20.5, 90.0)
    assert world.walls == (
        Wall(0.0, 0.0, 100.0, 0.0),
        Wall(100.0, 0.0, 100.0, 50.5),
        Wall(-1.0, -1.0, -1e6, 1e6),
    )


def test_an_empty_arena_is_an_open_floor(tmp_path: Path) -> None:
    world = arena(tmp_path, "")
    assert (world.walls, world.start) == ((), HOME)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("[[wall]]\npoints = [[0, 0], [1, 1]]\n[[wall]]\npoints = [[0, 0]]", "wall 2: it needs points"),
        ("[[wall]]", "wall 1: it needs points"),
        ("[[wall]]\npoints = 3", "wall 1: it needs points"),
        ("[[wall]]\npoints = [[0, 0], [0]]", "wall 1, point 2: a point is [x, y], in millimetres, not [0]"),
        ("[[wall]]\npoints = [[0, 0], 7]", "wall 1, point 2: a point is"),
        ("[[wall]]\npoints = [[0, 0], [1, 'a']]", "wall 1, point 2: 'a' is not a number"),
        ("[[wall]]\npoints = [[0, true], [1, 1]]", "wall 1, point 1: True is not a number"),
        ("[[wall]]\npoints = [[0, nan], [1, 1]]", "wall 1, point 1: nan is not a number"),
        ("[[wall]]\npoints = [[0, 0], [inf, 1]]", "wall 1, point 2: inf is not a number"),
        ("[[wall]]\npoints = [[0, 0], [1000001, 1]]", "from -1000000 to 1000000"),
        ("[[wall]]\npoints = [[0, 0], [5, 5], [5, 5]]", "wall 1: points 2 and 3 are the same"),
        ("[[wall]]\npoints = [[0, 0], [1, 1]]\ncolour = 1", "wall 1: there is no 'colour'; known are points"),
        ("[wall]\npoints = []", "wall: walls are written [[wall]]"),
        ("wall = [1]", "wall: walls are written [[wall]]"),
        ("walls = []", "an arena: there is no 'walls'; known are start, wall"),
        ("start = 3", "start: the start is written [start]"),
        ("[start]\nx = 3", "start: there is no 'x'; known are x_mm, y_mm, heading_deg"),
        ("[start]\ny_mm = 'far'", "start: y_mm: 'far' is not a number"),
        ("[start]\nheading_deg = nan", "start: heading_deg: nan is not a number"),
        ("[[wall]\n", "at line 1"),
        (b"\xff\xfe", "byte 0 is not UTF-8 text"),
    ],
)
def test_what_is_wrong_in_an_arena_is_named_with_its_file_and_entry(
    tmp_path: Path, text: str | bytes, complaint: str
) -> None:
    with pytest.raises(DataError) as caught:
        arena(tmp_path, text)
    assert str(tmp_path / "arena.toml") in str(caught.value)
    assert complaint in str(caught.value)


def test_toml_too_deep_for_its_reader_is_wrong_data(tmp_path: Path) -> None:
    text = "wall = " + "[" * 100_000
    with pytest.raises(DataError, match="no valid TOML"):
        arena(tmp_path, text)


@pytest.mark.parametrize("name", ["nowhere.toml", "", "nul\0byte"])
def test_an_arena_that_cannot_be_read(tmp_path: Path, name: str) -> None:
    with pytest.raises(UsageError, match="the arena file cannot be read"):
        load_arena(f"{tmp_path}/{name}")
