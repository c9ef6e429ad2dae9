"""What kind of number an expression gives, as far as the program's text says: so that nothing is asked while it runs.

A variable in a Python local has the kind that all of its assignments have. One that only counts, by steps written in
the program from where it begins, is taken to stay small: it would have to count for months to leave what is exact.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from turtlewire.logo.compiler.facts import as_line, literal_name
from turtlewire.logo.syntax import Call, Literal, Variable
from turtlewire.logo.values import plain

if TYPE_CHECKING:
    from collections.abc import Container, Iterable

    from turtlewire.logo.compiler.facts import Survey
    from turtlewire.logo.syntax import Node

NOTHING = 0
NUMBER = 1  # an int or a float
WHOLE = 2  # an int
SMALL = 4  # far from 2**53, on either side
NATURAL = 8  # not below 0
ARRAY = 16  # no number: an array
COUNT = NUMBER | WHOLE | SMALL | NATURAL
SMALL_AT_FIRST = 2**40  # what a small number may be when it begins to count
_STEP = 16  # by how much it may count at once
_FACTOR = 8  # what a small number may be multiplied by

_NUMBERS = frozenset((
    "sum", "+", "difference", "minus", "product", "*", "quotient", "remainder", "modulo", "int", "round", "abs",
    "sqrt", "power", "exp", "log10", "ln", "sin", "cos", "tan", "radsin", "radcos", "arctan", "radarctan", "pi",
    "bitand", "bitor", "bitxor", "bitnot", "ashift", "lshift",
))  # fmt: skip
_COUNTS = frozenset(("count", "ascii", "repcount"))
_ARRAYS = frozenset(("array", "mdarray", "listtoarray", "{}"))
_ANY = COUNT | ARRAY


class Kinds:
    """The kinds of a function's variables.

    Args:
        survey: what is known of all procedures.
        nodes: the instructions of the function.
        keys: the variables that have no value before, and that nothing else can set.
        others: those that it gets from elsewhere; the rest are loops' own.
        at_first: the kinds that more variables have before, and that nothing else can set.

    Attributes:
        assignments: which variables are given which values.
    """

    def __init__(
        self,
        survey: Survey,
        nodes: Iterable[Node] = (),
        keys: Iterable[str] = (),
        others: Container[str] = (),
        at_first: dict[str, int] | None = None,
    ) -> None:
        self._survey = survey
        assigned = self.assignments = self._assignments(nodes)
        at_first = at_first or {}
        known = {*keys, *at_first}
        known |= {key for key, value in assigned if isinstance(value, _Counting) and key not in others}
        assigned = [each for each in assigned if each[0] in known]
        self._found = {key: _ANY for key, _ in assigned} | at_first
        changes = True
        while changes:
            changes = False
            for key, value in assigned:
                kind = self._found[key] & self._assigned(key, value)
                changes |= kind != self._found[key]
                self._found[key] = kind

    def of_variable(self, key: str) -> int:
        """The kind of a variable."""
        return self._found.get(key, NOTHING)

    def of(self, node: Node) -> int:
        """The kind of an expression's value."""
        if isinstance(node, Literal):
            return of_literal(node.value)
        if isinstance(node, Variable):
            return self._found.get(node.key, NOTHING)
        if not isinstance(node, Call):
            return NOTHING
        name = node.primitive.name
        if name in _COUNTS:
            return COUNT
        if name not in _NUMBERS:
            return ARRAY if name in _ARRAYS else NOTHING
        kinds = [self.of(each) for each in node.inputs]
        return NUMBER | self._whole(name, node, kinds)

    @staticmethod
    def _whole(name: str, node: Call, kinds: list[int]) -> int:
        """What more is known of a number than that it is one."""
        both = WHOLE | SMALL | NATURAL
        for kind in kinds:
            both &= kind
        if not both & WHOLE or len(kinds) > 2:
            return NOTHING
        if name in ("sum", "+"):
            return both & ~SMALL
        if name in ("difference", "minus"):
            return WHOLE | (both & SMALL if name == "minus" else NOTHING)
        if name in ("product", "*") and len(kinds) == 2 and both & SMALL:
            factors = [each.value for each in node.inputs if isinstance(each, Literal)]
            if any(isinstance(each, int) and -_FACTOR <= each <= _FACTOR for each in factors):
                return both & ~SMALL
        if name in ("remainder", "modulo"):
            divisor = node.inputs[1]
            if isinstance(divisor, Literal) and isinstance(divisor.value, int) and divisor.value > 0:
                is_natural = NATURAL if name == "modulo" else kinds[0] & NATURAL
                return WHOLE | is_natural | (SMALL if divisor.value <= SMALL_AT_FIRST else NOTHING)
        return NOTHING

    def _assigned(self, key: str, value: Node | _Counting) -> int:
        """The kind of a value that is given to a variable, which may only count on."""
        if isinstance(value, _Counting):
            return self._counted(value)
        kind = self.of(value)
        if (
            isinstance(value, Call)
            and value.primitive.name in ("sum", "+", "difference")
            and len(value.inputs) == 2
        ):
            a, b = value.inputs
            if isinstance(a, Literal) and value.primitive.name != "difference":
                a, b = b, a
            counts = isinstance(a, Variable) and a.key == key
            if counts and isinstance(b, Literal) and type(b.value) is int and -_STEP <= b.value <= _STEP:
                kind |= self._found[key] & SMALL
        return kind

    def _assignments(self, nodes: Iterable[Node]) -> list[tuple[str, Node | _Counting]]:
        """Which variables are given which values."""
        found: list[tuple[str, Node | _Counting]] = []
        for node in self._survey.walk(nodes):
            if not isinstance(node, Call):
                continue
            name, inputs = node.primitive.name, node.inputs
            if name in ("make", "localmake", "name"):
                named, value = reversed(inputs) if name == "name" else inputs
                key = literal_name(named)
                if key is not None:
                    found.append((key, value))
            elif name == "for" and isinstance(inputs[0], Literal) and inputs[0].line is not None:
                control = inputs[0].line
                if 3 <= len(control.items) <= 4 and isinstance(control.items[0], str):
                    parsed = [
                        self._survey.parse(as_line(control, index)) for index in range(1, len(control.items))
                    ]
                    limits = [each[0] if len(each) == 1 else None for each in parsed]
                    found.append((plain(control.items[0]).lower(), _Counting(limits)))
        return found

    def _counted(self, counting: _Counting) -> int:
        """The kind of what a FOR counts: beginning with its start, up or down to its end."""
        start, end, *steps = [self.of(each) if each is not None else NOTHING for each in counting.limits]
        if not steps:
            return start if end & NATURAL else start & ~NATURAL
        step = counting.limits[2]
        is_slow = isinstance(step, Literal) and type(step.value) is int and -_STEP <= step.value <= _STEP
        return start & (steps[0] | SMALL if is_slow else steps[0] & ~SMALL)


class _Counting(NamedTuple):
    """What a FOR counts: start, end, and the step if it has one."""

    limits: list[Node | None]


def of_literal(value: object) -> int:
    """The kind of what stands in the program."""
    if type(value) is int:
        small = SMALL if -SMALL_AT_FIRST <= value <= SMALL_AT_FIRST else NOTHING
        return NUMBER | WHOLE | small | (NATURAL if value >= 0 else NOTHING)
    return NUMBER if isinstance(value, float) else NOTHING
