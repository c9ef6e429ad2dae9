"""``turtlewire firmware flash``: the real avrdude, a real bootloader on the emulated chip, and a port between them."""

from __future__ import annotations

import fcntl
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest

from turtlewire.protocols.simple.messages import BAUD

from .bootloader import ATMEGABOOT, Bootloader, PluggedBoard, intel_hex, optiboot

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from turtlewire.firmware import Built

ERASED = b"\xff"
DEADLINE_S = 60.0
# In the middle of SimpleCar.
MIDWAY = 0x400
DRIVE_PWM = 5


class Ended(NamedTuple):
    code: int
    out: str
    err: str


class Flashing:
    """Runs the command line beside one board."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.port = folder / "tty"
        self.environment = {**os.environ, "XDG_CONFIG_HOME": str(folder), "PYTHONWARNINGS": "error"}

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, "-m", "turtlewire", *arguments],
            cwd=self.folder,
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    def end(self, process: subprocess.Popen[str]) -> Ended:
        out, err = process.communicate(timeout=DEADLINE_S)
        assert "Traceback" not in err
        assert "bug in turtlewire" not in err
        return Ended(process.returncode, out, err)

    def __call__(self, *arguments: str) -> Ended:
        return self.end(self.start(*arguments))

    def flash(self, *arguments: str, sketch: str = "SimpleCar") -> Ended:
        return self("firmware", "flash", sketch, "--port", str(self.port), *arguments)


@pytest.fixture
def turtlewire(tmp_path: Path) -> Flashing:
    return Flashing(tmp_path)


@pytest.fixture(scope="session")
def bootloader(tmp_path_factory: pytest.TempPathFactory) -> Bootloader:
    return optiboot(tmp_path_factory.mktemp("optiboot"))


@pytest.fixture
def board(bootloader: Bootloader, turtlewire: Flashing) -> Iterator[PluggedBoard]:
    with PluggedBoard(bootloader, turtlewire.port) as board:
        yield board


def holds(board: PluggedBoard, program: Built) -> bool:
    """Whether this program is on the board, and the bootloader behind it."""
    return all(
        board.board.flash(address, len(data)) == data
        for made in (program.hex, board.bootloader.hex)
        for address, data in intel_hex(made)
    )


def test_a_board_is_flashed_and_driven(
    board: PluggedBoard, turtlewire: Flashing, built: Callable[[str], Built]
) -> None:
    """From a board with nothing on it to one that draws, and to another program, by the commands in the manual."""
    ended = turtlewire.flash()
    assert ended.code == 0, ended.err
    assert ended.out == "SimpleCar.hex\n"
    assert f"{built('SimpleCar').flash_bytes} bytes of flash verified" in ended.err
    assert f"flashed, and read back. What now? turtlewire doctor {turtlewire.port}" in ended.err
    assert holds(board, built("SimpleCar"))

    board.pace = 1.0
    (turtlewire.folder / "drive.logo").write_text("FD 20 BK 20\n", "utf-8")
    driven = turtlewire("run", "drive.logo", "--robot", "simple", "--port", str(turtlewire.port))
    assert driven.code == 0, driven.err
    assert board.opened == 2
    stopped = turtlewire("stop", "--robot", "simple", "--port", str(turtlewire.port), "--require-replies")
    assert (stopped.code, stopped.out) == (0, "stopped: the robot answers\n")
    board.unplug()
    levels = [edge.level for edge in board.board.edges(DRIVE_PWM)]
    assert levels.count(1) > 20, "the motor has run"
    assert levels[-1] == 0

    board.pace = 0.2
    board.plug()
    again = turtlewire.flash("--json", sketch="FrameRobot")
    assert again.code == 0, again.err
    told = json.loads(again.out)
    assert told["flashed"] is True
    assert told["flash_command"][:3] == ["avrdude", "-p", "atmega328p"]
    assert holds(board, built("FrameRobot"))


def test_a_nano_with_the_old_bootloader(
    turtlewire: Flashing, built: Callable[[str], Built], tmp_path: Path
) -> None:
    with PluggedBoard(ATMEGABOOT, turtlewire.port) as board:
        wrong = turtlewire.flash("--board", "nano")
        assert wrong.code == 3
        assert "no bootloader answers there at 115200 baud" in wrong.err
        assert "--board nano-old" in wrong.err
        assert wrong.err.endswith("Nothing was written: the board has the program that it had.\n")
        assert wrong.err.count("not in sync") == 3, "avrdude itself would try ten times"
        assert board.board.flash(0, 0x7800) == ERASED * 0x7800
        board.pace = 1.0  # it is as slow to begin as avrdude expects
        right = turtlewire.flash("--board", "nano-old")
        assert right.code == 0, right.err
        (program,) = intel_hex(tmp_path / "SimpleCar.hex")
        assert board.board.flash(*program[:1], len(program.data)) == program.data


def test_the_plug_is_pulled(board: PluggedBoard, turtlewire: Flashing, built: Callable[[str], Built]) -> None:
    board.unplug_when = lambda: board.board.flash(MIDWAY, 2) != ERASED * 2
    ended = turtlewire.flash("--json")
    assert ended.code == 3
    assert ended.out == ""
    assert "turtlewire: the port is gone: was the board unplugged?\n" in ended.err
    assert "flash it again: the bootloader is untouched" in ended.err
    board.wait_until_unplugged()
    assert not holds(board, built("SimpleCar"))
    assert turtlewire.flash().code == 3, "there is no port"

    board.unplug_when = lambda: False
    board.plug()
    again = turtlewire.flash()
    assert again.code == 0, again.err
    assert holds(board, built("SimpleCar"))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_midway(
    board: PluggedBoard, turtlewire: Flashing, built: Callable[[str], Built], number: signal.Signals
) -> None:
    process = turtlewire.start("firmware", "flash", "SimpleCar", "--port", str(turtlewire.port))
    is_told = False

    def tell() -> bool:
        nonlocal is_told
        if not is_told and board.board.flash(MIDWAY, 2) != ERASED * 2:
            is_told = True
            if number is signal.SIGINT:
                os.killpg(process.pid, number)  # a terminal tells all of them
            else:
                process.send_signal(number)
            board.pace = 0.001  # it waits for what comes next, and so does avrdude
        return False

    board.unplug_when = tell
    ended = turtlewire.end(process)
    assert ended.code == 130
    assert f"turtlewire: interrupted ({number.name})" in ended.err
    assert "The board holds a part of this program" in ended.err
    assert not holds(board, built("SimpleCar"))
    assert not avrdudes_at(turtlewire.port)
    board.pace = 0.2
    again = turtlewire.flash()
    assert again.code == 0, again.err
    assert holds(board, built("SimpleCar"))


def avrdudes_at(port: Path) -> list[bytes]:
    """Flashing tools that are left behind."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            line = path.read_bytes()
        except OSError:
            continue  # it has just ended
        if line.startswith(b"avrdude\0") and os.fsencode(port) in line:
            found.append(line)
    return found


def test_another_chip_is_left_alone(turtlewire: Flashing, tmp_path: Path) -> None:
    with PluggedBoard(optiboot(tmp_path, signature="1E9406"), turtlewire.port) as board:
        ended = turtlewire.flash()
        assert ended.code == 3
        assert "the chip there, 0x1e9406, is not the atmega328p of the uno" in ended.err, ended.err
        assert ended.err.endswith("Nothing was written: the board has the program that it had.\n")
        assert board.board.flash(0, 0x7000) == ERASED * 0x7000


def test_a_chip_that_is_worn(board: PluggedBoard, turtlewire: Flashing) -> None:
    """A bit that does not take what is written is found when it is read back."""

    def stick() -> bool:
        board.board.burn(MIDWAY, b"\0")
        return False

    board.unplug_when = stick
    ended = turtlewire.flash()
    assert ended.code == 3
    assert "what is on it now is not what was written" in ended.err
    assert ended.err.endswith("All of it was written, but reading it back came to no good end: flash it again.\n")


def test_a_robot_that_is_being_driven_is_left_alone(board: PluggedBoard, turtlewire: Flashing) -> None:
    with turtlewire.port.open("r+b", buffering=0) as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        ended = turtlewire.flash()
        assert ended.code == 3
        assert f"{turtlewire.port} is in use by another program" in ended.err
        assert "avrdude" not in ended.err
    assert board.board.flash(0, 0x7000) == ERASED * 0x7000


def test_while_it_is_flashed_nobody_drives_it(board: PluggedBoard, turtlewire: Flashing) -> None:
    process = turtlewire.start("firmware", "flash", "SimpleCar", "--port", str(turtlewire.port))
    deadline = time.monotonic() + DEADLINE_S
    while board.board.flash(0, 2) == ERASED * 2:
        assert time.monotonic() < deadline
        assert process.poll() is None
    stopped = turtlewire("stop", "--robot", "simple", "--port", str(turtlewire.port))
    assert stopped.code == 3
    assert "in use by another program" in stopped.err
    ended = turtlewire.end(process)
    assert ended.code == 0, ended.err


def test_a_robot_by_its_name(board: PluggedBoard, turtlewire: Flashing) -> None:
    (turtlewire.folder / "turtlewire").mkdir()
    (turtlewire.folder / "turtlewire" / "robots.toml").write_text(
        f'[elsie]\nport = "{turtlewire.port}"\nprotocol = "simple"\n', "utf-8"
    )
    ended = turtlewire("firmware", "flash", "SimpleCar", "--robot", "elsie", "--dry-run")
    assert ended.code == 0, ended.err
    assert re.search(rf"would be flashed by: avrdude .* -P {turtlewire.port} ", ended.err)
    assert board.opened == 0
    assert BAUD == 9600
