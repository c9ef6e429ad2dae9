"""The scalar kernel: one short (or free) piece of a robot's way, at even wheel speeds.

Where something may be in the way, a piece lasts until the next look (10 ms at most) and is a straight chord of its
arc: contact is exact, and nothing is ever driven through. Where nothing can be met, it is the exact arc, however
long. ``fleet`` does the same for thousands at once.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from turtlewire.simulator.chassis import HEADING_DECIMALS, Wheels, chords, drive
from turtlewire.turtle import Pose, direction

if TYPE_CHECKING:
    from turtlewire.simulator.settings import BodySettings
    from turtlewire.simulator.world import Contact, World

# How far a drawn arc may be from the true one.
INK_MM = 0.02


class Leg:
    """From one pose on, for so many seconds.

    Args:
        settings: the robot's.
        start: the pose at its beginning.
        ground: what the wheels make on the ground, mm/s.
        seconds: how long, unless something is in the way; infinite only without obstacles.
        obstacles: what may be in the way; None: nothing can be, it is an exact arc.
        pivots: whether a robot that is held by an obstacle can turn in place; else it stands.

    Attributes:
        seconds: how long it lasts.
        contact: what it ends at, if it does.
        held_by: what the robot touches and presses into during the whole leg, if it does.
        ground: what the wheels make on the ground, mm/s.
    """

    def __init__(
        self,
        settings: BodySettings,
        start: Pose,
        ground: Wheels,
        seconds: float,
        obstacles: World | None = None,
        *,
        pivots: bool = True,
    ) -> None:
        self.start = start
        self.ground = ground
        self.seconds = seconds
        self.contact: Contact | None = None
        self.held_by: Contact | None = None
        self._track_mm = settings.track_mm
        self._offset_mm = settings.offset_mm
        self._whole_s = seconds
        self._is_arc = obstacles is None
        if obstacles is not None:
            self._meet(obstacles, settings.radius_mm, pivots=pivots)

    @property
    def is_straight(self) -> bool:
        """Whether it goes straight, ahead or back."""
        return self.ground.left_mm == self.ground.right_mm

    def pose(self, elapsed_s: float) -> Pose:
        """Where the robot is, so many seconds after the beginning, 0..``seconds``."""
        if self._is_arc:
            return drive(self.start, self.ground.times(elapsed_s), self._track_mm)
        if self.ground == (0.0, 0.0):
            return self.start
        if elapsed_s >= self._whole_s:
            return self._end
        part = elapsed_s / self._whole_s
        x = self._from.x_mm + (self._to.x_mm - self._from.x_mm) * part
        y = self._from.y_mm + (self._to.y_mm - self._from.y_mm) * part
        turned = math.degrees((self.ground.left_mm - self.ground.right_mm) * elapsed_s / self._track_mm)
        heading = round((self.start.heading_deg + turned) % 360.0, HEADING_DECIMALS) % 360.0
        return Pose(x, y, heading).moved(-self._offset_mm) if self._offset_mm else Pose(x, y, heading)

    def way(self, from_s: float, to_s: float) -> list[Pose]:
        """The ends of the chords of the way between two times, near enough for ink."""
        pieces = chords(self.ground.times(to_s - from_s), self._track_mm, INK_MM) if self._is_arc else 1
        poses = [self.pose(from_s + (to_s - from_s) * i / pieces) for i in range(1, pieces)]
        return [*poses, self.pose(to_s)]

    def _plan(self) -> None:
        """The chord of the middle of the disc."""
        self._end = drive(self.start, self.ground.times(self._whole_s), self._track_mm)
        self._from = self.start.moved(self._offset_mm) if self._offset_mm else self.start
        self._to = self._end.moved(self._offset_mm) if self._offset_mm else self._end

    def _meet(self, obstacles: World, radius_mm: float, *, pivots: bool) -> None:
        self._plan()
        here, there = self._from, self._to
        way_mm = here.distance_to(there.x_mm, there.y_mm)
        if not way_mm:
            return
        ahead = ((there.x_mm - here.x_mm) / way_mm, (there.y_mm - here.y_mm) / way_mm)
        contact = obstacles.contact(here.x_mm, here.y_mm, ahead, way_mm, radius_mm)
        if contact is None:
            return
        if contact.distance_mm:
            self.contact = contact
            self.seconds = self._whole_s * contact.distance_mm / way_mm
            return
        self.held_by = contact
        rim = (self.ground.left_mm - self.ground.right_mm) / 2.0 if pivots else 0.0
        self.ground = Wheels(rim, -rim)
        self._plan()


def free_s(settings: BodySettings, pose: Pose, wheels: Wheels, world: World) -> float:
    """How long a robot can go on like this before it could possibly meet anything; infinite: for ever."""
    if world.is_empty:
        return math.inf
    left, right = wheels
    fastest = abs(left + right) / 2.0 + settings.offset_mm * abs(left - right) / settings.track_mm
    if not fastest:
        return math.inf
    dx, dy = direction(pose.heading_deg)
    x, y = pose.x_mm + settings.offset_mm * dx, pose.y_mm + settings.offset_mm * dy
    return max(0.0, world.gap(x, y, settings.radius_mm)) / fastest
