"""A program that wants more memory than there is: it is told where, and the robot is stopped."""

from __future__ import annotations

import os
import re
import resource
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from .conftest import Cli, Process

MOST = 700_000_000  # bytes; NumPy alone takes 200 MB of addresses
AT_ONCE = 'make "a "abcdefgh\nfd 50\nrepeat 60 [make "a word :a :a]\n'
LITTLE_BY_LITTLE = 'make "a []\nfd 50\nforever [make "a fput repcount / 7 :a]\n'


def start(cli: Cli, *arguments: str) -> Process:
    process = cli.start(*arguments)
    resource.prlimit(process.popen.pid, resource.RLIMIT_AS, (MOST, MOST))
    return process


@pytest.mark.parametrize("program", [AT_ONCE, LITTLE_BY_LITTLE], ids=["at once", "little by little"])
def test_a_script_says_where(cli: Cli, program: str) -> None:
    ended = start(cli, "logo", "--picture", "drawn.svg", cli.program(program)).end()
    assert ended.code == 1
    ended.check_said("program.logo, line 3, column", "out of space", "grow without an end")
    assert "<svg" in cli.text("drawn.svg")


@pytest.mark.parametrize("program", [AT_ONCE, LITTLE_BY_LITTLE], ids=["at once", "little by little"])
def test_a_robot_is_stopped(cli: Cli, program: str) -> None:
    simulator = cli.simulate("--listen", "socket://127.0.0.1:0")
    ended = start(cli, "run", cli.program(program), "--port", simulator.url).end()
    assert ended.code == 1
    ended.check_said("program.logo, line 3, column", "out of space", "The robot was stopped")
    simulator.wait_until_still()


@pytest.mark.parametrize("command", ["logo", "run"])
def test_no_program_has_more_than_the_computer(cli: Cli, command: str) -> None:
    """Linux would end it then, or another program, and nothing would stop the robot."""
    program = """openread "|/proc/self/limits|
setread "|/proc/self/limits|
until [eofp] [print readrawline]
close "|/proc/self/limits|
"""
    ended = cli(command, cli.program(program))
    assert ended.code == 0
    found = re.search(r"Max address space +(\d+)", ended.out)
    assert found is not None
    assert int(found[1]) < os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
