"""On a real terminal: the bar shows, the program's output stays whole, and the terminal is left as it was."""

from __future__ import annotations

import os
import pty
import re
import signal
import subprocess
from typing import TYPE_CHECKING, Literal

import pytest

from .conftest import COMMAND, DEADLINE_S, wait_until
from .terminal import clean_environment

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from .terminal import Terminal

PROGRAM = """
REPEAT 60 [PRINT SE [step no.] REPCOUNT FD 10 RT 6]
PRINT [:smile: [bold] not markup]
TYPE "unfinished
"""
LINES = [f"step no. {number}" for number in range(1, 61)] + [":smile: [bold] not markup", "unfinished"]
SHOW_CURSOR, HIDE_CURSOR = "\x1b[?25h", "\x1b[?25l"


def run(
    folder: Path, arguments: list[str], stdout: int, stderr: int, program: str = PROGRAM
) -> subprocess.Popen[str]:
    (folder / "program.logo").write_text(program, "utf-8")
    command = [*COMMAND, "run", "program.logo", *arguments]
    return subprocess.Popen(
        command,
        cwd=folder,
        env=clean_environment(),
        stdin=subprocess.DEVNULL,
        stdout=stdout,
        stderr=stderr,
        text=True,
    )


@pytest.mark.parametrize("columns", [100, 40])
def test_both_outputs_on_the_terminal(
    tmp_path: Path, terminal: Callable[[int], Terminal], columns: int
) -> None:
    screen = terminal(columns)
    process = run(tmp_path, [], screen.far, screen.far)
    assert process.wait(DEADLINE_S) == 0
    wait_until(lambda: "robot pose" in screen.text, "the summary")
    # Each line of the program whole, once, in order; the bar in between has left nothing.
    lines = [line for line in screen.lines() if line in LINES]
    assert lines == LINES
    assert screen.text.count(HIDE_CURSOR) == screen.text.count(SHOW_CURSOR) == 1
    assert "100%" in screen.text
    assert re.search(r"0\.\d\d m, \d+ commands" if columns == 100 else r"\d m", screen.text)


def test_output_into_a_pipe_and_the_bar_on_the_terminal(
    tmp_path: Path, terminal: Callable[[int], Terminal]
) -> None:
    screen = terminal(80)
    process = run(tmp_path, [], subprocess.PIPE, screen.far)
    output, _ = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 0
    assert output == "\n".join(LINES)
    wait_until(lambda: "robot pose" in screen.text, "the summary")
    assert "100%" in screen.text
    assert "step no." not in screen.text


def test_no_bar_where_there_is_no_terminal(tmp_path: Path, terminal: Callable[[int], Terminal]) -> None:
    screen = terminal(80)
    process = run(tmp_path, [], screen.far, subprocess.PIPE)
    _, errors = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 0
    assert "\x1b" not in errors
    assert "%" not in errors
    wait_until(lambda: "unfinished" in screen.text, "the output")
    assert screen.text.split("\r\n") == LINES


def test_json_has_no_bar(tmp_path: Path, terminal: Callable[[int], Terminal]) -> None:
    screen = terminal(80)
    process = run(tmp_path, ["--json"], subprocess.PIPE, screen.far)
    output, _ = process.communicate(timeout=DEADLINE_S)
    assert output.count("\n") == 1
    assert screen.text == ""


@pytest.mark.parametrize(
    "program", ["FOREVER [FD 1 RT 1 PRINT 5]", "FD 10 PRINT 5 FDD"], ids=["interrupt", "error"]
)
def test_the_terminal_is_left_as_it_was(
    tmp_path: Path, terminal: Callable[[int], Terminal], program: str
) -> None:
    screen = terminal(80)
    process = run(tmp_path, [], screen.far, screen.far, program)
    if "FOREVER" in program:
        wait_until(lambda: "5\r\n" in screen.text, "output")
        process.send_signal(signal.SIGINT)
    assert process.wait(DEADLINE_S) == (130 if "FOREVER" in program else 1)
    wait_until(lambda: "turtlewire: " in screen.text, "the message")
    before, _, message = screen.text.rpartition("turtlewire: ")
    assert before.rfind(SHOW_CURSOR) > before.rfind(HIDE_CURSOR) >= 0
    assert "Traceback" not in screen.text
    assert "program.logo, line 1" in message


def test_a_terminal_that_goes_away(tmp_path: Path) -> None:
    """The window is closed: SIGHUP, and every write to the terminal fails from then on."""
    read_end: Literal[-1] | int
    pid, read_end = pty.fork()
    if pid == 0:  # the child, in a session of its own with the terminal as its controlling one
        os.chdir(tmp_path)
        (tmp_path / "p.logo").write_text("FOREVER [FD 1 RT 1 PRINT 5]", "utf-8")
        os.execv(COMMAND[0], [*COMMAND, "run", "p.logo", "--picture", "drawn.svg"])
    seen = bytearray()
    while b"5\r\n" not in seen:
        seen += os.read(read_end, 4096)
    os.close(read_end)
    _, status = os.waitpid(pid, 0)
    assert os.waitstatus_to_exitcode(status) in (130, 1)
    assert "<svg" in (tmp_path / "drawn.svg").read_text("utf-8")
