"""Loops: they hand on a STOP or OUTPUT that comes out of their lists."""

from __future__ import annotations

from turtlewire.logo.errors import did_not_output
from turtlewire.logo.primitives.inputs import key, natural, number, truth
from turtlewire.logo.procedures import COMMAND, BadInputError, Chapter, Result
from turtlewire.logo.tracing import tell_shadowed
from turtlewire.logo.values import Number, Value, members_of, narrowed

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive


@primitive("repeat", 2)
def _repeat(logo: Interpreter, count: Value, instructions: Value) -> Result:
    times = natural(count)
    outer_count = logo.repeat_count
    level = logo.levels.enter(times)
    try:
        for index in range(times):
            if level is not None:
                level[0] = index
            logo.repeat_count = index + 1
            result = logo.run_code(logo.parsed(instructions), COMMAND)
            if result is not None:
                return result
    finally:
        logo.repeat_count = outer_count
        if level is not None:
            logo.levels.leave()
    return None


@primitive("forever", 1)
def _forever(logo: Interpreter, instructions: Value) -> Result:
    outer_count = logo.repeat_count
    count = 0
    try:
        while True:
            count += 1
            logo.repeat_count = count
            result = logo.run_list(instructions)
            if result is not None:
                return result
    finally:
        logo.repeat_count = outer_count


@primitive("repcount", 0)
def _repcount(logo: Interpreter) -> Value:
    return logo.repeat_count


def _loop_number(logo: Interpreter, value: Value) -> Number:
    """A limit of FOR: a number, or a word or list that is run for one."""
    if isinstance(value, int | float):
        return value
    result = logo.value_of(value, single=True)
    if result is None:
        raise BadInputError(value)
    return number(result)


@primitive("for", 2)
def _for(logo: Interpreter, control: Value, instructions: Value) -> Result:
    members = members_of(control) if isinstance(control, list) else []
    if not 3 <= len(members) <= 4:
        raise BadInputError(
            control, wanted="a list of a name, a start, an end and perhaps a step: [i 1 10 2]"
        )
    name = key(members[0])
    start, end = _loop_number(logo, members[1]), _loop_number(logo, members[2])
    ascending = 1 if end >= start else -1
    step = _loop_number(logo, members[3]) if len(members) == 4 else ascending
    # The variable is the loop's own, and what it had before comes back; the program may change it for this round.
    if name in logo.marks.stepped.variables:
        tell_shadowed(logo, name)
    before = logo.variables.get(name)
    level = logo.levels.enter(_rounds(start, end, step))
    current: Number = start
    try:
        while current <= end if step >= 0 else current >= end:
            logo.variables[name] = current
            result = logo.run_list(instructions)
            if result is not None:
                return result
            if level is not None:
                level[0] += 1
            current = narrowed(current + step)
    finally:
        if before is None:
            logo.variables.pop(name, None)
        else:
            logo.variables[name] = before
        if level is not None:
            logo.levels.leave()
    return None


def _rounds(start: Number, end: Number, step: Number) -> int:
    """How often a FOR will run its list, for the progress; 1 when there is no telling."""
    rounds = (end - start) / step + 1 if step else 1
    return int(rounds) if 1 <= rounds < 1e9 else 1


def _while(
    logo: Interpreter, name: str, condition: Value, instructions: Value, *, wanted: bool, test_first: bool
) -> Result:
    if test_first and _truth_of(logo, name, condition) is not wanted:
        return None
    while True:
        result = logo.run_list(instructions)
        if result is not None:
            return result
        if _truth_of(logo, name, condition) is not wanted:
            return None


def _truth_of(logo: Interpreter, name: str, condition: Value) -> bool:
    """The truth that an instruction list outputs; a mere word is run too, so that a forgotten bracket is told."""
    value = logo.value_of(condition, single=True)
    if value is None:
        last = logo.parsed(condition).last
        if last is None:
            raise did_not_output("[]", name)
        value = logo.instead(last, name, None)
    return truth(logo, value)


@primitive("while", 2)
def _while_true(logo: Interpreter, condition: Value, instructions: Value) -> Result:
    return _while(logo, "while", condition, instructions, wanted=True, test_first=True)


@primitive("until", 2)
def _until(logo: Interpreter, condition: Value, instructions: Value) -> Result:
    return _while(logo, "until", condition, instructions, wanted=False, test_first=True)


@primitive("do.while", 2)
def _do_while(logo: Interpreter, instructions: Value, condition: Value) -> Result:
    return _while(logo, "do.while", condition, instructions, wanted=True, test_first=False)


@primitive("do.until", 2)
def _do_until(logo: Interpreter, instructions: Value, condition: Value) -> Result:
    return _while(logo, "do.until", condition, instructions, wanted=False, test_first=False)
