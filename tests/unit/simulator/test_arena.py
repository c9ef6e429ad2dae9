"""Arena files: polygons and discs in TOML, and drawings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from turtlewire.errors import DataError
from turtlewire.simulator.world import Disc, Wall, World, load_arena
from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from pathlib import Path


def toml(folder: Path, text: str) -> World:
    path = folder / "arena.toml"
    path.write_text(text, "utf-8")
    return load_arena(path)


def svg(folder: Path, inside: str, root: str = "") -> World:
    path = folder / "Arena.SVG"
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {root}>{inside}</svg>', "utf-8")
    return load_arena(path)


def test_polygons_are_closed_and_discs_round(tmp_path: Path) -> None:
    world = toml(
        tmp_path,
        "[[polygon]]\npoints = [[0, 0], [10, 0], [0, 10]]\n[[disc]]\nx_mm = 1\ny_mm = 2\nradius_mm = 3.5\n",
    )
    assert world.walls == (
        Wall(0.0, 0.0, 10.0, 0.0),
        Wall(10.0, 0.0, 0.0, 10.0),
        Wall(0.0, 10.0, 0.0, 0.0),
    )
    assert world.discs == (Disc(1.0, 2.0, 3.5),)
    assert not world.is_empty
    assert World().is_empty


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("[[polygon]]\npoints = [[0, 0], [1, 0]]", "polygon 1: .*at least three"),
        ("[[polygon]]\npoints = [[0, 0], [1, 0], [0, 1], [0, 0]]", "polygon 1: the last point is the first"),
        ("polygon = 3", r"polygon: polygons are written \[\[polygon\]\]"),
        ("[[disc]]\nx_mm = 1", "disc 1: it needs y_mm, radius_mm"),
        ("[[disc]]\nx_mm = 1\ny_mm = 1\nradius_mm = 0", "disc 1: radius_mm: 0 is not above 0"),
        ("[[disc]]\nx_mm = 1\ny_mm = 1\nradius_mm = true", "disc 1: radius_mm: True is not a number"),
        ("[[disc]]\nx_mm = 1\ny_mm = 1\nradius_mm = 1\ncolour = 1", "disc 1: there is no 'colour'"),
        ("disc = 1", "discs are written .*with x_mm, y_mm and radius_mm"),
    ],
)
def test_what_is_wrong_in_toml_is_named(tmp_path: Path, text: str, complaint: str) -> None:
    with pytest.raises(DataError, match=complaint):
        toml(tmp_path, text)


@pytest.mark.parametrize(
    ("inside", "walls"),
    [
        ('<line x1="1" y1="2" x2="3" y2="4.5"/>', [(1, -2, 3, -4.5)]),
        ('<line x2="3px"/>', [(0, 0, 3, 0)]),
        ('<polyline points="0,0 10,0 10,5"/>', [(0, 0, 10, 0), (10, 0, 10, -5)]),
        ('<polygon points="0 0 10 0 10 5"/>', [(0, 0, 10, 0), (10, 0, 10, -5), (10, -5, 0, 0)]),
        (
            '<rect x="1" y="2" width="3" height="4"/>',
            [(1, -2, 4, -2), (4, -2, 4, -6), (4, -6, 1, -6), (1, -6, 1, -2)],
        ),
        ('<path d="M1 2L3,4"/>', [(1, -2, 3, -4)]),
        (
            '<path d="m1 2 3-4h5v6H0V1z"/>',
            [(1, -2, 4, 2), (4, 2, 9, 2), (9, 2, 9, -4), (9, -4, 0, -4), (0, -4, 0, -1), (0, -1, 1, -2)],
        ),
        ('<path d="M0 0 10 0 10 1e1 M20 0l1 1"/>', [(0, 0, 10, 0), (10, 0, 10, -10), (20, 0, 21, -1)]),
        ('<path d="M5 5h2z l0 3"/>', [(5, -5, 7, -5), (7, -5, 5, -5), (5, -5, 5, -8)]),
        ('<path d=""/>', []),
        ('<path d="M0 0L0 0L1 0"/>', [(0, 0, 1, 0)]),
        (
            '<g transform="translate(10)"><g transform="scale(2 3)"><line x2="1" y2="1"/></g></g>',
            [(10, 0, 12, -3)],
        ),
        ('<line transform="rotate(90)" x2="1"/>', [(0, 0, 0, -1)]),
        ('<line transform="rotate(90, 1 1) translate(1,2)" x2="1"/>', [(0, -1, 0, -2)]),
        ('<line transform="matrix(0 1 1 0 5 6) scale(2)" x2="1"/>', [(5, -6, 5, -8)]),
        ('<title>x</title><defs><line x2="1"/></defs><text>wall</text><!-- c -->', []),
        ('<g display="none"><line x2="1"/></g>', []),
    ],
)
def test_what_can_be_a_wall(tmp_path: Path, inside: str, walls: list[tuple[float, ...]]) -> None:
    world = svg(tmp_path, inside)
    assert world.start == HOME
    assert len(world.walls) == len(walls)
    for wall, expected in zip(world.walls, walls, strict=True):
        assert wall == pytest.approx(expected, abs=1e-9)


def test_circles_are_round_obstacles(tmp_path: Path) -> None:
    world = svg(tmp_path, '<g transform="scale(2)"><circle cx="1" cy="2" r="3"/></g>')
    assert world.discs == (Disc(2.0, -4.0, 6.0),)


def test_a_drawing_may_say_how_large_it_is(tmp_path: Path) -> None:
    line = '<line x2="1" y2="1"/>'
    assert svg(tmp_path, line, 'width="2m" viewBox="0 0 100 50"').walls == (Wall(0.0, 0.0, 20.0, -20.0),)
    assert svg(tmp_path, line, 'width="100" viewBox="0 0 50 50"').walls == (Wall(0.0, 0.0, 1.0, -1.0),)
    assert svg(tmp_path, line, 'width="100mm"').walls == (Wall(0.0, 0.0, 1.0, -1.0),)


def test_the_start_is_marked_by_its_id(tmp_path: Path) -> None:
    world = svg(tmp_path, '<line id="start" x1="10" y1="20" x2="110" y2="20"/><line x2="5"/>')
    assert world.start == Pose(10.0, -20.0, 90.0)
    assert len(world.walls) == 1
    assert svg(tmp_path, '<circle id="start" cx="3" cy="4" r="9"/>').start == Pose(3.0, -4.0, 0.0)


@pytest.mark.parametrize(
    ("inside", "complaint"),
    [
        ('<path id="maze" d="M0 0C1 1 2 2 3 3"/>', r"path 1 \(id 'maze'\): its path has 'C': only straight"),
        ('<line x2="1"/><line x2="wide"/>', "line 2: its x2 is 'wide', but must be a number"),
        ('<line x2="5cm"/>', "line 1: its x2 is '5cm'"),
        ('<ellipse rx="1" ry="2"/>', "ellipse 1: this cannot be a wall; what can: line,"),
        ('<rect width="1"/>', "rect 1: its width and height must be above 0"),
        ('<rect width="1" height="1" rx="0.1"/>', "rect 1: rounded corners"),
        ('<circle r="0"/>', "circle 1: its radius must be above 0"),
        ('<circle transform="scale(1 2)" r="1"/>', "circle 1: .*ellipse"),
        ('<circle transform="matrix(1 0 1 0 0 0)" r="1"/>', "circle 1: .*ellipse"),
        ('<polyline points="1 2 3"/>', "polyline 1: its points must be pairs"),
        ('<polygon points="1 2 x 4"/>', "polygon 1: its points is '1 2 x 4', but must be numbers"),
        ('<path d="L 1 1"/>', "path 1: its path must start with M"),
        ('<path d="1 1"/>', "path 1: its path has a number 1 where a command must be"),
        ('<path d="M 1"/>', "path 1: its path has too few numbers after 'M'"),
        ('<path d="M 1 1 L 2 Z"/>', "path 1: its path has too few numbers after 'L'"),
        ('<path d="M 1 1 z 2 2"/>', "path 1: its path has a number 2 where"),
        ('<path d="M 1 1 ; 2"/>', "path 1: its path has '; 2'"),
        ('<g transform="skewX(3)"/>', "g 1: its transform skewX of 1 numbers is not known"),
        ('<g transform="scale 2"/>', "g 1: its transform is 'scale 2'"),
        ('<line x2="2000000"/>', r"line 1: it reaches 2e\+06, -?0 mm"),
        ('<rect id="start" width="1" height="1"/>', "rect 1 .*the start is a line"),
        ("<g>", "this is no valid SVG"),
    ],
)
def test_what_is_wrong_in_a_drawing_is_named(tmp_path: Path, inside: str, complaint: str) -> None:
    with pytest.raises(DataError, match=complaint):
        svg(tmp_path, inside)


def test_a_drawing_that_is_none(tmp_path: Path) -> None:
    path = tmp_path / "page.svg"
    path.write_text("<html/>", "utf-8")
    with pytest.raises(DataError, match="outermost element is 'html'"):
        load_arena(path)
    with pytest.raises(DataError, match="its viewBox must be four numbers"):
        svg(tmp_path, "", 'width="2m" viewBox="0 0 100"')
    with pytest.raises(DataError, match="its width is '0mm'"):
        svg(tmp_path, "", 'width="0mm" viewBox="0 0 100 100"')


def test_an_obstacle_far_away_is_seen_from_as_far_as_it_reaches() -> None:
    world = World((Wall(0.0, 100.0, 10.0, 100.0),), discs=(Disc(0.0, -100.0, 30.0),))
    assert world.gap(0.0, 0.0, 20.0) == 50.0
    assert world.near(0.0, 0.0, 69.0).is_empty
    assert world.near(0.0, 0.0, 70.0).discs == world.discs
    assert world.near(0.0, 0.0, 100.0).walls == world.walls
    contact = world.contact(0.0, 0.0, (0.0, -1.0), 1000.0, 20.0)
    assert contact is not None
    assert contact == pytest.approx((50.0, 180.0, 1.0))
    assert world.contact(51.0, 0.0, (0.0, -1.0), 1000.0, 20.0) is None
    assert world.contact(0.0, -50.0, (0.0, -1.0), 1000.0, 20.0) == pytest.approx((0.0, 180.0, 1.0))
    assert world.contact(0.0, -50.0, (0.0, 1.0), 10.0, 20.0) is None


def test_several_starts(tmp_path: Path) -> None:
    world = toml(tmp_path, "[[start]]\nx_mm = 1\n[[start]]\ny_mm = 2\nheading_deg = 450\n")
    assert world.start == Pose(1.0, 0.0, 0.0)
    assert world.starts == (Pose(1.0, 0.0, 0.0), Pose(0.0, 2.0, 90.0))
    drawn = '<circle id="start-10" cx="5"/><line id="start" x2="1"/><circle id="start-2" cy="3" r="9"/>'
    world = svg(tmp_path, drawn)
    assert world.starts == (Pose(0.0, 0.0, 90.0), Pose(0.0, -3.0, 0.0), Pose(5.0, 0.0, 0.0))
    assert world.is_empty
    assert svg(tmp_path, "").starts == (HOME,)


def test_wrong_starts(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="start 2: x_mm: 'a' is not a number"):
        toml(tmp_path, "[[start]]\n[[start]]\nx_mm = 'a'\n")
    with pytest.raises(DataError, match=r"start: the start is written \[start\], several"):
        toml(tmp_path, "start = []")
    with pytest.raises(DataError, match="start 2: the start is written"):
        toml(tmp_path, "start = [{}, 3]")
    with pytest.raises(DataError, match=r"circle 2 \(id 'start-1'\): start 1 is there already"):
        svg(tmp_path, '<circle id="start"/><circle id="start-1"/>')
