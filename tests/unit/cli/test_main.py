"""The command line within this process: what it refuses, with which words and which exit code."""

from __future__ import annotations

import importlib.metadata
import os
import signal
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from turtlewire.cli.main import main
from turtlewire.cli.signals import Interrupted, Signals

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A folder with programs, and an interpreter that is as before afterwards."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    (tmp_path / "ok.logo").write_text("FD 10\n", "utf-8")
    (tmp_path / "folder").mkdir()
    (tmp_path / "latin.logo").write_bytes(b'FD 10\nPRINT "Gr\xfc\xdfe\n')
    (tmp_path / "wrong.logo").write_text("FD 10\nFDD 20\n", "utf-8")
    (tmp_path / "empty.logo").write_text("", "utf-8")
    yield
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def run(*arguments: str) -> int:
    """The exit code, whether it is returned or raised by argparse."""
    try:
        return main(arguments)
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else -1


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        ("run missing.logo", 1, "cannot read the program missing.logo: No such file or directory"),
        ("run folder", 1, "cannot read the program folder: Is a directory"),
        ("run latin.logo", 1, "latin.logo is not text in UTF-8: in line 2, byte 15 is FC. Save it as UTF-8"),
        ("run wrong.logo", 1, "line 2, column 1: I don't know how to FDD\n    FDD 20\n    ^\nDid you mean fd"),
        ("run ok.logo --picture drawn.gif", 2, "unknown picture format '.gif': use .svg or .png"),
        ("run ok.logo --picture nowhere/drawn.svg", 1, "there is no folder nowhere; make it first"),
        ("run ok.logo --set baud", 2, "--set baud: write NAME=VALUE; the names are baud, speed"),
        ("run ok.logo --set colour=red", 2, "--set colour=red: write NAME=VALUE"),
        ("run ok.logo --set baud=fast", 2, "--set baud=fast: 'fast' is no value for baud"),
        ("run ok.logo --set gentle=perhaps", 2, "'perhaps' is no value for gentle"),
        ("run ok.logo --set baud=1", 2, "the setting baud is 1, but must be from 50 to 4000000"),
        ("run ok.logo --set groups=XY", 2, "groups is XY, but must be some of C, Q, H and E"),
        ("run ok.logo --set boot_s=nan", 2, "boot_s is nan"),
        ("run ok.logo --seed pi", 2, "argument --seed: invalid int value: 'pi'"),
        ("run ok.logo --step-mm 0", 2, "'0' is not a number above 0"),
        ("run ok.logo --step-mm much", 2, "'much' is not a number above 0"),
        ("run ok.logo --speed 3", 2, "argument --speed: invalid choice: '3'"),
        ("run ok.logo --speed max --port /dev/ttyUSB0", 2, "--speed max is for the simulated robot"),
        ("run ok.logo --speed max --port sim:walter?pace=2", 2, "both say how fast: leave one out"),
        ("run ok.logo --robot wheelbarrow", 2, "invalid choice: 'wheelbarrow'"),
        ("run", 2, "the following arguments are required: PROGRAM.logo"),
        ("run ok.logo --port sim:turtle", 2, "'sim:turtle': there is no simulated robot 'turtle'"),
        ("run ok.logo --port sim:walter?colour=red", 2, "unknown option 'colour'"),
        ("run ok.logo --port sim:walter?seed=x", 2, "'sim:walter?seed=x': seed is 'x', but must be a number"),
        ("run ok.logo --port sim:walter?slip=2", 2, "slip is 2.0, but must be 0 or more and below 1"),
        ("run ok.logo --port sim:walter?pace=0", 2, "pace is '0'"),
        ("run ok.logo --port sim:walter?arena=none.toml", 2, "none.toml: the arena file cannot be read"),
        ("run ok.logo --port ttyUSB0", 2, "'ttyUSB0' is no port: write a device (/dev/ttyUSB0"),
        ("run ok.logo --port http://robot", 2, "there is no 'http' port"),
        ("run ok.logo --port socket://robot", 2, "must be socket://host:port"),
        ("run ok.logo --port socket://127.0.0.1:99999", 2, "with a port number from 0 to 65535"),
        ("run ok.logo --port socket://[::1:5", 2, "'socket://[::1:5' is no port"),
        ("run ok.logo --port socket://robot:5?colour=red", 2, "unknown option 'colour'; a socket has none"),
        ("run ok.logo --port serial:///dev/ttyS9?baud=x", 2, "baud is 'x', but must be a whole number"),
        ("run ok.logo --port serial:///dev/ttyS9?parity=e", 2, "unknown option 'parity'; a serial port has baud"),
        ("run ok.logo --port socket://no-such-host.invalid:80", 3, "cannot reach socket://no-such-host.invalid:80"),
        ("run ok.logo --port /dev/no-such-port", 3, "there is no port /dev/no-such-port"),
        ("simulate walter --listen somewhere", 2, "cannot serve a robot at 'somewhere': write pty, or socket://"),
        ("simulate walter --speed 0", 2, "'0' is not a number above 0"),
        ("simulate walter --slip 2", 2, "slip is 2.0"),
        ("simulate walter --seed x", 2, "seed is 'x', but must be a number"),
        ("simulate walter --groups Z", 2, "but must be some of C, Q, H and E"),
        ("simulate walter --arena none.toml", 2, "none.toml: the arena file cannot be read"),
        ("simulate walter --picture drawn.gif", 2, "unknown picture format '.gif'"),
        ("simulate", 2, "the following arguments are required: ROBOT"),
        ("stop", 2, "the following arguments are required: --port"),
        ("stop --port sim:walter", 2, "is a robot of its own in each process: there is nothing to stop"),
        ("stop --port pty", 2, "pty is a new port, with no robot at it yet"),
        ("stop --port /dev/no-such-port", 3, "there is no port /dev/no-such-port"),
        ("fly", 2, "invalid choice: 'fly'"),
        ("", 2, "run a Logo program on a robot"),
    ],
)  # fmt: skip
def test_what_is_refused(capfd: pytest.CaptureFixture[str], arguments: str, code: int, message: str) -> None:
    assert run(*arguments.split()) == code
    out, err = capfd.readouterr()
    assert out == ""
    assert message in err
    assert "Traceback" not in err


def test_an_empty_program_is_none_the_worse(capfd: pytest.CaptureFixture[str]) -> None:
    assert run("run", "empty.logo") == 0
    out, err = capfd.readouterr()
    assert out == ""
    assert "empty.logo: done" in err
    assert "driven     0.00 m" in err


def test_the_summary(capfd: pytest.CaptureFixture[str]) -> None:
    assert run("run", "ok.logo", "--picture", "a.svg", "--picture", "b.png", "--picture", "a.svg") == 0
    _, err = capfd.readouterr()
    lines = [line[:13].strip() for line in err.splitlines()]
    assert lines == [
        "ok.logo: done",
        "sent",
        "driven",
        "took",
        "host pose",
        "robot pose",
        "deviation",
        "drawn",
    ]
    assert "driven     0.01 m in 0." in err
    assert "host pose  x 0 mm, y 10 mm, heading 0 degrees" in err
    assert "robot pose x 0 mm, y 10 mm, heading 0 degrees" in err
    assert err.endswith("drawn      a.svg, b.png\n")


@pytest.mark.parametrize("command", [[], ["run"], ["simulate"], ["stop"]])
def test_help_has_examples(capfd: pytest.CaptureFixture[str], command: list[str]) -> None:
    assert run(*command, "--help") == 0
    out, err = capfd.readouterr()
    assert err == ""
    assert "examples:\n  turtlewire " in out


def test_the_version(capfd: pytest.CaptureFixture[str]) -> None:
    assert run("--version") == 0
    assert capfd.readouterr().out == f"turtlewire {importlib.metadata.version('turtlewire')}\n"


def test_a_mistake_of_ours_is_a_paragraph_too(tmp_path: Path) -> None:
    """Whatever is raised by accident stops the robot, keeps the picture, and ends with JSON or a message."""
    (tmp_path / "broken.py").write_text(
        "import sys\n"
        "import turtlewire.logo.evaluator as evaluator\n"
        "from turtlewire.cli.main import main\n"
        "def run(self, source, name):\n"
        "    self.turtle.forward(10)\n"
        "    raise LookupError('oh dear')\n"
        "evaluator.Interpreter.run = run\n"
        "sys.exit(main())\n",
        "utf-8",
    )
    command = [sys.executable, "broken.py", "run", "ok.logo", "--picture", "p.svg"]
    plain = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert plain.returncode == 1
    assert "this is a bug in turtlewire, please report it: LookupError: oh dear (" in plain.stderr
    assert "broken.py, line 6)" in plain.stderr
    assert "Traceback" not in plain.stderr
    assert "<svg" in (tmp_path / "p.svg").read_text("utf-8")
    structured = subprocess.run(
        [*command, "--json"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert structured.returncode == 1
    assert '"type": "LookupError", "message": "oh dear"' in structured.stdout
    environment = {**os.environ, "PYTHONDEVMODE": "1"}
    told = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, env=environment)
    assert "Traceback" in told.stderr


def test_help_does_not_load_what_only_a_run_needs() -> None:
    """Starting fast: no library of pictures, terminals, serial ports, or of the Logo language."""
    code = (
        "import sys\n"
        "from turtlewire.cli.main import main\n"
        "try:\n    main(['--help'])\n"
        "except SystemExit:\n    print(sorted(sys.modules), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    for module in ("rich", "drawsvg", "resvg_py", "serialx", "turtlewire.logo", "turtlewire.simulator"):
        assert f"'{module}'" not in done.stderr


class TestSignals:
    def test_the_first_raises_and_later_ones_are_only_noted(self) -> None:
        before = signal.getsignal(signal.SIGTERM)
        try:
            with Signals() as signals:
                with pytest.raises(Interrupted, match="SIGTERM"):
                    signal.raise_signal(signal.SIGTERM)
                signal.raise_signal(signal.SIGINT)
                assert signals.received == "SIGTERM"
            # Nor does anything disturb what is left of the way out.
            signal.raise_signal(signal.SIGTERM)
        finally:
            for name in ("SIGINT", "SIGTERM", "SIGHUP"):
                signal.signal(getattr(signal, name), before)
            signal.signal(signal.SIGINT, signal.default_int_handler)

    def test_on_hold_none_raises(self) -> None:
        try:
            with Signals() as signals:
                signals.hold()
                signal.raise_signal(signal.SIGINT)
                assert signals.received == "SIGINT"
        finally:
            signal.signal(signal.SIGINT, signal.default_int_handler)
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
            signal.signal(signal.SIGHUP, signal.SIG_DFL)

    def test_without_a_signal_all_is_as_before(self) -> None:
        before = signal.getsignal(signal.SIGTERM)
        with Signals():
            assert signal.getsignal(signal.SIGTERM) is not before
        assert signal.getsignal(signal.SIGTERM) is before
