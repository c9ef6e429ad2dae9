"""Logo's values: words, numbers and lists; how they compare and how they print.

A word is a ``str``, or, when it spells a number the way Logo prints it, an ``int`` or ``float``; an odd spelling
(``007``) stays text and becomes a number when arithmetic asks for one. Numbers are finite, always.
Characters that stood between bars or after a backslash lose their meaning for the tokenizer; the reader says so by
moving them to code points of plane 16, and ``plain`` moves them back.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

SPECIAL = " \t\n()[]{}+-*/=<>\"\\:;|~?'"
BARRED = 0x10FE00  # a special character that stood between bars
BACKSLASHED = 0x10FF00  # a special character that stood after a backslash
EXACT = 2**53  # integers beyond this are floats, as they are in UCBLogo
_PRINTED_WHOLE = 10**15

_TO_BARRED = {ord(c): BARRED + ord(c) for c in SPECIAL}
_TO_BACKSLASHED = {ord(c): BACKSLASHED + ord(c) for c in SPECIAL}
_TO_PLAIN = {mark + ord(c): c for c in SPECIAL for mark in (BARRED, BACKSLASHED)}
_WITHOUT_BACKSLASHES = {BACKSLASHED + ord(c): c for c in SPECIAL}
_TO_ESCAPED = {
    ord(c): f"\\{c}" for c in " \t\n[]();|\\~"
}  # what a quoted word can have after a backslash only

TRUE = "true"
FALSE = "false"


class LogoList:
    """A list, immutable. One that was read from a program knows where each of its members stood.

    Attributes:
        items: the members.
        source: the program text that it stood in, or ``None``.
        offsets: for each member, its offset in the source.
        code: what the evaluator made of it when it ran it, or ``None``.
    """

    __slots__ = ("code", "items", "offsets", "source")

    def __init__(
        self, items: Iterable[Value] = (), source: Any = None, offsets: tuple[int, ...] = ()
    ) -> None:
        self.items: tuple[Value, ...] = tuple(items)
        self.source = source
        self.offsets = offsets
        self.code: Any = None

    def __len__(self) -> int:
        return len(self.items)

    def __repr__(self) -> str:
        return f"LogoList({show(self)})"


Number = int | float
Value = str | int | float | LogoList
VALUE_TYPES = frozenset((str, int, float, LogoList))


def barred(text: str) -> str:
    """The text with its special characters marked as if between bars."""
    return text.translate(_TO_BARRED)


def backslashed(text: str) -> str:
    """The text with its special characters marked as if after backslashes."""
    return text.translate(_TO_BACKSLASHED)


def plain(text: str) -> str:
    """The text without any marks: what people see."""
    return text if text.isascii() else text.translate(_TO_PLAIN)


def without_backslashes(text: str) -> str:
    """The text of a quoted word, in which backslashed characters become ordinary; barred ones stay special."""
    return text if text.isascii() else text.translate(_WITHOUT_BACKSLASHES)


def parse_number(text: str) -> Number | None:
    """The number that a word spells, or ``None``: ``12``, ``-3``, ``.5``, ``1e-7``, but not ``+3`` or ``inf``."""
    body = text[1:] if text[:1] == "-" else text
    if not body or not text.isascii():
        return None
    if body.isdigit():
        # int() refuses thousands of digits, and so large a number is a float in any case.
        return narrowed(int(text) if len(body) < 20 else float(text))
    if body[0] not in "0123456789." or body.strip("0123456789.eE+-") or body == ".":
        return None
    try:
        return narrowed(float(text))
    except ValueError:
        return None


def narrowed(number: Number) -> Number | None:
    """The number as Logo keeps it: a large integer as a float; ``None`` when it is not finite."""
    if type(number) is int:
        if -EXACT <= number <= EXACT:
            return number
        try:
            return float(number)
        except OverflowError:
            return None
    return number if math.isfinite(number) else None


def format_number(number: Number) -> str:
    """A number as UCBLogo prints it: at most 15 significant digits."""
    if type(number) is int and -_PRINTED_WHOLE < number < _PRINTED_WHOLE:
        return str(number)
    return f"{number:.15g}"


def word(text: str) -> Value:
    """The word with this text: a number when it spells one as Logo would print it."""
    if text and text[-1] in "0123456789":
        number = parse_number(text)
        if number is not None and format_number(number) == text:
            return number
    return text


def to_text(value: str | int | float) -> str:
    """The text of a word, marks included."""
    return value if type(value) is str else format_number(value)  # type: ignore[arg-type]


def to_number(value: Value) -> Number | None:
    """The number that a value is or spells, or ``None``."""
    kind = type(value)
    if kind is int or kind is float:
        return value  # type: ignore[return-value]
    return parse_number(value) if isinstance(value, str) else None


def to_words(value: Value) -> str:
    """A value as PRINT prints it: the outermost brackets left out."""
    if isinstance(value, LogoList):
        return show(value)[1:-1]
    return plain(to_text(value))


def spelled(text: str) -> str:
    """A word as errors show it: what a program would have to say for it, with bars or backslashes where needed."""
    seen = plain(text)
    return f"|{seen}|" if seen != text else text.translate(_TO_ESCAPED) or "||"


def show(value: Value, spell: Callable[[str], str] = plain) -> str:
    """A value as SHOW prints it: brackets around lists."""
    if not isinstance(value, LogoList):
        return spell(to_text(value))
    # Iterative: lists may be nested deeper than any stack.
    pieces = ["["]
    open_lists = [iter(value.items)]
    is_first = True
    while open_lists:
        for item in open_lists[-1]:
            if not is_first:
                pieces.append(" ")
            is_first = isinstance(item, LogoList)
            if isinstance(item, LogoList):
                pieces.append("[")
                open_lists.append(iter(item.items))
                break
            pieces.append(spell(to_text(item)))
        else:
            open_lists.pop()
            is_first = False
            pieces.append("]")
    return "".join(pieces)


def show_in_error(value: Value) -> str:
    """A value as errors show it: like SHOW, but where a word begins and ends can be seen."""
    return show(value, spelled)


def equal(a: Value, b: Value, *, ignore_case: bool = True) -> bool:
    """Whether two values are EQUALP: numbers by value, words without regard to case, lists by their members."""
    pending = [(a, b)]
    while pending:
        a, b = pending.pop()
        if a is b:
            continue
        if isinstance(a, LogoList) or isinstance(b, LogoList):
            if not (isinstance(a, LogoList) and isinstance(b, LogoList)) or len(a.items) != len(b.items):
                return False
            pending.extend(zip(a.items, b.items, strict=True))
        elif not _equal_words(a, b, ignore_case=ignore_case):
            return False
    return True


def _equal_words(a: str | int | float, b: str | int | float, *, ignore_case: bool) -> bool:
    if not (isinstance(a, str) and isinstance(b, str)):
        x, y = to_number(a), to_number(b)
        return x is not None and x == y
    a, b = plain(a), plain(b)
    if a == b or (ignore_case and a.lower() == b.lower()):
        return True
    x = parse_number(a)
    return x is not None and x == parse_number(b)
