"""``turtlewire robots``: what has a name, and what is wrong with it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest

from turtlewire.cli.main import main

if TYPE_CHECKING:
    from pathlib import Path

GOOD = '[elsie]\nport = "/dev/ttyUSB0"\nspeed = 60\n[herbie]\nport = "sim:simple"\nslip = 0.1\nfaults = "lose:0.1"\n'


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    (tmp_path / "turtlewire").mkdir()
    return tmp_path / "turtlewire" / "robots.toml"


def test_the_list(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file.write_text(GOOD, "utf-8")
    assert main(["robots"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert [line.split(maxsplit=2) for line in out.splitlines()] == [
        ["elsie", "walter", "/dev/ttyUSB0, speed 60"],
        ["herbie", "simple", "sim:simple, slip 0.1, faults lose:0.1"],
    ]


def test_a_calibration_is_not_printed_in_full(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file.write_text('[herbie]\nport = "sim:simple"\n[herbie.calibration]\ntrim_deg = 2.0\n', "utf-8")
    assert main(["robots"]) == 0
    assert capsys.readouterr().out.endswith("sim:simple, calibration measured\n")
    assert main(["robots", "--json"]) == 0
    (herbie,) = json.loads(capsys.readouterr().out)["robots"]
    assert herbie["settings"] == {"calibration": {"trim_deg": 2.0}}


def test_for_programs(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file.write_text(GOOD, "utf-8")
    assert main(["robots", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["file"] == str(file)
    assert told["robots"][0] == {
        "name": "elsie",
        "port": "/dev/ttyUSB0",
        "protocol": "walter",
        "settings": {"speed": 60},
        "error": None,
    }
    assert len(told["robots"]) == 2


def test_what_is_wrong_hides_nothing(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file.write_text('[dot]\nport = "sim:frame"\ncolour = "red"\n[marvin]\nport = 5\n' + GOOD, "utf-8")
    assert main(["robots"]) == 1
    out, err = capsys.readouterr()
    assert len(out.splitlines()) == 2
    assert "unknown option 'colour'" in err
    assert f"{file}, line 4, [marvin]: '5' is no port" in err
    assert main(["robots", "--json"]) == 1
    out, err = capsys.readouterr()
    assert err == ""
    assert [bool(robot["error"]) for robot in json.loads(out)["robots"]] == [True, True, False, False]


def test_none(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots"]) == 0
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"there are no robots in {file}")


def test_no_toml(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file.write_text("[elsie", "utf-8")
    assert main(["robots"]) == 1
    assert capsys.readouterr().err.startswith(f"turtlewire: {file}: ")
