"""The keyboard: where READLIST and READCHAR read from when no file is set."""

from __future__ import annotations

import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any


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

    def is_attended(self) -> bool:
        """Whether somebody may be there who types."""
        return True

    def rest(self) -> None:
        """The program has ended, and what was set for it is put back."""


class StandardInput(Keyboard):
    """Standard input. At a terminal, READCHAR gets a key as soon as it is pressed, without showing it.

    From the first READCHAR or KEYP on, the terminal gives key by key, until a line is read or the program ends.
    """

    def __init__(self) -> None:
        super().__init__(_read_standard_input)
        self._lines_mode: list[Any] | None = None  # how the terminal was before it gave key by key

    def read_line(self) -> str:
        """The next line, or what is left of one, with its newline; ``""`` at the end."""
        self.rest()
        return super().read_line()

    def read_character(self) -> str:
        """The next character; ``""`` at the end."""
        if self._typed or not _is_terminal():
            return super().read_character()
        self._give_keys()
        # Not by sys.stdin, which would take more than one key and hide the others from has_key.
        terminal = sys.stdin.fileno()
        data = os.read(terminal, 1)
        more = 0 if data < b"\xc0" else 1 if data < b"\xe0" else 2 if data < b"\xf0" else 3
        for _ in range(more):
            data += os.read(terminal, 1)
        return data.decode("utf-8", "replace")

    def has_key(self) -> bool:
        """Whether a key was pressed."""
        if self._typed or not _is_terminal():
            return bool(self._typed)
        import select

        self._give_keys()
        return bool(select.select([sys.stdin], [], [], 0)[0])

    def is_attended(self) -> bool:
        """Whether it is a terminal."""
        return _is_terminal()

    def _give_keys(self) -> None:
        sys.stdout.flush()
        if self._lines_mode is None:
            import termios
            import tty

            self._lines_mode = termios.tcgetattr(sys.stdin)
            tty.setcbreak(sys.stdin, termios.TCSANOW)

    def rest(self) -> None:
        """The terminal is as it was before."""
        mode, self._lines_mode = self._lines_mode, None
        if mode is not None:
            import termios

            try:
                termios.tcsetattr(sys.stdin, termios.TCSANOW, mode)
            except (termios.error, OSError, ValueError):
                return  # the terminal is gone


def _read_standard_input() -> str:
    if sys.stdin is None:
        return ""
    if sys.stdout is not None:
        sys.stdout.flush()  # a question that TYPE asked
    return sys.stdin.readline()


def _is_terminal() -> bool:
    return sys.stdin is not None and sys.stdin.isatty()
