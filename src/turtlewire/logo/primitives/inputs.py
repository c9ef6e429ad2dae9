"""Checks of a primitive's inputs: each gives the input as the type that is wanted, or does not like it."""

from __future__ import annotations

import math

from turtlewire.logo.procedures import BadInputError
from turtlewire.logo.values import FALSE, TRUE, Number, Value, members_of, plain, to_number, to_text

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter


_TRUTH = "true or false, as a comparison outputs it"


def number(value: Value) -> Number:
    """A number."""
    if isinstance(value, int | float):
        return value
    raise BadInputError(value, wanted="a number")


def finite(value: Value) -> Number:
    """A number that a robot can be given: not infinite, nor undefined."""
    found = number(value)
    if not math.isfinite(found):
        raise BadInputError(value, wanted="a finite number")
    return found


def integer(value: Value) -> int:
    """A whole number, however it is spelled."""
    found = number(value)
    if not math.isfinite(found) or found != int(found):
        raise BadInputError(value, wanted="a whole number")
    return int(found)


def natural(value: Value) -> int:
    """A whole number, 0 or more."""
    found = integer(value)
    if found < 0:
        raise BadInputError(value, wanted="a whole number, 0 or more")
    return found


def text(value: Value) -> str:
    """The text of a word, marks included."""
    if isinstance(value, str | int | float):
        return to_text(value)
    raise BadInputError(value, wanted="a word, and no list")


def key(value: Value) -> str:
    """A name, in the spelling that tables use."""
    return plain(text(value)).lower()


def items(value: Value) -> list[Value]:
    """The members of a list."""
    if not isinstance(value, list):
        raise BadInputError(value, wanted="a list in brackets")
    return members_of(value)


def truth(logo: Interpreter, value: Value) -> bool:
    """``true`` or ``false``; a list is run to get one."""
    return as_truth(logo.value_of(value) if isinstance(value, list) else value)


def as_truth(found: Value | None) -> bool:
    """``true`` or ``false``; ``None`` is a list that output nothing."""
    if found is None:
        raise BadInputError("nothing", wanted=_TRUTH)
    lowered = found.lower() if isinstance(found, str) else ""
    if lowered == TRUE:
        return True
    if lowered == FALSE:
        return False
    raise BadInputError(found, wanted=_TRUTH)


def point(value: Value) -> tuple[float, float]:
    """A list of two numbers."""
    members = members_of(value) if isinstance(value, list) else []
    numbers = [to_number(member) for member in members]
    if len(numbers) != 2 or numbers[0] is None or numbers[1] is None:
        raise BadInputError(value, wanted="a list of two numbers, as in [30 40]")
    return float(numbers[0]), float(numbers[1])


def answer(*, condition: bool) -> str:
    """A predicate's output."""
    return TRUE if condition else FALSE
