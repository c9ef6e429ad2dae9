"""Whether a program goes on: a bracket, a parenthesis, a bar or a procedure is still open at its end."""

from __future__ import annotations

from turtlewire.logo.errors import LogoError
from turtlewire.logo.reader import read

_STILL_OPEN = 10
_NO_END = 33


def is_unfinished(text: str) -> bool:
    """Whether more lines are needed before the text can be run. A mistake in it needs none: it is to be told."""
    if text.endswith(("~", "\\")):
        return True
    try:
        read(text)
    except LogoError as error:
        return error.number == _STILL_OPEN or (
            error.number == _NO_END and error.text.startswith("END not found")
        )
    return False
