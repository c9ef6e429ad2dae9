"""What a program says, kept for whoever looks: the last of its output, and texts that can be sent on."""

from __future__ import annotations

from typing import Any

# What is kept of what a program has written, characters.
KEPT = 100_000


class Output:
    """What a program has written: the last of it.

    Attributes:
        written: how many characters there were in all.
    """

    def __init__(self) -> None:
        self._text = ""
        self.written = 0

    def add(self, text: str) -> None:
        """It has written more."""
        self._text = (self._text + text)[-KEPT:]
        self.written += len(text)

    def since(self, index: int) -> tuple[int, str]:
        """What was written from a character on, and where that begins: later, if it is forgotten already."""
        first = self.written - len(self._text)
        start = min(max(index, first), self.written)
        return start, self._text[start - first :]


def sayable(value: object) -> str:
    """A text that can be sent on: half a character is none."""
    return str(value).encode("utf-8", "replace").decode("utf-8")


def cleaned(value: Any) -> Any:
    """The same, with texts that can be sent on."""
    if isinstance(value, str):
        return sayable(value)
    if isinstance(value, dict):
        return {sayable(key): cleaned(each) for key, each in value.items()}
    return value if isinstance(value, int | float | None) else str(value)
