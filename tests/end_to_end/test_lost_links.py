"""A robot that goes away while it runs a program, and comes back or not: exit code 3, and what became of it."""

from __future__ import annotations

import os
import re
import signal
from typing import TYPE_CHECKING

import pytest

from .conftest import CONFIRMED, EMERGENCY_STOP, IMPATIENT, wait_until

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from .conftest import Cli, Process, Simulator, Wire

ENDLESS = "REPEAT 1000000 [FD 50 RT 91]\n"
MOVES = re.compile("speed=[1-9]")
WAITING = "Waiting until the robot is reached again"


class Cable:
    """A port of one name, at which there is a simulator now and then."""

    def __init__(self, cli: Cli) -> None:
        self._cli = cli
        self._device: Path = cli.folder / "ttyROBOT"

    @property
    def port(self) -> str:
        return str(self._device)

    def plug_in(self, *arguments: str, robot: str = "walter", **options: str) -> Simulator:
        simulator = self._cli.simulate(*arguments, robot=robot, **options)
        self.lead_to(simulator.url)
        return simulator

    def lead_to(self, device: str) -> None:
        self._device.symlink_to(device)

    def unplug(self, simulator: Simulator) -> None:
        self._device.unlink()
        simulator.signal(signal.SIGKILL)
        simulator.end()


def run(cli: Cli, cable: Cable, *arguments: str) -> Process:
    return cli.start("run", cli.program(ENDLESS), "--port", cable.port, "--picture", "drawn.svg", *arguments)


def test_a_robot_that_comes_back_is_stopped_before_the_program_ends(cli: Cli) -> None:
    cable = Cable(cli)
    simulator = cable.plug_in()
    process = run(cli, cable, "--statistics")
    simulator.wait_for_motions(CONFIRMED)
    cable.unplug(simulator)
    process.wait_for_err(WAITING)
    assert process.popen.poll() is None
    back = cable.plug_in()
    ended = process.end()
    assert ended.code == 3
    ended.check_said(
        f"the link to {cable.port} ended",
        "Trying to reach it again, for 30 s; the robot was last known to be at x ",
        "The robot was stopped, after",
        "was reached again after",
        "in program.logo, line 1",
        "What was drawn until then is in drawn.svg.",
        "reconnections        1",
    )
    assert "cannot be reached" not in ended.err
    assert not any(action.startswith("started") for action in back.actions)


def test_a_robot_that_stays_away_is_given_up_and_that_is_said(cli: Cli) -> None:
    cable = Cable(cli)
    simulator = cable.plug_in()
    process = run(cli, cable, "--set", "reconnect_s=0.3")
    simulator.wait_for_motions(1)
    cable.unplug(simulator)
    ended = process.end()
    assert ended.code == 3
    ended.check_said(
        WAITING,
        "could not be reached again within 0.3 s",
        "The robot cannot be reached to stop it: if it still moves, switch it off.",
    )
    assert "The robot was stopped" not in ended.err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_waiting(cli: Cli, number: signal.Signals) -> None:
    cable = Cable(cli)
    simulator = cable.plug_in()
    process = run(cli, cable, "--set", "reconnect_s=100000", "--json")
    simulator.wait_for_motions(1)
    cable.unplug(simulator)
    process.wait_for_err(WAITING)
    process.signal(number)
    ended = process.end()
    assert ended.code == 3
    ended.check_said()
    assert '"type": "LinkLostError"' in ended.out


def test_who_ends_the_waiting_for_a_robot_that_does_not_answer_stops_it_all_the_same(
    cli: Cli, wire: Callable[..., Wire]
) -> None:
    cable, raw = Cable(cli), wire()
    simulator = cable.plug_in()
    process = run(cli, cable, "--set", "reconnect_s=100000")
    simulator.wait_for_motions(1)
    cable.unplug(simulator)
    process.wait_for_err(WAITING)
    cable.lead_to(raw.path)
    raw.wait_for(EMERGENCY_STOP)
    process.signal(signal.SIGINT)
    assert process.end().code == 3
    raw.wait_for_end(EMERGENCY_STOP)
    assert b"F\0" not in raw.received


@pytest.mark.parametrize("robot", ["simple", "frame"])
def test_other_robots(cli: Cli, robot: str) -> None:
    cable = Cable(cli)
    simulator = cable.plug_in("--speed", "1", robot=robot)
    process = run(cli, cable, "--robot", robot, "--set", "boot_s=0")
    wait_until(lambda: any(MOVES.search(action) for action in simulator.actions), "a motion")
    cable.unplug(simulator)
    process.wait_for_err(WAITING)
    back = cable.plug_in("--speed", "1", robot=robot)
    ended = process.end()
    assert ended.code == 3
    ended.check_said("by reckoning", "The robot was stopped, after", "was reached again after")
    assert not any(MOVES.search(action) for action in back.actions)


def test_a_lesson_about_it_needs_no_robot(cli: Cli) -> None:
    ended = cli("run", cli.program("REPEAT 4 [FD 100 RT 90]"), "--faults", "close:2+3")
    assert ended.code == 3
    ended.check_said("a fault that was asked for", "was reached again after 3.", "in program.logo, line 1")


def test_a_robot_may_come_to_a_new_pty_whenever_it_likes(cli: Cli) -> None:
    process = cli.start("run", cli.program("FD 20 PRINT POS"), "--port", "pty", *IMPATIENT)
    process.wait_for_err("waiting for the robot at ")
    path = process.err.split()[-1]
    assert process.popen.poll() is None
    robot = os.open(path, os.O_RDWR | os.O_NOCTTY)
    try:
        ended = process.end()
    finally:
        os.close(robot)
    assert (ended.code, ended.out) == (0, "0 20\n")
    ended.check_said("answers no queries: it is run as a basic one")


def test_the_wait_at_a_new_pty_can_be_interrupted(cli: Cli) -> None:
    process = cli.start("run", cli.program("FD 20"), "--port", "pty")
    process.wait_for_err("waiting for the robot at ")
    process.signal(signal.SIGINT)
    ended = process.end()
    assert ended.code == 130
    ended.check_said("interrupted (SIGINT)")


def test_who_interrupts_a_program_that_thinks_is_told_that_its_robot_is_away(cli: Cli) -> None:
    cable = Cable(cli)
    simulator = cable.plug_in()
    thinks = cli.program('FD 20 PRINT "thinking FOREVER [MAKE "x 1 + 1]\n')
    process = cli.start("run", thinks, "--port", cable.port)
    process.wait_for_out("thinking")
    cable.unplug(simulator)
    process.wait_for_err("Trying to reach it again")
    process.signal(signal.SIGINT)
    ended = process.end()
    assert ended.code == 130
    ended.check_said("The robot cannot be reached to stop it: if it still moves, switch it off.")
    assert "The robot was stopped" not in ended.err
