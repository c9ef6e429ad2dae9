"""What robots have and screens have not: horn, lamp, speed, waiting, limit sensors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.logo.primitives.inputs import finite, integer
from turtlewire.logo.procedures import BadInputError, Chapter

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
    logo.set_limit_handler(handler or None)


@primitive("limitsensor", 0)
def _limitsensor(logo: Interpreter) -> Value:
    """The sensor of the limit reached last; the empty word before the first."""
    return logo.limit_sensor
