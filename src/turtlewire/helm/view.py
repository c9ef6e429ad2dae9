"""What is to be seen of a robot: immutable, so that one thread makes it and another shows it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from collections.abc import Mapping

    from turtlewire.helm.wire import Line

# How sure the pose is: seen (a simulated robot), told by the robot itself, or reckoned from what it was told.
Certainty = Literal["seen", "told", "reckoned"]
Level = Literal["note", "warning", "error"]


class Notice(NamedTuple):
    """Something that people should know.

    Attributes:
        time_s: when it was, since the link was opened.
        number: counts up from 1, for ever.
        code: what it is, for machines: ``limit``, ``link``; "": nothing in particular.
        sensor, pose: of a limit.
    """

    time_s: float
    level: Level
    text: str
    number: int = 0
    code: str = ""
    sensor: str = ""
    pose: Pose | None = None


class View(NamedTuple):
    """The robot at one moment.

    Attributes:
        time_s: since the link was opened.
        pose, certainty: where it is, in millimetres and degrees from where it stood at first.
        distance_mm: how far it has moved, there and back counted.
        speed_mm_per_s, turn_deg_per_s: how fast it was a moment ago; ahead and clockwise.
        pen_down, lamp, horn: None where the robot has none, or nothing is known of it.
        link: ``connected``, ``reconnecting``, ``stopped`` or ``closed``.
        figures: of the connection, by name.
        jumped: it is not where it was reckoned to be, and no way leads there; counted.
    """

    time_s: float = 0.0
    pose: Pose = HOME
    certainty: Certainty = "reckoned"
    distance_mm: float = 0.0
    speed_mm_per_s: float = 0.0
    turn_deg_per_s: float = 0.0
    pen_down: bool | None = None
    lamp: bool | None = None
    horn: bool = False
    link: str = "connected"
    figures: Mapping[str, Any] = {}
    lines: tuple[Line, ...] = ()
    notices: tuple[Notice, ...] = ()
    jumped: int = 0
