"""Many robots without wires: set-points in, poses out, all in one world and in steps of 10 ms.

For learning, planning and testing with crowds. Each robot is what its settings say, as it is over its wire, and has two
set-points of -255..255, by its kind:

========================  ======================  =================
settings                  first                   second
========================  ======================  =================
``CarSettings``           drive, PWM              steering, PWM
``FrameRobotSettings``    left engine             right engine
``Settings`` (WALTER)     linear speed, units     turning speed, units (clockwise)
========================  ======================  =================

What a robot runs into holds it; a WALTER stops and has its set-points cleared, as its limit sensors do it (W13). Robots
of a fleet do not see one another. ``make_fleet`` takes the kernel that is faster: plain Python for few robots, NumPy
(``turtlewire.simulator.fleet``) above about twenty. Both give the same poses.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from turtlewire.errors import UsageError
from turtlewire.simulator.body import LOOK_S
from turtlewire.simulator.car import CarDrivetrain, CarSettings
from turtlewire.simulator.chassis import Chassis, Wheels
from turtlewire.simulator.drivetrain import Battery
from turtlewire.simulator.frame_robot import FrameRobotSettings, TwoEngines
from turtlewire.simulator.leg import Leg
from turtlewire.simulator.rolling import GRIP_S
from turtlewire.simulator.settings import FULL_SPEED, Settings
from turtlewire.turtle import direction

if TYPE_CHECKING:
    from collections.abc import Sequence

    from turtlewire.simulator.world import World
    from turtlewire.turtle import Pose

AnySettings = CarSettings | FrameRobotSettings | Settings
# From this many robots on, NumPy is the faster kernel.
MANY = 20
# A robot that meets one thing after another within one step has had enough after so many.
MAX_PIECES = 4
STEPS_PER_GRIP = round(GRIP_S / LOOK_S)


class Fleet(Protocol):
    """Robots in one world that go step by step together."""

    @property
    def time_s(self) -> float:
        """Seconds since power-on."""

    def set_points(self, first: Sequence[float], second: Sequence[float]) -> None:
        """What each robot is told from now on, -255..255 (beyond, it is cut). One value for each robot."""

    def step(self, steps: int = 1) -> None:
        """Let ``steps`` times 10 ms pass."""

    def poses(self) -> list[Pose]:
        """Where the robots truly are on the ground."""

    def bumpers(self) -> list[bool]:
        """Which robots press into something, or (a WALTER) were stopped by it."""


def make_fleet(robots: Sequence[AnySettings]) -> Fleet:
    """A fleet of these robots, with the kernel that is faster for so many.

    Raises ``UsageError`` if they are not all in the same world.
    """
    if len(robots) <= MANY:
        return ScalarFleet(robots)
    from turtlewire.simulator.fleet import ArrayFleet

    return ArrayFleet(robots)


def world_of(robots: Sequence[AnySettings]) -> World:
    """The world of all of them. Raises ``UsageError`` if there is none."""
    if not robots:
        raise UsageError("a fleet needs at least one robot")
    world = robots[0].world
    if any((r.world.walls, r.world.discs) != (world.walls, world.discs) for r in robots):
        raise UsageError("the robots of a fleet must all be in the same world")
    return world


class _WalterWheels:
    """WALTER's stepper motors: what they are told, they do at once."""

    can_pivot = True

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.first = self.second = 0.0
        self._wheels = Wheels(0.0, 0.0)

    @property
    def is_settled(self) -> bool:
        return True

    @property
    def power(self) -> float:
        return min(1.0, (abs(self.first) + abs(self.second)) / FULL_SPEED)

    def aim(self, strength: float) -> None:
        turn = Chassis(self.settings.radius_mm, self.settings.track_mm).turning(
            self.second * self.settings.deg_per_s_per_unit * strength
        )
        ahead = self.first * self.settings.mm_per_s_per_unit * strength
        self._wheels = Wheels(ahead + turn.left_mm, ahead + turn.right_mm)

    def mean(self, seconds: float) -> Wheels:  # noqa: ARG002 - the same at all times
        return self._wheels

    def advance(self, seconds: float) -> None:
        pass


class _Member:
    """One robot of the fleet."""

    def __init__(self, settings: AnySettings) -> None:
        self.settings = settings
        self.pose = settings.first_pose
        self.bumped = False
        self.drivetrain: CarDrivetrain | TwoEngines | _WalterWheels
        match settings:
            case CarSettings():
                self.drivetrain = CarDrivetrain(settings)
            case FrameRobotSettings():
                self.drivetrain = TwoEngines(settings)
            case Settings():
                self.drivetrain = _WalterWheels(settings)
        self._battery = Battery(settings.sag, settings.battery_s)
        self._chassis = Chassis(
            settings.radius_mm, settings.track_mm, settings.slip, settings.noise, settings.seed
        )
        self._grip = (1.0, 1.0)
        # How far its disc can go before it could possibly meet anything.
        self._free_mm = 0.0

    def set_points(self, first: float, second: float) -> None:
        first, second = (max(-FULL_SPEED, min(FULL_SPEED, value)) for value in (first, second))
        match self.drivetrain:
            case CarDrivetrain() as car:
                car.drive, car.steer = first, second
            case TwoEngines() as engines:
                engines.wanted = (first, second)
            case _WalterWheels() as wheels:
                wheels.first, wheels.second = first, second

    def step(self, world: World, now: float) -> None:
        left_s = LOOK_S
        for _ in range(MAX_PIECES):
            left_s = self._piece(world, now + LOOK_S - left_s, left_s)
            if not left_s:
                break

    def new_grip(self) -> None:
        self._grip = self._chassis.grip()

    def _piece(self, world: World, now: float, seconds: float) -> float:
        """One leg; what is left of the time after something was met."""
        drivetrain = self.drivetrain
        drivetrain.aim(self._battery.draw(drivetrain.power, now))
        wheels = drivetrain.mean(seconds)
        if wheels == (0.0, 0.0):
            drivetrain.advance(seconds)
            return 0.0
        if not self._chassis.is_ideal:
            turned = self._chassis.turned(wheels.times(seconds)).times(1.0 / seconds)
            wheels = Wheels(turned.left_mm * self._grip[0], turned.right_mm * self._grip[1])
        leg = Leg(
            self.settings,
            self.pose,
            wheels,
            seconds,
            world if self._may_meet(world, wheels, seconds) else None,
            pivots=drivetrain.can_pivot,
        )
        drivetrain.advance(leg.seconds)
        self.bumped = leg.held_by is not None or leg.contact is not None
        is_refused = leg.held_by is not None and isinstance(drivetrain, _WalterWheels)
        if not is_refused:
            self.pose = leg.pose(leg.seconds)
        if self.bumped and isinstance(drivetrain, _WalterWheels):
            drivetrain.first = drivetrain.second = 0.0
            self._battery.draw(0.0, now + leg.seconds)
            return 0.0
        return seconds - leg.seconds if leg.contact else 0.0

    def _may_meet(self, world: World, wheels: Wheels, seconds: float) -> bool:
        """Whether a wall could be met: by what was free when it was last measured."""
        settings, (left, right) = self.settings, wheels
        way_mm = abs(left + right) / 2.0 + settings.offset_mm * abs(left - right) / settings.track_mm
        way_mm *= seconds
        if way_mm > self._free_mm:
            dx, dy = direction(self.pose.heading_deg)
            x = self.pose.x_mm + settings.offset_mm * dx
            y = self.pose.y_mm + settings.offset_mm * dy
            self._free_mm = world.gap(x, y, settings.radius_mm)
        self._free_mm -= way_mm
        return self._free_mm <= 0.0


class ScalarFleet:
    """A fleet in plain Python: the faster kernel for few robots, and what the other one is checked against.

    Raises ``UsageError`` if the robots are not all in the same world.
    """

    def __init__(self, robots: Sequence[AnySettings]) -> None:
        self._world = world_of(robots)
        self._members = [_Member(settings) for settings in robots]
        self._steps = 0

    @property
    def time_s(self) -> float:
        """Seconds since power-on."""
        return self._steps * LOOK_S

    def set_points(self, first: Sequence[float], second: Sequence[float]) -> None:
        """What each robot is told from now on, -255..255 (beyond, it is cut). One value for each robot."""
        for member, a, b in zip(self._members, first, second, strict=True):
            member.set_points(a, b)

    def step(self, steps: int = 1) -> None:
        """Let ``steps`` times 10 ms pass."""
        for _ in range(steps):
            now = self.time_s
            for member in self._members:
                if self._steps % STEPS_PER_GRIP == 0:
                    member.new_grip()
                member.step(self._world, now)
            self._steps += 1

    def poses(self) -> list[Pose]:
        """Where the robots truly are on the ground."""
        return [member.pose for member in self._members]

    def bumpers(self) -> list[bool]:
        """Which robots press into something, or (a WALTER) were stopped by it."""
        return [member.bumped for member in self._members]
