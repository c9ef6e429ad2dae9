"""Laying out a program changes nothing but spaces, whatever the program is, and doing it twice changes nothing more."""

from __future__ import annotations

import re

from hypothesis import example, given, reject
from hypothesis import strategies as st

from turtlewire.logo import LogoError
from turtlewire.logo.formatting import formatted
from turtlewire.logo.reader import Definition, Line, read, value_of
from turtlewire.logo.tokens import tokenize
from turtlewire.logo.values import show, to_text

BLANK = re.compile(r"[\s\0]+")
PIECES = [
    *(
        "fd",
        "10",
        "repeat",
        "print",
        '"a',
        ":x",
        "make",
        '"x',
        "+",
        "-",
        "*",
        "/",
        "=",
        "<=",
        "-2",
        "-:x",
        "(-",
    ),
    *(
        "if",
        "sum",
        "first",
        "to f :x",
        "\nto g\n",
        "\nend\n",
        "output",
        "run",
        "map",
        "[? + 1]",
        "a-b",
        "1+2",
    ),
    *(
        "[",
        "]",
        "(",
        ")",
        "{",
        "}",
        "}@0",
        "\n",
        "\n\n",
        " ",
        "   ",
        "\t",
        "; why\n",
        ";why ~\n",
        "~\n",
        " ~\n",
    ),
    *("|a  b|", "|\n|", "\\ ", "\\\n", "\\;", "#!x\n", "x;y~\n", "word~\n", "\\", "~", "?1", "1e-7", "äπ"),
]
PROGRAMS = st.lists(st.tuples(st.sampled_from(PIECES), st.sampled_from(["", " ", "\n"]))).map(
    lambda pieces: "".join(piece + space for piece, space in pieces)
)
TEXTS = st.text(alphabet=st.one_of(st.sampled_from("ab1.e \n[]{}()+-*/=<>\"\\:;|~?#!@'"), st.characters()))


def tokens(line: Line) -> list[object]:
    """What a line says when it is run; the lists in it may be, too."""
    try:
        found = tokenize(line)
    except LogoError:
        return [show(value_of(line), lambda word: word)]
    return [
        (token.kind, tokens(token.value) if isinstance(token.value, Line) else spelled(token.value))
        for token in found
    ]


def spelled(value: object) -> str:
    return to_text(value) if isinstance(value, str | int | float) else show(value, lambda word: word)  # type: ignore[arg-type]


def meaning(text: str) -> list[object]:
    return [
        [[spelled(value_of(each.title))], *map(tokens, each.body)]
        if isinstance(each, Definition)
        else tokens(each)
        for each in read(text)
    ]


@given(st.one_of(PROGRAMS, TEXTS))
@example("print 3 -2 print 3-2 print -2-3")
@example('print "a~\nb')
@example(" #!a")
def test_the_tokens_and_all_but_spaces_stay(text: str) -> None:
    try:
        before = meaning(text)
    except LogoError:
        reject()
    laid_out = formatted(text)
    assert meaning(laid_out) == before
    assert BLANK.sub("", laid_out) == BLANK.sub("", text)


@given(st.one_of(PROGRAMS, TEXTS))
def test_a_second_time_changes_nothing(text: str) -> None:
    try:
        once = formatted(text)
    except LogoError:
        reject()
    assert formatted(once) == once
