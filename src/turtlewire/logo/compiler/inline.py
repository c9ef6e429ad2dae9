"""Operations that are written out in place, because a call would take longer than what they do.

What Python does by itself is right for the values that it does not refuse: so each is written such that a value that
Logo would not like makes Python raise an exception. Then the primitive itself is asked what was wrong.
"""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from turtlewire.logo.compiler import python as py
from turtlewire.logo.compiler import structures
from turtlewire.logo.compiler.kinds import NATURAL, NUMBER, SMALL_AT_FIRST, WHOLE
from turtlewire.logo.syntax import Call, Literal
from turtlewire.logo.values import EXACT

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.logo.compiler.emit import Emitter
    from turtlewire.logo.compiler.python import Expr, Stmt
    from turtlewire.logo.syntax import Node


def _is_number(value: Expr) -> bool:
    return isinstance(value, ast.Constant) and isinstance(value.value, int | float)


def _is_float(value: Expr) -> bool:
    return isinstance(value, ast.Constant) and isinstance(value.value, float)


def _is(emitter: Emitter, kind: int, *nodes: Node) -> bool:
    """Whether all of these are numbers of this kind."""
    return all(emitter.kinds.of(each) & kind == kind for each in nodes)


# ---------------------------------------------------------------- arithmetic


def _sum(emitter: Emitter, node: Call) -> Expr:
    if len(node.inputs) != 2:
        return _plain(emitter, node)
    (a, b), operands = emitter.operands(node)
    # Words and lists can be added in Python, though not to a number: but have no sign.
    is_safe = any(_is(emitter, NUMBER, each) for each in node.inputs)
    made = py.binary(a, ast.Add(), b) if is_safe else py.binary(a, ast.Add(), py.signed(b))
    return py.at(emitter.site(node, "", operands), made)  # type: ignore[no-any-return]


def _difference(emitter: Emitter, node: Call) -> Expr:
    (a, b), operands = emitter.operands(node)
    return py.at(emitter.site(node, "", operands), py.binary(a, ast.Sub(), b))  # type: ignore[no-any-return]


def _minus(emitter: Emitter, node: Call) -> Expr:
    (a,), operands = emitter.operands(node)
    return py.at(emitter.site(node, "", operands), py.minus(a))  # type: ignore[no-any-return]


def _product(emitter: Emitter, node: Call) -> Expr:
    if len(node.inputs) != 2:
        return _plain(emitter, node)
    a, b = emitter.values(node.inputs, node.name)
    are_numbers = _is(emitter, NUMBER, *node.inputs)
    if not are_numbers and not emitter.is_certain(b):  # both are there before one is looked at
        a, b = emitter.kept(a, always=True), emitter.kept(b, always=True)
    (a, first), (b, second) = emitter.operand(node.inputs[0], a), emitter.operand(node.inputs[1], b)
    factors = (a, b) if are_numbers else (py.signed(a), py.signed(b))
    made = py.at(emitter.site(node, "", (first, second)), py.binary(factors[0], ast.Mult(), factors[1]))
    if _is_float(a) or _is_float(b) or _is(emitter, WHOLE, node):  # then it is not too large
        return made  # type: ignore[no-any-return]
    product, again = emitter.named(made)
    within = ast.Compare(py.const(-EXACT), [ast.LtE(), ast.LtE()], [product, py.const(EXACT)])
    return py.either(within, again, py.call("narrowed", again))


def _remainder(emitter: Emitter, node: Call) -> Expr:
    a, b = emitter.values(node.inputs, node.name)
    slow = emitter.namer.primitive(node.primitive, moves=False)
    number = emitter.site(node)
    is_fast = isinstance(b, ast.Constant) and isinstance(b.value, int) and b.value > 0
    if not is_fast:
        return py.at(number, py.call(slow, py.name("logo"), a, b))  # type: ignore[no-any-return]
    is_whole = _is(emitter, WHOLE, node.inputs[0])
    # Its sign is that of the dividend, in Python of the divisor.
    is_alike = node.primitive.name == "modulo" or _is(emitter, NATURAL, node.inputs[0])
    if is_whole and is_alike:
        return py.binary(a, ast.Mod(), b)
    first, again = emitter.named(a)
    conditions = [] if is_whole else [py.has_type(first, "int")]
    if not is_alike:
        conditions.append(py.compare(again if conditions else first, ast.GtE(), py.const(0)))
    condition = py.all_of(*conditions) if len(conditions) > 1 else conditions[0]
    otherwise = py.at(number, py.call(slow, py.name("logo"), again, b))
    return py.either(condition, py.binary(again, ast.Mod(), b), otherwise)


def _int(emitter: Emitter, node: Call) -> Expr:
    """INT: of a quotient, it is a division of whole numbers, as long as no float would be rounded."""
    (quotient,) = node.inputs
    slow = emitter.namer.primitive(node.primitive, moves=False)
    number = emitter.site(node)
    divisor = quotient.inputs[-1] if isinstance(quotient, Call) and len(quotient.inputs) == 2 else None
    if (
        not isinstance(quotient, Call)
        or quotient.primitive.name != "quotient"
        or not isinstance(divisor, Literal)
        or not isinstance(divisor.value, int)
        or divisor.value <= 0
    ):
        return py.at(number, py.call(slow, py.name("logo"), *emitter.values(node.inputs, node.name)))  # type: ignore[no-any-return]
    first, again = emitter.named(emitter.value(quotient.inputs[0], quotient.name))
    divided = py.call(
        emitter.namer.primitive(quotient.primitive, moves=False),
        py.name("logo"),
        again,
        py.const(divisor.value),
    )
    otherwise = py.at(
        number, py.call(slow, py.name("logo"), py.at(emitter.site(quotient, node.name), divided))
    )
    within = ast.Compare(py.const(0), [ast.LtE(), ast.LtE()], [again, py.const(SMALL_AT_FIRST)])
    condition = py.all_of(py.has_type(first, "int"), within)
    return py.either(condition, py.binary(again, ast.FloorDiv(), py.const(divisor.value)), otherwise)


def _plain(emitter: Emitter, node: Call) -> Expr:
    inputs = ast.List(emitter.values(node.inputs, node.name), py.LOAD)
    name = emitter.namer.primitive(node.primitive, moves=False)
    return py.at(emitter.site(node), py.call(name, py.name("logo"), inputs))  # type: ignore[no-any-return]


# ---------------------------------------------------------------- conditions


def _comparison(operator: type[ast.cmpop]) -> Callable[[Emitter, Call], Expr]:
    def emit(emitter: Emitter, node: Call) -> Expr:
        (a, b), operands = emitter.operands(node)
        number = emitter.site(node, "", operands)
        if not any(_is(emitter, NUMBER, each) for each in node.inputs):
            b = py.signed(b)  # words and lists can be compared in Python, but not with a number
        return py.at(number, py.compare(a, operator(), b))  # type: ignore[no-any-return]

    return emit


def _equal(emitter: Emitter, node: Call) -> Expr:
    a, b = emitter.values(node.inputs, node.name)
    if _is_number(a) or _is_number(b):
        return py.compare(a, ast.Eq(), b)
    if isinstance(a, ast.Constant) and isinstance(a.value, str):
        a, b = b, a
    if isinstance(b, ast.Constant) and isinstance(b.value, str):
        return structures.same_word(*emitter.named(a), b.value)
    if not isinstance(b, ast.Name):
        return py.call("same", a, b)
    first, again = emitter.named(a)
    return py.either(py.has_type(first, "int"), py.compare(again, ast.Eq(), b), py.call("same", again, b))


def _not_equal(emitter: Emitter, node: Call) -> Expr:
    return py.negated(_equal(emitter, node))


def _empty(emitter: Emitter, node: Call) -> Expr:
    first, again = emitter.named(emitter.values(node.inputs, node.name)[0])
    kind = py.compare(py.call("type", again), ast.In(), py.name("CAN_BE_EMPTY"))
    return py.all_of(py.negated(first), kind)


def _of_type(kinds: str) -> Callable[[Emitter, Call], Expr]:
    def emit(emitter: Emitter, node: Call) -> Expr:
        (value,) = emitter.values(node.inputs, node.name)
        return py.compare(py.call("type", value), ast.In(), py.name(kinds))

    return emit


def _not(emitter: Emitter, node: Call) -> Expr:
    return py.negated(emitter.condition(node.inputs[0], node))


def _and(emitter: Emitter, node: Call) -> Expr:
    return _junction(emitter, node, is_and=True)


def _or(emitter: Emitter, node: Call) -> Expr:
    return _junction(emitter, node, is_and=False)


def _later(emitter: Emitter, node: Node, asker: Call) -> tuple[list[Stmt], Expr]:
    """The statements and the truth of a condition that may not be needed."""
    found: list[Expr] = []
    return emitter.within(lambda: found.append(emitter.condition(node, asker))), found[0]


def _junction(emitter: Emitter, node: Call, *, is_and: bool) -> Expr:
    """AND and OR: all inputs are evaluated; but only until it is decided are they looked at, and lists run."""
    if not node.inputs:
        return ast.Constant(value=is_and)

    def is_condition(each: Node) -> bool:
        return isinstance(each, Call) and each.primitive.name in CONDITIONS

    def evaluated(each: Node) -> Expr:
        if isinstance(each, Literal):
            return py.NONE
        if isinstance(each, Call) and is_condition(each):
            return CONDITIONS[each.primitive.name](emitter, each)
        return emitter.raw(each, node.name)

    made = emitter.in_order(node.inputs, evaluated)
    if all(is_condition(each) for each in node.inputs):
        result = made[0]
        for condition in made[1:]:
            result = py.binary(result, ast.BitAnd() if is_and else ast.BitOr(), condition)
        return result
    kept = [
        value if isinstance(each, Literal) else emitter.kept(value, always=True)
        for each, value in zip(node.inputs, made, strict=True)
    ]
    name = emitter.temp()
    decided = ast.Constant(value=not is_and)
    outer = emitter.body
    for index, (each, value) in enumerate(zip(node.inputs, kept, strict=True)):
        if is_condition(each):
            truth = value
        elif isinstance(each, Literal):
            statements, truth = _later(emitter, each, node)
            emitter.body += statements
        else:
            truth = emitter.truth(value, value, each, node)
        if index == len(node.inputs) - 1:
            emitter.body.append(py.assign(name, truth))
            break
        rest: list[Stmt] = []
        branches = (rest, [py.assign(name, decided)])
        emitter.body.append(py.when(truth, *(branches if is_and else branches[::-1])))
        emitter.body = rest
    emitter.body = outer
    return py.name(name)


def _predicate(emitter: Emitter, node: Call) -> Expr:
    inputs = emitter.values(node.inputs, node.name)
    name = emitter.namer.primitive(node.primitive, moves=False)
    made = py.at(emitter.site(node), py.call(name, py.name("logo"), *inputs))
    return py.compare(made, ast.Eq(), py.const("true"))


OPERATIONS: dict[str, Callable[[Emitter, Call], Expr]] = {
    "sum": _sum, "+": _sum, "difference": _difference, "minus": _minus, "product": _product, "*": _product,
    "int": _int, "remainder": _remainder, "modulo": _remainder, "first": structures.first,
    "butfirst": structures.butfirst,
    "last": structures.last, "fput": structures.fput, "list": structures.list_of, "word": structures.joined,
    "char": structures.char, "ascii": structures.ascii_of, "item": structures.item,
}  # fmt: skip
CONDITIONS: dict[str, Callable[[Emitter, Call], Expr]] = {
    "lessp": _comparison(ast.Lt), "greaterp": _comparison(ast.Gt), "lessequalp": _comparison(ast.LtE),
    "greaterequalp": _comparison(ast.GtE), "equalp": _equal, "notequalp": _not_equal, "emptyp": _empty,
    "listp": _of_type("LISTS"), "wordp": _of_type("WORDS"), "numberp": _of_type("NUMBERS"), "not": _not, "and": _and,
    "or": _or, "memberp": structures.member, "beforep": _predicate, "substringp": _predicate,
}  # fmt: skip
