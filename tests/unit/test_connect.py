"""``connect``: by URL, for people and for asynchronous programs, over a simulated robot and over real ports."""

from __future__ import annotations

import asyncio
import gc
import inspect
import logging
import os
import signal
import subprocess
import sys
import threading
from typing import TYPE_CHECKING, Any

import pytest

import turtlewire
from turtlewire.configuration import target
from turtlewire.connect import connect, stop
from turtlewire.errors import (
    LinkClosedError,
    LinkLostError,
    MessageError,
    NoReplyError,
    NotSupportedError,
    PortNotFoundError,
    StoppedError,
    UsageError,
)
from turtlewire.links.faults import FaultyLink
from turtlewire.links.memory import MemoryLink
from turtlewire.protocols.walter import messages as m
from turtlewire.robots.car import AsyncCar, Car
from turtlewire.robots.car import Settings as CarSettings
from turtlewire.robots.runner import InlineRunner, ThreadRunner
from turtlewire.robots.two_engine import AsyncTwoEngine, TwoEngine
from turtlewire.robots.two_engine import Settings as TwoEngineSettings
from turtlewire.robots.walter import AsyncWalter, Settings, Walter
from turtlewire.simulated import simulated
from turtlewire.simulator.car import CarSettings as CarRobotSettings
from turtlewire.simulator.car import SimulatedCar
from turtlewire.simulator.frame_robot import FrameRobotSettings, SimulatedFrameRobot
from turtlewire.simulator.server import serve
from turtlewire.simulator.walter import Settings as RobotSettings
from turtlewire.simulator.walter import SimulatedWalter
from turtlewire.turtle import Pose, Turtle

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from turtlewire.links.link import Link
    from turtlewire.simulator.walter import Action

FAST = Settings(boot_s=0.0)


class Served:
    """A simulated robot at a real port, in a thread of its own."""

    def __init__(self, listen: str, speed: float, robot: Any) -> None:
        self.robot = robot
        self.heard = b""
        self.moving = threading.Event()
        write = self.robot.write

        def listen_in(data: bytes) -> None:
            self.heard += data
            write(data)

        self.robot.write = listen_in
        self.robot.events = self._happened
        self.url = ""
        self._ready = threading.Event()
        self._thread = threading.Thread(target=asyncio.run, args=(self._serve(listen, speed),))
        self._thread.start()
        assert self._ready.wait(20.0)

    def _happened(self, action: Action) -> None:
        if "started" in action.what:
            self.moving.set()

    async def _serve(self, listen: str, speed: float) -> None:
        self._loop, self._stopped = asyncio.get_running_loop(), asyncio.Event()

        def ready(url: str) -> None:
            self.url = url
            self._ready.set()

        await serve(self.robot, listen, speed=speed, ready=ready, stopped=self._stopped)

    def end(self) -> None:
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._stopped.set)
            self._thread.join()


@pytest.fixture
def served() -> Iterator[Callable[..., Served]]:
    """Serve a simulated robot: ``served("pty", speed=1.0, **settings)``."""
    robots: list[Served] = []

    def make(listen: str = "pty", speed: float = 20.0, robot: Any = None, **settings: Any) -> Served:
        robots.append(Served(listen, speed, robot or SimulatedWalter(RobotSettings(**settings))))
        return robots[-1]

    yield make
    for one in robots:
        one.end()


# ---------------------------------------------------------------- the simulated robot


def test_the_plain_api() -> None:
    with turtlewire.connect("sim:walter") as robot:
        robot.forward(100)
        robot.right(90)
        robot.finish()
        assert robot.pose == Pose(0.0, 100.0, 90.0)
        assert robot.reported_pose() == robot.pose
        assert robot.ask(m.QueryPen()) == m.PenReply(1)
        assert robot.towards(0, 200) == 0.0
        robot.horn("high")
        robot.lamp(on=True)
        robot.wait(1.0)
        robot.clear_screen()
        assert robot.pose == Pose()
        assert robot.trace.strokes == []
        assert not robot.obstacles
        robot.clear_screen()  # at home already: it only starts a new sheet
        robot.arc(0, 10)
        assert robot.is_pen_down
        assert robot.statistics.corrections == 0
        assert robot.statistics.seconds > 1.0


def test_a_sheet_cleared_with_the_pen_up_stays_so() -> None:
    with connect() as robot:
        robot.pen_up()
        robot.forward(10)
        robot.clear_screen()
        robot.arc(90, 20)
        assert not robot.is_pen_down


def test_simulated_robots_need_no_asyncio() -> None:
    program = (
        "import sys, turtlewire\n"
        "with turtlewire.connect('sim:walter') as r: r.forward(10); r.home()\n"
        "print([n for n in ('asyncio', 'logging', 'serialx', 'rich', 'drawsvg') if n in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("[]\n", "")


@pytest.mark.parametrize(
    ("url", "attribute", "value"),
    [
        ("sim:walter?slip=0.02&seed=3", "slip", 0.02),
        ("sim:walter?slip=0.02&seed=3", "seed", 3),
        ("sim:walter?noise=1", "noise", 1.0),
        ("sim:walter?basic=1", "groups", frozenset()),
        ("sim:walter?basic=0", "groups", frozenset("CQHE")),
        ("sim:walter?groups=qh", "groups", frozenset("QH")),
        ("sim:walter?baud=0", "baud", 0),
        ("sim:walter?boot_s=1.5", "boot_s", 1.5),
        ("sim:walter?watchdog_s=2", "watchdog_s", 2.0),
        ("sim:walter?pen_s=0&speed=50&pace=real", "speed", 50),
    ],
)
def test_options_of_a_simulated_robot(url: str, attribute: str, value: object) -> None:
    assert getattr(simulated(target(url)).robot.settings, attribute) == value


def test_an_arena(tmp_path: Path) -> None:
    arena = tmp_path / "arena.toml"
    arena.write_text("[[wall]]\npoints = [[-500, 300], [500, 300]]\n")
    assert len(simulated(target(f"sim:walter?arena={arena}")).robot.settings.world.walls) == 1


@pytest.mark.parametrize(
    "url",
    [
        "sim:marvin",
        "sim:walter?colour=red",
        "sim:walter?seed=x",
        "sim:walter?slip=x",
        "sim:walter?slip=2",
        "sim:walter?groups=Z",
        "sim:walter?pace=0",
        "sim:walter?pace=nan",
        "sim:walter?pace=inf",
        "sim:walter?pace=fast",
        "sim:walter?arena=/nowhere.toml",
        "sim:walter?baud=10",
        "nonsense",
        "socket://x",
    ],
)
def test_urls_that_mean_nothing(url: str) -> None:
    with pytest.raises(UsageError):
        connect(url)


@pytest.mark.parametrize(("pace", "value"), [("max", None), ("real", 1.0), ("2.5", 2.5)])
def test_paces(pace: str, value: float | None) -> None:
    assert simulated(target(f"sim:walter?pace={pace}"))[1] == value


@pytest.mark.parametrize(
    "settings",
    [
        Settings(baud=49),
        Settings(speed=0),
        Settings(speed=256),
        Settings(boot_s=-1.0),
        Settings(boot_s=float("nan")),
        Settings(max_unfenced=15),
        Settings(groups=frozenset("X")),
        Settings(reply_timeout_s=0.0),
        Settings(heartbeat_s=0.0),
        Settings(mm_per_s_per_unit=float("inf")),
        Settings(deg_per_s_per_unit=float("nan")),
    ],
)
def test_settings_are_checked_before_a_port_is_opened(settings: Settings) -> None:
    for url in ("sim:walter", "/dev/ttyNOWHERE"):
        with pytest.raises(UsageError, match="the setting"):
            connect(url, settings)
    with pytest.raises(UsageError, match="the setting"):
        stop("/dev/ttyNOWHERE", settings)


HUGE: tuple[Any, ...] = (float("nan"), float("inf"), -float("inf"), 1e300, -1e7, 10**400, 10**5000)


@pytest.mark.parametrize("value", HUGE, ids=["nan", "inf", "-inf", "1e300", "-1e7", "10**400", "10**5000"])
@pytest.mark.parametrize(
    "command",
    [
        "forward",
        "back",
        "right",
        "left",
        "set_x",
        "set_y",
        "set_heading",
        "set_speed",
        "wait",
        "arc",
        "set_position",
    ],
)
def test_numbers_that_no_robot_can_do_are_refused_before_any_byte(command: str, value: Any) -> None:
    with connect() as robot:
        robot.finish()
        before, pose = robot.statistics.bytes_sent, robot.pose
        both = command in ("arc", "set_position")
        for arguments in [(value, 10.0), (10.0, value)] if both else [(value,)]:
            with pytest.raises(MessageError):
                getattr(robot, command)(*arguments)
        assert (robot.statistics.bytes_sent, robot.pose) == (before, pose)


@pytest.mark.parametrize("speed", [0, 256, -1, 1.5])
def test_speeds_that_are_none(speed: Any) -> None:
    with connect() as robot:
        before = robot.statistics.bytes_sent
        with pytest.raises(MessageError):
            robot.set_speed(speed)
        assert robot.statistics.bytes_sent == before
        robot.forward(10)
        robot.finish()
        assert robot.reported_pose().y_mm == 10.0


def test_a_basic_robot_has_no_horn_and_no_lamp_and_answers_nothing(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "turtlewire"), connect("sim:walter?basic=1", FAST) as robot:
        for use in (
            lambda: robot.horn("low"),
            lambda: robot.lamp(on=True),
            robot.reported_pose,
            lambda: robot.ask(m.QueryX()),
        ):
            with pytest.raises(NotSupportedError, match="sim:walter"):
                use()
        with pytest.raises(MessageError, match="no horn tone"):
            robot.horn("shrill")
        robot.forward(10)
        robot.finish()
        assert robot.trace.strokes
    assert "basic one" in caplog.text


# ---------------------------------------------------------------- one implementation, two ways to call it


def test_both_ways_have_the_same_names_and_parameters() -> None:
    def public(kind: type) -> dict[str, object]:
        return {name: getattr(kind, name) for name in dir(kind) if not name.startswith("_")}

    plain, asynchronous = public(Walter), public(AsyncWalter)
    assert plain.keys() == asynchronous.keys() - {"connect"}
    assert public(Turtle).keys() <= plain.keys()
    for name, function in plain.items():
        other = asynchronous[name]
        if isinstance(function, property):
            assert isinstance(other, property)
            continue
        assert callable(function)
        assert callable(other)
        assert inspect.signature(function).parameters == inspect.signature(other).parameters
        assert inspect.iscoroutinefunction(other) == (name != "towards")


def test_asynchronous_programs(served: Callable[..., Served]) -> None:
    async def main(url: str) -> None:
        async with await turtlewire.connect_async(url) as robot:
            await robot.forward(30)
            await robot.right(45)
            await robot.finish()
            assert await robot.reported_pose() == robot.pose == Pose(0.0, 30.0, 45.0)

    asyncio.run(main("sim:walter"))
    port = served(speed=100.0)
    asyncio.run(main(port.url))
    assert port.heard.endswith(m.EMERGENCY_STOP)


def test_a_stop_from_another_task(served: Callable[..., Served]) -> None:
    port = served(speed=1.0)

    async def main() -> None:
        async with await turtlewire.connect_async(port.url) as robot:

            async def drive() -> None:
                for _ in range(50):
                    await robot.forward(1000)

            driving = asyncio.create_task(drive())
            await asyncio.to_thread(port.moving.wait, 20.0)
            await robot.stop()
            with pytest.raises(StoppedError):
                await driving
            assert (await robot.reported_pose()).y_mm < 1000.0

    asyncio.run(main())


# ---------------------------------------------------------------- real ports


@pytest.mark.parametrize("listen", ["pty", "socket://127.0.0.1:0"])
def test_a_drawing_over_a_real_port(served: Callable[..., Served], listen: str) -> None:
    port = served(listen, speed=200.0)
    with connect(port.url, Settings(heartbeat_s=0.5)) as robot:
        for _ in range(4):
            robot.forward(40)
            robot.right(90)
        robot.finish()
        assert robot.reported_pose() == robot.pose == Pose(0.0, 0.0, 0.0)
    port.end()
    assert port.heard.endswith(m.EMERGENCY_STOP)
    assert port.robot.trace.strokes[-1].points[-1] == pytest.approx((0.0, 0.0))
    with pytest.raises(LinkClosedError):
        robot.forward(1)
    robot.close()


def test_a_stop_from_another_thread_while_this_one_waits(served: Callable[..., Served]) -> None:
    port = served(speed=1.0)
    with connect(port.url) as robot:

        def stop_it() -> None:
            port.moving.wait(20.0)
            robot.stop()

        stopper = threading.Thread(target=stop_it)
        stopper.start()

        def drive() -> None:
            for _ in range(50):
                robot.forward(1000)

        with pytest.raises(StoppedError):
            drive()
        stopper.join()
        assert robot.reported_pose().y_mm < 1000.0


def test_a_close_from_another_thread_while_this_one_waits(served: Callable[..., Served]) -> None:
    port = served(speed=1.0)
    robot = connect(port.url)
    robot.forward(5000)

    def close_it() -> None:
        port.moving.wait(20.0)
        robot.close(finish=False)

    closer = threading.Thread(target=close_it)
    closer.start()
    with pytest.raises((StoppedError, LinkClosedError)):
        robot.finish()
    closer.join()
    port.end()
    assert port.heard.endswith(m.EMERGENCY_STOP)


def test_ctrl_c_while_the_main_thread_waits(served: Callable[..., Served]) -> None:
    port = served(speed=1.0)

    def interrupt() -> None:
        port.moving.wait(20.0)
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)

    def drive() -> None:
        with connect(port.url) as robot:
            robot.forward(5000)
            robot.finish()

    interrupter = threading.Thread(target=interrupt)
    interrupter.start()
    with pytest.raises(KeyboardInterrupt):
        drive()
    interrupter.join()
    port.end()
    assert port.heard.endswith(m.EMERGENCY_STOP)
    assert port.robot.pose.y_mm < 5000.0


@pytest.mark.parametrize(
    "way_out", ["del robot", "sys.exit(0)", "os.kill(os.getpid(), signal.SIGINT)", "1 / 0"]
)
def test_every_way_out_of_a_process_stops_the_robot(served: Callable[..., Served], way_out: str) -> None:
    port = served(speed=1.0)
    program = (
        "import os, signal, sys, turtlewire\n"
        f"robot = turtlewire.connect({port.url!r})\n"
        "robot.forward(5000)\n"
        f"{way_out}\n"
        "print('still there', flush=True)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert ("still there" in done.stdout) == (way_out == "del robot")
    assert "Exception ignored" not in done.stderr
    port.end()
    assert port.heard.endswith(m.EMERGENCY_STOP)
    assert port.robot.pose.y_mm < 5000.0


def test_the_last_reference_may_be_lost_in_the_very_thread_of_the_link(served: Callable[..., Served]) -> None:
    port = served(speed=1.0)
    robot = connect(port.url)
    runner: Any = robot._runner
    assert not runner.is_here
    box, ended = [robot], threading.Event()
    before = set(threading.enumerate())
    del robot

    def lose() -> None:
        box.clear()
        gc.collect()
        ended.set()

    runner._loop.call_soon_threadsafe(lose)
    assert ended.wait(20.0)
    for thread in set(threading.enumerate()) - before:
        thread.join(20.0)
    assert runner._loop.is_closed()
    port.end()
    assert port.heard.endswith(m.EMERGENCY_STOP)


def test_a_link_that_ends_in_the_middle(served: Callable[..., Served]) -> None:
    port = served("socket://127.0.0.1:0", speed=1.0)
    robot = connect(port.url)
    robot.forward(5000)
    port.end()
    for use in (robot.finish, lambda: robot.forward(1), robot.reported_pose):
        with pytest.raises(LinkLostError):
            use()
    robot.stop()
    assert robot.link_state == "reconnecting"
    robot.close()
    robot.close()
    with pytest.raises(LinkClosedError):
        robot.finish()


def test_a_port_that_is_not_there_leaves_nothing_behind() -> None:
    threads = threading.active_count()
    with pytest.raises(PortNotFoundError):
        connect("/dev/ttyNOWHERE")
    assert threading.active_count() == threads


def test_a_robot_that_must_answer_and_does_not_leaves_the_port_free() -> None:
    robots: list[int] = []
    settings = Settings(boot_s=0.0, reply_timeout_s=0.01, require_replies=True, baud=115200)
    threads = threading.active_count()
    with pytest.raises(NoReplyError):
        connect("pty", settings, announce=lambda path: robots.append(os.open(path, os.O_RDWR | os.O_NOCTTY)))
    assert threading.active_count() == threads
    os.close(robots[0])


def test_stop_by_itself(served: Callable[..., Served]) -> None:
    port = served(speed=1.0)
    host = os.open(port.url, os.O_RDWR | os.O_NOCTTY)
    os.write(host, b"F\xff\x00\r")
    assert port.moving.wait(20.0)
    os.close(host)
    stopped = stop(port.url)
    assert stopped.is_confirmed
    assert stopped.pose is not None
    assert port.heard.startswith(b"F\xff\x00\r" + m.EMERGENCY_STOP)
    basic = served(speed=1.0, groups=frozenset())
    assert stop(basic.url, Settings(boot_s=0.0, reply_timeout_s=0.05)) == (False, None)


def test_the_baud_rate_of_the_url_counts(served: Callable[..., Served]) -> None:
    port = served(speed=50.0)
    with connect(f"serial://{port.url}?baud=115200") as robot:
        assert robot._robot._wire.settings.baud == 115200


# ---------------------------------------------------------------- every robot, every link


KINDS: dict[str, tuple[Any, Any, Callable[[], Any]]] = {
    "walter": (Walter, AsyncWalter, lambda: SimulatedWalter(RobotSettings())),
    "simple": (Car, AsyncCar, lambda: SimulatedCar(CarRobotSettings())),
    "frame": (TwoEngine, AsyncTwoEngine, lambda: SimulatedFrameRobot(FrameRobotSettings())),
}


# A machine with much to do may take longer for an answer than a car does.
PATIENT = {"walter": "&reply_timeout_s=20", "simple": "&reply_delay_s=0.4", "frame": ""}


@pytest.mark.parametrize("protocol", KINDS)
@pytest.mark.parametrize("listen", ["pty", "socket://127.0.0.1:0"])
def test_every_robot_over_every_port(served: Callable[..., Served], protocol: str, listen: str) -> None:
    kind, asynchronous, made = KINDS[protocol]
    port = served(listen, speed=20.0, robot=made())
    url = f"{port.url}?protocol={protocol}&boot_s=0&speed=255{PATIENT[protocol]}"
    with connect(f"{url}&faults=split:1") as robot:
        assert type(robot) is kind
        robot.forward(20)
        robot.right(90)
        robot.finish()
        assert robot.pose == Pose(0.0, 20.0, 90.0)
    assert len(port.heard) > 20

    async def main() -> None:
        async with await turtlewire.connect_async(url) as robot:
            assert type(robot) is asynchronous
            assert robot.pose == Pose()

    asyncio.run(main())
    port.end()
    assert not port.robot.is_moving


@pytest.mark.parametrize("protocol", KINDS)
def test_every_simulated_robot(protocol: str) -> None:
    seen: list[Link] = []

    def see(link: Link) -> Link:
        seen.append(link)
        return link

    with connect(f"sim:{protocol}", wrap=see) as robot:
        assert type(robot) is KINDS[protocol][0]
        robot.forward(-20)
        robot.finish()
        assert robot.pose == Pose(0.0, -20.0, 0.0)
    (link,) = seen
    assert isinstance(link, MemoryLink)
    with connect(f"sim:{protocol}?faults=lose:0", wrap=see):
        assert isinstance(seen[1], FaultyLink)
        assert seen[1].url == f"sim:{protocol}?faults=lose:0"


def test_settings_say_which_robot_it_is(served: Callable[..., Served]) -> None:
    port = served(speed=20.0, robot=KINDS["simple"][2]())
    with connect(port.url, CarSettings(reply_delay_s=0.4)) as car:
        assert car.turning_radius_mm > 0.0
    with pytest.raises(UsageError, match="sim:frame speaks frame, but the settings are"):
        connect("sim:frame", CarSettings())
    with connect("sim:frame", TwoEngineSettings(halts=1)) as robot:
        robot.engine(0, 50)


def test_options_of_a_simulated_robot_and_of_its_driver() -> None:
    end, pace, found = simulated(target("sim:simple?dead_pwm=60&window=3&pace=2&boot_s=1&speed=9&slip=0.5"))
    assert (end.settings.dead_pwm, end.settings.boot_s, end.settings.slip, pace) == (60, 1.0, 0.5, 2.0)
    assert found.overrides == {"window": 3, "speed": 9}
    end, _, found = simulated(target("sim:frame?dialect=telemetry&pen_servo=0&telemetry_s=0.5&halts=3"))
    assert (end.settings.dialect.name, end.settings.telemetry_s) == ("telemetry", 0.5)
    assert end.settings.baud == end.settings.dialect.baud
    assert found.overrides == {"dialect": end.settings.dialect, "halts": 3}
    assert simulated(target("sim:frame?dialect=telemetry&baud=300")).robot.settings.baud == 300
    # What was set otherwise counts more than the URL.
    chosen = target("sim:simple?window=3")._replace(overrides={"window": 5})
    assert simulated(chosen)[2].overrides == {"window": 5}


@pytest.mark.parametrize("url", ["sim:simple?groups=C", "sim:frame?basic=1", "sim:walter?dialect=0.1"])
def test_options_of_another_robot(url: str) -> None:
    with pytest.raises(UsageError, match="a simulated robot and its driver have pace, faults, "):
        connect(url)


def test_by_name(served: Callable[..., Served], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    port = served(speed=20.0, robot=KINDS["simple"][2]())
    (tmp_path / "turtlewire").mkdir()
    (tmp_path / "turtlewire" / "robots.toml").write_text(
        f'[herbie]\nport = "{port.url}"\nprotocol = "simple"\nreply_delay_s = 0.4\n', "utf-8"
    )
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    with turtlewire.connect("herbie") as car:
        car.steer(255)
    assert b"R255" in port.heard
    assert stop("herbie") == (True, None)


def test_a_stop_is_no_lesson_about_noise(served: Callable[..., Served]) -> None:
    port = served(speed=20.0)
    assert stop(f"{port.url}?faults=lose:1").is_confirmed


def test_an_end_that_was_asked_for() -> None:
    def drive() -> None:
        with connect("sim:walter?faults=close:1") as robot:
            robot.forward(1000)
            robot.finish()

    with pytest.raises(LinkLostError, match="a fault that was asked for"):
        drive()


# ---------------------------------------------------------------- runners


def test_an_inline_runner_never_waits() -> None:
    with pytest.raises(RuntimeError, match="must never wait"):
        InlineRunner().run(asyncio.sleep(0))
    InlineRunner().close()
    assert not InlineRunner().is_here


def test_a_thread_runner_ends_what_still_runs() -> None:
    runner = ThreadRunner()
    started, cleaned = threading.Event(), threading.Event()

    async def wait_for_ever() -> None:
        started.set()
        try:
            await asyncio.Event().wait()
        finally:
            cleaned.set()

    async def answer() -> int:
        return 42

    def close_it() -> None:
        started.wait(20.0)
        runner.close()

    closer = threading.Thread(target=close_it)
    closer.start()
    with pytest.raises(LinkClosedError):
        runner.run(wait_for_ever())
    closer.join()
    assert cleaned.is_set()
    runner.close()
    with pytest.raises(LinkClosedError, match="connect again"):
        runner.run(answer())
