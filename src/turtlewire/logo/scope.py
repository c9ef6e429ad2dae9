"""Dynamic scope: the inputs and locals of a procedure, which hide what their names meant before until it ends."""

from __future__ import annotations

from turtlewire.logo import errors
from turtlewire.logo.errors import LogoError
from turtlewire.logo.procedures import OPERATION, OptionalInput, Result, UserProcedure
from turtlewire.logo.syntax import Call, Invocation
from turtlewire.logo.tracing import tell_shadowed
from turtlewire.logo.values import VALUE_TYPES, Value, make_list, show_in_error

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter


def bind(logo: Interpreter, procedure: UserProcedure, inputs: list[Value], name: str) -> None:
    """Give the inputs their values; what the names meant before is remembered once per running procedure."""
    variables, hidden = logo.variables, logo.hidden
    count = len(procedure.inputs)
    if procedure.is_erased:
        raise errors.unknown_procedure(name, list(logo.procedures))
    if len(inputs) < count:  # only when it was defined anew since the call was parsed
        raise errors.not_enough_inputs(name)
    index = 0
    stepped = logo.marks.stepped.variables
    for key in procedure.inputs:
        if stepped and key in stepped:
            tell_shadowed(logo, key)
        if key not in hidden:
            hidden[key] = variables.get(key)
        variables[key] = inputs[index]
        index += 1
    if len(inputs) == count and not procedure.optional and not procedure.rest:
        return
    for optional in procedure.optional:
        if index < len(inputs):
            value: Result = inputs[index]
        else:
            value = _default(logo, optional, name)
        index += 1
        set_local(logo, optional.name, value, is_input=True)  # type: ignore[arg-type]
    if procedure.rest:
        set_local(logo, procedure.rest, make_list(inputs[index:]), is_input=True)
    elif index < len(inputs):
        raise errors.too_many_inputs(name)


def _default(logo: Interpreter, optional: OptionalInput, wanted_by: str) -> Result:
    """The value of an optional input that was not given."""
    code = logo.parsed(optional.default.value)
    if code.instructions:
        shown = show_in_error([optional.name, optional.default.value])
        raise LogoError(37, f"Bad default expression for optional input: {shown}")
    value = logo.run_code(code, OPERATION)
    if type(value) not in VALUE_TYPES:
        last = code.last
        raise errors.did_not_output(last.name if isinstance(last, Call | Invocation) else "[]", wanted_by)
    return value


def set_local(logo: Interpreter, key: str, value: Value | None, *, is_input: bool = False) -> None:
    """Make a variable local to the running procedure, with a value or without; at top level it is global."""
    if key in logo.marks.stepped.variables and (is_input or logo.procedure is not None):
        tell_shadowed(logo, key)
    if key not in logo.hidden:
        logo.hidden[key] = logo.variables.get(key)
    if value is None:
        logo.variables.pop(key, None)
    else:
        logo.variables[key] = value
