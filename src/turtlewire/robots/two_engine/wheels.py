"""Two wheels, told their speeds in a dialect's own messages: engines by PWM, or wheels in mm/s."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from turtlewire.errors import NotSupportedError, UsageError
from turtlewire.robots.calibration import FULL_PWM
from turtlewire.robots.timed.reckoning import Motion

if TYPE_CHECKING:
    from turtlewire.protocols.frame.dialect import Dialect, Entry
    from turtlewire.protocols.frame.message import FrameMessage
    from turtlewire.robots.calibration import SpeedCurve, TwoEngineCalibration

ENGINES = ("engine_forward", "engine_backward")
SPEEDS = "set_wheel_speeds"


class Told(NamedTuple):
    """What the wheels are told, ahead above 0: PWM -255..255, or mm/s."""

    left: int = 0
    right: int = 0


def field_values(message: FrameMessage) -> dict[str, Any]:
    """The fields of a message by name: classes belong to dialects, what all of them share is names."""
    return dict(zip((field.name for field in message.FIELDS), message.values(), strict=True))


def motion(left_mm_per_s: float, right_mm_per_s: float, track_mm: float) -> Motion:
    """How a robot moves whose wheels turn so fast."""
    return Motion(
        (left_mm_per_s + right_mm_per_s) / 2.0,
        math.degrees((left_mm_per_s - right_mm_per_s) / track_mm),
    )


class Wheels(ABC):
    """How to tell the wheels of one robot."""

    def __init__(self, dialect: Dialect, calibration: TwoEngineCalibration) -> None:
        self._dialect = dialect
        self._calibration = calibration

    @property
    def full_mm_per_s(self) -> float:
        """The speed that both wheels can have."""
        return self._calibration.full_mm_per_s

    @abstractmethod
    def nearest(self, left_mm_per_s: float, right_mm_per_s: float) -> Told:
        """What to tell them for such speeds; their ratio matters more than their size."""

    @abstractmethod
    def portion(self, left: float, right: float) -> Told:
        """What to tell them for parts, -1..1, of their driving range."""

    @abstractmethod
    def motion(self, told: Told) -> Motion:
        """How the robot moves then."""

    @abstractmethod
    def messages(self, told: Told) -> list[FrameMessage]:
        """The messages, which belong in one frame (F9). Raises ``NotSupportedError``."""

    @abstractmethod
    def after(self, told: Told, message: FrameMessage) -> Told | None:
        """What the wheels are told when the robot has carried out a message too; None: it is not about wheels."""


class EngineWheels(Wheels):
    """Engines, forward and backward by PWM. Raises ``UsageError`` for engines that the robot does not have."""

    def __init__(self, dialect: Dialect, calibration: TwoEngineCalibration) -> None:
        super().__init__(dialect, calibration)
        known = {entry.message_type.name(): entry for entry in dialect.entries}
        self._forward, self._backward = (known[name] for name in ENGINES)
        count = dialect.counts.get(self._forward.below, 0)
        for name in ("left_engine", "right_engine"):
            number = getattr(calibration, name)
            if number >= count:
                raise UsageError(
                    f"{name} is {number}, but this robot has {count} engines: numbers begin with 0"
                )

    def nearest(self, left_mm_per_s: float, right_mm_per_s: float) -> Told:
        """The PWM of the left wheel, and that of the right one that goes best with what comes of it."""
        left = self._calibration.left_curve(left_mm_per_s)
        right = self._calibration.right_curve(right_mm_per_s)
        left_pwm = left.pwm(abs(left_mm_per_s))
        ratio = left.speed_mm_per_s(left_pwm) / abs(left_mm_per_s) if left_mm_per_s else 1.0
        right_pwm = right.pwm(abs(right_mm_per_s) * ratio)
        return Told(_signed(left_pwm, left_mm_per_s), _signed(right_pwm, right_mm_per_s))

    def portion(self, left: float, right: float) -> Told:
        """PWM beyond the dead band."""
        curves = self._calibration
        return Told(
            _signed(curves.left_curve(left).portion(abs(left)), left),
            _signed(curves.right_curve(right).portion(abs(right)), right),
        )

    def motion(self, told: Told) -> Motion:
        """By the curves of the calibration."""
        curves = self._calibration
        left, right = curves.left_curve(told.left), curves.right_curve(told.right)
        return motion(_speed(left, told.left), _speed(right, told.right), curves.track_mm)

    def messages(self, told: Told) -> list[FrameMessage]:
        """One for each engine."""
        curves = self._calibration
        left = -told.left if curves.left_reversed else told.left
        right = -told.right if curves.right_reversed else told.right
        return [self.engine(curves.left_engine, left), self.engine(curves.right_engine, right)]

    def engine(self, number: int, speed: int) -> FrameMessage:
        """The message for one engine. Raises ``NotSupportedError`` where it could mean forward, too (F1)."""
        if speed < 0 and not self._backward.is_decoded:
            raise NotSupportedError(
                f"in the dialect {self._dialect.name} both directions of an engine have the same type: the robot "
                "cannot tell backward from forward, so it can neither drive backwards nor turn on the spot"
            )
        return _made(self._forward if speed >= 0 else self._backward, engine_id=number, speed=abs(speed))

    def after(self, told: Told, message: FrameMessage) -> Told | None:
        """An engine of a wheel was told something, or another one."""
        if message.name() not in ENGINES:
            return None
        curves, values = self._calibration, field_values(message)
        speed = -values["speed"] if message.name() == ENGINES[1] else values["speed"]
        if values["engine_id"] == curves.left_engine:
            return told._replace(left=-speed if curves.left_reversed else speed)
        if values["engine_id"] == curves.right_engine:
            return told._replace(right=-speed if curves.right_reversed else speed)
        return None


class SpeedWheels(Wheels):
    """Wheels that keep a speed in whole mm/s by themselves."""

    def __init__(self, dialect: Dialect, calibration: TwoEngineCalibration) -> None:
        super().__init__(dialect, calibration)
        self._entry = next(entry for entry in dialect.entries if entry.message_type.name() == SPEEDS)
        high = min(field.high for field in self._entry.message_type.FIELDS)
        low = max(field.low for field in self._entry.message_type.FIELDS)
        self._most = min(super().full_mm_per_s, high, -low)

    @property
    def full_mm_per_s(self) -> float:
        """The speed that both wheels can have, and the message can carry."""
        return self._most

    def nearest(self, left_mm_per_s: float, right_mm_per_s: float) -> Told:
        """Whole mm/s of the same ratio, and never none where some was wanted."""
        left = _signed(max(1, round(abs(left_mm_per_s))), left_mm_per_s) if left_mm_per_s else 0
        ratio = abs(left / left_mm_per_s) if left_mm_per_s else 1.0
        right = _signed(max(1, round(abs(right_mm_per_s) * ratio)), right_mm_per_s) if right_mm_per_s else 0
        return Told(left, right)

    def portion(self, left: float, right: float) -> Told:
        """Parts of the full speed."""
        return Told(round(left * self._most), round(right * self._most))

    def motion(self, told: Told) -> Motion:
        """As it is told."""
        return motion(told.left, told.right, self._calibration.track_mm)

    def messages(self, told: Told) -> list[FrameMessage]:
        """One for both."""
        return [_made(self._entry, left_mm_per_s=told.left, right_mm_per_s=told.right)]

    def after(self, told: Told, message: FrameMessage) -> Told | None:  # noqa: ARG002 - both are told at once
        """Both were told something."""
        if message.name() != SPEEDS:
            return None
        values = field_values(message)
        return Told(values["left_mm_per_s"], values["right_mm_per_s"])


def wheels(dialect: Dialect, calibration: TwoEngineCalibration) -> Wheels:
    """How to tell the wheels of a robot that speaks a dialect. Raises ``UsageError`` if its messages drive none."""
    known = {entry.message_type.name() for entry in dialect.entries}
    if known.issuperset(ENGINES):
        return EngineWheels(dialect, calibration)
    if SPEEDS in known:
        return SpeedWheels(dialect, calibration)
    raise UsageError(
        f"the dialect {dialect.name} drives no wheels: it has neither {' and '.join(ENGINES)} nor {SPEEDS}"
    )


def _signed(value: int, like: float) -> int:
    return -value if like < 0.0 else value


def _speed(curve: SpeedCurve, pwm: int) -> float:
    return math.copysign(curve.speed_mm_per_s(min(FULL_PWM, abs(pwm))), pwm)


def _made(entry: Entry, **values: int) -> FrameMessage:
    message: FrameMessage = cast("Any", entry.message_type)(**values)
    return message
