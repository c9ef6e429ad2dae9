"""What a program would do: the figures are those of the run itself."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest

import turtlewire
from turtlewire.configuration import target
from turtlewire.errors import DataError, LimitReachedError, LinkError
from turtlewire.logo import LogoError
from turtlewire.preview import CHANCE, KEYBOARD, LONGEST_S, SENSORS, Extent, Touch, preview
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from pathlib import Path

ARENA = """
[start]
x_mm = 1000
y_mm = 1000
heading_deg = 90
[[wall]]
points = [[1500, 0], [1500, 2000]]
"""


def test_extent_and_lengths() -> None:
    found = preview(target("sim:walter"), "fd 100 rt 90 pu fd 50 pd bk 200 cs pu setpos [0 -300]", "p.logo")
    assert found.drawing == pytest.approx(Extent(-150.0, 50.0, 0.0, 100.0))
    assert found.way == pytest.approx(Extent(-150.0, 50.0, -300.0, 100.0))
    # CS drives home with the pen up, and is no new beginning for a robot.
    assert found.path_mm == pytest.approx(100 + 50 + 200 + math.hypot(150, 100) + 300)
    assert found.pen_down_mm == pytest.approx(300)
    assert (found.asks, found.touch, found.has_arena, found.error) == ((), None, False, None)
    assert found.is_whole


def test_nothing_is_drawn() -> None:
    found = preview(target("sim:walter"), 'pu fd 30 print "quiet', "p.logo")
    assert found.drawing is None
    assert found.path_mm == 30


@pytest.mark.parametrize(
    "url", ["sim:walter", "sim:walter?speed=40", "sim:simple", "sim:frame", "sim:walter?basic=yes"]
)
def test_the_time_is_the_time_that_it_takes(url: str) -> None:
    program = "repeat 4 [fd 200 rt 90] wait 120"
    with turtlewire.connect(url) as robot:
        began = robot.statistics.seconds
        for _ in range(4):
            robot.forward(200)
            robot.right(90)
        robot.wait(2)
        robot.finish()
        took = robot.statistics.seconds - began
    assert preview(target(url), program, "p.logo").seconds == pytest.approx(took, rel=0.01)


def test_w14_a_robot_at_a_port_is_as_fast_as_it_was_measured_to_be() -> None:
    """Nothing is at that port, and nothing is sent there."""
    slow = preview(target("/dev/ttyUSB0?mm_per_s_per_unit=0.5&speed=100"), "fd 1000", "p.logo")
    fast = preview(target("/dev/ttyUSB0?mm_per_s_per_unit=1&speed=200"), "fd 1000", "p.logo")
    assert slow.seconds == pytest.approx(1000 / 50, rel=0.02)
    assert fast.seconds == pytest.approx(1000 / 200, rel=0.05)
    basic = preview(target("/dev/ttyUSB0?groups=&boot_s=9"), "fd 100", "p.logo")
    assert basic.seconds < 5
    with pytest.raises(LinkError):
        turtlewire.connect("/dev/ttyUSB0")


def test_the_scale_of_a_robot_that_goes_too_far_is_made_good() -> None:
    found = preview(target("/dev/ttyUSB0?distance_scale=2&turn_scale=0.5"), "fd 100 rt 90 fd 100", "p.logo")
    assert found.way == pytest.approx(Extent(0, 100, 0, 100))


@pytest.mark.parametrize("url", ["sim:walter", "sim:simple", "sim:frame", "/dev/ttyUSB0"])
def test_an_arena(url: str, tmp_path: Path) -> None:
    (tmp_path / "arena.toml").write_text(ARENA, "utf-8")
    arena = str(tmp_path / "arena.toml")
    assert preview(target(url), "fd 100 rt 90 fd 200", "p.logo", arena=arena).touch is None
    found = preview(target(url), "fd 100\n\nfd 600 bk 1", "p.logo", arena=arena)
    assert found.has_arena
    assert isinstance(found.touch, Touch)
    assert found.touch.x_mm == pytest.approx(0, abs=1)  # as the turtle sees it, the wall is 500 mm ahead
    assert 500 - 130 < found.touch.y_mm < 500 - 80
    assert found.touch.line == 3
    # W13: only a WALTER feels it.
    assert isinstance(found.error, LimitReachedError) == (url in ("sim:walter", "/dev/ttyUSB0"))


def test_a_wall_that_is_met_at_an_angle(tmp_path: Path) -> None:
    (tmp_path / "arena.toml").write_text(ARENA, "utf-8")
    found = preview(target("sim:simple"), "rt 30 fd 900", "p.logo", arena=str(tmp_path / "arena.toml"))
    assert found.touch is not None
    assert found.touch.y_mm == pytest.approx(500 - 120, abs=1)  # the car's radius
    assert found.touch.x_mm == pytest.approx(found.touch.y_mm * math.tan(math.radians(30)), abs=1)


def test_no_such_arena() -> None:
    with pytest.raises(turtlewire.TurtlewireError, match="arena file"):
        preview(target("sim:walter"), "fd 1", "p.logo", arena="none.toml")
    assert issubclass(DataError, turtlewire.TurtlewireError)


@pytest.mark.parametrize(
    ("program", "asks"),
    [
        ("fd 10 print pos", ()),
        ("fd random 10", (CHANCE,)),
        ("fd pick [10 20]", (CHANCE,)),
        ("onlimit [bk 10] fd 10", (SENSORS,)),
        ("onlimit [] fd random 5", (CHANCE,)),
        ('make "size readlist fd 10', (KEYBOARD,)),
        ("if keyp [fd 10]", (KEYBOARD,)),
    ],
)
def test_what_makes_it_an_estimate(program: str, asks: tuple[str, ...]) -> None:
    assert preview(target("sim:walter"), program, "p.logo").asks == asks


def test_a_program_without_an_end() -> None:
    found = preview(target("sim:walter"), 'forever [catch "error [fd 100 bk 100]]', "p.logo")
    assert not found.is_whole
    assert found.error is None
    assert found.seconds > LONGEST_S


def test_a_wrong_program() -> None:
    found = preview(target("sim:walter"), "fd 10\nfdd 20", "p.logo")
    assert isinstance(found.error, LogoError)
    assert found.position is not None
    assert found.position[:3] == ("p.logo", 2, 1)
    assert found.path_mm == 10


def test_the_seed_decides() -> None:
    one, same, other = (
        preview(target("sim:walter"), "fd random 1000", "p", seed=n).path_mm for n in (1, 1, 2)
    )
    assert one == same != other


def test_it_begins_where_the_robot_stands() -> None:
    """Absolute places stay what they are, and what stands around the robot stays where it is."""
    program = "fd 50 setpos [0 0] seth 90 fd 10 print pos home"
    at = Pose(100.0, -40.0, 90.0)
    found = preview(target("sim:walter"), program, "p.logo", start=at)
    assert found.way == pytest.approx(Extent(0.0, 150.0, -40.0, 0.0))
    assert found.path_mm == pytest.approx(50 + math.hypot(150, 40) + 10 + 10)
    assert [point for stroke in found.strokes for point in stroke.points] == [
        pytest.approx(point, abs=1e-9) for point in [(100, -40), (150, -40), (0, 0), (10, 0), (0, 0)]
    ]


def test_walls_are_where_they_were_when_it_begins_elsewhere(tmp_path: Path) -> None:
    arena = tmp_path / "arena.toml"
    arena.write_text(ARENA, "utf-8")
    # Home is 500 mm before the wall, looking at it; from here it is 200 mm, to the right.
    at = Pose(-100.0, 300.0, 270.0)
    found = preview(target(f"sim:walter?arena={arena}"), "rt 90 fd 1000", "p.logo", start=at)
    assert isinstance(found.error, LimitReachedError)
    assert found.touch is not None
    assert found.touch.x_mm == pytest.approx(-100.0, abs=1)
    assert 350.0 < found.touch.y_mm < 450.0
