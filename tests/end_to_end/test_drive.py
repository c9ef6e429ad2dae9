"""``turtlewire drive`` on a real terminal, and a robot in another process: keys in, motion and a picture out."""

from __future__ import annotations

import re
import signal
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest

from .conftest import DEADLINE_S, Cli, Simulator, wait_until

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Callable, Iterator

    from .terminal import Terminal

MakeTerminal = "Callable[..., Terminal]"
ROBOTS = ("walter", "simple", "frame")
# Keys count longer than a busy machine may be late with the next one, where a test is not about that.
PATIENT = ["--hold-ms", "2000", "--first-ms", "2000"]
UP, DOWN, LEFT, RIGHT, ESCAPE, CTRL_C = "\x1b[A", "\x1b[B", "\x1b[D", "\x1b[C", "\x1b", "\x03"


class Drive(NamedTuple):
    """A dashboard at work."""

    screen: Terminal
    process: subprocess.Popen[bytes]
    simulator: Simulator

    @property
    def y_mm(self) -> float:
        found = re.search(r"\by +(-?[\d.]+) mm", self.screen.shown)
        return float(found[1]) if found else 0.0

    def speeds(self) -> list[int]:
        """What the motors of a car or a two-engine robot were told, in order; WALTER's starts and ends."""
        words = {"started": 1, "stopped": 0, "ended": 0}
        speeds: list[int] = []
        for action in self.simulator.actions:
            name, _, rest = action.partition(" ")
            if name in words:
                speeds.append(words[name])
            elif name in ("drive_forward", "drive_backward", "engine_forward", "engine_backward"):
                speeds.append(int(rest.rpartition("speed=")[2]))
            elif name == "stop":
                speeds.append(0)
        return speeds

    def wait_until_moving(self) -> None:
        wait_until(lambda: self.speeds()[-1:] not in ([], [0]), f"motion: {self.simulator.actions}")

    def wait_until_standing(self) -> None:
        def stands() -> bool:
            speeds = self.speeds()
            return 0 in speeds and not any(speeds[-2:] if self.has_two else speeds[-1:])

        wait_until(stands, f"a stop: {self.simulator.actions}")

    @property
    def has_two(self) -> bool:
        return "engine_forward" in "".join(self.simulator.actions)

    def ended(self) -> int:
        return self.process.wait(DEADLINE_S)


@pytest.fixture
def drive(cli: Cli, terminal: Callable[..., Terminal], tmp_path: Path) -> Iterator[Callable[..., Drive]]:
    """Drive a simulated robot of another process on a new terminal, with so many columns and rows."""
    drives: list[Drive] = []

    def start(
        robot: str = "walter",
        *options: str,
        size: tuple[int, int] = (80, 24),
        simulate: tuple[str, ...] = (),
        tells_releases: bool = False,
        environment: dict[str, str] | None = None,
        nohup: bool = False,
    ) -> Drive:
        simulator = cli.simulate(*simulate, robot=robot, speed="1")
        screen = terminal(*size, tells_releases=tells_releases)
        arguments = ["drive", "--robot", robot, "--port", simulator.url, "--set", "boot_s=0.2", *options]
        process = screen.run(arguments, tmp_path, environment, nohup=nohup)
        drives.append(Drive(screen, process, simulator))
        screen.wait_for("connected")
        screen.wait_for("Space")
        return drives[-1]

    yield start
    for each in drives:
        each.process.kill()
        each.process.wait()


@pytest.mark.parametrize("robot", ROBOTS)
def test_it_drives_while_a_key_is_held(drive: Callable[..., Drive], robot: str) -> None:
    driving = drive(robot, "--hold-ms", "1000")
    screen = driving.screen
    with screen.holding(UP):
        driving.wait_until_moving()
        screen.wait_for("▲ ahead")
        wait_until(lambda: driving.y_mm > 20.0, "progress on the screen")
    # Nothing tells that the key was released: no more repetitions come.
    driving.wait_until_standing()
    screen.wait_for("■ stop")
    screen.wait_for("speed           0 mm/s")
    for key, stop in ((DOWN, " "), ("w" if robot != "walter" else "a", ESCAPE)):
        with screen.holding(key) as sent:
            driving.wait_until_moving()
            screen.press(stop)
            driving.wait_until_standing()
            stood, before = len(driving.speeds()), len(sent)
            wait_until(lambda: len(sent) > before + 10, "more repetitions")  # noqa: B023 - waited for here
            screen.wait_for("■ stop")
        assert not any(driving.speeds()[stood:])
    screen.press("q")
    assert driving.ended() == 0
    assert re.search(r"The robot was stopped, after 0\.\d\d m in", screen.text)
    assert "Traceback" not in screen.text


@pytest.mark.parametrize(
    ("robot", "way"),
    [
        ("walter", "Ctrl-C"),
        ("walter", "the window is closed"),
        ("simple", "the window is closed"),
        ("simple", "SIGTERM"),
        ("frame", "SIGHUP"),
        ("frame", "the window is closed, and no signal tells"),
        ("frame", "q"),
    ],
)
def test_every_way_out_stops_the_robot(drive: Callable[..., Drive], robot: str, way: str) -> None:
    driving = drive(robot, "--latched", nohup=way.endswith("no signal tells"))
    driving.screen.press(UP)
    driving.wait_until_moving()
    driving.screen.wait_for("(latched)")
    if way == "q":
        driving.screen.press("q")
    elif way == "Ctrl-C":
        driving.screen.press(CTRL_C)
    elif way.startswith("the window is closed"):
        driving.screen.hang_up()
    else:
        driving.process.send_signal(getattr(signal, way))
    assert driving.ended() == (0 if way == "q" else 130)
    driving.wait_until_standing()
    if way in ("SIGTERM", "SIGHUP"):
        assert f"interrupted ({way})" in driving.screen.text
    assert "Traceback" not in driving.screen.text


def test_a_terminal_that_tells_releases(drive: Callable[..., Drive]) -> None:
    """The kitty keyboard protocol: a key counts as long as the terminal is there, and until it is released."""
    driving = drive("frame", "--first-ms", "300", tells_releases=True)
    screen = driving.screen
    screen.press("\x1b[119;;119u")  # w
    wait_until(lambda: driving.y_mm > 150.0, "a longer way than a key counts that nothing is heard of")
    screen.press("\x1b[97;;97u")  # a
    screen.wait_for("▲ ahead ◀ left")
    screen.press("\x1b[97;1:2;97u\x1b[97;1:3u")
    screen.wait_for_match(r"▲ ahead +\n")
    screen.press("\x1b[119;1:3u")
    driving.wait_until_standing()
    screen.wait_for("■ stop")
    screen.press("\x1b[119;;119u")
    driving.wait_until_moving()
    screen.stall()  # and it answers no more
    driving.wait_until_standing()
    screen.go_on()
    screen.wait_for("■ stop")
    screen.press("\x1b[99;5u")  # Ctrl-C
    assert driving.ended() == 130


def test_a_terminal_that_takes_no_more_keeps_no_robot_moving(drive: Callable[..., Drive]) -> None:
    driving = drive("walter")
    screen = driving.screen
    with screen.holding("a"):
        driving.wait_until_moving()
        screen.stall()
    driving.wait_until_standing()
    screen.press("z")
    driving.simulator.wait_for_action("started start_backward")
    screen.press(" ")
    driving.wait_until_standing()
    screen.press("q")
    screen.go_on()  # it has something to say at the end
    assert driving.ended() == 0


def test_nobody_drives_while_the_program_is_suspended(drive: Callable[..., Drive]) -> None:
    driving = drive("walter", "--latched")
    state = Path(f"/proc/{driving.process.pid}/stat")
    driving.screen.press("a")
    driving.wait_until_moving()
    driving.process.send_signal(signal.SIGTSTP)
    wait_until(
        lambda: state.read_text("utf-8").rpartition(")")[2].split()[0] == "T", "the program to be stopped"
    )
    driving.wait_until_standing()
    driving.process.send_signal(signal.SIGCONT)
    driving.screen.wait_for("■ stop")
    driving.screen.press("z")
    driving.simulator.wait_for_action("started start_backward")


def test_the_keyboard_goes_elsewhere(drive: Callable[..., Drive]) -> None:
    driving = drive("simple", "--latched")
    driving.screen.press("w")
    driving.wait_until_moving()
    driving.screen.press("\x1b[O")
    driving.wait_until_standing()
    driving.screen.wait_for("■ stop")


def test_walter_and_its_own_keys(drive: Callable[..., Drive]) -> None:
    driving = drive("walter", "--latched")
    screen, simulator = driving.screen, driving.simulator
    screen.wait_for("A Z , . or arrows")
    screen.press("G200\r")
    screen.wait_for("set      200, of turns 100")
    screen.press("b2555\x7f\r")
    screen.wait_for("of turns 25")
    screen.press("9")
    screen.press("-")
    screen.wait_for("set      227, of turns 227")
    screen.press("g12" + ESCAPE)
    screen.press("s")
    simulator.wait_for_action("pen up")
    screen.wait_for_match(r"pen +up")
    screen.press("z")
    simulator.wait_for_action("started start_backward")
    screen.press("ddc")
    screen.wait_for("move_slower")
    screen.wait_for("set      228, of turns 227")
    screen.press(",")
    simulator.wait_for_action("started start_left")
    screen.press("x")
    simulator.wait_for_action("pen down")
    screen.press("l")  # a command of Logo control: the robot stops for it
    simulator.wait_for_action("lamp on")
    screen.wait_for_match(r"lights +on")
    driving.wait_until_standing()
    screen.press("h")
    simulator.wait_for_action("horn low")
    simulator.wait_for_action("horn off")
    # When it has stood for a moment it is asked where it is.
    screen.wait_for("as it says")


def test_lights_and_pen(drive: Callable[..., Drive]) -> None:
    car = drive("simple")
    car.screen.wait_for("W A S D or arrows")
    assert "pen" not in car.screen.shown
    car.screen.press("p")
    car.screen.wait_for("this robot has no pen")
    car.screen.press("L")
    car.simulator.wait_for_action("headlights left_upper=1 left_lower=1 right_upper=1 right_lower=1")
    car.screen.wait_for_match(r"lights +on")
    car.screen.press("q")
    assert car.ended() == 0
    robot = drive("frame", *PATIENT)
    robot.screen.press("p")
    robot.simulator.wait_for_action("pen up")
    robot.screen.wait_for_match(r"pen +up")
    with robot.screen.holding("w"):
        robot.wait_until_moving()


def test_w13_what_stands_in_the_way_is_seen_and_said(drive: Callable[..., Drive], tmp_path: Path) -> None:
    (tmp_path / "arena.toml").write_text("[[wall]]\npoints = [[-300, 150], [300, 150]]\n", "utf-8")
    driving = drive("walter", *PATIENT, simulate=("--arena", "arena.toml"))
    screen = driving.screen
    with screen.holding("a") as sent:
        screen.wait_for("! front limit: something is in the way at x 0, y 60 mm")
        screen.wait_for("drive it back")
        before = len(sent)
        wait_until(lambda: len(sent) > before + 10, "more repetitions")
    assert driving.speeds() == [1, 0]
    with screen.holding("z"):
        driving.wait_until_moving()


def test_a_link_that_is_lost(cli: Cli, terminal: Callable[..., Terminal], tmp_path: Path) -> None:
    simulator = cli.simulate("--listen", "socket://127.0.0.1:0", robot="simple", speed="1")
    url, screen = simulator.url, terminal(80)
    options = ["--latched", "--hold-ms", "50"]
    process = screen.run(["drive", "--robot", "simple", "--port", url, *options], tmp_path)
    try:
        screen.wait_for("● connected")
        screen.press("w")
        simulator.wait_for_action("drive_forward")
        screen.wait_for("▲ ahead")
        simulator.clean_up()
        screen.wait_for("LINK LOST, trying again")
        screen.press("w")
        simulator = cli.simulate("--listen", url, robot="simple", speed="1")
        screen.wait_for("press R to go on")
        screen.wait_for("■ stop")
        screen.press("w")
        assert not [action for action in simulator.actions if action.startswith("drive_forward speed=1")]
        screen.press("r")
        screen.wait_for("● connected")
        screen.press("w")
        simulator.wait_for_action("drive_forward speed=1")
        screen.press("q")
        assert process.wait(DEADLINE_S) == 0
    finally:
        process.kill()
        process.wait()


def test_a_link_that_ends(cli: Cli, terminal: Callable[..., Terminal], tmp_path: Path) -> None:
    simulator = cli.simulate("--listen", "socket://127.0.0.1:0")
    screen = terminal(80)
    process = screen.run(["drive", "--port", simulator.url, "--set", "reconnect_s=0"], tmp_path)
    try:
        screen.wait_for("● connected")
        simulator.clean_up()
        screen.wait_for("NO LINK")
        screen.wait_for("If the robot still moves, switch it off")
        screen.press("q")
        assert process.wait(DEADLINE_S) == 3
        assert "turtlewire: the link to socket://" in screen.text
    finally:
        process.kill()
        process.wait()


def test_small_large_and_without_colours(drive: Callable[..., Drive]) -> None:
    driving = drive("walter", size=(40, 10), environment={"NO_COLOR": "1"})
    screen = driving.screen
    assert "3" not in re.findall(r"\x1b\[[\d;]*?\b([34])[0-7]\b[\d;]*m", screen.text)
    screen.wait_for("heading")
    screen.resize(120, 40)
    screen.wait_for("├───┤")
    screen.wait_for("set_speed speed=100")
    screen.resize(20, 5)
    screen.resize(80, 24)
    screen.wait_for("├───┤")
    screen.press("q")
    assert driving.ended() == 0


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        ([], 2, "drive needs a terminal for its keys and its picture"),
        (["--hold-ms", "0"], 2, "'0' is not a number of milliseconds from 50 to 5000"),
        (["--first-ms", "long"], 2, "'long' is not a number of milliseconds"),
        (["--port", "sim:walter?pace=max"], 2, "nobody can drive at pace=max"),
        (["--port", "sim:walter?wings=2"], 2, "unknown option 'wings'"),
        (["--faults", "gremlins"], 2, "'gremlins' means nothing"),
        (["--robot", "simple", "--set", "window=9"], 2, "window is 9"),
    ],
)
def test_wrong_usage(cli: Cli, arguments: list[str], code: int, message: str) -> None:
    ended = cli("drive", *arguments)
    assert ended.code == code
    ended.check_said(message)


def test_a_terminal_that_cannot_be_drawn_on_and_a_port_that_is_not(
    terminal: Callable[..., Terminal], tmp_path: Path
) -> None:
    screen = terminal(80)
    process = screen.run(["drive"], tmp_path, {"TERM": "dumb"})
    assert process.wait(DEADLINE_S) == 2
    screen.wait_for("drive needs a terminal that can be drawn on, and TERM says that this")
    process = screen.run(["drive", "--port", "/dev/nowhere"], tmp_path)
    assert process.wait(DEADLINE_S) == 3
    screen.wait_for("there is no port /dev/nowhere")
    assert "1049h" not in screen.text


def test_a_simulated_robot_of_its_own_in_real_time(terminal: Callable[..., Terminal], tmp_path: Path) -> None:
    (tmp_path / "arena.toml").write_text(
        "[start]\nheading_deg = 90\n[[disc]]\nx_mm=300\ny_mm=0\nradius_mm=50", "utf-8"
    )
    screen = terminal(100, 30)
    process = screen.run(["drive", "--port", "sim:walter?arena=arena.toml&pace=4", *PATIENT], tmp_path)
    try:
        screen.wait_for("simulated WALTER")
        with screen.holding("a"):
            # It looks to the right on the ground; in its own coordinates, whose y is ahead, the disc is ahead.
            screen.wait_for("front limit: something is in the way at x 0, y 160 mm")
        screen.wait_for_match(r"y +160\.0 mm")
        screen.press("q")
        assert process.wait(DEADLINE_S) == 0
    finally:
        process.kill()
        process.wait()
