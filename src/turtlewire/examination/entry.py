"""The lines of ``robots.toml`` that follow from what was found."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from turtlewire.examination.findings import CarFacts, FrameFacts, WalterFacts
from turtlewire.examination.probes import BITS

if TYPE_CHECKING:
    from turtlewire.examination.findings import Findings

# What drivers allow for where nobody says otherwise (their settings): an entry says it only if it is not enough.
ENOUGH_BOOT_S = 2.0
ENOUGH_CAR_DELAY_S = 0.025
ENOUGH_WALTER_REPLY_S = 0.25
# A robot that is heard so early has not been reset.
AT_ONCE_S = 0.5
# A reply that came once so late may come twice as late.
MARGIN = 2.0
# S000000, and K.
CAR_EXCHANGE_BYTES = 8


def lines(findings: Findings) -> dict[str, Any]:
    """What an entry of this robot says besides its port, in order."""
    entry: dict[str, Any] = {"protocol": findings.protocol}
    if findings.baud is not None:
        entry["baud"] = findings.baud
    facts, trip = findings.facts, findings.round_trip
    if isinstance(facts, FrameFacts) and facts.dialect:
        entry["dialect"] = facts.dialect
    if isinstance(facts, WalterFacts) and facts.unanswered:
        # The fences need them all (W9): a robot that has some is run as one that has none.
        entry["groups"] = ""
    if trip is not None and isinstance(facts, CarFacts):
        delay_s = trip.most_s - (CAR_EXCHANGE_BYTES * BITS / findings.baud if findings.baud else 0.0)
        if delay_s > ENOUGH_CAR_DELAY_S:
            entry["reply_delay_s"] = round(MARGIN * delay_s, 3)
    if trip is not None and isinstance(facts, WalterFacts) and trip.most_s > ENOUGH_WALTER_REPLY_S:
        entry["reply_timeout_s"] = round(MARGIN * trip.most_s, 2)
    boot_s = boot_time_s(findings)
    if boot_s is not None and boot_s > ENOUGH_BOOT_S:
        entry["boot_s"] = math.ceil(2.0 * boot_s + 1.0) / 2.0
    return entry


def boot_time_s(findings: Findings) -> float | None:
    """After how many seconds a robot was heard that was not, when its port was opened; None: it was, or nobody knows.

    A robot that was first tried at another rate may have booted long before.
    """
    first_s = findings.first_answer_s
    return first_s if findings.attempts > 1 and first_s is not None and first_s > AT_ONCE_S else None
