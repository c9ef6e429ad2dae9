"""What simulated robots are like, and what they can tell about themselves."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.errors import UsageError
from turtlewire.protocols.walter.codec import ALL_GROUPS, Mode
from turtlewire.protocols.walter.messages import BAUD, DEFAULT_SPEED, DEG_PER_S_PER_UNIT, MM_PER_S_PER_UNIT
from turtlewire.simulator.world import TOUCH_MM, World

if TYPE_CHECKING:
    from turtlewire.turtle import Pose

FULL_SPEED = 255
FULL_PWM = 255


@dataclass(frozen=True, kw_only=True)
class BodySettings:
    """What every simulated robot has. Raises ``UsageError`` for a value that makes no robot.

    Attributes:
        baud: of the line, 8N1; None or 0: bytes take no time.
        world: the walls around it.
        start: where it stands on the ground at power-on; None: where the world says. Its odometer says 0, 0, 0.
        seed: of slip and noise.
        slip: 0 <= slip < 1; a wheel loses up to this fraction of its travel on the ground, in each motion.
        noise: the standard deviation, in mm, of a wheel's own travel after one metre; it grows with its square root.
        sag: 0 <= sag < 1; the part of its speed that it has lost when its battery is empty. It loses it evenly.
        battery_s: how many seconds at full speed empty the battery.
        radius_mm: the robot is a disc of this size.
        track_mm: the distance between its wheels.
        boot_s: bytes that arrive before this time are lost.
        watchdog_s: with nothing valid heard for so long, motors stop and the queue is abandoned; None: never.
    """

    baud: int | None = BAUD
    world: World = field(default_factory=World)
    start: Pose | None = None
    seed: int = 0
    slip: float = 0.0
    noise: float = 0.0
    sag: float = 0.0
    battery_s: float = 3600.0
    radius_mm: float = 90.0
    track_mm: float = 140.0
    boot_s: float = 0.0
    watchdog_s: float | None = None

    @property
    def offset_mm(self) -> float:
        """How far the middle of its disc is ahead of the point that is called its place."""
        return 0.0

    @property
    def first_pose(self) -> Pose:
        """Where it stands at power-on."""
        return (self.start or self.world.start).turned(0.0)  # a heading may be given as any number

    def __post_init__(self) -> None:
        self._require_above_0("radius_mm", "track_mm", "battery_s")
        self._require_0_or_more("noise", "boot_s")
        for name in ("slip", "sag"):
            self._require(name, 0.0 <= getattr(self, name) < 1.0, "0 or more and below 1")
        self._require(
            "baud", not self.baud or self.baud > 0, "a number of bits per second, or 0 for no delay"
        )
        self._require("watchdog_s", self.watchdog_s is None or self.watchdog_s > 0.0, "above 0, or none")
        self._require(
            "start", all(map(math.isfinite, self.start or self.world.start)), "a place and a heading"
        )
        start = self.first_pose
        middle = start.moved(self.offset_mm) if self.offset_mm else start
        if self.world.gap(middle.x_mm, middle.y_mm, self.radius_mm) < -TOUCH_MM:
            raise UsageError(
                f"the robot (radius {self.radius_mm:g} mm) does not fit at its start, "
                f"x {start.x_mm:g} mm, y {start.y_mm:g} mm: a wall is in the way"
            )

    def _require_above_0(self, *names: str) -> None:
        for name in names:
            self._require(name, 0.0 < getattr(self, name) < math.inf, "a number above 0")

    def _require_0_or_more(self, *names: str) -> None:
        for name in names:
            self._require(name, 0.0 <= getattr(self, name) < math.inf, "0 or more")

    def _require(self, name: str, holds: bool, what: str) -> None:
        if not holds:
            raise UsageError(f"simulated robot: {name} is {getattr(self, name)!r}, but must be {what}")


@dataclass(frozen=True, kw_only=True)
class Settings(BodySettings):
    """What a simulated WALTER is like; see ``BodySettings`` too. Raises ``UsageError`` for what makes no robot.

    Attributes:
        groups: the groups of ``*`` commands that it has, of C, Q, H and E; a basic robot has none (W10).
        mm_per_s_per_unit: linear speed for each unit of the wire (W14).
        deg_per_s_per_unit: turn rate for each unit of the wire (W14).
        distance_scale: how far it goes for each millimetre that it believes: its wheels are larger than it knows.
        turn_scale: how far it turns for each degree that it believes.
        speed: 0..255, at power-on, for moves and turns.
        pen_down: the pen at power-on.
        pen_s: how long the pen servo takes; a pen that is there already takes no time.
        mode: at power-on (W7).
    """

    groups: frozenset[str] = ALL_GROUPS
    mm_per_s_per_unit: float = MM_PER_S_PER_UNIT
    deg_per_s_per_unit: float = DEG_PER_S_PER_UNIT
    distance_scale: float = 1.0
    turn_scale: float = 1.0
    speed: int = DEFAULT_SPEED
    pen_down: bool = False
    pen_s: float = 0.1
    mode: Mode = Mode.LOGO

    def __post_init__(self) -> None:
        self._require_above_0("mm_per_s_per_unit", "deg_per_s_per_unit", "distance_scale", "turn_scale")
        self._require_0_or_more("pen_s")
        self._require("speed", 0 <= self.speed <= FULL_SPEED, f"0 to {FULL_SPEED}")
        self._require("groups", self.groups <= ALL_GROUPS, "some of C, Q, H and E")
        super().__post_init__()


class Action(NamedTuple):
    """Something that the robot did: when, in seconds of its time, and what (``"started forward ..."``)."""

    time_s: float
    what: str


class Statistics(NamedTuple):
    """What a robot has done since power-on.

    ``commands`` counts what was begun or acted on, keys included; ``malformed`` and ``overflowed`` are what was
    dropped (W6, W9), ``lost_bytes`` what came during the boot; ``distance_mm`` and ``turned_deg`` are by its wheels.
    """

    commands: int
    bytes_in: int
    bytes_out: int
    lost_bytes: int
    malformed: int
    overflowed: int
    refused: int
    limits: int
    watchdog_stops: int
    distance_mm: float
    turned_deg: float
