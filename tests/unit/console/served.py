"""A console that really listens, with simulated robots, in a thread of this process; and those who use it."""

from __future__ import annotations

import asyncio
import contextlib
import json
import threading
import time
from typing import TYPE_CHECKING, Any

import httpx
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from turtlewire import configuration
from turtlewire.cli.options import by_hand
from turtlewire.console.console import Console
from turtlewire.console.programs import Programs
from turtlewire.console.server import Service, door, listen
from turtlewire.console.stations import Berth

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path
    from typing import Self

    from websockets.sync.connection import Connection

PATIENCE_S = 60.0


def until(condition: Callable[[], Any]) -> Any:
    """Wait for something to be true; what it is."""
    deadline = time.monotonic() + PATIENCE_S
    while not (found := condition()):
        assert time.monotonic() < deadline, "it does not come true"
        time.sleep(0.005)
    return found


class Served:
    """A console at an address of this computer."""

    def __init__(self, *urls: str, folder: Path, token: str = "", host: str = "127.0.0.1") -> None:
        berths = [Berth(*by_hand(configuration.target(url))) for url in urls]
        self.console = Console(berths, lambda _: None, Programs(folder))
        self._listener = listen(host, 0)
        entrance = door(host, self._listener, token, is_secure=False)
        self.address = f"http://127.0.0.1:{entrance.port}"
        self.service = Service(self.console, entrance, self._listener, with_page=False)
        self._thread = threading.Thread(target=lambda: asyncio.run(self.service.serve()), daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        until(lambda: all(station.is_reached for station in self.console.stations))
        return self

    def __exit__(self, *_: object) -> None:
        self.service.end()
        self._thread.join(PATIENCE_S)
        self._listener.close()
        assert not self._thread.is_alive()

    def http(self, **headers: str) -> httpx.Client:
        """A client that sends these headers."""
        return httpx.Client(base_url=self.address, headers=headers)

    @contextlib.contextmanager
    def page(self, *robots: str, **options: Any) -> Iterator[Page]:
        """A page that watches these robots."""
        url = self.address.replace("http", "ws") + "/api/stream"
        with connect(url, open_timeout=PATIENCE_S, close_timeout=PATIENCE_S, **options) as socket:
            yield Page(socket, *robots)


class Page:
    """Somebody at a page, without the browser."""

    def __init__(self, socket: Connection, *robots: str) -> None:
        self.socket = socket
        self.heard: list[dict[str, Any]] = []
        self._stamp, self._stamped_s = 0.0, 0.0
        self.number = 0
        self.welcome = self.hear()
        self.session: str = self.welcome["session"]
        self.id: int = self.welcome["id"]
        for robot in robots:
            self.say(type="watch", robot=robot)
        for robot in robots:
            self.state(robot)

    def say(self, **message: Any) -> None:
        self.socket.send(json.dumps(message))

    def hear(self) -> dict[str, Any]:
        message: dict[str, Any] = json.loads(self.socket.recv(PATIENCE_S))
        self.heard.append(message)
        if "stamp" in message:
            self._stamp, self._stamped_s = message["stamp"], time.monotonic()
        return message

    def await_(self, condition: Callable[[dict[str, Any]], Any]) -> dict[str, Any]:
        """The next message that fulfils a condition."""
        deadline = time.monotonic() + PATIENCE_S
        while True:
            message = self.hear()
            if condition(message):
                return message
            assert time.monotonic() < deadline, f"not in {self.heard[-20:]}"

    def state(
        self, robot: str, condition: Callable[[dict[str, Any]], Any] = lambda _: True
    ) -> dict[str, Any]:
        """The next state of a robot that fulfils a condition."""
        return self.await_(lambda m: m["type"] == "state" and m["robot"] == robot and condition(m))

    def refusal(self, code: str) -> dict[str, Any]:
        """The next refusal, which is of this code."""
        message = self.await_(lambda m: m["type"] == "refused")
        assert message["code"] == code, message
        return message

    def ended_by(self, text: str, times: int) -> int:
        """The code with which the server ends the stream of whoever says this so often."""
        try:
            for _ in range(times):
                self.socket.send(text)
            while True:
                self.hear()
        except ConnectionClosed as closed:
            return closed.rcvd.code if closed.rcvd else 0

    def drive(
        self, robot: str, speed: float, turn: float = 0.0, *, grip: int = 1, stamp_s: float = 0.0, **more: Any
    ) -> None:
        """A set-point; ``stamp_s`` makes it look older."""
        self.number += 1
        age_ms = (time.monotonic() - self._stamped_s) * 1000.0
        said = {"number": self.number, "grip": grip, "speed": speed, "turn": turn, "horn": False}
        said |= {"stamp": self._stamp - stamp_s, "age_ms": age_ms}
        self.say(type="drive", robot=robot, **(said | more))

    def hold(
        self, robot: str, speed: float, condition: Callable[[dict[str, Any]], Any], *, grip: int = 1
    ) -> dict[str, Any]:
        """Hold until the robot's state fulfils a condition."""
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            self.drive(robot, speed, grip=grip)
            message = self.hear()
            if message["type"] == "state" and message["robot"] == robot and condition(message):
                return message
        raise AssertionError(f"not in {self.heard[-20:]}")


def moves(state: dict[str, Any]) -> bool:
    return bool(state["view"]["speed_mm_per_s"] or state["view"]["turn_deg_per_s"])


def stands(state: dict[str, Any]) -> bool:
    return not moves(state)
