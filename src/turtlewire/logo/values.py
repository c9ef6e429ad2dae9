"""Logo's values: words, numbers, lists and arrays; how they compare and how they print.

A word that spells a number is one, from the moment it is made: an ``int``, a ``float``, or, when it is not spelled as
Logo would print it (``007``), a ``SpelledNumber``. Other words are ``str``. Whole numbers are exact; a product or power
beyond 2**53 is a float, as in UCBLogo. Infinities are let through, as UCBLogo does; robots refuse them.

A list is a chain of cells, as in every Lisp: a cell is a Python list of two, the first member and the rest, and the
empty list is a Python list of none. So FIRST, BUTFIRST and FPUT take no longer for long lists.

Characters that stood between bars or after a backslash lose their meaning for the tokenizer; the reader says so by
moving them to code points of plane 16, and ``plain`` moves them back.
"""

from __future__ import annotations

import math

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from typing import Any

SPECIAL = " \t\n()[]{}+-*/=<>\"\\:;|~?'"
BARRED = 0x10FE00  # a special character that stood between bars
BACKSLASHED = 0x10FF00  # a special character that stood after a backslash
EXACT = 2**53  # integers beyond this are floats, as they are in UCBLogo
_PRINTED_WHOLE = 10**15

_TO_BARRED = {ord(c): BARRED + ord(c) for c in SPECIAL}
_TO_BACKSLASHED = {ord(c): BACKSLASHED + ord(c) for c in SPECIAL}
_TO_PLAIN = {mark + ord(c): c for c in SPECIAL for mark in (BARRED, BACKSLASHED)}
_WITHOUT_BACKSLASHES = {BACKSLASHED + ord(c): c for c in SPECIAL}
_TO_BAR = {ord(c): f"\\{c}" for c in "|\\"}  # what needs a backslash even between bars
_TO_ESCAPED = {
    ord(c): f"\\{c}" for c in " \t\n\f\v\r\0[]{}();|\\~"
}  # what a quoted word can have after a backslash only

TRUE = "true"
FALSE = "false"


# A cell of a list, [first, rest]; or [], the empty list.
List = list["Any"]
NIL: List = []  # the empty list; others are as empty


class SpelledNumber(float):
    """A number that is not spelled as Logo would print it, such as ``007`` or ``1e3``."""

    __slots__ = ("text",)
    text: str


class Array:
    """An array: members that can be set, and the index of the first of them."""

    __slots__ = ("items", "origin")

    def __init__(self, items: list[Value], origin: int = 1) -> None:
        self.items = items
        self.origin = origin


Number = int | float
Value = str | int | float | List | Array
VALUE_TYPES = frozenset((str, int, float, SpelledNumber, list, Array))


def make_list(members: Sequence[Value], rest: List = NIL) -> List:
    """A list of these members, and then those of another list."""
    made = rest
    for member in reversed(members):
        made = [member, made]
    return made


def members_of(cells: List) -> list[Value]:
    """The members of a list, in a Python list of their own."""
    found: list[Value] = []
    while cells:
        member, cells = cells
        found.append(member)
    return found


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
        number = narrowed(int(text) if len(body) < 20 else float(text))
        return number if math.isfinite(number) else None
    if body[0] not in "0123456789." or body.strip("0123456789.eE+-") or body == ".":
        return None
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def narrowed(number: Number) -> Number:
    """A product or power as Logo keeps it: beyond 2**53, where not every whole number is a float, as a float."""
    if type(number) is int and not -EXACT <= number <= EXACT:
        try:
            return float(number)
        except OverflowError:
            return math.inf if number > 0 else -math.inf
    return number


def format_number(number: Number) -> str:
    """A number as UCBLogo prints it: at most 15 significant digits."""
    if type(number) is int and -_PRINTED_WHOLE < number < _PRINTED_WHOLE:
        return str(number)
    return f"{narrowed(number):.15g}"


def word(text: str) -> Value:
    """The word with this text: a number when it spells one."""
    if text and text[0] in "0123456789.-":
        number = parse_number(text)
        if number is not None:
            if format_number(number) == text:
                return number
            spelled_number = SpelledNumber(number)
            spelled_number.text = text
            return spelled_number
    return text


def to_text(value: str | int | float) -> str:
    """The text of a word, marks included."""
    if type(value) is str:
        return value
    if type(value) is SpelledNumber:
        return value.text
    return format_number(value)  # type: ignore[arg-type]


def to_number(value: Value) -> Number | None:
    """The number that a value is, or ``None``."""
    if isinstance(value, int | float):
        return value
    return None


def to_words(value: Value) -> str:
    """A value as PRINT prints it: the outermost brackets of a list left out."""
    shown = show(value)
    return shown[1:-1] if isinstance(value, list) else shown


def spelled(text: str) -> str:
    """A word as errors show it: what a program would have to say for it, with bars or backslashes where needed."""
    seen = plain(text)
    return f"|{seen.translate(_TO_BAR)}|" if seen != text else text.translate(_TO_ESCAPED) or "||"


def show(
    value: Value,
    spell: Callable[[str], str] = plain,
    *,
    with_origins: bool = False,
    depth: int = -1,
    width: int = -1,
) -> str:
    """A value as SHOW prints it: brackets around lists, braces around arrays.

    Args:
        value: what to show.
        spell: how a word is written.
        with_origins: whether ``@0`` stands behind an array whose first index is 0.
        depth: how deep lists are shown, PRINTDEPTHLIMIT; -1 for any.
        width: how many members of each, PRINTWIDTHLIMIT; -1 for any.
    """
    if depth == 0:
        return "..."
    if isinstance(value, str | int | float):
        return spell(_cut(to_text(value), width))
    # Iterative: lists may be nested deeper than any stack.
    pieces: list[str] = []
    closers: list[str] = []
    pending: list[Iterator[Value]] = []
    shown: list[int] = []  # how many members of each
    within: set[int] = set()  # what is open: an array, or a list that was changed, may be its own member
    opened: list[Value] = []

    def open_one(each: List | Array) -> None:
        opened.append(each)
        within.add(id(each))
        shown.append(0)
        if isinstance(each, Array):
            pieces.append("{")
            closers.append("}" if each.origin == 1 or not with_origins else f"}}@{each.origin}")
            pending.append(iter(each.items))
        else:
            pieces.append("[")
            closers.append("]")
            pending.append(iter(_visible_members(each)))

    open_one(value)
    is_first = True
    while pending:
        for item in pending[-1]:
            if not is_first:
                pieces.append(" ")
            is_first = False
            if shown[-1] == width:
                pieces.append("...")
                pending[-1] = iter(())
                break
            shown[-1] += 1
            if item is _AROUND or len(pending) == depth:
                pieces.append("...")
            elif isinstance(item, str | int | float):
                pieces.append(spell(_cut(to_text(item), width)))
            elif id(item) in within and item != NIL:
                pieces.append("{...}" if isinstance(item, Array) else "[...]")
            else:
                is_first = True
                open_one(item)
                break
        else:
            pending.pop()
            shown.pop()
            within.discard(id(opened.pop()))
            is_first = False
            pieces.append(closers.pop())
    return "".join(pieces)


_AROUND = "..."  # stands for the rest of a list whose rest is itself; told from a word by identity


def _visible_members(cells: List) -> list[Value]:
    """The members of a list; of one whose rest leads back into it, each of them once, and ``_AROUND``."""
    found: list[Value] = []
    landmark, until = cells, 1
    while cells:
        found.append(cells[0])
        cells = cells[1]
        if cells is landmark and cells:
            return [*found, _AROUND]
        if len(found) == until:
            landmark, until = cells, 2 * until
    return found


def _cut(text: str, width: int) -> str:
    """A word as PRINTWIDTHLIMIT has it: never less than ten characters."""
    most = max(width, 10)
    return text if width < 0 or len(text) <= most else text[:most] + "..."


def show_in_error(value: Value) -> str:
    """A value as errors show it: like SHOW, but where a word begins and ends can be seen."""
    return show(value, spelled, with_origins=True)


def equal(a: Value, b: Value, *, ignore_case: bool = True) -> bool:
    """Whether two values are EQUALP: numbers by value, words without regard to case, lists by their members.

    Arrays are equal only to themselves.
    """
    pending = [(a, b)]
    while pending:
        a, b = pending.pop()
        while a is not b:
            if isinstance(a, list) and isinstance(b, list):
                if not (a and b):
                    if a or b:
                        return False
                    break
                (x, a), (y, b) = a, b
                if isinstance(x, list) and isinstance(y, list):
                    pending.append((x, y))
                elif not _equal_words(x, y, ignore_case=ignore_case):
                    return False
            elif _equal_words(a, b, ignore_case=ignore_case):
                break
            else:
                return False
    return True


def _equal_words(a: Value, b: Value, *, ignore_case: bool) -> bool:
    if isinstance(a, str) and isinstance(b, str):
        a, b = plain(a), plain(b)
        return a == b or (ignore_case and a.lower() == b.lower())
    if isinstance(a, int | float) and isinstance(b, int | float | str):
        return a == (parse_number(plain(b)) if isinstance(b, str) else b)
    if isinstance(a, str) and isinstance(b, int | float):
        return b == parse_number(plain(a))
    return a is b
