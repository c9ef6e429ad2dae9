"""Programs of ``turtlewire console`` on a robot at a port: whatever ends, the robot stands, and no process is left."""

from __future__ import annotations

import os
import re
import signal
from pathlib import Path
from typing import TYPE_CHECKING

import httpx
import pytest

from tests.unit.robots.reconnecting.ports import PATIENT, ROBOTS, Port

from .conftest import EMERGENCY_STOP, wait_until

if TYPE_CHECKING:
    from collections.abc import Iterator

    from .conftest import Cli, Process

# The last bytes that a stopped WALTER hears (W8).
STOPPED = re.compile(re.escape(EMERGENCY_STOP) + rb".*\Z", re.DOTALL)


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Port]:
    made = Port("pty", ROBOTS["walter"](), tmp_path)
    yield made
    made.unplug()


class Driven:
    """A console whose robot draws a line that has no end."""

    def __init__(self, cli: Cli, robot: Port) -> None:
        url = f"{robot.url}?protocol=walter&boot_s=0.2{PATIENT['walter']}"
        self.process: Process = cli.start(
            "console", "--listen-port", "0", "--programs", "programs", "--port", url
        )
        self.process.wait_for_out("turtlewire console: ")
        wait_until(lambda: "\n" in self.process.out, "an address")
        address = re.search(r"console: (\S+)", self.process.out)
        assert address is not None
        self.client = httpx.Client(base_url=address[1], trust_env=False)
        wait_until(lambda: self.client.get("/api/robots").json()[0]["reached"], "the robot")
        self.path = f"/api/robots/{self.client.get('/api/robots').json()[0]['name']}"
        self.client.headers["X-Session"] = self.client.post("/api/sessions", json={}).json()["session"]
        self.client.post(f"{self.path}/wheel", json={"action": "take"})
        begun = self.client.post(f"{self.path}/program", json={"source": "fd 1000000"})
        assert begun.status_code == 201, begun.text
        wait_until(lambda: robot.robot.is_moving, "motion")
        (self.worker,) = children(self.process.popen.pid)

    def phase(self) -> str:
        return str(self.client.get(f"{self.path}/program").json()["phase"])


@pytest.fixture
def driven(cli: Cli, robot: Port) -> Iterator[Driven]:
    made = Driven(cli, robot)
    yield made
    made.client.close()


def children(pid: int) -> list[int]:
    found = Path(f"/proc/{pid}/task").glob("*/children")
    return [int(child) for each in found for child in each.read_text().split()]


def is_gone(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_a_signal_stops_the_robot_and_ends_the_program(
    driven: Driven, robot: Port, number: signal.Signals
) -> None:
    driven.process.signal(number)
    assert driven.process.end().code == 130
    wait_until(lambda: not robot.robot.is_moving, "a robot that stands")
    assert STOPPED.search(robot.heard)
    wait_until(lambda: is_gone(driven.worker), "the program's process to be gone")


def test_anybodys_stop_is_heard_while_a_motion_is_under_way(driven: Driven, robot: Port) -> None:
    assert httpx.post(f"{driven.client.base_url}api/stop", trust_env=False).status_code == 200
    wait_until(lambda: not robot.robot.is_moving, "a robot that stands")
    assert STOPPED.search(robot.heard)
    wait_until(lambda: driven.phase() == "stopped", "the program's end")
    wait_until(lambda: is_gone(driven.worker), "the program's process to be gone")
    driven.process.signal(signal.SIGTERM)
    assert driven.process.end().code == 130


def test_a_process_that_is_killed_stops_the_robot(driven: Driven, robot: Port) -> None:
    os.kill(driven.worker, signal.SIGKILL)
    wait_until(lambda: not robot.robot.is_moving, "a robot that stands")
    assert STOPPED.search(robot.heard)
    wait_until(lambda: driven.phase() == "failed", "the program's end")
    driven.process.signal(signal.SIGTERM)
    assert driven.process.end().code == 130


def test_a_server_that_is_killed_leaves_no_process_behind(driven: Driven) -> None:
    driven.process.signal(signal.SIGKILL)
    wait_until(lambda: is_gone(driven.worker), "the program's process to be gone")
