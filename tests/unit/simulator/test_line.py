from __future__ import annotations

import math

import pytest

from turtlewire.simulator.line import Line


def arrivals(line: Line) -> list[tuple[float, int]]:
    found = []
    while line.next_s < math.inf:
        found.append((line.next_s, line.read_byte()))
    return found


def test_each_byte_takes_ten_bits_and_waits_for_the_one_before() -> None:
    line = Line(1000)
    line.write(b"ab", 5.0)
    line.write(b"c", 5.015)
    assert arrivals(line) == [(5.01, 97), (5.02, 98), (5.03, 99)]


def test_a_line_that_was_idle_starts_anew() -> None:
    line = Line(1000)
    line.write(b"a", 1.0)
    line.write(b"b", 2.0)
    assert [at for at, _ in arrivals(line)] == [1.01, 2.01]


def test_no_rounding_adds_up_over_a_long_burst() -> None:
    line = Line(9600)
    line.write(bytes(96_000), 0.0)
    assert arrivals(line)[-1][0] == 100.0


def test_reading_gives_what_has_arrived() -> None:
    line = Line(1000)
    line.write(b"abc", 0.0)
    assert line.read(0.0099) == b""
    assert line.read(0.02) == b"ab"
    assert len(line) == 1


@pytest.mark.parametrize(("now", "left"), [(0.0, b"a"), (0.009, b"a"), (0.01, b"ab"), (0.0201, b"abc")])
def test_discarding_keeps_what_has_begun_to_go_out(now: float, left: bytes) -> None:
    line = Line(1000)
    line.write(b"abcd", 0.0)
    line.discard(now)
    assert line.read(1.0) == left


def test_after_discarding_the_line_is_free_when_the_last_byte_is_out() -> None:
    line = Line(1000)
    line.write(b"abcd", 0.0)
    line.discard(0.005)
    line.write(b"x", 0.005)
    assert arrivals(line) == [(0.01, 97), (0.02, 120)]


def test_discarding_nothing_is_fine() -> None:
    line = Line(1000)
    line.discard(3.0)
    assert line.next_s == math.inf


@pytest.mark.parametrize("baud", [None, 0])
def test_without_a_baud_rate_bytes_take_no_time(baud: int | None) -> None:
    line = Line(baud)
    line.write(b"ab", 2.0)
    line.discard(2.0)
    assert line.read(2.0) == b"ab"
