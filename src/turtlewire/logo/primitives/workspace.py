"""Workspace management: variables, procedures, property lists."""

from __future__ import annotations

from turtlewire.logo.definitions import copy_definition, define_from_list
from turtlewire.logo.errors import LogoError, is_primitive, no_value, unknown_procedure
from turtlewire.logo.primitives.inputs import answer, key, text
from turtlewire.logo.primitives.predicates import ignores_case
from turtlewire.logo.printout import full_text
from turtlewire.logo.procedures import Chapter, Primitive, UserProcedure
from turtlewire.logo.receiving import read_list
from turtlewire.logo.scope import set_local
from turtlewire.logo.tracing import tell_property, tell_variable
from turtlewire.logo.values import NIL, List, Value, make_list, members_of, plain, word

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive


# --- variables ------------------------------------------------------------------------------------------------


@primitive("make", 2)
def _make(logo: Interpreter, name: Value, value: Value) -> None:
    variable = key(name)
    logo.variables[variable] = value
    if variable in logo.marks.traced.variables:
        tell_variable(logo, plain(text(name)), value)


@primitive("name", 2)
def _name(logo: Interpreter, value: Value, name: Value) -> None:
    _make(logo, name, value)


@primitive("thing", 1)
def _thing(logo: Interpreter, name: Value) -> Value:
    value = logo.variables.get(key(name))
    if value is None:
        raise no_value(text(name), list(logo.variables))
    return value


@primitive("namep name?", 1)
def _namep(logo: Interpreter, name: Value) -> Value:
    return answer(condition=key(name) in logo.variables)


@primitive("local", 1, maximum=-1)
def _local(logo: Interpreter, inputs: list[Value]) -> None:
    for each in inputs:
        for name in members_of(each) if isinstance(each, list) else [each]:
            local_key = key(name)
            if logo.procedure is not None:
                set_local(logo, local_key, None)


@primitive("localmake", 2)
def _localmake(logo: Interpreter, name: Value, value: Value) -> None:
    set_local(logo, key(name), value)
    if key(name) in logo.marks.traced.variables:
        tell_variable(logo, plain(text(name)), value)


@primitive("global", 1, maximum=-1)
def _global(logo: Interpreter, inputs: list[Value]) -> None:
    """A global variable comes into being with its value; from now on SET... gives it one."""
    for each in inputs:
        for name in members_of(each) if isinstance(each, list) else [each]:
            logo.marks.declared.add(key(name))


# --- procedures -----------------------------------------------------------------------------------------------


@primitive("to", 0, maximum=-1)
def _to(_logo: Interpreter, _inputs: list[Value]) -> None:
    raise LogoError(
        23,
        "can't use TO inside a procedure",
        hint="TO must be the first word of a line, outside of brackets.",
    )


@primitive("define", 2)
def _define(logo: Interpreter, name: Value, definition: Value) -> None:
    define_from_list(logo, name, definition, command="define")


@primitive("text", 1)
def _text(logo: Interpreter, name: Value) -> Value:
    procedure = users(logo, name)
    inputs: list[Value] = [*procedure.inputs]
    inputs += [[each.name, each.default.value] for each in procedure.optional]
    if procedure.rest:
        inputs.append(make_list((procedure.rest,)))
    if procedure.default_inputs != procedure.minimum_inputs:
        inputs.append(procedure.default_inputs)
    return [make_list(inputs), make_list([line.value for line in procedure.body])]


@primitive("fulltext", 1)
def _fulltext(logo: Interpreter, name: Value) -> Value:
    procedure = users(logo, name)
    if procedure.full_text:
        return make_list([word(line) for line in procedure.full_text])
    return make_list([read_list(line) for line in full_text(procedure)])


@primitive("copydef", 2)
def _copydef(logo: Interpreter, new_name: Value, old_name: Value) -> None:
    new, old = plain(text(new_name)), plain(text(old_name))
    copy_definition(logo, new, old)


def users(logo: Interpreter, name: Value) -> UserProcedure:
    """The user's procedure with a name.

    Raises:
        LogoError: there is none, or it is a primitive.
    """
    procedure = logo.procedures.get(key(name))
    if isinstance(procedure, Primitive):
        raise is_primitive(plain(text(name)))
    if procedure is None:
        raise unknown_procedure(text(name), list(logo.procedures), number=24)
    return procedure


@primitive("procedurep procedure?", 1)
def _procedurep(logo: Interpreter, name: Value) -> Value:
    return answer(condition=key(name) in logo.procedures)


@primitive("primitivep primitive?", 1)
def _primitivep(logo: Interpreter, name: Value) -> Value:
    return answer(condition=isinstance(logo.procedures.get(key(name)), Primitive))


@primitive("definedp defined?", 1)
def _definedp(logo: Interpreter, name: Value) -> Value:
    return answer(condition=isinstance(logo.procedures.get(key(name)), UserProcedure))


# --- property lists -------------------------------------------------------------------------------------------


def _property_key(logo: Interpreter, name: Value) -> str:
    return key(name) if ignores_case(logo) else plain(text(name))


@primitive("pprop", 3)
def _pprop(logo: Interpreter, owner: Value, name: Value, value: Value) -> None:
    properties = logo.property_lists.setdefault(key(owner), {})
    property_key = _property_key(logo, name)
    known = properties.get(property_key)
    properties[property_key] = (name if known is None else known[0], value)
    if key(owner) in logo.marks.traced.property_lists:
        tell_property(logo, plain(text(owner)), plain(text(name)), value)


@primitive("gprop", 2)
def _gprop(logo: Interpreter, owner: Value, name: Value) -> Value:
    found = logo.property_lists.get(key(owner), {}).get(_property_key(logo, name))
    return NIL if found is None else found[1]


@primitive("remprop", 2)
def _remprop(logo: Interpreter, owner: Value, name: Value) -> None:
    logo.property_lists.get(key(owner), {}).pop(_property_key(logo, name), None)


@primitive("plist", 1)
def _plist(logo: Interpreter, owner: Value) -> Value:
    return property_members(logo, key(owner))


def property_members(logo: Interpreter, owner: str) -> List:
    """Names and values of a property list by turns, the newest property first."""
    members: list[Value] = []
    for name, value in reversed(logo.property_lists.get(owner, {}).values()):
        members += (name, value)
    return make_list(members)
