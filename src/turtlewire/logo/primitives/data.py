"""Data structures: words and lists, taken apart and put together."""

from __future__ import annotations

from turtlewire.logo.primitives.inputs import integer, items, text
from turtlewire.logo.procedures import BadInputError, Chapter
from turtlewire.logo.values import (
    NIL,
    Array,
    List,
    Value,
    equal,
    make_list,
    members_of,
    word,
)

TYPE_CHECKING = False
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
        if isinstance(each, Array):
            raise BadInputError(each, wanted="words and lists; ARRAYTOLIST makes a list of an array")
        if not isinstance(each, list):
            result = [each, result]
        elif each:
            result = make_list(members_of(each), result) if result else each
    return result


def put_first(thing: Value, onto: Value) -> Value:
    """A list with one more member before the others, or a word with one more letter."""
    if isinstance(onto, list):
        return [thing, onto]
    if isinstance(thing, list):
        raise BadInputError(onto)
    if len(text(thing)) != 1:
        raise BadInputError(onto)
    return word(text(thing) + text(onto))


@primitive("fput", 2)
def _fput(_logo: Interpreter, thing: Value, onto: Value) -> Value:
    return put_first(thing, onto)


def put_last(thing: Value, onto: Value) -> Value:
    """A list with one more member behind the others, or a word with one more letter."""
    if isinstance(onto, list):
        return make_list(members_of(onto), [thing, NIL])
    if not isinstance(thing, str | int | float) or len(text(thing)) != 1:
        raise BadInputError(onto)
    return word(text(onto) + text(thing))


@primitive("lput", 2)
def _lput(_logo: Interpreter, thing: Value, onto: Value) -> Value:
    return put_last(thing, onto)


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
    return item_of(index, value)


def item_of(index: Value, value: Value) -> Value:
    """The member of a list or array, or the letter of a word, at a place."""
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
    if isinstance(value, Array) and value.items:
        return logo.random.choice(value.items)
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
    return value if isinstance(value, list | Array) else '"' + text(value)
