"""Every robot and its driver over a faulty link, checked against a model after each step: a little of it.

``make nightly`` gives a hundred thousand commands to each: ``python -m tests.soak``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, run_state_machine_as_test
from hypothesis.stateful import rule as hypothesis_rule

from tests.soak.__main__ import ONE_PERCENT
from tests.soak.domains import rules_of
from tests.soak.lives import SOAKS, random_lives
from turtlewire.links.faults import Faults

if TYPE_CHECKING:
    from tests.soak.domains import Rule
    from tests.soak.soak import Soak

each_robot = pytest.mark.parametrize("soak_type", list(SOAKS.values()), ids=list(SOAKS))


def machine(soak_type: type[Soak]) -> type[RuleBasedStateMachine]:
    """A state machine that does what a soak can do."""

    class Machine(RuleBasedStateMachine):
        soak: Soak | None = None

        @initialize(
            seed=st.integers(0, 1 << 32),
            rate=st.sampled_from((0.0, 0.002, 0.01)),
            setup=st.fixed_dictionaries({name: d.strategy() for name, d in soak_type.SETUP.items()}),
        )
        def begin(self, seed: int, rate: float, setup: dict[str, Any]) -> None:
            self.soak = soak_type(seed, Faults(lose=rate / 3, add=rate / 3, flip=rate / 3), **setup)

        def teardown(self) -> None:
            if self.soak is not None:
                self.soak.finish_life()

    for each in rules_of(soak_type):
        setattr(Machine, each.name, as_rule(each))
    return Machine


def as_rule(each: Rule) -> Any:
    def act(self: Any, **inputs: Any) -> None:
        self.soak.step(each.name, **inputs)

    act.__name__ = each.name
    inputs: dict[str, Any] = {name: d.strategy() for name, d in each.inputs.items()}
    make: Any = hypothesis_rule
    return make(**inputs)(act)


@each_robot
def test_whatever_is_done_to_a_robot_and_its_wire(soak_type: type[Soak]) -> None:
    run_state_machine_as_test(
        machine(soak_type),
        settings=settings(
            max_examples=20,
            stateful_step_count=40,
            derandomize=True,
            database=None,
            deadline=None,
            suppress_health_check=list(HealthCheck),
        ),
    )


@each_robot
def test_by_chance_at_one_percent(soak_type: type[Soak]) -> None:
    report = random_lives(soak_type, 1, Faults.parse(ONE_PERCENT), 400, 200)
    assert report.commands >= 400
    assert report.lives == 2
    faults = report.faults.total()
    assert faults > 0.005 * report.bytes_to_robot
    # What is counted as not to be noticed is little beside what was noticed, or healed.
    assert report.executed > 0.6 * report.wire_commands
    assert report.recoveries > 0
    assert report.table().startswith(f"soak of {report.robot}\n")


@each_robot
def test_without_noise_nothing_is_wrong(soak_type: type[Soak]) -> None:
    report = random_lives(soak_type, 5, Faults(), 150, 150)
    assert report.robot == soak_type.NAME
    assert report.executed > 0
