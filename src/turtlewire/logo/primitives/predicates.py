"""What words, lists and arrays are like: predicates, queries, and PARSE."""

from __future__ import annotations

from turtlewire.logo.primitives.inputs import answer, integer, text
from turtlewire.logo.procedures import BadInputError, Chapter
from turtlewire.logo.reader import line_of, value_of
from turtlewire.logo.receiving import read_list
from turtlewire.logo.tokens import tokenize
from turtlewire.logo.values import (
    BACKSLASHED,
    BARRED,
    NIL,
    Array,
    List,
    Value,
    equal,
    make_list,
    plain,
    to_number,
    word,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive


def _letter(value: Value) -> str:
    found = text(value)
    if len(found) != 1:
        raise BadInputError(value, wanted="a single letter")
    return found


# --- predicates -----------------------------------------------------------------------------------------------


@primitive("wordp word?", 1)
def _wordp(_logo: Interpreter, value: Value) -> Value:
    return answer(condition=isinstance(value, str | int | float))


@primitive("listp list?", 1)
def _listp(_logo: Interpreter, value: Value) -> Value:
    return answer(condition=isinstance(value, list))


@primitive("arrayp array?", 1)
def _arrayp(_logo: Interpreter, value: Value) -> Value:
    return answer(condition=isinstance(value, Array))


@primitive("numberp number?", 1)
def _numberp(_logo: Interpreter, value: Value) -> Value:
    return answer(condition=to_number(value) is not None)


@primitive("emptyp empty?", 1)
def _emptyp(_logo: Interpreter, value: Value) -> Value:
    return answer(condition=isinstance(value, str | list) and not value)


@primitive("equalp equal? =", 2)
def _equalp(logo: Interpreter, a: Value, b: Value) -> Value:
    return answer(condition=equal(a, b, ignore_case=ignores_case(logo)))


@primitive(".eq", 2)
def _dot_eq(_logo: Interpreter, a: Value, b: Value) -> Value:
    """Words cannot be changed: two that are written alike are the same."""
    is_same = a is b or (
        isinstance(a, str | int | float) and isinstance(b, str | int | float) and text(a) == text(b)
    )
    return answer(condition=is_same or (a == b == NIL))


@primitive("notequalp notequal? <>", 2)
def _notequalp(logo: Interpreter, a: Value, b: Value) -> Value:
    return answer(condition=not equal(a, b, ignore_case=ignores_case(logo)))


def ignores_case(logo: Interpreter) -> bool:
    """Whether words that differ in case only are equal: unless CASEIGNOREDP is false."""
    setting = logo.variables.get("caseignoredp")
    return not (isinstance(setting, str) and setting.lower() == "false")


@primitive("beforep before?", 2)
def _beforep(logo: Interpreter, a: Value, b: Value) -> Value:
    first, second = plain(text(a)), plain(text(b))
    if ignores_case(logo):
        first, second = first.lower(), second.lower()
    return answer(condition=first < second)


@primitive("memberp member?", 2)
def _memberp(logo: Interpreter, thing: Value, value: Value) -> Value:
    if isinstance(value, Array):
        ignore_case = ignores_case(logo)
        return answer(condition=any(equal(each, thing, ignore_case=ignore_case) for each in value.items))
    if isinstance(value, list):
        return answer(condition=bool(_cell_with(logo, thing, value)))
    return answer(condition=_is_letter(thing) and _find(logo, thing, value) >= 0)


@primitive("member", 2)
def _member_from(logo: Interpreter, thing: Value, value: Value) -> Value:
    if isinstance(value, list):
        return _cell_with(logo, thing, value)
    if isinstance(value, Array):
        raise BadInputError(value, 4, "a list or a word")
    index = _find(logo, thing, value) if _is_letter(thing) else -1
    return word(text(value)[index:] if index >= 0 else "")


def _is_letter(value: Value) -> bool:
    return isinstance(value, str | int | float) and len(text(value)) == 1


def _cell_with(logo: Interpreter, thing: Value, cells: List) -> List:
    """The rest of a list from a member on; empty when it is not there."""
    ignore_case = ignores_case(logo)
    while cells and not equal(cells[0], thing, ignore_case=ignore_case):
        cells = cells[1]
    return cells


def _find(logo: Interpreter, thing: Value, value: Value) -> int:
    """Where a word is in a word; -1 when it is not there."""
    if not isinstance(thing, str | int | float):
        return -1
    whole, part = plain(text(value)), plain(text(thing))
    return whole.lower().find(part.lower()) if ignores_case(logo) else whole.find(part)


@primitive("substringp substring?", 2)
def _substringp(logo: Interpreter, part: Value, whole: Value) -> Value:
    is_within = not isinstance(whole, list | Array) and _find(logo, part, whole) >= 0
    return answer(condition=is_within)


@primitive("vbarredp vbarred?", 1)
def _vbarredp(_logo: Interpreter, value: Value) -> Value:
    return answer(condition=BARRED <= ord(_letter(value)) < BACKSLASHED)


@primitive("backslashedp backslashed?", 1)
def _backslashedp(_logo: Interpreter, value: Value) -> Value:
    return answer(condition=ord(_letter(value)) >= BARRED)


# --- queries --------------------------------------------------------------------------------------------------


def length(cells: List) -> int:
    """How many members a list has."""
    count = 0
    while cells:
        cells = cells[1]
        count += 1
    return count


@primitive("count", 1)
def _count(_logo: Interpreter, value: Value) -> Value:
    if isinstance(value, list):
        return length(value)
    return len(value.items) if isinstance(value, Array) else len(text(value))


@primitive("ascii rawascii", 1)
def _ascii(_logo: Interpreter, value: Value) -> Value:
    return ord(plain(_letter(value)))


@primitive("char", 1)
def _char(_logo: Interpreter, value: Value) -> Value:
    code = integer(value)
    if not 0 <= code < BARRED or 0xD800 <= code < 0xE000:
        raise BadInputError(value)
    return word(chr(code))


@primitive("lowercase", 1)
def _lowercase(_logo: Interpreter, value: Value) -> Value:
    return word(text(value).lower())


@primitive("uppercase", 1)
def _uppercase(_logo: Interpreter, value: Value) -> Value:
    return word(text(value).upper())


@primitive("parse", 1)
def _parse(_logo: Interpreter, value: Value) -> Value:
    return read_list(text(value))


@primitive("runparse", 1)
def _runparse(_logo: Interpreter, value: Value) -> Value:
    as_list = value if isinstance(value, list) else read_list(text(value))
    spelled: list[Value] = []
    for token in tokenize(line_of(as_list)):
        found = value_of(token.value)
        if token.kind == "dots":
            spelled.append(f":{text(found)}")
        elif token.kind == "value" and isinstance(found, str):
            spelled.append('"' + found)
        else:
            spelled.append(found)
    return make_list(spelled)
