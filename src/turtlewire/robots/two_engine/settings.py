"""How to drive a two-engine robot, and what can be said of it afterwards."""

from __future__ import annotations

import math
from typing import NamedTuple

from turtlewire.errors import UsageError
from turtlewire.protocols.frame.dialect import Dialect, shipped
from turtlewire.robots.calibration import TwoEngineCalibration


class Settings(NamedTuple):
    """How to drive a two-engine robot; everything has the default of the protocol's decisions.

    Attributes:
        dialect: the messages, and how many servos and engines there are (F10); None: Serial Protocol 0.1.
        baud: of the line; None: the dialect's (F12).
        calibration: what the robot makes of the numbers on its wire.
        speed: 1..255, of the turtle's moves and turns; 255 is as fast as the robot can.
        tolerance_mm: how far the robot may be off to the side, by reckoning, before it turns to make that good.
        halts: 1 or more; how often the frame that ends a motion is sent, for nobody answers if it gets lost.
        boot_s: how long the robot may take to boot after its port was opened, seconds (section 4): until it is heard,
            or for so long, it is stopped again and again.
        repeat_s: send the latest set-points again at this interval (F6), seconds, for one may get lost; None: never.
        heartbeat_s: send an empty frame whenever nothing was sent for so long (F7), seconds; None: never.
        odometry_s: how long to wait after a motion for the odometry of a dialect that has it, seconds.
        reconnect_s: when the link is lost, try for so long to open it again, seconds; 0: never.
    """

    dialect: Dialect | None = None
    baud: int | None = None
    calibration: TwoEngineCalibration = TwoEngineCalibration()
    speed: int = 100
    tolerance_mm: float = 0.2
    halts: int = 2
    boot_s: float = 2.5
    repeat_s: float | None = 0.2
    heartbeat_s: float | None = None
    odometry_s: float = 0.3
    reconnect_s: float = 30.0

    def checked(self) -> Settings:
        """Return self, with dialect and baud rate filled in. Raises ``UsageError`` for what cannot drive a robot."""
        for name in ("tolerance_mm", "repeat_s", "heartbeat_s", "odometry_s"):
            value = getattr(self, name)
            _require(name, value, value is None or 0.0 < value < math.inf, "a number above 0")
        dialect = self.dialect or shipped("0.1")
        baud = self.baud or dialect.baud
        _require("baud", baud, 50 <= baud <= 4_000_000, "from 50 to 4000000")
        _require("speed", self.speed, 1 <= self.speed <= 255, "from 1 to 255")
        for name in ("boot_s", "reconnect_s"):
            value = getattr(self, name)
            _require(name, value, 0.0 <= value < math.inf, "0 or more seconds")
        _require("halts", self.halts, 1 <= self.halts <= 100, "from 1 to 100")
        return self._replace(dialect=dialect, baud=baud)


def _require(name: str, value: object, fine: bool, wanted: str) -> None:
    if not fine:
        raise UsageError(f"the setting {name} is {value}, but must be {wanted}")


class Statistics(NamedTuple):
    """Figures of one connection.

    ``frames_received``, ``frames_ignored`` and ``frames_lost`` are about what came from the robot;
    ``resynchronisations`` counts how often the beginning of a frame had to be looked for, ``skipped_bytes`` what
    belonged to none, ``corrections`` how often its odometry put the reckoning right, ``reconnections`` how often it was
    reached again after its link was lost. ``repeats`` counts how often the latest set-points were sent again (F6).
    Nothing is answered: there is no window, and no round trip.

    ``distance_mm`` is by reckoning, there and back counted. ``seconds`` is the time since the connection was made, by
    the link's clock: a simulated robot's own.
    """

    bytes_sent: int
    bytes_received: int
    distance_mm: float
    repeats: int
    frames_received: int
    frames_ignored: int
    frames_lost: int
    resynchronisations: int
    skipped_bytes: int
    corrections: int
    reconnections: int
    seconds: float


DEFAULTS = Settings()
