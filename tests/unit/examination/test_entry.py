"""From findings to the lines of robots.toml."""

from __future__ import annotations

import pytest

from turtlewire.examination.entry import boot_time_s, lines
from turtlewire.examination.findings import CarFacts, Findings, FrameFacts, RoundTrip, WalterFacts
from turtlewire.turtle import HOME

CAR = Findings(
    "simple", 19200, 1.0, facts=CarFacts(8), round_trip=RoundTrip(0.005, 0.004, 0.006, 20), attempts=1
)
QUERIES = ("pen", "heading", "location", "x", "y", "towards")
WALTER = Findings("walter", 9600, 1.0, facts=WalterFacts(QUERIES, (), HOME, is_pen_down=True), attempts=1)


def test_what_drivers_allow_for_anyway_is_not_said() -> None:
    assert lines(CAR) == {"protocol": "simple", "baud": 19200}
    assert lines(WALTER) == {"protocol": "walter", "baud": 9600}
    assert lines(CAR._replace(baud=None)) == {"protocol": "simple"}


def test_a_slow_adapter() -> None:
    # 8 bytes at 19200 take 4.2 ms of the 64.
    slow = CAR._replace(round_trip=RoundTrip(0.05, 0.04, 0.064, 20))
    assert lines(slow)["reply_delay_s"] == pytest.approx(2 * (0.064 - 80 / 19200), abs=0.001)
    assert lines(WALTER._replace(round_trip=RoundTrip(0.2, 0.1, 0.3, 20)))["reply_timeout_s"] == 0.6


def test_a_long_boot() -> None:
    booted = CAR._replace(attempts=3, first_answer_s=2.6)
    assert boot_time_s(booted) == 2.6
    assert lines(booted)["boot_s"] == 3.5
    # Found at another rate: it was there long before.
    assert boot_time_s(CAR._replace(first_answer_s=7.0)) is None
    # A robot that talks may have been there at once, though it was understood late.
    assert boot_time_s(CAR._replace(attempts=2, first_answer_s=0.1)) is None


def test_a_walter_that_answers_some_queries_is_run_as_a_basic_one() -> None:
    some = WALTER._replace(facts=WalterFacts(("pen",), QUERIES[1:], None, is_pen_down=True))
    assert lines(some)["groups"] == ""


def test_a_dialect() -> None:
    facts = FrameFacts("CRC-8/SMBUS", "magic", "/home/me/mine.toml", {"status": 3}, 0, is_dialects_crc=True)
    found = Findings("frame", 115200, 0.999, facts=facts, attempts=1)
    assert lines(found) == {"protocol": "frame", "baud": 115200, "dialect": "/home/me/mine.toml"}


def test_json_has_all_of_it() -> None:
    form = WALTER.to_json()
    assert form["facts"] == {
        "answered": QUERIES,
        "unanswered": (),
        "pose": {"x_mm": 0.0, "y_mm": 0.0, "heading_deg": 0.0},
        "is_pen_down": True,
    }
    assert CAR.to_json()["round_trip"] == {"median_s": 0.005, "least_s": 0.004, "most_s": 0.006, "times": 20}
    assert Findings().to_json()["facts"] is None
