"""Shorter ways for the commonest values; everything else, and everything that is wrong, is the primitive's."""

from __future__ import annotations

from turtlewire.logo.values import Array, Value, word

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.procedures import Result

    # A primitive's function; it takes the interpreter, and then its inputs.
    Function = Callable[..., Result]

_DIGITS = {str(digit): digit for digit in range(10)}
_BEGIN_NUMBERS = frozenset("0123456789.-")


def first(primitive: Function) -> Function:
    """FIRST of a word."""

    def fast(logo: Interpreter, value: Value) -> Result:
        if type(value) is str and value:
            letter = value[0]
            return _DIGITS.get(letter, letter)
        return primitive(logo, value)

    return fast


def last(primitive: Function) -> Function:
    """LAST of a word."""

    def fast(logo: Interpreter, value: Value) -> Result:
        if type(value) is str and value:
            letter = value[-1]
            return _DIGITS.get(letter, letter)
        return primitive(logo, value)

    return fast


def butfirst(primitive: Function) -> Function:
    """BUTFIRST of a word."""

    def fast(logo: Interpreter, value: Value) -> Result:
        if type(value) is str and value:
            rest = value[1:]
            return word(rest) if rest and rest[0] in _BEGIN_NUMBERS else rest
        return primitive(logo, value)

    return fast


def butlast(primitive: Function) -> Function:
    """BUTLAST of a word."""

    def fast(logo: Interpreter, value: Value) -> Result:
        if type(value) is str and value:
            rest = value[:-1]
            return word(rest) if rest and rest[0] in _BEGIN_NUMBERS else rest
        return primitive(logo, value)

    return fast


def join(primitive: Function) -> Function:
    """WORD of two words."""

    def fast(logo: Interpreter, inputs: list[Value]) -> Result:
        if len(inputs) == 2:
            a, b = inputs
            if type(b) is int:
                b = str(b) if -(10**15) < b < 10**15 else ""
            if type(a) is str and type(b) is str and a and b:
                return word(a + b) if a[0] in _BEGIN_NUMBERS else a + b
        return primitive(logo, inputs)

    return fast


def item(primitive: Function) -> Function:
    """ITEM of an array."""

    def fast(logo: Interpreter, index: Value, value: Value) -> Result:
        if type(value) is Array and type(index) is int:
            place = index - value.origin
            if 0 <= place < len(value.items):
                return value.items[place]
        return primitive(logo, index, value)

    return fast


def char(primitive: Function) -> Function:
    """CHAR of a letter's number."""

    def fast(logo: Interpreter, value: Value) -> Result:
        if type(value) is int and 58 <= value < 0xD800:
            return chr(value)
        return primitive(logo, value)

    return fast


def ascii_of(primitive: Function) -> Function:
    """ASCII of a letter."""

    def fast(logo: Interpreter, value: Value) -> Result:
        if type(value) is str and len(value) == 1 and value.isascii():
            return ord(value)
        return primitive(logo, value)

    return fast


FAST: dict[str, Callable[[Function], Function]] = {
    "first": first, "last": last, "butfirst": butfirst, "butlast": butlast, "word": join, "item": item, "char": char,
    "ascii": ascii_of,
}  # fmt: skip
