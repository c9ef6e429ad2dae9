"""The drivers and the command line, unchanged, against emulated boards: the same picture, and a stop whatever happens.

Over a pseudo-terminal at the pace of the wall, from process to process; the long drawing in the chip's own time.
"""

from __future__ import annotations

import json
import random
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

import turtlewire
from turtlewire.deviation import between
from turtlewire.errors import LinkLostError, PoseUncertainError
from turtlewire.links.memory import MemoryLink
from turtlewire.logo import Interpreter
from turtlewire.protocols.simple.messages import BAUD as CAR_BAUD
from turtlewire.protocols.walter.messages import BAUD as WALTER_BAUD
from turtlewire.robots import car, two_engine, walter
from turtlewire.robots.runner import InlineRunner
from turtlewire.simulator.walter import Settings as SimulatedSettings
from turtlewire.simulator.walter import SimulatedWalter

from .chip import Chip
from .served import ServedBoard
from .test_frame_robot import DIALECT, SKETCH
from .turtle import drawing

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.firmware import Built
    from turtlewire.links.memory import VirtualEnd
    from turtlewire.trace import Trace

ROSE = Path(__file__).parents[2] / "examples" / "rose.logo"
SWITCHES = (14, 15, 16, 17)
BOOTED_S = 0.12
DEADLINE_S = 60.0
# The pen up and down, corners that are no whole degrees, absolute moves, and the way home.
PROGRAM = "PU FD 20 PD REPEAT 5 [FD 30 RT 144] SETPOS [-12 7.3] PU SETH 33 BK 10.7 PD HOME\n"
# How far the robot's way may be from the simulator's. Both carry out the same half millimetres and whole degrees, but
# a step is a sixteenth of a millimetre, or a twentieth of a degree: half a step off, a metre is 0.2 mm off.
TOLERANCE_MM = 0.25


def run_here(end: VirtualEnd, program: str, speed: int) -> None:
    """Have a robot draw, in its own time."""

    async def connect() -> walter.AsyncWalter:
        robot = walter.AsyncWalter(MemoryLink(end), walter.Settings(speed=speed), lambda _: None)
        await robot.connect()
        return robot

    runner = InlineRunner()
    with walter.Walter(runner.run(connect()), runner) as robot:
        Interpreter(robot, print, random.Random(0)).run(program)
        robot.finish()


def simulated(program: str, speed: int = 255, groups: frozenset[str] = frozenset("CQHE")) -> Trace:
    """What the simulator draws."""
    robot = SimulatedWalter(SimulatedSettings(groups=groups))
    run_here(robot, program, speed)
    return robot.trace


def check_same(drawn: Trace, wanted: Trace) -> None:
    """The same lines with the pen down, and the same place in the end."""
    found = between(drawn, wanted)
    assert found is not None
    assert found.largest < TOLERANCE_MM
    assert drawn.pose[:2] == pytest.approx(wanted.pose[:2], abs=TOLERANCE_MM)
    assert [stroke.pen_down for stroke in drawn.strokes] == [stroke.pen_down for stroke in wanted.strokes]


def drawn_by(program: Built, logo: str, speed: int = 255) -> Trace:
    """What an emulated board draws, in its own time."""
    with Chip(program.elf, WALTER_BAUD) as chip:
        for pin in SWITCHES:
            chip.press(pin, 1)
        chip.run(BOOTED_S)
        run_here(chip, logo, speed)
        assert chip.overruns == 0
        return drawing(chip)


def test_the_whole_rose_is_the_simulators(built: Callable[[str], Built]) -> None:
    """Three thousand commands, fifteen metres: what rounding to steps leaves never adds up."""
    rose = ROSE.read_text("utf-8")
    check_same(drawn_by(built("Walter"), rose), simulated(rose))


def test_without_a_single_answer_the_picture_is_the_same(built: Callable[[str], Built]) -> None:
    check_same(drawn_by(built("WalterBasic"), PROGRAM), simulated(PROGRAM, groups=frozenset()))


def run_there(port: str, program: str, folder: Path, *options: str) -> dict[str, Any]:
    """``turtlewire run``, as a process; what it says as JSON."""
    path = folder / "program.logo"
    path.write_text(program, "utf-8")
    command = [sys.executable, "-m", "turtlewire", "run", str(path), "--port", port, "--json"]
    done = subprocess.run(
        [*command, "--set", "speed=255", *options], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert isinstance(told, dict)
    return told


@pytest.mark.parametrize("sketch", ["Walter", "WalterBasic"])
def test_the_command_line_draws_with_it_over_a_port(
    built: Callable[[str], Built], tmp_path: Path, sketch: str
) -> None:
    with ServedBoard(built(sketch), WALTER_BAUD, tmp_path, SWITCHES) as board:
        told = run_there(board.port, PROGRAM, tmp_path)
        drawn = board.drawing()
        assert board.do("state")["overruns"] == 0
    assert told["outcome"] == "done"
    answers = sketch == "Walter"
    assert (told["robot_pose"] is not None) == answers
    assert told["statistics"]["retries"] == told["statistics"]["malformed_replies"] == 0
    check_same(drawn, simulated(PROGRAM, groups=frozenset("CQHE") if answers else frozenset()))


@pytest.mark.nightly
def test_the_command_line_draws_the_rose_over_a_port(built: Callable[[str], Built], tmp_path: Path) -> None:
    """As above, two minutes long."""
    rose = ROSE.read_text("utf-8")
    with ServedBoard(built("Walter"), WALTER_BAUD, tmp_path, SWITCHES) as board:
        assert run_there(board.port, rose, tmp_path)["outcome"] == "done"
        drawn = board.drawing()
    check_same(drawn, simulated(rose))


def wait_until(condition: Callable[[], bool], what: str) -> None:
    """Ask again and again: each time is a round trip to the board."""
    deadline = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline, f"waited in vain for {what}"


def test_a_car_that_is_unplugged_midway_comes_back_stopped(
    built: Callable[[str], Built], tmp_path: Path
) -> None:
    """It is known at once, the same session reaches it again, and nothing resumes but what is asked for anew."""
    motors = (5, 6)
    with ServedBoard(built("SimpleCar"), CAR_BAUD, tmp_path) as board:
        settings = car.Settings(boot_s=1.0)
        with turtlewire.connect(board.port, settings, announce=lambda _: None) as robot:
            robot.motor(200)
            robot.steer(-90)
            wait_until(lambda: [board.duty(pin) for pin in motors] == [200, 90], "the car to drive")
            board.do("unplug")
            with pytest.raises(LinkLostError):
                robot.forward(1000.0)
            board.do("plug")
            robot.reconnected()
            edges = board.do("state")["edges"]
            assert [board.duty(pin) for pin in motors] == [0, 0]
            with pytest.raises((LinkLostError, PoseUncertainError)):
                robot.motor(50)
            robot.resume()
            after = board.do("state")
            assert [after["duty"][str(pin)] for pin in motors] == [0, 0]
            assert [after["edges"][str(pin)] for pin in motors] == [edges[str(pin)] for pin in motors]
            robot.motor(100)
            wait_until(lambda: board.duty(5) == 100, "the car to drive on")
        assert [board.duty(pin) for pin in motors] == [0, 0]
        assert board.do("state")["overruns"] == 0


def test_a_robot_that_is_reset_midway_comes_back_stopped(
    built: Callable[[str], Built], tmp_path: Path
) -> None:
    """FrameRobot: driven by its own dialect, unplugged, and stopped when it is there again; then it drives on."""
    motors = (5, 6)
    with ServedBoard(built("FrameRobot"), DIALECT.baud, tmp_path, (4,)) as board:
        url = f"{board.port}?protocol=frame&dialect={SKETCH / 'dialect.toml'}"
        with turtlewire.connect(url, announce=lambda _: None) as robot:
            assert isinstance(robot, two_engine.TwoEngine)
            robot.engine(0, 120)
            robot.engine(1, -130)
            wait_until(lambda: [board.duty(pin) for pin in motors] == [120, 130], "the robot to drive")
            assert board.do("state")["levels"][7:9] == [1, 0]
            board.do("unplug")
            with pytest.raises(LinkLostError):
                robot.forward(1000.0)
            board.do("plug")
            robot.reconnected()
            assert [board.duty(pin) for pin in motors] == [0, 0]
            robot.resume()
            robot.engine(1, 77)
            wait_until(lambda: [board.duty(pin) for pin in motors] == [0, 77], "the robot to drive on")
        wait_until(lambda: [board.duty(pin) for pin in motors] == [0, 0], "the robot to stop")
        assert board.do("state")["overruns"] == 0
