"""docs/logo/coverage.md: every word of the Berkeley Logo manual, where it is implemented, or why it is left out."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, Any

from tools.generators import primitives
from tools.generators.python import ROOT

if TYPE_CHECKING:
    from pathlib import Path

_TABLE = ROOT / "spec" / "logo" / "manual.toml"
_PAGE = ROOT / "docs" / "logo" / "coverage.md"


def table() -> dict[str, Any]:
    """The table of the manual's words."""
    return tomllib.loads(_TABLE.read_text("utf-8"))


def reasons() -> dict[str, str]:
    """Why each word is left out."""
    return {word: each["reason"] for each in table()["left_out"] for word in each["words"].split()}


def place_of(word: str) -> str | None:
    """The module that implements a word; ``None`` when none does."""
    for chapter, words in primitives.chapters().items():
        if word in words:
            return f"logo/primitives/{chapter}.py"
    found: str | None = table()["variables"].get(word)
    return found


def _row(words: list[str], why_not: dict[str, str]) -> str:
    names = ", ".join(f"`{word}`" if word != "`" else "`` ` ``" for word in words)
    place = place_of(words[0])
    if place is not None:
        return f"| {names} | [{place}](../../src/turtlewire/{place}) |"
    return f"| {names} | left out: {why_not[words[0]]} |"


def files() -> dict[Path, str]:
    """The page."""
    why_not = reasons()
    chapters = table()["chapter"]
    words = [word for chapter in chapters for row in chapter["words"] for word in row.split()]
    there = sum(place_of(word) is not None for word in words)
    lines = [
        "# What there is of the Berkeley Logo manual",
        "",
        "Made by `make generate` from `spec/logo/manual.toml`, a table of all words in UCBLogo's manual.",
        f"Of {len(words)} words, {there} are implemented; of the others it says why not.",
        "What the words do, and what there is besides, stands on the page about [Logo](../logo.md).",
    ]
    for chapter in chapters:
        lines += ["", f"## {chapter['title']}", "", "| word | |", "| --- | --- |"]
        lines += [_row(row.split(), why_not) for row in chapter["words"]]
    return {_PAGE: "\n".join(lines) + "\n"}
