"""An error as the prompt shows it: what is wrong, and the line that it is in with the place marked."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from prompt_toolkit import print_formatted_text
from prompt_toolkit.formatted_text import FormattedText
from prompt_toolkit.styles import Style

if TYPE_CHECKING:
    from turtlewire.logo import LogoError, Position

# What is written at the prompt has this for a file.
INPUT = "input"
STYLE = Style.from_dict({"error": "bold ansired", "place": "bold underline ansired", "hint": "ansicyan"})
# A word, or the bracket or sign that is meant.
MEANT = re.compile(r"[\"':]?[^\s\[\](){}+\-*/=<>;]+|.")


def show(error: LogoError) -> None:
    """Print an error."""
    print_formatted_text(fragments(error), style=STYLE)


def fragments(error: LogoError) -> FormattedText:
    """An error, piece by piece, each with its style."""
    sentence = f"{error.text} in {error.procedure}" if error.procedure else error.text
    found: list[tuple[str, str]] = [("class:error", sentence)]
    position = error.position
    if position is not None:
        if position.file != INPUT:
            found.append(("", f" ({position.file}, line {position.line})"))
        found += _marked(position)
    advice = error.advice()
    if advice:
        found += [("", "\n"), ("class:hint", advice)]
    return FormattedText(found)


def _marked(position: Position) -> list[tuple[str, str]]:
    """The source line, with the word at the place set apart, and a caret below it."""
    text, start = position.text, position.column - 1
    match = MEANT.match(text, start)
    end = match.end() if match else start
    caret = position.marked().rpartition("\n")[2]
    return [
        ("", f"\n    {text[:start]}"),
        ("class:place", text[start:end]),
        ("", f"{text[end:]}\n{caret[:-1]}"),
        ("class:error", "^"),
    ]
