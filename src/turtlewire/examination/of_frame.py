"""frame: a robot never answers (F11). It shows itself by what it says unasked, if its dialect has it say something."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from turtlewire.examination.findings import Findings, FrameFacts
from turtlewire.examination.steps import Plan, WayOut
from turtlewire.protocols.checksums import Checksum, Coverage, algorithm
from turtlewire.protocols.frame.codec import Frame, FrameDecoder, FrameEncoder
from turtlewire.protocols.frame.dialect import FROM_ROBOT
from turtlewire.protocols.frame.host import stop_bytes

if TYPE_CHECKING:
    from collections.abc import Mapping

    from turtlewire.protocols.frame.dialect import Dialect
    from turtlewire.protocols.identify import Verdict


def recognised(
    baud: int | None, verdict: Verdict, data: bytes, dialects: Mapping[str, Dialect]
) -> Plan[Findings]:
    """Which dialect a robot speaks that was heard, and how to stop it on the way out (F13).

    Args:
        baud: the rate.
        verdict: what identification says of what was heard.
        data: what was heard.
        dialects: those that are known, by name; where several fit, the first.
    """
    crc, coverage = verdict.settings.get("crc", ""), verdict.settings.get("coverage", "")
    best: tuple[int, str, Dialect, Counter[str], int] | None = None
    for name, known in dialects.items() if crc else ():
        dialect = known.configured(crc=crc, coverage=coverage)
        messages, ignored = _read(dialect, data)
        if messages and (best is None or messages.total() > best[0]):
            best = (messages.total(), name, dialect, messages, ignored)
    why = (*verdict.reasons,)
    if best is None:
        facts = FrameFacts(crc, coverage, "", {}, 0, is_dialects_crc=False)
        return Findings("frame", baud, verdict.score, why, facts)
    _, name, dialect, messages, ignored = best
    yield WayOut(stop_bytes(FrameEncoder(dialect)))
    is_dialects = dialects[name].checksum == Checksum(algorithm(crc), Coverage(coverage))
    facts = FrameFacts(crc, coverage, name, dict(messages), ignored, is_dialects)
    return Findings("frame", baud, verdict.score, why, facts)


def _read(dialect: Dialect, data: bytes) -> tuple[Counter[str], int]:
    """The messages that a robot of this dialect says here, and how many of its frames are ignored (F3)."""
    decoder = FrameDecoder(dialect, FROM_ROBOT)
    messages: Counter[str] = Counter()
    for item in (*decoder.receive_data(data), *decoder.end()):
        if isinstance(item, Frame):
            messages.update(message.name() for message in item.messages)
    return messages, decoder.statistics.unknown_type + decoder.statistics.inconsistent
