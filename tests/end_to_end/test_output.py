"""What is printed, and where to: any of it may be full, closed, or too narrow for the letters."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
from typing import TYPE_CHECKING

import pytest

from .conftest import COMMAND, DEADLINE_S, EMERGENCY_STOP, IMPATIENT, Ended

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from .conftest import Cli, Wire

UNICODE = 'PRINT "Grüße☃ FD 10'
ENDLESS = "FOREVER [FD 5 RT 91 PRINT POS]"


def shell(folder: Path, command: str, **environment: str) -> Ended:
    """Run a line of bash; $T is turtlewire."""
    done = subprocess.run(
        ["bash", "-c", f"set -o pipefail; T={shlex.quote(shlex.join(COMMAND))}; {command}"],
        cwd=folder,
        env={**os.environ, "PYTHONUNBUFFERED": "", **environment},
        capture_output=True,
        timeout=DEADLINE_S,
        check=False,
    )
    return Ended(done.returncode, done.stdout.decode("utf-8"), done.stderr.decode("utf-8"))


@pytest.mark.parametrize(
    ("environment", "output"),
    [
        ({"PYTHONIOENCODING": "ascii"}, "Gr\\xfc\\xdfe\\u2603\n"),
        ({"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}, "Gr\\xfc\\xdfe\\u2603\n"),
        ({"PYTHONIOENCODING": "utf-8"}, "Grüße☃\n"),
    ],
)
def test_letters_that_the_output_has_not(cli: Cli, environment: dict[str, str], output: str) -> None:
    cli.program(UNICODE)
    ended = shell(cli.folder, "$T run program.logo", **environment)
    assert (ended.code, ended.out) == (0, output)
    ended.check_said("program.logo: done")


@pytest.mark.parametrize("redirection", [">&-", ">&- 2>&-", ">&- 2>&- <&-", "2>/dev/full", ">&- 2>/dev/full"])
@pytest.mark.parametrize("options", ["", "--json"])
def test_closed_on_purpose_is_no_error(cli: Cli, redirection: str, options: str) -> None:
    cli.program(UNICODE)
    ended = shell(cli.folder, f"$T run program.logo --picture p.svg {options} {redirection}")
    assert ended.code == 0
    ended.check_said()
    assert "<svg" in cli.text("p.svg")


@pytest.mark.parametrize("options", ["", "--json"])
def test_a_full_disk_behind_the_output(cli: Cli, options: str) -> None:
    cli.program(UNICODE)
    ended = shell(cli.folder, f"$T run program.logo --picture p.svg {options} >/dev/full")
    assert ended.code == 1
    ended.check_said("turtlewire: cannot write the output: No space left on device")
    assert "<svg" in cli.text("p.svg")


def test_the_reader_of_the_output_goes_away(cli: Cli, wire: Callable[..., Wire]) -> None:
    simulator = cli.simulate()
    cli.program(ENDLESS)
    ended = shell(cli.folder, f"$T run program.logo --port {simulator.url} --picture p.svg | head -1")
    assert (ended.code, ended.out) == (1, "0 5\n")
    ended.check_said("the output is no longer read", "program.logo, line 1, PRINT", "The robot was stopped")
    simulator.wait_until_still()
    assert "<svg" in cli.text("p.svg")


def test_nobody_reads_the_json(cli: Cli) -> None:
    cli.program(UNICODE)
    # The reader has gone before anything is written.
    ended = shell(cli.folder, "$T run program.logo --json --speed real > >(exec true)")
    assert ended.code in (0, 1)
    ended = shell(
        cli.folder, "mkfifo fifo; (exec true < fifo) & exec 5> fifo; wait; $T run program.logo --json >&5"
    )
    assert ended.code == 1
    ended.check_said("the output is no longer read")


def test_output_comes_as_it_is_printed(cli: Cli, wire: Callable[..., Wire]) -> None:
    """Through a pipe, too: a robot takes its time, and somebody waits for what it says."""
    raw = wire()
    process = cli.start("run", cli.program("PRINT 1 FD 30000 FD 1"), "--port", raw.path, *IMPATIENT)
    process.wait_for_out("1\n")
    raw.wait_for(b"F")
    process.signal(signal.SIGTERM)
    assert process.end().code == 130
    raw.wait_for_end(EMERGENCY_STOP)


def test_a_picture_on_a_full_disk(cli: Cli) -> None:
    (cli.folder / "full.svg").symlink_to("/dev/full")
    cli.program("FD 10 PRINT 1")
    ended = cli(
        "run", "program.logo", "--picture", "full.svg", "--picture", "fine.svg", "--picture", "fine.svg"
    )
    assert (ended.code, ended.out) == (1, "1\n")
    ended.check_said(
        "cannot write the picture full.svg: No space left", "What was drawn until then is in fine.svg."
    )
    assert "<svg" in cli.text("fine.svg")
    # What went wrong first is what counts; nothing of the rest is kept back.
    cli.program("FD 10 HORNHI", "horn.logo")
    robot = ["--port", "sim:walter?basic=1", "--set", "groups="]
    ended = cli("run", "horn.logo", *robot, "--picture", "full.svg")
    assert ended.code == 3
    ended.check_said("has no horn", "horn.logo, line 1, HORNHI", "cannot write the picture full.svg")


def test_a_program_from_the_standard_input(cli: Cli) -> None:
    ended = shell(cli.folder, "printf '\\xef\\xbb\\xbfPRINT 1\\r\\nPRINT 2\\r\\n' | $T run -")
    assert (ended.code, ended.out) == (0, "1\n2\n")
    ended.check_said("standard input: done")
    ended = shell(cli.folder, "printf 'PRINT 1\\n\\xff' | $T run -")
    assert ended.code == 1
    ended.check_said("is not text in UTF-8: in line 2")
    ended = shell(cli.folder, "$T run - <&-")
    assert ended.code == 0


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("TO F\nF PRINT 1\nEND\nF", "program.logo, line 2, column 1: stack overflow in F"),
        ("[" * 100_000, "program.logo, line 1"),
        ("FD 1e400", "FD"),
    ],
    ids=["recursion", "brackets", "beyond-numbers"],
)
def test_programs_that_never_end_well(cli: Cli, program: str, message: str) -> None:
    ended = cli("run", cli.program(program), "--picture", "p.svg")
    assert (ended.code, ended.out) == (1, "")
    ended.check_said(message)


def test_a_tail_call_runs_on_in_constant_memory(cli: Cli) -> None:
    """200,000 calls, each in the place of its caller; a stack of them would have ended at 30,000."""
    program = "TO F :n\nIF :n = 0 [STOP]\nF :n - 1\nEND\nF 200000 PRINT [still here]"
    ended = cli("run", cli.program(program))
    assert (ended.code, ended.out) == (0, "still here\n")
