"""``turtlewire doctor`` of real processes at real ptys and sockets; robots with a rate mishear any other."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import threading
import tomllib
import tty
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.examination.probes import FLUSH, LOGO_PROBE, MILD_PROBE
from turtlewire.protocols.simple.robot import Robot as Car

from .conftest import COMMAND, DEADLINE_S, Cli, Wire, wait_until
from .terminal import clean_environment

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from .terminal import Terminal

FEW = ["--boot-s", "0", "--baud", "57600,19200,115200"]


@pytest.fixture(autouse=True)
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    return tmp_path / "turtlewire" / "robots.toml"


def examined(cli: Cli, *arguments: str) -> tuple[int, dict[str, Any]]:
    ended = cli("doctor", *arguments, "--json")
    ended.check_said()
    told: dict[str, Any] = json.loads(ended.out)
    return ended.code, told


# ---------------------------------------------------------------- found


@pytest.mark.parametrize(
    ("robot", "baud", "listen"),
    [
        ("simple", 19200, "pty"),
        ("walter", 115200, "pty"),
        ("walter", None, "socket://127.0.0.1:0"),
    ],
)
def test_a_robot_at_its_rate(cli: Cli, file: Path, robot: str, baud: int | None, listen: str) -> None:
    rate = ["--baud", str(baud)] if baud else []
    simulator = cli.simulate("--listen", listen, *rate, robot=robot, speed="1")
    few = FEW if baud else FEW[:2]  # a socket has no rate
    code, told = examined(cli, simulator.url, "--name", "elsie", "--write", *few)
    assert (code, told["outcome"]) == (0, "found"), told
    findings = told["findings"]
    assert (findings["protocol"], findings["baud"]) == (robot, baud)
    assert findings["round_trip"]["median_s"] > 0.0
    entry = {"port": simulator.url, "protocol": robot} | ({"baud": baud} if baud else {})
    written = tomllib.loads(file.read_text("utf-8"))
    written["elsie"].pop("reply_delay_s", None)  # a busy machine has slow robots
    assert written == {"elsie": entry}
    assert set(simulator.actions) <= {"stop"}
    # And so it can be driven.
    ended = cli("run", cli.program("FD 1"), "--robot", "elsie", "--set", "boot_s=0")
    assert ended.code == 0, ended.err


def test_a_robot_that_talks(cli: Cli, file: Path) -> None:
    simulator = cli.simulate("--baud", "19200", robot="frame?dialect=telemetry", speed="1")
    code, told = examined(cli, simulator.url, "--name", "dot", "--write", *FEW)
    assert (code, told["outcome"]) == (0, "found"), told
    findings = told["findings"]
    assert (findings["protocol"], findings["baud"]) == ("frame", 19200)
    assert findings["facts"]["dialect"] == "telemetry"
    entry = {"port": simulator.url, "protocol": "frame", "baud": 19200, "dialect": "telemetry"}
    assert tomllib.loads(file.read_text("utf-8")) == {"dot": entry}


def test_a_robot_that_boots(cli: Cli) -> None:
    simulator = cli.simulate("--baud", "9600", "--boot-s", "2", robot="simple", speed="1")
    code, told = examined(cli, simulator.url, "--boot-s", "20")
    assert code == 0
    assert told["findings"]["protocol"] == "simple"
    # It booted while the doctor started, too; the others it never gets to.
    assert [at["baud"] for at in told["findings"]["rates"]] == [9600]


def test_what_people_are_told(cli: Cli, file: Path) -> None:
    simulator = cli.simulate("--baud", "19200", robot="walter", speed="1")
    ended = cli(
        "doctor", simulator.url, "--name", "elsie", "--write", "--boot-s", "0", "--baud", "9600,19200"
    )
    assert ended.code == 0
    lines = ended.out.splitlines()
    assert lines[0] == "found: walter at 19200 baud (certain)"
    assert lines[-2:] == ["next:", "  turtlewire run examples/rose.logo --robot elsie"]
    ended.check_said(
        f"examining {simulator.url}: nothing that is sent can move a robot\n",
        "     9600 baud  silence\n",
        "    19200 baud  walter\n",
        f"written to {file}\n",
    )
    # From now on it is tried at this rate first.
    for port in ("elsie", f"serial://{simulator.url}?baud=19200"):
        code, told = examined(cli, port)
        assert code == 0
        assert [at["baud"] for at in told["findings"]["rates"]] == [19200]


# ---------------------------------------------------------------- not found


def test_silence_and_nothing_but_proven_bytes(cli: Cli, wire: Callable[..., Wire]) -> None:
    robot = wire()
    bauds = (115200, 250000, 9600)
    ended = cli("doctor", robot.path, "--boot-s", "0", "--baud", ",".join(map(str, bauds)))
    assert (ended.code, ended.out) == (3, "")
    ended.check_said(f"no robot was found at {robot.path}", "--protocol frame", "--protocol walter")
    assert len([line for line in ended.err.splitlines() if line.endswith(" baud  silence")]) == len(bauds)
    assert bytes(robot.received) == FLUSH + LOGO_PROBE + FLUSH + MILD_PROBE + FLUSH + LOGO_PROBE


@pytest.mark.parametrize(("robot", "word"), [("frame", "frame"), ("walter", "walter")])
def test_a_robot_that_never_answers_is_taken_at_ones_word(
    cli: Cli, file: Path, robot: str, word: str
) -> None:
    options = ["--basic"] if robot == "walter" else []
    simulator = cli.simulate("--baud", "57600", *options, robot=robot, speed="1")
    rates = ["--boot-s", "0", "--baud", "57600"]
    ended = cli("doctor", simulator.url, *rates)
    assert ended.code == 3
    ended = cli("doctor", simulator.url, "--protocol", word, "--name", "dot", "--write", *rates)
    assert ended.code == 0
    assert ended.out.startswith(f"taken at your word: {word} at 57600 baud; nothing has confirmed it")
    entry = {"port": simulator.url, "protocol": word, "baud": 57600}
    assert tomllib.loads(file.read_text("utf-8")) == {"dot": entry}
    assert simulator.actions == []


@pytest.fixture
def talking() -> Iterator[Callable[[bytes], str]]:
    """Makes ports where something says the same again and again."""
    over = threading.Event()
    threads: list[threading.Thread] = []
    descriptors: list[int] = []

    def make(text: bytes) -> str:
        near, far = pty.openpty()
        tty.setraw(far)
        os.set_blocking(near, False)

        def talk() -> None:
            while not over.wait(0.05):
                try:
                    os.write(near, text)
                except BlockingIOError:  # nobody listens
                    continue

        threads.append(threading.Thread(target=talk, daemon=True))
        threads[-1].start()
        descriptors.extend((near, far))
        return os.ttyname(far)

    yield make
    over.set()
    for thread in threads:
        thread.join(DEADLINE_S)
    for descriptor in descriptors:
        os.close(descriptor)


def test_something_that_writes_text(cli: Cli, talking: Callable[[bytes], str]) -> None:
    path = talking(b"temperature 21.5 degrees\r\n")
    ended = cli("doctor", path, *FEW)
    assert ended.code == 3
    ended.check_said(f"no robot was found at {path}: something writes text at 57600 baud: 'temperature 21.5")


def test_a_host(cli: Cli, talking: Callable[[bytes], str]) -> None:
    ended = cli("doctor", talking(b"F\x00\xc8\rR\x00\x5a\rQH\rB\x00\x07\rPU\rQX\r"), *FEW)
    assert ended.code == 3
    ended.check_said("is a host that speaks walter, and no robot")


# ---------------------------------------------------------------- trouble at the port


def test_a_port_in_use(cli: Cli, wire: Callable[..., Wire]) -> None:
    robot = wire()
    holder = cli.start("identify", robot.path, "--seconds", "1e9")
    holder.wait_for_err("listening at")
    ended = cli("doctor", robot.path)
    assert ended.code == 3
    ended.check_said("is in use by another program")
    assert not robot.received


def test_a_port_that_vanishes_midway(cli: Cli) -> None:
    simulator = cli.simulate("--baud", "9600", "--basic", speed="1")
    process = cli.start("doctor", simulator.url, "--boot-s", "100")
    process.wait_for_err("examining")
    simulator.signal(signal.SIGKILL)
    ended = process.end()
    assert ended.code == 3
    ended.check_said(f"the link to {simulator.url} ended")
    assert ended.out == ""


# ---------------------------------------------------------------- every way out


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_before_anything_is_known(
    cli: Cli, wire: Callable[..., Wire], number: signal.Signals
) -> None:
    robot = wire()
    process = cli.start("doctor", robot.path, "--boot-s", "1000", "--name", "elsie", "--write")
    wait_until(lambda: len(robot.received) > 3, "the first bytes")
    process.signal(number)
    ended = process.end()
    assert (ended.code, ended.out) == (130, "")
    ended.check_said(f"interrupted ({number.name})")
    assert (FLUSH + LOGO_PROBE).startswith(bytes(robot.received[: len(FLUSH + LOGO_PROBE)]))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_when_it_is_known_how_to_stop_the_robot(
    cli: Cli, file: Path, wire: Callable[..., Wire], number: signal.Signals
) -> None:
    """A car that is put out of action by the first stop: what the doctor sends last is the stop."""
    car, heard, stopped = Car(), bytearray(), threading.Event()

    def answer(data: bytes) -> bytes:
        heard.extend(data)
        replies = b"" if stopped.is_set() else car.receive_data(data).replies
        if b"S000000" in heard and not stopped.is_set():
            stopped.set()
            process.signal(number)
            return b""
        return replies

    robot = wire(answer)
    process = cli.start("doctor", robot.path, "--json", "--name", "elsie", "--write")
    ended = process.end()
    assert ended.code == 130
    told = json.loads(ended.out)
    assert (told["outcome"], told["exit_code"], told["written"]) == ("interrupted", 130, [])
    ended.check_said()
    robot.wait_for_end(b"S" * 14)
    assert not file.exists()


# ---------------------------------------------------------------- asked at a terminal


@pytest.mark.parametrize(
    ("answer", "name"), [("elsie\r", "elsie"), ("\r", ""), ("a b\r", "")], ids=["name", "none", "no name"]
)
def test_asked_at_a_terminal(
    tmp_path: Path, file: Path, terminal: Callable[..., Terminal], answer: str, name: str
) -> None:
    screen = terminal(120)
    process = subprocess.Popen(
        [*COMMAND, "doctor", "sim:walter"],
        cwd=tmp_path,
        env=clean_environment() | {"XDG_CONFIG_HOME": str(tmp_path)},
        stdin=screen.far,
        stdout=screen.far,
        stderr=screen.far,
    )
    screen.wait_for("a name, to write it to")
    assert "[NAME]" in screen.shown
    screen.press(answer)
    code = process.wait(DEADLINE_S)
    assert code == (2 if answer == "a b\r" else 0)
    if name:
        assert tomllib.loads(file.read_text("utf-8"))[name] == {"port": "sim:walter"}
        screen.wait_for(f"--robot {name}")
    else:
        assert not file.exists()


@pytest.mark.parametrize(
    ("answer", "is_written"), [("y\r", True), ("n\r", False), ("\x04", False), ("", False)]
)
def test_asked_whether_to_write(
    tmp_path: Path, file: Path, terminal: Callable[..., Terminal], answer: str, is_written: bool
) -> None:
    screen = terminal(120)
    process = subprocess.Popen(
        [*COMMAND, "doctor", "sim:walter", "--name", "elsie"],
        cwd=tmp_path,
        env=clean_environment() | {"XDG_CONFIG_HOME": str(tmp_path)},
        stdin=screen.far,
        stdout=screen.far,
        stderr=screen.far,
    )
    screen.wait_for("[y/N]")
    if answer:
        screen.press(answer)
    else:
        process.send_signal(signal.SIGINT)
    assert process.wait(DEADLINE_S) == (0 if answer else 130)
    assert file.exists() == is_written
