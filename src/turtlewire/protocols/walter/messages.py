"""The messages of WALTER. Generated from spec/protocols/walter.toml by `make generate`: do not edit.

Everything is big endian; RET is CR or CR LF (W1).
"""

from __future__ import annotations

from typing import ClassVar

from turtlewire.protocols.message import Field, Message

BAUD = 9600  # W16
MAX_UNFENCED_BYTES = 48  # W9
QUEUE_COMMANDS = 16  # what a robot must be able to queue
MM_PER_S_PER_UNIT = 1.0  # W14, the nominal robot
DEG_PER_S_PER_UNIT = 1.0  # W14, the nominal robot
DEFAULT_SPEED = 100
ATTENTION = bytes.fromhex("00 00 00 00 00 0D 32 0D 20 31 0D")
EMERGENCY_STOP = bytes.fromhex("00 00 00 00 00 0D 32 0D 20")


class WalterMessage(Message, frozen=True):
    """Any message of WALTER."""

    LETTERS: ClassVar[bytes]


class LogoCommand(WalterMessage, frozen=True):
    """Host to robot in Logo control: letters, binary arguments, RET.

    ``GROUP`` is the capability group (C, Q, H, E) that a robot may lack, or empty (W10).
    ``QUEUED`` tells whether the robot carries it out in order (W9) or when it arrives.
    """

    GROUP: ClassVar[str] = ""
    QUEUED: ClassVar[bool] = True


class DirectKey(WalterMessage, frozen=True):
    """Host to robot in direct control: one key, at most one binary byte, no RET."""


class RobotMessage(WalterMessage, frozen=True):
    """Robot to host in Logo control: letters, binary values, RET."""


class SelectDirect(LogoCommand, frozen=True):
    """Change to direct control. Abandons queued motion at once (W8)."""

    LETTERS: ClassVar[bytes] = b"2"
    QUEUED: ClassVar[bool] = False


class Forward(LogoCommand, frozen=True):
    """Move forward. Logo: FD, FORWARD."""

    LETTERS: ClassVar[bytes] = b"F"
    FIELDS: ClassVar[tuple[Field, ...]] = (Field("distance_half_mm", "u16", 0, 65535, "half millimetres"),)
    distance_half_mm: int


class Back(LogoCommand, frozen=True):
    """Move back. Logo: BK, BACK."""

    LETTERS: ClassVar[bytes] = b"B"
    FIELDS: ClassVar[tuple[Field, ...]] = (Field("distance_half_mm", "u16", 0, 65535, "half millimetres"),)
    distance_half_mm: int


class SetSpeed(LogoCommand, frozen=True):
    """Set the speed of moves and turns."""

    LETTERS: ClassVar[bytes] = b"V"
    FIELDS: ClassVar[tuple[Field, ...]] = (Field("speed", "u8", 0, 255, "speed units (W14)"),)
    speed: int


class Left(LogoCommand, frozen=True):
    """Turn left. Logo: LT, LEFT."""

    LETTERS: ClassVar[bytes] = b"L"
    FIELDS: ClassVar[tuple[Field, ...]] = (Field("angle_deg", "u16", 0, 65535, "degrees"),)
    angle_deg: int


class Right(LogoCommand, frozen=True):
    """Turn right. Logo: RT, RIGHT."""

    LETTERS: ClassVar[bytes] = b"R"
    FIELDS: ClassVar[tuple[Field, ...]] = (Field("angle_deg", "u16", 0, 65535, "degrees"),)
    angle_deg: int


class PenUp(LogoCommand, frozen=True):
    """Lift the pen. Logo: PU, PENUP."""

    LETTERS: ClassVar[bytes] = b"PU"


class PenDown(LogoCommand, frozen=True):
    """Lower the pen. Logo: PD, PENDOWN."""

    LETTERS: ClassVar[bytes] = b"PD"


class HornOff(LogoCommand, frozen=True):
    """Horn off. The source swaps HORNHI and HORNOFF in its third column; the bytes rule (W3). Logo: HORNOFF."""

    LETTERS: ClassVar[bytes] = b"H0"
    GROUP: ClassVar[str] = "H"


class HornLow(LogoCommand, frozen=True):
    """Horn, low pitch. Logo: HORNLO."""

    LETTERS: ClassVar[bytes] = b"HL"
    GROUP: ClassVar[str] = "H"


class HornHigh(LogoCommand, frozen=True):
    """Horn, high pitch (W3). Logo: HORNHI."""

    LETTERS: ClassVar[bytes] = b"HH"
    GROUP: ClassVar[str] = "H"


class LampOn(LogoCommand, frozen=True):
    """Lamp on. Logo: EYESON."""

    LETTERS: ClassVar[bytes] = b"E1"
    GROUP: ClassVar[str] = "E"


class LampOff(LogoCommand, frozen=True):
    """Lamp off. Logo: EYESOFF."""

    LETTERS: ClassVar[bytes] = b"E0"
    GROUP: ClassVar[str] = "E"


class ResetLocation(LogoCommand, frozen=True):
    """Here is X = 0, Y = 0; the heading stays."""

    LETTERS: ClassVar[bytes] = b"CR"
    GROUP: ClassVar[str] = "C"


class GoHome(LogoCommand, frozen=True):
    """Move to X = 0, Y = 0. Does not promise heading 0 (W10). Logo: HOME."""

    LETTERS: ClassVar[bytes] = b"C0"
    GROUP: ClassVar[str] = "C"


class TurnTo(LogoCommand, frozen=True):
    """Turn to an absolute heading. Logo: SETH, SETHEADING."""

    LETTERS: ClassVar[bytes] = b"CH"
    GROUP: ClassVar[str] = "C"
    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("heading_deg", "u16", 0, 65535, "degrees, 0 = +Y, clockwise (W5)"),
    )
    heading_deg: int


class GoTo(LogoCommand, frozen=True):
    """Move to an absolute position; keeps the heading (W10). Logo: SETPOS."""

    LETTERS: ClassVar[bytes] = b"CL"
    GROUP: ClassVar[str] = "C"
    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("x_half_mm", "i16", -32768, 32767, "half millimetres"),
        Field("y_half_mm", "i16", -32768, 32767, "half millimetres"),
    )
    x_half_mm: int
    y_half_mm: int


class GoToX(LogoCommand, frozen=True):
    """Move to an absolute X; keeps Y and the heading (W10). Logo: SETX."""

    LETTERS: ClassVar[bytes] = b"CX"
    GROUP: ClassVar[str] = "C"
    FIELDS: ClassVar[tuple[Field, ...]] = (Field("x_half_mm", "i16", -32768, 32767, "half millimetres"),)
    x_half_mm: int


class GoToY(LogoCommand, frozen=True):
    """Move to an absolute Y; keeps X and the heading (W10). Logo: SETY."""

    LETTERS: ClassVar[bytes] = b"CY"
    GROUP: ClassVar[str] = "C"
    FIELDS: ClassVar[tuple[Field, ...]] = (Field("y_half_mm", "i16", -32768, 32767, "half millimetres"),)
    y_half_mm: int


class QueryTowards(LogoCommand, frozen=True):
    """Ask for the bearing of a point. Logo: TOWARDS."""

    LETTERS: ClassVar[bytes] = b"QT"
    GROUP: ClassVar[str] = "Q"
    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("x_half_mm", "i16", -32768, 32767, "half millimetres"),
        Field("y_half_mm", "i16", -32768, 32767, "half millimetres"),
    )
    x_half_mm: int
    y_half_mm: int


class QueryHeading(LogoCommand, frozen=True):
    """Ask for the heading. Logo: HEADING."""

    LETTERS: ClassVar[bytes] = b"QH"
    GROUP: ClassVar[str] = "Q"


class QueryLocation(LogoCommand, frozen=True):
    """Ask for the location. Logo: POS."""

    LETTERS: ClassVar[bytes] = b"QL"
    GROUP: ClassVar[str] = "Q"


class QueryX(LogoCommand, frozen=True):
    """Ask for the X coordinate. Logo: XCOR."""

    LETTERS: ClassVar[bytes] = b"QX"
    GROUP: ClassVar[str] = "Q"


class QueryY(LogoCommand, frozen=True):
    """Ask for the Y coordinate. Logo: YCOR."""

    LETTERS: ClassVar[bytes] = b"QY"
    GROUP: ClassVar[str] = "Q"


class QueryPen(LogoCommand, frozen=True):
    """Ask whether the pen is down. Logo: PENDOWNP, PENDOWN?."""

    LETTERS: ClassVar[bytes] = b"QP"
    GROUP: ClassVar[str] = "Q"


class EmptyLine(LogoCommand, frozen=True):
    """A lone RET: nothing, but a sign of life that feeds a watchdog (section 4)."""

    LETTERS: ClassVar[bytes] = b""
    QUEUED: ClassVar[bool] = False


class Stop(DirectKey, frozen=True):
    """Immediate stop."""

    LETTERS: ClassVar[bytes] = b" "


class SelectLogo(DirectKey, frozen=True):
    """Change to Logo control. Direct motion stops."""

    LETTERS: ClassVar[bytes] = b"1"


class StartForward(DirectKey, frozen=True):
    """Start moving forward."""

    LETTERS: ClassVar[bytes] = b"A"


class StartBackward(DirectKey, frozen=True):
    """Start moving backward."""

    LETTERS: ClassVar[bytes] = b"Z"


class MoveFaster(DirectKey, frozen=True):
    """Linear speed up by one unit; saturates at 255 (W14)."""

    LETTERS: ClassVar[bytes] = b"D"


class MoveSlower(DirectKey, frozen=True):
    """Linear speed down by one unit; saturates at 0 (W14)."""

    LETTERS: ClassVar[bytes] = b"C"


class TurnFaster(DirectKey, frozen=True):
    """Turning speed up by one unit; saturates at 255 (W14)."""

    LETTERS: ClassVar[bytes] = b"F"


class TurnSlower(DirectKey, frozen=True):
    """Turning speed down by one unit; saturates at 0 (W14)."""

    LETTERS: ClassVar[bytes] = b"V"


class RaisePen(DirectKey, frozen=True):
    """Pen up."""

    LETTERS: ClassVar[bytes] = b"S"


class LowerPen(DirectKey, frozen=True):
    """Pen down."""

    LETTERS: ClassVar[bytes] = b"X"


class SetMoveSpeed(DirectKey, frozen=True):
    """Set the linear speed."""

    LETTERS: ClassVar[bytes] = b"G"
    FIELDS: ClassVar[tuple[Field, ...]] = (Field("speed", "u8", 0, 255, "speed units (W14)"),)
    speed: int


class SetTurnSpeed(DirectKey, frozen=True):
    """Set the turning speed."""

    LETTERS: ClassVar[bytes] = b"B"
    FIELDS: ClassVar[tuple[Field, ...]] = (Field("speed", "u8", 0, 255, "speed units (W14)"),)
    speed: int


class StartLeft(DirectKey, frozen=True):
    """Start turning left."""

    LETTERS: ClassVar[bytes] = b","


class StartRight(DirectKey, frozen=True):
    """Start turning right."""

    LETTERS: ClassVar[bytes] = b"."


class LimitFront(RobotMessage, frozen=True):
    """The front limit sensor tripped (W13)."""

    LETTERS: ClassVar[bytes] = b"LF"


class LimitBack(RobotMessage, frozen=True):
    """The back limit sensor tripped (W13)."""

    LETTERS: ClassVar[bytes] = b"LB"


class LimitLeft(RobotMessage, frozen=True):
    """The left limit sensor tripped (W13)."""

    LETTERS: ClassVar[bytes] = b"LL"


class LimitRight(RobotMessage, frozen=True):
    """The right limit sensor tripped (W13)."""

    LETTERS: ClassVar[bytes] = b"LR"


class TowardsReply(RobotMessage, frozen=True):
    """The bearing that was asked for."""

    LETTERS: ClassVar[bytes] = b"QT"
    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("angle_deg", "u16", 0, 359, "degrees, 0 = +Y, clockwise (W5)"),
    )
    angle_deg: int


class HeadingReply(RobotMessage, frozen=True):
    """The heading."""

    LETTERS: ClassVar[bytes] = b"QH"
    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("heading_deg", "u16", 0, 359, "degrees, 0 = +Y, clockwise (W5)"),
    )
    heading_deg: int


class LocationReply(RobotMessage, frozen=True):
    """The location."""

    LETTERS: ClassVar[bytes] = b"QL"
    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("x_half_mm", "i16", -32768, 32767, "half millimetres"),
        Field("y_half_mm", "i16", -32768, 32767, "half millimetres"),
    )
    x_half_mm: int
    y_half_mm: int


class XReply(RobotMessage, frozen=True):
    """The X coordinate."""

    LETTERS: ClassVar[bytes] = b"QX"
    FIELDS: ClassVar[tuple[Field, ...]] = (Field("x_half_mm", "i16", -32768, 32767, "half millimetres"),)
    x_half_mm: int


class YReply(RobotMessage, frozen=True):
    """The Y coordinate."""

    LETTERS: ClassVar[bytes] = b"QY"
    FIELDS: ClassVar[tuple[Field, ...]] = (Field("y_half_mm", "i16", -32768, 32767, "half millimetres"),)
    y_half_mm: int


class PenReply(RobotMessage, frozen=True):
    """Whether the pen is down (W4)."""

    LETTERS: ClassVar[bytes] = b"QP"
    FIELDS: ClassVar[tuple[Field, ...]] = (Field("down", "bit", 0, 1, "0 = up, 1 = down"),)
    down: int


LOGO_COMMANDS: tuple[type[LogoCommand], ...] = (
    SelectDirect,
    Forward,
    Back,
    SetSpeed,
    Left,
    Right,
    PenUp,
    PenDown,
    HornOff,
    HornLow,
    HornHigh,
    LampOn,
    LampOff,
    ResetLocation,
    GoHome,
    TurnTo,
    GoTo,
    GoToX,
    GoToY,
    QueryTowards,
    QueryHeading,
    QueryLocation,
    QueryX,
    QueryY,
    QueryPen,
    EmptyLine,
)


DIRECT_KEYS: tuple[type[DirectKey], ...] = (
    Stop,
    SelectLogo,
    StartForward,
    StartBackward,
    MoveFaster,
    MoveSlower,
    TurnFaster,
    TurnSlower,
    RaisePen,
    LowerPen,
    SetMoveSpeed,
    SetTurnSpeed,
    StartLeft,
    StartRight,
)


ROBOT_MESSAGES: tuple[type[RobotMessage], ...] = (
    LimitFront,
    LimitBack,
    LimitLeft,
    LimitRight,
    TowardsReply,
    HeadingReply,
    LocationReply,
    XReply,
    YReply,
    PenReply,
)
MESSAGES: tuple[type[WalterMessage], ...] = (*LOGO_COMMANDS, *DIRECT_KEYS, *ROBOT_MESSAGES)
REPLIES: dict[type[LogoCommand], type[RobotMessage]] = {
    QueryTowards: TowardsReply,
    QueryHeading: HeadingReply,
    QueryLocation: LocationReply,
    QueryX: XReply,
    QueryY: YReply,
    QueryPen: PenReply,
}
