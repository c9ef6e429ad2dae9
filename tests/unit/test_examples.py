"""Every example program runs, and draws the picture that the documentation shows."""

from __future__ import annotations

import random
import re
import shlex
from pathlib import Path

import pytest

import turtlewire
from turtlewire import picture
from turtlewire.cli.main import main
from turtlewire.logo import Interpreter

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.logo"))
URLS = {"maze": f"sim:walter?arena={ROOT}/examples/maze.toml"}


def test_there_are_ten() -> None:
    assert len(EXAMPLES) == 10
    pictures = {path.stem for path in (ROOT / "docs/pictures").glob("*.svg")}
    assert {path.stem for path in EXAMPLES} == pictures - {"drive", "duet"}  # a terminal; two robots


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_draws_its_picture(path: Path) -> None:
    with turtlewire.connect(URLS.get(path.stem, "sim:walter")) as robot:
        output: list[str] = []
        interpreter = Interpreter(robot, write=output.append, random=random.Random(0))
        interpreter.run(path.read_text("utf-8"), path.name)
        robot.finish()
        drawn = picture.svg(robot.trace, title=f"examples/{path.name}", obstacles=robot.obstacles)
        deviation = robot.reported_pose().distance_to(robot.pose.x_mm, robot.pose.y_mm)

    assert drawn == (ROOT / f"docs/pictures/{path.stem}.svg").read_text("utf-8"), "run `make pictures`"
    assert deviation < 1.0
    assert robot.statistics.fences_lost == 0


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_says_what_it_shows_and_is_in_the_gallery(path: Path) -> None:
    assert re.match(r"; \S.{20,}", path.read_text("utf-8"))
    gallery = (ROOT / "docs/examples.md").read_text("utf-8")
    assert f"pictures/{path.stem}.svg" in gallery
    assert f"../examples/{path.name}" in gallery


def test_two_robots_draw_the_picture_that_the_manual_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The program and the command are the manual's."""
    manual = (ROOT / "docs/logo.md").read_text("utf-8")
    program = re.search(
        r"^```text\n(; duet\.logo: .*?)^```\n\n```text\n\$ turtlewire (.*?)\n",
        manual,
        re.MULTILINE | re.DOTALL,
    )
    assert program is not None
    monkeypatch.chdir(tmp_path)
    (tmp_path / "duet.logo").write_text(program[1], "utf-8")
    assert main(shlex.split(program[2])) == 0
    assert (tmp_path / "duet.svg").read_text("utf-8") == (ROOT / "docs/pictures/duet.svg").read_text("utf-8")
