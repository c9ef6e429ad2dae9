from __future__ import annotations

import pytest

from turtlewire.logo.errors import LogoError
from turtlewire.logo.reader import Definition, Line, read
from turtlewire.logo.receiving import read_list
from turtlewire.logo.values import show


def lines(text: str) -> list[str]:
    return [show(line.value, with_origins=True) for line in read(text) if isinstance(line, Line)]


def error(text: str) -> LogoError:
    with pytest.raises(LogoError) as caught:
        read(text, "a.logo")
    return caught.value


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("fd 10\n\n  rt 90", ["[fd 10]", "[rt 90]"]),
        ("a\r\nb\rc", ["[a]", "[b]", "[c]"]),
        ("a [b\nc] d", ["[a [b c] d]"]),
        ("a (b\nc) d\ne", ["[a (b c) d]", "[e]"]),
        ("a ~\nb", ["[a b]"]),
        ("a~\nb", ["[ab]"]),
        ("a~b ~ c", ["[a~b ~ c]"]),
        ("a ~ \t \nb", ["[a b]"]),
        ("a~ \t \nb", ["[ab]"]),
        ("a ~", ["[a ~]"]),
        ("{a b}@0", ["[{a b}@0]"]),
        ("{a b}@-12 c", ["[{a b}@-12 c]"]),
        ("{a b}@ c", ["[{a b} c]"]),
        ("{a b}@- c", ["[{a b} - c]"]),
        ("{a b}c", ["[{a b} c]"]),
        (f"{{a}}@{'1' * 15}2", [f"[{{a}}@{'1' * 15} 2]"]),
        ("a ; b\nc", ["[a]", "[c]"]),
        ("a; b ~\nc", ["[ac]"]),
        ("a ;b ~\nc", ["[a c]"]),
        ("a;b", ["[a]"]),
        ("#! logo\na", ["[a]"]),
        ("a\n#! logo\nb", ["[a]", "[b]"]),
        ("a #!b", ["[a #!b]"]),
        ("|a b|c d", ["[a bc d]"]),
        ("|a\\|b|", ["[a|b]"]),
        ("a\\ b", ["[a b]"]),
        ("a\\\nb", ["[a\nb]"]),
        ("a\\", ["[a]"]),
        ("[(a] b", ["[[(a] b]"]),
        ("a) b\nc", ["[a) b]", "[c]"]),
    ],
)
def test_lines(text: str, expected: list[str]) -> None:
    assert lines(text) == expected


def test_places_count_in_the_file() -> None:
    (line,) = read("\n  fd [a\n b]", "p.logo")
    assert isinstance(line, Line)
    inner = line.items[1]
    assert isinstance(inner, Line)
    place = inner.position(1)
    assert place is not None
    assert (place.file, place.line, place.column, place.text) == ("p.logo", 3, 2, " b]")


def test_definitions() -> None:
    (definition,) = read("To sq :n\n\nfd (:n +\n1)\nEND\n")
    assert isinstance(definition, Definition)
    assert show(definition.title.value) == "[To sq :n]"
    assert [show(line.value) for line in definition.body] == ["[fd (:n + 1)]"]


@pytest.mark.parametrize(
    ("text", "number", "line", "column", "hint"),
    [
        ("a\nb [c [d", 10, 2, 6, "This [ has no ]"),
        ("a (b (c)", 10, 1, 3, "This ( has no )"),
        ("a |b\nc", 10, 1, 3, "This | has no partner"),
        ("a ]", 26, 1, 3, ""),
        ("to f\nprint [a\nend\n]", 33, 2, 7, "This [ is still open"),
        ("to f\nprint (1\n end", 33, 2, 7, "This ( is still open"),
        ("to f\nprint 1", 33, 1, 1, "no END up to the end"),
        ("to f\nprint 1\nto g\nend", 23, 3, 1, "procedure f, begun in line 1"),
        ("to [x]\nto g\nend", 23, 2, 1, "procedure to, begun in line 1"),
    ],
)
def test_what_is_left_open(text: str, number: int, line: int, column: int, hint: str) -> None:
    found = error(text)
    assert found.position is not None
    assert (found.number, found.position.line, found.position.column) == (number, line, column)
    assert hint in str(found)


def test_a_list_from_a_text() -> None:
    assert show(read_list("a [b\nc]\nd")) == "[a [b c] d]"
    assert show(read_list("")) == "[]"
