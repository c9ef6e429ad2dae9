"""Definitions: from the title line of a TO to a procedure."""

from __future__ import annotations

from turtlewire.logo.errors import (
    LogoError,
    does_not_like,
    is_primitive,
    not_enough_inputs,
    unknown_procedure,
)
from turtlewire.logo.library import LIBRARY
from turtlewire.logo.procedures import BadInputError, OptionalInput, Primitive, UserProcedure
from turtlewire.logo.reader import Line, value_of
from turtlewire.logo.tokens import PRECEDENCE
from turtlewire.logo.values import TRUE, Value, members_of, plain, show

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.reader import Definition, Item


# The parser makes calls of these itself.
_KEPT = frozenset([*PRECEDENCE, "minus", "make", "{}"])
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
        defined = define(logo, title.items[1], title.items[2:], definition.body, title, str(title.items[0]))
        defined.full_text = definition.text
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
) -> UserProcedure:
    """Define a procedure, or define it anew.

    Raises:
        LogoError: see ``define_from_title``; errors name ``command``.
    """
    is_to = command.lower() in ("to", ".macro")
    if not isinstance(name, str) or ((is_to and name[:1] in ':"') or "(" in name):
        raise does_not_like(command, show(value_of(name)), number=4 if is_to else 7, wanted=_NAME)
    key = plain(name).lower()
    procedure = logo.procedures.get(key)
    if isinstance(procedure, Primitive) and not may_redefine(logo, key):
        number, problem = (15, "already defined") if is_to else (22, "a primitive")
        raise LogoError(number, f"{plain(name)} is {problem}", hint="It is a primitive: choose another name.")
    fresh = made_procedure(plain(name), inputs, body, command)
    fresh.is_macro = command.lower() in (".macro", ".defmacro")
    fresh.title = title
    logo.epoch += 1
    if isinstance(procedure, UserProcedure):
        _take_over(procedure, fresh)
        return procedure
    logo.procedures[key] = fresh
    return fresh


def _take_over(procedure: UserProcedure, fresh: UserProcedure) -> None:
    for slot in UserProcedure.__slots__:
        setattr(procedure, slot, getattr(fresh, slot))


def may_redefine(logo: Interpreter, name: str) -> bool:
    """Whether a primitive can be given another meaning.

    Those of the library can at any time, others while REDEFP is true, unless the parser relies on them.
    """
    if name in LIBRARY:
        return True
    setting = logo.variables.get("redefp")
    return isinstance(setting, str) and setting.lower() == TRUE and name not in _KEPT


def copy_definition(logo: Interpreter, new_name: str, old_name: str) -> None:
    """Make a name mean what another one means now.

    Raises:
        LogoError: there is nothing to copy, or the new name is a primitive's.
    """
    key = new_name.lower()
    old, existing = logo.procedures.get(old_name.lower()), logo.procedures.get(key)
    if old is None:
        raise unknown_procedure(old_name, list(logo.procedures))
    if isinstance(existing, Primitive) and not may_redefine(logo, key):
        raise is_primitive(new_name)
    logo.epoch += 1
    if isinstance(old, Primitive):
        logo.procedures[key] = old
        if isinstance(existing, UserProcedure):
            existing.is_erased = True
        return
    copy = UserProcedure(new_name)
    _take_over(copy, old)
    copy.name, copy.code = new_name, None
    if old.full_text:
        command, _, rest = old.full_text[0].partition(" ")
        copy.full_text = (f"{command} {new_name}{rest.lstrip()[len(old.name) :]}", *old.full_text[1:])
    if isinstance(existing, UserProcedure):
        _take_over(existing, copy)
    else:
        logo.procedures[key] = copy


def made_procedure(
    name: str, inputs: tuple[Item, ...], body: tuple[Line, ...], command: str
) -> UserProcedure:
    """A procedure that nothing is called by yet.

    Raises:
        LogoError: inputs that are none; it names ``command``.
    """
    made = UserProcedure(name)
    made.default_inputs = -1
    for each in inputs:
        _add_input(made, each, command)
    made.minimum_inputs = len(made.inputs)
    made.maximum_inputs = -1 if made.rest else len(made.inputs) + len(made.optional)
    if made.default_inputs < 0:
        made.default_inputs = made.minimum_inputs
    made.body = body
    return made


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
