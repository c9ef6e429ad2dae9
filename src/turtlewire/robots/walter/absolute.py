"""Moves to a place and turns to a heading, by the robot's own commands for them, if it has them: group C (W10).

What these decline, the driver does with turns and moves: all of them for a robot that does not go as far, or turn as
much, as it believes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.errors import NotSupportedError
from turtlewire.protocols.walter.codec import encode
from turtlewire.protocols.walter.messages import (
    GoHome,
    GoTo,
    GoToX,
    GoToY,
    LogoCommand,
    ResetLocation,
    TurnTo,
)
from turtlewire.robots.frame import Frame
from turtlewire.robots.walter.whereabouts import ANY_HEADING, TOLERANCE_DEG, TOLERANCE_MM, UNIT_MM
from turtlewire.turtle import HOME, Pose, wrapped

if TYPE_CHECKING:
    from turtlewire.robots.walter.connection import Connection


class AbsoluteMoves:
    """Group C of one robot. Each method is False if the robot, or the wire, has no such command."""

    def __init__(self, wire: Connection) -> None:
        self._wire = wire

    async def go_to(self, x_mm: float, y_mm: float) -> bool:
        """Go straight to a point and keep the heading."""
        position, frame = self._wire.where.position, self._wire.where.frame
        here = frame.to_robot(position.robot)
        there = frame.to_robot(Pose(x_mm, y_mm, position.robot.heading_deg))
        x, y = round(there.x_mm / UNIT_MM), round(there.y_mm / UNIT_MM)
        if here.y_mm == y * UNIT_MM:
            command: LogoCommand = GoToX(x)
        elif here.x_mm == x * UNIT_MM:
            command = GoToY(y)
        else:
            command = GoTo(x, y)
        arrived = frame.from_robot(Pose(x * UNIT_MM, y * UNIT_MM, here.heading_deg))
        if arrived.distance_to(*position.robot[:2]) < UNIT_MM or not await self._sent([(command, arrived)]):
            return False
        position.exact = Pose(x_mm, y_mm, position.exact.heading_deg)
        return True

    async def turn_to(self, pose: Pose) -> bool:
        """Turn, the shorter way, to the heading of a pose, on the spot."""
        return await self._sent([self._turn(pose)])

    async def go_home(self) -> bool:
        """Go to the origin and look up."""
        position, origin = self._wire.where.position, self._wire.where.frame.origin
        # C 0 goes to the robot's own origin, and promises no heading: a fence may fall between it and C H.
        is_own = (origin.x_mm, origin.y_mm) == (0.0, 0.0)
        is_away = position.robot.distance_to(0.0, 0.0) >= UNIT_MM
        heading_deg = ANY_HEADING if self._wire.host.answers else position.robot.heading_deg
        arrived = Pose(0.0, 0.0, heading_deg)
        if not (is_own and is_away and await self._sent([(GoHome(), arrived), self._turn(HOME)])):
            return False
        position.exact = HOME
        return True

    async def carry_out(self, command: LogoCommand) -> None:
        """Have a command of group C sent as somebody wrote it, in the robot's own coordinates; it tells where that led.

        Raises ``NotSupportedError`` for a robot that has no such commands, or cannot tell.
        """
        wire = self._wire
        where, settings = wire.where, wire.settings
        if "C" not in wire.groups or not wire.host.answers:
            raise NotSupportedError(
                f"the robot at {wire.link.url} has no {command.name()}, or cannot tell where that leads"
            )
        if (settings.distance_scale, settings.turn_scale) != (1.0, 1.0):
            raise NotSupportedError(
                f"{command.name()}: the robot at {wire.link.url} is calibrated, and so its coordinates are not the "
                "turtle's"
            )
        await wire.finish()
        here = where.frame.to_robot(where.position.robot)
        there = {
            field.name[0]: value * UNIT_MM
            for field, value in zip(command.FIELDS, command.values(), strict=True)
        }
        far = Pose(there.get("x", 0.0), there.get("y", 0.0), here.heading_deg)
        wire.host.submit(command, self._duration_s(where.frame.from_robot(far)))
        pose = await wire.reported_pose()
        if isinstance(command, ResetLocation):
            # It stands where it stood, and calls that by another name.
            where.frame = Frame.matching(where.position.robot, where.frame.to_robot(pose))
        else:
            where.arrived(pose, pen_down=wire.pen_down)
            where.position.exact = pose

    def _turn(self, pose: Pose) -> tuple[LogoCommand, Pose]:
        return TurnTo(round(self._wire.where.frame.to_robot(pose).heading_deg) % 360), pose

    def _can_send(self, command: LogoCommand) -> bool:
        settings = self._wire.settings
        if "C" not in self._wire.groups or (settings.distance_scale, settings.turn_scale) != (1.0, 1.0):
            return False
        if any(
            not field.low <= value <= field.high
            for field, value in zip(command.FIELDS, command.values(), strict=True)
        ):
            return False  # W5
        arguments = encode(command)[len(command.LETTERS) : -1]
        return not self._wire.settings.gentle or not set(arguments) & {0x0D, 0x0A}  # W8

    async def _sent(self, moves: list[tuple[LogoCommand, Pose]]) -> bool:
        """Have commands sent, each with the pose that it ends at; False if there are no such commands.

        Whether the robot has group C shows in the pose after the first of them.
        """
        wire = self._wire
        if not all(self._can_send(command) for command, _ in moves):
            return False
        if not wire.knows_c and wire.host.answers:
            return await self._found_out(moves)
        for command, pose in moves:
            wire.submit(command, self._duration_s(pose), pose)
            wire.where.position.robot = pose
        return True

    async def _found_out(self, moves: list[tuple[LogoCommand, Pose]]) -> bool:
        """Does the robot do it, or nothing at all?"""
        wire = self._wire
        await wire.finish()
        before = wire.where.position.robot
        for command, pose in moves:
            wire.host.submit(command, self._duration_s(pose))
        pose = await wire.reported_pose()
        wire.knows_c = True
        arrived = moves[-1][1]
        if _distance(pose, arrived) >= _distance(pose, before):
            wire.groups = wire.groups - {"C"}
            return False
        # Robots round: what is near enough is where it was sent. From elsewhere, the driver drives the rest.
        is_near = _distance(pose, arrived) <= 2.0
        wire.where.arrived(arrived if is_near else pose, pen_down=wire.pen_down)
        return is_near

    def _duration_s(self, pose: Pose) -> float:
        """How long a move there should take at most (W14): the robot turns there, and back again."""
        settings, speed = self._wire.settings, self._wire.speed
        way_mm = self._wire.where.position.robot.distance_to(pose.x_mm, pose.y_mm)
        return way_mm / (speed * settings.mm_per_s_per_unit) + 360.0 / (speed * settings.deg_per_s_per_unit)


def _distance(pose: Pose, other: Pose) -> float:
    """How far apart poses are, in tolerances."""
    turned = abs(wrapped(pose.heading_deg - other.heading_deg))
    return max(pose.distance_to(*other[:2]) / TOLERANCE_MM, turned / TOLERANCE_DEG)
