"""A car at work on a simulated one, in virtual time, with a wire between them that can be read and damaged."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import pytest

from tests.unit.robots.car.wires import Wire, off_mm
from turtlewire.links.memory import MemoryLink
from turtlewire.robots.car import AsyncCar, Car, Settings
from turtlewire.robots.runner import InlineRunner
from turtlewire.simulator.car import CarSettings, SimulatedCar


class Bench(NamedTuple):
    """A turtle, the car that it drives, the wire between, and what people were told."""

    turtle: Car
    robot: SimulatedCar
    wire: Wire
    notes: list[str]

    @property
    def off_mm(self) -> float:
        """How far the car truly is from where the turtle says."""
        return off_mm(self.turtle, self.robot)

    def goes_on(self, seconds: float) -> bool:
        """Let the host do what it does for some time; whether the car moves then."""
        self.turtle._runner.run(self.turtle._robot._pause(seconds))
        return self.robot.is_moving


MakeBench = Callable[..., Bench]


@pytest.fixture
def bench() -> Iterator[MakeBench]:
    """Connect to a simulated car; ``robot`` are its settings, the rest those of the driver."""
    benches: list[Bench] = []

    def make(
        robot: dict[str, Any] | None = None, prepare: Callable[[Wire], object] = id, **settings: Any
    ) -> Bench:
        simulated = SimulatedCar(CarSettings(**(robot or {})))
        wire, runner = Wire(simulated), InlineRunner()
        notes: list[str] = []
        prepare(wire)
        driver = AsyncCar(MemoryLink(wire), Settings(**settings), notes.append)
        runner.run(driver.connect())
        made = Bench(Car(driver, runner), simulated, wire, notes)
        benches.append(made)
        return made

    yield make
    for one in benches:
        one.turtle.close(finish=False)
