"""What READLIST and READWORD make of lines: a line goes on while a bracket or bar is open, or behind a ``~``."""

from __future__ import annotations

from turtlewire.logo.errors import LogoError
from turtlewire.logo.reader import Line, LineReader, Source
from turtlewire.logo.values import List, Value, word

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.logo.reader import Item

    Lines = Callable[[], str | None]


class _Opened:
    """What is open behind the lines so far."""

    def __init__(self) -> None:
        self._brackets = 0
        self._in_bars = False

    def goes_on(self, line: str) -> bool:
        """Whether another line is needed behind this one."""
        i, size = 0, len(line)
        while i < size:
            c = line[i]
            if c == "\\":
                if i + 1 == size:
                    return True
                i += 1
            elif c == "|":
                self._in_bars = not self._in_bars
            elif not self._in_bars:
                self._brackets += (c in "[{") - (c in "]}")
            i += 1
        return self._in_bars or self._brackets > 0 or (line.endswith("~") and not line.endswith("\\~"))


def read_list(text: str) -> List:
    """The list that a text spells, as READLIST and PARSE read it: one list, the newlines in it mere spaces.

    Raises:
        LogoError: whatever ``LineReader.read_line`` raises.
    """
    reader = LineReader(Source(text, ""), is_data=True)
    items: list[Item] = []
    try:
        while (line := reader.read_line()) is not None:
            items.extend(line.items)
    except LogoError as error:
        error.position = None  # the program that reads the list is to blame, not a line of it
        raise
    return Line(tuple(items)).value


def list_of_line(read_line: Lines) -> List | None:
    """The next line, or as many as belong together, as a list; ``None`` at the end.

    Raises:
        LogoError: a bracket, brace or bar that is closed and not open, or never closed.
    """
    lines: list[str] = []
    opened = _Opened()
    while (line := read_line()) is not None:
        lines.append(line)
        if not opened.goes_on(line):
            break
    return read_list("\n".join(lines)) if lines else None


def word_of_line(read_line: Lines) -> Value | None:
    """The next line as a word: backslashes have done their work, bars and ``~`` are kept; ``None`` at the end."""
    line = read_line()
    if line is None:
        return None
    pieces: list[str] = []
    in_bars = False
    while line is not None:
        i, size, goes_on = 0, len(line), False
        while i < size:
            c = line[i]
            if c == "\\":
                i += 1
                goes_on = i == size
                c = line[i : i + 1]
            elif c == "|":
                in_bars = not in_bars
            elif c == "~" and i + 1 == size:
                goes_on = True
            pieces.append(c)
            i += 1
        if not (goes_on or in_bars):
            break
        line = read_line()
        if line is not None:
            pieces.append("\n")
    return word("".join(pieces))
