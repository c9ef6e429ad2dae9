from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from turtlewire.console.refusals import Refused
from turtlewire.console.wheel import ANSWER_S, IDLE_S, MAX_ASKING, Wheel

if TYPE_CHECKING:
    from collections.abc import Callable

ANNA, BERT, CEES = 1, 2, 3
people = st.sampled_from([ANNA, BERT, CEES])


def refused(code: str, act: Callable[[], object]) -> None:
    with pytest.raises(Refused) as caught:
        act()
    assert caught.value.code == code


@pytest.fixture
def wheel() -> Wheel:
    """Anna's."""
    wheel = Wheel()
    wheel.press(ANNA, 0.0)
    return wheel


def test_the_first_who_presses_drives_and_nobody_else(wheel: Wheel) -> None:
    assert wheel.driver == ANNA
    refused("wheel_held", lambda: wheel.press(BERT, 1.0))
    refused("wheel_held", lambda: wheel.take(BERT, 1.0))
    refused("not_the_driver", lambda: wheel.need(BERT, 1.0))
    wheel.need(ANNA, 1.0)


def test_the_driver_gives_it(wheel: Wheel) -> None:
    wheel.ask(BERT, 1.0)
    wheel.ask(CEES, 2.0)
    refused("not_the_driver", lambda: wheel.give(BERT, None, 2.5))
    wheel.give(ANNA, CEES, 3.0)
    assert wheel.driver == CEES
    assert [asking.session for asking in wheel.asking] == [BERT]
    # the new driver has as long to answer
    wheel.tick(3.0 + ANSWER_S - 0.1)
    assert wheel.driver == CEES
    wheel.tick(3.0 + ANSWER_S)
    assert wheel.driver == BERT


def test_the_driver_keeps_it(wheel: Wheel) -> None:
    wheel.ask(BERT, 1.0)
    wheel.keep(ANNA, None, 2.0)
    wheel.tick(2.0 + ANSWER_S)
    assert wheel.driver == ANNA
    refused("nobody_asks", lambda: wheel.give(ANNA, BERT, 2.0))


def test_without_an_answer_the_asker_has_it(wheel: Wheel) -> None:
    wheel.ask(BERT, 5.0)
    wheel.ask(BERT, 9.0)  # asking again changes nothing
    wheel.active(ANNA, 5.0 + ANSWER_S - 0.1)
    wheel.tick(5.0 + ANSWER_S - 0.1)
    assert wheel.driver == ANNA
    wheel.tick(5.0 + ANSWER_S)
    assert wheel.driver == BERT
    # also when the driver's next set-point is the first to notice it
    refused("not_the_driver", lambda: wheel.need(ANNA, 5.0 + ANSWER_S))


def test_who_does_nothing_for_long_does_not_keep_others_waiting(wheel: Wheel) -> None:
    wheel.active(ANNA, 10.0)
    wheel.active(BERT, 30.0)  # he does not drive: this is nothing of hers
    wheel.ask(BERT, 10.0 + IDLE_S - 0.1)
    assert wheel.driver == ANNA
    wheel.tick(10.0 + IDLE_S)
    assert wheel.driver == BERT
    wheel.ask(CEES, 10.0 + 2 * IDLE_S)
    assert wheel.driver == CEES


def test_a_stop_of_somebody_else_takes_it_away(wheel: Wheel) -> None:
    wheel.ask(CEES, 0.5)
    wheel.stopped(BERT)
    refused("not_the_driver", lambda: wheel.need(ANNA, 0.6))
    refused("wheel_taken_away", lambda: wheel.press(ANNA, 1.0))
    wheel.tick(1.0 + ANSWER_S)
    refused("not_the_driver", lambda: wheel.need(CEES, 1.1 + ANSWER_S))  # she asked before the stop
    wheel.take(ANNA, 2.0 + ANSWER_S)
    assert wheel.driver == ANNA
    wheel.release(ANNA, 20.0)
    wheel.press(ANNA, 21.0)


def test_a_stop_of_ones_own_does_not(wheel: Wheel) -> None:
    wheel.stopped(ANNA)
    refused("not_the_driver", lambda: wheel.need(ANNA, 0.5))
    wheel.press(ANNA, 1.0)
    assert wheel.driver == ANNA


def test_whoever_goes_away_lets_go(wheel: Wheel) -> None:
    wheel.ask(BERT, 1.0)
    wheel.ask(CEES, 1.0)
    wheel.leave(BERT, 2.0)
    wheel.leave(ANNA, 3.0)
    assert wheel.driver == CEES
    wheel.leave(CEES, 4.0)
    wheel.take(BERT, 5.0)


def test_not_everybody_asks_at_once(wheel: Wheel) -> None:
    for session in range(10, 10 + MAX_ASKING):
        wheel.ask(session, 1.0)
    refused("many_ask", lambda: wheel.ask(BERT, 1.0))


class TheWheel(RuleBasedStateMachine):
    """Whatever people do in whatever order: the wheel is held by one of them at most, and always gets free again."""

    def __init__(self) -> None:
        super().__init__()
        self.wheel = Wheel()
        self.now = 0.0
        self.here: set[int] = set()
        self.stopped: set[int] = set()

    @rule(seconds=st.floats(0.0, 40.0))
    def wait(self, seconds: float) -> None:
        self.now += seconds
        before = self.wheel.driver
        asked = [asking.session for asking in self.wheel.asking]
        self.wheel.tick(self.now)
        if self.wheel.driver != before:
            assert self.wheel.driver == asked[0]

    @rule(who=people)
    def press(self, who: int) -> None:
        self.here.add(who)
        before = self.wheel.driver
        try:
            self.wheel.press(who, self.now)
        except Refused:
            assert who in self.stopped or before is not None or self.wheel.driver is not None
            assert self.wheel.driver != who
        else:
            assert self.wheel.driver == who
            assert who not in self.stopped or before == who or self.wheel.driver == who
            self.stopped.discard(who)

    @rule(who=people)
    def take(self, who: int) -> None:
        self.here.add(who)
        try:
            self.wheel.take(who, self.now)
        except Refused:
            assert self.wheel.driver not in (None, who)
        else:
            assert self.wheel.driver == who
            self.stopped.discard(who)

    @rule(who=people)
    def ask(self, who: int) -> None:
        self.here.add(who)
        self.wheel.ask(who, self.now)
        assert self.wheel.driver == who or who in [asking.session for asking in self.wheel.asking]

    @rule(who=people, to=st.none() | people)
    def give(self, who: int, to: int | None) -> None:
        asked = [asking.session for asking in self.wheel.asking]
        try:
            self.wheel.give(who, to, self.now)
        except Refused:
            pass
        else:
            assert self.wheel.driver in asked
            assert to in (None, self.wheel.driver)

    @rule(who=people)
    def keep(self, who: int) -> None:
        try:
            self.wheel.keep(who, None, self.now)
        except Refused:
            pass
        else:
            assert self.wheel.driver == who

    @rule(who=people)
    def leave(self, who: int) -> None:
        self.here.discard(who)
        self.stopped.discard(who)
        self.wheel.leave(who, self.now)

    @rule(who=st.none() | people)
    def stop(self, who: int | None) -> None:
        driver = self.wheel.driver
        self.wheel.stopped(who)
        assert self.wheel.driver is None
        if driver is not None and driver != who:
            self.stopped.add(driver)

    @precondition(lambda self: self.wheel.driver is None)
    @rule(who=people)
    def press_free(self, who: int) -> None:
        """A press takes a free wheel unless somebody else's stop took it from this page."""
        self.here.add(who)
        if who in self.stopped:
            refused("wheel_taken_away", lambda: self.wheel.press(who, self.now))
            assert self.wheel.driver is None
        else:
            self.wheel.press(who, self.now)
            assert self.wheel.driver == who

    @invariant()
    def holds(self) -> None:
        wheel = self.wheel
        asking = [asking.session for asking in wheel.asking]
        self.stopped -= {wheel.driver} if wheel.driver else set()
        assert wheel.barred == self.stopped
        assert wheel.driver is None or wheel.driver in self.here
        assert wheel.driver not in asking
        assert len(set(asking)) == len(asking)
        assert not asking or wheel.driver is not None
        assert all(each.until <= self.now + ANSWER_S for each in wheel.asking)


TheWheel.TestCase.settings = settings(max_examples=60, stateful_step_count=30, deadline=None)
test_whatever_people_do = TheWheel.TestCase
