"""Workspace management: variables, procedures, property lists."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.logo.errors import LogoError, no_value, unknown_procedure
from turtlewire.logo.primitives.inputs import answer, key, text
from turtlewire.logo.procedures import Chapter, Primitive, UserProcedure
from turtlewire.logo.scope import set_local
from turtlewire.logo.values import NIL, Value, make_list, members_of, plain
from turtlewire.logo.workspace import define_from_list

if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive


# --- variables ------------------------------------------------------------------------------------------------


@primitive("make", 2)
def _make(logo: Interpreter, name: Value, value: Value) -> None:
    logo.variables[key(name)] = value


@primitive("name", 2)
def _name(logo: Interpreter, value: Value, name: Value) -> None:
    logo.variables[key(name)] = value


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


@primitive("global", 1, maximum=-1)
def _global(_logo: Interpreter, inputs: list[Value]) -> None:
    """A global variable comes into being with its value: there is nothing to do but check the names."""
    for each in inputs:
        for name in members_of(each) if isinstance(each, list) else [each]:
            key(name)


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
    procedure = _users(logo, name)
    inputs: list[Value] = [*procedure.inputs]
    inputs += [[each.name, each.default.value] for each in procedure.optional]
    if procedure.rest:
        inputs.append(make_list((procedure.rest,)))
    return [make_list(inputs), make_list([line.value for line in procedure.body])]


def _users(logo: Interpreter, name: Value) -> UserProcedure:
    procedure = logo.procedures.get(key(name))
    if isinstance(procedure, Primitive):
        raise LogoError(22, f"{plain(text(name))} is a primitive")
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


@primitive("arity", 1)
def _arity(logo: Interpreter, name: Value) -> Value:
    procedure = logo.procedures.get(key(name))
    if procedure is None:
        raise unknown_procedure(text(name), list(logo.procedures), number=24)
    return make_list((procedure.minimum_inputs, procedure.default_inputs, procedure.maximum_inputs))


@primitive("erase er", 1)
def _erase(logo: Interpreter, names: Value) -> None:
    for name in members_of(names) if isinstance(names, list) else [names]:
        _users(logo, name).is_erased = True
        del logo.procedures[key(name)]
    logo.epoch += 1
    logo.compiler.forget()


@primitive("ern", 1)
def _ern(logo: Interpreter, names: Value) -> None:
    for name in members_of(names) if isinstance(names, list) else [names]:
        logo.variables.pop(key(name), None)


# --- property lists -------------------------------------------------------------------------------------------


@primitive("pprop", 3)
def _pprop(logo: Interpreter, owner: Value, name: Value, value: Value) -> None:
    logo.property_lists.setdefault(key(owner), {})[key(name)] = value


@primitive("gprop", 2)
def _gprop(logo: Interpreter, owner: Value, name: Value) -> Value:
    value = logo.property_lists.get(key(owner), {}).get(key(name))
    return NIL if value is None else value


@primitive("remprop", 2)
def _remprop(logo: Interpreter, owner: Value, name: Value) -> None:
    logo.property_lists.get(key(owner), {}).pop(key(name), None)


@primitive("plist", 1)
def _plist(logo: Interpreter, owner: Value) -> Value:
    members: list[Value] = []
    for name, value in logo.property_lists.get(key(owner), {}).items():
        members += (name, value)
    return make_list(members)
