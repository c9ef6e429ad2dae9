"""Ctrl-C and its kin: whoever drives a robot stops it on the way out, and what was drawn is kept."""

from __future__ import annotations

import os
import signal
from typing import TYPE_CHECKING

import pytest

from .conftest import CONFIRMED, EMERGENCY_STOP, IMPATIENT, points

if TYPE_CHECKING:
    from collections.abc import Callable

    from .conftest import Cli, Wire

ENDLESS = "PRINT [off we go]\nREPEAT 1000000 [FD 50 RT 91]\n"
SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]


@pytest.mark.parametrize("number", SIGNALS)
def test_in_process(cli: Cli, number: signal.Signals) -> None:
    process = cli.start("run", cli.program(ENDLESS), "--picture", "drawn.svg")
    process.wait_for_out("off we go")
    process.signal(number)
    ended = process.end()
    assert ended.code == 130
    ended.check_said(f"turtlewire: interrupted ({number.name}) at program.logo", "drawn.svg")
    assert "<svg" in cli.text("drawn.svg")


@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("listen", ["pty", "socket://127.0.0.1:0"], ids=["pty", "socket"])
def test_over_a_port_the_robot_stands_still(cli: Cli, listen: str, number: signal.Signals) -> None:
    simulator = cli.simulate("--listen", listen)
    process = cli.start("run", cli.program(ENDLESS), "--port", simulator.url, "--picture", "drawn.svg")
    simulator.wait_for_motions(CONFIRMED)
    process.signal(number)
    ended = process.end()
    assert ended.code == 130
    ended.check_said(
        f"interrupted ({number.name}) at program.logo", "The robot was stopped, after", "drawn.svg"
    )
    assert len(points(cli.text("drawn.svg"))) >= 2
    simulator.wait_until_still()
    begun = len(simulator.actions)
    # Whoever asks it, some time later, finds it where it stopped, and nothing has run on.
    assert cli("stop", "--port", simulator.url).out.startswith("stopped: the robot answers")
    assert not [action for action in simulator.actions[begun:] if action.startswith("started")]


def test_a_second_signal_does_not_prevent_the_stop(cli: Cli, wire: Callable[..., Wire]) -> None:
    raw = wire()
    process = cli.start("run", cli.program(ENDLESS), "--port", raw.path, *IMPATIENT, "--picture", "drawn.svg")
    raw.wait_for(b"F\0\x64\r")
    for _ in range(5):
        process.signal(signal.SIGINT)
        process.signal(signal.SIGTERM)
    ended = process.end()
    assert ended.code == 130
    ended.check_said("interrupted (SIG", "The robot was stopped", "drawn.svg")
    raw.wait_for_end(EMERGENCY_STOP)


def test_a_signal_on_the_way_out_is_only_noted(cli: Cli, wire: Callable[..., Wire]) -> None:
    """The program has failed, the robot is stopped, the picture is being written into a pipe that nobody reads yet."""
    raw = wire()
    os.mkfifo(cli.folder / "pipe.svg")
    program = cli.program("FD 5\nFDD")
    process = cli.start("run", program, "--port", raw.path, *IMPATIENT, "--picture", "pipe.svg")
    raw.wait_for(b"PD\r")
    raw.wait_for_end(EMERGENCY_STOP)
    for number in SIGNALS:
        process.signal(number)
    assert cli.text("pipe.svg").endswith("</svg>")
    ended = process.end()
    assert ended.code == 1
    ended.check_said("program.logo, line 2, column 1: I don't know how to FDD", "is in pipe.svg.")


def test_a_signal_while_it_connects(cli: Cli, wire: Callable[..., Wire]) -> None:
    raw = wire()
    arguments = ["run", cli.program(ENDLESS), "--port", raw.path, "--set", "boot_s=1000"]
    process = cli.start(*arguments)
    raw.wait_for(b"QH\r")
    process.signal(signal.SIGINT)
    ended = process.end()
    assert (ended.code, ended.out) == (130, "")
    ended.check_said("turtlewire: interrupted (SIGINT)")
    raw.wait_for_end(EMERGENCY_STOP)


def test_what_was_ignored_before_stays_ignored(cli: Cli) -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        process = cli.start("run", cli.program(ENDLESS), "--json")
        simulator = cli.simulate()
        assert simulator.url
    finally:
        signal.signal(signal.SIGHUP, before)
    simulator.signal(signal.SIGHUP)
    assert cli("stop", "--port", simulator.url).code == 0
    process.signal(signal.SIGHUP)
    process.signal(signal.SIGTERM)
    ended = process.end()
    assert ended.code == 130
    assert "interrupted (SIGTERM)" in ended.out


@pytest.mark.parametrize("number", SIGNALS)
def test_the_simulator_draws_its_picture(cli: Cli, number: signal.Signals) -> None:
    simulator = cli.simulate("--picture", "seen.svg", "--picture", "seen.png")
    host = os.open(simulator.url, os.O_RDWR | os.O_NOCTTY)
    os.write(host, b"2\rXA")
    simulator.wait_for_action("started start_forward")
    simulator.wait_for_action("pen down")
    os.close(host)
    simulator.signal(number)
    simulator.signal(signal.SIGINT)
    ended = simulator.end()
    assert ended.code == 130
    ended.check_said("interrupted (SIG", "drawn seen.svg", "drawn seen.png")
    assert len(points(cli.text("seen.svg"))) >= 2
    assert (cli.folder / "seen.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_of_the_simulator_that_fails_keeps_not_the_others(cli: Cli) -> None:
    for name in ("one.svg", "two.svg"):
        (cli.folder / name).symlink_to("/dev/full")
    simulator = cli.simulate("--picture", "one.svg", "--picture", "two.svg", "--picture", "three.svg")
    assert simulator.url
    simulator.signal(signal.SIGINT)
    ended = simulator.end()
    assert ended.code == 1
    ended.check_said(
        "cannot write the picture one.svg", "cannot write the picture two.svg", "drawn three.svg"
    )
