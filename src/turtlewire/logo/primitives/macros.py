"""Macros, and the backquote that makes their lists."""

from __future__ import annotations

from turtlewire.logo.blame import refuse_several
from turtlewire.logo.calls import inputs_of, invoke
from turtlewire.logo.definitions import define_from_list
from turtlewire.logo.errors import LogoError, did_not_output
from turtlewire.logo.primitives.inputs import answer, key, text
from turtlewire.logo.procedures import BadInputError, Chapter, UserProcedure
from turtlewire.logo.syntax import Call, Invocation
from turtlewire.logo.values import Array, List, Value, make_list, members_of, show_in_error, word

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive


@primitive(".macro", 0, maximum=-1)
def _macro(_logo: Interpreter, _inputs: list[Value]) -> None:
    raise LogoError(
        23,
        "can't use .MACRO inside a procedure",
        hint=".MACRO must be the first word of a line, outside of brackets.",
    )


@primitive(".defmacro", 2)
def _defmacro(logo: Interpreter, name: Value, definition: Value) -> None:
    define_from_list(logo, name, definition, command=".defmacro")


@primitive("macrop macro?", 1)
def _macrop(logo: Interpreter, name: Value) -> Value:
    procedure = logo.procedures.get(key(name))
    return answer(condition=isinstance(procedure, UserProcedure) and procedure.is_macro)


@primitive("macroexpand", 1)
def _macroexpand(logo: Interpreter, expression: Value) -> Value:
    """What a macro outputs when it is invoked as the expression does it."""
    code = logo.parsed(expression)
    node = code.instructions[0] if code.instructions else code.last
    if not isinstance(node, Invocation) or not node.procedure.is_macro:
        first = expression[0] if isinstance(expression, list) and expression else expression
        if isinstance(first, list) and not first:
            raise BadInputError(expression, wanted="a list that invokes a macro")
        raise LogoError(35, f"{show_in_error(first)} is not a macro.")
    refuse_several(code)
    expansion = invoke(logo, node, inputs_of(logo, node), wants_value=True)
    if expansion is None:
        raise did_not_output(node.name, "macroexpand")
    return expansion


# --- backquote ------------------------------------------------------------------------------------------------


class _Open:
    """A list that is being copied: what is left of it, what was made of it, and how many backquotes it is within."""

    __slots__ = ("depth", "made", "rest")

    def __init__(self, rest: List, depth: int) -> None:
        self.rest = rest
        self.depth = depth
        self.made: list[Value] = []


@primitive("`", 1)
def _backquote(logo: Interpreter, template: Value) -> Value:
    """A copy of a list, in which what follows a comma is replaced by its value."""
    if not isinstance(template, list):
        raise BadInputError(template, wanted="a list")
    # Not recursive: lists may be nested deeper than any stack.
    opened = [_Open(template, 0)]
    while True:
        current = opened[-1]
        if not current.rest:
            made = make_list(current.made)
            opened.pop()
            if not opened:
                return made
            opened[-1].made.append(made)
            continue
        member: Value = current.rest[0]
        current.rest = current.rest[1]
        if isinstance(member, list):
            opened.append(_Open(member, current.depth))
        elif not isinstance(member, str):
            current.made.append(member)
        elif member == "`":
            current.made.append(member)
            if current.rest and isinstance(current.rest[0], list):
                opened.append(_Open(current.rest[0], current.depth + 1))
                current.rest = current.rest[1]
        elif member.startswith(","):
            inner = _unquote(logo, current, member, template)
            if inner is not None:
                opened.append(inner)
        elif member[:2] in ('",', ":,") and current.depth == 0:
            current.made.append(_joined(logo, current, member, template))
        else:
            current.made.append(member)


def _after(current: _Open, comma: str, member: str, template: Value) -> Value:
    """The expression behind a comma: the rest of its word, or the next member."""
    if member != comma:
        return make_list((word(member[len(comma) :]),))
    if not current.rest:
        raise BadInputError(template, wanted=f"an instruction list after {comma}")
    expression: Value = current.rest[0]
    current.rest = current.rest[1]
    return expression


def _unquote(logo: Interpreter, current: _Open, member: str, template: Value) -> _Open | None:
    """Replace a comma and what follows it; within another backquote only what is deeper, which is output."""
    comma = ",@" if member.startswith(",@") else ","
    expression = _after(current, comma, member, template)
    if current.depth:
        current.made.append(comma)
        if isinstance(expression, list):
            return _Open(expression, current.depth - 1)
        current.made.append(expression)
        return None
    value = _value(logo, expression)
    if comma == ",":
        current.made.append(value)
    elif isinstance(value, list):
        current.made += members_of(value)
    elif isinstance(value, Array):
        raise BadInputError(value, wanted="a list after ,@")
    else:
        current.made.append(value)
    return None


def _joined(logo: Interpreter, current: _Open, member: str, template: Value) -> Value:
    """``",`` or ``:,`` and an expression: the quote or colon before its value."""
    return word(member[0] + text(_value(logo, _after(current, member[:2], member, template))))


def _value(logo: Interpreter, expression: Value) -> Value:
    value = logo.value_of(expression, single=True)
    if value is None:
        last = logo.parsed(expression).last
        raise did_not_output(last.name if isinstance(last, Call | Invocation) else "[]", "`")
    return value
