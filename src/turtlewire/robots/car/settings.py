"""How to drive a car, and what can be said of it afterwards."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

from turtlewire.errors import UsageError
from turtlewire.protocols.simple.messages import BAUD, MAX_WINDOW
from turtlewire.robots.calibration import CarCalibration


class Settings(NamedTuple):
    """How to drive a car; everything has the default of the protocol's decisions.

    Attributes:
        baud: of the line (S6).
        calibration: what the car makes of the numbers on its wire.
        speed: 1..255, of the turtle's moves and turns; 255 is as fast as the car can.
        turn: how the turtle turns. ``"spot"``: a multi-point turn, back and forth, that keeps the place. ``"arc"``:
            ahead in the narrowest circle; the place changes.
        turn_space_mm: how far from its place the car may get in a multi-point turn, above 0.
        tolerance_mm: how far the car may be off to the side, by reckoning, before it turns to make that good.
        pen_light: show the turtle's pen by the lower headlights: a car has none.
        window: how many commands may be under way, 1 to 8 (S9).
        reply_delay_s: how long a reply may take, beyond its bytes' own time (S7).
        retries: how often a set-point that got lost is sent again (S8).
        boot_s: how long the car may take to boot after its port was opened, seconds (section 4).
        heartbeat_s: repeat a set-point so often, for a car with a watchdog, seconds; None: never (section 4).
        reconnect_s: when the link is lost, try for so long to open it again, seconds; 0: never.
    """

    baud: int = BAUD
    calibration: CarCalibration = CarCalibration()
    speed: int = 100
    turn: Literal["spot", "arc"] = "spot"
    turn_space_mm: float = 150.0
    tolerance_mm: float = 1.0
    pen_light: bool = False
    window: int = 1
    reply_delay_s: float = 0.05
    retries: int = 3
    boot_s: float = 2.5
    heartbeat_s: float | None = None
    reconnect_s: float = 30.0

    def checked(self) -> Settings:
        """Return self. Raises ``UsageError`` for a value that cannot drive a car."""
        for name in ("turn_space_mm", "tolerance_mm", "reply_delay_s", "heartbeat_s"):
            value = getattr(self, name)
            _require(name, value, value is None or 0.0 < value < math.inf, "a number above 0")
        _require("baud", self.baud, 50 <= self.baud <= 4_000_000, "from 50 to 4000000")
        _require("speed", self.speed, 1 <= self.speed <= 255, "from 1 to 255")
        _require("turn", self.turn, self.turn in ("spot", "arc"), "spot or arc")
        _require("window", self.window, 1 <= self.window <= MAX_WINDOW, f"from 1 to {MAX_WINDOW}")
        _require("retries", self.retries, 0 <= self.retries <= 1000, "from 0 to 1000")
        for name in ("boot_s", "reconnect_s"):
            value = getattr(self, name)
            _require(name, value, 0.0 <= value < math.inf, "0 or more seconds")
        return self


def _require(name: str, value: object, fine: bool, wanted: str) -> None:
    if not fine:
        raise UsageError(f"the setting {name} is {value}, but must be {wanted}")


class Statistics(NamedTuple):
    """Figures of one connection.

    ``window_commands`` may be under way without a reply (S9). ``retries`` counts set-points to be sent again because
    their fate was not known (S8), ``resynchronisations`` how often host and car were brought in step (S7), the first
    time included, ``malformed_replies`` bytes that are no reply (and so ``skipped_bytes``), ``unexpected_replies``
    those that reply to nothing. The round trips are those of commands; None: none was answered yet. ``reconnections``
    counts how often the car was reached again after its link was lost.

    ``distance_mm`` is by reckoning, there and back counted. ``seconds`` is the time since the connection was made, by
    the link's clock: a simulated car's own.
    """

    bytes_sent: int
    bytes_received: int
    distance_mm: float
    window_commands: int
    retries: int
    resynchronisations: int
    malformed_replies: int
    unexpected_replies: int
    skipped_bytes: int
    round_trip_median_s: float | None
    round_trip_max_s: float | None
    reconnections: int
    seconds: float


DEFAULTS = Settings()
