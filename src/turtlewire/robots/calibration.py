"""Calibration: what a robot makes of the numbers on its wire, as data: PWM to mm/s, steering to radius, pen angles.

Everything has a default, which is what the simulated robots are like. A file names what is different::

    track_mm = 152.0
    pen_down_deg = 25
    [left]
    dead_pwm = 38
    table = [[60, 35.0], [120, 140.0], [255, 330.0]]

``read(TwoEngineCalibration, "robot.toml")`` makes a calibration of it; ``calibrating`` measures one. All of it is
checked; a name that means nothing, a wrong type or a value that makes no robot raises ``DataError``, which says what
and where.
"""

from __future__ import annotations

import math
import tomllib
from bisect import bisect_left
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import msgspec

from turtlewire.errors import DataError
from turtlewire.protocols.walter.messages import DEG_PER_S_PER_UNIT, MM_PER_S_PER_UNIT

if TYPE_CHECKING:
    from collections.abc import Mapping

# TOML has no null.
NONE = "none"
FULL_PWM = 255
MAX_SERVO_DEG = 180
# A wheel at a right angle would not roll.
MAX_LOCK_DEG = 80.0


class Calibration(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What all calibrations are: data, that says what is wrong with it."""

    def __post_init__(self) -> None:
        """Raises ``DataError``, also where a program makes one."""
        try:
            self.check()
        except ValueError as error:
            raise DataError(f"{type(self).__name__}: {error}") from None

    def check(self) -> None:
        """Raises ``ValueError`` for a value that makes no robot."""

    def _require(self, name: str, fine: bool, wanted: str) -> None:
        if not fine:
            raise ValueError(f"{name} is {getattr(self, name)!r}, but must be {wanted}")

    def _require_times(self, *names: str) -> None:
        for name in names:
            self._require(name, 0.0 <= getattr(self, name) <= 60.0, "from 0 to 60 seconds")


class SpeedCurve(Calibration, frozen=True, kw_only=True):
    """How fast a PWM makes a wheel.

    Attributes:
        dead_pwm: 0..254; up to this PWM it does not turn.
        mm_per_s_per_pwm: above 0; speed for each unit of PWM beyond, where there is no table.
        table: measured points (PWM, mm/s), both growing, instead of the slope. From the dead band to the first, and
            from one to the next, speed grows evenly; beyond the last it goes on as between the last two.
    """

    dead_pwm: int = 40
    mm_per_s_per_pwm: float = 2.5
    table: tuple[tuple[int, float], ...] = ()

    def check(self) -> None:
        """Raises ``ValueError``."""
        self._require("dead_pwm", 0 <= self.dead_pwm < FULL_PWM, f"from 0 to {FULL_PWM - 1}")
        self._require("mm_per_s_per_pwm", 0.0 < self.mm_per_s_per_pwm < math.inf, "above 0")
        points = ((self.dead_pwm, 0.0), *self.table)
        grows = all(a[0] < b[0] and a[1] < b[1] < math.inf for a, b in pairwise(points))
        self._require("table", grows and points[-1][0] <= FULL_PWM, "points that grow, beyond the dead band")

    @property
    def _points(self) -> tuple[tuple[int, float], ...]:
        """From the dead band's end to full PWM."""
        points = ((self.dead_pwm, 0.0), *self.table)
        if len(points) == 1:
            slope = self.mm_per_s_per_pwm
        else:
            (x0, y0), (x1, y1) = points[-2:]
            slope = (y1 - y0) / (x1 - x0)
        last, speed = points[-1]
        return points if last == FULL_PWM else (*points, (FULL_PWM, speed + slope * (FULL_PWM - last)))

    def speed_mm_per_s(self, pwm: int) -> float:
        """The speed at a PWM of 0..255."""
        points = self._points
        if pwm <= self.dead_pwm:
            return 0.0
        i = bisect_left(points, pwm, key=lambda point: point[0])
        (x0, y0), (x1, y1) = points[i - 1], points[i]
        return y0 + (y1 - y0) * (pwm - x0) / (x1 - x0)

    @property
    def full_mm_per_s(self) -> float:
        """The speed at PWM 255."""
        return self.speed_mm_per_s(FULL_PWM)

    def pwm(self, speed_mm_per_s: float) -> int:
        """The PWM, 0..255, whose speed is nearest to a speed of 0 or more; for any above 0 it turns the wheel."""
        if speed_mm_per_s <= 0.0:
            return 0
        points = self._points
        i = bisect_left(points, speed_mm_per_s, key=lambda point: point[1])
        if i == len(points):
            return FULL_PWM
        (x0, y0), (x1, y1) = points[i - 1], points[i]
        return max(self.dead_pwm + 1, round(x0 + (x1 - x0) * (speed_mm_per_s - y0) / (y1 - y0)))

    def portion(self, part: float) -> int:
        """The PWM, 0..255, for a part of the driving range, 0..1: 0 stands still, anything above turns the wheel."""
        return self.dead_pwm + max(1, round(part * (FULL_PWM - self.dead_pwm))) if part > 0.0 else 0


class WalterCalibration(Calibration, frozen=True, kw_only=True):
    """What a WALTER makes of its numbers.

    Attributes:
        mm_per_s_per_unit: above 0; how fast it drives for each unit of speed (W14).
        deg_per_s_per_unit: above 0; how fast it turns for each unit of speed (W14).
        distance_scale: how far it truly goes when it is told to go a millimetre: 0.1 to 10 mm.
        turn_scale: how far it truly turns when it is told to turn a degree: 0.1 to 10 degrees.
    """

    mm_per_s_per_unit: float = MM_PER_S_PER_UNIT
    deg_per_s_per_unit: float = DEG_PER_S_PER_UNIT
    distance_scale: float = 1.0
    turn_scale: float = 1.0

    def check(self) -> None:
        """Raises ``ValueError``."""
        for name in ("mm_per_s_per_unit", "deg_per_s_per_unit"):
            self._require(name, 0.0 < getattr(self, name) < math.inf, "above 0")
        for name in ("distance_scale", "turn_scale"):
            self._require(name, 0.1 <= getattr(self, name) <= 10.0, "from 0.1 to 10")


class CarCalibration(Calibration, frozen=True, kw_only=True):
    """What a car makes of its numbers. Its place is the middle of its rear axle.

    Attributes:
        forward: PWM to speed of the rear axle.
        backward: the same in reverse; None: as forward.
        wheelbase_mm: above 0; from the rear axle to the front axle.
        lock_deg: above 0, at most 80; how far 255 turns the front wheels.
        trim_deg: the angle of the front wheels at 0, clockwise: how far they are out of true, less than the lock.
        steering: measured points (steering -255..255, radius in mm of the rear axle's circle, negative to the left)
            instead of wheelbase, lock and trim; from full left to full right. Between two, curvature grows evenly.
        steer_s: how long the front wheels take from one lock to the other, seconds.
        settle_s: how long the car takes to stand still when the motor is off, seconds.
        overrun_s: how much longer it drives than it is told, coasting less starting late: -1..1 seconds.
    """

    forward: SpeedCurve = SpeedCurve()
    backward: SpeedCurve | None = None
    wheelbase_mm: float = 160.0
    lock_deg: float = 28.0
    trim_deg: float = 0.0
    steering: tuple[tuple[int, float], ...] = ()
    steer_s: float = 0.2
    settle_s: float = 0.05
    overrun_s: float = 0.0

    def check(self) -> None:
        """Raises ``ValueError``."""
        self._require("wheelbase_mm", 0.0 < self.wheelbase_mm < math.inf, "above 0")
        self._require("lock_deg", 0.0 < self.lock_deg <= MAX_LOCK_DEG, f"above 0, at most {MAX_LOCK_DEG:g}")
        self._require("trim_deg", abs(self.trim_deg) < self.lock_deg, "less than the lock")
        self._require("overrun_s", -1.0 <= self.overrun_s <= 1.0, "from -1 to 1")
        self._require_times("steer_s", "settle_s")
        if self.steering:
            whole = all(abs(steer) <= FULL_PWM and radius for steer, radius in self.steering)
            self._require("steering", whole, "of steering -255..255, and no radius is 0")
            points = [(steer, 1.0 / radius) for steer, radius in self.steering]
            grows = all(a[0] < b[0] and a[1] < b[1] for a, b in pairwise(points))
            self._require("steering", grows, "in order from full left to full right")
            self._require("steering", points[0][1] < 0.0 < points[-1][1], "measured to both sides")

    def curve(self, direction: float) -> SpeedCurve:
        """PWM to speed ahead (direction above 0) or back."""
        return self.forward if direction >= 0.0 or self.backward is None else self.backward

    def curvature(self, steer: int) -> float:
        """1 / radius in mm of the rear axle's circle at a steering of -255..255: positive clockwise, 0 is straight."""
        if not self.steering:
            angle_deg = self.trim_deg + self.lock_deg * steer / FULL_PWM
            return math.tan(math.radians(angle_deg)) / self.wheelbase_mm
        points = [(point, 1.0 / radius) for point, radius in self.steering]
        i = min(max(1, bisect_left(points, steer, key=lambda p: p[0])), len(points) - 1)
        (x0, y0), (x1, y1) = points[i - 1], points[i]
        return y0 + (y1 - y0) * (min(max(steer, points[0][0]), points[-1][0]) - x0) / (x1 - x0)

    @property
    def straight(self) -> int:
        """The steering, -255..255, that goes most nearly straight."""
        return min(range(-FULL_PWM, FULL_PWM + 1), key=lambda steer: (abs(self.curvature(steer)), abs(steer)))

    @property
    def turning_radius_mm(self) -> float:
        """The radius of the narrowest circle that it can drive to both sides."""
        return 1.0 / min(self.curvature(FULL_PWM), -self.curvature(-FULL_PWM))


class TwoEngineCalibration(Calibration, frozen=True, kw_only=True):
    """What a robot with an engine for each wheel makes of its numbers. Its place is the middle between its wheels.

    Attributes:
        left, right: speed on the wire to mm/s; a dialect that speaks of mm/s uses only the full speed of it.
        left_backward, right_backward: the same backward; None: as ahead.
        left_engine, right_engine: the engines' numbers, 0..255.
        left_reversed, right_reversed: whether that engine drives ahead when it is told to go backward.
        track_mm: above 0; the distance between the wheels.
        pen_servo: the number of the servo that holds the pen; None, in a file ``"none"``: the robot has no pen.
        pen_up_deg, pen_down_deg: 0..180 degrees, its angles.
        pen_s: how long the pen takes, seconds.
        settle_s: how long the robot takes to stand still when the engines are off, seconds.
        overrun_s: how much longer it drives than it is told, coasting less starting late: -1..1 seconds.
        mm_per_tick: above 0; how far a wheel goes for a tick of its encoder, where the dialect has odometry.
    """

    left: SpeedCurve = SpeedCurve(dead_pwm=30, mm_per_s_per_pwm=1.6)
    right: SpeedCurve = SpeedCurve(dead_pwm=30, mm_per_s_per_pwm=1.6)
    left_backward: SpeedCurve | None = None
    right_backward: SpeedCurve | None = None
    left_engine: int = 0
    right_engine: int = 1
    left_reversed: bool = False
    right_reversed: bool = False
    track_mm: float = 140.0
    pen_servo: int | None = 0
    pen_up_deg: int = 90
    pen_down_deg: int = 30
    pen_s: float = 0.25
    settle_s: float = 0.05
    overrun_s: float = 0.0
    mm_per_tick: float = 0.5

    def check(self) -> None:
        """Raises ``ValueError``."""
        for name in ("left_engine", "right_engine"):
            self._require(name, 0 <= getattr(self, name) <= 255, "from 0 to 255")
        self._require("right_engine", self.left_engine != self.right_engine, "another than the left one")
        for name in ("track_mm", "mm_per_tick"):
            self._require(name, 0.0 < getattr(self, name) < math.inf, "above 0")
        self._require(
            "pen_servo", self.pen_servo is None or 0 <= self.pen_servo <= 255, "from 0 to 255, or none"
        )
        for name in ("pen_up_deg", "pen_down_deg"):
            self._require(name, 0 <= getattr(self, name) <= MAX_SERVO_DEG, f"from 0 to {MAX_SERVO_DEG}")
        self._require("overrun_s", -1.0 <= self.overrun_s <= 1.0, "from -1 to 1")
        self._require_times("pen_s", "settle_s")

    def left_curve(self, direction: float) -> SpeedCurve:
        """Speed on the wire to mm/s of the left wheel, ahead (direction 0 or above) or back."""
        return self.left if direction >= 0.0 or self.left_backward is None else self.left_backward

    def right_curve(self, direction: float) -> SpeedCurve:
        """The same of the right wheel."""
        return self.right if direction >= 0.0 or self.right_backward is None else self.right_backward

    @property
    def full_mm_per_s(self) -> float:
        """The speed that both wheels can have, ahead and back."""
        return min(
            curve(direction).full_mm_per_s
            for curve in (self.left_curve, self.right_curve)
            for direction in (1, -1)
        )


CalibrationT = TypeVar("CalibrationT", bound=Calibration)


# By the protocols of the robots that have one.
KINDS: dict[str, type[Calibration]] = {
    "walter": WalterCalibration,
    "simple": CarCalibration,
    "frame": TwoEngineCalibration,
}


def made(kind: type[CalibrationT], table: Mapping[str, Any], where: str = "calibration") -> CalibrationT:
    """The calibration that a TOML table says; ``where`` is what errors call it. Raises ``DataError``."""
    try:
        return msgspec.convert({key: None if value == NONE else value for key, value in table.items()}, kind)
    except (msgspec.ValidationError, DataError) as error:
        raise DataError(f"{where}: {error}") from None


def parse(kind: type[CalibrationT], text: str, file: str = "calibration") -> CalibrationT:
    """The calibration in a TOML text; ``file`` is what errors call it. Raises ``DataError``."""
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise DataError(f"{file}: {error}") from None
    return made(kind, table, file)


def read(kind: type[CalibrationT], path: str | Path) -> CalibrationT:
    """The calibration in a TOML file. Raises ``DataError``, also if the file cannot be read."""
    try:
        text = Path(path).read_text("utf-8")
    except OSError as error:
        raise DataError(f"{path}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise DataError(f"{path}: this is not UTF-8") from None
    return parse(kind, text, str(path))


def lines(calibration: Calibration) -> dict[str, Any]:
    """What a TOML table says that means this calibration, by name; None: there is no such line."""
    table: dict[str, Any] = {}
    for name in calibration.__struct_fields__:
        value = getattr(calibration, name)
        if isinstance(value, Calibration):
            table[name] = lines(value)
        elif isinstance(value, tuple):
            table[name] = [list(point) for point in value] or None
        else:
            table[name] = NONE if value is None and name == "pen_servo" else value
    return table
