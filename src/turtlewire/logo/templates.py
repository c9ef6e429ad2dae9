"""Templates: what MAP and its like apply to each of their data.

A word is the name of a procedure. A list is an expression with slots (``?``), or, when a list of names is its first
member, a lambda: an expression behind them, or nothing but lists, the lines of a procedure without a name.
"""

from __future__ import annotations

from turtlewire.logo.calls import call_primitive, expansion, invoke
from turtlewire.logo.definitions import made_procedure
from turtlewire.logo.errors import (
    does_not_like,
    not_enough_inputs,
    too_many_inputs,
    unknown_procedure,
)
from turtlewire.logo.procedures import (
    OPERATION,
    BadInputError,
    Primitive,
    Result,
    RunList,
    UserProcedure,
)
from turtlewire.logo.syntax import Invocation
from turtlewire.logo.tracing import tell_shadowed
from turtlewire.logo.values import List, Value, members_of, plain, show_in_error, to_text, to_words

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import TypeAlias

    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.reader import Line

_FORMS = "the name of a procedure, or a list with ? in it, or a list that begins with a list of names"


class Named:
    """A template that is a procedure, called by this name."""

    __slots__ = ("name", "procedure")

    def __init__(self, name: str, procedure: Primitive | UserProcedure) -> None:
        self.name = name
        self.procedure = procedure


class Lambda:
    """A template with names for its inputs; ``given`` is all of it."""

    __slots__ = ("body", "given", "keys")

    def __init__(self, keys: list[str], body: List, given: List) -> None:
        self.keys = keys
        self.body = body
        self.given = given


Template: TypeAlias = Named | Lambda | List  # a list is an expression with slots


def template(logo: Interpreter, value: Value, tool: str) -> Template:
    """What a template means; ``tool`` is the primitive that was given it.

    Raises:
        LogoError: no procedure has this name.
        BadInputError: it is an array, or its names are none.
    """
    if isinstance(value, list):
        if not (value and isinstance(value[0], list) and value[1]):
            return value
        return _lambda(logo, value, tool)
    if not isinstance(value, str | int | float):
        raise BadInputError(value, 32, _FORMS)
    name = to_text(value)
    procedure = logo.procedures.get(plain(name).lower())
    if procedure is None or (isinstance(procedure, Primitive) and procedure.name in ("to", ".macro")):
        raise unknown_procedure(name, list(logo.procedures), number=24)
    return Named(name, procedure)


def _lambda(logo: Interpreter, value: List, tool: str) -> Template:
    body: List = value[1]
    lines: list[Line] = []
    for line in members_of(body):
        if not isinstance(line, list):
            keys: list[str] = []
            for name in members_of(value[0]):
                if not isinstance(name, str | int | float):
                    raise BadInputError(value, wanted="a list of names first")
                keys.append(plain(to_text(name)).lower())
            return Lambda(keys, body, value)
        lines.append(logo.line(line))
    return Named(tool, made_procedure(tool, logo.line(value[0]).items, tuple(lines), tool))


def applied(logo: Interpreter, found: Template, inputs: list[Value], how: int = OPERATION) -> Result:
    """Apply a template to its inputs.

    Returns:
        What ``Interpreter.run_list`` does.
    """
    if isinstance(found, Named):
        return _apply_named(logo, found, inputs, how)
    if isinstance(found, Lambda):
        return _apply_lambda(logo, found, inputs, how)
    outer, logo.slots = logo.slots, inputs
    try:
        return logo.run_list(found, how)
    finally:
        logo.slots = outer


def _apply_named(logo: Interpreter, found: Named, inputs: list[Value], how: int) -> Result:
    name, procedure = found.name, found.procedure
    if len(inputs) < procedure.minimum_inputs:
        raise not_enough_inputs(name, procedure.usage(name))
    if 0 <= procedure.maximum_inputs < len(inputs):
        raise too_many_inputs(name, procedure.usage(name))
    if isinstance(procedure, UserProcedure):
        invocation = Invocation(procedure, name, [], None)
        if not procedure.is_macro:
            return invoke(logo, invocation, inputs, wants_value=how == OPERATION)
        result: Result = expansion(logo, invocation, inputs, may_be_empty=True)
    else:
        try:
            result = call_primitive(logo, procedure, inputs)
        except BadInputError as bad:
            shown = show_in_error(bad.value)
            raise does_not_like(name, shown, number=bad.number, wanted=bad.wanted) from None
    return logo.run_list(result.instructions, how) if isinstance(result, RunList) else result


def _apply_lambda(logo: Interpreter, found: Lambda, inputs: list[Value], how: int) -> Result:
    keys, variables = found.keys, logo.variables
    if len(inputs) != len(keys):
        shown = to_words(found.given)
        raise not_enough_inputs(shown) if len(inputs) < len(keys) else too_many_inputs(shown)
    for key in keys:
        if key in logo.marks.stepped.variables:
            tell_shadowed(logo, key)
    hidden = [variables.get(key) for key in keys]
    for index, key in enumerate(keys):
        variables[key] = inputs[index]
    try:
        return logo.run_list(found.body, how)
    finally:
        for index, key in enumerate(keys):
            put_back(logo, key, hidden[index])


def put_back(logo: Interpreter, key: str, value: Value | None) -> None:
    """Give a variable the value that it had before; none, when it had none."""
    if value is None:
        logo.variables.pop(key, None)
    else:
        logo.variables[key] = value
