"""A simulated car that speaks ``simple``: driven at the rear, steered at the front.

Its place is the middle of its rear axle, which turns about a point on the axle's line (the bicycle model): with the
front wheels at an angle a, in a circle of radius wheelbase / tan a.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from turtlewire.protocols.simple.messages import BAUD
from turtlewire.protocols.simple.robot import Robot
from turtlewire.simulator.chassis import Wheels
from turtlewire.simulator.drivetrain import Motor, Servo, SpeedCurve
from turtlewire.simulator.rolling import RollingBody, RollingStatistics
from turtlewire.simulator.settings import FULL_PWM, Action, BodySettings
from turtlewire.trace import Trace

if TYPE_CHECKING:
    from turtlewire.protocols.simple.messages import SimpleCommand

__all__ = ["Action", "CarSettings", "RollingStatistics", "SimulatedCar"]

# A wheel at a right angle would not roll.
MAX_LOCK_DEG = 80.0


@dataclass(frozen=True, kw_only=True)
class CarSettings(BodySettings):
    """What a simulated car is like; see ``BodySettings`` too. Raises ``UsageError`` for what makes no car.

    Attributes:
        dead_pwm: 0..254; up to this PWM the motor does not turn.
        mm_per_s_per_pwm: speed for each unit of PWM beyond.
        backward_factor: how fast it is backwards, as a part of that.
        lag_s: the motor's time constant: after so long, 63% of a change of speed has happened; 0: at once.
        coast_s: the same when it is told to stand still; None: as ``lag_s``.
        wheelbase_mm: from the rear axle to the front axle.
        max_lock_deg: above 0, at most 80; the angle of the front wheels at 255.
        trim_deg: the angle of the front wheels at 0, clockwise: how far they are out of true, less than the lock.
        steer_deg_per_s: how fast the front wheels turn; infinite: they are there at once.
        pen_down: whether it draws. simple has no command for a pen.
        extensions: commands of one's own that it answers (S10); they do nothing but show up in ``events``.
    """

    baud: int | None = BAUD
    radius_mm: float = 120.0
    track_mm: float = 130.0
    dead_pwm: int = 40
    mm_per_s_per_pwm: float = 2.5
    backward_factor: float = 1.0
    lag_s: float = 0.0
    coast_s: float | None = None
    wheelbase_mm: float = 160.0
    max_lock_deg: float = 28.0
    trim_deg: float = 0.0
    steer_deg_per_s: float = 300.0
    pen_down: bool = False
    extensions: tuple[type[SimpleCommand], ...] = ()

    @property
    def offset_mm(self) -> float:
        """The disc's middle is half way between the axles."""
        return self.wheelbase_mm / 2.0

    @property
    def curve(self) -> SpeedCurve:
        """PWM to speed."""
        return SpeedCurve(self.dead_pwm, self.mm_per_s_per_pwm, self.backward_factor)

    def wheel_angle_deg(self, steer: float) -> float:
        """The angle of the front wheels, clockwise, at a steering of -255 (left) .. 255 (right)."""
        return self.trim_deg + self.max_lock_deg * steer / FULL_PWM

    def turning_radius_mm(self, steer: float) -> float:
        """The radius of the circle of the rear axle's middle: positive clockwise, infinite straight ahead."""
        tangent = math.tan(math.radians(self.wheel_angle_deg(steer)))
        return self.wheelbase_mm / tangent if tangent else math.inf

    def __post_init__(self) -> None:
        self._require_above_0("mm_per_s_per_pwm", "backward_factor", "wheelbase_mm")
        self._require_0_or_more("lag_s", *["coast_s"] * (self.coast_s is not None))
        self._require("dead_pwm", 0 <= self.dead_pwm < FULL_PWM, f"0 to {FULL_PWM - 1}")
        self._require("steer_deg_per_s", self.steer_deg_per_s > 0.0, "a number above 0, or infinite")
        self._require(
            "max_lock_deg", 0.0 < self.max_lock_deg <= MAX_LOCK_DEG, f"above 0, up to {MAX_LOCK_DEG:g}"
        )
        self._require("trim_deg", abs(self.trim_deg) < self.max_lock_deg, "less than the lock")
        super().__post_init__()


class CarDrivetrain:
    """A motor at the rear axle, a servo at the front one.

    Attributes:
        drive: -255..255, PWM.
        steer: -255 (left) .. 255 (right), PWM.
    """

    can_pivot = False

    def __init__(self, settings: CarSettings) -> None:
        self.settings = settings
        self.drive: float = 0
        self.steer: float = 0
        self.motor = Motor(settings.lag_s, settings.coast_s)
        self.servo = Servo(settings.steer_deg_per_s, settings.wheel_angle_deg(0))

    @property
    def is_settled(self) -> bool:
        """Whether speed and steering are as they were told to be."""
        return self.motor.is_settled and self.servo.is_settled

    @property
    def power(self) -> float:
        """The part, 0..1, of full power that the motor is told to use."""
        return abs(self.drive) / FULL_PWM

    def aim(self, strength: float) -> None:
        """Go for what the set-points ask for."""
        self.motor.set_target(self.settings.curve.speed_mm_per_s(self.drive) * strength)
        self.servo.set_target(self.settings.wheel_angle_deg(self.steer))

    def mean(self, seconds: float) -> Wheels:
        """The mean speed of the rear wheels during the coming time, mm/s."""
        speed = self.motor.mean(seconds)
        if not speed:
            return Wheels(0.0, 0.0)
        half = math.tan(math.radians(self.servo.mean(seconds)))
        half *= self.settings.track_mm / self.settings.wheelbase_mm / 2.0
        return Wheels(speed * (1.0 + half), speed * (1.0 - half))

    def advance(self, seconds: float) -> None:
        """Time has passed."""
        self.motor.advance(seconds)
        self.servo.advance(seconds)


class SimulatedCar(RollingBody[CarSettings]):
    """One car, its line and its time. ``settings`` are its true parameters, for whoever calibrates."""

    def __init__(self, settings: CarSettings | None = None) -> None:
        settings = settings or CarSettings()
        self._rear = CarDrivetrain(settings)
        super().__init__(settings, self._rear)
        self._end = Robot(settings.extensions)
        self._pen_down = settings.pen_down
        # What was drawn, while it is not followed.
        self._followed: Trace | None = None

    @property
    def drive(self) -> int:
        """-255 (full speed backward) .. 255 (full speed forward), as set."""
        return self._end.drive

    @property
    def steer(self) -> int:
        """-255 (full lock left) .. 255 (full lock right), as set."""
        return self._end.steer

    @property
    def lights(self) -> tuple[bool, bool, bool, bool]:
        """Headlights: left upper, left lower, right upper, right lower."""
        return self._end.lights

    @property
    def speed_mm_per_s(self) -> float:
        """How fast its rear wheels turn now; backwards when negative."""
        left, right = self._turned if self._leg else (0.0, 0.0)
        return (left + right) / 2.0

    @property
    def wheels_deg(self) -> float:
        """The angle of its front wheels now, clockwise."""
        return self._rear.servo.at(self._elapsed_s) if self._leg else self._rear.servo.angle

    @property
    def trace(self) -> Trace:
        """Where it truly went, as far as it is followed: see ``follow``."""
        return super().trace if self._followed is None else self._followed

    def follow(self, *, pen_down: bool | None) -> None:
        """From now on its way is drawn as with a pen that is up or down; None: not at all, until it is again.

        A car has no pen. Whoever sees it can draw where it goes, and leave out how it manoeuvres.
        """
        self._draw()
        if pen_down is None:
            if self._followed is None:
                self._followed, self._trace = self._trace, Trace(self.pose)
            return
        if self._followed is not None:
            self._trace, self._followed = self._followed, None
            self._trace.move(self.pose, pen_down=pen_down)
        self._pen_down = pen_down

    def clear_trace(self) -> None:
        """A new sheet."""
        super().clear_trace()
        if self._followed is not None:
            self._followed.pose = self.pose
            self._followed.clear()

    @property
    def _inks(self) -> bool:
        return self._pen_down

    @property
    def _malformed(self) -> int:
        return self._end.malformed

    def _understand(self, byte: int) -> bool:
        replies, commands = self._end.receive_data(bytes([byte]))
        for command in commands:
            self._commands += 1
            self._tell(str(command))
        if commands:
            self._follow()
        if replies:
            self._send(replies)
        return bool(commands)

    def _follow(self) -> None:
        """Let the motors follow the set-points."""
        if (self._rear.drive, self._rear.steer) == (self._end.drive, self._end.steer):
            return
        self._halt()
        self._rear.drive, self._rear.steer = self._end.drive, self._end.steer
        self._set_out()

    def _abandon(self) -> None:
        self._end.stop()
        self._follow()

    def _reset(self) -> None:
        super()._reset()
        self._end = Robot(self.settings.extensions)

    def _is_busy(self) -> bool:
        return bool(self._end.drive or self._end.steer)
