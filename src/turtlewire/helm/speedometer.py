"""How fast something moves, by where it was."""

from __future__ import annotations

import math
from collections import deque

from turtlewire.turtle import Pose, direction, wrapped

# Over how long: less is unsteady, more is slow to tell.
OVER_S = 0.3


class Speedometer:
    """Takes poses, and tells speeds."""

    def __init__(self) -> None:
        self._poses: deque[tuple[float, Pose]] = deque()
        self.speed_mm_per_s = self.turn_deg_per_s = 0.0

    def at(self, pose: Pose, now: float) -> None:
        """It is here now, seconds on any clock."""
        self._poses.append((now, pose))
        while len(self._poses) > 2 and self._poses[1][0] <= now - OVER_S:
            self._poses.popleft()
        then, before = self._poses[0]
        seconds = now - then
        if seconds <= 0.0 or pose == self._poses[-2][1]:
            self.speed_mm_per_s = self.turn_deg_per_s = 0.0
            return
        dx, dy = pose.x_mm - before.x_mm, pose.y_mm - before.y_mm
        turned = wrapped(pose.heading_deg - before.heading_deg)
        ahead_x, ahead_y = direction(before.heading_deg + turned / 2.0)
        way = math.copysign(math.hypot(dx, dy), dx * ahead_x + dy * ahead_y)
        self.speed_mm_per_s, self.turn_deg_per_s = way / seconds, turned / seconds
