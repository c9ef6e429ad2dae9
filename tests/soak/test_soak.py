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
from tests.soak.wire import ViolationError
from turtlewire.links.faults import Faults
from turtlewire.protocols.frame import host as frame
from turtlewire.protocols.simple import host as simple
from turtlewire.protocols.simple.resynchronise import Resynchronisation
from turtlewire.protocols.walter import host as walter
from turtlewire.robots.two_engine import AsyncTwoEngine
from turtlewire.robots.two_engine.wheels import Told
from turtlewire.robots.walter.whereabouts import Whereabouts

if TYPE_CHECKING:
    from collections.abc import Callable

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


# ------------------------------------------------------------------------------------- would it notice?


def no_cancelling(patch: pytest.MonkeyPatch) -> None:
    """A stop of the car forgets no set-point."""
    patch.setattr(simple.Host, "_cancel", lambda self: None)


def any_reply_will_do(patch: pytest.MonkeyPatch) -> None:
    """The way back into step ends with any answer to its stop."""
    replied = Resynchronisation.replied
    patch.setattr(
        Resynchronisation, "replied", lambda self, now, *, accepted: replied(self, now, accepted=True)
    )


def stale_set_points(patch: pytest.MonkeyPatch) -> None:
    """A two-engine robot is told again what it was told before a stop."""
    stop = frame.Host.emergency_stop

    def remember(self: frame.Host, now: float) -> None:
        latest = dict(self._latest)
        stop(self, now)
        self._latest.update(latest)

    patch.setattr(frame.Host, "emergency_stop", remember)


def a_motion_goes_on(patch: pytest.MonkeyPatch) -> None:
    """Nobody tells the engines that a motion is over."""
    patch.setattr(AsyncTwoEngine, "_halt", lambda self: setattr(self, "_told_wheels", Told()))


def another_order(patch: pytest.MonkeyPatch) -> None:
    """A WALTER gets the last command first."""

    def submit(self: walter.Host, command: Any, duration_s: float = 0.0, tag: object = None) -> None:
        self._queue.appendleft((command, duration_s, tag))

    patch.setattr(walter.Host, "submit", submit)


def answers_say_nothing(patch: pytest.MonkeyPatch) -> None:
    """Nobody looks whether a WALTER is where it should be."""
    patch.setattr(Whereabouts, "compare", lambda self, reply: None)


@pytest.mark.parametrize(
    ("robot", "mistake"),
    [
        ("simple", no_cancelling),
        ("simple", any_reply_will_do),
        ("frame", stale_set_points),
        ("frame", a_motion_goes_on),
        ("walter", another_order),
        ("walter", answers_say_nothing),
    ],
)
def test_a_mistake_of_the_host_is_found(
    monkeypatch: pytest.MonkeyPatch, robot: str, mistake: Callable[[pytest.MonkeyPatch], None]
) -> None:
    mistake(monkeypatch)
    with pytest.raises(ViolationError, match="again: --seed"):
        random_lives(SOAKS[robot], 1, Faults.parse(ONE_PERCENT), 8000, 400)
