"""simple: counting to seven with bytes that mean nothing, then stops, then times."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.examination.findings import CarFacts, Findings, RoundTrip
from turtlewire.examination.probes import PULSES, byte_s, pause_s
from turtlewire.examination.steps import Exchange, Plan, WayOut
from turtlewire.protocols.simple.codec import encode
from turtlewire.protocols.simple.messages import (
    EMERGENCY_STOP,
    LENGTH,
    MAX_WINDOW,
    Accepted,
    Rejected,
    Stop,
)

if TYPE_CHECKING:
    from turtlewire.examination.steps import Heard

ACCEPTED, REJECTED = encode(Accepted()), encode(Rejected())
STOP = encode(Stop())
# How long a reply may take, beyond its bytes' own time: the firmware's own work, and an adapter that gathers.
REPLY_S = 0.15
TIMES = 20
(ZERO, _) = PULSES


def may_be(answers: bytes) -> bool:
    """Whether these can be answers of a robot that speaks simple, to bytes that mean nothing (S4).

    ``K`` is one too: what the bytes completed may have been valid.
    """
    return bool(answers) and set(answers) <= set(ACCEPTED + REJECTED)


def confirmed(baud: int | None) -> Plan[Findings | None]:
    """See whether a robot answers ``F`` to each seventh byte that means nothing, and to no other; then stop it.

    Nothing but zeros is sent until that is so. None if it is not.
    """
    answer = b""
    for _ in range(LENGTH):  # to where a command begins
        if not answer:
            answer = yield from _counted(baud)
    if answer != REJECTED:
        return None
    for number in range(1, LENGTH + 1):
        answer = yield from _counted(baud)
        if answer != (REJECTED if number == LENGTH else b""):
            return None
    yield WayOut(EMERGENCY_STOP)
    times_s: list[float] = []
    for _ in range(TIMES):
        heard = yield from _stopped(STOP, 1, baud)
        if heard.data != ACCEPTED:
            return None
        times_s.append(heard.took_s)
    heard = yield from _stopped(STOP * MAX_WINDOW, MAX_WINDOW, baud)
    return Findings(
        "simple",
        baud,
        1.0,
        (
            f"it answers F to each {LENGTH}th byte that means nothing, and to no other",
            f"it answered K to {TIMES} stops, S000000",
        ),
        CarFacts(MAX_WINDOW if heard.data == ACCEPTED * MAX_WINDOW else 1),
        RoundTrip.of(times_s),
    )


def _counted(baud: int | None) -> Plan[bytes]:
    """What comes back for one zero; with the pause behind it, whatever that was."""
    heard = yield Exchange(ZERO, REPLY_S + 2 * byte_s(baud), bool)
    rest = yield Exchange(b"", pause_s(baud))
    return heard.data + rest.data


def _stopped(data: bytes, replies: int, baud: int | None) -> Plan[Heard]:
    within_s = REPLY_S + (len(data) + replies) * byte_s(baud)
    heard = yield Exchange(data, within_s, lambda heard: len(heard) >= replies)
    return heard
