"""Numbers that no robot is asked for: refused before any byte leaves."""

from __future__ import annotations

import math

from turtlewire.errors import MessageError
from turtlewire.turtle import TONES

# What one command may ask for: a kilometre, or a million degrees or seconds. A robot is not meant to go on for days
# before the next command, nor the host to split a move into more commands than it has memory for.
LARGEST = 1e6
FULL_SPEED = 255
# By hand, no motion is held for longer than this.
LONGEST_HOLD_S = 60.0


def check(name: str, value: float) -> None:
    """Raises ``MessageError`` for what no command may ask for."""
    # Not math.isfinite: an int may be larger than any float. Nor is nan between anything.
    if not -LARGEST <= value <= LARGEST:
        raise MessageError(f"{name} must be a number from {-LARGEST:.0f} to {LARGEST:.0f}")


def check_speed(speed: int) -> None:
    """Raises ``MessageError`` for a speed at which nothing ever arrives."""
    check("speed", speed)
    if not 1 <= speed <= FULL_SPEED:
        raise MessageError(
            f"speed is {speed}, but must be from 1 to {FULL_SPEED}: at 0 the robot would never arrive"
        )


def check_tone(tone: str) -> None:
    """Raises ``MessageError`` for a tone that no horn has."""
    if tone not in TONES:
        raise MessageError(f"there is no horn tone {tone!r}: the tones are {', '.join(TONES)}")


def check_hold(seconds: float, settle_s: float | None) -> None:
    """Raises ``MessageError`` for times that no motion is to be held for, or waited for."""
    if not 0.0 < seconds <= LONGEST_HOLD_S:
        raise MessageError(f"seconds is {seconds}, but must be above 0, and at most {LONGEST_HOLD_S:g}")
    if settle_s is not None and not 0.0 <= settle_s <= LONGEST_HOLD_S:
        raise MessageError(f"settle_s is {settle_s}, but must be from 0 to {LONGEST_HOLD_S:g}, or None")


def check_valid_s(valid_s: float | None) -> None:
    """Raises ``MessageError`` for a time to live that is none."""
    if valid_s is not None and not 0.0 < valid_s < math.inf:
        raise MessageError(f"valid_s is {valid_s}, but must be above 0 seconds, or None")
