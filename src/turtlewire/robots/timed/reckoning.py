"""Where a robot is that cannot tell: reckoned from how it was told to move, and for how long it truly was.

Two turtles: the exact one is where Logo says, the other where the robot is. What the times of the wire, whole PWM
values and whole steering values leave between them is known, and each move aims from where the robot is to where
the exact turtle is: nothing adds up.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from turtlewire.trace import Trace
from turtlewire.turtle import HOME, Pose, direction, wrapped

# A drawn arc is a polygon of pieces that turn by no more than this.
INK_DEG = 5.0
# What is less is left to the next move.
LEAST_MOVE_MM = 0.05


class Motion(NamedTuple):
    """How a robot moves while its set-points hold: in an arc, a straight line, or on the spot.

    Attributes:
        speed_mm_per_s: of the robot's place, negative backwards.
        turn_deg_per_s: clockwise.
    """

    speed_mm_per_s: float = 0.0
    turn_deg_per_s: float = 0.0

    def after(self, pose: Pose, seconds: float) -> Pose:
        """Where a robot gets that moves so."""
        length = self.speed_mm_per_s * seconds
        if not self.turn_deg_per_s:
            return pose.moved(length)
        half_deg = self.turn_deg_per_s * seconds / 2.0
        half = math.radians(half_deg)
        chord = length * (math.sin(half) / half if half else 1.0)
        dx, dy = direction(pose.heading_deg + half_deg)
        return Pose(
            pose.x_mm + chord * dx, pose.y_mm + chord * dy, (pose.heading_deg + 2.0 * half_deg) % 360.0
        )


STILL = Motion()


class Reckoning:
    """The account of one robot.

    Attributes:
        exact: where the turtle is.
        distance_mm: how far its place has moved, there and back counted.
        rolled_mm, rotated_deg: how far it has moved and turned, ahead less back, clockwise less counter-clockwise.
    """

    def __init__(self) -> None:
        self.exact = HOME
        self.distance_mm = 0.0
        self.rolled_mm = 0.0
        self.rotated_deg = 0.0
        self._robot = HOME
        # How far it has driven straight since then. It is one line, however many set-points that took: whoever drives
        # by hand gives many, and seldom asks.
        self._straight_mm = 0.0
        self._owed_deg = 0.0
        self._motion = STILL
        self._since = -math.inf
        self._trace = Trace()
        self._is_drawn = True
        self._pen_down = True

    # ------------------------------------------------------------------ the robot

    @property
    def motion_under_way(self) -> Motion:
        """How the robot moves, as far as it was told."""
        return self._motion

    @property
    def is_moving(self) -> bool:
        """Whether the robot moves, as far as it was told."""
        return self._motion != STILL

    def begin(self, motion: Motion, now: float, *, is_drawn: bool = True) -> None:
        """From now on the robot moves so, instead of what it did. ``is_drawn``: the trace shows it."""
        self.update(now)
        if is_drawn is not self._is_drawn:
            self._draw_line()
            self._is_drawn = is_drawn
        self._motion = motion

    def end(self, now: float) -> None:
        """The robot stands still from now on."""
        self.begin(STILL, now)
        self._draw_line()

    def at(self, now: float) -> Pose:
        """Where the robot is at a time, by reckoning, if it goes on as it does."""
        return self._motion.after(self.robot, self._elapsed(now))

    @property
    def robot(self) -> Pose:
        """Where the robot was when its motion last changed; where it is, if it stands still."""
        self._draw_line()
        return self._robot

    def place(self, pose: Pose) -> None:
        """The robot is here, as something better than reckoning tells."""
        self._draw_line()
        self._draw(pose)

    @property
    def pen_down(self) -> bool:
        """Whether the pen is."""
        return self._pen_down

    @pen_down.setter
    def pen_down(self, is_down: bool) -> None:
        self._draw_line()
        self._pen_down = is_down

    @property
    def trace(self) -> Trace:
        """The way that the robot has gone, by reckoning, until its motion last changed."""
        self._draw_line()
        return self._trace

    def _elapsed(self, now: float) -> float:
        return max(0.0, now - self._since) if self.is_moving else 0.0

    def update(self, now: float) -> None:
        """The robot has gone on as it does until now."""
        seconds = now - self._since
        if seconds <= 0.0:
            return  # what was sent last has not arrived yet
        self._since = now
        motion = self._motion
        if motion is STILL:
            return
        length_mm = motion.speed_mm_per_s * seconds
        self.distance_mm += abs(length_mm)
        self.rolled_mm += length_mm
        if motion.turn_deg_per_s:
            self._draw_turn(seconds)
        else:
            if length_mm * self._straight_mm < 0.0:  # there and back are two lines
                self._draw_line()
            self._straight_mm += length_mm

    def _draw_turn(self, seconds: float) -> None:
        start, turn_deg = self.robot, self._motion.turn_deg_per_s * seconds
        pieces = math.ceil(abs(turn_deg) / INK_DEG)
        for piece in range(1, pieces + 1):
            self._draw(self._motion.after(start, seconds * piece / pieces))
        self._owed_deg -= turn_deg
        self.rotated_deg += turn_deg

    def _draw_line(self) -> None:
        """The robot is at the end of its line."""
        if self._straight_mm:
            length_mm, self._straight_mm = self._straight_mm, 0.0
            self._draw(self._robot.moved(length_mm))

    def _draw(self, pose: Pose) -> None:
        self._robot = pose
        if self._is_drawn:
            self._trace.move(pose, pen_down=self._pen_down)

    # ------------------------------------------------------------------ the exact turtle

    def turn(self, angle_deg: float) -> None:
        """Turn the turtle; the robot owes it. Whole turns are owed, too."""
        self._owed_deg = self.owed_deg + angle_deg
        self.exact = self.exact.turned(angle_deg)

    @property
    def owed_deg(self) -> float:
        """How far the robot has to turn, clockwise, to look where the turtle looks."""
        behind = wrapped(self.exact.heading_deg - self._robot.heading_deg - self._owed_deg)
        return self._owed_deg + behind

    def settle(self) -> None:
        """Whatever was to come is forgotten: the turtle is where the robot is."""
        self.exact = self.robot
        self._owed_deg = 0.0

    def aim(self, tolerance_mm: float) -> float:
        """By how much to turn, clockwise, before driving on to where the turtle is.

        The robot turns as the turtle did; more than that only to make good what it is off to the side by more than a
        tolerance.
        """
        target, robot, owed = self.exact, self.robot, self.owed_deg
        distance = robot.distance_to(target.x_mm, target.y_mm)
        more = wrapped(robot.bearing_to(target.x_mm, target.y_mm) - robot.heading_deg - owed)
        if abs(more) > 90.0:
            more += math.copysign(180.0, -more)  # it drives there backwards
        return owed + (more if distance * abs(math.sin(math.radians(more))) > tolerance_mm else 0.0)

    @property
    def ahead_mm(self) -> float:
        """How far to drive, as the robot looks now, to get nearest to where the turtle is; backwards when negative."""
        robot = self.robot
        dx, dy = direction(robot.heading_deg)
        return (self.exact.x_mm - robot.x_mm) * dx + (self.exact.y_mm - robot.y_mm) * dy
