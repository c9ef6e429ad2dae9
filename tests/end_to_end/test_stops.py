"""A stop goes next on the wire, from wherever it is called; and every way out of a program stops its robot.

The robots are simulated ones at real ptys, whose bytes are kept.
"""

from __future__ import annotations

import asyncio
import os
import re
import signal
import subprocess
import sys
import threading
from typing import TYPE_CHECKING, Any

import pytest

import turtlewire
from tests.unit.robots.reconnecting.ports import PATIENT, ROBOTS, SPEED, Port
from turtlewire.errors import StoppedError, UsageError
from turtlewire.protocols.frame.codec import Frame, FrameDecoder
from turtlewire.protocols.frame.dialect import shipped

from .conftest import DEADLINE_S, EMERGENCY_STOP, wait_until

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from .conftest import Cli

    MakePort = Callable[..., Port]

# So many motions that some of them wait: behind the window, and in the program.
MOTIONS = 200
each_robot = pytest.mark.parametrize("protocol", ["walter", "simple", "frame"])
QUEUES = [("walter", "max_unfenced=16"), ("walter", "max_unfenced=48"), ("simple", "window=1"),
          ("simple", "window=8"), ("frame", "repeat_s=0.05")]  # fmt: skip


@pytest.fixture
def port(tmp_path: Path) -> Iterator[MakePort]:
    """A robot of a protocol at a pty."""
    ports: list[Port] = []

    def make(protocol: str, **settings: Any) -> Port:
        folder = tmp_path / str(len(ports))
        folder.mkdir()
        ports.append(Port("pty", ROBOTS[protocol](**settings), folder))
        return ports[-1]

    yield make
    for one in ports:
        one.unplug()


def url_of(port: Port, protocol: str, options: str = "heartbeat_s=never") -> str:
    return f"{port.url}?protocol={protocol}&boot_s=0.2{PATIENT[protocol]}&{options}"


def stop_at(heard: bytes, protocol: str) -> int:
    """Where in what was heard a whole stop begins; -1: nowhere."""
    if protocol == "frame":
        items = FrameDecoder(shipped("0.1")).receive_data(heard)
        stops = [item for item in items if isinstance(item, Frame) and is_halt(item)]
        return stops[0].offset if len(stops) > 10 else -1
    if protocol == "simple":
        # Whoever is in step needs no more than one; at once, it takes the bytes that stop any car.
        return min((at for at in (heard.find(b"S" * 14), heard.find(b"S000000")) if at >= 0), default=-1)
    return heard.find(EMERGENCY_STOP * 3)


def is_move(frame: Frame) -> bool:
    return any(m.name().startswith("engine") and m.values()[1] for m in frame.messages)


def is_halt(frame: Frame) -> bool:
    return len(frame.messages) == 2 and all(
        message.name() == "engine_forward" and message.values()[1] == 0 for message in frame.messages
    )


# Moves and turns of WALTER, and the keys that start one; set-points of a car that are not 0.
MOVES = {
    "walter": re.compile(rb"[FBLR]..\r|[GB].[AZ,.]", re.DOTALL),
    "simple": re.compile(rb"[FBLR](?!000)\d{3}"),
}


def last_move(heard: bytes, protocol: str) -> int:
    """Where the last that sets a robot going ends; 0: nothing does."""
    if protocol != "frame":
        return max((found.end() for found in MOVES[protocol].finditer(heard)), default=0)
    items = FrameDecoder(shipped("0.1")).receive_data(heard)
    moves = [item for item in items if isinstance(item, Frame) and is_move(item)]
    return moves[-1].offset + len(moves[-1].raw) if moves else 0


def stands(port: Port, protocol: str) -> bool:
    robot = port.robot
    return not robot.is_moving and (protocol != "walter" or robot._end.queued == 0)


def draw(robot: Any) -> None:
    for _ in range(MOTIONS):
        robot.forward(40)
        robot.right(91)


def check_stopped(port: Port, protocol: str, heard: int) -> None:
    """After so many bytes came a stop, and nothing that moves; the robot stands."""
    wait_until(lambda: stop_at(port.heard[heard:], protocol) >= 0, f"a stop in {port.heard[heard:]!r}")
    wait_until(lambda: stands(port, protocol), "the robot to stand")
    rest = port.heard[heard:]
    assert last_move(rest, protocol) <= stop_at(rest, protocol), rest


def check_goes_on(port: Port, protocol: str, command: Callable[[], object]) -> None:
    """The next command moves the robot by itself alone: nothing that was waiting runs."""
    before = port.robot.statistics.distance_mm
    command()
    wait_until(lambda: stands(port, protocol), "the robot to stand")
    # A robot that is timed by a host whose clock is slower than its own goes so much farther.
    most_mm = 25.0 if protocol == "walter" else 25.0 * SPEED
    assert port.robot.statistics.distance_mm - before < most_mm


@pytest.mark.parametrize(("protocol", "options"), QUEUES)
def test_from_another_thread(port: MakePort, protocol: str, options: str) -> None:
    one = port(protocol)
    with turtlewire.connect(url_of(one, protocol, options)) as robot:
        ended, again = threading.Event(), threading.Event()
        moved: list[bool] = []

        def work() -> None:
            with pytest.raises(StoppedError):
                draw(robot)
            ended.set()
            assert again.wait(DEADLINE_S)
            robot.forward(10)  # it has been told
            moved.append(True)

        worker = threading.Thread(target=work)
        one.moving.clear()
        worker.start()
        assert one.moving.wait(DEADLINE_S)
        heard = len(one.heard)
        robot.stop()
        assert ended.wait(DEADLINE_S)
        check_stopped(one, protocol, heard)
        check_goes_on(one, protocol, lambda: robot.forward(10))
        again.set()
        worker.join(DEADLINE_S)
        assert moved == [True]


@each_robot
def test_from_another_task(port: MakePort, protocol: str) -> None:
    one = port(protocol)

    async def main() -> None:
        async with await turtlewire.connect_async(url_of(one, protocol)) as robot:

            async def draw_async() -> None:
                for _ in range(MOTIONS):
                    await robot.forward(40)
                    await robot.right(91)

            one.moving.clear()
            drawing = asyncio.create_task(draw_async())
            await asyncio.to_thread(one.moving.wait, DEADLINE_S)
            heard = len(one.heard)
            await robot.stop()
            with pytest.raises(StoppedError):
                await drawing
            await asyncio.to_thread(check_stopped, one, protocol, heard)

    asyncio.run(main())


@each_robot
def test_from_a_callback(port: MakePort, protocol: str) -> None:
    """In the thread that serves the link nobody can wait for the robot: but a stop never waits."""
    one = port(protocol)
    with turtlewire.connect(url_of(one, protocol)) as robot:
        heard: list[int] = []
        errors: list[BaseException] = []

        def called_back() -> None:
            try:
                robot.wait(1000.0)
            except UsageError as error:
                errors.append(error)
            heard.append(len(one.heard))
            robot.stop()

        def later() -> None:
            assert one.moving.wait(DEADLINE_S)
            robot._runner._loop.call_soon_threadsafe(called_back)

        one.moving.clear()
        waiter = threading.Thread(target=later)
        waiter.start()
        with pytest.raises(StoppedError):
            draw(robot)
        waiter.join(DEADLINE_S)
        assert "it can stop() it, nothing else" in str(errors[0])
        check_stopped(one, protocol, heard[0])
        check_goes_on(one, protocol, lambda: robot.forward(10))


# ---------------------------------------------------------------- every way out

WAYS_OUT = {
    "an exception": "with turtlewire.connect(url) as robot:\n    drive(robot)\n    1 / 0",
    "sys.exit": "with turtlewire.connect(url) as robot:\n    drive(robot)\n    sys.exit(7)",
    "an exception, no with": "robot = turtlewire.connect(url)\ndrive(robot)\n1 / 0",
    "the interpreter ends": "robot = turtlewire.connect(url)\ndrive(robot)",
    "the last reference": "robot = turtlewire.connect(url)\ndrive(robot)\ndel robot\ngc.collect()\ninput()",
    "interrupted": "robot = turtlewire.connect(url)\ndrive(robot)\nrobot.wait(1e6)",
}
DRIVE = """
import gc, sys, turtlewire
url = sys.argv[1]
def drive(robot):
    robot.drive(0.5, 0.0)
    print("driving", flush=True)
    input()
"""


@pytest.fixture
def driving(port: MakePort) -> Iterator[Callable[..., tuple[Port, subprocess.Popen[str]]]]:
    """A program that drives a robot by hand, which moves; what it does next begins with a line of input."""
    programs: list[subprocess.Popen[str]] = []

    def start(protocol: str, text: str, options: str = "heartbeat_s=never", **settings: Any) -> Any:
        one = port(protocol, **settings)
        programs.append(
            subprocess.Popen(
                [sys.executable, "-c", DRIVE + text, url_of(one, protocol, options)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                env={**os.environ, "PYTHONWARNINGS": "error"},
            )
        )
        out = programs[-1].stdout
        assert out is not None
        assert out.readline() == "driving\n"
        wait_until(lambda: one.robot.is_moving, "the robot to move")
        return one, programs[-1]

    yield start
    for program in programs:
        program.kill()
        program.communicate()


@each_robot
@pytest.mark.parametrize("way", WAYS_OUT)
def test_ways_out(driving: Any, protocol: str, way: str) -> None:
    one, program = driving(protocol, WAYS_OUT[way])
    if way == "interrupted":
        program.send_signal(signal.SIGINT)
    else:
        program.stdin.write("\n")
        program.stdin.flush()
    if way == "the last reference":
        wait_until(lambda: stands(one, protocol), "the robot to stand")
        assert program.poll() is None  # it is alive, and waits for input
    _, complaints = program.communicate("\n", timeout=DEADLINE_S)
    assert "Exception ignored" not in complaints
    assert last_move(one.heard, protocol)
    check_stopped(one, protocol, last_move(one.heard, protocol))


@each_robot
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals(cli: Cli, port: MakePort, protocol: str, number: signal.Signals) -> None:
    one = port(protocol)
    program = cli.program("REPEAT 100000 [FD 40 RT 91]")
    one.moving.clear()
    process = cli.start("run", program, "--port", url_of(one, protocol))
    assert one.moving.wait(DEADLINE_S)
    process.signal(number)
    ended = process.end()
    assert ended.code == 130
    ended.check_said(f"interrupted ({number.name})", "The robot was stopped")
    wait_until(lambda: stands(one, protocol), "the robot to stand")


@each_robot
def test_sigkill_is_for_the_watchdog(driving: Any, protocol: str) -> None:
    """The driver feeds it for as long as it lives; then the robot stops by itself."""
    one, program = driving(protocol, WAYS_OUT["interrupted"], "heartbeat_s=0.05", watchdog_s=10.0)
    began_s = one.robot.now
    wait_until(lambda: one.robot.now > began_s + 25.0, "time to pass")
    assert one.robot.is_moving
    assert one.robot.statistics.watchdog_stops == 0
    program.kill()
    wait_until(lambda: stands(one, protocol), "the watchdog")
    assert one.robot.statistics.watchdog_stops == 1
