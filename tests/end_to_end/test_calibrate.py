"""``turtlewire calibrate`` on a real terminal, with a robot at a real pty: what the robot truly did is typed in."""

from __future__ import annotations

import asyncio
import math
import re
import signal
import threading
import tomllib
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.simulator.car import CarSettings, SimulatedCar
from turtlewire.simulator.frame_robot import FrameRobotSettings, SimulatedFrameRobot
from turtlewire.simulator.server import serve
from turtlewire.simulator.walter import Settings, SimulatedWalter

from .conftest import DEADLINE_S, Cli, wait_until
from .terminal import Terminal
from .test_lost_links import Cable

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Callable, Iterator
    from pathlib import Path

PROMPT = re.compile(r"(stop here > |\[(?P<hint>[^\]]*)\] > |give up > |\[y/n\] |do not write it\): )\Z")
CTRL_C = "\x03"


class Served:
    """A simulated robot at a pty, in real time, whose body can be seen."""

    def __init__(self, body: Any) -> None:
        self.body = body
        self._ready = threading.Event()
        self._thread = threading.Thread(target=asyncio.run, args=(self._serve(),))
        self._thread.start()
        assert self._ready.wait(DEADLINE_S)

    async def _serve(self) -> None:
        self._loop, self._stopped = asyncio.get_running_loop(), asyncio.Event()

        def ready(url: str) -> None:
            self.url = url
            self._ready.set()

        await serve(self.body, "pty", ready=ready, stopped=self._stopped)

    def wait_until_moving(self) -> None:
        wait_until(lambda: bool(self.body.is_moving), "motion")

    def wait_until_standing(self) -> None:
        wait_until(lambda: not self.body.is_moving, "a stop")

    def end(self) -> None:
        self._loop.call_soon_threadsafe(self._stopped.set)
        self._thread.join()


class Sitting:
    """Somebody at a terminal, at which a calibration is under way."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        self.screen = Terminal(150, 40)
        self.file = folder / "turtlewire" / "robots.toml"
        environment = {"XDG_CONFIG_HOME": str(folder)}
        self.process: subprocess.Popen[bytes] = self.screen.run(
            ["calibrate", *arguments], folder, environment
        )
        self._read = 0

    def wait_for_prompt(self) -> str:
        """What was told until it asks for something, or ends."""

        def asks() -> bool:
            return bool(PROMPT.search(self.screen.text[self._read :])) or self.process.poll() is not None

        wait_until(asks, "a prompt")
        told = self.screen.text[self._read :]
        self._read += len(told)
        return told.replace("\r\n", "\n")

    def type(self, text: str) -> str:
        """Type a line; what was told until the next prompt."""
        self.screen.press(f"{text}\r")
        return self.wait_for_prompt()

    def wait_for(self, text: str) -> None:
        wait_until(lambda: text in self.screen.text, f"{text!r} in {self.screen.text}")

    def end(self) -> int:
        return self.process.wait(DEADLINE_S)

    def clean_up(self) -> None:
        self.process.kill()
        self.process.wait()
        self.screen.close()


@pytest.fixture
def served() -> Iterator[Callable[[Any], Served]]:
    robots: list[Served] = []

    def make(body: Any) -> Served:
        robots.append(Served(body))
        return robots[-1]

    yield make
    for robot in robots:
        robot.end()


@pytest.fixture
def sit(tmp_path: Path) -> Iterator[Callable[..., Sitting]]:
    sittings: list[Sitting] = []

    def make(*arguments: str) -> Sitting:
        sittings.append(Sitting(tmp_path, *arguments))
        return sittings[-1]

    yield make
    for sitting in sittings:
        sitting.clean_up()


class Trials:
    """All that was told and answered, drive by drive: the seconds of each, and what was measured."""

    def __init__(self, sitting: Sitting, body: Any) -> None:
        self._sitting, self._body = sitting, body
        self.measured: list[tuple[str, float, float]] = []

    def go_through(self) -> str:
        """Answer everything by what the body truly did; returns the last prompt, or what was told at the end."""
        told = self._sitting.wait_for_prompt()
        while "stop here > " in told:
            before = self._body.pose
            does = re.findall(r"^  (It .*)", told, re.MULTILINE)[-1]
            told = self._sitting.type("")
            while "] > " in told:
                answer = self._answer(told, before)
                seconds = re.search(r"for ([\d.]+) s", does)
                if not self.measured:
                    assert "write a number of mm" in self._sitting.type("a lot")
                    wrong = self._sitting.type("123456")
                    assert re.search(r"123456 mm is not plausible: it should be from \d+ to \d+", wrong)
                self.measured.append((does, float(seconds[1]) if seconds else 0.0, answer))
                again = self._sitting.type(f"{answer:.3f}")
                if "is not plausible" in again:  # a busy machine
                    again = self._sitting.type(f"{answer:.3f}")
                told = again
        return told

    def _answer(self, question: str, before: Any) -> float:
        after = self._body.pose
        if "[degrees] > " in question:
            turned: float = self._body.rotated_deg - self._turned_deg
            self._turned_deg += turned
            return turned
        return float(before.distance_to(*after[:2]))

    _turned_deg = 0.0


def test_a_car_is_measured_and_its_entry_written(
    served: Callable[[Any], Served], sit: Callable[..., Sitting]
) -> None:
    robot = served(SimulatedCar(CarSettings(mm_per_s_per_pwm=2.0, dead_pwm=50)))
    sitting = sit(
        *["--port", f"{robot.url}?protocol=simple&window=2", "--steps", "speed", "--space-mm", "200"],
        *["--repeats", "1"],
    )
    trials = Trials(sitting, robot.body)
    told = trials.go_through()
    assert "it moves: any key stops it" in sitting.screen.text
    assert "write this to" in told
    refused = sitting.type("frame")
    assert "'frame' cannot be the name of a robot" in refused
    sitting.type("herbie")
    assert sitting.end() == 0
    # One to get to know it, a short and a long one, two others.
    assert len(trials.measured) == 5
    (_, short_s, short), (_, long_s, long) = trials.measured[1:3]
    speed = (long - short) / (long_s - short_s)
    assert speed == pytest.approx(196.0, rel=0.3)
    row = re.search(r"forward at PWM 148, mm/s +270 +([\d.]+)", sitting.screen.text)
    assert row is not None
    assert float(row[1]) == pytest.approx(speed, rel=0.001)
    entry = tomllib.loads(sitting.file.read_text("utf-8"))["herbie"]
    assert entry["port"] == robot.url
    assert (entry["protocol"], entry["window"]) == ("simple", 2)
    assert set(entry["calibration"]) <= {"forward", "overrun_s"}
    assert not robot.body.is_moving


def test_a_walter_that_has_an_entry(
    served: Callable[[Any], Served], sit: Callable[..., Sitting], tmp_path: Path
) -> None:
    robot = served(SimulatedWalter(Settings(distance_scale=1.06, turn_scale=0.9, speed=255)))
    file = tmp_path / "turtlewire" / "robots.toml"
    file.parent.mkdir()
    file.write_text(
        f'[elsie]  # ours\nport = "{robot.url}"\nspeed = 255  # fast\nturn_scale = 1.0\n', "utf-8"
    )
    sitting = sit(
        "--robot", "elsie", "--steps", "distance,angle", "--space-mm", "300", "--repeats", "1", "--write"
    )
    Trials(sitting, robot.body).go_through()
    assert sitting.end() == 0
    text = file.read_text("utf-8")
    assert text.startswith(f'[elsie]  # ours\nport = "{robot.url}"\nspeed = 255  # fast\n')
    assert "turn_scale = 1.0" not in text
    entry = tomllib.loads(text)["elsie"]["calibration"]
    # These do not depend on any clock.
    assert entry["distance_scale"] == pytest.approx(1.06, rel=0.005)
    assert entry["turn_scale"] == pytest.approx(0.9, rel=0.005)


def test_the_engines_of_a_two_engine_robot(
    served: Callable[[Any], Served], sit: Callable[..., Sitting]
) -> None:
    wired = FrameRobotSettings(left_engine=1, right_engine=0, left_reversed=True)
    robot = served(SimulatedFrameRobot(wired))
    where = f"{robot.url}?protocol=frame&boot_s=0.1"
    sitting = sit("--port", where, "--steps", "engines", "--write", "dot", "--json")
    told = sitting.wait_for_prompt()
    for number, answer, seen in ((0, "right", (0.0, 1.0)), (1, "left back", (-1.0, 0.0))):
        assert f"Engine {number} turns forward" in told
        before = robot.body.wheels_mm
        assert "[left/left back/right/right back/none] > " in sitting.type("")
        after = robot.body.wheels_mm
        turned = [b - a for a, b in zip(before, after, strict=True)]
        assert [math.copysign(1.0, mm) if abs(mm) > 1.0 else 0.0 for mm in turned] == list(seen)
        assert "the answers are left, left back" in sitting.type("L")
        told = sitting.type(answer)
    assert sitting.end() == 0
    calibration = tomllib.loads(sitting.file.read_text("utf-8"))["dot"]["calibration"]
    assert calibration == {"left_engine": 1, "right_engine": 0, "left_reversed": True}


# Eight seconds, more than two metres.
STEER = ("--steps", "speed", "--space-mm", "20000", "--repeats", "1")
WHOLE_MM = 2160.0


@pytest.fixture
def driving(served: Callable[[Any], Served], sit: Callable[..., Sitting]) -> tuple[Served, Sitting]:
    """A car in the middle of a long drive."""
    robot = served(SimulatedCar(CarSettings()))
    sitting = sit("--port", f"{robot.url}?protocol=simple", "--write", "herbie", *STEER)
    sitting.wait_for_prompt()
    sitting.screen.press("\r")
    robot.wait_until_moving()
    sitting.wait_for("it moves: any key stops it")
    return robot, sitting


@pytest.mark.parametrize("key", [" ", "\r"])
def test_any_key_stops_it(driving: tuple[Served, Sitting], key: str) -> None:
    robot, sitting = driving
    sitting.screen.press(key)
    robot.wait_until_standing()
    assert robot.body.pose.y_mm < 0.9 * WHOLE_MM
    assert "stopped: this does not count" in sitting.wait_for_prompt()
    # The same drive once more, if it is wanted.
    sitting.screen.press("\r")
    robot.wait_until_moving()
    sitting.screen.press(" ")
    robot.wait_until_standing()
    told = sitting.wait_for_prompt()
    assert told.count("It drives ahead at PWM 148") == 1
    sitting.type("q")
    assert sitting.end() == 0
    assert not sitting.file.exists()


@pytest.mark.parametrize("how", ["ctrl-c", "SIGTERM", "hang up"])
def test_it_is_stopped_and_nothing_written(driving: tuple[Served, Sitting], how: str) -> None:
    robot, sitting = driving
    if how == "ctrl-c":
        sitting.screen.press(CTRL_C)
    elif how == "SIGTERM":
        sitting.process.send_signal(signal.SIGTERM)
    else:
        sitting.screen.hang_up()
    assert sitting.end() == 130
    robot.wait_until_standing()
    assert robot.body.pose.y_mm < 0.9 * WHOLE_MM
    assert robot.body.drive == 0
    assert not sitting.file.exists()
    if how != "hang up":
        sitting.wait_for("interrupted (SIG")
        sitting.wait_for("Nothing was written.")


def test_ctrl_c_at_a_question(served: Callable[[Any], Served], sit: Callable[..., Sitting]) -> None:
    robot = served(SimulatedCar(CarSettings()))
    sitting = sit("--port", f"{robot.url}?protocol=simple", *STEER)
    sitting.wait_for_prompt()
    sitting.screen.press(CTRL_C)
    assert sitting.end() == 130
    sitting.wait_for("Nothing was written.")


@pytest.mark.parametrize("comes_back", [False, True])
def test_a_link_that_is_lost_midway(cli: Cli, sit: Callable[..., Sitting], comes_back: bool) -> None:
    cable = Cable(cli)
    simulator = cable.plug_in(robot="simple", speed="1")
    sitting = sit("--port", f"{cable.port}?protocol=simple", "--write", "herbie", *STEER)
    sitting.wait_for_prompt()
    sitting.screen.press("\r")
    simulator.wait_for_action("drive_forward")
    cable.unplug(simulator)
    told = sitting.wait_for_prompt()
    assert "Enter: go on when it is plugged in again" in told
    if comes_back:
        back = cable.plug_in(robot="simple", speed="1")
        assert "It drives ahead at PWM 148" in sitting.type("")
        assert not any(action.startswith("drive_forward speed=1") for action in back.actions)
        sitting.type("q")
        assert sitting.end() == 0
    else:
        sitting.screen.press("q\r")
        assert sitting.end() == 3
        sitting.wait_for("Nothing was written.")
    assert not sitting.file.exists()
