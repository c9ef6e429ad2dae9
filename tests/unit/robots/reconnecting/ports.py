"""Real ports at which a simulated robot is, is not any more, and is again."""

from __future__ import annotations

import asyncio
import contextlib
import re
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any

from turtlewire.simulator.car import CarSettings, SimulatedCar
from turtlewire.simulator.frame_robot import FrameRobotSettings, SimulatedFrameRobot
from turtlewire.simulator.server import serve
from turtlewire.simulator.walter import Settings as WalterSettings
from turtlewire.simulator.walter import SimulatedWalter

if TYPE_CHECKING:
    from collections.abc import Callable

PATIENCE_S = 30.0
SPEED = 20.0
MOVES = re.compile(r"started|speed=[1-9]")
ROBOTS: dict[str, Callable[..., Any]] = {
    "walter": lambda **settings: SimulatedWalter(WalterSettings(**settings)),
    "simple": lambda **settings: SimulatedCar(CarSettings(**settings)),
    "frame": lambda **settings: SimulatedFrameRobot(FrameRobotSettings(**settings)),
}
# A machine with much to do may take longer for an answer than a robot does.
PATIENT = {"walter": "&reply_timeout_s=20", "simple": "&reply_delay_s=0.5", "frame": ""}


class Port:
    """A port, and the robot that is there while it is plugged in.

    Attributes:
        url: where a host finds it: the same every time.
        heard: what the robot's adapter has got from the host since it was plugged in last.
        moving: set when a motion begins.
    """

    def __init__(self, kind: str, robot: Any, folder: Path) -> None:
        self.robot = robot
        self.heard = b""
        self.moving = threading.Event()
        self._kind = kind
        self._device = folder / "ttyROBOT"
        self._listen = "pty" if kind == "pty" else "socket://127.0.0.1:0"
        self._write = robot.write
        robot.write = self._received
        robot.events = lambda action: self.moving.set() if MOVES.search(action.what) else None
        self._thread: threading.Thread | None = None
        self.plug_in()
        self.url = str(self._device) if kind == "pty" else self._listen

    def _received(self, data: bytes) -> None:
        self.heard += data
        self._write(data)

    def plug_in(self) -> None:
        """The robot is there."""
        self.heard = b""
        self.moving.clear()
        ready = threading.Event()

        async def main() -> None:
            self._loop, self._stopped = asyncio.get_running_loop(), asyncio.Event()

            def is_ready(url: str) -> None:
                if self._kind == "pty":
                    self._device.symlink_to(url)
                else:
                    self._listen = url
                ready.set()

            await serve(self.robot, self._listen, speed=SPEED, ready=is_ready, stopped=self._stopped)

        self._thread = threading.Thread(target=asyncio.run, args=(main(),))
        self._thread.start()
        assert ready.wait(PATIENCE_S)

    def unplug(self) -> None:
        """The robot is gone, and so is its port; its own time stands still meanwhile."""
        if self._thread is None:
            return
        self._device.unlink(missing_ok=True)
        self._loop.call_soon_threadsafe(self._stopped.set)
        self._thread.join(PATIENCE_S)
        self._thread = None

    def address(self) -> tuple[str, int]:
        """Of a socket."""
        return "127.0.0.1", int(self._listen.rpartition(":")[2])


class Notes(list[str]):
    """What people are told; whoever waits for a note gets it."""

    def __init__(self) -> None:
        super().__init__()
        self._changed = threading.Condition()

    def __bool__(self) -> bool:
        return True

    def __call__(self, text: str) -> None:
        with self._changed:
            self.append(text)
            self._changed.notify_all()

    def wait_for(self, part: str) -> str:
        with self._changed:
            assert self._changed.wait_for(lambda: any(part in note for note in self), PATIENCE_S), self
        return next(note for note in self if part in note)


def open_files() -> set[str]:
    """What this process has open: where each descriptor leads to."""
    found = set()
    for descriptor in Path("/proc/self/fd").iterdir():
        with contextlib.suppress(OSError):  # that of the listing itself
            found.add(f"{descriptor.name} {descriptor.readlink()}")
    return found
