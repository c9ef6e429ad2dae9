"""Data structures: words and lists, taken apart and put together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.logo.primitives.inputs import answer, integer, items, text
from turtlewire.logo.procedures import BadInputError, Chapter
from turtlewire.logo.reader import line_of, read_list, value_of
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
    members_of,
    plain,
    to_number,
    word,
)

if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive

# --- constructors ---------------------------------------------------------------------------------------------


@primitive("word", 2, minimum=0, maximum=-1)
def _word(_logo: Interpreter, inputs: list[Value]) -> Value:
    return word("".join([text(each) for each in inputs]))


@primitive("list", 2, minimum=0, maximum=-1)
def _list(_logo: Interpreter, inputs: list[Value]) -> Value:
    return make_list(inputs)


@primitive("sentence se", 2, minimum=0, maximum=-1)
def _sentence(_logo: Interpreter, inputs: list[Value]) -> Value:
    result: List = NIL
    for each in reversed(inputs):
        if not isinstance(each, list):
            result = [each, result]
        elif each:
            result = make_list(members_of(each), result) if result else each
    return result


def _letter(value: Value) -> str:
    found = text(value)
    if len(found) != 1:
        raise BadInputError(value, wanted="a single letter")
    return found


@primitive("fput", 2)
def _fput(_logo: Interpreter, thing: Value, onto: Value) -> Value:
    if isinstance(onto, list):
        return [thing, onto]
    if isinstance(thing, list):
        raise BadInputError(onto)
    if len(text(thing)) != 1:
        raise BadInputError(onto)
    return word(text(thing) + text(onto))


@primitive("lput", 2)
def _lput(_logo: Interpreter, thing: Value, onto: Value) -> Value:
    if isinstance(onto, list):
        return make_list(members_of(onto), [thing, NIL])
    if not isinstance(thing, str | int | float) or len(text(thing)) != 1:
        raise BadInputError(onto)
    return word(text(onto) + text(thing))


@primitive("combine", 2)
def _combine(_logo: Interpreter, thing: Value, onto: Value) -> Value:
    if isinstance(onto, list):
        return [thing, onto]
    return word(text(thing) + text(onto))


@primitive("reverse", 1)
def _reverse(_logo: Interpreter, value: Value) -> Value:
    if isinstance(value, list):
        return make_list(members_of(value)[::-1])
    return word(text(value)[::-1])


@primitive("gensym", 0)
def _gensym(logo: Interpreter) -> Value:
    logo.symbols_made += 1
    return f"g{logo.symbols_made}"


# --- selectors ------------------------------------------------------------------------------------------------


def _filled(value: Value) -> Value:
    """A list or word with something in it."""
    if isinstance(value, str | list) and not value:
        raise BadInputError(value, wanted="a word or list with something in it")
    return value


def _letter_word(letter: str) -> Value:
    return int(letter) if letter in _DIGITS else letter


_DIGITS = frozenset("0123456789")


@primitive("first", 1)
def _first(_logo: Interpreter, value: Value) -> Value:
    if isinstance(value, list) and value:
        first: Value = value[0]
        return first
    if isinstance(value, Array):
        return value.origin
    return _letter_word(text(_filled(value))[0])


@primitive("last", 1)
def _last(_logo: Interpreter, value: Value) -> Value:
    if isinstance(value, list) and value:
        last: Value = last_cell(value)[0]
        return last
    return _letter_word(text(_filled(value))[-1])


def last_cell(cells: List) -> List:
    """The last cell of a list that is not empty."""
    while cells[1]:
        cells = cells[1]
    return cells


@primitive("butfirst bf", 1)
def _butfirst(_logo: Interpreter, value: Value) -> Value:
    if isinstance(value, list) and value:
        rest: List = value[1]
        return rest
    return word(text(_filled(value))[1:])


@primitive("butlast bl", 1)
def _butlast(_logo: Interpreter, value: Value) -> Value:
    if isinstance(value, list) and value:
        return make_list(members_of(value)[:-1])
    return word(text(_filled(value))[:-1])


@primitive("firsts", 1)
def _firsts(logo: Interpreter, value: Value) -> Value:
    return make_list([_first(logo, each) for each in items(value)])


@primitive("butfirsts bfs", 1)
def _butfirsts(logo: Interpreter, value: Value) -> Value:
    return make_list([_butfirst(logo, each) for each in items(value)])


@primitive("item", 2)
def _item(_logo: Interpreter, index: Value, value: Value) -> Value:
    wanted = integer(index)
    if isinstance(value, Array):
        place = wanted - value.origin
        if not 0 <= place < len(value.items):
            last = value.origin + len(value.items) - 1
            raise BadInputError(index, 4, f"a place from {value.origin} to {last}")
        return value.items[place]
    if isinstance(value, list):
        cells = value
        for _ in range(wanted - 1):
            if not cells:
                break
            cells = cells[1]
        if wanted < 1 or not cells:
            _filled(value)
            raise BadInputError(index, 4, f"a place from 1 to {len(members_of(value))}")
        found: Value = cells[0]
        return found
    letters = text(_filled(value))
    if not 1 <= wanted <= len(letters):
        raise BadInputError(index, 4, f"a place from 1 to {len(letters)}")
    return _letter_word(letters[wanted - 1])


@primitive("pick", 1)
def _pick(logo: Interpreter, value: Value) -> Value:
    if isinstance(value, list) and value:
        return logo.random.choice(members_of(value))
    return _letter_word(logo.random.choice(text(_filled(value))))


@primitive("remove", 2)
def _remove(_logo: Interpreter, thing: Value, value: Value) -> Value:
    if isinstance(value, list):
        return make_list([each for each in members_of(value) if not equal(each, thing)])
    return word("".join([c for c in text(value) if not equal(c, thing)]))


@primitive("remdup", 1)
def _remdup(_logo: Interpreter, value: Value) -> Value:
    """Of equal members the last stays, as the manual says."""
    found: list[Value] = members_of(value) if isinstance(value, list) else list(text(value))
    kept = [
        each
        for index, each in enumerate(found)
        if not any(equal(each, later) for later in found[index + 1 :])
    ]
    return make_list(kept) if isinstance(value, list) else word("".join([str(each) for each in kept]))


@primitive("quoted", 1)
def _quoted(_logo: Interpreter, value: Value) -> Value:
    return value if isinstance(value, list) else '"' + text(value)


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
    if isinstance(value, list):
        return answer(condition=bool(_cell_with(logo, thing, value)))
    if not isinstance(thing, str | int | float) or len(text(thing)) != 1:
        return answer(condition=False)
    return answer(condition=_find(logo, thing, value) >= 0)


@primitive("member", 2)
def _member_from(logo: Interpreter, thing: Value, value: Value) -> Value:
    if isinstance(value, list):
        return _cell_with(logo, thing, value)
    index = _find(logo, thing, value)
    return word(text(value)[index:] if index >= 0 else "")


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
    is_within = not isinstance(whole, list) and _find(logo, part, whole) >= 0
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
    return read_list(plain(text(value)))


@primitive("runparse", 1)
def _runparse(_logo: Interpreter, value: Value) -> Value:
    as_list = value if isinstance(value, list) else read_list(plain(text(value)))
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
