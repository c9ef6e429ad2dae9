"""A body on wheels that a host drives by set-points: they hold until changed, and the motors do what they can."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeVar

from turtlewire.simulator.body import Body, last_look_s, next_look_s
from turtlewire.simulator.chassis import Chassis, Wheels, drive
from turtlewire.simulator.drivetrain import Battery
from turtlewire.simulator.leg import Leg, free_s
from turtlewire.simulator.settings import BodySettings
from turtlewire.simulator.walter_commands import sensor

if TYPE_CHECKING:
    from turtlewire.simulator.world import Disc
    from turtlewire.turtle import Pose

# Wheels that slip find another grip once in so many seconds.
GRIP_S = 1.0
S_co = TypeVar("S_co", bound=BodySettings, covariant=True)


class Drivetrain(Protocol):
    """Motors and steering of one robot, and what its wheels make of them."""

    @property
    def is_settled(self) -> bool:
        """Whether everything is where it has been told to be."""

    @property
    def power(self) -> float:
        """The part, 0..1, of full power that it is told to use."""

    @property
    def can_pivot(self) -> bool:
        """Whether it can turn in place when an obstacle holds it."""

    def aim(self, strength: float) -> None:
        """Go for what the set-points ask for, with motors this strong, 0..1."""

    def mean(self, seconds: float) -> Wheels:
        """The mean speed of the wheels during the coming time, mm/s."""

    def advance(self, seconds: float) -> None:
        """Time has passed."""


class RollingStatistics(NamedTuple):
    """What a robot has done since power-on.

    ``commands`` counts messages carried out, ``malformed`` what was not carried out, ``lost_bytes`` what
    came during the boot, ``bumps`` how often it ran into something; ``distance_mm`` and ``turned_deg`` are by its
    wheels.
    """

    commands: int
    bytes_in: int
    bytes_out: int
    lost_bytes: int
    malformed: int
    bumps: int
    watchdog_stops: int
    distance_mm: float
    turned_deg: float


class RollingBody(Body[S_co]):
    """A robot that rolls as its drivetrain says. It is solid: what it runs into holds it until it drives away.

    Attributes:
        bumper: the side that presses into something, ``"front"``, ``"back"``, ``"left"`` or ``"right"``; or None.
    """

    def __init__(self, settings: S_co, drivetrain: Drivetrain) -> None:
        super().__init__(settings)
        self.bumper: str | None = None
        self._drivetrain = drivetrain
        self._chassis = Chassis(
            settings.radius_mm, settings.track_mm, settings.slip, settings.noise, settings.seed
        )
        self._battery = Battery(settings.sag, settings.battery_s)
        self._grip, self._grip_from = (1.0, 1.0), -1
        self._leg: Leg | None = None
        self._leg_from_s = 0.0
        self._leg_ends_s = math.inf
        self._turned = Wheels(0.0, 0.0)  # mm/s, in this leg
        self._drawn_s = 0.0
        self._wheels_mm = Wheels(0.0, 0.0)
        self._commands = self._bumps = 0
        self._distance_mm = self._turned_deg = 0.0

    # What is to be seen of it

    @property
    def is_moving(self) -> bool:
        """Whether the wheels turn."""
        return self._leg is not None and self._turned != (0.0, 0.0)

    @property
    def pose(self) -> Pose:
        """Where it truly is on the ground."""
        return self._leg.pose(self._elapsed_s) if self._leg else self._true

    @property
    def odometer(self) -> Pose:
        """Where it would be by what its wheels have turned."""
        if not self._leg:
            return self._odometer
        return drive(self._odometer, self._turned.times(self._elapsed_s), self.settings.track_mm)

    @property
    def wheels_mm(self) -> Wheels:
        """How far each wheel has turned since power-on, ahead less back."""
        left, right = self._turned.times(self._elapsed_s) if self._leg else (0.0, 0.0)
        return Wheels(self._wheels_mm.left_mm + left, self._wheels_mm.right_mm + right)

    @property
    def rotated_deg(self) -> float:
        """How far its wheels have turned it since power-on, clockwise less counter-clockwise."""
        left, right = self.wheels_mm
        return math.degrees((left - right) / self.settings.track_mm)

    @property
    def statistics(self) -> RollingStatistics:
        """What it has done since power-on, up to now."""
        distance_mm, turned_deg = self._driven() if self._leg else (0.0, 0.0)
        return RollingStatistics(
            self._commands,
            self._bytes_in,
            self._bytes_out,
            self._lost_bytes,
            self._malformed,
            self._bumps,
            self._watchdog_stops,
            self._distance_mm + distance_mm,
            self._turned_deg + turned_deg,
        )

    def claims(self) -> tuple[Disc, ...]:
        """The ground that nobody else may enter now: where it is, and where it is about to be."""
        leg, here, offset = self._leg, self.disc(), self.settings.offset_mm
        if leg is None or self._leg_ends_s == math.inf:
            return (here,)
        there = leg.pose(leg.seconds).moved(offset)
        return (here, here._replace(x_mm=there.x_mm, y_mm=there.y_mm))

    @property
    @abstractmethod
    def _malformed(self) -> int:
        """What was not understood."""

    # Time

    def _next_s(self) -> float:
        return self._leg_ends_s

    def _act(self) -> bool:
        if self._leg_ends_s > self.now:
            return False
        self._set_out()
        return True

    def _is_settled(self) -> bool:
        return self._leg is None or self._drivetrain.is_settled

    @property
    def _elapsed_s(self) -> float:
        """How far the leg is; its end is its end, however its time is rounded."""
        assert self._leg is not None
        return self._leg.seconds if self.now >= self._leg_ends_s else self.now - self._leg_from_s

    def _driven(self) -> tuple[float, float]:
        """What the wheels have driven and turned in this leg."""
        left, right = self._turned.times(self._elapsed_s)
        return abs(left + right) / 2.0, math.degrees(abs(left - right) / self.settings.track_mm)

    def _reset(self) -> None:
        super()._reset()
        self._wheels_mm = Wheels(0.0, 0.0)

    def _halt(self) -> None:
        """The leg under way, if any, ends here."""
        leg = self._leg
        if leg is None:
            return
        if not leg.is_straight:
            self._draw()
        elapsed_s = self._elapsed_s
        distance_mm, turned_deg = self._driven()
        self._true, self._odometer, self._wheels_mm = self.pose, self.odometer, self.wheels_mm
        self._distance_mm += distance_mm
        self._turned_deg += turned_deg
        self._drivetrain.advance(elapsed_s)
        self._leg = None
        self._leg_ends_s = math.inf

    def _set_out(self) -> None:
        """A leg is over, or the set-points have changed: begin the next leg, if there is anything to do."""
        self._halt()
        drivetrain = self._drivetrain
        drivetrain.aim(self._battery.draw(drivetrain.power, self.now))
        look_s = next_look_s(self.now)
        leg: Leg | None = None
        if not drivetrain.is_settled or drivetrain.mean(look_s - self.now) != (0.0, 0.0):
            leg = self._begin(look_s)
        if leg is None or not leg.is_straight:
            self._trace.move(self._true, pen_down=self._inks)
        if leg is not None:
            self._feel(leg)

    def _feel(self, leg: Leg) -> None:
        """The bumper: it stays pressed until the robot has got away, also from what moves off before it."""
        if not leg.held_by:
            self.bumper = self.bumper if leg.contact else None
            return
        was_pressed = self.bumper is not None
        self.bumper = sensor(leg.held_by.bearing_deg - self._true.heading_deg)
        if not was_pressed:
            self._bumps += 1
            self._tell(f"bumped {self.bumper}")

    def _begin(self, look_s: float) -> Leg:
        """Begin a leg."""
        settings, drivetrain, now = self.settings, self._drivetrain, self.now
        until_look_s = look_s - now
        wheels = drivetrain.mean(until_look_s)
        is_even = drivetrain.is_settled and self._chassis.is_ideal and not settings.sag and not self.others
        free_until_s = look_s
        if is_even:
            free_until_s = last_look_s(now + free_s(settings, self._true, wheels, settings.world))
        if free_until_s > look_s:
            # As far as nothing can be met; from a look to a look, as all legs.
            self._leg = Leg(settings, self._true, wheels, free_until_s - now)
            self._turned = wheels
        else:
            self._turned, ground = self._imperfect(wheels, until_look_s)
            self._leg = Leg(
                settings,
                self._true,
                ground,
                until_look_s,
                self._surroundings(),
                pivots=drivetrain.can_pivot,
            )
        leg = self._leg
        if is_even and leg.held_by and leg.ground == (0.0, 0.0):
            leg.seconds = math.inf  # nothing will change
        self._leg_from_s = now
        self._leg_ends_s = look_s if leg.seconds == until_look_s else now + leg.seconds
        self._drawn_s = 0.0
        return leg

    def _imperfect(self, wheels: Wheels, seconds: float) -> tuple[Wheels, Wheels]:
        """What the wheels turn and what they make on the ground, mm/s."""
        if self._chassis.is_ideal:
            return wheels, wheels
        grip_from = math.floor(self.now / GRIP_S)
        if grip_from != self._grip_from:
            self._grip, self._grip_from = self._chassis.grip(), grip_from
        turned = self._chassis.turned(wheels.times(seconds)).times(1.0 / seconds)
        return turned, Wheels(turned.left_mm * self._grip[0], turned.right_mm * self._grip[1])

    # The ink

    def _undrawn(self) -> list[Pose]:
        return self._leg.way(self._drawn_s, self._elapsed_s) if self._leg else []

    def _draw(self) -> None:
        super()._draw()
        if self._leg:
            self._drawn_s = self._elapsed_s
