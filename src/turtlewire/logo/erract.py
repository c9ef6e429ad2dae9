"""ERRACT: the instructions that a program wants to be run when there is an error; what they output may stand in for it.

Within them ERRACT has no value, so that an error there is an error.
"""

from __future__ import annotations

from turtlewire.logo.errors import does_not_like
from turtlewire.logo.procedures import OPERATION, ThrowError
from turtlewire.logo.syntax import Call, Literal
from turtlewire.logo.values import VALUE_TYPES, equal, show_in_error

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.errors import LogoError
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.procedures import BadInputError, Result
    from turtlewire.logo.syntax import Invocation, Node
    from turtlewire.logo.values import Value

# Those of the manual's appendix after which a program can go on with another value.
_RECOVERABLE = frozenset((5, 7, 11, 13))


def value_instead(logo: Interpreter, error: LogoError) -> Value:
    """The value to go on with instead of an error.

    Raises:
        LogoError: the error, when there is no ERRACT, when it outputs nothing, or when nothing can stand in for it.
    """
    action = logo.variables.get("erract")
    if action is None or error.is_known:
        error.is_known = True
        raise error
    error.is_known = True
    outer, logo.acting_on = logo.acting_on, error
    logo.last_error = error
    del logo.variables["erract"]
    try:
        result = logo.run_list(action, OPERATION)
    finally:
        logo.acting_on = outer
        logo.variables.setdefault("erract", action)
    if type(result) in VALUE_TYPES and error.number in _RECOVERABLE:
        return result  # type: ignore[return-value]
    raise error


def refuse_loop(logo: Interpreter, bad: Value, value: Value) -> None:
    """A value that is to stand in for a bad one may not be equal to it: that would go on for ever.

    Raises:
        ThrowError: to the top level, when it is.
    """
    if equal(bad, value):
        logo.write("Erract loop\n")
        raise ThrowError("toplevel", None)


def call_again(
    logo: Interpreter, node: Call | Invocation, inputs: list[Value], bad: BadInputError, how: int
) -> Result:
    """Call a primitive again with another value instead of an input that it does not like.

    Raises:
        LogoError: nothing is to stand in for it; see ``value_instead``.
        ThrowError: the same again.
    """
    error = does_not_like(node.name, show_in_error(bad.value), number=bad.number, wanted=bad.wanted)
    value = logo.fail(error, node.place)
    if isinstance(node, Call):
        for index, each in enumerate(inputs):
            if each is bad.value:
                literals: list[Node] = [Literal(given, node.place) for given in inputs]
                literals[index] = Literal(value, node.place)
                refuse_loop(logo, bad.value, value)
                return logo.evaluate(Call(node.primitive, node.name, literals, node.place), how)
    raise error
