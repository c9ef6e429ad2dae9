"""Template-based iteration: APPLY, MAP, FILTER, FOREACH, REDUCE; templates are named procedures, ``?`` or lambda."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from turtlewire.logo.errors import (
    did_not_output,
    does_not_like,
    not_enough_inputs,
    too_many_inputs,
    unknown_procedure,
)
from turtlewire.logo.primitives.inputs import items, natural, text, truth
from turtlewire.logo.procedures import COMMAND, OPERATION, BadInputError, Chapter, Primitive, Result, RunList
from turtlewire.logo.syntax import Call, Invocation
from turtlewire.logo.values import (
    NIL,
    VALUE_TYPES,
    List,
    Value,
    make_list,
    members_of,
    plain,
    show,
    show_in_error,
    word,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive


def apply_template(logo: Interpreter, template: Value, inputs: list[Value], how: int) -> Result:
    """Apply a template to its inputs."""
    if not isinstance(template, list):
        return _apply_named(logo, text(template), inputs, how)
    if template and isinstance(template[0], list):
        return _apply_lambda(logo, template, inputs, how)
    outer, logo.slots = logo.slots, inputs
    try:
        return logo.run_list(template, how)
    finally:
        logo.slots = outer


def _apply_named(logo: Interpreter, name: str, inputs: list[Value], how: int) -> Result:
    procedure = logo.procedures.get(plain(name).lower())
    if procedure is None:
        raise unknown_procedure(name, list(logo.procedures), number=24)
    if len(inputs) < procedure.minimum_inputs:
        raise not_enough_inputs(name)
    if 0 <= procedure.maximum_inputs < len(inputs):
        raise too_many_inputs(name)
    if isinstance(procedure, Primitive):
        try:
            result = logo.call_primitive(procedure, inputs)
        except BadInputError as bad:
            shown = show_in_error(bad.value)
            raise does_not_like(name, shown, number=bad.number, wanted=bad.wanted) from None
        return logo.run_list(result.instructions, how) if isinstance(result, RunList) else result
    return logo.invoke(Invocation(procedure, name, [], None), inputs, wants_value=how == OPERATION)


def _apply_lambda(logo: Interpreter, template: List, inputs: list[Value], how: int) -> Result:
    names = items(template[0])
    if len(names) != len(inputs):
        raise BadInputError(template)
    keys = [plain(text(name)).lower() for name in names if not isinstance(name, list)]
    before = {key: logo.variables.get(key) for key in keys}
    logo.variables.update(zip(keys, inputs, strict=True))
    try:
        return logo.run_list(template[1], how)
    finally:
        for key, value in before.items():
            if value is None:
                logo.variables.pop(key, None)
            else:
                logo.variables[key] = value


def _value(logo: Interpreter, template: Value, inputs: list[Value], wanted_by: str) -> Value:
    result = apply_template(logo, template, inputs, OPERATION)
    if type(result) not in VALUE_TYPES:
        last = logo.parsed(template).last if isinstance(template, list) else None
        name = last.name if isinstance(last, Call | Invocation) else show(template)
        raise did_not_output(name, wanted_by)
    return result  # type: ignore[return-value]


@primitive("?", 0, maximum=1)
def _slot(logo: Interpreter, index: Value = 1) -> Value:
    wanted = natural(index)
    if not 1 <= wanted <= len(logo.slots):
        raise BadInputError(index, 4, "to stand in a template, with as many inputs")
    return logo.slots[wanted - 1]


@primitive("#", 0)
def _number(logo: Interpreter) -> Value:
    """Which member of the data a template is applied to; outside of templates the same as REPCOUNT."""
    return logo.iteration[0] if logo.iteration is not None else logo.repeat_count


@primitive("?rest", 0, maximum=1)
def _rest(logo: Interpreter, index: Value = 1) -> Value:
    wanted = natural(index)
    done, inputs = logo.iteration if logo.iteration is not None else (0, [])
    if not 1 <= wanted <= len(inputs):
        raise BadInputError(index, 4)
    data = inputs[wanted - 1]
    return make_list(members_of(data)[done:]) if isinstance(data, list) else word(text(data)[done:])


@contextmanager
def _iterating(logo: Interpreter, inputs: list[Value]) -> Iterator[Iterator[list[Value]]]:
    """The columns of the inputs, one after the other, while ``#`` and ``?REST`` follow them."""

    def columns() -> Iterator[list[Value]]:
        for index, column in enumerate(_columns(inputs), 1):
            logo.iteration = (index, inputs)
            yield column

    outer = logo.iteration
    try:
        yield columns()
    finally:
        logo.iteration = outer


@primitive("apply", 2)
def _apply(logo: Interpreter, template: Value, inputs: Value) -> Result:
    return apply_template(logo, template, list(items(inputs)), OPERATION)


@primitive("invoke", 2, minimum=1, maximum=-1)
def _invoke(logo: Interpreter, inputs: list[Value]) -> Result:
    return apply_template(logo, inputs[0], inputs[1:], OPERATION)


def _columns(inputs: list[Value]) -> list[list[Value]]:
    """The members of several lists or words, side by side; all must be equally long."""
    rows = [members_of(each) if isinstance(each, list) else [word(c) for c in text(each)] for each in inputs]
    for each, row in zip(inputs, rows, strict=True):
        if len(row) != len(rows[0]):
            raise BadInputError(each)
    return [list(column) for column in zip(*rows, strict=True)]


def like(model: Value, members: list[Value]) -> Value:
    """A list of these members if the model is one, otherwise a word of them."""
    if isinstance(model, list):
        return make_list(members)
    for each in members:
        if isinstance(each, list):
            raise BadInputError(each)
    return word("".join([text(each) for each in members if not isinstance(each, list)]))


@primitive("map", 2, maximum=-1)
def _map(logo: Interpreter, inputs: list[Value]) -> Value:
    with _iterating(logo, inputs[1:]) as columns:
        return like(inputs[1], [_value(logo, inputs[0], column, "map") for column in columns])


@primitive("filter", 2)
def _filter(logo: Interpreter, template: Value, data: Value) -> Value:
    def keeps(column: list[Value]) -> bool:
        return truth(logo, _value(logo, template, column, "filter"))

    with _iterating(logo, [data]) as columns:
        return like(data, [column[0] for column in columns if keeps(column)])


@primitive("find", 2)
def _find(logo: Interpreter, template: Value, data: Value) -> Value:
    with _iterating(logo, [data]) as columns:
        for column in columns:
            if truth(logo, _value(logo, template, column, "find")):
                return column[0]
    return NIL


@primitive("reduce", 2)
def _reduce(logo: Interpreter, template: Value, data: Value) -> Value:
    members = [column[0] for column in _columns([data])]
    if not members:
        raise BadInputError(data)
    result = members.pop()
    while members:
        result = _value(logo, template, [members.pop(), result], "reduce")
    return result


@primitive("foreach", 2, maximum=-1)
def _foreach(logo: Interpreter, inputs: list[Value]) -> Result:
    with _iterating(logo, inputs[:-1]) as columns:
        for column in columns:
            result = apply_template(logo, inputs[-1], column, COMMAND)
            if result is not None:
                return result
    return None
