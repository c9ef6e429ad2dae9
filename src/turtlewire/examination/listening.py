"""Listening, at one rate and at all of them: what something says unasked, and what that is. Nothing is sent."""

from __future__ import annotations

import math
from typing import NamedTuple

from turtlewire.examination.steps import Exchange, Heard, Plan, Tell, Tune
from turtlewire.protocols.identify import Identification, identify

# How long something that talks is listened to; as long again if what it says is promising.
TALK_S = 1.0
# Where something is known to talk, how long to wait for it at each rate.
PAUSE_S = 0.6
# More than this of anything is not needed.
ENOUGH_BYTES = 4096
# Fewer bytes than these are noise: an adapter that is switched on makes one or two.
FEW_BYTES = 3
# Text of this length that is readable was heard at its own rate; mostly letters, digits and blanks, of several kinds.
# What is repeated again and again may look like a few printable characters at a wrong one.
TEXT_BYTES = 24
TEXT_PART = 0.7
TEXT_LETTERS = 5
READABLE = frozenset(range(0x20, 0x7F)) | frozenset(b"\r\n\t")
WORDS = frozenset(byte for byte in READABLE if chr(byte).isalnum() or chr(byte).isspace())


def unasked(seconds: float) -> Plan[Heard]:
    """What is said meanwhile."""
    heard = yield Exchange(b"", seconds, lambda data: len(data) >= ENOUGH_BYTES)
    return heard


def followed(heard: Heard) -> Plan[tuple[Heard, Identification]]:
    """Something talks: what it says with that which comes next, and what all of it is."""
    heard = yield from _more(heard)
    identification = identify(heard.data)
    if not identification.is_sure and identification.best.protocol != "none":
        heard = yield from _more(heard)
        identification = identify(heard.data)
    return heard, identification


def _more(heard: Heard) -> Plan[Heard]:
    more = yield from unasked(TALK_S)
    return heard._replace(now_s=more.now_s, data=heard.data + more.data, took_s=heard.took_s + more.took_s)


def is_text(data: bytes) -> bool:
    """Whether this is text that people can read, and enough of it to be sure."""
    if len(data) < TEXT_BYTES or not READABLE.issuperset(data):
        return False
    letters = {byte for byte in data if chr(byte).isalpha()}
    return len(letters) >= TEXT_LETTERS and sum(byte in WORDS for byte in data) >= TEXT_PART * len(data)


class Worth(NamedTuple):
    """How much it tells what was heard at a rate, in order. At a wrong one, too, it may look like something."""

    is_sure: bool = False
    is_text: bool = False
    gained_bits: float = -math.inf
    size: int = 0

    @classmethod
    def of(cls, data: bytes, identification: Identification) -> Worth:
        """Of what was heard, and what that is."""
        return cls(identification.is_sure, is_text(data), identification.gained_bits, len(data))


def is_proof(identification: Identification) -> bool:
    """Whether the rate is right beyond doubt: by chance, no checksum fits so often."""
    return identification.is_sure and identification.best.protocol == "frame"


class Listening:
    """Listens at one rate after the other, round by round, until it is sure at one.

    Args:
        bauds: the rates; (None,) for a link that has none.
        seconds: how long at most.

    Attributes:
        baud: at which rate most was understood up to now.
        data: what was heard there.
    """

    def __init__(self, bauds: tuple[int | None, ...], seconds: float) -> None:
        self._bauds = bauds
        self._seconds = seconds
        self._worth = Worth()
        self._is_proven = False
        self.baud = bauds[0]
        self.data = b""

    def plan(self) -> Plan[None]:
        """The plan; what has come of it stands in ``baud`` and ``data`` at any time."""
        now_s = 0.0
        while True:
            for baud in self._bauds:
                now_s = yield from self._at(baud, self._seconds - now_s)
                if self._is_proven or now_s >= self._seconds:
                    return
            if self._worth.is_sure:
                return

    def _at(self, baud: int | None, seconds: float) -> Plan[float]:
        """Listen at one rate; the time when that was done."""
        if baud is not None:
            tuned = yield Tune(baud)
            if tuned.refusal:
                yield Tell(baud, tuned.refusal)
                # A port that refuses all rates must not keep this from coming to its end.
                heard = yield Exchange(b"", min(PAUSE_S, seconds))
                return heard.now_s
        heard = yield from unasked(min(PAUSE_S, seconds))
        worth = Worth(size=len(heard.data))
        if len(heard.data) >= FEW_BYTES:
            heard, identification = yield from followed(heard)
            worth = Worth.of(heard.data, identification)
            self._is_proven = is_proof(identification)
            yield Tell(baud, f"{len(heard.data)} bytes")
        if worth > self._worth:
            self._worth, self.baud, self.data = worth, baud, heard.data
        return heard.now_s
