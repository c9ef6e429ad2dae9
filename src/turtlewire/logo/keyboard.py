"""The keyboard: where READLIST and READCHAR read from when no file is set."""

from __future__ import annotations

import contextlib
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


class Keyboard:
    """Somebody who types, line by line.

    Args:
        read_line: gives the next line with its newline, ``""`` at the end; like ``readline`` of a text file.
    """

    def __init__(self, read_line: Callable[[], str]) -> None:
        self._read_line = read_line
        self._typed = ""  # of a line, what READCHAR has not read yet

    def read_line(self) -> str:
        """The next line, or what is left of one, with its newline; ``""`` at the end."""
        line, self._typed = self._typed or self._read_line(), ""
        return line

    def read_character(self) -> str:
        """The next character; ``""`` at the end."""
        self._typed = self._typed or self._read_line()
        character, self._typed = self._typed[:1], self._typed[1:]
        return character

    def has_key(self) -> bool:
        """Whether a character can be read without waiting."""
        return bool(self._typed)


class StandardInput(Keyboard):
    """Standard input. At a terminal, READCHAR gets a key as soon as it is pressed, without showing it."""

    def __init__(self) -> None:
        super().__init__(_read_standard_input)

    def read_character(self) -> str:
        """The next character; ``""`` at the end."""
        if self._typed or not _is_terminal():
            return super().read_character()
        with _key_by_key():
            return sys.stdin.read(1)

    def has_key(self) -> bool:
        """Whether a key was pressed."""
        if self._typed or not _is_terminal():
            return bool(self._typed)
        import select

        with _key_by_key():
            return bool(select.select([sys.stdin], [], [], 0)[0])


def _read_standard_input() -> str:
    if sys.stdin is None:
        return ""
    if sys.stdout is not None:
        sys.stdout.flush()  # a question that TYPE asked
    return sys.stdin.readline()


def _is_terminal() -> bool:
    return sys.stdin is not None and sys.stdin.isatty()


@contextlib.contextmanager
def _key_by_key() -> Iterator[None]:
    """The terminal gives every key at once; put back behind it."""
    import termios
    import tty

    sys.stdout.flush()
    before = termios.tcgetattr(sys.stdin)
    try:
        tty.setcbreak(sys.stdin, termios.TCSANOW)
        yield
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSANOW, before)
