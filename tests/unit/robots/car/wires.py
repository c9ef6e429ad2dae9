"""A simulated robot behind a wire that is read and damaged, in virtual time."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from turtlewire.turtle import Pose, Turtle

Change = Callable[[bytes], bytes]


class End(Protocol):
    """What of a simulated robot the wire needs."""

    now: float

    def write(self, data: bytes) -> None: ...

    def discard_output(self) -> None: ...

    def read(self, until: float) -> bytes: ...

    def awaits_host(self) -> bool: ...

    def port_opened(self) -> None: ...


class Wire:
    """What lies between host and robot.

    Attributes:
        sent: what the host put on the line, with the time.
        to_robot, to_host: what the line makes of bytes on their way.
        at: what happens once, at a time.
        discards: how often the host took back what had not gone out.
    """

    def __init__(self, robot: End) -> None:
        self.robot = robot
        self.sent: list[tuple[float, bytes]] = []
        self.to_robot: Change = bytes
        self.to_host: Change = bytes
        self.discards = 0
        self._at: tuple[float, Callable[[], object]] = (math.inf, int)

    @property
    def now(self) -> float:
        return self.robot.now

    @property
    def bytes_sent(self) -> bytes:
        return b"".join(data for _, data in self.sent)

    def forget(self) -> None:
        self.sent.clear()

    def at(self, seconds_from_now: float, act: Callable[[], object]) -> None:
        self._at = (self.now + seconds_from_now, act)

    def write(self, data: bytes) -> None:
        self.sent.append((self.now, data))
        self.robot.write(self.to_robot(data))

    def discard_output(self) -> None:
        self.discards += 1
        self.robot.discard_output()

    def awaits_host(self) -> bool:
        return self._at[0] == math.inf and self.robot.awaits_host()

    def port_opened(self) -> None:
        self.robot.port_opened()

    def read(self, until: float) -> bytes:
        at, act = self._at
        if self.now < at:
            return self.to_host(self.robot.read(min(until, at)))
        self._at = (math.inf, int)
        act()
        return b""


class Damage:
    """Changes chosen occurrences of something on its way: ``{1: b""}`` loses the second one."""

    def __init__(self, what: bytes, becomes: dict[int, bytes]) -> None:
        self._what, self._becomes = what, becomes
        self.seen = 0

    def __call__(self, data: bytes) -> bytes:
        if self._what in data:
            data = data.replace(self._what, self._becomes.get(self.seen, self._what), 1)
            self.seen += 1
        return data


def mute(_: bytes) -> bytes:
    """What is not heard."""
    return b""


def pass_time(robot: End, seconds: float) -> None:
    """Let some of a robot's time pass without its host."""
    end = robot.now + seconds
    while robot.now < end:
        robot.read(end)


def off_mm(turtle: Any, robot: Any) -> float:
    """How far the robot truly is from where the turtle says."""
    pose: Pose = robot.pose
    distance: float = turtle.pose.distance_to(pose.x_mm, pose.y_mm)
    return distance


def corners(turtle: Turtle, robot: Any) -> float:
    """Draw a bit of everything that moves; the largest distance there was between robot and turtle at a corner."""
    worst = 0.0
    steps: list[Callable[[], object]] = [
        lambda: turtle.forward(140.3),
        lambda: turtle.right(77.7),
        lambda: turtle.forward(-25.2),
        turtle.pen_up,
        lambda: turtle.set_position(30.0, -20.25),
        turtle.pen_down,
        lambda: turtle.set_x(55.5),
        lambda: turtle.set_y(11),
        lambda: turtle.set_heading(13),
        lambda: turtle.forward(20),
        lambda: turtle.right(-200),
        lambda: turtle.forward(0.7),
        turtle.home,
        lambda: turtle.back(5),
        lambda: turtle.left(390),
        turtle.finish,
    ]
    for step in steps:
        step()
        worst = max(worst, off_mm(turtle, robot))
    return worst
