"""``turtlewire run`` on any robot: by protocol, by name, with faults and with statistics."""

from __future__ import annotations

import json
import re
import sys
from typing import TYPE_CHECKING

import pytest

from turtlewire.cli.main import main
from turtlewire.cli.progress import Bar
from turtlewire.connect import connect

if TYPE_CHECKING:
    from pathlib import Path

CONFIGURED = """
[elsie]
port = "sim:walter"
gentle = false
[herbie]
port = "sim:simple"
window = 4
faults = "split:1"
[dot]
port = "/dev/no-such-port"
protocol = "frame"
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    (tmp_path / "turtlewire").mkdir()
    (tmp_path / "turtlewire" / "robots.toml").write_text(CONFIGURED, "utf-8")
    (tmp_path / "corner.logo").write_text("FD 50 RT 90 FD 20\n", "utf-8")


@pytest.mark.parametrize(
    "which",
    [
        "--robot simple",
        "--robot frame",
        "--port sim:simple?wheelbase_mm=100",
        "--port sim:frame?dialect=telemetry",
        "--robot herbie",
        "--port herbie",
    ],
)
def test_robots_that_count_no_commands(capsys: pytest.CaptureFixture[str], which: str) -> None:
    assert main(["run", "corner.logo", "--picture", "p.svg", *which.split()]) == 0
    err = capsys.readouterr().err
    lines = [line[:13].strip() for line in err.splitlines()]
    assert lines == ["corner.logo:", "sent", "driven", "took", "host pose", "deviation", "drawn"]
    assert "host pose  x 20 mm, y 50 mm, heading 90 degrees" in err
    assert "bytes came back" in err


@pytest.mark.parametrize("robot", ["simple", "frame", "herbie", "elsie"])
def test_for_programs(capsys: pytest.CaptureFixture[str], robot: str) -> None:
    assert main(["run", "corner.logo", "--robot", robot, "--json", "--statistics"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["outcome"] == "done"
    assert told["host_pose"] == {"x_mm": 20.0, "y_mm": 50.0, "heading_deg": 90.0}
    assert (told["robot_pose"] is not None) == (robot == "elsie")
    assert told["statistics"]["bytes_sent"] > 20
    assert told["connection"]["robot"] == {"herbie": "simple", "elsie": "walter"}.get(robot, robot)
    if robot == "herbie":
        assert told["connection"]["settings"]["window"] == "4"
        assert told["connection"]["faults"] == {"lost": 0, "added": 0, "flipped": 0, "duplicated": 0}
    if robot == "elsie":
        assert told["connection"]["settings"]["gentle"] == "no"
        assert "faults" not in told["connection"]


def test_what_was_drawn_is_compared_with_the_exact_path(capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        main(["run", "corner.logo", "--port", "sim:frame?right_factor=1.05&start=40,-30,90", "--json"]) == 0
    )
    told = json.loads(capsys.readouterr().out)
    assert told["drawing"] == "seen"
    # 5% more on one side turn it by 2 degrees each 100 mm.
    assert 0.5 < told["deviation_mm"]["largest"] < 5.0
    assert 0.1 < told["deviation_mm"]["mean"] < told["deviation_mm"]["largest"]
    assert main(["run", "corner.logo", "--port", "sim:frame"]) == 0
    assert re.search(r"deviation  0\.0\d mm at most, 0\.0\d mm on average", capsys.readouterr().err)


def test_there_is_no_deviation_of_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for text, code in (("PU FD 50\n", 0), ("FD 50 ERROR.HERE\n", 1)):
        (tmp_path / "nothing.logo").write_text(text, "utf-8")
        assert main(["run", "nothing.logo", "--robot", "frame", "--json"]) == code
        assert json.loads(capsys.readouterr().out)["deviation_mm"] is None


def test_what_noise_does(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["run", "corner.logo", "--port", "sim:simple", "--statistics"]
    assert main(command) == 0
    clean = capsys.readouterr().err
    assert "  resynchronisations   1\n" in clean
    assert "  settings " in clean
    assert "faults" not in clean
    assert main([*command, "--faults", "lose:0.05,to:host,seed:1"]) in (0, 3)
    noisy = capsys.readouterr().err
    assert "\nstatistics:\n  turtlewire " in noisy
    assert "  faults               lost " in noisy
    assert "lost 0" not in noisy
    assert "  resynchronisations   1\n" not in noisy


def test_without_the_option_no_statistics(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "corner.logo"]) == 0
    assert "statistics" not in capsys.readouterr().err
    assert main(["run", "corner.logo", "--json"]) == 0
    assert "connection" not in json.loads(capsys.readouterr().out)


def test_statistics_of_a_run_that_failed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "corner.logo", "--faults", "close:0.3", "--statistics"]) == 3
    err = capsys.readouterr().err
    assert "a fault that was asked for" in err
    assert "statistics:\n" in err
    assert "  bytes_sent " in err


def test_a_setting_on_the_command_line_counts_more(capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        main(["run", "corner.logo", "--robot", "elsie", "--set", "gentle=yes", "--json", "--statistics"]) == 0
    )
    assert json.loads(capsys.readouterr().out)["connection"]["settings"]["gentle"] == "True"


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        ("--robot marvin", 2, "'marvin' (choose from walter, simple, frame, or a robot in a file: "),
        ("--robot /dev/ttyUSB0", 2, "a port is named by --port"),
        ("--robot simple --port sim:frame", 2, "mean different robots: leave one out"),
        (
            "--robot simple --set gentle=1",
            2,
            "--set gentle=1: write NAME=VALUE; the names are baud, speed, calib",
        ),
        ("--robot simple --set window=9", 2, "the setting window is 9, but must be from 1 to 8"),
        ("--robot simple --set window=x", 2, "'x' is no value for window, which must be a whole number"),
        ("--robot frame --require-replies", 2, "a robot that speaks frame never answers"),
        ("--robot dot", 3, "there is no port /dev/no-such-port"),
        ("--faults nonsense", 2, "faults 'nonsense': 'nonsense' means nothing; write NAME:VALUE"),
        ("--port sim:simple?window=9", 2, "window is 9"),
        ("--port sim:simple?colour=red", 2, "a simulated robot and its driver have pace, faults, baud"),
        ("--port sim:frame?dialect=none.toml", 1, "none.toml: No such file or directory"),
    ],
)
def test_what_is_refused(capsys: pytest.CaptureFixture[str], arguments: str, code: int, said: str) -> None:
    assert main(["run", "corner.logo", *arguments.split()]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err


def test_replies_are_no_matter_to_a_car(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "corner.logo", "--robot", "simple", "--require-replies"]) == 0
    assert main(["run", "corner.logo", "--port", "sim:walter?basic=1", "--require-replies"]) == 3
    assert "does not answer" in capsys.readouterr().err


def test_the_bar_of_robots_that_count_no_commands() -> None:
    for url, counts in (("sim:simple", False), ("sim:walter", True)):
        with connect(url) as robot:
            figures = Bar([robot], lambda: 0.5, shown=False)._figures()
        assert figures.startswith("0.00 m, ")
        assert ("commands" in figures) == counts


def test_the_url_of_a_simulated_robot_counts_more_than_the_seed(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["run", "corner.logo", "--port", "sim:walter?seed=3", "--seed", "5", "--json", "--statistics"]
    assert main(command) == 0
    assert json.loads(capsys.readouterr().out)["connection"]["settings"] == {"seed": "3", "pace": "max"}
