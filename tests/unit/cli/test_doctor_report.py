"""What people are told of an examination, for findings that no simulated robot gives."""

from __future__ import annotations

from turtlewire.cli.doctor_report import believed, found, nothing, rate
from turtlewire.examination.findings import (
    AtRate,
    CarFacts,
    Findings,
    FrameFacts,
    RoundTrip,
    WalterFacts,
)

TRIP = RoundTrip(0.02, 0.018, 0.031, 20)
HERE = (AtRate(9600, 0, 2, "simple"),)


def told(findings: Findings) -> str:
    return "\n".join(found(findings))


def test_a_walter_with_a_part_of_group_q() -> None:
    facts = WalterFacts(("pen",), ("heading", "location"), None, is_pen_down=True)
    text = told(Findings("walter", 9600, 1.0, ("it answers pen",), facts, rates=HERE, attempts=1))
    assert (
        "  answers     pen\n              but not heading, location: it is run as a robot without group Q"
        in text
    )
    assert "  groups      Q: in part" in text
    assert "  pen         down" in text
    assert "pose" not in text
    assert "round trip" not in text


def test_a_car_whose_adapter_is_slow_or_whose_buffer_is_short() -> None:
    car = Findings("simple", 9600, 1.0, ("F", "K"), CarFacts(8), TRIP, 1.9, 3, rates=HERE)
    text = told(car)
    assert "  why         F\n              K" in text
    assert "round trip  20 ms (median of 20; 18 ms to 31 ms)" in text
    assert (
        "window      up to 8: commands that were sent at once were all answered, and worth it here: window = 4"
        in text
    )
    assert "it was heard first 1.9 s after the port was opened: that may reset it" in text
    quick = car._replace(round_trip=RoundTrip(0.009, 0.008, 0.01, 20))
    assert "worth it" not in told(quick)
    assert "window      1: commands that were sent at once were not all answered" in told(
        car._replace(facts=CarFacts(1))
    )


def test_the_boot() -> None:
    car = Findings("simple", 9600, 1.0, facts=CarFacts(8), attempts=1, rates=HERE, first_answer_s=0.6)
    assert "it was there at once" in told(car)
    assert "not known: it was tried at other rates first" in told(car._replace(rates=HERE * 2))
    assert "it was there at once" in told(car._replace(rates=HERE * 2, first_answer_s=0.1))


def test_frames() -> None:
    unknown = FrameFacts("", "", "", {}, 0, is_dialects_crc=False)
    text = told(Findings("frame", 57600, 0.9899, facts=unknown, attempts=1))
    assert text.startswith("found: frame at 57600 baud (99.0% likely)")
    assert "CRC         none of the catalogue's: no driver understands it" in text
    assert "dialect     none that is known" in text
    mine = FrameFacts("CRC-8/ROHC", "seq", "mine.toml", {"status": 4}, 3, is_dialects_crc=False)
    text = told(Findings("frame", 57600, 0.9999, facts=mine, attempts=1))
    assert "(99.9% likely)" in text
    assert "CRC         CRC-8/ROHC from seq" in text
    assert "dialect     mine.toml: it says status 4" in text
    assert "but 3 frames have messages that this dialect does not know" in text
    assert "its CRC is another than this dialect's" in text


def test_nothing() -> None:
    def said(findings: Findings) -> str:
        return "\n".join(nothing(findings, "/dev/ttyUSB0", "turtlewire doctor /dev/ttyUSB0"))

    assert "turtlewire doctor /dev/ttyUSB0 --protocol walter" in said(Findings())
    answering = said(Findings(rates=(AtRate(9600, 0, 3, "something"),)))
    assert "identify /dev/ttyUSB0 --baud auto" in answering
    assert "--protocol" not in answering
    strange = said(Findings(strange="what is sent comes back"))
    assert strange.startswith("no robot was found at /dev/ttyUSB0: what is sent comes back\n")


def test_taken_at_ones_word() -> None:
    assert next(believed(Findings("walter", None))).startswith("taken at your word: walter; nothing")
    text = "\n".join(believed(Findings("frame", 57600, strange="something writes text at 57600 baud")))
    assert "rate        something writes text at 57600 baud" in text


def test_a_rate() -> None:
    assert rate(9600) == "     9600 baud"
    assert rate(None) == "     the link"
