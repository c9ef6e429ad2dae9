"""The words of an instruction list to tokens: operators, parentheses, names, values.

A minus is unary after an infix operator or ``(``, whatever follows it; anywhere
else, when it begins a word of more than itself: ``3 - -2``, ``3 - - 2``, ``(- :a)`` and ``print -3`` negate, ``3 -2``
are two values, and the minus alone in ``print - 3`` is infix.
"""

from __future__ import annotations

from turtlewire.logo.errors import LogoError, unexpected_parenthesis
from turtlewire.logo.values import SpelledNumber, parse_number, without_backslashes, word
from turtlewire.named_tuple import NamedTuple

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.reader import Item, Line, Source
    from turtlewire.logo.values import Value

Place = tuple["Source", int] | None

PRECEDENCE = {"=": 1, "<>": 1, "<": 1, ">": 1, "<=": 1, ">=": 1, "+": 2, "-": 2, "*": 3, "/": 3}
_DELIMITERS = frozenset("()+-*/=<>")


class Token(NamedTuple):
    """What the parser reads: ``kind`` is one of the constants below, or an infix operator or parenthesis itself."""

    kind: str
    value: Item
    place: Place


VALUE = "value"
DOTS = "dots"
NAME = "name"
NEGATE = "negate"


def tokenize(instructions: Line) -> list[Token]:
    """Split the words of a list into tokens.

    Raises:
        LogoError: a ``)`` without ``(``.
    """
    tokens: list[Token] = []
    source, offsets = instructions.source, instructions.offsets
    for index, item in enumerate(instructions.items):
        offset = offsets[index] if offsets else 0
        if isinstance(item, str):
            _split(item, tokens, source, offset)
        elif isinstance(item, SpelledNumber):  # an instruction wants the number, not how it is spelled
            place = (source, offset) if source is not None else None
            tokens.append(_name_or_number(item.text, place))
        else:
            tokens.append(Token(VALUE, item, (source, offset) if source is not None else None))
    _check_parentheses(tokens)
    return tokens


def _check_parentheses(tokens: list[Token]) -> None:
    opened: list[Token] = []
    for token in tokens:
        if token.kind == "(":
            opened.append(token)
        elif token.kind == ")":
            if not opened:
                raise placed(unexpected_parenthesis(), token.place)
            opened.pop()
    if opened:
        raise placed(LogoError(10, "too many ('s", hint="This ( has no )."), opened[-1].place)


def placed(error: LogoError, place: Place) -> LogoError:
    """The error with this place, unless it has one."""
    if error.position is None and place is not None:
        error.position = place[0].position(place[1])
    return error


def _split(text: str, tokens: list[Token], source: Source | None, offset: int) -> None:
    """Split one word, whose first character stands at ``offset``, into tokens."""
    i, size = 0, len(text)
    if not text:
        tokens.append(Token(NAME, text, (source, offset) if source is not None else None))
    while i < size:
        place = (source, offset + i) if source is not None else None
        c = text[i]
        if c == '"':
            end = _end_of(text, i, "()")
            tokens.append(Token(VALUE, _quoted(text[i + 1 : end]), place))
            i = end
        elif c in _DELIMITERS:
            operator = text[i : i + 2] if text[i : i + 2] in PRECEDENCE else c
            end = i + len(operator)
            after_operator = bool(tokens) and (
                tokens[-1].kind in PRECEDENCE or tokens[-1].kind in ("(", NEGATE)
            )
            if c == "-" and (after_operator or (i == 0 and end < size)):
                end = _negative(text, i, tokens, place)
            else:
                tokens.append(Token(operator, operator, place))
            i = end
        else:
            end = _end_of_name(text, i)
            piece = text[i:end]
            if c == ":":
                tokens.append(Token(DOTS, without_backslashes(piece[1:]), place))
            elif c == "?" and piece[1:].isdigit():
                tokens += [Token("(", "(", place), Token(NAME, "?", place)]
                tokens += [Token(VALUE, int(piece[1:]), place), Token(")", ")", place)]
            else:
                tokens.append(_name_or_number(piece, place))
            i = end


def _negative(text: str, start: int, tokens: list[Token], place: Place) -> int:
    """A unary minus: a negative number, or the operator; outputs where it ends."""
    end = _end_of_name(text, start + 1)
    if end > start + 1:
        token = _name_or_number(text[start:end], place)
        if token.kind == VALUE:
            tokens.append(token)
            return end
    tokens.append(Token(NEGATE, "-", place))
    return start + 1


def _end_of(text: str, start: int, delimiters: str) -> int:
    end = start
    while end < len(text) and text[end] not in delimiters:
        end += 1
    return end


def _end_of_name(text: str, start: int) -> int:
    """The end of a word that stops at operators; the sign of an exponent (``1e-7``) does not count as one."""
    i = start
    while i < len(text):
        if text[i] in _DELIMITERS:
            head = text[start:i]
            digits = head[:-1].replace(".", "", 1)
            is_exponent = (
                text[i] in "+-" and head[-1:] in "eE" and digits.isdigit() and text[i + 1 : i + 2].isdigit()
            )
            if not is_exponent:
                break
        i += 1
    return i


def _quoted(text: str) -> Value:
    return word(without_backslashes(text))


def _name_or_number(text: str, place: Place) -> Token:
    number = parse_number(text)
    return Token(NAME, text, place) if number is None else Token(VALUE, number, place)
