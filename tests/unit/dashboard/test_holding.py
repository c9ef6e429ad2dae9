"""The dead-man's handle, by a clock of the tests."""

from __future__ import annotations

import math

import pytest

from turtlewire.dashboard.holding import Axis, Holding

FIRST_S, HOLD_S = 0.7, 0.25
AHEAD, BACK = (Axis.SPEED, 1), (Axis.SPEED, -1)
LEFT, RIGHT = (Axis.TURN, -1), (Axis.TURN, 1)


def holding(*, combines: bool = True, latched: bool = False, releases: bool = False) -> Holding:
    made = Holding(first_s=FIRST_S, hold_s=HOLD_S, combines=combines, latched=latched)
    made.sees_releases = releases
    return made


def held(one: Holding, now: float) -> tuple[int, int]:
    return one.grip(now)[:2]


def test_nothing_is_held_at_first() -> None:
    one = holding()
    assert held(one, 0.0) == (0, 0)
    assert one.grip(0.0).until == -math.inf


def test_a_key_counts_until_it_should_have_repeated_and_then_from_repetition_to_repetition() -> None:
    one = holding()
    one.press("w", *AHEAD, 10.0)
    assert held(one, 10.69) == (1, 0)
    assert held(one, 10.7) == (0, 0)
    one.press("w", *AHEAD, 20.0)
    one.press("w", *AHEAD, 20.5)  # the first repetition, after a pause
    assert one.grip(20.5).until == pytest.approx(20.75)
    for n in range(1, 30):
        one.press("w", *AHEAD, 20.5 + n / 30.0)
        assert held(one, 20.5 + n / 30.0) == (1, 0)
    last = 20.5 + 29 / 30.0
    assert held(one, last + 0.24) == (1, 0)
    assert held(one, last + 0.26) == (0, 0)
    assert one.grip(last).number == 2  # two presses, and repetitions


def test_a_key_that_turns_makes_an_arc_of_a_drive_and_one_that_drives_ends_it() -> None:
    one = holding()
    one.press("w", *AHEAD, 0.0)
    one.press("w", *AHEAD, 0.5)
    one.press("a", *LEFT, 0.6)  # from now on only this one repeats
    assert held(one, 1.2) == (1, -1)
    one.press("a", *LEFT, 1.2)
    assert held(one, 1.4) == (1, -1)
    one.press("w", *AHEAD, 1.42)
    assert held(one, 1.43) == (1, 0)
    one.press("d", *RIGHT, 1.5)
    one.press("a", *LEFT, 1.6)
    assert held(one, 1.6) == (1, -1)
    assert held(one, 2.31) == (0, 0)
    one.press("a", *LEFT, 5.0)
    assert held(one, 5.0) == (0, -1)
    one.press("s", *BACK, 5.1)
    assert held(one, 5.1) == (-1, 0)


def test_a_robot_that_does_one_at_a_time_does_the_newest() -> None:
    one = holding(combines=False)
    one.press("a", *AHEAD, 0.0)
    one.press(",", *LEFT, 0.1)
    assert held(one, 0.1) == (0, -1)
    one.press("z", *BACK, 0.2)
    assert held(one, 0.2) == (-1, 0)


@pytest.mark.parametrize("releases", [False, True])
def test_what_was_let_go_of_does_not_begin_again_by_repetitions(releases: bool) -> None:
    one = holding(releases=releases)
    one.press("w", *AHEAD, 0.0)
    one.press("w", *AHEAD, 0.5)
    one.let_go(0.52)
    assert held(one, 0.53) == (0, 0)
    now = 0.53
    for _ in range(40):
        if releases:
            one.repeat("w", now)
        else:
            one.press("w", *AHEAD, now)
        assert held(one, now) == (0, 0)
        now += 0.033
    one.press("s", *BACK, now)  # another key does
    assert held(one, now) == (-1, 0)
    one.let_go(now)
    one.press("w", *AHEAD, now + HOLD_S)
    assert held(one, now + HOLD_S) == (1, 0)


def test_a_key_that_was_let_go_of_and_released_may_begin_at_once() -> None:
    one = holding(releases=True)
    one.press("w", *AHEAD, 0.0)
    one.let_go(0.1)
    one.release("w", 0.15)
    one.press("w", *AHEAD, 0.2)
    assert held(one, 0.2) == (1, 0)
    assert one.grip(0.2).number == 2


def test_with_releases_what_is_held_is_known_exactly() -> None:
    one = holding(releases=True)
    one.press("w", *AHEAD, 0.0)
    one.press("a", *LEFT, 0.1)
    one.press("d", *RIGHT, 0.2)
    assert held(one, 0.2) == (1, 1)  # the later one counts
    one.release("d", 0.3)
    assert held(one, 0.3) == (1, -1)
    one.release("a", 0.4)
    assert held(one, 0.4) == (1, 0)
    one.release("x", 0.4)
    one.press("s", *BACK, 0.45)
    assert held(one, 0.45) == (-1, 0)
    one.release("s", 0.5)
    assert held(one, 0.5) == (1, 0)
    one.release("w", 0.5)
    assert held(one, 0.5) == (0, 0)
    one.press("w", *AHEAD, 1.0)
    one.press("a", *LEFT, 1.1)
    one.release("a", 1.2)  # a sign of life as any other
    assert one.grip(1.2).until == pytest.approx(1.45)


def test_with_releases_one_at_a_time_goes_back_to_what_is_held_still() -> None:
    one = holding(combines=False, releases=True)
    one.press("a", *AHEAD, 0.0)
    one.press(",", *LEFT, 0.1)
    assert held(one, 0.1) == (0, -1)
    one.release(",", 0.2)
    assert held(one, 0.2) == (1, 0)


def test_a_terminal_that_tells_releases_has_to_answer() -> None:
    one = holding(releases=True)
    one.press("w", *AHEAD, 0.0)
    now = 0.0
    for _ in range(50):
        now += 0.1
        one.answered(now)
        assert held(one, now) == (1, 0)
    assert held(one, now + 0.24) == (1, 0)
    assert held(one, now + 0.26) == (0, 0)
    one.answered(now + 0.3)  # too late: only a key begins anything
    one.repeat("w", now + 0.3)
    assert held(one, now + 0.3) == (0, 0)
    one.press("w", *AHEAD, now + 0.4)
    one.repeat("w", now + 0.9)
    assert held(one, now + 1.1) == (1, 0)


def test_a_terminal_that_tells_no_releases_answers_nothing_that_counts() -> None:
    one = holding()
    one.press("w", *AHEAD, 0.0)
    one.answered(0.6)
    assert held(one, 0.75) == (0, 0)


def test_latched_it_goes_on_until_something_else() -> None:
    for releases in (False, True):
        one = holding(latched=True, releases=releases)
        one.press("w", *AHEAD, 0.0)
        one.press("w", *AHEAD, 0.5)
        one.release("w", 0.6)
        one.answered(0.7)
        one.repeat("w", 0.8)
        assert held(one, 1e6) == (1, 0)
        assert one.grip(1.0).until == math.inf
        assert one.grip(1.0).number == 1
        one.press("a", *LEFT, 2.0)
        assert held(one, 2.0) == (1, -1)
        one.press("w", *AHEAD, 3.0)
        assert held(one, 3.0) == (1, 0)
        one.press("s", *BACK, 4.0)
        assert held(one, 4.0) == (-1, 0)
        one.let_go(5.0)
        assert held(one, 5.0) == (0, 0)
