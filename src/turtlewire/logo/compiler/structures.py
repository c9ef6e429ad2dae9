"""Words, lists and arrays, taken apart and put together in place; see ``inline``."""

from __future__ import annotations

import ast
from itertools import product
from typing import TYPE_CHECKING

from turtlewire.logo.compiler import python as py
from turtlewire.logo.compiler.kinds import ARRAY, NUMBER, WHOLE
from turtlewire.logo.syntax import Literal
from turtlewire.logo.values import SPECIAL

if TYPE_CHECKING:
    from collections.abc import Iterable

    from turtlewire.logo.compiler.emit import Emitter
    from turtlewire.logo.compiler.python import Expr
    from turtlewire.logo.syntax import Call, Node

_NEAR = 6  # up to which place of a list a member is fetched without a loop
_MANY_SPELLINGS = 5  # letters whose upper and lower case are all written out


def _whole(emitter: Emitter, value: Expr, node: Node) -> list[Expr]:
    """What is to be asked before a value is taken for an int: nothing, or one condition."""
    return [] if emitter.kinds.of(node) & WHOLE else [py.has_type(value, "int")]


def _of_array(emitter: Emitter, value: Expr, node: Node) -> list[Expr]:
    """What is to be asked before a value is taken for an array."""
    return [] if emitter.kinds.of(node) & ARRAY else [py.has_type(value, "Array")]


def _slowly(emitter: Emitter, node: Call, number: int, *inputs: Expr) -> Expr:
    name = emitter.namer.primitive(node.primitive, moves=False)
    return py.at(number, py.call(name, py.name("logo"), *inputs))  # type: ignore[no-any-return]


def _twice(emitter: Emitter, value: Expr) -> tuple[Expr, Expr]:
    """An operand for its first use, and for those after it; see ``Emitter.named``."""
    if isinstance(value, ast.NamedExpr):
        return value, py.name(value.target.id)
    return emitter.named(value)


def _names(emitter: Emitter, node: Call) -> tuple[list[Expr], int]:
    """The inputs, each with a name or a constant, and the number of the place."""
    values = [emitter.kept(each, always=True) for each in emitter.values(node.inputs, node.name)]
    operands = [emitter.operand(each, value)[1] for each, value in zip(node.inputs, values, strict=True)]
    return values, emitter.site(node, "", tuple(operands))


# ---------------------------------------------------------------- words and lists


def first(emitter: Emitter, node: Call) -> Expr:
    """FIRST."""
    return _part(emitter, node, 0, ends_at=0)


def butfirst(emitter: Emitter, node: Call) -> Expr:
    """BUTFIRST."""
    return _part(emitter, node, 1)


def last(emitter: Emitter, node: Call) -> Expr:
    """LAST."""
    return _part(emitter, node, None, ends_at=-1)


def _part(emitter: Emitter, node: Call, cell_part: int | None, *, ends_at: int | None = None) -> Expr:
    """A part of a list's cell, or the letter at one end of a word."""
    (value,), operands = emitter.operands(node)
    value, again = _twice(emitter, value)
    number = emitter.site(node, "", operands)
    made = _slowly(emitter, node, number, again)
    if isinstance(value, ast.Constant):
        return made
    kinds = []
    if cell_part is not None:
        kinds.append(("list", py.at(number, py.index(again, py.const(cell_part)))))
    if ends_at is not None:
        letter = py.at(number, py.index(again, py.const(ends_at)))
        kinds.append(("str", py.index(py.name("LETTERS"), letter)))
    for index, (kind, quick) in reversed(list(enumerate(kinds))):
        made = py.either(py.has_type(again if index else value, kind), quick, made)
    return made


def fput(emitter: Emitter, node: Call) -> Expr:
    """FPUT."""
    thing, onto = emitter.values(node.inputs, node.name)
    if not isinstance(thing, ast.Constant | ast.Name):
        thing = emitter.kept(thing)  # evaluated before the list is looked at
    named, again = emitter.named(onto)
    otherwise = _slowly(emitter, node, emitter.site(node), thing, again)
    return py.either(py.has_type(named, "list"), ast.List([thing, again], py.LOAD), otherwise)


def list_of(emitter: Emitter, node: Call) -> Expr:
    """LIST."""
    made = py.name("NIL")
    for value in reversed(emitter.values(node.inputs, node.name)):
        made = ast.List([value, made], py.LOAD)
    return made


def joined(emitter: Emitter, node: Call) -> Expr:
    """WORD."""
    values = emitter.values(node.inputs, node.name)
    number = emitter.site(node)
    if len(values) == 2:
        return py.at(number, py.call("joined", *values))  # type: ignore[no-any-return]
    return _slowly(emitter, node, number, ast.List(values, py.LOAD))


def char(emitter: Emitter, node: Call) -> Expr:
    """CHAR."""
    (value,) = emitter.values(node.inputs, node.name)
    named, again = emitter.named(value)
    conditions = _whole(emitter, named, node.inputs[0])
    # Neither a digit, which would be a number, nor what is no letter of its own.
    within = ast.Compare(
        py.const(58), [ast.LtE(), ast.Lt()], [again if conditions else named, py.const(0xD800)]
    )
    condition = py.all_of(*conditions, within) if conditions else within
    return py.either(condition, py.call("chr", again), _slowly(emitter, node, emitter.site(node), again))


def ascii_of(emitter: Emitter, node: Call) -> Expr:
    """ASCII."""
    (value,), operands = emitter.operands(node)
    value, again = _twice(emitter, value)
    number = emitter.site(node, "", operands)
    get = ast.Call(ast.Attribute(py.name("CODES"), "get", py.LOAD), [value], [])
    return py.any_of(py.at(number, get), _slowly(emitter, node, number, again))


def member(emitter: Emitter, node: Call) -> Expr:
    """Whether MEMBERP is true."""
    thing, whole = emitter.values(node.inputs, node.name)
    thing, again = emitter.named(thing)
    number = emitter.site(node)
    word = whole.value if isinstance(whole, ast.Constant) else None
    if not isinstance(word, str) or not word or not _is_ordinary(word):
        return py.compare(_slowly(emitter, node, number, thing, whole), ast.Eq(), py.const("true"))
    # Letters that it has, in one case or the other: only then is more to be asked.
    spellings = [spelling for letter in word for spelling in _spellings(letter)]
    is_listed = py.compare(again, ast.In(), _set_of(spellings))
    is_member = py.compare(_slowly(emitter, node, number, again, whole), ast.Eq(), py.const("true"))
    also = py.compare(_slowly(emitter, node, number, again, whole), ast.Eq(), py.const("true"))
    is_there = py.compare(again, ast.In(), _set_of(word))
    return py.either(py.has_type(thing, "str"), py.any_of(is_there, py.all_of(is_listed, is_member)), also)


def same_word(value: Expr, again: Expr, wanted: str) -> Expr:
    """Whether a value is EQUALP to a word that stands in the program; case may or may not count."""
    is_it = py.compare(value, ast.Eq(), py.const(wanted))
    if not wanted:
        return is_it
    if not _is_ordinary(wanted):
        return py.call("same", value, py.const(wanted))
    if sum(letter.isalpha() for letter in wanted) <= _MANY_SPELLINGS:
        spellings = ["".join(each) for each in product(*[_spellings(letter) for letter in wanted])]
        may_be = py.compare(again, ast.In(), _set_of(spellings))
    else:
        may_be = py.compare(py.call("len", again), ast.Eq(), py.const(len(wanted)))
    alike = py.all_of(py.has_type(again, "str"), may_be, py.call("same", again, py.const(wanted)))
    return py.any_of(is_it, alike)


def _set_of(words: Iterable[str]) -> Expr:
    """``{words}``, which Python makes a constant of."""
    return ast.Set([py.const(each) for each in sorted(set(words))])


def _is_ordinary(text: str) -> bool:
    """Whether no character of a word can be another one that looks the same."""
    return text.isascii() and not any(letter in SPECIAL for letter in text)


def _spellings(letter: str) -> tuple[str, ...]:
    """A letter in upper and lower case; the sign for kelvin is a K, too."""
    found = {letter, letter.lower(), letter.upper()} | ({"\N{KELVIN SIGN}"} if letter in "kK" else set())
    return tuple(sorted(found))


# ---------------------------------------------------------------- arrays


def item(emitter: Emitter, node: Call) -> Expr:
    """ITEM: of an array; of a list when the place stands in the program, near its beginning."""
    index_node, whole_node = node.inputs
    index, whole = emitter.values(node.inputs, node.name)
    if not emitter.is_certain(index):
        index = emitter.kept(index, always=True)
    _, of_index = emitter.operand(index_node, index)
    if emitter.kinds.of(whole_node) & ARRAY:
        whole = emitter.kept(whole, always=True)
    whole, of_whole = emitter.operand(whole_node, whole)
    whole, again = _twice(emitter, whole)
    number = emitter.site(node, "", (of_index, of_whole))
    otherwise = _slowly(emitter, node, number, index, again)
    if (
        isinstance(whole, ast.Constant)
        and isinstance(whole.value, str)
        and not isinstance(index, ast.Constant)
    ):
        within = ast.Compare(py.const(1), [ast.LtE(), ast.LtE()], [index, py.const(len(whole.value))])
        letter = py.index(whole, py.binary(index, ast.Sub(), py.const(1)))
        conditions = [*_whole(emitter, index, index_node), within]
        condition = py.all_of(*conditions) if len(conditions) > 1 else within
        return py.either(condition, py.index(py.name("LETTERS"), letter), otherwise)
    if isinstance(whole, ast.Constant):
        return _slowly(emitter, node, number, index, whole)
    if isinstance(index_node, Literal) and not emitter.kinds.of(whole_node) & ARRAY:
        place = index_node.value
        if type(place) is not int or not 1 <= place <= _NEAR:
            return _slowly(emitter, node, number, index, whole)
        cell = again
        for _ in range(place - 1):
            cell = py.at(number, py.index(cell, py.const(1)))
        member = py.at(number, py.index(cell, py.const(0)))
        return py.either(py.has_type(whole, "list"), member, otherwise)
    conditions = _of_array(emitter, whole, whole_node)
    first_use = again if conditions else whole
    conditions += _whole(emitter, index, index_node)
    place_name = emitter.temp()
    conditions.append(_is_within(index, first_use, place_name))
    condition = py.all_of(*conditions) if len(conditions) > 1 else conditions[0]
    items = ast.Attribute(again, "items", py.LOAD)
    return py.either(condition, py.at(number, py.index(items, py.name(place_name))), otherwise)


def _is_within(index: Expr, array: Expr, place: str) -> Expr:
    """Whether an index is not before an array's first; Python sees when it is behind its last."""
    distance = py.binary(index, ast.Sub(), ast.Attribute(array, "origin", py.LOAD))
    return py.compare(py.walrus(place, distance), ast.GtE(), py.const(0))


def set_item(emitter: Emitter, node: Call, tail: bool) -> None:  # noqa: ARG001 - as all commands
    """SETITEM."""
    (index, array, value), number = _names(emitter, node)
    index_node, array_node, value_node = node.inputs
    conditions = _of_array(emitter, array, array_node) + _whole(emitter, index, index_node)
    if not (isinstance(value, ast.Constant) or emitter.kinds.of(value_node) & NUMBER):
        # A list or an array might hold the array itself.
        conditions.append(py.compare(py.call("type", value), ast.In(), py.name("WORDS")))
    place = emitter.temp()
    conditions.append(_is_within(index, array, place))
    condition = py.all_of(*conditions) if len(conditions) > 1 else conditions[0]
    target = ast.Subscript(ast.Attribute(array, "items", py.LOAD), py.name(place), py.STORE)
    slow = py.do(_slowly(emitter, node, number, index, array, value))
    emitter.body.append(py.when(condition, [ast.Assign([py.at(number, target)], value)], [slow]))
