from __future__ import annotations

import pytest

from turtlewire.logo.values import (
    Array,
    Number,
    SpelledNumber,
    Value,
    backslashed,
    barred,
    equal,
    format_number,
    make_list,
    members_of,
    narrowed,
    parse_number,
    plain,
    show,
    show_in_error,
    to_number,
    to_words,
    without_backslashes,
    word,
)


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("12", 12), ("-3", -3), ("007", 7), (".5", 0.5), ("5.", 5.0), ("1e3", 1000.0), ("1e-7", 1e-7),
        ("9007199254740992", 2**53), ("9007199254740993", 2.0**53), ("1" * 25, float("1" * 25)),
        ("", None), ("-", None), (".", None), ("+3", None), ("--3", None), ("1e", None), ("e5", None), ("1.2.3", None),
        ("inf", None), ("nan", None), ("1e999", None), ("9" * 400, None), ("1_0", None), ("٣", None), ("0x10", None),
    ],
)  # fmt: skip
def test_numbers_in_words(text: str, number: Number | None) -> None:
    found = parse_number(text)
    assert found == number
    assert type(found) is type(number)


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (3, "3"),
        (3.0, "3"),
        (-0.5, "-0.5"),
        (10**15, "1e+15"),
        (999999999999999, "999999999999999"),
        (1 / 3, "0.333333333333333"),
    ],
)
def test_numbers_are_printed_with_15_digits(number: Number, text: str) -> None:
    assert format_number(number) == text


def test_large_whole_numbers_become_floats() -> None:
    assert type(narrowed(2**53)) is int
    assert narrowed(2**53 + 1) == 2.0**53
    assert type(narrowed(-(2**53) - 1)) is float
    assert narrowed(10**400) == float("inf")
    assert narrowed(-(10**400)) == -float("inf")
    assert format_number(10**400) == "inf"
    assert narrowed(2.5) == 2.5


@pytest.mark.parametrize(
    ("text", "value"),
    [("12", 12), ("1.5", 1.5), ("-3", -3), ("a1", "a1"), ("", ""), ("-", "-"), ("1-2", "1-2")],
)
def test_a_word_that_spells_a_number_is_one(text: str, value: Value) -> None:
    assert word(text) == value
    assert type(word(text)) is type(value)


@pytest.mark.parametrize(("text", "number"), [("007", 7), ("1.50", 1.5), ("1e3", 1000), ("5.", 5), ("-0", 0)])
def test_an_odd_spelling_is_kept(text: str, number: float) -> None:
    value = word(text)
    assert isinstance(value, SpelledNumber)
    assert value == number
    assert show(value) == to_words(value) == text
    assert show(value + 1) == format_number(number + 1)


def test_marks() -> None:
    assert plain(barred("a b(")) == plain(backslashed("a b(")) == "a b("
    assert without_backslashes(backslashed("(")) == "("
    assert without_backslashes(barred("(")) == barred("(") != "("
    assert plain("ä") == without_backslashes("ä") == "ä"


def test_printing() -> None:
    value = make_list(("a", make_list(()), make_list((1, make_list(("b",)))), "", 2.5))
    assert show(value) == "[a [] [1 [b]]  2.5]"
    assert to_words(value) == "a [] [1 [b]]  2.5"
    assert show_in_error("") == "||"
    assert len(members_of(value)) == 5
    array = Array([1, make_list(("a", "b")), Array([], 0)])
    assert show(array) == to_words(array) == "{1 [a b] {}}"
    assert show_in_error(array) == "{1 [a b] {}@0}"
    array.items[2] = make_list((array, "c"))
    assert show(array) == "{1 [a b] [{...} c]}"


def test_equality() -> None:
    assert equal("abc", "ABC")
    assert not equal("abc", "ABC", ignore_case=False)
    assert equal(word("007"), 7)
    assert equal(word("007"), word("7.0"))
    assert not equal("a", 7)
    assert not equal("a", "b")
    assert equal(barred("a b"), "a b")
    assert equal(make_list((1, make_list(("A",)))), make_list((word("1.0"), make_list(("a",)))))
    assert not equal(make_list((1,)), make_list((1, 2)))
    assert not equal(make_list(()), "")


def test_no_number() -> None:
    assert to_number(make_list((1,))) is None


def test_deep_lists() -> None:
    a, b = make_list((1,)), make_list((1,))
    for _ in range(5000):
        a, b = make_list((a,)), make_list((b,))
    assert equal(a, b)
    assert show(a) == "[" * 5001 + "1" + "]" * 5001
