"""What WALTER's commands mean for the robot: the motions that they consist of, and the answers to queries.

Everything here goes by the odometer: the robot knows no other place.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.protocols.walter import messages as m

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from turtlewire.turtle import Pose

# Nearer than this to where it is sent, the robot is there: a bearing to that place would mean nothing.
ARRIVED_MM = 1e-6
# W13: a contact this near to straight ahead (astern) trips the front (back) sensor.
FRONT_DEG = 60.0


class Step(NamedTuple):
    """One motion of a command: degrees clockwise on the spot, or millimetres ahead."""

    turning: bool
    amount: float


def drive(distance_mm: float) -> Step:
    """Straight ahead; back when negative."""
    return Step(turning=False, amount=distance_mm)


def turn(angle_deg: float) -> Step:
    """Clockwise on the spot; counter-clockwise when negative."""
    return Step(turning=True, amount=angle_deg)


def motions(command: m.LogoCommand, odometer: Callable[[], Pose]) -> Iterator[Step]:
    """The motions of a command, each planned from where the odometer says the robot is by then."""
    here = odometer()
    match command:
        case m.Forward():
            yield drive(command.distance_half_mm / 2.0)
        case m.Back():
            yield drive(-command.distance_half_mm / 2.0)
        case m.Left():
            yield turn(-float(command.angle_deg))
        case m.Right():
            yield turn(float(command.angle_deg))
        case m.TurnTo():
            yield _turn_to(command.heading_deg, odometer)
        case m.GoHome():
            yield from _go_to(0.0, 0.0, odometer)
        case m.GoTo() | m.GoToX() | m.GoToY():
            x_mm = here.x_mm if isinstance(command, m.GoToY) else command.x_half_mm / 2.0
            y_mm = here.y_mm if isinstance(command, m.GoToX) else command.y_half_mm / 2.0
            yield from _go_to(x_mm, y_mm, odometer)
            yield _turn_to(here.heading_deg, odometer)  # W10: the heading is kept


def _turn_to(heading_deg: float, odometer: Callable[[], Pose]) -> Step:
    return turn(shorter(heading_deg - odometer().heading_deg))


def _go_to(x_mm: float, y_mm: float, odometer: Callable[[], Pose]) -> Iterator[Step]:
    if odometer().distance_to(x_mm, y_mm) > ARRIVED_MM:
        yield _turn_to(odometer().bearing_to(x_mm, y_mm), odometer)
        yield drive(odometer().distance_to(x_mm, y_mm))


def reply(command: m.LogoCommand, here: Pose, *, pen_down: bool) -> m.RobotMessage | None:
    """The answer to a query; None if the command is none."""
    match command:
        case m.QueryTowards():
            return m.TowardsReply(_degrees(here.bearing_to(command.x_half_mm / 2.0, command.y_half_mm / 2.0)))
        case m.QueryHeading():
            return m.HeadingReply(_degrees(here.heading_deg))
        case m.QueryLocation():
            return m.LocationReply(_half_millimetres(here.x_mm), _half_millimetres(here.y_mm))
        case m.QueryX():
            return m.XReply(_half_millimetres(here.x_mm))
        case m.QueryY():
            return m.YReply(_half_millimetres(here.y_mm))
        case m.QueryPen():
            return m.PenReply(int(pen_down))
    return None


def shorter(angle_deg: float) -> float:
    """The same direction by the shorter way: -180 < angle <= 180."""
    return 180.0 - (180.0 - angle_deg) % 360.0


def sensor(angle_deg: float) -> str:
    """The sensor that a contact at this angle clockwise from ahead trips (W13)."""
    angle = shorter(angle_deg)
    if abs(angle) <= FRONT_DEG:
        return "front"
    if abs(angle) >= 180.0 - FRONT_DEG:
        return "back"
    return "right" if angle > 0.0 else "left"


def _half_up(value: float) -> int:
    """The nearest integer, the upper one of two: what a microcontroller's ``(value + half) >> n`` gives."""
    return math.floor(value + 0.5)


def _degrees(heading_deg: float) -> int:
    return _half_up(heading_deg) % 360


def _half_millimetres(mm: float) -> int:
    """As the wire carries a coordinate; it saturates at 16 bits (W5)."""
    return max(-32768, min(32767, _half_up(mm * 2.0)))
