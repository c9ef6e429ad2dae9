"""Every word of the Berkeley manual is implemented, or left out for a reason; and the page says so."""

from __future__ import annotations

import re

from tools.generators import coverage
from tools.generators.python import ROOT
from turtlewire.logo.primitives import PRIMITIVES

ROWS = [row.split() for chapter in coverage.table()["chapter"] for row in chapter["words"]]
WORDS = [word for row in ROWS for word in row]
# What the manual does not have.
OWN = {
    "{}", "abs", "tan", "pi", "distance", "hornoff", "hornlo", "hornhi", "eyeson", "eyesoff", "setspeed", "onlimit",
    "limitsensor", "onstop", "tell", "who", "each",
}  # fmt: skip


def test_no_word_stands_twice() -> None:
    assert len(WORDS) == len(set(WORDS)) > 430


def test_every_word_is_implemented_or_left_out_for_a_reason() -> None:
    reasons = coverage.reasons()
    for word in WORDS:
        assert (coverage.place_of(word) is None) is (word in reasons), word


def test_what_is_left_out_is_in_the_manual() -> None:
    assert set(coverage.reasons()) <= set(WORDS)
    assert all(reason.endswith(".") for reason in coverage.reasons().values())


def test_words_of_one_row_are_in_one_place() -> None:
    for row in ROWS:
        assert len({coverage.place_of(word) for word in row}) == 1, row


def test_every_primitive_is_the_manuals_or_known_to_be_our_own() -> None:
    assert set(PRIMITIVES) - set(WORDS) == OWN


def test_variables_are_heeded_where_the_table_says() -> None:
    for variable, place in coverage.table()["variables"].items():
        assert re.search(rf"\b{variable}\b", (ROOT / "src" / "turtlewire" / place).read_text("utf-8")), (
            variable
        )


def test_the_page_has_every_word() -> None:
    ((path, page),) = coverage.files().items()
    assert path == ROOT / "docs" / "logo" / "coverage.md"
    assert path.read_text("utf-8") == page
    found = re.findall(r"`` ` ``|`([^`]+)`", "".join(re.findall(r"^\| (.+?) \|", page, re.MULTILINE)))
    assert sorted(word or "`" for word in found) == sorted(WORDS)
