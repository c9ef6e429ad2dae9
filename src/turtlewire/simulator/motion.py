"""One motion of a robot on two wheels, under way: where it is at any time, and when and how it ends."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from turtlewire.simulator.chassis import Chassis, Travel, Wheels, chords, drive
from turtlewire.simulator.world import TOUCH_MM, Contact, World
from turtlewire.turtle import direction

if TYPE_CHECKING:
    from turtlewire.turtle import Pose

# How far a drawn arc may be from the true one.
INK_MM = 0.02
# An endless motion of imperfect wheels is made of pieces, each with its own slip and noise.
PIECE_MM = 1000.0
PIECE_DEG = 360.0


class Motion:
    """Straight ahead or back, or turning on the spot, as far as the wheels do what they are told.

    Progress is counted in millimetres or degrees, from 0 up to ``length``. Nothing depends on how often it is
    asked for: all follows from the start, the rate and the time of its last change.

    Args:
        chassis: what moves; how they fail is drawn here, once.
        world: the walls in the way.
        true: the pose on the ground at the start.
        odometer: the pose that the wheels have measured.
        turning: on the spot (amounts are degrees, clockwise), or straight (millimetres, ahead).
        amount: how far; the other way round when negative; may be infinite. The wheels measure this.
        scale: how far it truly goes for each unit of that.

    Attributes:
        length: how far it goes, in units of progress.
        continues: whether this is only a piece of an endless motion, to be followed by the next.
        contact: the wall that ends it, if one does.
        stop_at: the progress at which it ends.
        rate: units per second.
        end_s: when it ends, as long as the rate stays (infinite: never).
    """

    def __init__(
        self,
        chassis: Chassis,
        world: World,
        true: Pose,
        odometer: Pose,
        *,
        turning: bool,
        amount: float,
        scale: float = 1.0,
    ) -> None:
        self.turning = turning
        self.amount = amount
        self.length = abs(amount)
        self.continues = self.length == math.inf and not chassis.is_ideal
        if self.continues:
            self.length = PIECE_DEG if turning else PIECE_MM
        self._true, self._odometer, self._track_mm = true, odometer, chassis.track_mm
        sign = math.copysign(1.0, amount)
        unit = chassis.turning(sign) if turning else Wheels(sign, sign)
        if chassis.is_ideal or not self.length:
            self._per_unit = Travel(unit, unit.times(scale))
        else:
            turned, ground = chassis.travel(unit.times(self.length))
            each = 1.0 / self.length
            self._per_unit = Travel(turned.times(each), ground.times(each * scale))
        self.stop_at = self.length
        self.contact = self._find_contact(world, chassis.radius_mm) if not world.is_empty else None
        self._done = 0.0
        self._since = 0.0
        self.rate = 0.0
        self._drawn = 0.0
        self.end_s = math.inf

    @property
    def is_refused(self) -> bool:
        """Whether it would press into a wall that the robot touches already (W13)."""
        return self.contact is not None and self.stop_at == 0.0

    def set_rate(self, rate: float, now: float) -> None:
        """Go on at this many units per second from now on; 0: do not progress."""
        self._done, self._since, self.rate = self.progress(now), now, rate
        left = self.stop_at - self._done
        self.end_s = now + left / rate if rate and left else math.inf if left else now

    def progress(self, now: float) -> float:
        """How far it is."""
        if now >= self.end_s:
            return self.stop_at
        return min(self.stop_at, self._done + self.rate * (now - self._since))

    def true_pose(self, progress: float) -> Pose:
        """Where the robot is on the ground."""
        return drive(self._true, self._per_unit.ground.times(progress), self._track_mm)

    def odometer_pose(self, progress: float) -> Pose:
        """Where the robot is by what its wheels have turned."""
        return drive(self._odometer, self._per_unit.turned.times(progress), self._track_mm)

    def undrawn(self, progress: float) -> list[Pose]:
        """The way since what was said to be drawn, near enough for ink."""
        return self._ways(self._drawn, progress, INK_MM)

    def mark_drawn(self, progress: float) -> None:
        """The way up to here has been drawn."""
        self._drawn = progress

    def stop_short(self, progress: float, contact: Contact) -> None:
        """Somebody has come in the way: it ends here instead, no earlier than where it is."""
        self.contact = contact
        self.stop_at = max(progress, self.progress(self._since))

    def _ways(self, start: float, end: float, tolerance_mm: float) -> list[Pose]:
        """The ends of the chords of the true way between two progresses."""
        pieces = chords(self._per_unit.ground.times(end - start), self._track_mm, tolerance_mm)
        poses = [self.true_pose(start + (end - start) * i / pieces) for i in range(1, pieces)]
        return [*poses, self.true_pose(end)]

    def _find_contact(self, world: World, radius_mm: float) -> Contact | None:
        left, right = self._per_unit.ground
        if self.turning:
            if left != -right and self._meet(world, radius_mm):
                # A disc that turns never runs into anything, but unequal slip shifts it. A wall holds it: it turns
                # in place.
                rim = (left - right) / 2.0
                self._per_unit = self._per_unit._replace(ground=Wheels(rim, -rim))
                self.stop_at = self.length
            return None
        return self._meet(world, radius_mm)

    def _meet(self, world: World, radius_mm: float) -> Contact | None:
        """The wall that ends this motion, if any: ``stop_at`` is where."""
        left, right = self._per_unit.ground
        if not self.length or not (left or right):
            return None
        if left == right:
            dx, dy = direction(self._true.heading_deg)
            ahead = (dx, dy) if left > 0.0 else (-dx, -dy)
            way_mm = self.length * abs(left)
            contact = world.contact(self._true.x_mm, self._true.y_mm, ahead, way_mm, radius_mm)
            if contact:
                self.stop_at = min(self.length, contact.distance_mm / abs(left))
            return contact
        here = self._true
        way_mm = self.length * max(abs(left), abs(right))
        world = world.near(here.x_mm, here.y_mm, way_mm + radius_mm + TOUCH_MM)
        if world.is_empty:
            return None
        ends = self._ways(0.0, self.length, TOUCH_MM / 2.0)
        for i, end in enumerate(ends):
            dx, dy = end.x_mm - here.x_mm, end.y_mm - here.y_mm
            way_mm = math.hypot(dx, dy)
            if way_mm:
                ahead = (dx / way_mm, dy / way_mm)
                contact = world.contact(here.x_mm, here.y_mm, ahead, way_mm, radius_mm)
                if contact:
                    self.stop_at = self.length * (i + contact.distance_mm / way_mm) / len(ends)
                    return contact
            here = end
        return None
