"""Those who look on and those who are in the way: a stream that writes down what it is told, and a wire that stalls."""

from __future__ import annotations

import contextlib
import json
import math
import socket
import threading
import time
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import urlsplit

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

if TYPE_CHECKING:
    from .conftest import Console

DEADLINE_S = 40.0
# Less than this is no motion.
STILL_MM, STILL_DEG = 0.01, 0.01


class Look(NamedTuple):
    """Where the robot was at a time, of its own clock and of this computer's."""

    time_s: float
    stamp: float
    x_mm: float
    y_mm: float
    heading_deg: float

    def off(self, other: Look) -> float:
        """How far it is from there: millimetres, and degrees for as much."""
        way = math.hypot(self.x_mm - other.x_mm, self.y_mm - other.y_mm)
        return way + abs((self.heading_deg - other.heading_deg + 180.0) % 360.0 - 180.0)


class Onlooker:
    """Watches one robot of a console over the stream, as any page does."""

    def __init__(self, console: Console, robot: str = "walter") -> None:
        self._robot = robot
        self._looks: list[Look] = []
        self.messages: list[dict[str, Any]] = []
        self._news = threading.Condition()
        self._open = contextlib.ExitStack()
        self.socket = self._open.enter_context(connect(console.url.replace("http", "ws", 1) + "api/stream"))
        welcome = json.loads(self.socket.recv(timeout=DEADLINE_S))
        self.session: str = welcome["session"]
        self.id: int = welcome["id"]
        self.say(type="watch", robot=robot)
        self._reader = threading.Thread(target=self._follow, daemon=True)
        self._reader.start()

    def _follow(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            for text in self.socket:
                message = json.loads(text)
                with self._news:
                    self.messages.append(message)
                    view = message.get("view")
                    if message["type"] == "state" and view is not None:
                        pose = view["pose"]
                        look = Look(
                            view["time_s"], message["stamp"], pose["x_mm"], pose["y_mm"], pose["heading_deg"]
                        )
                        if not self._looks or look.time_s > self._looks[-1].time_s:
                            self._looks.append(look)
                    self._news.notify_all()

    def say(self, **message: Any) -> None:
        self.socket.send(json.dumps(message))

    def wait_for(self, kind: str, since: int = 0, **parts: Any) -> dict[str, Any]:
        """The first message of a kind, of those from a number on, that has these parts."""

        def found() -> dict[str, Any] | None:
            return next(
                (
                    message
                    for message in self.messages[since:]
                    if message["type"] == kind and parts.items() <= message.items()
                ),
                None,
            )

        with self._news:
            assert self._news.wait_for(lambda: found() is not None, DEADLINE_S), (
                f"waited in vain for {kind} {parts}"
            )
            message = found()
        assert message is not None
        return message

    def robot_time(self) -> float:
        """What the robot's clock shows now: a view is a little old when it is told, the newest of them the least."""
        with self._news:
            return time.monotonic() - min(look.stamp - look.time_s for look in self._looks)

    def stopped_at(self) -> float:
        """When, by its own clock, the robot came to a stand; waits until it has stood for a while."""

        def stands() -> bool:
            looks = self._looks
            last = looks[-1]
            return all(look.off(last) < STILL_MM for look in looks if look.time_s > last.time_s - 0.5)

        with self._news:
            assert self._news.wait_for(stands, DEADLINE_S), "it does not stop"
            last = self._looks[-1]
            elsewhere = [look.off(last) >= STILL_MM for look in self._looks]
            number = len(elsewhere) - 1 - elsewhere[::-1].index(True)
            then, still = self._looks[number], self._looks[number + 1]
            before = next(
                (look for look in reversed(self._looks[:number]) if look.off(then) >= STILL_MM), None
            )
        if before is None:
            return still.time_s
        return min(
            still.time_s, then.time_s + then.off(last) * (then.time_s - before.time_s) / then.off(before)
        )

    def close(self) -> None:
        self._open.close()
        self._reader.join(DEADLINE_S)


class Forwarder:
    """A way to a console that can stall, and break without a word."""

    def __init__(self, console: Console) -> None:
        address = urlsplit(console.url)
        assert address.hostname is not None
        self._to = (address.hostname, address.port or 80)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}/"
        self._goes = threading.Event()
        self._goes.set()
        self._is_over = False
        self._sockets: list[socket.socket] = []
        self._threads = [threading.Thread(target=self._accept, daemon=True)]
        self._threads[0].start()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                here, _ = self._listener.accept()
                there = socket.create_connection(self._to)
                self._sockets += [here, there]
                for source, sink in ((here, there), (there, here)):
                    thread = threading.Thread(target=self._forward, args=(source, sink), daemon=True)
                    self._threads.append(thread)
                    thread.start()

    def _forward(self, source: socket.socket, sink: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(1 << 16):
                self._goes.wait()
                if self._is_over:
                    return
                sink.sendall(data)
            sink.shutdown(socket.SHUT_WR)

    def stall(self) -> None:
        """From now on everything waits on its way."""
        self._goes.clear()

    def go_on(self) -> None:
        """All that waited arrives now, in order."""
        self._goes.set()

    def close(self) -> None:
        self._is_over = True
        self._goes.set()
        for each in (self._listener, *self._sockets):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()
        for thread in self._threads:
            thread.join(DEADLINE_S)
