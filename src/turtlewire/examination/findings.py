"""What an examination has found out, for people and for programs."""

from __future__ import annotations

import statistics
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from turtlewire.turtle import Pose


class RoundTrip(NamedTuple):
    """How long answers took, from handing over what was sent until the last byte of the answer was there, seconds."""

    median_s: float
    least_s: float
    most_s: float
    times: int

    @classmethod
    def of(cls, times_s: list[float]) -> RoundTrip:
        """Of one measurement or more."""
        return cls(statistics.median(times_s), min(times_s), max(times_s), len(times_s))


class CarFacts(NamedTuple):
    """What is known of a robot that speaks simple.

    ``window``: how many commands, sent at once, were all answered: 8, or 1.
    """

    window: int


class WalterFacts(NamedTuple):
    """What is known of a WALTER.

    Attributes:
        answered, unanswered: the queries of group Q, by their names.
        pose: where it says that it is, in its own coordinates; None: it does not say.
        is_pen_down: None: it does not say.
    """

    answered: tuple[str, ...]
    unanswered: tuple[str, ...]
    pose: Pose | None
    is_pen_down: bool | None


class FrameFacts(NamedTuple):
    """What is known of a robot that speaks frame.

    Attributes:
        crc, coverage: of its frames (F2); empty: none of the catalogue's.
        dialect: the name, or the file, of the one that fits best; empty: none of those that are known.
        messages: how often each message was heard, by its name.
        ignored: frames that this dialect does not know.
        is_dialects_crc: whether crc and coverage are those that the dialect says.
    """

    crc: str
    coverage: str
    dialect: str
    messages: dict[str, int]
    ignored: int
    is_dialects_crc: bool


Facts: TypeAlias = CarFacts | WalterFacts | FrameFacts


class AtRate(NamedTuple):
    """What happened at one rate.

    Attributes:
        baud: the rate; None: a link without rates.
        heard_bytes, answer_bytes: how many bytes came unasked, and after something was sent.
        what: what that means, in words.
    """

    baud: int | None
    heard_bytes: int
    answer_bytes: int
    what: str


class Findings(NamedTuple):
    """What an examination has found out.

    Attributes:
        protocol: simple, frame or walter; empty: none of them was found.
        baud: the rate of the robot, or of a text that something writes; None: not found, or the link has none.
        likelihood: how likely it is, 0 to 1; 1.0: it answered as only this protocol does.
        why: reasons, in words.
        facts: what is known of this protocol's robot.
        round_trip: None: it does not answer.
        first_answer_s: when it answered for the first time, seconds after the port was opened; None: never.
        attempts: how often its rate had been tried until then.
        strange: what else is there, in words, if it is no robot of the three protocols.
        rates: what happened at each rate, in order.
        seconds: how long it took.
        bytes_sent: until it was known what is there.
    """

    protocol: str = ""
    baud: int | None = None
    likelihood: float = 0.0
    why: tuple[str, ...] = ()
    facts: Facts | None = None
    round_trip: RoundTrip | None = None
    first_answer_s: float | None = None
    attempts: int = 0
    strange: str = ""
    rates: tuple[AtRate, ...] = ()
    seconds: float = 0.0
    bytes_sent: int = 0

    def to_json(self) -> dict[str, Any]:
        """All of it, as JSON has it."""
        form: dict[str, Any] = dict(self._asdict())
        form["why"] = list(self.why)
        form["rates"] = [rate._asdict() for rate in self.rates]
        form["round_trip"] = self.round_trip and self.round_trip._asdict()
        form["facts"] = None
        if self.facts is not None:
            form["facts"] = dict(self.facts._asdict())
            pose = form["facts"].get("pose")
            form["facts"] |= {"pose": pose._asdict()} if pose else {}
        return form
