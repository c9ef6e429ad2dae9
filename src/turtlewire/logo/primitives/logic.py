"""Logic: AND, OR and NOT. A list as input is run, and only when its truth is still needed."""

from __future__ import annotations

from turtlewire.logo.primitives.inputs import answer, truth
from turtlewire.logo.procedures import Chapter

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.values import Value

chapter = Chapter()
primitive = chapter.primitive


@primitive("and", 2, minimum=0, maximum=-1)
def _and(logo: Interpreter, inputs: list[Value]) -> Value:
    for each in inputs:
        if not truth(logo, each):
            return answer(condition=False)
    return answer(condition=True)


@primitive("or", 2, minimum=0, maximum=-1)
def _or(logo: Interpreter, inputs: list[Value]) -> Value:
    for each in inputs:
        if truth(logo, each):
            return answer(condition=True)
    return answer(condition=False)


@primitive("not", 1)
def _not(logo: Interpreter, value: Value) -> Value:
    return answer(condition=not truth(logo, value))
