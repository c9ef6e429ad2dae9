"""What a program would do, found out in a process of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from turtlewire.configuration import target
from turtlewire.console import previewing
from turtlewire.console.previewing import preview_there
from turtlewire.console.refusals import Refused
from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from pathlib import Path


def test_its_figures_and_its_lines() -> None:
    found = preview_there(target("sim:walter"), "fd 50 rt 90 pu fd 20", "p.logo", Pose(10.0, 0.0, 0.0), None)
    assert found["drawing"] == {"left_mm": 10, "right_mm": 10, "bottom_mm": 0, "top_mm": 50}
    assert found["way"] == {"left_mm": 10, "right_mm": 30, "bottom_mm": 0, "top_mm": 50}
    assert (found["path_mm"], found["pen_down_mm"]) == (70, 50)
    assert found["seconds"] > 0.5
    assert found["is_whole"]
    assert found["strokes"] == [
        {"pen": True, "points": [[10, 0], [10, 50]]},
        {"pen": False, "points": [[10, 50], [30, 50]]},
    ]


def test_the_target_is_the_robot_with_its_settings(tmp_path: Path) -> None:
    arena = tmp_path / "wall.toml"
    arena.write_text("[[wall]]\npoints = [[-500, 300], [500, 300]]\n", "utf-8")
    found = preview_there(target(f"sim:walter?arena={arena}"), "rt 0\nfd 1000", "p.logo", HOME, None)
    assert found["stays_in_arena"] is False
    assert found["touch"]["line"] == 2
    assert found["error"]["kind"] == "LimitReachedError"
    slow = preview_there(target("sim:walter?mm_per_s_per_unit=0.1"), "fd 100", "p.logo", HOME, None)
    fast = preview_there(target("sim:walter?mm_per_s_per_unit=1.0"), "fd 100", "p.logo", HOME, None)
    assert slow["seconds"] > 5 * fast["seconds"]


def test_an_error_has_its_place(tmp_path: Path) -> None:
    found = preview_there(target("sim:frame"), "fd 10\nprint 1 / 0", "p.logo", HOME, tmp_path)
    assert (found["error"]["kind"], found["error"]["number"], found["error"]["line"]) == ("logo", 4, 2)


@pytest.mark.parametrize("source", ["forever []", "forever [fd 1 rt 1]", 'forever [catch "error [fd 1]]'])
def test_what_goes_on_and_on_is_not_looked_at_to_its_end(source: str, tmp_path: Path) -> None:
    found = preview_there(target("sim:walter"), source, "p.logo", HOME, tmp_path, longest_s=1.0)
    assert found["is_whole"] is False
    if "fd" in source:
        assert found["path_mm"] > 100
        assert found["strokes"]
        assert sum(len(stroke["points"]) for stroke in found["strokes"]) <= 2 * previewing.MOST_POINTS


def test_one_that_takes_all_memory_ends_in_an_error() -> None:
    program = 'make "a "x repeat 40 [make "a word :a :a]'
    found = preview_there(target("sim:walter"), program, "p.logo", HOME, None)
    assert found["error"]["text"] == "out of space"
    assert found["error"]["line"] == 1


def test_its_files_are_confined_too(tmp_path: Path) -> None:
    found = preview_there(target("sim:walter"), 'openread "/etc/passwd', "p.logo", HOME, tmp_path)
    assert found["error"]["number"] == 40


def test_so_many_at_a_time_and_no_more() -> None:
    taken = 0
    while previewing._WAITING.acquire(blocking=False):
        taken += 1
    try:
        with pytest.raises(Refused) as refused:
            preview_there(target("sim:walter"), "fd 1", "p.logo", HOME, None)
        assert (refused.value.status, refused.value.code) == (429, "busy")
    finally:
        for _ in range(taken):
            previewing._WAITING.release()
    assert taken > 5
    assert preview_there(target("sim:walter"), "fd 1", "p.logo", HOME, None)["path_mm"] == 1
