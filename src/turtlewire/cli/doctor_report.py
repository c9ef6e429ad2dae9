"""What people are told of an examination."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.examination.entry import AT_ONCE_S, boot_time_s
from turtlewire.examination.findings import CarFacts, FrameFacts, WalterFacts

if TYPE_CHECKING:
    from collections.abc import Iterator

    from turtlewire.examination.findings import Findings

# Where an adapter that gathers bytes takes longer than the bytes do, a window makes up for it.
SLOW_S = 0.01
NOBODY = """\
  A robot that speaks frame 0.1 never says anything, and neither does a WALTER without the commands marked *: if it is
  one of these, say so, and its entry can be written all the same:
    {command} --protocol frame
    {command} --protocol walter
  Otherwise: is it switched on? Is it this port (turtlewire ports)? Are its RX and TX each connected to the other of the
  adapter, and the grounds to each other? If its rate is none of those above: --baud N."""
STRANGER = """\
  Is it this port (turtlewire ports), and does the robot run a program that speaks one of the three protocols?"""
ANSWERING = """\
  Something answers or talks at some of these rates, so something is there, but at a rate that was not tried (--baud N),
  or with a protocol that is none of the three. turtlewire identify {port} --baud auto listens to it for longer."""


def rate(baud: int | None) -> str:
    """At which rate, at the beginning of a line."""
    return f"{baud:>9} baud" if baud is not None else "     the link"


def found(findings: Findings) -> Iterator[str]:
    """What was found, line by line."""
    where = f" at {findings.baud} baud" if findings.baud is not None else ""
    sure = "certain" if findings.likelihood == 1.0 else f"{min(findings.likelihood, 0.999):.1%} likely"
    yield f"found: {findings.protocol}{where} ({sure})"
    for number, reason in enumerate(findings.why):
        yield _line("why" if not number else "", reason)
    facts, trip = findings.facts, findings.round_trip
    if isinstance(facts, WalterFacts):
        yield from _walter(facts)
    elif isinstance(facts, FrameFacts):
        yield from _frame(facts)
    if trip is not None:
        yield _line(
            "round trip",
            f"{_ms(trip.median_s)} (median of {trip.times}; {_ms(trip.least_s)} to {_ms(trip.most_s)})",
        )
    if isinstance(facts, CarFacts):
        yield from _car(facts, findings)
    yield _line("boot", _boot(findings))


def believed(findings: Findings) -> Iterator[str]:
    """What was not found, but is said to be there."""
    where = f" at {findings.baud} baud" if findings.baud is not None else ""
    yield f"taken at your word: {findings.protocol}{where}; nothing has confirmed it"
    if findings.strange:
        yield _line("rate", findings.strange)
    elif findings.baud is not None:
        yield _line("rate", "nothing has confirmed that either; --baud N says another")


def nothing(findings: Findings, port: str, command: str) -> Iterator[str]:
    """What to do when nothing was found."""
    if findings.strange:
        yield f"no robot was found at {port}: {findings.strange}"
        yield STRANGER
        return
    yield f"no robot was found at {port}"
    if any(at.answer_bytes or at.heard_bytes for at in findings.rates):
        yield ANSWERING.format(port=port)
    else:
        yield NOBODY.format(command=command)


def _walter(facts: WalterFacts) -> Iterator[str]:
    yield _line("answers", ", ".join(facts.answered) or "nothing more")
    if facts.unanswered:
        yield _line("", f"but not {', '.join(facts.unanswered)}: it is run as a robot without group Q")
    yield _line("groups", f"Q: {'in part' if facts.unanswered else 'yes'}")
    yield _line("", "C: not tested, as that would move it; its first such move will tell")
    yield _line("", "H, E: not tested, as that would sound its horn and light its lamp; taken to be there")
    if facts.pose is not None:
        pose = facts.pose
        yield _line(
            "pose", f"x {pose.x_mm:g} mm, y {pose.y_mm:g} mm, heading {pose.heading_deg:g} degrees, by itself"
        )
    if facts.is_pen_down is not None:
        yield _line("pen", "down" if facts.is_pen_down else "up")


def _frame(facts: FrameFacts) -> Iterator[str]:
    if facts.crc:
        yield _line("CRC", f"{facts.crc} from {facts.coverage}")
    else:
        yield _line("CRC", "none of the catalogue's: no driver understands it")
    if not facts.dialect:
        yield _line(
            "dialect", "none that is known: describe its messages (docs/protocols/frame.md), --dialect FILE"
        )
        return
    said = ", ".join(f"{name} {count}" for name, count in facts.messages.items())
    yield _line("dialect", f"{facts.dialect}: it says {said}")
    if facts.ignored:
        yield _line("", f"but {facts.ignored} frames have messages that this dialect does not know")
    if not facts.is_dialects_crc:
        yield _line("", "its CRC is another than this dialect's")


def _car(facts: CarFacts, findings: Findings) -> Iterator[str]:
    if facts.window == 1:
        yield _line("window", "1: commands that were sent at once were not all answered")
        return
    trip = findings.round_trip
    hint = ", and worth it here: window = 4" if trip is not None and trip.median_s > SLOW_S else ""
    yield _line("window", f"up to {facts.window}: commands that were sent at once were all answered{hint}")


def _boot(findings: Findings) -> str:
    boot_s = boot_time_s(findings)
    first_s = findings.first_answer_s
    if boot_s is not None:
        return f"it was heard first {boot_s:.1f} s after the port was opened: that may reset it"
    if first_s is not None and (first_s <= AT_ONCE_S or len(findings.rates) == 1):
        return "it was there at once: opening the port does not reset it"
    return "not known: it was tried at other rates first"


def _ms(seconds: float) -> str:
    return f"{seconds * 1000:.3g} ms"


def _line(name: str, text: str) -> str:
    return f"  {name:<11} {text}"
