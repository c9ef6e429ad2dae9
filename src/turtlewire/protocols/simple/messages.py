"""The messages of simple. Generated from spec/protocols/simple.toml by `make generate`: do not edit."""

from __future__ import annotations

from typing import ClassVar

from turtlewire.protocols.message import Field, Message

BAUD = 9600  # S6
LENGTH = 7  # bytes of every command
DONT_CARE = b"0"  # S2
MAX_WINDOW = 8  # S9
PROBE = bytes.fromhex("53")
EMERGENCY_STOP = bytes.fromhex("53 53 53 53 53 53 53 53 53 53 53 53 53 53")


class SimpleMessage(Message, frozen=True):
    """Any message of simple: ``LETTER`` is its first byte."""

    LETTER: ClassVar[bytes]


class SimpleCommand(SimpleMessage, frozen=True):
    """Host to robot: one letter and six positions.

    ``CHANNEL`` is what a set-point sets (S9), empty for the stop. ``SIGN`` is what its value counts as there.
    ``STOPPED`` tells whether a stop ends it (S5).

    A command of one's own (S10) is a subclass with a letter and a channel of its own, and with fields for up to six
    positions: a ``u16`` of at most 999 or a ``u8`` takes three of them, a ``bit`` one. Both ends are told of it.
    """

    CHANNEL: ClassVar[str] = ""
    SIGN: ClassVar[int] = 1
    STOPPED: ClassVar[bool] = False


class Reply(SimpleMessage, frozen=True):
    """Robot to host: one byte, after every seven bytes received (S4)."""


class DriveForward(SimpleCommand, frozen=True):
    """Drive forward until told otherwise."""

    LETTER: ClassVar[bytes] = b"F"
    CHANNEL: ClassVar[str] = "drive"
    STOPPED: ClassVar[bool] = True
    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("speed", "u8", 0, 255, "PWM: 0 stands still, 255 is full speed"),
    )
    speed: int


class DriveBackward(SimpleCommand, frozen=True):
    """Drive backward until told otherwise. The source's text repeats forward's: a copy slip (S1)."""

    LETTER: ClassVar[bytes] = b"B"
    CHANNEL: ClassVar[str] = "drive"
    SIGN: ClassVar[int] = -1
    STOPPED: ClassVar[bool] = True
    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("speed", "u8", 0, 255, "PWM: 0 stands still, 255 is full speed"),
    )
    speed: int


class SteerLeft(SimpleCommand, frozen=True):
    """Turn the front wheels left."""

    LETTER: ClassVar[bytes] = b"L"
    CHANNEL: ClassVar[str] = "steer"
    SIGN: ClassVar[int] = -1
    STOPPED: ClassVar[bool] = True
    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("lock", "u8", 0, 255, "PWM: 0 is straight, 255 is full lock"),
    )
    lock: int


class SteerRight(SimpleCommand, frozen=True):
    """Turn the front wheels right."""

    LETTER: ClassVar[bytes] = b"R"
    CHANNEL: ClassVar[str] = "steer"
    STOPPED: ClassVar[bool] = True
    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("lock", "u8", 0, 255, "PWM: 0 is straight, 255 is full lock"),
    )
    lock: int


class Stop(SimpleCommand, frozen=True):
    """Stop the motors: drive and steering are 0 then, headlights stay as they are (S5)."""

    LETTER: ClassVar[bytes] = b"S"


class Headlights(SimpleCommand, frozen=True):
    """Switch all four headlights."""

    LETTER: ClassVar[bytes] = b"H"
    CHANNEL: ClassVar[str] = "lights"
    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("left_upper", "bit", 0, 1, "0 = off, 1 = on"),
        Field("left_lower", "bit", 0, 1, "0 = off, 1 = on"),
        Field("right_upper", "bit", 0, 1, "0 = off, 1 = on"),
        Field("right_lower", "bit", 0, 1, "0 = off, 1 = on"),
    )
    left_upper: int
    left_lower: int
    right_upper: int
    right_lower: int


class Accepted(Reply, frozen=True):
    """The seven bytes were a valid command, and it is carried out (S4)."""

    LETTER: ClassVar[bytes] = b"K"


class Rejected(Reply, frozen=True):
    """The seven bytes were no valid command, and nothing has changed (S4)."""

    LETTER: ClassVar[bytes] = b"F"


COMMANDS: tuple[type[SimpleCommand], ...] = (
    DriveForward,
    DriveBackward,
    SteerLeft,
    SteerRight,
    Stop,
    Headlights,
)


REPLIES: tuple[type[Reply], ...] = (
    Accepted,
    Rejected,
)
MESSAGES: tuple[type[SimpleMessage], ...] = (*COMMANDS, *REPLIES)
