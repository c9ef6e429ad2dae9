"""Definitions: from the title line of a TO to a procedure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.logo.errors import LogoError, does_not_like, not_enough_inputs
from turtlewire.logo.procedures import BadInputError, OptionalInput, Primitive, UserProcedure
from turtlewire.logo.reader import Line, value_of
from turtlewire.logo.values import Value, members_of, plain, show

if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.reader import Definition, Item


_NAME = "a name, without any sign before it or behind it"
_INPUTS = "nothing but the inputs in this line, each with a colon, as in :size; the instructions begin in the next line"


def define_from_title(logo: Interpreter, definition: Definition) -> None:
    """Carry out a TO.

    Raises:
        LogoError: no name, a name that is a number, a list or a primitive's, or inputs that are none.
    """
    title = definition.title
    try:
        if len(title.items) < 2:
            raise not_enough_inputs(str(title.items[0]))
        define(logo, title.items[1], title.items[2:], definition.body, title, str(title.items[0]))
    except LogoError as error:
        error.position = title.position(1)
        raise


def define_from_list(logo: Interpreter, name: Item, definition: Value, command: str) -> None:
    """Carry out a DEFINE or .DEFMACRO: a list of the list of the inputs and a list for each line.

    Raises:
        LogoError: see ``define_from_title``.
        BadInputError: the definition is no such list.
    """
    lines: list[Line] = []
    for each in members_of(definition) if isinstance(definition, list) else []:
        if not isinstance(each, list):
            lines = []
            break
        lines.append(logo.line(each))
    if not lines:
        raise BadInputError(definition, wanted="a list of lists: the inputs, and each line")
    define(logo, name, lines[0].items, tuple(lines[1:]), command=command)


def define(
    logo: Interpreter,
    name: Item,
    inputs: tuple[Item, ...],
    body: tuple[Line, ...],
    title: Line | None = None,
    command: str = "to",
) -> None:
    """Define a procedure, or define it anew.

    Raises:
        LogoError: see ``define_from_title``; errors name ``command``.
    """
    is_to = command.lower() in ("to", ".macro")
    if not isinstance(name, str) or ((is_to and name[:1] in ':"') or "(" in name):
        raise does_not_like(command, show(value_of(name)), number=4 if is_to else 7, wanted=_NAME)
    key = plain(name).lower()
    procedure = logo.procedures.get(key)
    if isinstance(procedure, Primitive):
        number, problem = (15, "already defined") if is_to else (22, "a primitive")
        raise LogoError(number, f"{plain(name)} is {problem}", hint="It is a primitive: choose another name.")
    fresh = UserProcedure(plain(name))
    fresh.default_inputs = -1
    for each in inputs:
        _add_input(fresh, each, command)
    fresh.minimum_inputs = len(fresh.inputs)
    fresh.maximum_inputs = -1 if fresh.rest else len(fresh.inputs) + len(fresh.optional)
    if fresh.default_inputs < 0:
        fresh.default_inputs = fresh.minimum_inputs
    fresh.is_macro = command.lower() in (".macro", ".defmacro")
    fresh.body = body
    fresh.title = title
    if procedure is None:
        logo.procedures[key] = fresh
    else:
        for slot in UserProcedure.__slots__:
            setattr(procedure, slot, getattr(fresh, slot))
    logo.epoch += 1
    logo.compiler.forget()


def _add_input(procedure: UserProcedure, each: Item, command: str) -> None:
    """Add one member of a title line: ``:required``, then ``[:optional default]``, ``[:rest]``, a number of inputs."""
    if isinstance(each, int) and procedure.default_inputs < 0:
        most = float("inf") if procedure.rest else len(procedure.inputs) + len(procedure.optional)
        if not len(procedure.inputs) <= each <= most:
            raise does_not_like(command, show(value_of(each)), number=4, wanted=_INPUTS)
        procedure.default_inputs = each  # how many inputs are taken without parentheses
    elif isinstance(each, str) and not ("(" in each or procedure.optional or procedure.rest):
        procedure.inputs.append(_input_name(each))
    elif isinstance(each, Line) and each.items and not procedure.rest and isinstance(each.items[0], str):
        name = _input_name(each.items[0])
        if len(each.items) == 1:
            procedure.rest = name
        else:
            procedure.optional.append(OptionalInput(name, each.rest()))
    else:
        raise does_not_like(command, show(value_of(each)), number=4, wanted=_INPUTS)


def _input_name(text: str) -> str:
    return plain(text).lstrip(':"').lower()
