"""Data structures: words and lists, taken apart and put together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.logo.primitives.inputs import answer, integer, items, text
from turtlewire.logo.procedures import BadInputError, Chapter
from turtlewire.logo.reader import read_list
from turtlewire.logo.tokens import tokenize
from turtlewire.logo.values import (
    BACKSLASHED,
    BARRED,
    LogoList,
    Value,
    equal,
    plain,
    to_number,
    to_text,
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
    return LogoList(inputs)


@primitive("sentence se", 2, minimum=0, maximum=-1)
def _sentence(_logo: Interpreter, inputs: list[Value]) -> Value:
    members: list[Value] = []
    for each in inputs:
        if isinstance(each, LogoList):
            members += each.items
        else:
            members.append(each)
    return LogoList(members)


def _letter(value: Value) -> str:
    found = text(value)
    if len(found) != 1:
        raise BadInputError(value, wanted="a single letter")
    return found


@primitive("fput", 2)
def _fput(_logo: Interpreter, thing: Value, onto: Value) -> Value:
    if isinstance(onto, LogoList):
        return LogoList((thing, *onto.items))
    if isinstance(thing, LogoList):
        raise BadInputError(onto)
    if len(to_text(thing)) != 1:
        raise BadInputError(onto)
    return word(to_text(thing) + to_text(onto))


@primitive("lput", 2)
def _lput(_logo: Interpreter, thing: Value, onto: Value) -> Value:
    if isinstance(onto, LogoList):
        return LogoList((*onto.items, thing))
    if isinstance(thing, LogoList) or len(to_text(thing)) != 1:
        raise BadInputError(onto)
    return word(to_text(onto) + to_text(thing))


@primitive("combine", 2)
def _combine(_logo: Interpreter, thing: Value, onto: Value) -> Value:
    if isinstance(onto, LogoList):
        return LogoList((thing, *onto.items))
    return word(text(thing) + to_text(onto))


@primitive("reverse", 1)
def _reverse(_logo: Interpreter, value: Value) -> Value:
    if isinstance(value, LogoList):
        return LogoList(value.items[::-1])
    return word(to_text(value)[::-1])


@primitive("gensym", 0)
def _gensym(logo: Interpreter) -> Value:
    logo.symbols_made += 1
    return f"g{logo.symbols_made}"


# --- selectors ------------------------------------------------------------------------------------------------


def _members(value: Value) -> tuple[Value, ...] | str:
    """The members of a list or the letters of a word, of which there is at least one."""
    found = value.items if isinstance(value, LogoList) else to_text(value)
    if not found:
        raise BadInputError(value, wanted="a word or list with something in it")
    return found


def _as_value(part: tuple[Value, ...] | str) -> Value:
    return word(part) if isinstance(part, str) else LogoList(part)


def _member(part: Value) -> Value:
    return word(part) if isinstance(part, str) and len(part) == 1 else part


@primitive("first", 1)
def _first(_logo: Interpreter, value: Value) -> Value:
    return _member(_members(value)[0])


@primitive("last", 1)
def _last(_logo: Interpreter, value: Value) -> Value:
    return _member(_members(value)[-1])


@primitive("butfirst bf", 1)
def _butfirst(_logo: Interpreter, value: Value) -> Value:
    return _as_value(_members(value)[1:])


@primitive("butlast bl", 1)
def _butlast(_logo: Interpreter, value: Value) -> Value:
    return _as_value(_members(value)[:-1])


@primitive("firsts", 1)
def _firsts(_logo: Interpreter, value: Value) -> Value:
    return LogoList([_member(_members(each)[0]) for each in items(value)])


@primitive("butfirsts bfs", 1)
def _butfirsts(_logo: Interpreter, value: Value) -> Value:
    return LogoList([_as_value(_members(each)[1:]) for each in items(value)])


@primitive("item", 2)
def _item(_logo: Interpreter, index: Value, value: Value) -> Value:
    wanted = integer(index)
    found = _members(value)
    if not 1 <= wanted <= len(found):
        raise BadInputError(index, 4, f"a place from 1 to {len(found)}")
    return _member(found[wanted - 1])


@primitive("pick", 1)
def _pick(logo: Interpreter, value: Value) -> Value:
    found = _members(value)
    return _member(found[logo.random.randrange(len(found))])


@primitive("remove", 2)
def _remove(_logo: Interpreter, thing: Value, value: Value) -> Value:
    if isinstance(value, LogoList):
        return LogoList([each for each in value.items if not equal(each, thing)])
    return word("".join([c for c in to_text(value) if not equal(c, thing)]))


@primitive("remdup", 1)
def _remdup(_logo: Interpreter, value: Value) -> Value:
    """Of equal members the last stays, as the manual says."""
    found: tuple[Value, ...] | str = value.items if isinstance(value, LogoList) else to_text(value)
    kept: list[Value] = []
    for index, each in enumerate(found):
        if not any(equal(each, later) for later in found[index + 1 :]):
            kept.append(each)
    return LogoList(kept) if isinstance(value, LogoList) else word("".join([str(each) for each in kept]))


@primitive("quoted", 1)
def _quoted(_logo: Interpreter, value: Value) -> Value:
    return value if isinstance(value, LogoList) else '"' + to_text(value)


# --- predicates -----------------------------------------------------------------------------------------------


@primitive("wordp word?", 1)
def _wordp(_logo: Interpreter, value: Value) -> Value:
    return answer(condition=not isinstance(value, LogoList))


@primitive("listp list?", 1)
def _listp(_logo: Interpreter, value: Value) -> Value:
    return answer(condition=isinstance(value, LogoList))


@primitive("arrayp array?", 1)
def _arrayp(_logo: Interpreter, _value: Value) -> Value:
    return answer(condition=False)


@primitive("numberp number?", 1)
def _numberp(_logo: Interpreter, value: Value) -> Value:
    return answer(condition=to_number(value) is not None)


@primitive("emptyp empty?", 1)
def _emptyp(_logo: Interpreter, value: Value) -> Value:
    return answer(condition=value == "" or (isinstance(value, LogoList) and not value.items))


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
    if not isinstance(value, LogoList) and (isinstance(thing, LogoList) or len(to_text(thing)) != 1):
        return answer(condition=False)
    return answer(condition=_find(logo, thing, value) >= 0)


@primitive("member", 2)
def _member_from(logo: Interpreter, thing: Value, value: Value) -> Value:
    index = _find(logo, thing, value)
    if isinstance(value, LogoList):
        return LogoList(value.items[index:] if index >= 0 else ())
    return word(to_text(value)[index:] if index >= 0 else "")


def _find(logo: Interpreter, thing: Value, value: Value) -> int:
    """Where a thing is in a list, or a word in a word; -1 when it is not there."""
    if isinstance(value, LogoList):
        for index, each in enumerate(value.items):
            if equal(each, thing, ignore_case=ignores_case(logo)):
                return index
        return -1
    if isinstance(thing, LogoList):
        return -1
    whole, part = plain(to_text(value)), plain(to_text(thing))
    return whole.lower().find(part.lower()) if ignores_case(logo) else whole.find(part)


@primitive("substringp substring?", 2)
def _substringp(logo: Interpreter, part: Value, whole: Value) -> Value:
    is_within = not isinstance(whole, LogoList) and _find(logo, part, whole) >= 0
    return answer(condition=is_within)


@primitive("vbarredp vbarred?", 1)
def _vbarredp(_logo: Interpreter, value: Value) -> Value:
    return answer(condition=BARRED <= ord(_letter(value)) < BACKSLASHED)


@primitive("backslashedp backslashed?", 1)
def _backslashedp(_logo: Interpreter, value: Value) -> Value:
    return answer(condition=ord(_letter(value)) >= BARRED)


# --- queries --------------------------------------------------------------------------------------------------


@primitive("count", 1)
def _count(_logo: Interpreter, value: Value) -> Value:
    return len(value.items if isinstance(value, LogoList) else to_text(value))


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
    as_list = value if isinstance(value, LogoList) else read_list(plain(to_text(value)))
    spelled: list[Value] = []
    for token in tokenize(as_list):
        if token.kind == "dots":
            spelled.append(f":{token.value}")
        elif token.kind == "value" and isinstance(token.value, str):
            spelled.append('"' + token.value)
        else:
            spelled.append(token.value)
    return LogoList(spelled)
