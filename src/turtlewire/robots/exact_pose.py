"""No drift from rounding (W11): the exact turtle, and the robot that follows it in whole degrees and half millimetres.

The exact turtle is where Logo says. The robot can only turn by whole degrees and drive whole units. So each move aims
from where the robot is to where the exact turtle will be: after a move the robot is at most half a unit off along its
way and ``move * sin 0.5 degrees`` off to the side, and the next move starts from there instead of adding to it.
"""

from __future__ import annotations

from typing import NamedTuple

from turtlewire.turtle import HOME, Pose, direction, wrapped


class Turn(NamedTuple):
    """Turn on the spot by whole degrees of the wire, clockwise; with the robot's pose afterwards."""

    angle_deg: int
    pose: Pose


class Move(NamedTuple):
    """Drive straight by whole units (backwards when negative); with the robot's pose afterwards."""

    units: int
    pose: Pose


Step = Turn | Move


class ExactPose:
    """The exact turtle and the pose of the robot that follows it.

    Args:
        unit_mm: how far the robot goes for the wire's unit of distance.
        unit_deg: how far it turns for the wire's unit of angle, which is called a degree.

    Attributes:
        exact: where the turtle is.
        robot: where the robot is when it has done every step handed out so far; it has turned by whole units.
    """

    def __init__(self, unit_mm: float, unit_deg: float = 1.0) -> None:
        self.unit_mm = unit_mm
        self.unit_deg = unit_deg
        self.exact = HOME
        self.robot = HOME

    def turn(self, angle_deg: float) -> list[Step]:
        """Turn the turtle; the steps that bring the robot's heading nearest to it. Whole turns are made."""
        behind = wrapped(self.exact.heading_deg - self.robot.heading_deg)
        self.exact = self.exact.turned(angle_deg)
        return self._turn_robot(round((behind + angle_deg) / self.unit_deg))

    def move(self, distance_mm: float) -> list[Step]:
        """Move the turtle straight on; the steps that bring the robot nearest to it."""
        self.exact = self.exact.moved(distance_mm)
        return self._approach()

    def go_to(self, x_mm: float, y_mm: float) -> list[Step]:
        """Set the turtle's place, its heading kept; the steps that bring the robot nearest to it.

        The robot's own heading is put right by ``align`` or by the next turn.
        """
        self.exact = Pose(x_mm, y_mm, self.exact.heading_deg)
        return self._approach()

    def set_heading(self, heading_deg: float) -> list[Step]:
        """Set the turtle's heading; turn the robot the shorter way to the nearest whole degree."""
        self.exact = Pose(self.exact.x_mm, self.exact.y_mm, heading_deg % 360.0)
        return self.align()

    def align(self) -> list[Step]:
        """Turn the robot to the whole degree nearest to the turtle's heading."""
        behind = wrapped(self.exact.heading_deg - self.robot.heading_deg)
        return self._turn_robot(round(behind / self.unit_deg))

    def _approach(self) -> list[Step]:
        target, robot = self.exact, self.robot
        distance = robot.distance_to(target.x_mm, target.y_mm)
        if round(distance / self.unit_mm) == 0:
            return []
        turn = wrapped(robot.bearing_to(target.x_mm, target.y_mm) - robot.heading_deg)
        if abs(round(turn)) > 90:
            turn += 180.0 if turn < 0.0 else -180.0  # drive it backwards
        steps = self._turn_robot(round(turn / self.unit_deg))
        dx, dy = direction(self.robot.heading_deg)
        ahead = (target.x_mm - robot.x_mm) * dx + (target.y_mm - robot.y_mm) * dy
        units = round(ahead / self.unit_mm)
        self.robot = self.robot.moved(units * self.unit_mm)
        return [*steps, Move(units, self.robot)]

    def _turn_robot(self, angle_deg: int) -> list[Step]:
        if angle_deg == 0:
            return []
        self.robot = self.robot.turned(angle_deg * self.unit_deg)
        return [Turn(angle_deg, self.robot)]


def wire_parts(value: int, *, gentle: bool) -> list[int]:
    """A distance or angle, 0 or more, as 16-bit arguments that add up to it: moves are split, never cut (W5).

    ``gentle`` parts have no byte 0D or 0A (W8).
    """
    parts: list[int] = []
    while value > 0xFFFF:
        parts.append(0xF000)
        value -= 0xF000
    if not gentle or is_gentle(value):
        return [*parts, value]
    # Nearly every half will do: start in the middle, so that both parts are of a size.
    half = value // 2
    while not (is_gentle(half) and is_gentle(value - half)):
        half -= 1
    return [*parts, half, value - half]


def is_gentle(value: int) -> bool:
    """Whether a 16-bit argument has no byte 0D or 0A (W8)."""
    return not {value >> 8 & 0xFF, value & 0xFF} & {0x0D, 0x0A}


def with_rest(parts: list[int]) -> list[tuple[int, int]]:
    """Each part with what is still to come after it."""
    total = sum(parts)
    rests = []
    for part in parts:
        total -= part
        rests.append((total, part))
    return rests
