"""How to drive a WALTER, and what can be said of it afterwards."""

from __future__ import annotations

import math
from typing import NamedTuple

from turtlewire.errors import UsageError
from turtlewire.protocols.walter.codec import ALL_GROUPS
from turtlewire.protocols.walter.messages import (
    BAUD,
    DEFAULT_SPEED,
    DEG_PER_S_PER_UNIT,
    MAX_UNFENCED_BYTES,
    MM_PER_S_PER_UNIT,
)

# The longest command, a fence, and two more to ask again with.
LEAST_UNFENCED = 16


class Settings(NamedTuple):
    """How to drive a WALTER; everything has the default of the protocol's decisions.

    Attributes:
        baud: of the line (W16).
        speed: 1..255, sent at connect.
        mm_per_s_per_unit, deg_per_s_per_unit: calibration of the speed (W14).
        distance_scale: how far the robot truly goes when it is told to go a millimetre, in mm.
        turn_scale: how far it truly turns when it is told to turn a degree, in degrees.
        groups: the capability groups (C, Q, H, E) that the robot has; None: learn them (W10).
        gentle: avoid argument bytes 0D and 0A in moves and turns (W8).
        boot_s: how long a robot may take to boot after its port was opened, seconds (section 4).
        reply_timeout_s: how long the answer to the first query may take, seconds.
        require_replies: raise ``NoReplyError`` for a robot that answers nothing, rather than run it as a basic one.
        max_unfenced: bytes, at least 16 (W9).
        heartbeat_s: feed a watchdog so often, seconds; None: never (section 4).
        reconnect_s: when the link is lost, try for so long to open it again, seconds; 0: never.
    """

    baud: int = BAUD
    speed: int = DEFAULT_SPEED
    mm_per_s_per_unit: float = MM_PER_S_PER_UNIT
    deg_per_s_per_unit: float = DEG_PER_S_PER_UNIT
    distance_scale: float = 1.0
    turn_scale: float = 1.0
    groups: frozenset[str] | None = None
    gentle: bool = True
    boot_s: float = 2.5
    reply_timeout_s: float = 0.5
    require_replies: bool = False
    max_unfenced: int = MAX_UNFENCED_BYTES
    heartbeat_s: float | None = None
    reconnect_s: float = 30.0

    def checked(self) -> Settings:
        """Return self. Raises ``UsageError`` for a value that cannot drive a robot."""
        positive = ("mm_per_s_per_unit", "deg_per_s_per_unit", "reply_timeout_s", "heartbeat_s")
        for name in positive:
            value = getattr(self, name)
            _require(name, value, value is None or 0.0 < value < math.inf, "a number above 0")
        for name in ("distance_scale", "turn_scale"):
            value = getattr(self, name)
            _require(name, value, 0.1 <= value <= 10.0, "from 0.1 to 10")
        _require("baud", self.baud, 50 <= self.baud <= 4_000_000, "from 50 to 4000000")
        _require("speed", self.speed, 1 <= self.speed <= 255, "from 1 to 255")
        for name in ("boot_s", "reconnect_s"):
            value = getattr(self, name)
            _require(name, value, 0.0 <= value < math.inf, "0 or more seconds")
        _require(
            "max_unfenced",
            self.max_unfenced,
            self.max_unfenced >= LEAST_UNFENCED,
            f"{LEAST_UNFENCED} or more",
        )
        groups = self.groups or frozenset()
        _require("groups", "".join(sorted(groups)), groups <= ALL_GROUPS, "some of C, Q, H and E")
        return self


def _require(name: str, value: object, fine: bool, wanted: str) -> None:
    if not fine:
        raise UsageError(f"the setting {name} is {value}, but must be {wanted}")


class Statistics(NamedTuple):
    """Figures of one connection.

    ``window_bytes`` may be under way without an answer (W9). ``retries`` counts overdue answers that were asked for
    again, ``resynchronisations`` attentions (W7), the first one included, ``malformed_replies`` lines that mean nothing
    and ``skipped_bytes`` what they had of them, ``unexpected_replies`` answers to nothing that was asked. The round
    trips are those of queries sent while nothing else was under way; None: there was none.

    ``corrections`` counts how often the robot was not where it should be, or answers were lost, and it was asked (W15).
    ``reconnections`` counts how often it was reached again after its link was lost.
    ``seconds`` is the time since the connection was made, by the link's clock: a simulated robot's own.
    """

    commands: int
    bytes_sent: int
    bytes_received: int
    distance_mm: float
    window_bytes: int
    fences: int
    fences_lost: int
    retries: int
    resynchronisations: int
    corrections: int
    malformed_replies: int
    unexpected_replies: int
    skipped_bytes: int
    round_trip_median_s: float | None
    round_trip_max_s: float | None
    reconnections: int
    seconds: float


DEFAULTS = Settings()
