"""Arrays, and what changes arrays, lists, and the stacks and queues that variables hold."""

from __future__ import annotations

from turtlewire.logo.errors import no_value
from turtlewire.logo.primitives.data import item_of, put_first, put_last
from turtlewire.logo.primitives.inputs import integer, items, key, natural, text
from turtlewire.logo.procedures import BadInputError, Chapter
from turtlewire.logo.values import NIL, Array, List, Value, make_list, word

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive

_LARGEST = 10_000_000  # members of an array; more is a mistake, and would fill the memory


# --- constructors ---------------------------------------------------------------------------------------------


@primitive("{}", 1)
def _literal(_logo: Interpreter, value: Value) -> Value:
    """What the parser makes of an array between braces: a new one each time, and the arrays in it, too."""
    assert isinstance(value, Array)
    copy = Array(list(value.items), value.origin)
    pending = [copy]
    for each in pending:
        for place, item in enumerate(each.items):
            if isinstance(item, Array):
                each.items[place] = fresh = Array(list(item.items), item.origin)
                pending.append(fresh)
    return copy


def _size(value: Value) -> int:
    size = natural(value)
    if size > _LARGEST:
        raise BadInputError(value, wanted=f"a size up to {_LARGEST}")
    return size


@primitive("array", 1, maximum=2)
def _array(_logo: Interpreter, size: Value, origin: Value = 1) -> Value:
    return Array([NIL] * _size(size), integer(origin))


@primitive("mdarray", 1, maximum=2)
def _mdarray(_logo: Interpreter, sizes: Value, origin: Value = 1) -> Value:
    members = items(sizes)
    if not members:
        raise BadInputError(sizes, wanted="a list of sizes, as in [3 5]")
    first = integer(origin)
    total = 1
    for each in members:
        total *= _size(each)
        if total > _LARGEST:
            raise BadInputError(sizes, wanted=f"at most {_LARGEST} members in all")
    made = Array([], first)
    level = [made]
    for size in members[:-1]:
        deeper: list[Array] = []
        for array in level:
            added = [Array([], first) for _ in range(_size(size))]
            array.items.extend(added)
            deeper += added
        level = deeper
    for array in level:
        array.items = [NIL] * _size(members[-1])
    return made


@primitive("listtoarray", 1, maximum=2)
def _listtoarray(_logo: Interpreter, value: Value, origin: Value = 1) -> Value:
    return Array(items(value), integer(origin))


@primitive("arraytolist", 1)
def _arraytolist(_logo: Interpreter, value: Value) -> Value:
    return make_list(_array_input(value).items)


# --- members --------------------------------------------------------------------------------------------------


def _array_input(value: Value) -> Array:
    if not isinstance(value, Array):
        raise BadInputError(value, wanted="an array, as ARRAY makes one")
    return value


def _place(index: Value, array: Array) -> int:
    """Where in an array the member with an index is."""
    place = integer(index) - array.origin
    if not 0 <= place < len(array.items):
        last = array.origin + len(array.items) - 1
        wanted = f"a place from {array.origin} to {last}" if array.items else "an array with members"
        raise BadInputError(index, wanted=wanted)
    return place


def _contains(value: Value, wanted: Array) -> bool:
    """Whether an array is within a value, or is it itself."""
    pending, seen = [value], set[int]()
    while pending:
        each = pending.pop()
        if each is wanted:
            return True
        if isinstance(each, list | Array) and id(each) not in seen:
            seen.add(id(each))
            pending += each if isinstance(each, list) else each.items
    return False


@primitive("setitem", 3)
def _setitem(_logo: Interpreter, index: Value, array: Value, value: Value) -> None:
    found = _array_input(array)
    place = _place(index, found)
    if _contains(value, found):
        raise BadInputError(value, wanted="a value that does not hold the array itself")
    found.items[place] = value


@primitive(".setitem", 3)
def _dot_setitem(_logo: Interpreter, index: Value, array: Value, value: Value) -> None:
    found = _array_input(array)
    found.items[_place(index, found)] = value


def _inner(indexes: list[Value], array: Value) -> Value:
    """The member of arrays within arrays that a list of indexes leads to."""
    for index in indexes:
        array = item_of(index, array)
    return array


@primitive("mditem", 2)
def _mditem(_logo: Interpreter, indexes: Value, array: Value) -> Value:
    return _inner(items(indexes), array)


@primitive("mdsetitem", 3)
def _mdsetitem(logo: Interpreter, indexes: Value, array: Value, value: Value) -> None:
    members = items(indexes)
    if not members:
        raise BadInputError(indexes, wanted="a list of indexes, as in [1 2]")
    _setitem(logo, members[-1], _inner(members[:-1], array), value)


# --- lists that change ----------------------------------------------------------------------------------------


def _cell(value: Value) -> List:
    if not isinstance(value, list) or not value:
        raise BadInputError(value, wanted="a list that is not empty")
    return value


def _lists_change(logo: Interpreter) -> None:
    logo.lists_change = True
    logo.forget_lines()


@primitive(".setfirst", 2)
def _setfirst(logo: Interpreter, cells: Value, value: Value) -> None:
    _cell(cells)[0] = value
    _lists_change(logo)


@primitive(".setbf", 2)
def _setbf(logo: Interpreter, cells: Value, value: Value) -> None:
    changed = _cell(cells)
    if not isinstance(value, list):
        raise BadInputError(value, wanted="a list")
    rest = value
    while rest:
        if rest is changed:
            raise BadInputError(value, wanted="a list that does not lead back to the one that is changed")
        rest = rest[1]
    changed[1] = value
    _lists_change(logo)


# --- stacks and queues kept in variables ----------------------------------------------------------------------


def _stored(logo: Interpreter, name: Value) -> Value:
    value = logo.variables.get(key(name))
    if value is None:
        raise no_value(text(name), list(logo.variables))
    return value


@primitive("push", 2)
def _push(logo: Interpreter, name: Value, value: Value) -> None:
    logo.variables[key(name)] = put_first(value, _stored(logo, name))


@primitive("pop dequeue", 1)
def _pop(logo: Interpreter, name: Value) -> Value:
    stored = _stored(logo, name)
    if isinstance(stored, list):
        if not stored:
            raise BadInputError(name, wanted="a stack or queue with something in it")
        first: Value = stored[0]
        logo.variables[key(name)] = stored[1]
        return first
    letters = text(stored)
    if not letters:
        raise BadInputError(name, wanted="a stack or queue with something in it")
    logo.variables[key(name)] = word(letters[1:])
    return word(letters[0])


@primitive("queue", 2)
def _queue(logo: Interpreter, name: Value, value: Value) -> None:
    stored = _stored(logo, name)
    logo.variables[key(name)] = put_last(value, stored)
