"""Compiled procedures do what the evaluator does: the same output and drawing, the same errors at the same place."""

from __future__ import annotations

import gc
import random
import resource
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import pytest
from hypothesis import HealthCheck, given, reject, settings
from hypothesis import strategies as st

from turtlewire.errors import TurtlewireError
from turtlewire.logo import Interpreter, LogoError, ScreenTurtle
from turtlewire.logo.values import show

if TYPE_CHECKING:
    from collections.abc import Iterator

MEMORY, OUT_OF_SPACE = 4 << 30, 1

VARIABLES = ["a", "b", "c", "g"]
PROCEDURES = {"p": 1, "q": 2, "r": 0, "s": 1, "u": 1, "v": 2}
BINARY = ["+", "-", "*", "/", "<", ">", "=", "<=", ">=", "<>"]
OPERATIONS = {
    "sum": 2, "difference": 2, "product": 2, "quotient": 2, "remainder": 2, "modulo": 2, "minus": 1, "int": 1,
    "first": 1, "butfirst": 1, "last": 1, "butlast": 1, "fput": 2, "lput": 2, "list": 2, "sentence": 2, "word": 2,
    "item": 2, "count": 1, "emptyp": 1, "listp": 1, "wordp": 1, "numberp": 1, "equalp": 2, "memberp": 2, "not": 1,
    "and": 2, "or": 2, "lessp": 2, "uppercase": 1, "thing": 1, "abs": 1, "reverse": 1, "char": 1, "ascii": 1,
    "gprop": 2, "mditem": 2, "substringp": 2,
}  # fmt: skip
LITERALS = [
    "0", "1", "2", "-1", "2.5", "007", '"', '"x', '"abc', '"12', "[]", "[1 2 3]", "[a [b c] 4]", '"true', '"false',
    "9007199254740993", "1e200", "[print 1]", "[:a]", "{1 2 3}", "(array 2 0)", "(mdarray [2 2])", '"aeiou', '"K', '"+',
]  # fmt: skip


# Whatever calls or repeats whatever, it comes to an end.
FUEL = 'make "fuel :fuel - 1 if :fuel < 0 [throw "toplevel]'


class Scope(NamedTuple):
    """Where in a program something stands: how deep, in a procedure, a loop, a template or not."""

    depth: int
    in_procedure: bool = False
    in_repeat: bool = False
    in_template: bool = False

    def deeper(self, **changes: bool) -> Scope:
        return self._replace(depth=self.depth - 1, **changes)


@cache
def expressions(scope: Scope) -> st.SearchStrategy[str]:
    simple = [st.sampled_from(LITERALS), st.sampled_from([f":{name}" for name in VARIABLES])]
    if scope.in_repeat:
        simple.append(st.just("repcount"))
    if scope.in_template:
        simple.append(st.just("?"))
    if scope.depth <= 0:
        return st.one_of(simple)
    inner = expressions(scope.deeper())
    template = expressions(scope.deeper(in_template=True, in_repeat=False))

    def applied(name: str) -> st.SearchStrategy[str]:
        return st.tuples(*[inner] * OPERATIONS[name]).map(lambda found: f"({name} {' '.join(found)})")

    def called(name: str) -> st.SearchStrategy[str]:
        return st.tuples(*[inner] * PROCEDURES[name]).map(lambda found: f"({name} {' '.join(found)})")

    return st.one_of(
        *simple,
        st.tuples(inner, st.sampled_from(BINARY), inner).map(lambda found: f"({' '.join(found)})"),
        st.sampled_from(list(OPERATIONS)).flatmap(applied),
        st.sampled_from(list(PROCEDURES)).flatmap(called),
        st.tuples(inner, inner, inner).map(lambda found: f"(ifelse {found[0]} [{found[1]}] [{found[2]}])"),
        st.tuples(st.sampled_from(["map", "filter", "find"]), template, inner).map(
            lambda found: f"({found[0]} [{found[1]}] {found[2]})"
        ),
        st.tuples(st.sampled_from(['"sum', '"p', '"word', "[(list ?1 ?2)]"]), inner).map(
            lambda found: f"(reduce {found[0]} {found[1]})"
        ),
        st.tuples(st.sampled_from(['"first', '"p', '"nope']), inner).map(
            lambda found: f"(map {found[0]} {found[1]})"
        ),
        inner.map(lambda found: f"(run [{found}])"),
        # What is true may be said by a list.
        inner.map(lambda found: f"(not [{found}])"),
        st.tuples(st.sampled_from(["and", "or"]), inner, inner).map(
            lambda found: f"({found[0]} [{found[1]}] {found[2]})"
        ),
        st.tuples(inner, inner, inner).map(lambda found: f"(ifelse [{found[0]}] [{found[1]}] [{found[2]}])"),
    )


@cache
def instructions(scope: Scope) -> st.SearchStrategy[str]:
    value = expressions(scope.deeper())
    names = st.sampled_from(VARIABLES)
    kinds = [
        value.map(lambda found: f"show {found}"),
        st.tuples(names, value).map(lambda found: f'make "{found[0]} {found[1]}'),
        value.map(lambda found: f"fd {found}"),
        value.map(lambda found: f"rt {found}"),
        value,
        value.map(lambda found: f"ignore {found}"),
        st.tuples(names, st.sampled_from(["+ 1", "- 1", "* 2", "+ 0.5", "+ 16"])).map(
            lambda found: f'make "{found[0]} :{found[0]} {found[1]}'
        ),
        st.tuples(value, names, value).map(lambda found: f"setitem {found[0]} :{found[1]} {found[2]}"),
        st.tuples(value, names, value).map(
            lambda found: f"mdsetitem list {found[0]} 1 :{found[1]} {found[2]}"
        ),
        st.tuples(names, value).map(lambda found: f'pprop "list "{found[0]} {found[1]}'),
    ]
    if scope.in_procedure:
        kinds += [value.map(lambda found: f"output {found}"), st.just("stop")]
        kinds += [st.tuples(names, value).map(lambda found: f'localmake "{found[0]} {found[1]}')]
        kinds += [names.map(lambda found: f'local "{found}')]
    if scope.depth > 0:
        block = blocks(scope.deeper())
        loop = blocks(scope.deeper(in_repeat=True))
        template = blocks(scope.deeper(in_template=True, in_repeat=False))
        count = st.sampled_from(["0", "1", "2", "3", "-1", "1.5", "[2 1]", "first [2]", '"x'])
        kinds += [
            st.tuples(value, block).map(lambda found: f"if {found[0]} [{found[1]}]"),
            st.tuples(value, block).map(lambda found: f"if [{found[0]}] [{found[1]}]"),
            st.tuples(value, block).map(lambda found: f"until [{found[0]}] [{FUEL} {found[1]}]"),
            st.tuples(value, block, block).map(lambda found: f"ifelse {found[0]} [{found[1]}] [{found[2]}]"),
            st.tuples(value, block, block).map(
                lambda found: f"test {found[0]} iftrue [{found[1]}] iffalse [{found[2]}]"
            ),
            st.tuples(count, loop).map(lambda found: f"repeat {found[0]} [{found[1]}]"),
            st.tuples(names, count, count, block).map(
                lambda found: f"for [{found[0]} {found[1]} {found[2]}] [{FUEL} {found[3]}]"
            ),
            st.tuples(names, count, block).map(
                lambda found: f"while [:{found[0]} < {found[1]}] [{FUEL} {found[2]}]"
            ),
            st.tuples(value, template).map(lambda found: f"foreach {found[0]} [{found[1]}]"),
            st.tuples(st.sampled_from(["error", "t"]), block).map(
                lambda found: f'catch "{found[0]} [{found[1]}] show error'
            ),
            st.just('throw "t'),
            st.tuples(st.sampled_from(list(PROCEDURES)), st.tuples(value, value)).map(
                lambda found: f"{found[0]} {' '.join(found[1][: PROCEDURES[found[0]]])}"
            ),
        ]  # fmt: skip
    return st.one_of(kinds)


@cache
def blocks(scope: Scope) -> st.SearchStrategy[str]:
    return st.lists(instructions(scope), max_size=3).map(" ".join)


@st.composite
def programs(draw: st.DrawFn) -> str:
    lines: list[str] = []
    for name, count in PROCEDURES.items():
        inputs = " ".join(f":{each}" for each in VARIABLES[:count])
        lines += [f"to {name} {inputs}", FUEL]
        lines += draw(st.lists(instructions(Scope(2, in_procedure=True)), max_size=4))
        if name in ("u", "v"):  # each ends in the other
            value = draw(expressions(Scope(1)))
            lines.append(f"output v {value} :a" if name == "u" else f"output u {value}")
        lines.append("end")
    lines += ['make "fuel 60', 'make "g 5', 'make "a 3', 'make "c (array 3)', 'pprop "list "g 7']
    lines += draw(st.lists(instructions(Scope(3)), min_size=1, max_size=4))
    return "\n".join(lines) + "\n"


@pytest.fixture(autouse=True)
def _bounded_memory() -> Iterator[None]:
    """A few turns of ``word :a :a`` are enough to fill a computer."""
    bound, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, hard))
    yield
    resource.setrlimit(resource.RLIMIT_AS, (bound, hard))


def outcome(program: str, *, compiles: bool) -> tuple[str, object, object]:
    """What it prints, what it draws, and its error."""
    written: list[str] = []
    turtle = ScreenTurtle()
    logo = Interpreter(turtle, written.append, random.Random(0), compiles=compiles)
    error: object = None
    try:
        logo.run(program, "random.logo")
    except LogoError as caught:
        if caught.number == OUT_OF_SPACE:
            del caught
            gc.collect()
            reject()  # both do sooner or later, but not at the same instruction
        shown = caught.instruction and show(caught.instruction)
        error = (caught.number, caught.text, caught.procedure, shown, str(caught))
    except TurtlewireError as caught:
        error = str(caught)
    pose = turtle.pose
    return "".join(written), (pose.x_mm, pose.y_mm, pose.heading_deg), error


@settings(max_examples=400, deadline=None, suppress_health_check=list(HealthCheck))
@given(programs())
def test_compiled_programs_do_what_the_evaluator_does(program: str) -> None:
    assert outcome(program, compiles=True) == outcome(program, compiles=False)


@pytest.mark.nightly
@settings(max_examples=100_000, deadline=None, suppress_health_check=list(HealthCheck))
@given(programs())
def test_a_hundred_thousand_programs(program: str) -> None:
    assert outcome(program, compiles=True) == outcome(program, compiles=False)
