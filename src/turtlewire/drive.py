"""Driving by hand: the interface of everything that has a speed and a direction.

Whoever steers a robot by keyboard, joystick or program in small steps uses only this; ``turtle.Turtle`` is for
distances and angles.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

from turtlewire.errors import MessageError


class Drive(ABC):
    """A robot that can be driven."""

    @abstractmethod
    def drive(self, speed: float, turn: float, *, valid_s: float | None = None) -> None:
        """Go on so until told otherwise.

        A newer set-point replaces an older one that has not gone out: a joystick never builds a backlog.

        Args:
            speed: -1 (full speed backwards) to 1 (full speed ahead).
            turn: -1 (fully to the left) to 1 (fully to the right). What that is depends on the robot: steered wheels,
                or a turn on the spot.
            valid_s: the robot is stopped when no newer set-point has come for so long; None: it goes on.

        Raises ``MessageError`` for a number outside, ``LinkError`` and ``RobotError``.
        """

    @abstractmethod
    def stop(self) -> None:
        """Stop at once, ahead of everything; another thread that was drawing with the robot gets ``StoppedError``."""

    @property
    @abstractmethod
    def features(self) -> frozenset[str]:
        """What else the robot has: ``"headlights"``, ``"pen"``, ``"horn"``, ``"lamp"``, ``"servos"``, ``"limits"``."""


def checked(name: str, value: float) -> float:
    """Return a set-point. Raises ``MessageError`` unless -1 <= value <= 1."""
    if not (math.isfinite(value) and -1.0 <= value <= 1.0):
        raise MessageError(f"{name} is {value}, but must be from -1 to 1")
    return value
