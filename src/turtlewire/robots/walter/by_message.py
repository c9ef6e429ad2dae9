"""Messages to a WALTER as somebody wrote them: each is sent as it stands, and the driver keeps account of what it does.

The two messages that change between Logo control and direct control are refused: which of them the robot is in is the
driver's to know, at every byte.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.errors import MessageError, UsageError
from turtlewire.protocols.walter.messages import (
    REPLIES,
    Back,
    DirectKey,
    EmptyLine,
    Forward,
    HornHigh,
    HornLow,
    HornOff,
    LampOff,
    LampOn,
    Left,
    LogoCommand,
    PenDown,
    PenUp,
    Right,
    SelectDirect,
    SelectLogo,
    SetSpeed,
)
from turtlewire.robots.exact_pose import Move, Step, Turn
from turtlewire.robots.walter.attention import PEN_S

if TYPE_CHECKING:
    from turtlewire.protocols.message import AnyMessage
    from turtlewire.robots.walter.absolute import AbsoluteMoves
    from turtlewire.robots.walter.by_hand import ByHand
    from turtlewire.robots.walter.connection import Connection


class ByMessage:
    """Messages to one robot.

    Args:
        wire: to it.
        by_hand: its direct control.
        absolute: its commands of group C.
    """

    def __init__(self, wire: Connection, by_hand: ByHand, absolute: AbsoluteMoves) -> None:
        self._wire = wire
        self._by_hand = by_hand
        self._absolute = absolute

    @staticmethod
    def checked(message: AnyMessage) -> LogoCommand | DirectKey:
        """A message that may be sent. Raises ``MessageError`` and ``UsageError``."""
        if not isinstance(message, LogoCommand | DirectKey):
            raise MessageError(f"{message.name()} is what a WALTER says, or no message of its protocol")
        if isinstance(message, SelectDirect | SelectLogo):
            raise UsageError(
                f"{message.name()}: the driver changes between Logo control and direct control by itself; send a "
                "command of Logo control (forward 200), or a key of direct control (start_forward)"
            )
        if isinstance(message, SetSpeed) and not message.speed:
            raise MessageError(
                "set_speed: with a speed of 0 no motion would ever end; it must be from 1 to 255"
            )
        return message.check()

    async def send(self, message: LogoCommand | DirectKey, valid_s: float | None) -> None:
        """Send a message that was ``checked``; see ``AsyncRobot.send``."""
        wire = self._wire
        if isinstance(message, DirectKey):
            await self._by_hand.press(message, valid_s=valid_s)
            return
        await wire.ready()
        if message.GROUP:
            wire.need(message.GROUP, f"has no {message.name()}")
        match message:
            case Forward(amount) | Back(amount):
                self._move(message, amount if isinstance(message, Forward) else -amount)
            case Right(amount) | Left(amount):
                self._turn(message, amount if isinstance(message, Right) else -amount)
            case PenUp() | PenDown():
                wire.pen_down = isinstance(message, PenDown)
                wire.submit(message, PEN_S)
            case SetSpeed(speed):
                wire.speed = speed
                wire.submit(message, 0.0)
            case HornOff() | HornLow() | HornHigh() | LampOn() | LampOff() | EmptyLine():
                wire.submit(message, 0.0)
            case _ if type(message) in REPLIES:
                await wire.ask(message)
            case _:
                await self._absolute.carry_out(message)
        await wire.until(lambda: wire.host.unsent == 0)

    def _move(self, command: LogoCommand, units: int) -> None:
        position = self._wire.where.position
        self._step(command, Move(units, position.robot.moved(units * position.unit_mm)))

    def _turn(self, command: LogoCommand, angle_deg: int) -> None:
        position = self._wire.where.position
        pose = position.robot.turned(angle_deg * position.unit_deg)
        self._wire.where.turning(pose, angle_deg)
        self._step(command, Turn(angle_deg, pose))

    def _step(self, command: LogoCommand, step: Step) -> None:
        """It is the robot that is told to: the turtle is where that leads."""
        wire = self._wire
        amount = abs(step.angle_deg if isinstance(step, Turn) else step.units)
        wire.submit(command, wire.duration_s(step, amount), step.pose)
        wire.where.position.robot = wire.where.position.exact = step.pose
