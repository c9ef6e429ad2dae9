from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from turtlewire.console.setpoints import CLOCKS_DIFFER_S, FRESH_S, LIFE_S, Grips, SetPoint, SetPoints

moments = st.floats(0.0, 10.0)


def point(number: int, *, grip: int = 1, stamp: float = 0.0, age_s: float = 0.0) -> SetPoint:
    return SetPoint(number, grip, 1.0, 0.0, horn=False, stamp=stamp, age_s=age_s)


def test_in_order_and_fresh_they_count() -> None:
    points = SetPoints()
    for number in (1, 2, 5, 6):
        assert points.take(point(number, stamp=number, age_s=0.0), float(number)) == ""
    assert points.dropped == 0


def test_a_later_one_counts_no_earlier_one_after_it() -> None:
    points = SetPoints()
    assert points.take(point(7), 0.0) == ""
    assert points.take(point(6), 0.0) == "order"
    assert points.take(point(7), 0.0) == "order"
    assert points.take(point(8, grip=0), 0.0) == "order"
    assert points.take(point(8), 0.0) == ""
    assert points.dropped == 3


def test_how_old_it_may_be() -> None:
    points = SetPoints()
    assert points.take(point(1, stamp=10.0, age_s=5.0), 15.0 + FRESH_S - 0.001) == ""
    assert points.take(point(2, stamp=10.0, age_s=5.0), 15.0 + FRESH_S + 0.001) == "late"
    # a late one is dropped for good: it does not count when it is said again
    assert points.take(point(2, stamp=16.0, age_s=0.0), 16.0) == "order"


def test_what_was_received_before_it_was_sent() -> None:
    points = SetPoints()
    assert points.take(point(1, stamp=11.0), 10.0) == "clock"
    assert points.take(point(2, stamp=9.0, age_s=1.0 + CLOCKS_DIFFER_S + 0.001), 10.0) == "clock"
    assert points.take(point(3, stamp=9.0, age_s=1.0 + CLOCKS_DIFFER_S - 0.001), 10.0) == ""


@given(st.lists(st.tuples(moments, moments, moments, st.integers(0, 5), st.integers(0, 5))))
def test_none_counts_that_is_older_than_the_limit(
    said: list[tuple[float, float, float, int, int]],
) -> None:
    """A page that had a stamp after ``down``, used it after ``age``, and whose message took ``up``."""
    points, now, numbers = SetPoints(), 0.0, [-1]
    for down, age, up, number, grip in said:
        stamp = now
        now += down + age + up
        why = points.take(point(number, grip=grip, stamp=stamp, age_s=age), now)
        if not why:
            assert up <= FRESH_S + 1e-9
            assert number > numbers[-1]
            numbers.append(number)
        elif why == "late":
            assert down + up > FRESH_S - 1e-9
        else:
            assert why == "order"


def test_grips_of_all_sessions_have_numbers_of_their_own() -> None:
    grips = Grips()
    numbers = []
    for session, grip in ((1, 1), (1, 1), (2, 1), (1, 1), (1, 2)):
        assert grips.hold(session, grip, 0.0)
        numbers.append(grips.number)
    assert numbers == [1, 1, 2, 3, 4]


def test_what_has_ended_drives_no_more() -> None:
    grips = Grips()
    assert grips.ended(1) is None
    assert grips.hold(1, 5, 0.0)
    assert grips.hold(2, 1, 0.0)
    grips.end()
    assert (grips.ended(1), grips.ended(2)) == (5, 1)
    assert not grips.hold(1, 5, 0.0)
    assert not grips.hold(1, 4, 0.0)
    assert not grips.hold(2, 1, 0.0)
    assert grips.hold(1, 6, 0.0)
    assert grips.hold(2, 2, 0.0)
    grips.leave(1)
    assert grips.ended(1) is None


def test_a_grip_that_fell_silent_has_ended() -> None:
    grips = Grips()
    assert grips.hold(1, 1, 0.0)
    assert grips.hold(1, 1, LIFE_S)
    assert not grips.hold(1, 1, 2 * LIFE_S + 0.01)
    assert not grips.hold(1, 1, 2 * LIFE_S + 0.02)
    assert grips.hold(1, 2, 2 * LIFE_S + 0.03)


def test_a_new_grip_is_known() -> None:
    grips = Grips()
    assert grips.is_new(1, 0)
    grips.hold(1, 0, 0.0)
    assert not grips.is_new(1, 0)
    assert grips.is_new(1, 1)
    assert grips.is_new(2, 0)
