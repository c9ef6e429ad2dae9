"""``turtlewire monitor`` between real programs, on ptys and sockets."""

from __future__ import annotations

import json
import os
import random
import re
import select
import signal
import socket
from typing import TYPE_CHECKING

import pytest

from tests.end_to_end.conftest import DEADLINE_S, EMERGENCY_STOP, Cli, Process, Wire, wait_until

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path


def url_of(process: Process, who: str) -> str:
    process.wait_for_err(f"the {who}'s port is ")
    wait_until(lambda: re.search(rf"the {who}'s port is \S+\n", process.err) is not None, "a whole line")
    found = re.search(rf"the {who}'s port is (\S+)\n", process.err)
    assert found is not None
    return found[1]


class Port:
    """A raw end of a pty or socket: what a program would hold."""

    def __init__(self, url: str) -> None:
        self.socket: socket.socket | None = None
        if url.startswith("socket://"):
            host, _, number = url.removeprefix("socket://").rpartition(":")
            self.socket = socket.create_connection((host, int(number)))
            self.descriptor = self.socket.fileno()
        else:
            self.descriptor = os.open(url, os.O_RDWR | os.O_NOCTTY)

    def send(self, data: bytes) -> None:
        while data:
            data = data[os.write(self.descriptor, data) :]

    def receive(self, size: int) -> bytes:
        data = b""
        while len(data) < size:
            ready, _, _ = select.select([self.descriptor], [], [], DEADLINE_S)
            assert ready, f"waited in vain for {size} bytes, {len(data)} came"
            piece = os.read(self.descriptor, size - len(data))
            assert piece, "the other side is gone"
            data += piece
        return data

    def close(self) -> None:
        if self.socket is not None:
            self.socket.close()
            self.socket = None
        elif self.descriptor >= 0:
            os.close(self.descriptor)
        self.descriptor = -1


@pytest.fixture
def port() -> Iterator[Callable[[str], Port]]:
    ports: list[Port] = []

    def opened(url: str) -> Port:
        ports.append(Port(url))
        return ports[-1]

    yield opened
    for each in ports:
        each.close()


def recorded(path: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()]


def bytes_of(path: Path, sender: str) -> bytes:
    return b"".join(bytes.fromhex(str(r["raw"])) for r in recorded(path) if r.get("from") == sender)


@pytest.mark.parametrize("listen", ["pty", "socket://127.0.0.1:0"])
def test_a_program_drives_a_robot_through_it(cli: Cli, listen: str) -> None:
    simulator = cli.simulate()
    monitor = cli.start("monitor", "--listen", listen, "--port", simulator.url, "--record", "wire.jsonl")
    cli.program("REPEAT 4 [FD 50 RT 90]")
    done = cli("run", "program.logo", "--port", url_of(monitor, "host"))
    assert done.code == 0, done.err
    monitor.wait_for_out("forward distance_half_mm=100")
    monitor.signal(signal.SIGINT)
    ended = monitor.end()
    assert ended.code == 130
    ended.check_said("interrupted (SIGINT)")
    # What was shown is what was recorded, and it says what happened.
    assert cli("decode", "walter", "wire.jsonl").out == ended.out
    assert ended.out.count(" host   ") > 10
    assert ended.out.count("heading_reply") >= 1
    # Attention and the stop that is sent again and again are full of what means nothing (W7, W8).
    assert "error" not in re.sub("error: (unknown letter 00|no key (00|32))", "", ended.out)
    identified = cli("identify", "wire.jsonl")
    assert identified.code == 0
    assert "walter, from the host, mode logo" in identified.out
    assert "walter, from the robot" in identified.out
    times = [int(str(record["t_ns"])) for record in recorded(cli.folder / "wire.jsonl")[1:]]
    assert times == sorted(times)


@pytest.mark.parametrize("listen", ["pty", "socket://127.0.0.1:0"])
def test_every_byte_passes_both_ways(cli: Cli, listen: str, port: Callable[[str], Port]) -> None:
    monitor = cli.start(
        "monitor", "--listen", listen, "--port", "pty", "--record", "wire.jsonl", "--protocol", "frame"
    )
    host, robot = port(url_of(monitor, "host")), port(url_of(monitor, "robot"))
    chance = random.Random(1)
    said = {"host": b"", "robot": b""}
    for _ in range(60):
        for sender, near, far in (("host", host, robot), ("robot", robot, host)):
            data = chance.randbytes(chance.randrange(1, 2000))
            near.send(data)
            assert far.receive(len(data)) == data
            said[sender] += data
    monitor.signal(signal.SIGTERM)
    assert monitor.end().code == 130
    for sender, data in said.items():
        assert bytes_of(cli.folder / "wire.jsonl", sender) == data
        shown = re.findall(rf"^ *\S+  {sender} .*# ((?:[0-9A-F]{{2}} ?)+)$", monitor.out, re.MULTILINE)
        assert b"".join(map(bytes.fromhex, shown)) == data


def test_a_terminal_that_is_stopped_delays_no_byte(cli: Cli, port: Callable[[str], Port]) -> None:
    """Nobody reads its output: a pipe holds 64 KiB, and far more than that is said."""
    import subprocess
    import sys

    process = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "turtlewire",
            "monitor",
            "--listen",
            "pty",
            "--port",
            "pty",
            "--protocol",
            "simple",
            "--record",
            "wire.jsonl",
        ],
        cwd=cli.folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    urls = {}
    for line in (process.stderr.readline(), process.stderr.readline()):
        found = re.fullmatch(r"the (host|robot)'s port is (\S+)\n", line)
        assert found is not None
        urls[found[1]] = found[2]
    host, robot = port(urls["host"]), port(urls["robot"])
    for n in range(300):
        data = b"%04d" % n * 20
        robot.send(data)
        assert host.receive(80) == data
    process.send_signal(signal.SIGINT)
    # Not a byte of its output is read before it has ended, except what it says at the end.
    assert process.wait(DEADLINE_S) == 130
    with process:
        assert "not everything was shown" in process.stderr.read()
    assert bytes_of(cli.folder / "wire.jsonl", "robot") == b"".join(b"%04d" % n * 20 for n in range(300))


def test_a_host_that_is_killed_says_nothing_more_and_may_come_back(
    cli: Cli, wire: Callable[..., Wire], port: Callable[[str], Port]
) -> None:
    robot = wire()
    monitor = cli.start("monitor", "--listen", "socket://127.0.0.1:0", "--port", robot.path)
    url = url_of(monitor, "host")
    host = port(url)
    host.send(b"F\0\xc8\r")
    robot.wait_for(b"F\0\xc8\r")
    second = port(url)
    # There is one host at a time: the second is sent away.
    assert select.select([second.descriptor], [], [], DEADLINE_S)[0]
    assert os.read(second.descriptor, 1) == b""
    host.close()
    monitor.wait_for_out("the host has left")
    again = port(url)
    again.send(b"QH\r")
    robot.wait_for(b"QH\r")
    monitor.signal(signal.SIGINT)
    assert monitor.end().code == 130
    # Nothing of the monitor's own.
    assert bytes(robot.received) == b"F\0\xc8\rQH\r"


def test_the_last_words_of_a_host_still_arrive(
    cli: Cli, wire: Callable[..., Wire], port: Callable[[str], Port]
) -> None:
    robot = wire()
    monitor = cli.start("monitor", "--listen", "socket://127.0.0.1:0", "--port", robot.path)
    host = port(url_of(monitor, "host"))
    host.send(EMERGENCY_STOP)
    host.close()
    robot.wait_for(EMERGENCY_STOP)
    monitor.signal(signal.SIGINT)
    monitor.end()


@pytest.mark.parametrize("gone", ["host", "robot"])
def test_an_end_that_is_gone_ends_it_with_a_clear_message(
    cli: Cli, gone: str, port: Callable[[str], Port]
) -> None:
    listeners = [socket.create_server(("127.0.0.1", 0)) for _ in range(2)]
    urls = [f"socket://127.0.0.1:{listener.getsockname()[1]}" for listener in listeners]
    monitor = cli.start("monitor", "--port", urls[0], "--port", urls[1], "--record", "wire.jsonl")
    robot, host = listeners[1].accept()[0], listeners[0].accept()[0]
    with robot, host, listeners[0], listeners[1]:
        host.sendall(b"PU\r")
        assert robot.recv(3) == b"PU\r"
        last, other = (host, robot) if gone == "host" else (robot, host)
        last.sendall(b"QH\r")
        last.close()
        assert other.recv(3) == b"QH\r"
        ended = monitor.end()
    assert ended.code == 3
    ended.check_said(f"the {gone}'s end of the wire is gone: {urls[gone == 'robot']}. Is it still plugged in")
    assert f"the {gone}'s end is gone" in ended.out
    assert bytes_of(cli.folder / "wire.jsonl", gone).endswith(b"QH\r")


def test_a_robot_that_is_unplugged(cli: Cli) -> None:
    near, far = os.openpty()
    monitor = cli.start("monitor", "--listen", "pty", "--port", os.ttyname(far))
    url_of(monitor, "host")
    os.close(far)
    os.close(near)
    ended = monitor.end()
    assert ended.code == 3
    ended.check_said("the robot's end of the wire is gone")


def test_a_port_has_one_host_at_a_time(cli: Cli, wire: Callable[..., Wire]) -> None:
    robot = wire()
    monitor = cli.start("monitor", "--listen", "socket://127.0.0.1:0", "--port", robot.path)
    url = url_of(monitor, "host")
    busy = cli("monitor", "--listen", "pty", "--port", robot.path)
    assert busy.code == 3
    busy.check_said(f"{robot.path} is in use by another program")
    taken = cli("monitor", "--listen", url, "--port", "pty")
    assert taken.code == 3
    taken.check_said(f"cannot listen at {url}: another program does already")
    monitor.signal(signal.SIGINT)
    monitor.end()


def test_a_host_that_does_not_read_is_said_and_the_robot_is_heard_all_the_same(
    cli: Cli, port: Callable[[str], Port]
) -> None:
    monitor = cli.start(
        "monitor",
        "--listen",
        "pty",
        "--port",
        "pty",
        "--protocol",
        "simple",
        "--record",
        "wire.jsonl",
        "--json",
    )
    host, robot = port(url_of(monitor, "host")), port(url_of(monitor, "robot"))
    for _ in range(100):
        robot.send(b"K" * 1000)
    wait_until(lambda: len(bytes_of(cli.folder / "wire.jsonl", "robot")) == 100_000, "all of it")
    notes = [str(record["note"]) for record in recorded(cli.folder / "wire.jsonl") if "note" in record]
    assert notes == ["the host does not read: what it is sent is dropped from here on"]
    kept = host.receive(1 << 16)
    assert set(kept) == {ord("K")}
    # The host's own bytes pass as ever.
    host.send(b"S000000")
    assert robot.receive(7) == b"S000000"
    monitor.signal(signal.SIGINT)
    assert monitor.end().code == 130
