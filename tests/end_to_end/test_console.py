"""``turtlewire console``: a process that is started, asked, stopped by signals, and told wrong things."""

from __future__ import annotations

import asyncio
import importlib.util
import json
import re
import signal
import socket
import ssl
import subprocess
from typing import TYPE_CHECKING, Any

import httpx
import pytest
from websockets.asyncio.client import connect as connect_async
from websockets.sync.client import connect

from tests.unit.console.served import Page, moves
from tests.unit.robots.reconnecting.ports import PATIENT, ROBOTS, Port
from turtlewire.cli.main import main

from .conftest import EMERGENCY_STOP, wait_until

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from .conftest import Cli, Process

    MakePort = Callable[[str], Port]

# What the last bytes are that each robot hears (S7, F13, W8).
STOPPED = {
    "walter": re.compile(re.escape(EMERGENCY_STOP) + rb".*\Z", re.DOTALL),
    "simple": re.compile(rb"S{14}\Z"),
    "frame": re.compile(rb"\x01\x00\x00\x01\x01\x00.\Z", re.DOTALL),
}


@pytest.fixture
def port(tmp_path: Path) -> Iterator[MakePort]:
    """A robot of a protocol at a pty."""
    ports: list[Port] = []

    def make(protocol: str) -> Port:
        folder = tmp_path / protocol
        folder.mkdir()
        ports.append(Port("pty", ROBOTS[protocol](), folder))
        return ports[-1]

    yield make
    for one in ports:
        one.unplug()


def start(cli: Cli, *arguments: str) -> tuple[Process, str]:
    """The console, and its address without what follows ``?``."""
    process = cli.start("console", "--listen-port", "0", "--programs", "programs", *arguments)
    process.wait_for_out("turtlewire console: ")
    wait_until(lambda: "\n" in process.out.split("turtlewire console: ")[1], "an address")
    return process, process.out.split("turtlewire console: ")[1].split()[0]


def robots(address: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = httpx.get(f"{address}api/robots").json()
    return found


def wait_until_reached(address: str) -> None:
    try:
        wait_until(lambda: all(robot["reached"] for robot in robots(address)), "its robots")
    except AssertionError as error:
        raise AssertionError(robots(address)) from error


def url_of(port: Port, protocol: str) -> str:
    return f"{port.url}?protocol={protocol}&boot_s=0.2{PATIENT[protocol]}"


def test_without_a_robot_it_has_three_and_a_page(cli: Cli) -> None:
    process, address = start(cli)
    wait_until_reached(address)
    assert [robot["name"] for robot in robots(address)] == ["walter", "car", "frame"]
    assert all(robot["simulated"] for robot in robots(address))
    page = httpx.get(address)
    assert page.status_code == 200
    for path in re.findall(r'(?:src|href)="([^"]+)"|@import url\("([^"]+)"\)', page.text):
        assert not "".join(path).startswith(("http:", "https:", "//")), path
    modules = json.loads(re.search(r'importmap">\s*(\{.*?\})\s*</script>', page.text, re.DOTALL)[1])  # type: ignore[index]
    own = modules["imports"]["turtlewire-console/"]
    shell = httpx.get(f"{address.rstrip('/')}{own}console.js")
    assert shell.status_code == 200
    assert shell.headers["cache-control"] == "no-cache"
    assert "turtlewire-console/console.js" in page.text or "component" in page.text
    assert httpx.get(f"{address.rstrip('/')}/favicon.ico").status_code == 200
    process.signal(signal.SIGINT)
    ended = process.end()
    assert ended.code == 130
    ended.check_said("turtlewire: interrupted (SIGINT)")


@pytest.mark.parametrize(
    ("protocol", "number"),
    [("walter", signal.SIGINT), ("simple", signal.SIGTERM), ("frame", signal.SIGHUP)],
    ids=["walter", "simple", "frame"],
)
def test_a_signal_stops_the_robot_that_somebody_drives(
    cli: Cli, port: MakePort, protocol: str, number: signal.Signals
) -> None:
    robot = port(protocol)
    process, address = start(cli, "--port", url_of(robot, protocol))
    wait_until_reached(address)
    name = robots(address)[0]["name"]
    with connect(address.replace("http", "ws") + "api/stream") as socket_:
        page = Page(socket_, name)
        page.hold(name, 0.5, moves)
        process.signal(number)
        ended = process.end()
    assert ended.code == 130
    ended.check_said(f"turtlewire: interrupted ({number.name})")
    wait_until(lambda: not robot.robot.is_moving, "a robot that stands")
    assert STOPPED[protocol].search(robot.heard)


def test_without_its_driver_the_robot_at_a_port_stands(cli: Cli, port: MakePort) -> None:
    robot = port("simple")
    process, address = start(cli, "--port", url_of(robot, "simple"))
    wait_until_reached(address)
    name = robots(address)[0]["name"]
    for how in ("silent", "stopped", "closed"):
        # What is seen of it is a little old.
        wait_until(
            lambda: not moves(httpx.get(f"{address}api/robots/{name}").json()), "it to be seen standing"
        )
        robot.heard = b""
        with connect(address.replace("http", "ws") + "api/stream") as socket_:
            page = Page(socket_, name)
            page.hold(name, 0.5, moves)
            if how == "stopped":
                page.say(type="stop", robot=name)
            elif how == "closed":
                page.socket.close()
            wait_until(lambda: not robot.robot.is_moving, f"a robot that stands: {how}")
            assert re.search(rb"F(?!000).*(F000|S{14})", robot.heard, re.DOTALL)
            driver = httpx.get(f"{address}api/robots/{name}").json()["wheel"]["driver"]
            assert driver == (page.id if how == "silent" else None)
    process.signal(signal.SIGTERM)
    assert process.end().code == 130


def test_a_robot_that_is_not_there_is_shown_as_such_and_tried_again(
    cli: Cli, port: MakePort, tmp_path: Path
) -> None:
    there = tmp_path / "simple" / "ttyROBOT"
    url = f"{there}?protocol=simple&boot_s=0.2{PATIENT['simple']}"
    process, address = start(cli, "--port", url, "--port", "sim:frame")
    wait_until(lambda: robots(address)[1]["reached"], "the other robot")
    missing = wait_for_error(address)
    assert str(there) in missing["error"]
    assert missing["reached"] is False
    name = missing["name"]
    answer = httpx.get(f"{address}api/robots/{name}").json()
    assert answer["view"]["link"] == "unreachable"
    assert httpx.post(f"{address}api/robots/{name}/stop").status_code == 200
    port("simple")
    wait_until(lambda: robots(address)[0]["reached"], "the robot that came late")
    assert robots(address)[0]["error"] is None
    process.signal(signal.SIGTERM)
    assert process.end().code == 130


def wait_for_error(address: str) -> dict[str, Any]:
    wait_until(lambda: robots(address)[0]["error"] is not None, "an error")
    return robots(address)[0]


def test_a_robot_that_is_still_being_reached_keeps_nobody_waiting_at_the_end(cli: Cli) -> None:
    process, address = start(cli, "--port", "pty?protocol=simple&boot_s=600")
    process.wait_for_err("waiting for the robot at")
    assert robots(address)[0]["reached"] is False
    process.signal(signal.SIGTERM)
    ended = process.end()
    assert ended.code == 130
    ended.check_said("interrupted (SIGTERM)")


# ---------------------------------------------------------------------- open to others


@pytest.fixture(scope="module")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("tls")
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes",
         "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost", "-days", "2",
         "-keyout", str(folder / "key.pem"), "-out", str(folder / "cert.pem")],
        check=True,
        capture_output=True,
    )  # fmt: skip
    return folder


def test_open_to_others_it_shows_its_token_and_a_picture_of_it(cli: Cli) -> None:
    process, address = start(cli, "--host", "0.0.0.0", "--robot", "simple")
    url, _, token = address.partition("?token=")
    assert len(token) >= 20
    assert "0.0.0.0" not in url or not _network()
    process.wait_for_out("▄")
    process.wait_for_err("with --certificate FILE nobody can")
    local = f"http://127.0.0.1:{url.rsplit(':')[-1]}"
    assert httpx.get(f"{local}api/robots").status_code == 401
    with httpx.Client(follow_redirects=True) as http:
        page = http.get(local, params={"token": token})
        assert page.status_code == 200
        assert token not in str(page.url)
        assert http.get(f"{local}api/robots").status_code == 200
    process.wait_for_err("refused 127.0.0.1 GET /api/robots: token: ")
    process.signal(signal.SIGTERM)
    ended = process.end()
    assert ended.code == 130
    assert token not in ended.err


def _network() -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))
        except OSError:
            return False
    return True


def test_over_tls(cli: Cli, certificate: Path) -> None:
    files = ["--certificate", str(certificate / "cert.pem"), "--key", str(certificate / "key.pem")]
    process, address = start(cli, "--host", "localhost", "--robot", "simple", *files)
    assert address.startswith("https://localhost:")
    context = ssl.create_default_context(cafile=str(certificate / "cert.pem"))
    with httpx.Client(verify=context) as http:
        assert http.get(f"{address}api/robots").json()[0]["name"] == "car"

    async def welcome() -> Any:
        url = address.replace("https", "wss") + "api/stream"
        async with connect_async(url, ssl=context) as stream:
            return json.loads(await stream.recv())

    assert asyncio.run(welcome())["type"] == "welcome"
    process.signal(signal.SIGTERM)
    assert process.end().code == 130


# ---------------------------------------------------------------------- wrong


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["--robot", "nobody"], 2, "--robot: invalid choice: 'nobody'"),
        (["--port", "sim:tank"], 2, "sim:tank"),
        (["--port", "sim:walter?pace=max"], 2, "nobody can drive at pace=max"),
        (["--port", "sim:walter?arena=none.toml"], 2, "none.toml"),
        (["--listen-port", "70000"], 2, "'70000' is not the number of a port"),
        (["--host", "256.1.1.1"], 2, "--host 256.1.1.1"),
        (["--host", "192.0.2.77"], 2, "192.0.2.77"),
        (["--key", "key.pem"], 2, "name that by --certificate"),
        (["--certificate", "none.pem"], 1, "none.pem: No such file"),
    ],
)
def test_what_is_wrong_is_told_in_a_paragraph(cli: Cli, arguments: list[str], code: int, said: str) -> None:
    ended = cli("console", "--listen-port", "0", *arguments)
    assert ended.code == code
    ended.check_said(said)
    assert ended.out == ""


def test_a_certificate_that_is_none_and_one_without_its_key(cli: Cli, certificate: Path) -> None:
    cli.program("no certificate", "bad.pem")
    ended = cli("console", "--listen-port", "0", "--certificate", "bad.pem")
    assert ended.code == 1
    ended.check_said("bad.pem", "PEM files are expected")
    ended = cli("console", "--listen-port", "0", "--certificate", str(certificate / "cert.pem"))
    assert ended.code == 1
    ended.check_said("cert.pem", "the key's by --key")


def test_a_port_that_is_in_use(cli: Cli) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        number = taken.getsockname()[1]
        ended = cli("console", "--listen-port", str(number))
    assert ended.code == 2
    ended.check_said(f"port {number} of 127.0.0.1 is in use", "--listen-port")
    assert ended.out == ""


def test_without_its_libraries_it_says_how_to_install_them(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = importlib.util.find_spec
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "nicegui" else found(name))
    assert main(["console", "--listen-port", "0"]) == 2
    assert "(nicegui): pip install 'turtlewire[console]'" in capsys.readouterr().err
