"""Every error that turtlewire raises on purpose, in one tree.

Each class knows the exit code that the command line ends with when it is not handled:
1 the program or the data is wrong, 2 wrong usage, 3 the robot or the link to it.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import ClassVar


class TurtlewireError(Exception):
    """The root: whoever catches this catches everything that turtlewire raises on purpose.

    ``str(error)`` is one paragraph for people: what was wrong, where, and what to do about it.
    """

    exit_code: ClassVar[int] = 1


class UsageError(TurtlewireError):
    """Options, a URL or a setting that mean nothing, or that contradict one another."""

    exit_code = 2


class DataError(TurtlewireError):
    """Data handed to turtlewire is wrong: a file, a value out of range, bytes that mean nothing."""


class ProgramError(DataError):
    """A robot program is wrong. Logo's own errors (``turtlewire.logo``) are a kind of this."""


class MessageError(DataError, ValueError):
    """A message that its protocol cannot carry (a field out of range, a wrong type).

    Raised before any byte of it leaves the host.

    Args:
        text: what is wrong.
        place: of a message that was read from text, where in it: the first character of what is wrong, and the one
            behind its last. None: it was not read from text, or all of it is wrong.
    """

    def __init__(self, text: str, place: tuple[int, int] | None = None) -> None:
        super().__init__(text)
        self.place = place


class OutputError(DataError):
    """A picture or other result could not be written (disk full, no permission, unknown format)."""


class LinkError(TurtlewireError):
    """Something is wrong with the way to the robot."""

    exit_code = 3


class PortNotFoundError(LinkError):
    """There is no such port, or nobody listens at that address."""


class PortBusyError(LinkError):
    """The port is in use by another program: a robot has one host at a time."""


class LinkLostError(LinkError):
    """The link ended while it was in use: unplugged, or closed by the other side. It is being opened again.

    The robot may be moving until it is reached again. Motion goes on only after ``resume``, and where the robot is then
    has to be found out: what was under way is never sent again (S8, W15).
    """


class LinkClosedError(LinkError):
    """There is no link: it was closed, it was never opened, or it ended and is not, or no longer, tried again."""


class RobotError(TurtlewireError):
    """The robot did not do what it was told."""

    exit_code = 3


class NoReplyError(RobotError):
    """The robot does not answer, though it should."""


class PoseUncertainError(RobotError):
    """Where the robot is, is no longer known: moves or answers were lost on the way (W15)."""


class StoppedError(RobotError):
    """The robot was stopped, from elsewhere, while this waited: the motion it waited for is abandoned."""


class LimitReachedError(RobotError):
    """A limit sensor stopped the robot (W13).

    Attributes:
        sensor: ``"front"``, ``"back"``, ``"left"`` or ``"right"``.
        x_mm, y_mm: where the robot says it is, or where it should be when it does not answer.
        heading_deg: 0 = +Y, clockwise.
    """

    def __init__(self, sensor: str, x_mm: float, y_mm: float, heading_deg: float) -> None:
        super().__init__(
            f"the {sensor} limit sensor stopped the robot at x {x_mm:g} mm, y {y_mm:g} mm, "
            f"heading {heading_deg:g} degrees; what had been sent ahead was abandoned. "
            "Move it free, or handle it in the program (Logo: ONLIMIT [ ... ])"
        )
        self.sensor = sensor
        self.x_mm = x_mm
        self.y_mm = y_mm
        self.heading_deg = heading_deg


class NotSupportedError(RobotError):
    """The robot lacks the hardware or the commands for this (no horn, no lamp)."""
