"""A simulated robot, and a person who measures it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import pytest

from turtlewire import configuration
from turtlewire.connect import connect
from turtlewire.links.memory import MemoryLink
from turtlewire.robots.calibrating import Plan, Procedure, Progress, SimulatedPerson, guide, procedure
from turtlewire.simulated import simulated


class Bench(NamedTuple):
    """A robot, its body, and how it is driven."""

    robot: Any
    body: Any
    settings: Any

    def progress(self, plan: Plan = Plan()) -> Progress:  # noqa: B008 - immutable
        return Progress(lambda: procedure(self.robot, self.settings, plan))

    def calibrated(self, *steps: str, noise: float = 0.0, seed: int = 0, **plan: Any) -> Procedure[Any]:
        """All of it, by somebody who sees the body."""
        progress = self.progress(Plan(steps=frozenset(steps) or None, **plan))
        guide(progress, SimulatedPerson(self.body, noise, seed))
        return progress.procedure


MakeBench = Callable[..., Bench]


def bench_of(url: str, **overrides: Any) -> Bench:
    """Connect to a simulated robot; the rest are settings of its driver."""
    target = configuration.target(url)
    target = target._replace(overrides={**target.overrides, **overrides})
    links: list[Any] = []

    def see(link: Any) -> Any:
        assert isinstance(link, MemoryLink)
        links.append(link)
        return link

    robot = connect(target, wrap=see)
    return Bench(robot, links[0].end, simulated(target).target.settings())


@pytest.fixture
def bench() -> Iterator[MakeBench]:
    benches: list[Bench] = []

    def make(url: str, **overrides: Any) -> Bench:
        benches.append(bench_of(url, **overrides))
        return benches[-1]

    yield make
    for one in benches:
        one.robot.close(finish=False)
