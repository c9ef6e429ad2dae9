"""``turtlewire identify`` of ports: it listens, and sends nothing."""

from __future__ import annotations

import json
import os
import pty
import signal
import socket
import subprocess
import tty
from typing import TYPE_CHECKING

import pytest

from tests.end_to_end.conftest import COMMAND, DEADLINE_S, Cli, Wire

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

REPLIES = b"QH\0\0\rQX\0\xc8\rQY\0\x64\rQP\x01\rLF\rQL\0\xc8\0\x64\rQH\0\x5a\r"


@pytest.fixture
def line() -> Iterator[tuple[int, str]]:
    """The robot's end of a line, and the path of the other."""
    near, far = pty.openpty()
    tty.setraw(far)
    yield near, os.ttyname(far)
    os.close(far)
    os.close(near)


def test_a_port_is_listened_to_until_it_is_sure(cli: Cli, line: tuple[int, str]) -> None:
    near, path = line
    # The time is never up.
    process = cli.start("identify", path, "--seconds", "1e9")
    process.wait_for_err("listening at")
    os.write(near, REPLIES)
    ended = process.end()
    assert ended.code == 0
    assert ended.out.startswith("walter, from the robot (")
    os.set_blocking(near, False)
    with pytest.raises(BlockingIOError):
        os.read(near, 1)


def test_a_socket_that_ends_is_judged_by_what_it_said(cli: Cli) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        process = cli.start(
            "identify", f"socket://127.0.0.1:{server.getsockname()[1]}", "--json", "--seconds", "1e9"
        )
        robot, _ = server.accept()
        with robot:
            robot.sendall(REPLIES[:5])
    ended = process.end()
    assert ended.code == 1
    assert json.loads(ended.out)["bytes"] == 5


def test_a_socket_that_ends_without_a_word_is_a_lost_link(cli: Cli) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        process = cli.start("identify", f"socket://127.0.0.1:{server.getsockname()[1]}", "--seconds", "1e9")
        server.accept()[0].close()
    ended = process.end()
    assert (ended.code, ended.out) == (3, "")
    ended.check_said("ended")


def test_when_the_time_is_up_it_says_what_it_has(cli: Cli, line: tuple[int, str]) -> None:
    ended = cli("identify", line[1], "--seconds", "0.01")
    assert ended.code == 1
    assert "there are no bytes" in ended.out


def test_ctrl_c_ends_listening_and_it_says_what_it_has(cli: Cli, line: tuple[int, str]) -> None:
    near, path = line
    process = cli.start("identify", path, "--seconds", "1e9")
    process.wait_for_err("listening at")
    os.write(near, REPLIES[:5])
    process.signal(signal.SIGINT)
    ended = process.end()
    assert ended.code == 130
    assert "perhaps" in ended.out or "none of the three" in ended.out
    ended.check_said("interrupted (SIGINT)")


def test_the_rate_of_what_talks_is_found(cli: Cli) -> None:
    simulator = cli.simulate("--baud", "115200", robot="frame?dialect=telemetry", speed="1")
    ended = cli("identify", simulator.url, "--baud", "auto", "--json")
    assert ended.code == 0
    told = json.loads(ended.out)
    assert (told["baud"], told["verdicts"][0]["protocol"]) == (115200, "frame")
    ended.check_said("at one rate after the other", "     9600 baud  ")


def test_ctrl_c_ends_listening_at_all_rates_too(cli: Cli, line: tuple[int, str]) -> None:
    process = cli.start("identify", line[1], "--baud", "auto", "--seconds", "1e9")
    process.wait_for_err("listening at")
    process.signal(signal.SIGINT)
    ended = process.end()
    assert ended.code == 130
    assert "there are no bytes" in ended.out
    ended.check_said("interrupted (SIGINT)")


def test_a_port_that_vanishes_while_all_rates_are_listened_to(cli: Cli) -> None:
    simulator = cli.simulate("--baud", "9600", speed="1")
    process = cli.start("identify", simulator.url, "--baud", "auto", "--seconds", "1e9")
    process.wait_for_err("listening at")
    simulator.signal(signal.SIGKILL)
    ended = process.end()
    assert (ended.code, ended.out) == (3, "")
    ended.check_said("ended")


def test_a_port_in_use_is_said(cli: Cli, wire: Callable[..., Wire]) -> None:
    robot = wire()
    holder = cli.start("identify", robot.path, "--seconds", "1e9")
    holder.wait_for_err("listening at")
    ended = cli("identify", robot.path)
    assert ended.code == 3
    ended.check_said("is in use by another program")
    holder.signal(signal.SIGTERM)
    assert holder.end().code == 130
    assert not robot.received


def test_a_pipe() -> None:
    done = subprocess.run(
        [*COMMAND, "identify", "-"], input=REPLIES, capture_output=True, check=False, timeout=DEADLINE_S
    )
    assert done.returncode == 0
    assert done.stdout.startswith(b"walter, from the robot")
