"""``turtlewire firmware``: its options, its output and its exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from turtlewire.cli.main import main


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_build(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["firmware", "build", "SimpleCar", "--tool", "avr-gcc"]) == 0
    out, err = capsys.readouterr()
    assert out == "SimpleCar.hex\n"
    assert err.startswith("SimpleCar for the uno, built by avr-gcc: ")
    assert err.endswith("%) of RAM\n")
    assert Path("SimpleCar.hex").is_file()


def test_for_programs(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """One object, whatever is done."""
    assert main(["firmware", "build", "Walter", "--board", "mega", "--json", "--output", "out"]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    told = json.loads(out)
    assert told.pop("flash_bytes") > told.pop("ram_bytes") > 0
    assert told == {
        "sketch": "Walter",
        "board": "mega",
        "tool": "avr-gcc",
        "hex": "out/Walter.hex",
        "elf": "out/Walter.elf",
        "flash_command": None,
        "flashed": False,
    }
    assert main(["firmware", "flash", "Walter", "--port", "/dev/ttyTEST", "--dry-run", "--json"]) == 0
    out, err = capfd.readouterr()
    told = json.loads(out)
    assert told["flashed"] is False
    assert told["flash_command"][:2] == ["avrdude", "-p"]
    assert "would be flashed by: avrdude -p atmega328p" in err


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        ("build Nonsense", 2, "there is no sketch 'Nonsense'"),
        ("build .", 2, "there is no sketch '.'"),
        ("flash SimpleCar", 2, "flash needs --port, or --robot"),
        ("flash SimpleCar --port /dev/nowhere", 3, "there is no port /dev/nowhere"),
        ("flash SimpleCar --port /dev/null", 3, "/dev/null is no serial port"),
        ("flash SimpleCar --port serial:///dev/nowhere?baud=9600", 3, "there is no port /dev/nowhere"),
        ("flash SimpleCar --port sim:simple", 2, "sim:simple is simulated: it has no firmware"),
        ("flash SimpleCar --robot simple", 2, "is simulated"),
        ("flash SimpleCar --port socket://robot:2000", 2, "socket://robot:2000 is no serial port"),
        ("flash SimpleCar --port pty", 2, "pty is no serial port"),
        ("flash SimpleCar --port ttyUSB0", 2, "ttyUSB0"),
        ("flash SimpleCar --robot dot", 2, "invalid choice: 'dot'"),
        ("flash SimpleCar --robot elsie --port /dev/ttyUSB0", 2, "leave one out"),
        ("flash SimpleCar --robot elsie", 3, "there is no port /dev/nowhere"),
        ("build SimpleCar --port /dev/nowhere", 2, "build touches no board"),
        ("build SimpleCar --dry-run", 2, "build touches no board"),
        ("build SimpleCar --output elsewhere/robots.toml/x", 1, "cannot build in"),
        ("build broken", 1, "broken does not compile"),
    ],
)
def test_what_is_wrong(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: str, code: int, said: str
) -> None:
    for folder in ("turtlewire", "elsewhere"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "robots.toml").write_text(
            '[elsie]\nport = "/dev/nowhere"\nprotocol = "simple"\n'
        )
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "broken.ino").write_text("what?")
    assert main(["firmware", *arguments.split()]) == code
    assert said in capsys.readouterr().err


@pytest.mark.usefixtures("no_tools")
def test_no_tools(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["firmware", "build", "SimpleCar"]) == 2
    assert "apt install gcc-avr" in capsys.readouterr().err
