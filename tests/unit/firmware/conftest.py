"""Real compilers, with Arduino's core compiled once for all tests, and never in anybody's home."""

from __future__ import annotations

import json
import os
import sys
from typing import TYPE_CHECKING, NamedTuple

import pytest

from turtlewire.firmware import BOARDS, Built, build, find_sketch

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

# There is no arduino-cli in Debian, nor in PyPI: this stands in for it, notes how it was called, and hands out what
# avr-gcc has built. Its options are those of https://arduino.github.io/arduino-cli/latest/commands/arduino-cli_compile
# and ..._upload.
ARDUINO_CLI = """\
#!{python} -IS
import json, shutil, sys
from pathlib import Path
here = Path(__file__).parent
arguments = sys.argv[1:]
with (here / "calls.jsonl").open("a") as calls:
    calls.write(json.dumps(arguments) + "\\n")
print((here / "says").read_text(), flush=True)
if arguments[0] == "compile":
    sketch, folder = Path(arguments[-1]), Path(arguments[arguments.index("--output-dir") + 1])
    for suffix in (".elf", ".hex"):
        shutil.copy(here / ("built" + suffix), folder / (sketch.name + ".ino" + suffix))
sys.exit(int((here / "code").read_text()))
"""


@pytest.fixture(scope="session")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the core is kept: one place for all processes of a test run."""
    base = tmp_path_factory.getbasetemp()
    place = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "cache"
    place.mkdir(exist_ok=True)
    return place


@pytest.fixture(autouse=True)
def home(cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setenv("HOME", str(tmp_path))


@pytest.fixture
def no_tools(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that is the whole PATH, with nothing in it."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))
    return folder


class ArduinoCli(NamedTuple):
    """The stand-in: how it was called, and what it says and returns from now on."""

    folder: Path

    @property
    def calls(self) -> list[list[str]]:
        return [json.loads(line) for line in (self.folder / "calls.jsonl").read_text().splitlines()]

    def then(self, says: str, code: int) -> None:
        (self.folder / "says").write_text(says)
        (self.folder / "code").write_text(str(code))


@pytest.fixture
def simple_car(tmp_path: Path) -> Built:
    return build(find_sketch("SimpleCar"), BOARDS["uno"], tmp_path / "built", "avr-gcc")


@pytest.fixture
def arduino_cli(simple_car: Built, no_tools: Path) -> ArduinoCli:
    """arduino-cli, and no other tool."""
    for made in (simple_car.elf, simple_car.hex):
        made.rename(no_tools / f"built{made.suffix}")
    program = no_tools / "arduino-cli"
    program.write_text(ARDUINO_CLI.format(python=sys.executable))
    program.chmod(0o755)
    cli = ArduinoCli(no_tools)
    cli.then("", 0)
    return cli


@pytest.fixture
def sketch(tmp_path: Path) -> Callable[..., Path]:
    """Makes a sketch: its name, and the text of its main file."""

    def make(name: str, text: str) -> Path:
        folder = tmp_path / name
        folder.mkdir()
        (folder / f"{name}.ino").write_text(text, "utf-8")
        return folder

    return make
