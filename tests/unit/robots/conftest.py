"""A driver at work on a simulated robot, in virtual time, with a wire between them that can be read and damaged."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import pytest

from turtlewire.links.memory import MemoryLink
from turtlewire.robots.runner import InlineRunner
from turtlewire.robots.walter import AsyncWalter, Settings, Walter
from turtlewire.simulator.walter import Settings as RobotSettings
from turtlewire.simulator.walter import SimulatedWalter

if TYPE_CHECKING:
    from turtlewire.turtle import Pose

Change = Callable[[bytes], bytes]


class Wire:
    """What lies between host and robot.

    Attributes:
        sent: what the host put on the line, with the time.
        received: what came back, before any damage.
        to_robot, to_host: what the line makes of bytes on their way.
        discards: how often the host took back what had not gone out.
        largest: the most unfenced bytes there ever were, as ``watch`` tells.
    """

    def __init__(self, robot: SimulatedWalter) -> None:
        self.robot = robot
        self.sent: list[tuple[float, bytes]] = []
        self.received = b""
        self.to_robot: Change = bytes
        self.to_host: Change = bytes
        self.discards = 0
        self.largest = 0
        self.watch: Callable[[], int] = int

    @property
    def now(self) -> float:
        return self.robot.now

    @property
    def bytes_sent(self) -> bytes:
        return b"".join(data for _, data in self.sent)

    def forget(self) -> None:
        """Forget what has passed until now."""
        self.sent.clear()
        self.received = b""

    def write(self, data: bytes) -> None:
        self.sent.append((self.now, data))
        self.largest = max(self.largest, self.watch())
        self.robot.write(self.to_robot(data))

    def discard_output(self) -> None:
        self.discards += 1
        self.robot.discard_output()

    def awaits_host(self) -> bool:
        return self.robot.awaits_host()

    def port_opened(self) -> None:
        self.robot.port_opened()

    def read(self, until: float) -> bytes:
        data = self.robot.read(until)
        self.received += data
        return self.to_host(data)


class Bench(NamedTuple):
    """A turtle, the robot that it drives, the wire between, and what people were told."""

    turtle: Walter
    robot: SimulatedWalter
    wire: Wire
    notes: list[str]

    @property
    def error_mm(self) -> float:
        """How far the robot truly is from where the turtle says."""
        return self.turtle.pose.distance_to(self.robot.pose.x_mm, self.robot.pose.y_mm)

    def strokes(self) -> list[list[tuple[float, float]]]:
        """What the pen truly drew."""
        return [stroke.points for stroke in self.robot.trace.strokes if stroke.pen_down]


MakeBench = Callable[..., Bench]


@pytest.fixture
def bench() -> Iterator[MakeBench]:
    """Connect to a simulated robot; ``robot`` are its settings, the rest those of the driver."""
    benches: list[Bench] = []

    def make(
        robot: dict[str, Any] | None = None, prepare: Callable[[Wire], object] = id, **settings: Any
    ) -> Bench:
        simulated = SimulatedWalter(RobotSettings(**(robot or {})))
        wire, runner = Wire(simulated), InlineRunner()
        notes: list[str] = []
        prepare(wire)
        driver = AsyncWalter(MemoryLink(wire), Settings(**settings), notes.append)
        host = driver._wire.host
        wire.watch = lambda: host.unfenced_bytes
        made = Bench(Walter(driver, runner), simulated, wire, notes)
        benches.append(made)
        runner.run(driver.connect())
        return made

    yield make
    for one in benches:
        one.turtle.close(finish=False)


@pytest.fixture
def settle() -> Callable[[SimulatedWalter, float], Pose]:
    """Let some of a robot's time pass; where it is then."""

    def pass_time(robot: SimulatedWalter, seconds: float) -> Pose:
        end = robot.now + seconds
        while robot.now < end:
            robot.read(end)
        return robot.pose

    return pass_time
