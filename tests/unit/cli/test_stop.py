"""``turtlewire stop``: robots of every protocol over real ptys, one by one and all at once."""

from __future__ import annotations

import asyncio
import os
import socket
import sys
import threading
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.cli.main import main
from turtlewire.protocols.frame.codec import FrameEncoder
from turtlewire.protocols.frame.dialect import shipped
from turtlewire.protocols.simple.messages import EMERGENCY_STOP
from turtlewire.simulator.car import CarSettings, SimulatedCar
from turtlewire.simulator.frame_robot import FrameRobotSettings, SimulatedFrameRobot
from turtlewire.simulator.server import serve_all
from turtlewire.simulator.walter import Settings, SimulatedWalter

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path


class Company:
    """A car, a two-engine robot, a WALTER and a basic one, at ptys, all of them driving."""

    def __init__(self) -> None:
        self.car = SimulatedCar(CarSettings())
        self.frame = SimulatedFrameRobot(FrameRobotSettings())
        self.walter = SimulatedWalter(Settings())
        self.basic = SimulatedWalter(Settings(groups=frozenset()))
        self.robots: list[Any] = [self.car, self.frame, self.walter, self.basic]
        self.heard = [b""] * len(self.robots)
        for number, robot in enumerate(self.robots):
            self._listen_in(number, robot)
        self.urls: list[str] = []
        self._ready = threading.Event()
        self._thread = threading.Thread(target=asyncio.run, args=(self._serve(),))
        self._thread.start()
        assert self._ready.wait(20.0)

    def _listen_in(self, number: int, robot: Any) -> None:
        write = robot.write

        def listen_in(data: bytes) -> None:
            self.heard[number] += data
            write(data)

        robot.write = listen_in

    async def _serve(self) -> None:
        self._loop, self._stopped = asyncio.get_running_loop(), asyncio.Event()

        def ready(urls: list[str]) -> None:
            self.urls = urls
            self._ready.set()

        await serve_all(self.robots, speed=5.0, ready=ready, stopped=self._stopped)

    def end(self) -> None:
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._stopped.set)
            self._thread.join()


@pytest.fixture
def company() -> Iterator[Company]:
    made = Company()
    yield made
    made.end()


@pytest.fixture(autouse=True)
def configured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Write ``robots.toml``."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    (tmp_path / "turtlewire").mkdir()

    def write(text: str) -> None:
        (tmp_path / "turtlewire" / "robots.toml").write_text(text, "utf-8")

    return write


def set_going(url: str, data: bytes) -> None:
    """What another host has sent before it went away."""
    port = os.open(url, os.O_RDWR | os.O_NOCTTY)
    os.write(port, data)
    os.close(port)


def test_a_car_that_drives_with_a_command_cut_off(
    company: Company, capsys: pytest.CaptureFixture[str]
) -> None:
    set_going(company.urls[0], b"F255000L1")
    assert main(["stop", "--port", f"{company.urls[0]}?protocol=simple&reply_delay_s=0.4"]) == 0
    assert capsys.readouterr() == ("stopped: the robot answers\n", "")
    company.end()
    assert company.heard[0].startswith(b"F255000L1" + EMERGENCY_STOP)
    assert not company.car.is_moving


def test_a_robot_that_speaks_frame_is_stopped_and_nothing_else(
    company: Company, capsys: pytest.CaptureFixture[str]
) -> None:
    url = f"{company.urls[1]}?protocol=frame"
    pen = company.frame.servos_deg
    drive = FrameEncoder(shipped("0.1")).frame(b"\x01\x00\xff\x01\x01\xff")
    # And the beginning of a frame, which the stop has to fill up.
    set_going(company.urls[1], drive + b"\xa3\x01\x7c\x01\x00\xff")
    assert main(["stop", "--port", url]) == 0
    out, err = capsys.readouterr()
    assert out == ""
    assert (
        err == f"the stop was sent to {company.urls[1]}; the robot answers nothing, so nothing confirms it\n"
    )
    assert main(["stop", "--port", url, "--require-replies"]) == 3
    assert "answers nothing" in capsys.readouterr().err
    company.end()
    assert not company.frame.is_moving
    assert company.frame.statistics.distance_mm > 0
    assert company.frame.servos_deg == pen


def test_all_of_them(
    company: Company, configured: Callable[[str], None], capsys: pytest.CaptureFixture[str]
) -> None:
    car, frame, walter, basic = company.urls
    text = (
        f'[herbie]\nport = "{car}"\nprotocol = "simple"\nreply_delay_s = 0.4\n'
        f'[dot]\nport = "{frame}"\nprotocol = "frame"\n'
        f'[elsie]\nport = "{walter}"\n[elmer]\nport = "{basic}"\nboot_s = 0\nreply_timeout_s = 0.1\n'
        '[dream]\nport = "sim:walter"\n'
    )
    configured(text)
    set_going(walter, b"F\xff\x00\r")
    set_going(car, b"F255000")
    assert main(["stop", "--all"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    told = dict(line.split(": ", 1) for line in out.splitlines())
    assert list(told) == ["herbie", "dot", "elsie", "elmer", "dream"]
    assert told["herbie"] == "stopped: the robot answers"
    assert told["dot"] == told["elmer"] == "the stop was sent, but nothing confirms it: it never answers"
    assert told["elsie"].startswith("stopped: the robot answers, at x 0 mm, y ")
    assert told["dream"].startswith("simulated")
    configured(text + '[gone]\nport = "/dev/no-such-port"\n[bad]\nport = "/dev/x"\nspeed = 0\n')
    assert main(["stop", "--all", "--require-replies"]) == 3
    out, err = capsys.readouterr()
    assert [line.split(": ")[0] for line in out.splitlines()] == ["herbie", "elsie", "dream"]
    failed = {line.split(": ")[1]: line for line in err.splitlines() if "NOT STOPPED" in line}
    assert failed.keys() == {"dot", "elmer", "gone", "bad"}
    assert "there is no port /dev/no-such-port" in failed["gone"]
    assert "[bad]: the setting speed is 0" in failed["bad"]
    company.end()
    assert not any(robot.is_moving for robot in company.robots)


def test_one_by_name(
    company: Company, configured: Callable[[str], None], capsys: pytest.CaptureFixture[str]
) -> None:
    configured(f'[elsie]\nport = "{company.urls[2]}"\n')
    assert main(["stop", "--robot", "elsie"]) == 0
    assert main(["stop", "--port", "elsie", "--require-replies"]) == 0
    assert (
        capsys.readouterr().out.count("stopped: the robot answers, at x 0 mm, y 0 mm, heading 0 degrees\n")
        == 2
    )


def test_a_silent_car_over_a_socket(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        url = f"socket://127.0.0.1:{silent.getsockname()[1]}?protocol=simple&boot_s=0"
        assert main(["stop", "--port", url]) == 3
        far, _ = silent.accept()
        with far:
            assert far.recv(len(EMERGENCY_STOP), socket.MSG_WAITALL) == EMERGENCY_STOP
    err = capsys.readouterr().err
    assert "cannot be talked to" in err
    assert "but nothing confirms it" in err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("", "the following arguments are required: --port, or --robot with a name, or --all"),
        ("--robot simple", "the following arguments are required: --port"),
        ("--all --port /dev/x", "leave out the others"),
        ("--all --robot x", "leave out the others"),
        ("--all --set baud=9600", "leave out the others"),
        ("--all", "there are no robots in "),
        ("--robot marvin", "invalid choice: 'marvin'"),
        ("--port sim:simple", "a robot of its own in each process"),
        ("--port pty:", "pty is a new port"),
    ],
)
def test_what_is_refused(capsys: pytest.CaptureFixture[str], arguments: str, said: str) -> None:
    assert main(["stop", *arguments.split()]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
