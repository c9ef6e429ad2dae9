"""How long answers take, as a bug report has it."""

from __future__ import annotations

from turtlewire.protocols.round_trips import KEPT, RoundTrips


def test_what_never_came_took_no_time() -> None:
    trips = RoundTrips()
    assert (trips.median_s, trips.longest_s) == (None, None)


def test_the_median_and_the_longest() -> None:
    trips = RoundTrips()
    for seconds in (0.3, 0.1, 9.0, 0.2, 0.0):
        trips.add(seconds)
    assert (trips.median_s, trips.longest_s) == (0.2, 9.0)


def test_the_median_is_of_late_and_the_longest_of_ever() -> None:
    trips = RoundTrips()
    trips.add(5.0)
    for _ in range(KEPT):
        trips.add(1.0)
    for _ in range(KEPT // 2 + 1):
        trips.add(2.0)
    assert (trips.median_s, trips.longest_s) == (2.0, 5.0)
