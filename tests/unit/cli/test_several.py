"""``turtlewire run`` with several robots: what they are called, how each is driven, and what is told of them."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest

from turtlewire.cli.main import main
from turtlewire.cli.progress import Bar
from turtlewire.connect import connect

CONFIGURED = """
[elsie]
port = "sim:walter"
speed = 60
[herbie]
port = "sim:simple"
"""
DANCE = """\
show who
fd 40
tell "herbie
fd 20 rt 90
tell [elsie herbie]
fd 10
each [show (se who pos)]
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    (tmp_path / "turtlewire").mkdir()
    (tmp_path / "turtlewire" / "robots.toml").write_text(CONFIGURED, "utf-8")
    (tmp_path / "dance.logo").write_text(DANCE, "utf-8")


def told(capsys: pytest.CaptureFixture[str], program: str, *options: str) -> dict[str, Any]:
    """The JSON object of a run of this text."""
    Path("told.logo").write_text(program, "utf-8")
    main(["run", "told.logo", *options, "--json"])
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


WALL = "[[wall]]\npoints = [[-500, 300], [500, 300]]\n"
BOTH = ("--robot", "elsie", "--robot", "herbie")


def test_each_is_told_by_its_name(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "dance.logo", *BOTH, "--picture", "drawn.svg"]) == 0
    out, err = capsys.readouterr()
    assert out == "elsie\n[elsie 0 50]\n[herbie 10 20]\n"
    heads = [line[:13].strip() for line in err.splitlines()]
    elsie = ["elsie:", "sent", "driven", "took", "host pose", "robot pose", "deviation"]
    herbie = ["herbie:", "sent", "driven", "took", "host pose", "deviation"]
    assert heads == ["dance.logo: d", *elsie, *herbie, "drawn: drawn."]
    assert "host pose  x 0 mm, y 50 mm" in err
    assert "host pose  x 10 mm, y 20 mm" in err


def test_a_picture_has_a_colour_for_each(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["run", "dance.logo", *BOTH, "--picture", "drawn.svg", "--picture", "drawn.png"]) == 0
    drawn = (tmp_path / "drawn.svg").read_text("utf-8")
    groups = re.findall(r"<g [^>]*>", drawn)
    inks = {each: next(group for group in groups if f'id="{each}"' in group) for each in ("ink", "ink-2")}
    colours = {re.findall(r'stroke="(#\w+)"', group)[0] for group in inks.values()}
    assert len(colours) == 2
    assert (tmp_path / "drawn.png").read_bytes().startswith(b"\x89PNG")
    capsys.readouterr()


def test_walls_around_any_of_them_are_drawn(tmp_path: Path) -> None:
    (tmp_path / "walls.toml").write_text(WALL, "utf-8")
    ports = ("--port", "sim:walter", "--port", "car=sim:simple?arena=walls.toml")
    (tmp_path / "away.logo").write_text("fd 10", "utf-8")
    assert main(["run", "away.logo", *ports, "--picture", "drawn.svg"]) == 0
    assert 'id="obstacles"' in (tmp_path / "drawn.svg").read_text("utf-8")


@pytest.mark.parametrize(
    ("options", "names"),
    [
        ("--robot walter --robot simple", "walter simple"),
        ("--robot simple --robot walter", "simple walter"),
        ("--port sim:walter --port sim:walter --port sim:walter", "walter walter2 walter3"),
        ("--port sim:simple --robot elsie", "simple elsie"),
        ("--robot elsie --port sim:simple", "elsie simple"),
        ("--port dot=sim:frame --port herbie", "dot herbie"),
        ("--robot walter --port rosa=sim:simple", "walter rosa"),
        ("--robot simple --port sim:simple", ""),  # what it speaks, and where it is
        ("--robot simple", ""),
        ("", ""),
        ("--robot elsie", "elsie"),
        ("--port Rosa=sim:simple?wheelbase_mm=90", "Rosa"),
    ],
)
def test_what_they_are_called(capsys: pytest.CaptureFixture[str], options: str, names: str) -> None:
    wanted = names.split() or ["turtle"]
    words = options.split()
    assert told(capsys, "show who", *words)["output"] == f"{wanted[0]}\n"
    found = told(capsys, f"tell [{' '.join(wanted)}] show who each [fd 1]", *words)
    assert found["outcome"] == "done"
    if len(wanted) > 1:
        assert found["output"] == f"[{' '.join(wanted)}]\n"
        assert list(found["robots"]) == wanted
    else:
        assert "robots" not in found


@pytest.mark.parametrize(
    ("options", "code", "said"),
    [
        ("--robot elsie --robot elsie", 2, "two robots are called elsie: give one of them another name"),
        ("--port Elsie=sim:walter --robot elsie", 2, "two robots are called elsie"),
        ("--robot elsie --port /dev/no-such-port", 3, "there is no port /dev/no-such-port"),
        ("--robot simple --port sim:frame", 2, "mean different robots: leave one out"),
        ("--robot elsie --robot herbie --set marvin:speed=9", 2, "no robot here is called marvin; there is elsie"),
        ("--robot elsie --robot herbie --set window=4", 2, "--set window=4: write NAME=VALUE; the names are baud"),
        ("--robot elsie --robot herbie --set herbie:window=9", 2, "window is 9, but must be from 1 to 8"),
        ("--robot elsie --port dot=sim:frame --require-replies", 2, "a robot that speaks frame never answers"),
        ("--robot elsie --port /dev/no-such-port --speed max", 2, "--speed max is for the simulated robot"),
    ],
)  # fmt: skip
def test_what_is_refused(capsys: pytest.CaptureFixture[str], options: str, code: int, said: str) -> None:
    assert main(["run", "dance.logo", *options.split()]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err


def test_settings_for_all_and_for_one(capsys: pytest.CaptureFixture[str]) -> None:
    settings = ("--set", "speed=50", "--set", "herbie:window=3", "--set", "elsie:gentle=no", "--statistics")
    found = told(capsys, "fd 1", *BOTH, *settings)["robots"]
    elsie, herbie = found["elsie"]["connection"]["settings"], found["herbie"]["connection"]["settings"]
    assert (elsie["speed"], elsie["gentle"], "window" in elsie) == ("50", "False", False)
    assert (herbie["speed"], herbie["window"], "gentle" in herbie) == ("50", "3", False)
    assert (elsie["seed"], herbie["seed"]) == ("0", "1")  # a chance of its own
    main(["run", "dance.logo", *BOTH, "--statistics"])
    err = capsys.readouterr().err
    assert err.index("statistics of elsie:") < err.index("commands  ") < err.index("statistics of herbie:")


def test_for_programs(capsys: pytest.CaptureFixture[str]) -> None:
    found = told(capsys, DANCE, *BOTH)
    elsie, herbie = found["robots"]["elsie"], found["robots"]["herbie"]
    assert elsie["host_pose"] == pytest.approx({"x_mm": 0.0, "y_mm": 50.0, "heading_deg": 0.0}, abs=1e-6)
    assert herbie["host_pose"] == pytest.approx({"x_mm": 10.0, "y_mm": 20.0, "heading_deg": 90.0}, abs=1e-6)
    assert elsie["robot_pose"] is not None
    assert herbie["robot_pose"] is None
    assert elsie["statistics"]["distance_mm"] == pytest.approx(50.0)
    assert {"statistics", "host_pose", "drawing"}.isdisjoint(found)
    assert told(capsys, "fd 1 forwrd", *BOTH)["error"]["position"]["column"] == 6


def test_a_program_that_names_its_robots_runs_with_one_of_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert told(capsys, 'ask "elsie [fd 10 show pos]', "--robot", "elsie")["output"] == "[0 10]\n"
    error = told(capsys, 'tell "herbie', "--robot", "elsie")["error"]["message"]
    assert "tell wants the name of a robot: elsie." in error


def test_warnings_say_whose_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    found = told(capsys, "each [fd 30]", "--robot", "elsie", "--port", "old=sim:walter?basic=1")
    assert found["warnings"]
    assert all(warning.startswith("old: ") for warning in found["warnings"])


def test_the_bar_counts_them_together() -> None:
    with connect("sim:walter") as elsie, connect("sim:simple") as herbie:
        for robot in (elsie, herbie):
            robot.forward(500)
            robot.finish()
        figures = Bar([elsie, herbie], lambda: 0.5, shown=False)._figures()
        commands = elsie.statistics.commands
    assert figures.startswith(f"1.00 m, {commands} commands, ")


class TestPreview:
    def test_text(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["run", "--preview=only", "dance.logo", *BOTH]) == 0
        out = capsys.readouterr().out
        elsie, herbie = out.split("dance.logo on herbie:\n")
        assert elsie.startswith("dance.logo on elsie:\n  drawing    0 x 50 mm: x 0 to 0, y 0 to 50\n")
        assert "  drawing    10 x 20 mm: x 0 to 10, y 0 to 20\n" in herbie
        assert "path       0.05 m" in elsie
        assert "path       0.03 m" in herbie

    def test_json(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["run", "--preview", "--json", "dance.logo", *BOTH]) == 0
        found = json.loads(capsys.readouterr().out)
        assert (found["outcome"], found["is_whole"], found["error"]) == ("previewed", True, None)
        assert found["robots"]["elsie"]["path_mm"] == pytest.approx(50.0)
        assert found["robots"]["herbie"]["path_mm"] == pytest.approx(30.0)
        assert found["robots"]["herbie"]["seconds"] > 0.0
        assert "path_mm" not in found

    def test_a_limit_is_the_one_of_the_robot_that_met_it(
        self, capsys: pytest.CaptureFixture[str], tmp_path: Path
    ) -> None:
        (tmp_path / "walls.toml").write_text(WALL, "utf-8")
        (tmp_path / "far.logo").write_text("tell [free caught] fd 400", "utf-8")
        ports = ("--port", "free=sim:walter", "--port", "caught=sim:walter?arena=walls.toml")
        assert main(["run", "--preview", "--json", "far.logo", *ports]) == 3
        found = json.loads(capsys.readouterr().out)["robots"]
        assert found["free"]["touch"] is None
        assert found["caught"]["touch"]["line"] == 1

    def test_somebody_goes_on_where_it_pauses(
        self, capsys: pytest.CaptureFixture[str], tmp_path: Path
    ) -> None:
        program = 'to f\nfd 10\npause\nfd 20\nend\nstep "f f'
        (tmp_path / "pause.logo").write_text(program, "utf-8")
        assert main(["run", "--preview", "--json", "pause.logo"]) == 0
        found = json.loads(capsys.readouterr().out)
        assert found["path_mm"] == pytest.approx(30.0)
        assert found["asks"] == ["reads the keyboard"]
