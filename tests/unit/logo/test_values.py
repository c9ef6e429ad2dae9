from __future__ import annotations

import pytest

from turtlewire.logo.values import (
    LogoList,
    Number,
    Value,
    backslashed,
    barred,
    equal,
    format_number,
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


def test_numbers_stay_finite() -> None:
    assert narrowed(2**53 + 1) == 2.0**53
    assert narrowed(10**400) is None
    assert narrowed(float("inf")) is None
    assert narrowed(2.5) == 2.5


@pytest.mark.parametrize(
    ("text", "value"), [("12", 12), ("1.5", 1.5), ("007", "007"), ("1.50", "1.50"), ("a1", "a1"), ("", "")]
)
def test_a_word_that_spells_a_number_is_one(text: str, value: Value) -> None:
    assert word(text) == value
    assert type(word(text)) is type(value)


def test_marks() -> None:
    assert plain(barred("a b(")) == plain(backslashed("a b(")) == "a b("
    assert without_backslashes(backslashed("(")) == "("
    assert without_backslashes(barred("(")) == barred("(") != "("
    assert plain("ä") == without_backslashes("ä") == "ä"


def test_printing() -> None:
    value = LogoList(("a", LogoList(), LogoList((1, LogoList(("b",)))), "", 2.5))
    assert show(value) == "[a [] [1 [b]]  2.5]"
    assert to_words(value) == "a [] [1 [b]]  2.5"
    assert show_in_error("") == "||"
    assert repr(value) == f"LogoList({show(value)})"
    assert len(value) == 5


def test_equality() -> None:
    assert equal("abc", "ABC")
    assert not equal("abc", "ABC", ignore_case=False)
    assert equal("007", 7)
    assert equal("007", "7.0")
    assert not equal("a", 7)
    assert not equal("a", "b")
    assert equal(barred("a b"), "a b")
    assert equal(LogoList((1, LogoList(("A",)))), LogoList(("1.0", LogoList(("a",)))))
    assert not equal(LogoList((1,)), LogoList((1, 2)))
    assert not equal(LogoList(), "")


def test_no_number() -> None:
    assert to_number(LogoList((1,))) is None


def test_deep_lists() -> None:
    a, b = LogoList((1,)), LogoList((1,))
    for _ in range(5000):
        a, b = LogoList((a,)), LogoList((b,))
    assert equal(a, b)
    assert show(a) == "[" * 5001 + "1" + "]" * 5001
