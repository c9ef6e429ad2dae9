"""WALTER: attention, each query once, then times. Nothing else: C would move it, H sound its horn, E light its lamp."""

from __future__ import annotations

import re

from turtlewire.examination.findings import Findings, RoundTrip, WalterFacts
from turtlewire.examination.probes import byte_s
from turtlewire.examination.steps import Exchange, Plan, WayOut
from turtlewire.protocols.message import KINDS, Decoded
from turtlewire.protocols.walter.codec import ReplyDecoder, encode
from turtlewire.protocols.walter.messages import (
    ATTENTION,
    EMERGENCY_STOP,
    REPLIES,
    LogoCommand,
    PenReply,
    QueryHeading,
    QueryLocation,
    QueryPen,
    QueryTowards,
    QueryX,
    QueryY,
    RobotMessage,
)
from turtlewire.turtle import Pose

QUERIES: tuple[LogoCommand, ...] = (
    QueryPen(),
    QueryHeading(),
    QueryLocation(),
    QueryX(),
    QueryY(),
    QueryTowards(0, 0),
)
# How long an answer may take beyond its bytes' own time, as in the driver's settings.
REPLY_S = 0.5
LONGEST_REPLY = 7
TIMES = 20
# Names of what one query asks for, for people: query_heading -> heading.
PREFIX = "query_"
UNIT_MM = 0.5  # W5


def pen_reply(answers: bytes) -> bool:
    """Whether the answer to QP is among these."""
    return _reply(answers, PenReply) is not None


def confirmed(baud: int | None) -> Plan[Findings]:
    """Stop a WALTER (W7), ask it everything it can be asked, and see how long its answers take."""
    yield WayOut(EMERGENCY_STOP)
    # Late answers, and what is left of the pauses between the bytes.
    yield Exchange(ATTENTION, len(ATTENTION) * byte_s(baud) + REPLY_S / 5)
    replies: dict[str, RobotMessage] = {}
    unanswered: list[str] = []
    for query in QUERIES:
        reply, _ = yield from _asked(query, baud)
        name = query.name().removeprefix(PREFIX)
        if reply is None:
            unanswered.append(name)
        else:
            replies[name] = reply
    times_s: list[float] = []
    for number in range(TIMES):
        # By turns, so that a late answer cannot pass for the next one (W9).
        reply, took_s = yield from _asked(QUERIES[number % 2], baud)
        if reply is not None:
            times_s.append(took_s)
    return Findings(
        "walter",
        baud,
        1.0,
        (f"it answers {', '.join(replies) or 'QP'}, as only WALTER does",),
        WalterFacts(tuple(replies), tuple(unanswered), _pose(replies), _is_pen_down(replies)),
        RoundTrip.of(times_s) if times_s else None,
    )


def _asked(query: LogoCommand, baud: int | None) -> Plan[tuple[RobotMessage | None, float]]:
    """The answer to one query, and how long it took."""
    wanted, data = REPLIES[type(query)], encode(query)
    heard = yield Exchange(
        data,
        REPLY_S + (len(data) + LONGEST_REPLY) * byte_s(baud),
        lambda heard: _reply(heard, wanted) is not None,
    )
    return _reply(heard.data, wanted), heard.took_s


def _reply(answers: bytes, wanted: type[RobotMessage]) -> RobotMessage | None:
    """The reply of a kind among what came. Behind a piece of something else it stands all the same."""
    size = sum(KINDS[field.kind][0] for field in wanted.FIELDS)
    for match in re.finditer(rb"(?s)%b.{%d}\r" % (wanted.LETTERS, size), answers):
        for item in ReplyDecoder().receive_data(match[0]):
            if isinstance(item, Decoded) and isinstance(item.message, wanted):
                return item.message
    return None


def _pose(replies: dict[str, RobotMessage]) -> Pose | None:
    if not {"location", "heading"} <= replies.keys():
        return None
    x, y = replies["location"].values()
    (heading_deg,) = replies["heading"].values()
    return Pose(x * UNIT_MM, y * UNIT_MM, float(heading_deg))


def _is_pen_down(replies: dict[str, RobotMessage]) -> bool | None:
    return bool(replies["pen"].values()[0]) if "pen" in replies else None
