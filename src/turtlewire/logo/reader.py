"""The reader: program text to lines of words and lists, each with its exact place.

This is the outer half of Logo's tokenization: words end at spaces, brackets and braces only. What is inside a word
(infix operators, parentheses, quotes) matters only when it is run: see ``syntax``.
"""

from __future__ import annotations

from turtlewire.logo.errors import LogoError, Position
from turtlewire.logo.values import Array, List, Value, backslashed, barred, make_list, members_of, plain, word
from turtlewire.named_tuple import NamedTuple

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_SPACES = " \t\f\v\r\0"
_ENDS_A_WORD = frozenset(_SPACES + "\n[]{};|\\~()")
_CLOSERS = {"[": "]", "{": "}"}
_LONGEST_ORIGIN = 15  # digits


class Source:
    """The text of one file, and where its lines start."""

    def __init__(self, text: str, name: str) -> None:
        self.text = text
        self.name = name

    def position(self, offset: int) -> Position:
        """The line and column of an offset."""
        start = self.text.rfind("\n", 0, offset) + 1
        end = self.text.find("\n", offset)
        line_text = self.text[start : end if end >= 0 else len(self.text)]
        return Position(self.name, self.text.count("\n", 0, start) + 1, offset - start + 1, line_text)

    def end_of(self, line: Line) -> int:
        """The offset at which a program's line ends at the latest."""
        last = max(
            [*line.offsets, *[offset for _, each in line.lists() for offset in each.offsets]], default=0
        )
        end = self.text.find("\n", last)
        return end if end >= 0 else len(self.text)


class Line:
    """A line of a program, or a list in it: words and lists, and where each of them stood.

    Attributes:
        items: words, and lists as ``Line``.
        source: the text that it stood in; ``None`` for what a program has put together.
        offsets: for each item, its offset in the source.
        code: what the evaluator made of it, or ``None``.
    """

    __slots__ = ("_value", "code", "items", "offsets", "source")

    def __init__(
        self, items: tuple[Item, ...], source: Source | None = None, offsets: tuple[int, ...] = ()
    ) -> None:
        self.items = items
        self.source = source
        self.offsets = offsets
        self.code: Any = None
        self._value: List | None = None

    def is_current(self) -> bool:
        """Whether its list is still what was read: the program has not changed it."""
        cells = self.value
        for item in self.items:
            if not cells or cells[0] is not value_of(item):
                return False
            cells = cells[1]
        return not cells

    @property
    def value(self) -> List:
        """The list that it is to the program; always the same one."""
        if self._value is None:
            # Not recursive: lists may be nested deeper than any stack.
            pending = [self]
            for each in pending:
                pending += [item for item in each.items if isinstance(item, Line) and item._value is None]
            for each in reversed(pending):
                each._value = make_list([value_of(item) for item in each.items])
        assert self._value is not None
        return self._value

    def lists(self) -> list[tuple[int, Line]]:
        """The lists within it, at any depth, and where each stood; none of one that stood nowhere."""
        found: list[tuple[int, Line]] = []
        pending = [self]
        for each in pending:
            for offset, item in zip(each.offsets, each.items, strict=False):
                if isinstance(item, Line):
                    found.append((offset, item))
                    pending.append(item)
        return found

    def position(self, index: int) -> Position | None:
        """Where an item stood, or the line itself if it has fewer."""
        if self.source is None or not self.offsets:
            return None
        return self.source.position(self.offsets[min(index, len(self.offsets) - 1)])

    def rest(self, start: int = 1) -> Line:
        """The line without its first items."""
        return Line(self.items[start:], self.source, self.offsets[start:])


Item = Value | Line


def value_of(item: Item) -> Value:
    """An item as a value."""
    return item.value if isinstance(item, Line) else item


def line_of(cells: List) -> Line:
    """A list that a program has put together, as a line; lists within it stay what they are."""
    return Line(tuple(members_of(cells)))


class Definition(NamedTuple):
    """A procedure as it stands in the source: TO, title line, body lines, END; ``text`` is all of it, line by line."""

    title: Line
    body: tuple[Line, ...]
    text: tuple[str, ...]


class _Open(NamedTuple):
    """A list or array that has begun and not yet ended."""

    bracket: str
    offset: int
    items: list[Item]
    offsets: list[int]


class LineReader:
    """Reads one line after the other; a line goes on while brackets, bars or parentheses are open in it.

    Args:
        source: what to read.
        is_data: it is no program: a semicolon begins no comment, and parentheses are letters.
    """

    def __init__(self, source: Source, *, is_data: bool = False) -> None:
        self.source = source
        self.offset = 0
        self._is_data = is_data
        self._procedure = ""

    def read_line(self, procedure: str = "") -> Line | None:
        """The next line, ``None`` at the end of the text.

        Args:
            procedure: the name of the procedure whose body is being read: its END may not come within brackets.

        Raises:
            LogoError: brackets, parentheses or bars that never end, or an unexpected ``]`` or ``}``.
        """
        text = self.source.text
        if self.offset >= len(text):
            return None
        self._procedure = procedure
        open_lists = [_Open("", self.offset, [], [])]
        open_parens: list[int] = []
        i, size = self.offset, len(text)
        while i < size:
            c = text[i]
            if c == "\n":
                i += 1
                if len(open_lists) == 1 and not open_parens:
                    break
                self._refuse_end(i, open_lists[-1].offset if len(open_lists) > 1 else open_parens[-1])
            elif c in _SPACES:
                i += 1
            elif c in "[{":
                open_lists.append(_Open(c, i, [], []))
                i += 1
            elif c in "]}":
                i = self._close(i, open_lists)
            elif self._begins_comment(i):
                i = self._skip_comment(i)
            elif c == "~" and (goes_on := _behind_tilde(text, i)):
                i = goes_on
            else:
                outside = len(open_lists) == 1 and not self._is_data
                end, value = self._read_word(i, open_parens if outside else None)
                open_lists[-1].items.append(value)
                open_lists[-1].offsets.append(i)
                i = end
        self.offset = i
        if len(open_lists) > 1:
            bracket, began = open_lists[-1].bracket, open_lists[-1].offset
            closer = _CLOSERS[bracket]
            raise self._error(
                10,
                f"'{closer}' not found",
                began,
                f"This {bracket} has no {closer} up to the end of the program.",
            )
        if open_parens:
            raise self._error(
                10, "too many ('s", open_parens[-1], "This ( has no ) up to the end of the program."
            )
        line = open_lists[0]
        return Line(tuple(line.items), self.source, tuple(line.offsets))

    def _close(self, i: int, open_lists: list[_Open]) -> int:
        """End the list or array that is open, at its bracket; the offset behind it, and behind an array's origin."""
        text = self.source.text
        done = open_lists[-1]
        if text[i] != _CLOSERS.get(done.bracket):
            number, opener = (26, "[") if text[i] == "]" else (27, "{")
            hint = f"This {text[i]} has no {opener} before it."
            if done.bracket:
                hint += f" The {done.bracket} that is open wants a {_CLOSERS[done.bracket]}."
            raise self._error(number, f"unexpected '{text[i]}'", i, hint)
        open_lists.pop()
        item: Item
        if text[i] == "]":
            item = Line(tuple(done.items), self.source, tuple(done.offsets))
            end = i + 1
        else:
            origin, end = _origin(text, i + 1)
            item = Array([value_of(each) for each in done.items], origin)
        open_lists[-1].items.append(item)
        open_lists[-1].offsets.append(done.offset)
        return end

    def _begins_comment(self, i: int) -> bool:
        text = self.source.text
        if self._is_data:
            return False
        return text[i] == ";" or (text.startswith("#!", i) and (i == 0 or text[i - 1] == "\n"))

    def _read_word(self, start: int, open_parens: list[int] | None) -> tuple[int, Value]:
        """A word, and where it ends; parentheses are counted outside brackets only, so that lines can go on."""
        text, size = self.source.text, len(self.source.text)
        pieces: list[str] = []
        i = begin = start
        while i < size:
            c = text[i]
            if c not in _ENDS_A_WORD:
                i += 1
                continue
            if c in "()":
                if open_parens is not None:
                    if c == "(":
                        open_parens.append(i)
                    elif open_parens:
                        open_parens.pop()
                i += 1
                continue
            goes_on = _behind_tilde(text, i) if c == "~" else 0
            if c == "~" and not goes_on:
                i += 1
                continue
            pieces.append(text[begin:i])
            if c == "|":
                i = self._read_bars(i, pieces)
            elif c == "\\":
                pieces.append(backslashed(text[i + 1 : i + 2]))
                i += 2
            elif goes_on:
                i = goes_on
            elif c == ";" and self._is_data:
                begin = i
                i += 1
                continue
            elif c == ";":
                i = self._skip_comment(i)
                if not (text.startswith("~\n", i - 2) and i < size):
                    begin = i
                    break
            else:
                begin = i
                break
            begin = i
        pieces.append(text[begin:i])
        joined = "".join(pieces)
        return i, word(joined)

    def _read_bars(self, start: int, pieces: list[str]) -> int:
        text, size = self.source.text, len(self.source.text)
        i = start + 1
        while i < size:
            c = text[i]
            if c == "|":
                return i + 1
            if c == "\\" and i + 1 < size:
                i += 1
                c = text[i]
            pieces.append(barred(c))
            i += 1
        raise self._error(10, "'|' not found", start, "This | has no partner up to the end of the program.")

    def _skip_comment(self, start: int) -> int:
        """The offset of the newline that ends a comment, or behind it when the comment ends in ``~``."""
        text = self.source.text
        end = text.find("\n", start)
        if end < 0:
            return len(text)
        return end + 1 if text[end - 1] == "~" else end

    def _refuse_end(self, line_start: int, opened: int) -> None:
        """Within a procedure, a line with nothing but END ends it: something before was left open."""
        if not self._procedure:
            return
        text = self.source.text
        line_end = text.find("\n", line_start)
        line = text[line_start : line_end if line_end >= 0 else len(text)]
        if line.strip().lower() == "end":
            raise self._error(
                33,
                f"END inside multi-line instruction in {self._procedure}",
                opened,
                f"This {text[opened]} is still open when END comes.",
            )

    def _error(self, number: int, text: str, offset: int, hint: str = "") -> LogoError:
        return LogoError(number, text, self.source.position(offset), hint)


def read(text: str, name: str = "") -> list[Line | Definition]:
    """A whole program: its top-level lines and its procedure definitions, in order.

    Raises:
        LogoError: whatever ``LineReader.read_line`` raises; a TO without END; a TO within a procedure.
    """
    source = Source(text.replace("\r\n", "\n").replace("\r", "\n"), name)
    reader = LineReader(source)
    program: list[Line | Definition] = []
    while (line := reader.read_line()) is not None:
        if not line.items:
            continue
        if _starts_with(line, "to", ".macro"):
            program.append(_read_definition(reader, line))
        else:
            program.append(line)
    return program


def _behind_tilde(text: str, i: int) -> int:
    """The beginning of the next line, if a ``~`` is the last in its own but for spaces; otherwise 0."""
    end = i + 1
    while text.startswith((" ", "\t"), end):
        end += 1
    return end + 1 if text.startswith("\n", end) else 0


def _origin(text: str, i: int) -> tuple[int, int]:
    """The origin of an array, which may stand behind it as ``@0``, and where that ends; else 1."""
    if not text.startswith("@", i):
        return 1, i
    first = i + 1 + text.startswith("-", i + 1)
    end = first
    while end - first < _LONGEST_ORIGIN and "0" <= text[end : end + 1] <= "9":
        end += 1
    return (int(text[i + 1 : end]), end) if end > first else (1, i + 1)


def _starts_with(line: Line, *names: str) -> bool:
    first = line.items[0] if line.items else None
    return isinstance(first, str) and first.lower() in names


def _read_definition(reader: LineReader, title: Line) -> Definition:
    name = title.items[1] if len(title.items) > 1 else "to"
    shown = plain(name) if isinstance(name, str) else "to"
    body: list[Line] = []
    source = reader.source.text
    text = [source[title.offsets[0] : reader.offset].rstrip("\n")]
    start = reader.offset
    while (line := reader.read_line(shown)) is not None:
        text.append(source[start : reader.offset].removesuffix("\n"))
        start = reader.offset
        if _starts_with(line, "end") and len(line.items) == 1:
            return Definition(title, tuple(body), tuple(text))
        if _starts_with(line, "to", ".macro"):
            began = title.position(0)
            raise LogoError(
                23,
                "can't use TO inside a procedure",
                line.position(0),
                f"The procedure {shown}, begun in line {began.line if began else 0}, has no END before this.",
            )
        if line.items:
            body.append(line)
    raise LogoError(
        33,
        f"END not found for {shown}",
        title.position(0),
        "This procedure has no END up to the end of the program. END stands in a line of its own.",
    )
