"""What a plan wants done, and what came of it: the language between the plan and the pump."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from typing import NamedTuple, TypeAlias, TypeVar


class Tune(NamedTuple):
    """Change the port's rate in place: nothing is sent, and nothing resets."""

    baud: int


class Exchange(NamedTuple):
    """Hand over bytes, or none, and listen.

    Attributes:
        data: to be sent, all at once.
        within_s: how long to listen after the bytes were handed over, seconds.
        is_enough: tells of what has come so far that nothing more is wanted.
    """

    data: bytes
    within_s: float
    is_enough: Callable[[bytes], bool] = lambda _: False


class WayOut(NamedTuple):
    """From now on, whatever ends the examination, these bytes are sent last: they stop the robot."""

    data: bytes


class Tell(NamedTuple):
    """Something that people would like to know while they wait: what was heard at a rate."""

    baud: int | None
    what: str


Step: TypeAlias = Tune | Exchange | WayOut | Tell


class Heard(NamedTuple):
    """What came of a step.

    Attributes:
        now_s: seconds since the port was opened, when the step was over.
        data: bytes that came in.
        first_s: seconds from its beginning to the first of them; infinite if there are none.
        took_s: seconds that it took.
        refusal: why it could not be done: a rate that the port does not have.
    """

    now_s: float
    data: bytes = b""
    first_s: float = math.inf
    took_s: float = 0.0
    refusal: str = ""


T = TypeVar("T")
Plan: TypeAlias = Generator[Step, Heard, T]
