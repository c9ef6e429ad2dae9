"""What the soaks of robots share whose clock is their host: the turtle, driving by hand, and where they are."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from tests.soak.domains import FLAG, Real, Whole, one_of, rule
from tests.soak.soak import Soak
from turtlewire.turtle import Pose, wrapped

if TYPE_CHECKING:
    from turtlewire.turtle import Turtle

DISTANCE = Real(-150.0, 150.0)
ANGLE = Real(-200.0, 200.0)
PLACE = Real(-100.0, 100.0)
UNIT = Real(-1.0, 1.0)
VALID = one_of(None, None, 0.1, 0.4, 1.5)


class Ways:
    """How far a robot truly went and turned, and how far by its host's account, since a moment; as seen from it."""

    def __init__(self, true: Pose, account: Pose) -> None:
        self._true, self._account = true, account

    def off(self, true: Pose, account: Pose) -> tuple[float, float]:
        """By how much they differ now: millimetres and degrees."""
        truly = self.in_account(true)
        return truly.distance_to(*account[:2]), abs(wrapped(truly.heading_deg - account.heading_deg))

    def in_account(self, true: Pose) -> Pose:
        """Where the host's account would be, if it knew."""
        here, way = self._account, _seen_from(self._true, true)
        angle = math.radians(here.heading_deg)
        return Pose(
            here.x_mm + way.x_mm * math.cos(angle) + way.y_mm * math.sin(angle),
            here.y_mm - way.x_mm * math.sin(angle) + way.y_mm * math.cos(angle),
            (here.heading_deg + way.heading_deg) % 360.0,
        )


def _seen_from(here: Pose, there: Pose) -> Pose:
    angle = math.radians(here.heading_deg)
    x, y = there.x_mm - here.x_mm, there.y_mm - here.y_mm
    return Pose(
        x * math.cos(angle) - y * math.sin(angle),
        x * math.sin(angle) + y * math.cos(angle),
        (there.heading_deg - here.heading_deg) % 360.0,
    )


class TimedSoak(Soak):
    """A robot driven by set-points."""

    # ------------------------------------------------------------------ rules

    @rule(weight=6.0, distance_mm=DISTANCE)
    def forward(self, distance_mm: float) -> None:
        self.do(self.driver.forward(distance_mm))

    @rule(weight=4.0, angle_deg=ANGLE)
    def right(self, angle_deg: float) -> None:
        self.do(self.driver.right(angle_deg))

    @rule(weight=2.0, x_mm=PLACE, y_mm=PLACE)
    def set_position(self, x_mm: float, y_mm: float) -> None:
        self.do(self.driver.set_position(x_mm, y_mm))

    @rule(weight=1.0, heading_deg=Real(0.0, 359.0))
    def set_heading(self, heading_deg: float) -> None:
        self.do(self.driver.set_heading(heading_deg))

    @rule(weight=0.5)
    def home(self) -> None:
        self.do(self.driver.home())

    @rule(weight=0.1, angle_deg=ANGLE, radius_mm=Real(1.0, 20.0))
    def arc(self, angle_deg: float, radius_mm: float) -> None:
        self.do(self.driver.arc(angle_deg, radius_mm))

    @rule(weight=3.0, down=FLAG)
    def pen(self, down: bool) -> None:
        self.do(self.driver.pen_down() if down else self.driver.pen_up())

    @rule(weight=1.0, speed=Whole(40, 255))
    def set_speed(self, speed: int) -> None:
        self.do(self.driver.set_speed(speed))

    @rule(weight=0.5, on=FLAG)
    def step_by_step(self, on: bool) -> None:
        self.do(self.driver.set_step_by_step(on))

    @rule(weight=2.0)
    def finish(self) -> None:
        self.do(self.driver.finish())

    @rule(weight=1.0, seconds=Real(0.0, 1.0))
    def wait(self, seconds: float) -> None:
        self.do(self.driver.wait(seconds))

    @rule(weight=0.2)
    def clean(self) -> None:
        self.do(self.driver.clean())

    @rule(weight=0.2)
    def clear_screen(self) -> None:
        self.do(self.driver.clear_screen())

    @rule(weight=8.0, speed=UNIT, turn=UNIT, valid_s=VALID)
    def drive(self, speed: float, turn: float, valid_s: float | None) -> None:
        self.do(self.driver.drive(speed, turn, valid_s=valid_s))

    @rule(weight=2.0, speed=UNIT, turn=UNIT, every_s=one_of(0.005, 0.0167, 0.05))
    def joystick(self, speed: float, turn: float, every_s: float) -> None:
        """One after the other, faster than the wire may be."""
        for n in range(1, 11):
            self.do(self.driver.drive(speed * n / 10, turn * n / 10, valid_s=0.3))
            self._runner.run(self.pause(every_s))

    # ------------------------------------------------------------------ what they know

    def new_ways(self) -> None:
        """Compare from here on."""
        self.ways = Ways(self.end.robot.pose, self.driver.reckoned_pose)

    def off(self) -> tuple[float, float]:
        """How far the account is off from the truth since ``new_ways``."""
        return self.ways.off(self.end.robot.pose, self.driver.reckoned_pose)


def same_names(turtle: type[Turtle]) -> set[str]:
    """What a turtle can do, for the test that nothing of it is left out."""
    return {name for name in dir(turtle) if not name.startswith("_")}
