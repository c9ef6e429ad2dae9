"""Logo keeps its promises on whatever text and numbers there are."""

from __future__ import annotations

import random

from hypothesis import given, settings
from hypothesis import strategies as st

from turtlewire.logo import Interpreter, LogoError, ScreenTurtle
from turtlewire.logo.printout import variable_text
from turtlewire.logo.reader import Line, read
from turtlewire.logo.receiving import read_list
from turtlewire.logo.tokens import tokenize
from turtlewire.logo.values import (
    Array,
    Value,
    barred,
    equal,
    make_list,
    members_of,
    show,
    show_in_error,
    to_text,
    word,
)

LOGO_TEXT = st.text(
    alphabet=st.one_of(st.sampled_from("ab1.e \n[]()+-*/=<>\"\\:;|~?#!{}'"), st.characters()), max_size=60
)
WORDS = st.text(alphabet="abcXYZ019.-+äπ", min_size=1, max_size=6)
PIECES = [
    "fd",
    "10",
    "repeat",
    "[",
    "]",
    "(",
    ")",
    "print",
    '"a',
    ":x",
    "make",
    '"x',
    "+",
    "-",
    "if",
    "sum",
    "first",
    "to",
    "f",
    "end",
    "\n",
    "output",
    "stop",
    "run",
    "for",
    "-2",
    "<",
    "butfirst",
    "item",
    "list",
]


def values() -> st.SearchStrategy[Value]:
    return st.recursive(
        WORDS.map(word), lambda inner: st.lists(inner, max_size=4).map(make_list), max_leaves=12
    )


# Words with any letters, some of them as if between bars; a carriage return is a newline wherever text is read.
ODD_LETTERS = st.one_of(
    st.sampled_from('ab1 \n\t[](){}|\\~;":@-'), st.characters(codec="utf-8", exclude_characters="\r")
)
ODD_WORDS = st.lists(
    st.tuples(
        st.text(alphabet=ODD_LETTERS, max_size=4),
        st.booleans(),
    ),
    max_size=3,
).map(lambda pieces: word("".join([barred(text) if is_barred else text for text, is_barred in pieces])))


def odd_values() -> st.SearchStrategy[Value]:
    return st.recursive(
        ODD_WORDS,
        lambda inner: st.one_of(
            st.lists(inner, max_size=4).map(make_list),
            st.builds(Array, st.lists(inner, max_size=3), st.integers(-2, 2)),
        ),
        max_leaves=12,
    )


def are_alike(a: Value, b: Value) -> bool:
    """EQUALP with arrays compared by their members."""
    if isinstance(a, Array) and isinstance(b, Array):
        return a.origin == b.origin and are_alike(make_list(a.items), make_list(b.items))
    if isinstance(a, list) and isinstance(b, list):
        mine, theirs = members_of(a), members_of(b)
        return len(mine) == len(theirs) and all(are_alike(x, y) for x, y in zip(mine, theirs, strict=True))
    return equal(a, b, ignore_case=False)


def assert_is_placed(error: LogoError) -> None:
    assert error.position is not None
    assert error.position.marked() in str(error)


@given(LOGO_TEXT)
def test_the_reader_raises_only_logo_errors(text: str) -> None:
    try:
        for line in read(text, "any.logo"):
            if isinstance(line, Line):
                tokenize(line)
    except LogoError as error:
        assert_is_placed(error)


@settings(max_examples=300)
@given(st.lists(st.sampled_from(PIECES), max_size=14).map(" ".join))
def test_bad_programs_raise_only_logo_errors(program: str) -> None:
    try:
        Interpreter(ScreenTurtle(), lambda _: None, random.Random(0)).run(program, "any.logo")
    except LogoError as error:
        assert_is_placed(error)


@given(values())
def test_what_is_shown_can_be_read(value: Value) -> None:
    as_list = make_list((value,))
    again = read_list(show(as_list))[0]
    assert equal(again, as_list, ignore_case=False)


@given(WORDS)
def test_a_word_keeps_its_text(text: str) -> None:
    value = word(text)
    assert isinstance(value, str | int | float)
    assert to_text(value) == text


@given(st.integers(-(10**7), 10**7), st.integers(-(10**7), 10**7))
def test_whole_numbers_are_exact(a: int, b: int) -> None:
    written: list[str] = []
    program = f"print ({a})+({b}) print ({a})-({b}) print ({a})*({b}) print ({a})<({b})"
    divisible = b != 0
    if divisible:
        program += f" print modulo {a} {b} print remainder {a} {b}"
    Interpreter(ScreenTurtle(), written.append, random.Random(0)).run(program)
    expected = [str(a + b), str(a - b), str(a * b), "true" if a < b else "false"]
    if divisible:
        sign = -1 if a < 0 else 1
        expected += [str(a % b), str(sign * (abs(a) % abs(b)))]
    assert "".join(written).split() == expected


@given(st.lists(odd_values(), max_size=4).map(make_list))
def test_what_fullprintp_prints_can_be_read_again(value: Value) -> None:
    assert are_alike(read_list(show_in_error(value)[1:-1]), value)


@given(odd_values())
def test_a_variable_that_is_saved_has_its_value_again(value: Value) -> None:
    interpreter = Interpreter(ScreenTurtle(), lambda _: None, random.Random(0))
    interpreter.run(variable_text("v", value))
    assert are_alike(interpreter.variables["v"], value)
