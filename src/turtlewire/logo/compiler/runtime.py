"""What compiled procedures call."""

from __future__ import annotations

import sys

from turtlewire.logo import blame
from turtlewire.logo.primitives import inputs
from turtlewire.logo.primitives.predicates import ignores_case
from turtlewire.logo.primitives.templates import like
from turtlewire.logo.procedures import BadInputError, Output, Stop
from turtlewire.logo.syntax import Code
from turtlewire.logo.values import (
    NIL,
    VALUE_TYPES,
    Array,
    Number,
    SpelledNumber,
    Value,
    equal,
    members_of,
    narrowed,
    to_text,
    word,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from types import FrameType
    from typing import Any

    from turtlewire.logo.compiler.faults import Record
    from turtlewire.logo.evaluator import Interpreter

CAN_BE_EMPTY = frozenset((str, list))
LISTS = frozenset((list,))
NUMBERS = frozenset((int, float, SpelledNumber))
WORDS = NUMBERS | {str}
BEGIN_NUMBERS = frozenset("0123456789.-")
_SPELLED_ALIKE = 10**15  # whole numbers below are spelled as Python spells them


# What letters ASCII is quickly told of.
CODES = {chr(code): code for code in range(33, 127)}


class _Letters(dict[str, Value]):
    """Letters as words: digits are numbers."""

    def __missing__(self, letter: str) -> str:
        return letter


LETTERS = _Letters({str(digit): digit for digit in range(10)})


class SilentError(Exception):
    """A procedure was to output, and did not."""


class UnusedError(Exception):
    """A value that no command takes."""

    def __init__(self, value: Value) -> None:
        super().__init__(value)
        self.value = value


class ConditionError(BadInputError):
    """What is neither true nor false; "nothing", where a list that was to output this output nothing."""


class LateError(Exception):
    """A procedure that took another one's place output, and was not to; or the other way.

    Attributes:
        number: of the instruction by which it took the place.
        value: what it output, ``None``: nothing.
        record: that of the function in which the instruction stands; ``None``: the one that raised this.
    """

    def __init__(self, number: int, value: Value | None, record: Record | None = None) -> None:
        super().__init__(number)
        self.number = number
        self.value = value
        self.record = record


def unused(value: Value) -> None:
    """Raise ``UnusedError``."""
    raise UnusedError(value)


def silent() -> None:
    """Raise ``SilentError``."""
    raise SilentError


def late_value(site: int, value: Value) -> None:
    """Raise ``LateError``: a command has output."""
    raise LateError(site, value)


def late_silence(site: int) -> None:
    """Raise ``LateError``: an operation has not."""
    raise LateError(-site, None)


def finished(result: Any) -> Value | None:
    """The value of a procedure that what a limit sensor started has ended."""
    if isinstance(result, Output):
        return result.value
    if isinstance(result, Stop):
        return None
    raise UnusedError(result)


def each_of(value: Value) -> list[Value]:
    """The members of a list, or the letters of a word."""
    if type(value) is list:
        return members_of(value)
    return [word(letter) for letter in inputs.text(value)]


def backwards(value: Value) -> list[Value]:
    """The members of what is to be reduced: of at least one."""
    members = each_of(value)
    if not members:
        raise BadInputError(value, wanted="at least one member to begin with")
    return members


def joined(a: Value, b: Value) -> Value:
    """WORD of two words."""
    if type(b) is int and -_SPELLED_ALIKE < b < _SPELLED_ALIKE:
        b = str(b)
    if type(a) is str and type(b) is str:
        return a + b if a and a[0] not in BEGIN_NUMBERS else word(a + b)
    return word(inputs.text(a) + inputs.text(b))


def direction(start: Number, end: Number) -> int:
    """Which way a FOR counts that does not say so."""
    return 1 if end >= start else -1


def numbers(start: Number, end: Number, step: Number) -> Iterable[Number]:
    """The numbers of a FOR."""
    if type(start) is int and type(end) is int and type(step) is int and step:
        return range(start, end + (1 if step > 0 else -1), step)
    return _counted(start, end, step)


def _counted(current: Number, end: Number, step: Number) -> Iterator[Number]:
    while current <= end if step >= 0 else current >= end:
        yield current
        current += step


def bounce(jump: Any) -> Value | None:
    """Do the calls that were left to the caller, one after the other; the value of the last."""
    result: Any = jump
    record, number = None, 0
    while type(result) is tuple:
        function, record, number, *given = result
        count = len(given)
        if count == 1:  # each in a way that needs no stack of C's
            result = function(given[0])
        elif count == 2:
            result = function(given[0], given[1])
        elif count == 3:
            result = function(given[0], given[1], given[2])
        elif count == 0:
            result = function()
        elif count == 4:
            result = function(given[0], given[1], given[2], given[3])
        else:
            result = function(*given)
    if (result is None) is not (number > 0):
        raise LateError(abs(number), result, record)
    return result  # type: ignore[no-any-return]


def value_within(logo: Interpreter, instructions: Value, frame: FrameType) -> Value | None:
    """What a list outputs that a compiled function runs: it sees, and says, what it would if that was evaluated."""
    node, owner = logo.compiler.node_at(frame)
    outer = logo.procedure, logo.body
    if owner is not None:
        line = blame.line_of(owner, node.place)
        logo.procedure, logo.body = owner, (Code([], logo.epoch, (line,) if line is not None else ()), [0])
    hidden: dict[str, Value | None] = {}
    for key, local in logo.compiler.locals_from(frame).items():
        hidden[key] = logo.variables.get(key)
        logo.variables[key] = local
    try:
        return logo.value_of(instructions)
    finally:
        logo.procedure, logo.body = outer
        for key, before in hidden.items():
            if before is None:
                logo.variables.pop(key, None)
            else:
                logo.variables[key] = before


def helpers(logo: Interpreter) -> dict[str, Any]:
    """By their names, what compiled procedures call, and what they use."""

    def same(a: Value, b: Value) -> bool:
        kind = type(a)
        if kind is type(b):
            if kind is str:
                if a == b:
                    return True
                if len(a) != len(b) and a.isascii() and b.isascii():  # type: ignore[arg-type,union-attr]
                    return False
            elif kind is int:
                return a == b
        return equal(a, b, ignore_case=ignores_case(logo))

    def truth_from_list(value: Any) -> bool:
        try:
            return inputs.as_truth(value)
        except BadInputError as bad:
            raise ConditionError(bad.value, bad.number, bad.wanted) from None

    def truth(value: Any) -> bool:
        if value is None:
            raise SilentError
        return truth_from_list(value_within(logo, value, sys._getframe(1)) if type(value) is list else value)

    def enter_loop(times: int | Iterable[Number]) -> list[int] | None:
        if isinstance(times, int):
            return logo.levels.enter(times)
        return logo.levels.enter(len(times) if isinstance(times, range) else 1)

    return {
        "logo": logo,
        "V": logo.variables,
        "NIL": NIL,
        "Array": Array,
        "CAN_BE_EMPTY": CAN_BE_EMPTY,
        "CODES": CODES,
        "LETTERS": LETTERS,
        "LISTS": LISTS,
        "NUMBERS": NUMBERS,
        "WORDS": WORDS,
        "narrowed": narrowed,
        "same": same,
        "truth": truth,
        "truth_from_list": truth_from_list,
        "natural": inputs.natural,
        "number": inputs.number,
        "unused": unused,
        "silent": silent,
        "late_value": late_value,
        "late_silence": late_silence,
        "finished": finished,
        "each_of": each_of,
        "backwards": backwards,
        "joined": joined,
        "like": like,
        "direction": direction,
        "numbers": numbers,
        "bounce": bounce,
        "enter": logo.levels.enter,
        "enter_loop": enter_loop,
        "leave": logo.levels.leave,
    }


__all__ = ["VALUE_TYPES", "LateError", "SilentError", "UnusedError", "helpers", "to_text"]
