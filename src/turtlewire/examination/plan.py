"""The plan of an examination: listen, then send what cannot move anything, rate by rate, until something is found.

Without clock and wire: it yields steps and is told what came of them. ``pump.carry_out`` does them on a link.

A robot that was reset when its port was opened hears and says nothing while it boots. So the first rate is tried again
and again until the boot must be over; the others come after that, once each.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from turtlewire.examination import of_frame, of_simple, of_walter
from turtlewire.examination.findings import AtRate, Findings, FrameFacts
from turtlewire.examination.listening import (
    FEW_BYTES,
    PAUSE_S,
    Worth,
    followed,
    is_proof,
    is_text,
    unasked,
)
from turtlewire.examination.probes import FLUSH, byte_s, logo_probe, pause_s
from turtlewire.examination.steps import Exchange, Heard, Plan, Tell, Tune

if TYPE_CHECKING:
    from collections.abc import Mapping

    from turtlewire.protocols.frame.dialect import Dialect

# Before anything is sent at a rate. Longer than the pause after which a partial frame is given up (F5).
QUIET_S = 0.25
# How long the answer to the query may take. Longer than that of any robot that is not busy; and it has been stopped.
ANSWER_S = 0.3


class Wanted(NamedTuple):
    """What to examine.

    Attributes:
        bauds: rates to try, in order; (None,) for a link that has none. At least one.
        protocols: what to look for.
        dialects: of frame, by name; where several fit, the first.
        boot_s: how long a robot may take to boot, seconds (section 4).
    """

    bauds: tuple[int | None, ...]
    protocols: frozenset[str]
    dialects: Mapping[str, Dialect]
    boot_s: float = 2.5


def examination(wanted: Wanted) -> Plan[Findings]:
    """Find out what is at the other end."""
    return _Examiner(wanted).whole()


class _OverError(Exception):
    """It is known what is there, and that it is no robot."""


class _Examiner:
    """One examination under way."""

    def __init__(self, wanted: Wanted) -> None:
        self._wanted = wanted
        self._bauds = wanted.bauds
        self._now_s = 0.0
        self._sent = 0
        self._rates: list[AtRate] = []
        self._attempts = 0
        # When something came in first at the rate that is being tried, and at any.
        self._first_s: float | None = None
        self._first_said_s: float | None = None
        self._strange = ""
        self._worth = Worth()
        self._text_baud: int | None = None
        # What came in at the rate that is being tried.
        self._said = self._answers = b""
        # Why the port does not have that rate.
        self._refusal = ""

    def whole(self) -> Plan[Findings]:
        """All of it."""
        try:
            found = yield from self._search()
        except _OverError as over:
            found, self._strange, self._text_baud = None, str(over), None
        if found is None:
            return Findings(
                baud=self._text_baud,
                strange=self._strange,
                rates=tuple(self._rates),
                seconds=self._now_s,
                bytes_sent=self._sent,
            )
        return found._replace(
            first_answer_s=self._first_said_s if found.protocol == "frame" else self._first_s,
            attempts=self._attempts,
            rates=tuple(self._rates),
            seconds=self._now_s,
            bytes_sent=self._sent,
        )

    def _search(self) -> Plan[Findings | None]:
        first, *others = self._bauds
        talked = 0
        while True:
            self._attempts += 1
            found = yield from self._at(first)
            talked = talked + 1 if self._said else 0
            has_booted = self._now_s >= self._wanted.boot_s
            # What says something twice in a row has booted, too.
            if found is not None or has_booted or self._refusal or (talked == 2 and others):
                break
        yield from self._note(first, found)
        if found is not None:
            return found
        has_listened = False
        for baud in (None, *others):
            if talked and not has_listened and len(self._bauds) > 1:
                has_listened = True
                found = yield from self._listen_around()
                if found is not None:
                    return found
            if baud is None or baud not in self._bauds:
                continue
            self._attempts = 1
            found = yield from self._at(baud)
            yield from self._note(baud, found)
            if found is not None:
                return found
            talked = bool(self._said)
        return None

    def _listen_around(self) -> Plan[Findings | None]:
        """Something talks, and it is not understood: listen at each rate, and send nothing."""
        for baud in self._bauds:
            if not (yield from self._begin(baud)):
                continue
            found = yield from self._listen(baud, PAUSE_S)
            yield from self._note(baud, found)
            if found is not None or len(self._bauds) == 1:
                return found
        return None

    # ------------------------------------------------------------------ at one rate

    def _at(self, baud: int | None) -> Plan[Findings | None]:
        """Listen, send what cannot move anything, and see what comes back."""
        if not (yield from self._begin(baud)):
            return None
        found = yield from self._listen(baud, QUIET_S)
        protocols = self._wanted.protocols
        if found is not None or protocols == {"frame"}:
            return found
        yield from self._send_apart(FLUSH, baud)
        yield from self._exchange(Exchange(b"", of_simple.REPLY_S))
        if FLUSH in self._answers:
            raise _OverError(
                "what is sent comes back as it is: that is a modem, or a plug that connects its own two lines"
            )
        if "simple" in protocols and of_simple.may_be(self._answers):
            found = yield from of_simple.confirmed(baud)
        if found is None and "walter" in protocols:
            yield from self._send_apart(logo_probe(baud), baud)
            yield from self._exchange(Exchange(b"", ANSWER_S, of_walter.pen_reply))
            if of_walter.pen_reply(self._answers):
                found = yield from of_walter.confirmed(baud)
        return found

    def _send_apart(self, data: bytes, baud: int | None) -> Plan[None]:
        """Send bytes one by one, so far apart that they are heard one by one at any rate."""
        for byte in data:
            yield from self._exchange(Exchange(bytes([byte]), byte_s(baud) + pause_s(baud)))

    def _exchange(self, exchange: Exchange) -> Plan[None]:
        heard = yield exchange
        self._heard(heard)
        self._sent += len(exchange.data)
        self._answers += heard.data

    def _begin(self, baud: int | None) -> Plan[bool]:
        """Change the rate; whether the port has it."""
        self._said = self._answers = b""
        self._first_s = None
        if baud is None:
            return True
        heard = yield Tune(baud)
        self._now_s, self._refusal = heard.now_s, heard.refusal
        return not heard.refusal

    def _listen(self, baud: int | None, seconds: float) -> Plan[Findings | None]:
        """Hear what is said unasked, and say what it is if that is plain."""
        heard = yield from unasked(seconds)
        if len(heard.data) < FEW_BYTES:
            self._heard(heard)
            return None
        heard, identification = yield from followed(heard)
        self._heard(heard)
        self._said = heard.data
        self._first_said_s = self._first_said_s or self._first_s
        if is_text(self._said):
            # Whatever else is there has the same rate.
            self._bauds, self._text_baud = (baud,), baud
            self._worth = Worth(is_sure=True, is_text=True)
            self._strange = f"something writes text{_at_rate(baud)}: {_excerpt(self._said)}"
            return None
        best = identification.best
        if is_proof(identification) and "frame" in self._wanted.protocols:
            found = yield from of_frame.recognised(baud, best, self._said, self._wanted.dialects)
            is_heard = isinstance(found.facts, FrameFacts) and found.facts.dialect
            if is_heard or best.sender != "host":
                return found
        worth = Worth.of(self._said, identification)
        if identification.is_sure and best.sender == "host" and worth > self._worth:
            # At a wrong rate it may look so, too: only if nothing else is found, that is what it is.
            self._worth = worth
            self._strange = (
                f"what talks there{_at_rate(baud)} is a host that speaks {best.protocol}, and no robot: is this the "
                "other end of somebody's line?"
            )
            if is_proof(identification):
                raise _OverError(self._strange)
        return None

    def _heard(self, heard: Heard) -> None:
        if heard.data and self._first_s is None:
            self._first_s = heard.now_s - heard.took_s + heard.first_s
        self._now_s = heard.now_s

    def _note(self, baud: int | None, found: Findings | None) -> Plan[None]:
        """Keep and tell what came of a rate."""
        said, answers = len(self._said), len(self._answers)
        if found is not None:
            what = found.protocol
        elif self._refusal:
            what = self._refusal
        elif is_text(self._said):
            what = f"text: {_excerpt(self._said)}"
        elif said:
            what = "something talks, but not at this rate, or it is none of the protocols"
        elif answers:
            what = "something answers, but not at this rate, or it is none of the protocols"
        else:
            what = "silence"
        self._rates.append(AtRate(baud, said, answers, what))
        yield Tell(baud, what)


def _at_rate(baud: int | None) -> str:
    return "" if baud is None else f" at {baud} baud"


def _excerpt(text: bytes) -> str:
    """A line or so of it."""
    line = max(text.decode("ascii").splitlines(), key=len)
    return repr(line if len(line) <= 60 else f"{line[:57]}...")
