"""Logo keeps its promises on whatever text and numbers there are."""

from __future__ import annotations

import random

from hypothesis import given, settings
from hypothesis import strategies as st

from turtlewire.logo import Interpreter, LogoError, ScreenTurtle
from turtlewire.logo.reader import Line, read, read_list
from turtlewire.logo.tokens import tokenize
from turtlewire.logo.values import Value, equal, make_list, show, to_text, word

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
