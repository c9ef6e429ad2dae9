"""A simulated robot with two engines and servos that speaks ``frame``, in any dialect.

It has a part for the messages of the dialects that ship with turtlewire, by their names: ``engine_forward`` and
``engine_backward`` (engines 0, left, and 1, right), ``set_wheel_speeds``, ``set_servo_position``, ``set_lamp``; and it
sends ``odometry``, ``status`` and ``distance`` if its dialect has them. Of any other message it remembers the last.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from turtlewire.errors import MessageError
from turtlewire.protocols.frame.codec import INTER_BYTE_S
from turtlewire.protocols.frame.dialect import FROM_ROBOT, Dialect, shipped
from turtlewire.protocols.frame.robot import Robot
from turtlewire.simulator.chassis import Wheels
from turtlewire.simulator.drivetrain import Motor, Servo, SpeedCurve
from turtlewire.simulator.rolling import RollingBody, RollingStatistics
from turtlewire.simulator.settings import FULL_PWM, Action, BodySettings
from turtlewire.turtle import direction

if TYPE_CHECKING:
    from turtlewire.protocols.frame.message import FrameMessage

__all__ = ["Action", "FrameRobotSettings", "RollingStatistics", "SimulatedFrameRobot"]

BAUD = 115200  # F12
MAX_SERVO_DEG = 180
NOTHING_IN_SIGHT_MM = 65535
# Half the width of the distance sensor's beam: a ray without any would touch nothing.
BEAM_MM = 0.01
# Status: what the shipped dialect's enumeration calls them.
IDLE, DRIVING, STOPPED = 0, 1, 2


@dataclass(frozen=True, kw_only=True)
class FrameRobotSettings(BodySettings):
    """What such a robot is like; see ``BodySettings`` too. Raises ``UsageError`` for what makes no robot.

    Attributes:
        dialect: its messages, and how many servos and engines it has.
        timeout_s: a partial frame is given up after a pause this long (F5).
        dead_pwm: 0..254; up to this speed on the wire an engine does not turn.
        mm_per_s_per_pwm: speed of a wheel for each unit beyond.
        backward_factor: how fast it is backwards, as a part of that.
        right_factor: what the right engine makes of it, as a part of the left one's: no two engines are the same.
        left_engine, right_engine: the engines' numbers, below how many there are.
        left_reversed, right_reversed: whether that engine drives ahead when it is told to go backward.
        lag_s: the engines' time constant: after so long, 63% of a change of speed has happened; 0: at once.
        coast_s: the same when they are told to stand still; None: as ``lag_s``.
        servo_deg_per_s: how fast servos turn; infinite: they are there at once.
        servo_deg: 0..180, where all servos are at power-on, unless it is the pen's: that one is up.
        pen_servo: the number of the servo that holds the pen; None: it has no pen.
        pen_up_deg: 0..180, the pen servo's angle with the pen up.
        pen_down_deg: 0..180, and with the pen down. In between, the nearer one counts.
        telemetry_s: how often it reports, if its dialect lets it; None: never.
        mm_per_tick: how far a wheel turns for each tick of its encoder.
        battery_v: the voltage of the full battery; it sags as the speed does.
    """

    baud: int | None = BAUD
    dialect: Dialect = field(default_factory=lambda: shipped("0.1"))
    timeout_s: float = INTER_BYTE_S
    dead_pwm: int = 30
    mm_per_s_per_pwm: float = 1.6
    backward_factor: float = 1.0
    right_factor: float = 1.0
    left_engine: int = 0
    right_engine: int = 1
    left_reversed: bool = False
    right_reversed: bool = False
    lag_s: float = 0.0
    coast_s: float | None = None
    servo_deg_per_s: float = 300.0
    servo_deg: float = 90.0
    pen_servo: int | None = 0
    pen_up_deg: float = 90.0
    pen_down_deg: float = 30.0
    telemetry_s: float | None = 0.1
    mm_per_tick: float = 0.5
    battery_v: float = 7.4

    @property
    def curve(self) -> SpeedCurve:
        """The left engine's speed on the wire to mm/s."""
        return SpeedCurve(self.dead_pwm, self.mm_per_s_per_pwm, self.backward_factor)

    def __post_init__(self) -> None:
        self._require_above_0("timeout_s", "mm_per_s_per_pwm", "right_factor", "backward_factor")
        self._require_above_0("mm_per_tick", "battery_v")
        self._require_0_or_more("lag_s", *["coast_s"] * (self.coast_s is not None))
        for name in ("left_engine", "right_engine"):
            self._require(name, 0 <= getattr(self, name) <= 255, "from 0 to 255")
        self._require("right_engine", self.left_engine != self.right_engine, "another than the left one")
        self._require("dead_pwm", 0 <= self.dead_pwm < FULL_PWM, f"0 to {FULL_PWM - 1}")
        self._require("servo_deg_per_s", self.servo_deg_per_s > 0.0, "a number above 0, or infinite")
        for name in ("servo_deg", "pen_up_deg", "pen_down_deg"):
            self._require(name, 0.0 <= getattr(self, name) <= MAX_SERVO_DEG, f"0 to {MAX_SERVO_DEG}")
        self._require("pen_down_deg", self.pen_down_deg != self.pen_up_deg, "different from pen_up_deg")
        servos = self.dialect.counts.get("servos", 0)
        self._require(
            "pen_servo",
            self.pen_servo is None or 0 <= self.pen_servo < servos,
            f"one of {servos} servos, or none",
        )
        self._require("telemetry_s", self.telemetry_s is None or self.telemetry_s > 0.0, "above 0, or none")
        super().__post_init__()


class TwoEngines:
    """An engine for each wheel.

    Attributes:
        wanted: what each is told, left and right: -255..255, or mm/s.
        is_speed: whether that is mm/s, which the robot keeps by itself, up to full speed.
    """

    can_pivot = True

    def __init__(self, settings: FrameRobotSettings) -> None:
        self.settings = settings
        self.wanted: tuple[float, float] = (0, 0)
        self.is_speed = False
        self.left = Motor(settings.lag_s, settings.coast_s)
        self.right = Motor(settings.lag_s, settings.coast_s)

    @property
    def is_settled(self) -> bool:
        """Whether both engines have the speed that they were told."""
        return self.left.is_settled and self.right.is_settled

    @property
    def power(self) -> float:
        """The part, 0..1, of full power that they are told to use."""
        full = self.settings.curve.speed_mm_per_s(FULL_PWM) if self.is_speed else FULL_PWM
        return min(1.0, (abs(self.wanted[0]) + abs(self.wanted[1])) / 2.0 / full)

    def aim(self, strength: float) -> None:
        """Go for what they are told, with engines this strong."""
        curve, factor = self.settings.curve, self.settings.right_factor
        left, right = self.wanted
        if self.is_speed:
            full = curve.speed_mm_per_s(FULL_PWM) * strength
            self.left.set_target(max(-full, min(full, left)))
            self.right.set_target(max(-full * factor, min(full * factor, right)))
        else:
            self.left.set_target(curve.speed_mm_per_s(left) * strength)
            self.right.set_target(curve.speed_mm_per_s(right) * strength * factor)

    def mean(self, seconds: float) -> Wheels:
        """The mean speed of the wheels during the coming time, mm/s."""
        return Wheels(self.left.mean(seconds), self.right.mean(seconds))

    def advance(self, seconds: float) -> None:
        """Time has passed."""
        self.left.advance(seconds)
        self.right.advance(seconds)


class SimulatedFrameRobot(RollingBody[FrameRobotSettings]):
    """One robot, its line and its time. ``settings`` are its true parameters, for whoever calibrates.

    Attributes:
        lamp: whether it is on.
        pen_is_down: whether the pen is on the ground.
        last: the last of each message that it has no part for, by its name (``"beep"``).
    """

    def __init__(self, settings: FrameRobotSettings | None = None) -> None:
        settings = settings or FrameRobotSettings()
        self._engines = TwoEngines(settings)
        super().__init__(settings, self._engines)
        self.lamp = False
        self.last: dict[str, FrameMessage] = {}
        self._end = Robot(settings.dialect, settings.timeout_s)
        self._servos = [
            Servo(
                settings.servo_deg_per_s,
                settings.pen_up_deg if number == settings.pen_servo else settings.servo_deg,
            )
            for number in range(settings.dialect.counts.get("servos", 0))
        ]
        self._servos_from_s = [0.0] * len(self._servos)
        self.pen_is_down = False
        self._pen_s = math.inf
        self._stopped = False
        self._reports = self._known_reports()
        self._report_number = 0

    # What is to be seen of it

    @property
    def engines(self) -> tuple[float, float]:
        """What the left and the right engine are told: -255..255, or mm/s if the dialect speaks of speeds."""
        return self._engines.wanted

    @property
    def servos_deg(self) -> tuple[float, ...]:
        """The angles of the servos now."""
        return tuple(s.at(self.now - at) for s, at in zip(self._servos, self._servos_from_s, strict=True))

    @property
    def _inks(self) -> bool:
        return self.pen_is_down

    @property
    def _malformed(self) -> int:
        seen = self._end.statistics
        ignored = seen.oversized + seen.wrong_crc + seen.incomplete + seen.unknown_type + seen.inconsistent
        return ignored + sum(seen.refused.values())

    # Time

    def _next_s(self) -> float:
        return min(self._leg_ends_s, self._pen_s, self._end.next_timeout(), self._report_s())

    def _is_settled(self) -> bool:
        nothing = self._pen_s == self._end.next_timeout() == self._report_s() == math.inf
        return nothing and super()._is_settled()

    def _act(self) -> bool:
        if self._pen_s <= self.now:
            self._pen_has_moved()
        elif super()._act():
            return True
        elif self._end.next_timeout() <= self.now:
            self._carry_out(self._end.receive_data(b"", self.now))
        elif self._report_s() <= self.now:
            self._report()
        else:
            return False
        return True

    def _understand(self, byte: int) -> bool:
        heard = self._end.heard
        self._carry_out(self._end.receive_data(bytes([byte]), self.now))
        return self._end.heard > heard

    def _reset(self) -> None:
        super()._reset()
        self._end = Robot(self.settings.dialect, self.settings.timeout_s)
        self._report_number = 0

    def _is_busy(self) -> bool:
        return any(self._engines.wanted)

    def _abandon(self) -> None:
        self._stopped = True
        self._drive((0, 0), is_speed=self._engines.is_speed)

    # Messages

    def _carry_out(self, messages: list[FrameMessage]) -> None:
        """Messages of one frame take effect together (F9)."""
        wanted, is_speed = self._engines.wanted, self._engines.is_speed
        for message in messages:
            self._commands += 1
            self._tell(str(message))
            # Classes belong to dialects; what all of them share is names.
            values: dict[str, Any] = dict(
                zip((f.name for f in message.FIELDS), message.values(), strict=True)
            )
            match message.name():
                case "engine_forward" | "engine_backward" | "engine_direction_unknown" as name:
                    # F1: where both have one type, a robot cannot tell; its engine turns forward.
                    speed = -values["speed"] if name == "engine_backward" else values["speed"]
                    if is_speed:
                        wanted, is_speed = (0, 0), False
                    wanted = self._with_engine(wanted, values["engine_id"], speed)
                case "set_wheel_speeds":
                    wanted, is_speed = (values["left_mm_per_s"], values["right_mm_per_s"]), True
                case "set_servo_position":
                    self._move_servo(values["servo_id"], values["position_deg"])
                case "set_lamp":
                    self.lamp = bool(values["on"])
                case name:
                    self.last[name] = message
        self._drive(wanted, is_speed=is_speed)

    def _with_engine(self, wanted: tuple[float, float], number: int, speed: float) -> tuple[float, float]:
        """What the wheels are told, with that of one engine changed; another one turns none of them."""
        settings = self.settings
        if number == settings.left_engine:
            return (-speed if settings.left_reversed else speed, wanted[1])
        if number == settings.right_engine:
            return (wanted[0], -speed if settings.right_reversed else speed)
        return wanted

    def _drive(self, wanted: tuple[float, float], *, is_speed: bool) -> None:
        engines = self._engines
        if (wanted, is_speed) == (engines.wanted, engines.is_speed):
            return
        self._stopped = self._stopped and not any(wanted)
        self._halt()
        engines.wanted, engines.is_speed = wanted, is_speed
        self._set_out()

    def _move_servo(self, number: int, angle: float) -> None:
        if number >= len(self._servos):
            return
        servo = self._servos[number]
        servo.advance(self.now - self._servos_from_s[number])
        servo.set_target(angle)
        self._servos_from_s[number] = self.now
        if number == self.settings.pen_servo:
            self._aim_pen(servo)

    # The pen

    def _aim_pen(self, servo: Servo) -> None:
        """When the pen servo passes the middle between up and down, the pen goes up or down."""
        up, down = self.settings.pen_up_deg, self.settings.pen_down_deg
        will_be_down = abs(servo.target - down) < abs(servo.target - up)
        self._pen_s = math.inf
        if will_be_down != self.pen_is_down:
            self._pen_s = self.now + abs((up + down) / 2.0 - servo.angle) / servo.rate

    def _pen_has_moved(self) -> None:
        self._draw()
        self._pen_s = math.inf
        self.pen_is_down = not self.pen_is_down
        self._tell("pen down" if self.pen_is_down else "pen up")

    # Telemetry

    def _known_reports(self) -> list[type[FrameMessage]]:
        known = {"odometry", "status", "distance"}
        return [
            e.message_type
            for e in self.settings.dialect.entries
            if e.goes(FROM_ROBOT) and e.message_type.name() in known
        ]

    def _report_s(self) -> float:
        """When it reports next; times are counted, so that no rounding adds up."""
        if self.settings.telemetry_s is None or not self._reports:
            return math.inf
        return self._booted_s + (self._report_number + 1) * self.settings.telemetry_s

    def _report(self) -> None:
        self._report_number += 1
        messages = []
        for message_type in self._reports:
            values = self._measured(message_type.name())
            wanted = [f.name for f in message_type.FIELDS]
            if set(wanted) <= set(values):
                messages.append(message_type(**{name: values[name] for name in wanted}))
        try:
            self._send(self._end.send(*messages))
        except MessageError as error:  # a dialect of one's own has narrower ranges
            self._tell(f"not reported: {error}")

    def _measured(self, what: str) -> dict[str, Any]:
        settings = self.settings
        if what == "odometry":
            left, right = (_wrapped(math.floor(mm / settings.mm_per_tick)) for mm in self.wheels_mm)
            since_s = self.now - (self._booted_s - settings.boot_s)  # it was switched on, or reset
            return {"time_ms": round(since_s * 1000.0) % 2**32, "left_ticks": left, "right_ticks": right}
        if what == "status":
            state = STOPPED if self._stopped else DRIVING if any(self._engines.wanted) else IDLE
            volts = settings.battery_v * self._battery.level(self.now)
            return {"state": state, "battery_v": volts, "bumper": self.bumper is not None}
        return {"bearing_deg": 0, "distance_mm": self._distance_ahead()}

    def _distance_ahead(self) -> int:
        """What a distance sensor at its front sees: whole millimetres from its rim."""
        here = self.pose
        ahead = direction(here.heading_deg)
        ray = self._surroundings().contact(here.x_mm, here.y_mm, ahead, math.inf, BEAM_MM)
        if ray is None:
            return NOTHING_IN_SIGHT_MM
        from_rim_mm = ray.distance_mm + BEAM_MM - self.settings.radius_mm
        return max(0, min(NOTHING_IN_SIGHT_MM - 1, math.floor(from_rim_mm + 0.5)))


def _wrapped(ticks: int) -> int:
    """As a 32-bit counter counts."""
    return (ticks + 2**31) % 2**32 - 2**31
