"""How to drive a WALTER, and what can be said of it afterwards."""

from __future__ import annotations

from typing import NamedTuple

from turtlewire.protocols.walter.messages import (
    BAUD,
    DEFAULT_SPEED,
    DEG_PER_S_PER_UNIT,
    MAX_UNFENCED_BYTES,
    MM_PER_S_PER_UNIT,
)


class Settings(NamedTuple):
    """How to drive a WALTER; everything has the default of the protocol's decisions.

    Attributes:
        baud: of the line (W16).
        speed: 1..255, sent at connect.
        mm_per_s_per_unit, deg_per_s_per_unit: calibration of the speed (W14).
        groups: the capability groups (C, Q, H, E) that the robot has; None: learn them (W10).
        gentle: avoid argument bytes 0D and 0A in moves and turns (W8).
        boot_s: how long a robot may take to boot after its port was opened, seconds (section 4).
        reply_timeout_s: how long the answer to the first query may take, seconds.
        require_replies: raise ``NoReplyError`` for a robot that answers nothing, rather than run it as a basic one.
        max_unfenced: bytes, at least 16 (W9).
        heartbeat_s: feed a watchdog so often, seconds; None: never (section 4).
    """

    baud: int = BAUD
    speed: int = DEFAULT_SPEED
    mm_per_s_per_unit: float = MM_PER_S_PER_UNIT
    deg_per_s_per_unit: float = DEG_PER_S_PER_UNIT
    groups: frozenset[str] | None = None
    gentle: bool = True
    boot_s: float = 2.5
    reply_timeout_s: float = 0.5
    require_replies: bool = False
    max_unfenced: int = MAX_UNFENCED_BYTES
    heartbeat_s: float | None = None


class Statistics(NamedTuple):
    """Figures of one connection.

    ``corrections`` counts how often the robot was not where it should be, or answers were lost, and it was asked (W15).
    ``seconds`` is the time since the connection was made, by the link's clock: a simulated robot's own.
    """

    commands: int
    bytes_sent: int
    bytes_received: int
    distance_mm: float
    fences: int
    fences_lost: int
    corrections: int
    malformed_replies: int
    unexpected_replies: int
    seconds: float


DEFAULTS = Settings()
