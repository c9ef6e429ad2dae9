"""``turtlewire doctor`` of simulated robots in this process, and what it writes; of ports: tests/end_to_end."""

from __future__ import annotations

import json
import sys
import tomllib
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.cli.main import main

if TYPE_CHECKING:
    from pathlib import Path

OTHERS = """\
# my robots

[herbie]   # the car
port = "socket://herbie.local:2000"
protocol = "simple"
window = 4 # fast
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    return tmp_path / "turtlewire" / "robots.toml"


def write(file: Path, text: str) -> None:
    file.parent.mkdir(exist_ok=True)
    file.write_text(text, "utf-8")


def doctor(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, Any]:
    """The exit code, and the JSON object."""
    code = main(["doctor", *arguments, "--json"])
    out, err = capsys.readouterr()
    assert err.count("\n") <= 1, err  # where it was written
    told = json.loads(out)
    assert told["exit_code"] == code
    return code, told


# ---------------------------------------------------------------- what it tells


def test_a_simulated_walter(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "sim:walter?groups=Q&seed=3"]) == 0
    out, err = capsys.readouterr()
    assert out.splitlines()[0] == "found: walter (certain)"
    assert "  groups      Q: yes" in out
    assert "  pose        x 0 mm, y 0 mm, heading 0 degrees" in out
    assert "  boot        it was there at once" in out
    assert '  [NAME]\n  port = "sim:walter"\n  groups = "Q"\n  seed = 3\n' in out
    assert "run examples/rose.logo --port 'sim:walter?groups=Q&seed=3'" in out
    assert "nothing that is sent can move a robot" in err
    assert "the link  walter" in err
    assert not file.exists()


def test_a_simulated_car(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, told = doctor(capsys, "sim:simple")
    assert code == 0
    assert told["outcome"] == "found"
    assert told["findings"]["protocol"] == "simple"
    assert told["findings"]["facts"] == {"window": 8}
    assert told["findings"]["round_trip"]["times"] == 20
    assert told["entry"] == {"name": None, "lines": {"port": "sim:simple"}}
    assert told["written"] == []


def test_a_robot_that_never_says_anything(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "sim:frame"]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert "no robot was found at sim:frame" in err
    assert "turtlewire doctor sim:frame --name NAME --write --protocol frame" in err
    code, told = doctor(capsys, "sim:frame")
    assert (code, told["outcome"], told["entry"]) == (3, "nothing", None)


def test_taken_at_ones_word(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "sim:frame", "--protocol", "frame", "--name", "dot", "--write"]) == 0
    out, _ = capsys.readouterr()
    assert out.startswith("taken at your word: frame; nothing has confirmed it")
    assert tomllib.loads(file.read_text("utf-8")) == {"dot": {"port": "sim:frame"}}
    # A car always answers: silence is none.
    assert main(["doctor", "sim:frame", "--protocol", "simple"]) == 3


def test_a_dialect_with_another_crc_cannot_be_driven_yet(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from importlib import resources

    text = (resources.files("turtlewire.protocols.frame") / "dialects" / "telemetry.toml").read_text("utf-8")
    write(file, "")
    mine = file.parent / "mine.toml"
    mine.write_text(
        text.replace("CRC-8/SMBUS", "CRC-8/ROHC").replace('dialect = "telemetry"', 'dialect = "mine"')
    )
    robot = f"sim:frame?dialect={mine}"
    assert main(["doctor", robot, "--name", "dot", "--write"]) == 1
    out, err = capsys.readouterr()
    assert "its CRC is another than this dialect's" in out
    assert (
        "no entry was written: its CRC is CRC-8/ROHC from magic, and the dialect telemetry has another" in err
    )
    assert file.read_text("utf-8") == ""
    # With the file it can.
    assert main(["doctor", robot, "--name", "dot", "--write", "--dialect", str(mine)]) == 0
    assert tomllib.loads(file.read_text("utf-8"))["dot"]["dialect"] == str(mine)
    assert main(["run", "--robot", "dot", "-"]) in (0, 1)


# ---------------------------------------------------------------- what it writes


def test_what_is_there_stays(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(file, OTHERS)
    code, told = doctor(capsys, "sim:walter", "--name", "elsie", "--write")
    assert code == 0
    assert told["written"] == [str(file)]
    text = file.read_text("utf-8")
    assert text.startswith(OTHERS)
    assert tomllib.loads(text)["elsie"] == {"port": "sim:walter"}
    assert main(["robots"]) == 0


def test_without_write_nothing_is_written_where_nobody_can_be_asked(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["doctor", "sim:walter", "--name", "elsie"]) == 0
    assert "  [elsie]" in capsys.readouterr().out
    assert not file.exists()


def test_a_robot_of_that_name_at_another_port_keeps_its_entry(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(file, OTHERS)
    assert main(["doctor", "sim:walter", "--name", "herbie", "--write"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "has a robot herbie already, at socket://herbie.local:2000" in err
    assert "examining" not in err  # it is said before anything is done
    assert file.read_text("utf-8") == OTHERS


def test_unless_it_is_to_be_replaced(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(file, OTHERS)
    assert main(["doctor", "sim:walter", "--name", "herbie", "--write", "--replace"]) == 0
    _, err = capsys.readouterr()
    assert "herbie speaks another protocol now; left out: protocol, window" in err
    assert file.read_text("utf-8").startswith("# my robots\n\n[herbie]   # the car\n")
    assert tomllib.loads(file.read_text("utf-8")) == {"herbie": {"port": "sim:walter"}}


def test_a_robot_that_is_there_already_keeps_its_other_settings(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(file, '[dream]\nport = "sim:simple"\nspeed = 60 # slow\nslip = 0.1\n')
    code, told = doctor(capsys, "dream", "--write")
    assert code == 0
    assert told["entry"]["name"] == "dream"
    assert file.read_text("utf-8") == '[dream]\nport = "sim:simple"\nspeed = 60 # slow\nslip = 0.1\n'


# ---------------------------------------------------------------- what means nothing


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["sim:walter", "--write"], "--name NAME"),
        (["sim:walter", "--name", "walter"], "cannot be the name of a robot"),
        (["sim:walter", "--name", "a b"], "cannot be the name of a robot"),
        (["sim:walter", "--baud", "9600"], "is no serial port"),
        (["socket://localhost:1", "--baud", "9600"], "has no rate"),
        (["pty"], "with no robot at it yet"),
        (["elsie"], "'elsie' is no port"),
        (["ttyUSB0?"], "is no port"),
        (["/dev/ttyUSB0?protocol=walter"], "leave out protocol"),
        (["/dev/ttyUSB0", "--dialect", "missing.toml"], "missing.toml"),
        (["sim:walter?colour=red"], "unknown option 'colour'"),
    ],
)
def test_what_means_nothing_is_said(
    file: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    code = main(["doctor", *arguments])
    assert code in (1, 2)
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err
    assert "Traceback" not in err
    code_again, told = doctor(capsys, *arguments)
    assert (code_again, told["outcome"]) == (code, "error")
    assert words in told["error"]


@pytest.mark.parametrize(
    "arguments",
    [["--baud", "fast"], ["--baud", "9600,"], ["--baud", "7"], ["--boot-s", "-1"], ["--boot-s", "nan"]],
)
def test_numbers(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["doctor", "/dev/ttyUSB0", *arguments])
    assert ended.value.code == 2


def test_a_file_that_is_no_toml_is_said_before_anything_is_done(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(file, "[elsie")
    assert main(["doctor", "sim:walter", "--name", "elsie", "--write"]) == 1
    _, err = capsys.readouterr()
    assert err.startswith(f"turtlewire: {file}: ")
    assert file.read_text("utf-8") == "[elsie"


def test_a_port_that_is_not_there(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, told = doctor(capsys, "/dev/ttyNOWHERE")
    assert (code, told["outcome"]) == (3, "error")
    assert "there is no port /dev/ttyNOWHERE" in told["error"]
