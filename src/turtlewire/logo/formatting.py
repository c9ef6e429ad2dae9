"""Laying out programs: indentation by brackets and procedures, single spaces, spaces around infix operators.

Lines stay the lines that they are, and words, comments and blank lines stay as written. Spaces around an operator can
change what it means (``3 -2`` are two numbers), and within a list of data they do change it: so operators are set
apart only in instructions, and a layout is taken only if the program is read from it as before.
"""

from __future__ import annotations

import contextlib
import re
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.logo.definitions import define_from_title
from turtlewire.logo.errors import LogoError
from turtlewire.logo.instructions import inputs_of, run_lists, scratch
from turtlewire.logo.reader import Definition, Line, read, value_of
from turtlewire.logo.syntax import Parser
from turtlewire.logo.tokens import PRECEDENCE, Token, tokenize
from turtlewire.logo.values import show, to_text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from turtlewire.logo.procedures import Primitive, UserProcedure
    from turtlewire.logo.syntax import Node

INDENT = "  "
# A word: bars hold anything, a backslash its next character, and a line that ends in ~ may go on in the midst of it.
_PIECE = re.compile(
    r"""
    (?P<blank>[ \t\f\v\r\0]+)
    | (?P<newline>~?\n)
    | (?P<comment>(?:;|(?<![^\n])\#!)[^\n]*)
    | (?P<open>[\[{])
    | (?P<close>\]|\}(?:@-?\d{0,15})?)
    | (?P<word>(?:[^ \t\f\v\r\0\n\[\]{};|\\~]|\|(?:[^|\\]|\\.)*\||\\.|~(?!\n)
        |(?:;[^\n]*)?~\n(?=(?:(?:;[^\n]*)?~\n)*(?:[^ \t\f\v\r\0\n\[\]{};~]|~(?!\n))))+)
    """,
    re.VERBOSE | re.DOTALL,
)


class _Piece(NamedTuple):
    """A bracket, word or comment, and where it stood."""

    kind: str
    text: str
    offset: int


class _Marks:
    """Where, by their offsets in the text, operators want spaces and parentheses want none."""

    def __init__(self) -> None:
        self.apart: set[int] = set()
        self.closed_up: set[int] = set()


def formatted(text: str, name: str = "") -> str:
    """The program, laid out.

    Raises:
        LogoError: it cannot be read.
    """
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    wanted = _meaning(text, name)
    for marks in (_marks(text, name), _Marks()):
        layout = _Layout(text, marks).laid_out()
        if _reads_as(layout, wanted):
            return layout
    return text  # spelled so strangely that it is better left alone


def _reads_as(text: str, wanted: list[object]) -> bool:
    try:
        return _meaning(text, "") == wanted
    except LogoError:
        return False


# --- what a program means, and where its operators are ------------------------------------------------------------


def _known(program: list[Line | Definition]) -> dict[str, Primitive | UserProcedure]:
    """The primitives, and the procedures of the program with their numbers of inputs."""
    logo = scratch()
    for each in program:
        if isinstance(each, Definition):
            with contextlib.suppress(LogoError):  # that it is wrong is told when it is run
                define_from_title(logo, each)
    return logo.procedures


def _code(line: Line, known: dict[str, Primitive | UserProcedure]) -> tuple[list[Token], set[int]] | None:
    """The tokens of instructions, and which of the lists in them are instructions too; ``None``: they are none."""
    try:
        tokens = tokenize(line)
    except LogoError:
        return None
    lists: set[int] = set()
    pending: list[Node] = Parser(tokens, known, lambda _line: None).parse()
    for node in pending:
        lists |= {id(each) for each, _ in run_lists(node)}
        pending += inputs_of(node)
    return tokens, lists


def _meaning(text: str, name: str) -> list[object]:
    """The tokens of all instructions, and the members of all other lists."""
    program = read(text, name)
    known = _known(program)
    found: list[object] = []
    for each in program:
        if isinstance(each, Definition):
            found.append([_data(each.title), *(_tokens(line, known) for line in each.body)])
        else:
            found.append(_tokens(each, known))
    return found


def _tokens(line: Line, known: dict[str, Primitive | UserProcedure]) -> object:
    code = _code(line, known)
    if code is None:
        return _data(line)
    tokens, lists = code
    return [
        (
            token.kind,
            (_tokens(token.value, known) if id(token.value) in lists else _data(token.value))
            if isinstance(token.value, Line)
            else _data(token.value),
        )
        for token in tokens
    ]


def _data(item: object) -> str:
    """A value, spelled out with what a word has between bars or after backslashes."""
    value = value_of(item)  # type: ignore[arg-type]
    return to_text(value) if isinstance(value, str | int | float) else show(value, lambda word: word)


def _marks(text: str, name: str) -> _Marks:
    """Where the operators and parentheses of the program stand."""
    program = read(text, name)
    known = _known(program)
    marks = _Marks()
    pending: list[Line] = []
    for each in program:
        pending += each.body if isinstance(each, Definition) else [each]
    for line in pending:
        code = _code(line, known)
        if code is None:
            continue
        tokens, lists = code
        for token in tokens:
            if isinstance(token.value, Line) and id(token.value) in lists:
                pending.append(token.value)
            offset = token.place[1] if token.place is not None else 0
            # A word with bars or backslashes is shorter than its spelling: offsets within it are not to be relied on.
            if token.kind in ("(", ")", *PRECEDENCE) and text.startswith(token.kind, offset):
                if token.kind == "(":
                    marks.closed_up.add(offset + 1)
                elif token.kind == ")":
                    marks.closed_up.add(offset)
                else:
                    marks.apart |= {offset, offset + len(token.kind)}
    return marks


# --- layout -------------------------------------------------------------------------------------------------------


def _pieces(text: str) -> Iterator[_Piece]:
    offset = 0
    while offset < len(text):
        match = _PIECE.match(text, offset)
        if match is None:  # a single character that begins nothing: a backslash at the end
            yield _Piece("word", text[offset:], offset)
            return
        assert match.lastgroup is not None
        if match.lastgroup != "blank":
            yield _Piece(match.lastgroup, match[0], offset)
        offset = match.end()


class _Open(NamedTuple):
    """A bracket or parenthesis that is open, and how far the line that it stands in is indented."""

    bracket: str
    level: int


class _Layout:
    """Puts the pieces of a program together again, line by line."""

    def __init__(self, text: str, marks: _Marks) -> None:
        self._text = text
        self._marks = marks
        self._open: list[_Open] = []
        self._is_procedure = False
        self._goes_on = False  # the line before ended in ~
        self._lines: list[str] = []

    def laid_out(self) -> str:
        """The whole program."""
        line: list[_Piece] = []
        for piece in _pieces(self._text):
            if piece.kind == "newline":
                self._end_line(line, goes_on=piece.text[0] == "~")
                line = []
            else:
                line.append(piece)
        if line:
            self._end_line(line, goes_on=False)
        while self._lines and not self._lines[-1]:
            self._lines.pop()
        return "".join(f"{each}\n" for each in self._lines)

    def _end_line(self, line: list[_Piece], *, goes_on: bool) -> None:
        level = self._level(line)
        comment = line[-1] if line and line[-1].kind == "comment" else None
        if comment is not None and comment.text.startswith("#!"):
            level = 0
        laid_out = INDENT * level + self._joined(line)
        if comment is not None:
            # It stays below the comment in the line before, as long as there is room.
            room = self._column(comment) - len(laid_out) if len(line) > 1 else 0
            laid_out += " " * max(room, int(len(line) > 1)) + comment.text
        if goes_on:
            laid_out += " ~" if line else "~"
        elif comment is None and laid_out.endswith("~"):
            laid_out += " "  # a word like any other, as long as the line does not end there
        self._lines.append(laid_out if line or goes_on else "")
        self._goes_on = goes_on or (comment is not None and comment.text.endswith("~"))
        for piece in line:
            self._count(piece, level)

    def _column(self, piece: _Piece) -> int:
        begin = self._text.rfind("\n", 0, piece.offset) + 1
        return len(self._text[begin : piece.offset].expandtabs())

    def _level(self, line: list[_Piece]) -> int:
        """How far a line is indented; a procedure begins or ends with it."""
        base = int(self._is_procedure)
        first = line[0] if line else None
        if not self._open and not self._goes_on and first is not None and first.kind == "word":
            word = first.text.lower()
            if word in ("to", ".macro") and not self._is_procedure:
                self._is_procedure = True
                return 0
            if word == "end" and self._is_procedure and all(each.kind == "comment" for each in line[1:]):
                self._is_procedure = False
                return 0
        if not self._open:
            return base + int(self._goes_on)
        closed = 0
        for piece in line:
            if piece.kind == "close":
                closed += 1
            else:
                closed += len(piece.text) - len(piece.text.lstrip(")")) if piece.kind == "word" else 0
                break
        if closed:
            return self._open[-min(closed, len(self._open))].level
        return self._open[-1].level + 1

    def _count(self, piece: _Piece, level: int) -> None:
        """Keep account of what is open."""
        if piece.kind == "open":
            self._open.append(_Open(piece.text, level))
        elif piece.kind == "close" and self._open:
            self._open.pop()
        elif piece.kind == "word" and not any(each.bracket != "(" for each in self._open):
            # Within brackets parentheses are letters, as long as nobody runs them.
            for c in re.sub(r"\|(?:[^|\\]|\\.)*\||\\.", "", piece.text, flags=re.DOTALL):
                if c == "(":
                    self._open.append(_Open(c, level))
                elif c == ")" and self._open:
                    self._open.pop()

    def _joined(self, line: list[_Piece]) -> str:
        """The brackets and words of a line, with single spaces where there may be some."""
        joined = ""
        before: _Piece | None = None
        for piece in (part for each in line for part in self._apart(each)):
            if piece.kind == "comment":
                break
            is_tight = (
                before is None
                or before.kind == "open"
                or piece.kind == "close"
                or before.offset + len(before.text) in self._marks.closed_up
                or piece.offset in self._marks.closed_up
            )
            joined += piece.text if is_tight else f" {piece.text}"
            before = piece
        return joined

    def _apart(self, piece: _Piece) -> Iterator[_Piece]:
        """A word, cut before and after its operators."""
        if piece.kind != "word" or re.search(r"[|\\~;]", piece.text):
            yield piece
            return
        start = 0
        for i in range(1, len(piece.text) + 1):
            if i == len(piece.text) or piece.offset + i in self._marks.apart:
                yield _Piece("word", piece.text[start:i], piece.offset + start)
                start = i
