"""Shorter ways for the commonest values; everything else, and everything that is wrong, is the primitive's."""

from __future__ import annotations

import sys

from turtlewire.errors import LimitReachedError
from turtlewire.logo.compiler.runtime import BEGIN_NUMBERS, LETTERS, WORDS
from turtlewire.logo.events import limit_reached
from turtlewire.logo.primitives.predicates import ignores_case
from turtlewire.logo.values import EXACT, NIL, Array, Value, equal, word

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.procedures import Result

    # A primitive's function; it takes the interpreter, and then its inputs.
    Function = Callable[..., Result]

_FAR = 10**15  # up to here a whole number is one that a float can be


def first(primitive: Function) -> Function:
    """FIRST of a word."""

    def fast(logo: Interpreter, value: Value) -> Result:
        if type(value) is str and value:
            letter = value[0]
            return LETTERS[letter]
        return primitive(logo, value)

    return fast


def last(primitive: Function) -> Function:
    """LAST of a word."""

    def fast(logo: Interpreter, value: Value) -> Result:
        if type(value) is str and value:
            letter = value[-1]
            return LETTERS[letter]
        return primitive(logo, value)

    return fast


def butfirst(primitive: Function) -> Function:
    """BUTFIRST of a word."""

    def fast(logo: Interpreter, value: Value) -> Result:
        if type(value) is str and value:
            rest = value[1:]
            return word(rest) if rest and rest[0] in BEGIN_NUMBERS else rest
        return primitive(logo, value)

    return fast


def butlast(primitive: Function) -> Function:
    """BUTLAST of a word."""

    def fast(logo: Interpreter, value: Value) -> Result:
        if type(value) is str and value:
            rest = value[:-1]
            return word(rest) if rest and rest[0] in BEGIN_NUMBERS else rest
        return primitive(logo, value)

    return fast


def item(primitive: Function) -> Function:
    """ITEM."""

    def fast(logo: Interpreter, index: Value, value: Value) -> Result:
        if type(index) is int and index > 0:
            if type(value) is list:
                cells = value
                for _ in range(index - 1):
                    if not cells:
                        break
                    cells = cells[1]
                if cells:
                    return cells[0]  # type: ignore[no-any-return]
            elif type(value) is Array:
                place = index - value.origin
                if 0 <= place < len(value.items):
                    return value.items[place]
            elif type(value) is str and index <= len(value):
                return LETTERS[value[index - 1]]
        return primitive(logo, index, value)

    return fast


def mditem(primitive: Function) -> Function:
    """MDITEM of arrays in arrays."""

    def fast(logo: Interpreter, indexes: Any, value: Value) -> Result:
        found = _inner(indexes, value) if type(indexes) is list else None
        return primitive(logo, indexes, value) if found is None else found

    return fast


def mdsetitem(primitive: Function) -> Function:
    """MDSETITEM in arrays in arrays, of what is no array or list."""

    def fast(logo: Interpreter, indexes: Any, array: Value, value: Value) -> Result:
        if type(value) in WORDS and type(indexes) is list and type(array) is Array:
            cells: Any = indexes
            inner = array
            while cells:
                index, cells = cells
                place = index - inner.origin if type(index) is int else -1
                if not 0 <= place < len(inner.items):
                    break
                if not cells:
                    inner.items[place] = value
                    return None
                found = inner.items[place]
                if type(found) is not Array:
                    break
                inner = found
        return primitive(logo, indexes, array, value)

    return fast


def _inner(indexes: Any, value: Value) -> Value | None:
    """The member of arrays in arrays that indexes lead to; ``None``: it is not as easy as that."""
    while indexes:
        index, indexes = indexes
        if type(value) is not Array or type(index) is not int:
            return None
        place = index - value.origin
        if not 0 <= place < len(value.items):
            return None
        value = value.items[place]
    return value


def count(primitive: Function) -> Function:
    """COUNT of a list."""

    def fast(logo: Interpreter, value: Any) -> Result:
        if type(value) is list:
            found = 0
            while value:
                value = value[1]
                found += 1
            return found
        return primitive(logo, value)

    return fast


def lput(primitive: Function) -> Function:
    """LPUT to a list."""

    def fast(logo: Interpreter, thing: Value, onto: Any) -> Result:
        if type(onto) is list:
            before: Any = [thing, NIL]
            end = before
            while onto:
                member, onto = onto
                end[1] = end = [member, NIL]
            end[1] = [thing, NIL]
            return before[1]  # type: ignore[no-any-return]
        return primitive(logo, thing, onto)

    return fast


def memberp(primitive: Function) -> Function:
    """MEMBERP of a whole number in a list."""

    def fast(logo: Interpreter, thing: Value, value: Any) -> Result:
        if type(value) is list and type(thing) is int:
            while value:
                member, value = value
                if member == thing if type(member) is int else equal(member, thing):
                    return "true"
            return "false"
        return primitive(logo, thing, value)

    return fast


def substringp(primitive: Function) -> Function:
    """SUBSTRINGP in a word that is asked again and again: in lower case, it is kept."""
    whole_before, lowered = "", ""

    def fast(logo: Interpreter, part: Value, whole: Value) -> Result:
        nonlocal whole_before, lowered
        if type(whole) is str and type(part) is str and part.isascii() and whole.isascii():
            if part in whole:
                return "true"
            if ignores_case(logo):
                if whole is not whole_before:
                    whole_before, lowered = whole, whole.lower()
                return "true" if part.lower() in lowered else "false"
        return primitive(logo, part, whole)

    return fast


def quotient(primitive: Function) -> Function:
    """A quotient of whole numbers."""

    def fast(logo: Interpreter, a: Value, b: Value | None = None) -> Result:
        if type(a) is int and type(b) is int and b and -EXACT <= a <= EXACT:
            result = a / b
            return int(result) if result.is_integer() else result
        return primitive(logo, a, b)

    return fast


def whole(primitive: Function) -> Function:
    """INT."""

    def fast(logo: Interpreter, value: Any) -> Result:
        kind = type(value)
        if (kind is int or kind is float) and -EXACT <= value <= EXACT:
            return int(value)
        return primitive(logo, value)

    return fast


def gprop(primitive: Function) -> Function:
    """GPROP of names in lower case."""

    def fast(logo: Interpreter, owner: Value, name: Value) -> Result:
        if type(owner) is str and type(name) is str and name.islower():
            properties = logo.property_lists.get(owner)
            if properties is not None:
                found = properties.get(name)
                if found is not None:
                    return found[1]
        return primitive(logo, owner, name)

    return fast


def pprop(primitive: Function) -> Function:
    """PPROP of a property that there is, by names in lower case."""

    def fast(logo: Interpreter, owner: Value, name: Value, value: Value) -> Result:
        if type(owner) is str and type(name) is str and name.islower():
            properties = logo.property_lists.get(owner)
            if properties is not None:
                known = properties.get(name)
                if known is not None and not logo.marks.traced.property_lists:
                    properties[name] = known[0], value
                    return None
        return primitive(logo, owner, name, value)

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


def forward(primitive: Function) -> Function:
    """FORWARD by a number of steps that no turtle can leave the numbers with."""

    def fast(logo: Interpreter, steps: Any) -> Result:
        kind = type(steps)
        try:
            if (kind is float and -1e200 < steps < 1e200) or (kind is int and -_FAR < steps < _FAR):
                logo.turtle.forward(steps * logo.step_mm)
                return None
            return primitive(logo, steps)
        except LimitReachedError as limit:
            return limit_reached(logo, limit, sys._getframe(1))

    return fast


def right(primitive: Function) -> Function:
    """RIGHT by an ordinary angle."""

    def fast(logo: Interpreter, angle: Any) -> Result:
        kind = type(angle)
        try:
            if kind is float and -1e200 < angle < 1e200:
                logo.turtle.right(angle)
                return None
            if kind is int and -_FAR < angle < _FAR:
                logo.turtle.right(float(angle))
                return None
            return primitive(logo, angle)
        except LimitReachedError as limit:
            return limit_reached(logo, limit, sys._getframe(1))

    return fast


def back(primitive: Function) -> Function:
    """BACK, as FORWARD."""

    def fast(logo: Interpreter, steps: Any) -> Result:
        kind = type(steps)
        try:
            if (kind is float and -1e200 < steps < 1e200) or (kind is int and -_FAR < steps < _FAR):
                logo.turtle.back(steps * logo.step_mm)
                return None
            return primitive(logo, steps)
        except LimitReachedError as limit:
            return limit_reached(logo, limit, sys._getframe(1))

    return fast


def left(primitive: Function) -> Function:
    """LEFT, as RIGHT."""

    def fast(logo: Interpreter, angle: Any) -> Result:
        kind = type(angle)
        try:
            if kind is float and -1e200 < angle < 1e200:
                logo.turtle.left(angle)
                return None
            if kind is int and -_FAR < angle < _FAR:
                logo.turtle.left(float(angle))
                return None
            return primitive(logo, angle)
        except LimitReachedError as limit:
            return limit_reached(logo, limit, sys._getframe(1))

    return fast


# Commands that move the robot; each heeds ONLIMIT.
MOVES: dict[str, Callable[[Function], Function]] = {
    "forward": forward,
    "back": back,
    "right": right,
    "left": left,
}
FAST: dict[str, Callable[[Function], Function]] = {
    "first": first, "last": last, "butfirst": butfirst, "butlast": butlast, "item": item, "char": char,
    "ascii": ascii_of, "mditem": mditem, "mdsetitem": mdsetitem, "count": count, "lput": lput, "memberp": memberp,
    "substringp": substringp,
    "quotient": quotient, "int": whole, "gprop": gprop, "pprop": pprop,
}  # fmt: skip
