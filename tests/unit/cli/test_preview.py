"""``turtlewire run --preview`` without a terminal; with one, see the end-to-end tests."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from turtlewire.cli.main import main


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    (tmp_path / "ok.logo").write_text('FD 100 RT 90 PU FD 50 PRINT "x\n', "utf-8")
    (tmp_path / "wrong.logo").write_text("FD 10\nFDD 20\n", "utf-8")
    (tmp_path / "arena.toml").write_text("[[disc]]\nx_mm = 0\ny_mm = 400\nradius_mm = 50\n", "utf-8")


def test_text(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "--preview=only", "ok.logo"]) == 0
    said = capsys.readouterr()
    assert said.out.splitlines() == [
        "ok.logo on sim:walter:",
        "  drawing    0 x 100 mm: x 0 to 0, y 0 to 100",
        "  way        50 x 100 mm: x 0 to 50, y 0 to 100",
        "  path       0.15 m, 0.10 m of it with the pen down",
        said.out.splitlines()[4],
        "  arena      not known; --arena FILE names one",
    ]
    assert "of the robot's time" in said.out
    assert said.err == ""


@pytest.mark.parametrize("way", ["--preview", "--preview=only"])
def test_json(capsys: pytest.CaptureFixture[str], way: str) -> None:
    assert main(["run", way, "--json", "ok.logo", "--arena", "arena.toml"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["drawing"] == {"left_mm": 0.0, "right_mm": 0.0, "bottom_mm": 0.0, "top_mm": 100.0}
    assert found["stays_in_arena"] is True
    assert (found["outcome"], found["is_estimate"], found["path_mm"]) == ("previewed", False, 150.0)


def test_a_wrong_program(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "--preview=only", "wrong.logo"]) == 1
    said = capsys.readouterr()
    assert "  ends       with an error, in line 2" in said.out
    assert "wrong.logo, line 2, column 1: I don't know how to FDD" in said.err
    assert main(["run", "--preview=only", "--json", "wrong.logo"]) == 1
    assert json.loads(capsys.readouterr().out)["error"]["position"] == {
        "file": "wrong.logo",
        "line": 2,
        "column": 1,
    }


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("--preview ok.logo", "there is no terminal to ask"),
        ("--preview -", "cannot the answer: --preview=only"),
        ("--arena arena.toml ok.logo", "--arena is for --preview"),
        ("--preview=only ok.logo --picture a.svg", "--picture is for what a robot draws"),
        ("--preview=only ok.logo --port sim:walter?speed=999", "speed"),
    ],
)
def test_wrong_usage(capsys: pytest.CaptureFixture[str], arguments: str, message: str) -> None:
    assert main(["run", *arguments.split()]) == 2
    assert message in capsys.readouterr().err


def test_nothing_is_run(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "--preview=only", "ok.logo", "--port", "/dev/there-is-no-such-port"]) == 0
    assert "x\n" not in capsys.readouterr().out
    assert not list(Path().glob("*.svg"))
