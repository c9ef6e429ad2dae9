"""Robots that are not there, not alone, not a robot, or gone: one paragraph, exit code 3, what is drawn kept."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from .conftest import CONFIRMED, EMERGENCY_STOP, IMPATIENT, points

if TYPE_CHECKING:
    from collections.abc import Callable

    from .conftest import Cli, Wire

ENDLESS = "REPEAT 1000000 [FD 50 RT 91]\n"
NOBODY = 65534


@pytest.mark.parametrize("listen", ["pty", "socket://127.0.0.1:0"], ids=["pty", "socket"])
def test_unplugged_midway(cli: Cli, listen: str) -> None:
    simulator = cli.simulate("--listen", listen)
    process = cli.start(
        "run",
        cli.program(ENDLESS),
        "--port",
        simulator.url,
        "--picture",
        "drawn.svg",
        "--set",
        "reconnect_s=0.3",
    )
    simulator.wait_for_motions(CONFIRMED)
    simulator.signal(signal.SIGKILL)
    ended = process.end()
    assert ended.code == 3
    ended.check_said(
        f"the link to {simulator.url} ended",
        "in program.logo, line 1",
        "The robot cannot be reached to stop it: if it still moves, switch it off.",
        "What was drawn until then is in drawn.svg.",
    )
    assert len(points(cli.text("drawn.svg"))) >= 2


def test_one_that_never_answers_is_run_as_a_basic_one(cli: Cli, wire: Callable[..., Wire]) -> None:
    raw = wire()
    ended = cli("run", cli.program("FD 5 PRINT POS"), "--port", raw.path, *IMPATIENT)
    assert (ended.code, ended.out) == (0, "0 5\n")
    ended.check_said("answers no queries: it is run as a basic one", "robot pose it cannot tell")
    # Ten units, in two parts because of the byte 0A.
    assert b"F\0\x05\rF\0\x05\r" in raw.received
    raw.wait_for_end(EMERGENCY_STOP)
    refused = cli("run", "program.logo", "--port", raw.path, "--require-replies", *IMPATIENT)
    assert refused.code == 3
    refused.check_said("does not answer: is it switched on")
    raw.wait_for_end(EMERGENCY_STOP)
    stopped = cli("stop", "--port", raw.path, *IMPATIENT)
    assert stopped.code == 0
    stopped.check_said("the stop was sent", "nothing confirms it")
    raw.wait_for_end(EMERGENCY_STOP)


@pytest.mark.parametrize(
    "answer",
    [lambda data: b"\xff?rubbish\r" * 3, lambda data: data, lambda data: bytes(range(256)) * 16],
    ids=["lines", "echo", "flood"],
)
def test_one_that_answers_rubbish_is_refused(
    cli: Cli, wire: Callable[..., Wire], answer: Callable[[bytes], bytes]
) -> None:
    raw = wire(answer)
    ended = cli("run", cli.program("FD 5"), "--port", raw.path, *IMPATIENT, "--picture", "p.svg")
    assert (ended.code, ended.out) == (3, "")
    ended.check_said("does not speak WALTER's protocol", "is the baud rate 9600 right")
    raw.wait_for_end(EMERGENCY_STOP)
    assert b"F\0" not in raw.received
    stopped = cli("stop", "--port", raw.path, *IMPATIENT)
    assert stopped.code == 3
    stopped.check_said("does not speak WALTER's protocol", "The stop was sent")


@pytest.mark.parametrize(
    "state",
    [
        b"",
        b"F\x13",
        b"F\x13\x88\rF\x13\x88\rR\x01\x00\rF\x13\x88\r",
        b"2\rA",
        b"2\rZ",
        b"2\r.",
        b"2\r,G",
        b"2\rG",
    ],
    ids=[
        "idle",
        "mid-command",
        "queue",
        "ahead",
        "astern",
        "turning",
        "speed-pending-turning",
        "speed-pending",
    ],
)
def test_stop_from_every_state(cli: Cli, state: bytes) -> None:
    simulator = cli.simulate(speed="1")
    host = os.open(simulator.url, os.O_RDWR | os.O_NOCTTY)
    os.write(host, state)
    os.close(host)
    if state.startswith((b"2\rA", b"2\rZ", b"2\r.", b"2\r,", b"F\x13\x88")):
        simulator.wait_for_action("started")
    ended = cli("stop", "--port", simulator.url)
    assert ended.code == 0
    assert ended.out.startswith("stopped: the robot answers, at x ")
    assert ended.err == ""
    simulator.wait_until_still()
    begun = [action for action in simulator.actions if action.startswith("started")]
    assert len(begun) == (
        1 if b"." in state or b"," in state or b"A" in state or b"Z" in state or len(state) > 9 else 0
    )


def test_one_host_at_a_time(cli: Cli) -> None:
    for listen in ("pty", "socket://127.0.0.1:0"):
        simulator = cli.simulate("--listen", listen)
        first = cli.start("run", cli.program(ENDLESS), "--port", simulator.url)
        simulator.wait_for_motions(1)
        for arguments in (["run", "program.logo"], ["stop"]):
            refused = cli(*arguments, "--port", simulator.url)
            assert refused.code == 3, listen
            refused.check_said("in use by another program", "one host at a time")
        # The first one has not noticed anything.
        assert first.popen.poll() is None
        first.signal(signal.SIGTERM)
        assert first.end().code == 130
        assert cli("stop", "--port", simulator.url).code == 0


@pytest.mark.parametrize(
    ("port", "message"),
    [
        ("/dev/null", "is no serial port"),
        ("regular", "is no serial port"),
        ("folder", "is no serial port"),
        ("/dev/no-such-port", "there is no port"),
    ],
)
def test_not_a_serial_port(cli: Cli, port: str, message: str) -> None:
    if not port.startswith("/"):
        path = cli.folder / port
        path.mkdir() if port == "folder" else path.write_text("precious", "utf-8")
        port = str(path)
    for arguments in (["run", cli.program("FD 5")], ["stop"]):
        ended = cli(*arguments, "--port", port)
        assert (ended.code, ended.out) == (3, "")
        ended.check_said(port, message)
    if port.endswith("regular"):
        assert cli.text("regular") == "precious"


def test_without_permission(wire: Callable[..., Wire]) -> None:
    raw = wire()
    os.chmod(raw.path, 0)  # noqa: PTH101 - a device, not one of our files
    # Root may open anything: then it becomes somebody else, once all that this takes is loaded.
    code = (
        "import os, sys\n"
        "from turtlewire.cli.main import main\n"
        "main(['stop', '--port', '/dev/no-such-port'])\n"
        f"if os.geteuid() == 0: os.setgid({NOBODY}), os.setuid({NOBODY})\n"
        f"sys.exit(main(['stop', '--port', {raw.path!r}]))\n"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert ended.returncode == 3
    assert f"no permission to open {raw.path}" in ended.stderr
    assert "dialout" in ended.stderr
    assert "Traceback" not in ended.stderr


def test_nobody_listens(cli: Cli) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        number = server.getsockname()[1]
    ended = cli("run", cli.program("FD 5"), "--port", f"socket://127.0.0.1:{number}", "--json")
    assert ended.code == 3
    assert "nobody listens at" in ended.out


def test_an_address_that_is_taken(cli: Cli) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        ended = cli("simulate", "walter", "--listen", f"socket://127.0.0.1:{server.getsockname()[1]}")
    assert (ended.code, ended.out) == (3, "")
    ended.check_said("another program does already")
