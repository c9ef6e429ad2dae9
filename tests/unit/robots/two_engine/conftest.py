"""A two-engine robot at work on a simulated one, in virtual time, with a wire between them that can be damaged."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import pytest

from tests.unit.robots.car.wires import Wire, off_mm
from turtlewire.links.memory import MemoryLink
from turtlewire.protocols.frame.dialect import Dialect, shipped
from turtlewire.robots.runner import InlineRunner
from turtlewire.robots.two_engine import AsyncTwoEngine, Settings, TwoEngine
from turtlewire.simulator.frame_robot import FrameRobotSettings, SimulatedFrameRobot


class Bench(NamedTuple):
    """A turtle, the robot that it drives, the wire between, and what people were told."""

    turtle: TwoEngine
    robot: SimulatedFrameRobot
    wire: Wire
    notes: list[str]

    @property
    def off_mm(self) -> float:
        """How far the robot truly is from where the turtle says."""
        return off_mm(self.turtle, self.robot)

    def goes_on(self, seconds: float) -> bool:
        """Let the host do what it does for some time; whether the robot moves then."""
        self.turtle._runner.run(self.turtle._robot._pause(seconds))
        return self.robot.is_moving


MakeBench = Callable[..., Bench]


@pytest.fixture
def bench() -> Iterator[MakeBench]:
    """Connect to a simulated robot; ``robot`` are its settings, the rest those of the driver."""
    benches: list[Bench] = []

    def make(
        robot: dict[str, Any] | None = None,
        prepare: Callable[[Wire], object] = id,
        dialect: str | Dialect = "0.1",
        **settings: Any,
    ) -> Bench:
        speaks = shipped(dialect) if isinstance(dialect, str) else dialect
        simulated = SimulatedFrameRobot(FrameRobotSettings(**{"dialect": speaks, **(robot or {})}))
        wire, runner = Wire(simulated), InlineRunner()
        notes: list[str] = []
        prepare(wire)
        driver = AsyncTwoEngine(
            MemoryLink(wire),
            Settings(**{"dialect": speaks, "boot_s": 0.0, **settings}),
            notes.append,
            simulated,
        )
        runner.run(driver.connect())
        made = Bench(TwoEngine(driver, runner), simulated, wire, notes)
        benches.append(made)
        return made

    yield make
    for one in benches:
        one.turtle.close(finish=False)
