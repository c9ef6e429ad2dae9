"""Real processes, real ptys, real sockets. Whoever waits waits for something, and only the deadline is in seconds."""

from __future__ import annotations

import errno
import json
import math
import os
import pty
import re
import select
import subprocess
import sys
import threading
import time
import tty
from typing import TYPE_CHECKING, Any, NamedTuple

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from .terminal import Terminal

DEADLINE_S = 40.0
COMMAND = [sys.executable, "-m", "turtlewire"]
# Fast enough for tests, slow enough that a long drive is still under way when a signal comes.
SPEED = "100"
# So many motions after one another are more than can be under way unconfirmed (48 bytes, W9).
CONFIRMED = 24
# For robots that will not answer: how long to wait for that.
IMPATIENT = ["--set", "boot_s=0", "--set", "reply_timeout_s=0.1"]
# W8, as a robot sees it.
EMERGENCY_STOP = b"\0\0\0\0\0\r2\r "


def wait_until(condition: Callable[[], bool], what: str) -> None:
    """Wait for a condition, looking again and again."""
    deadline = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < deadline, f"waited in vain for {what}"
        time.sleep(0.005)


class Ended(NamedTuple):
    """What became of a process."""

    code: int
    out: str
    err: str

    def check_said(self, *pieces: str) -> None:
        """No traceback, nothing of asyncio's worries, and the message says this."""
        for unwanted in ("Traceback", "destroyed", "never awaited", "Exception ignored", "bug in turtlewire"):
            assert unwanted not in self.err
        for piece in pieces:
            assert piece in self.err, self.err


class Process:
    """A turtlewire command under way, both its outputs being read."""

    def __init__(self, arguments: list[str], folder: Path) -> None:
        environment = {**os.environ, "PYTHONWARNINGS": "error", "PYTHONUNBUFFERED": ""}
        self.popen = subprocess.Popen(
            [*COMMAND, *arguments],
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
        )
        self._text = {"out": "", "err": ""}
        self._readers = [self._follow("out"), self._follow("err")]

    def _follow(self, name: str) -> threading.Thread:
        stream = self.popen.stdout if name == "out" else self.popen.stderr
        assert stream is not None

        def follow() -> None:
            for line in stream:
                self._text[name] += line

        thread = threading.Thread(target=follow, daemon=True)
        thread.start()
        return thread

    @property
    def out(self) -> str:
        return self._text["out"]

    @property
    def err(self) -> str:
        return self._text["err"]

    def wait_for_out(self, text: str) -> None:
        self._wait(lambda: text in self.out, text)

    def wait_for_err(self, text: str) -> None:
        self._wait(lambda: text in self.err, text)

    def _wait(self, condition: Callable[[], bool], what: str) -> None:
        wait_until(lambda: condition() or self.popen.poll() is not None, what)
        for reader in self._readers if self.popen.poll() is not None else []:
            reader.join(DEADLINE_S)
        assert condition(), f"it ended without {what!r}: {self.out}{self.err}"

    def signal(self, number: int) -> None:
        self.popen.send_signal(number)

    def end(self) -> Ended:
        code = self.popen.wait(DEADLINE_S)
        for reader in self._readers:
            reader.join(DEADLINE_S)
        return Ended(code, self.out, self.err)

    def clean_up(self) -> None:
        self.popen.kill()
        self.popen.wait()
        for reader in self._readers:
            reader.join()
        for stream in (self.popen.stdout, self.popen.stderr):
            assert stream is not None
            stream.close()


class Simulator(Process):
    """``turtlewire simulate ROBOT --verbose``."""

    @property
    def url(self) -> str:
        self._wait(lambda: "\n" in self.out, "a URL")
        return self.out.splitlines()[0]

    def json_lines(self, count: int) -> list[dict[str, Any]]:
        """What ``--json`` said of so many robots."""
        self._wait(lambda: self.out.count("\n") >= count, f"{count} lines")
        return [json.loads(line) for line in self.out.splitlines()[:count]]

    @property
    def actions(self) -> list[str]:
        """What the robot has done, without the times."""
        return re.findall(r"^ *\d+\.\d{3} s  (.*)\n", self.err, re.MULTILINE)

    def wait_for_action(self, start: str) -> None:
        self._wait(lambda: any(action.startswith(start) for action in self.actions), start)

    def wait_for_motions(self, count: int) -> None:
        """Until so many motions have ended."""
        self._wait(
            lambda: sum(action.startswith("ended") for action in self.actions) >= count, f"{count} motions"
        )

    def wait_until_still(self) -> None:
        """Until every motion that began has ended."""

        def is_still() -> bool:
            begun = sum(action.startswith("started") for action in self.actions)
            ended = sum(action.startswith(("ended", "stopped", "refused")) for action in self.actions)
            return begun == ended

        self._wait(is_still, "the robot to stand still")


class Cli:
    """Runs turtlewire, in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.processes: list[Process] = []

    def start(self, *arguments: str) -> Process:
        process = Process([*arguments], self.folder)
        self.processes.append(process)
        return process

    def __call__(self, *arguments: str) -> Ended:
        return self.start(*arguments).end()

    def simulate(self, *arguments: str, speed: str = SPEED, robot: str = "walter") -> Simulator:
        simulator = Simulator(
            ["simulate", *robot.split(), "--verbose", "--speed", speed, *arguments], self.folder
        )
        self.processes.append(simulator)
        return simulator

    def program(self, text: str, name: str = "program.logo") -> str:
        (self.folder / name).write_text(text, "utf-8")
        return name

    def clean_up(self) -> None:
        for process in self.processes:
            process.clean_up()

    def text(self, name: str) -> str:
        return (self.folder / name).read_text("utf-8")


@pytest.fixture
def cli(tmp_path: Path) -> Iterator[Cli]:
    cli = Cli(tmp_path)
    yield cli
    cli.clean_up()


class Wire:
    """A raw pty. Whoever opens ``path`` is the host; what it sends is kept, and ``answer`` may answer it."""

    def __init__(self, answer: Callable[[bytes], bytes]) -> None:
        self._near, self._far = pty.openpty()
        tty.setraw(self._far)
        self.path = os.ttyname(self._far)
        self.received = bytearray()
        self._answer = answer
        self._woken, self._wake = os.pipe()
        self._thread = threading.Thread(target=self._follow, daemon=True)
        self._thread.start()

    def _follow(self) -> None:
        while True:
            ready, _, _ = select.select([self._near, self._woken], [], [])
            if self._woken in ready:
                return
            try:
                data = os.read(self._near, 4096)
            except OSError as error:
                if error.errno == errno.EIO:
                    return
                raise
            self.received += data
            reply = self._answer(data)
            if reply:
                os.write(self._near, reply)

    def wait_for(self, data: bytes) -> None:
        wait_until(lambda: data in self.received, repr(data))

    def wait_for_end(self, data: bytes) -> None:
        wait_until(lambda: self.received.endswith(data), f"{data!r} at the end of {bytes(self.received)!r}")

    def close(self) -> None:
        os.write(self._wake, b"x")
        self._thread.join()
        for fd in (self._near, self._far, self._woken, self._wake):
            os.close(fd)


@pytest.fixture
def wire() -> Iterator[Callable[[Callable[[bytes], bytes]], Wire]]:
    wires: list[Wire] = []

    def make(answer: Callable[[bytes], bytes] = lambda _: b"") -> Wire:
        wires.append(Wire(answer))
        return wires[-1]

    yield make
    for each in wires:
        each.close()


@pytest.fixture
def terminal() -> Iterator[Callable[..., Terminal]]:
    """Makes terminals: see ``Terminal``."""
    from .terminal import Terminal

    terminals: list[Terminal] = []

    def make(columns: int, rows: int = 24, *, tells_releases: bool = False) -> Terminal:
        terminals.append(Terminal(columns, rows, tells_releases=tells_releases))
        return terminals[-1]

    yield make
    for each in terminals:
        each.close()


def points(svg: str) -> list[tuple[float, float]]:
    """The points of all ink in a picture, in pixels."""
    ink = re.search(r'<g id="ink".*?</g>|<g [^>]*id="ink"[^>]*>.*?</g>', svg, re.DOTALL)
    assert ink is not None
    return [(float(x), float(y)) for x, y in re.findall(r"(-?[\d.]+),(-?[\d.]+)", ink[0])]


def px_per_mm(svg: str) -> float:
    """The scale of a picture, as its scale bar says."""
    scale = re.search(r"<title>(\d+) (cm|mm|m)</title>\s*<path d=\"M([\d.]+),[^H]*H([\d.]+)", svg)
    assert scale is not None
    length_mm = int(scale[1]) * {"mm": 1, "cm": 10, "m": 1000}[scale[2]]
    return (float(scale[4]) - float(scale[3])) / length_mm


def check_same(svg: str, other: str, tolerance_mm: float = 1.0) -> None:
    """Every point of the ink of one picture is near to one of the other, and the other way round."""
    ink, wanted, scale = points(svg), points(other), px_per_mm(svg)
    assert len(wanted) >= 3
    assert abs(scale / px_per_mm(other) - 1.0) < 0.02
    for one, two in ((ink, wanted), (wanted, ink)):
        assert max(min(math.dist(p, q) for q in two) for p in one) < tolerance_mm * scale
