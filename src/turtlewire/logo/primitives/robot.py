"""What robots have and screens have not: horn, lamp, speed, waiting, limit sensors."""

from __future__ import annotations

from turtlewire.logo.events import set_limit_handler
from turtlewire.logo.primitives.inputs import finite, integer, text
from turtlewire.logo.procedures import COMMAND, OPERATION, BadInputError, Chapter, Result
from turtlewire.logo.values import make_list, members_of, plain, word

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.values import Value

chapter = Chapter()
primitive = chapter.primitive

_SLOWEST, _FASTEST = 1, 255
_SIXTIETHS_PER_SECOND = 60.0


@primitive("hornoff", 0)
def _hornoff(logo: Interpreter) -> None:
    logo.turtle.horn("off")


@primitive("hornlo", 0)
def _hornlo(logo: Interpreter) -> None:
    logo.turtle.horn("low")


@primitive("hornhi", 0)
def _hornhi(logo: Interpreter) -> None:
    logo.turtle.horn("high")


@primitive("eyeson", 0)
def _eyeson(logo: Interpreter) -> None:
    logo.turtle.lamp(on=True)


@primitive("eyesoff", 0)
def _eyesoff(logo: Interpreter) -> None:
    logo.turtle.lamp(on=False)


@primitive("setspeed", 1)
def _setspeed(logo: Interpreter, speed: Value) -> None:
    found = integer(speed)
    if not _SLOWEST <= found <= _FASTEST:
        raise BadInputError(speed, wanted=f"a speed from {_SLOWEST} to {_FASTEST}")
    logo.turtle.set_speed(found)


@primitive("wait", 1)
def _wait(logo: Interpreter, sixtieths: Value) -> None:
    found = finite(sixtieths)
    if found < 0:
        raise BadInputError(sixtieths, wanted="a number of sixtieths of a second, 0 or more")
    logo.turtle.wait(found / _SIXTIETHS_PER_SECOND)


@primitive("onlimit", 1)
def _onlimit(logo: Interpreter, handler: Value) -> None:
    if not isinstance(handler, list):
        raise BadInputError(handler, wanted="a list of instructions, or [] for none")
    set_limit_handler(logo, handler or None)


@primitive("limitsensor", 0)
def _limitsensor(logo: Interpreter) -> Value:
    """The sensor of the limit reached last; the empty word before the first."""
    return logo.events.sensor


@primitive("onstop", 1)
def _onstop(logo: Interpreter, handler: Value) -> None:
    if not isinstance(handler, list):
        raise BadInputError(handler, wanted="a list of instructions, or [] for none")
    logo.events.stop = handler or None


# --- several robots -------------------------------------------------------------------------------------------


def _names(logo: Interpreter, value: Value) -> tuple[str, ...]:
    """The names of turtles that a word or list means, each of them once."""
    found: dict[str, None] = {}
    for each in members_of(value) if isinstance(value, list) else [value]:
        name = logo.turtles.name_of(plain(text(each)))
        if name is None:
            raise BadInputError(each, wanted=f"the name of a robot: {', '.join(logo.turtles.names)}")
        found[name] = None
    if not found:
        raise BadInputError(value, wanted=f"at least one robot: {', '.join(logo.turtles.names)}")
    return tuple(found)


@primitive("tell", 1)
def _tell(logo: Interpreter, names: Value) -> None:
    logo.turtle = logo.turtles.tell(_names(logo, names))


@primitive("who", 0)
def _who(logo: Interpreter) -> Value:
    """The name of the robot that is told, or a list of several."""
    told = logo.turtles.told
    return word(told[0]) if len(told) == 1 else make_list([word(name) for name in told])


@primitive("ask", 2)
def _ask(logo: Interpreter, names: Value, instructions: Value) -> Result:
    outer, how = logo.turtles.told, OPERATION if logo.value_wanted else COMMAND
    logo.turtle = logo.turtles.tell(_names(logo, names))
    try:
        return logo.run_list(instructions, how)
    finally:
        logo.turtle = logo.turtles.tell(outer)


@primitive("each", 1)
def _each(logo: Interpreter, instructions: Value) -> Result:
    outer = logo.turtles.told
    try:
        for name in outer:
            logo.turtle = logo.turtles.tell((name,))
            result = logo.run_list(instructions)
            if result is not None:
                return result
    finally:
        logo.turtle = logo.turtles.tell(outer)
    return None
