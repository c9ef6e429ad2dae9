"""Template-based iteration: APPLY, MAP, FILTER, FOREACH, REDUCE, CASCADE and their like."""

from __future__ import annotations

import math

from turtlewire.logo.errors import did_not_output, unknown_procedure
from turtlewire.logo.primitives.inputs import items, natural, text, truth
from turtlewire.logo.procedures import COMMAND, BadInputError, Chapter, Result
from turtlewire.logo.syntax import Call, Invocation
from turtlewire.logo.templates import Template, applied, put_back, template
from turtlewire.logo.values import NIL, VALUE_TYPES, Value, make_list, members_of, show, word

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive

_EQUALLY_LONG = "data of equal length, as many members in each"


def _value(logo: Interpreter, found: Template, inputs: list[Value], given: Value, tool: str) -> Value:
    """What a template outputs; ``given`` is the template as the tool was given it."""
    result = applied(logo, found, inputs)
    if type(result) not in VALUE_TYPES:
        last = logo.parsed(given).last if isinstance(given, list) else None
        if isinstance(last, Call | Invocation):
            return logo.instead(last, tool, None)
        raise did_not_output(show(given), tool)
    return result  # type: ignore[return-value]


# --- slots ----------------------------------------------------------------------------------------------------


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
        raise BadInputError(index, 4, "to stand in a template, with as many data")
    data = inputs[wanted - 1]
    return make_list(members_of(data)[done:]) if isinstance(data, list) else word(text(data)[done:])


@primitive("?in", 0)
def _in(logo: Interpreter) -> Value:
    if logo.baskets is None:
        raise unknown_procedure("?in")
    return logo.baskets[0]


@primitive("?out", 0)
def _out(logo: Interpreter) -> Value:
    if logo.baskets is None:
        raise unknown_procedure("?out")
    return logo.baskets[1]


# --- data -----------------------------------------------------------------------------------------------------


def _members(data: Value) -> list[Value]:
    """The members of a list, or the letters of a word."""
    if isinstance(data, list):
        return members_of(data)
    return [word(letter) for letter in text(data)]


def _columns(inputs: list[Value]) -> list[list[Value]]:
    """The members of several lists or words, side by side; all must be equally long."""
    rows = [_members(each) for each in inputs]
    for each, row in zip(inputs, rows, strict=True):
        if len(row) != len(rows[0]):
            raise BadInputError(each, wanted=_EQUALLY_LONG)
    return [list(column) for column in zip(*rows, strict=True)]


def like(model: Value, members: list[Value]) -> Value:
    """A list of these members, or a word of them, as the model is one."""
    if isinstance(model, list):
        return make_list(members)
    return word("".join([text(each) for each in members]))


# --- apply ----------------------------------------------------------------------------------------------------


@primitive("apply", 2)
def _apply(logo: Interpreter, given: Value, inputs: Value) -> Result:
    return applied(logo, template(logo, given, "apply"), items(inputs))


@primitive("invoke", 2, minimum=1, maximum=-1)
def _invoke(logo: Interpreter, inputs: list[Value]) -> Result:
    return applied(logo, template(logo, inputs[0], "invoke"), inputs[1:])


# --- for each of the data -------------------------------------------------------------------------------------


@primitive("foreach", 2, maximum=-1)
def _foreach(logo: Interpreter, inputs: list[Value]) -> Result:
    data = inputs[:-1]
    columns = _columns(data)
    found = template(logo, inputs[-1], "foreach")
    outer = logo.iteration
    level = logo.levels.enter(len(columns))
    count = 0
    try:
        for column in columns:
            count += 1
            logo.iteration = (count, data)
            result = applied(logo, found, column, COMMAND)
            if result is not None:
                return result
            if level is not None:
                level[0] = count
    finally:
        logo.iteration = outer
        if level is not None:
            logo.levels.leave()
    return None


def _mapped(logo: Interpreter, inputs: list[Value], tool: str) -> list[Value]:
    """What the template that comes first outputs for each of the data that come behind it."""
    data = inputs[1:]
    columns = _columns(data)
    found = template(logo, inputs[0], tool)
    outer = logo.iteration
    outputs: list[Value] = []
    try:
        for column in columns:
            logo.iteration = (len(outputs) + 1, data)
            outputs.append(_value(logo, found, column, inputs[0], tool))
    finally:
        logo.iteration = outer
    return outputs


@primitive("map", 2, maximum=-1)
def _map(logo: Interpreter, inputs: list[Value]) -> Value:
    return like(inputs[1], _mapped(logo, inputs, "map"))


@primitive("map.se", 2, maximum=-1)
def _map_se(logo: Interpreter, inputs: list[Value]) -> Value:
    members: list[Value] = []
    for each in _mapped(logo, inputs, "map.se"):
        if isinstance(each, list):
            members += members_of(each)
        else:
            text(each)
            members.append(each)
    return make_list(members)


@primitive("filter", 2)
def _filter(logo: Interpreter, given: Value, data: Value) -> Value:
    return like(data, _true_members(logo, given, data, "filter", only_one=False))


@primitive("find", 2)
def _find(logo: Interpreter, given: Value, data: Value) -> Value:
    found = _true_members(logo, given, data, "find", only_one=True)
    return found[0] if found else NIL


def _true_members(logo: Interpreter, given: Value, data: Value, tool: str, *, only_one: bool) -> list[Value]:
    """The members for which a template outputs true; at most the first of them if only one is wanted."""
    found = template(logo, given, tool)
    outer = logo.iteration
    true_members: list[Value] = []
    count = 0
    try:
        for member in _members(data):
            count += 1
            logo.iteration = (count, [data])
            if truth(logo, _value(logo, found, [member], given, tool)):
                true_members.append(member)
                if only_one:
                    break
    finally:
        logo.iteration = outer
    return true_members


@primitive("reduce", 2)
def _reduce(logo: Interpreter, given: Value, data: Value) -> Value:
    members = _members(data)
    if not members:
        raise BadInputError(data, wanted="at least one member to begin with")
    found = template(logo, given, "reduce")
    result = members.pop()
    while members:
        result = _value(logo, found, [members.pop(), result], given, "reduce")
    return result


@primitive("crossmap", 2, maximum=-1)
def _crossmap(logo: Interpreter, inputs: list[Value]) -> Value:
    """Every combination of members; ``:1`` is another way to write ``?1``."""
    data = inputs[1:] if len(inputs) > 2 else _members(inputs[1])
    rows = [_members(each) for each in data]
    found = template(logo, inputs[0], "crossmap")
    outputs: list[Value] = []
    keys = [str(index + 1) for index in range(len(rows))]
    hidden = [logo.variables.get(key) for key in keys]
    places = [0] * len(rows)
    total = math.prod([len(row) for row in rows])
    try:
        while len(outputs) < total:
            column = [row[place] for row, place in zip(rows, places, strict=True)]
            for key, member in zip(keys, column, strict=True):
                logo.variables[key] = member
            outputs.append(_value(logo, found, column, inputs[0], "crossmap"))
            for index in range(len(rows) - 1, -1, -1):
                places[index] = (places[index] + 1) % len(rows[index])
                if places[index]:
                    break
    finally:
        for key, value in zip(keys, hidden, strict=True):
            put_back(logo, key, value)
    return make_list(outputs)


# --- again and again ------------------------------------------------------------------------------------------


@primitive("cascade", 3, minimum=2, maximum=-1)
def _cascade(logo: Interpreter, inputs: list[Value]) -> Value:
    return _cascaded(logo, inputs, "cascade")


@primitive("cascade.2", 5, minimum=2, maximum=-1)
def _cascade_2(logo: Interpreter, inputs: list[Value]) -> Value:
    return _cascaded(logo, inputs, "cascade.2")


def _cascaded(logo: Interpreter, inputs: list[Value], tool: str) -> Value:
    """Templates applied to what all of them output the time before, until the end test; then the last template."""
    end_test = inputs[0]
    final = inputs[-1] if len(inputs) % 2 == 0 else None
    pairs = inputs[1:] if final is None else inputs[1:-1]
    given, slots = pairs[::2], pairs[1::2]
    found = [template(logo, each, tool) for each in given]
    rounds = _rounds(end_test)
    test = template(logo, end_test, tool) if rounds is None else None
    outer = logo.iteration
    count = 1
    try:
        while True:
            logo.iteration = (count, [])
            if test is None:
                if rounds is not None and count > rounds:
                    break
            elif truth(logo, _value(logo, test, slots, end_test, tool)):
                break
            outputs: list[Value] = []
            while (index := len(outputs)) < len(found):
                outputs.append(_value(logo, found[index], slots, given[index], tool))
            slots = outputs
            count += 1
        if final is not None:
            return _value(logo, template(logo, final, tool), slots, final, tool)
    finally:
        logo.iteration = outer
    return slots[0]


def _rounds(end_test: Value) -> int | None:
    """How often, when the end test is a number and no template."""
    if not isinstance(end_test, int | float):
        return None
    if not 0 <= end_test < math.inf:
        raise BadInputError(end_test, wanted="a number of times, or a template that outputs true or false")
    return int(end_test)


@primitive("transfer", 3)
def _transfer(logo: Interpreter, end_test: Value, given: Value, inbasket: Value) -> Value:
    rest = make_list(_members(inbasket))
    found = template(logo, given, "transfer")
    has_test = not (isinstance(end_test, list) and not end_test)
    test = template(logo, end_test, "transfer") if has_test else None
    outer, outer_iteration = logo.baskets, logo.iteration
    out: Value = NIL
    count = 0
    try:
        while rest:
            count += 1
            logo.baskets, logo.iteration = (rest[0], out), (count, [])
            slots = [out, rest]
            if test is not None and truth(logo, _value(logo, test, slots, end_test, "transfer")):
                break
            out = _value(logo, found, slots, given, "transfer")
            rest = rest[1]
    finally:
        logo.baskets, logo.iteration = outer, outer_iteration
    return out
