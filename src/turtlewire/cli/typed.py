"""The keyboard of a program that has a progress bar."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.logo.keyboard import StandardInput

if TYPE_CHECKING:
    from turtlewire.cli.progress import Bar


class TypedPast(StandardInput):
    """The keyboard of a program with a bar, which is away while somebody types."""

    def __init__(self, bar: Bar) -> None:
        super().__init__()
        self._bar = bar

    def read_line(self) -> str:
        """The next line with its newline; ``""`` at the end."""
        with self._bar.away(ends_line=True):
            return super().read_line()

    def read_character(self) -> str:
        """The next character; ``""`` at the end."""
        with self._bar.away(ends_line=False):
            return super().read_character()
