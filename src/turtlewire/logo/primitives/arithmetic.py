"""Arithmetic: numbers, transcendental functions, random numbers, bits, and the infix operators."""

from __future__ import annotations

import math

from turtlewire.logo.primitives.inputs import answer, integer, natural, number, text
from turtlewire.logo.procedures import BadInputError, Chapter
from turtlewire.logo.values import EXACT, Number, Value, make_list, narrowed, plain

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive


_DIVISOR = "a number other than 0"
_RESULT = "a number for which there is a result, and not too large a one"


def _finite(result: Number, blamed: Value) -> Number:
    """A result that is a number; an infinite one, or none at all, is the fault of the blamed input."""
    kept = narrowed(result)
    if not math.isfinite(kept):
        raise BadInputError(blamed, wanted=_RESULT)
    return kept


def add(a: Number, b: Number) -> Number:
    """A sum: exact for whole numbers, infinite when it is too large for a float."""
    try:
        return a + b
    except OverflowError:
        return narrowed(a) + narrowed(b)


def multiply(a: Number, b: Number) -> Number:
    """A product: exact for whole numbers up to 2**53."""
    try:
        return narrowed(a * b)
    except OverflowError:
        return narrowed(a) * narrowed(b)


def divide(a: Number, b: Number) -> Number:
    """A quotient; the divisor is not 0."""
    try:
        result = a / b
    except OverflowError:
        result = narrowed(a) / narrowed(b)
    return int(result) if result.is_integer() and -EXACT <= result <= EXACT else result


def _whole_if_exact(result: float) -> Number:
    return int(result) if result.is_integer() and abs(result) < 1e15 else result


@primitive("sum", 2, minimum=0, maximum=-1)
def _sum(_logo: Interpreter, inputs: list[Value]) -> Number:
    total: Number = 0
    for each in inputs:
        total = add(total, number(each))
    return total


@primitive("+", 2)
def _plus(_logo: Interpreter, a: Value, b: Value) -> Number:
    return add(number(a), number(b))


@primitive("difference -", 2)
def _difference(_logo: Interpreter, a: Value, b: Value) -> Number:
    return add(number(a), -number(b))


@primitive("minus", 1)
def _minus(_logo: Interpreter, a: Value) -> Number:
    return -number(a)


@primitive("product", 2, minimum=0, maximum=-1)
def _product(_logo: Interpreter, inputs: list[Value]) -> Number:
    result: Number = 1
    for each in inputs:
        result = multiply(result, number(each))
    return result


@primitive("*", 2)
def _times(_logo: Interpreter, a: Value, b: Value) -> Number:
    return multiply(number(a), number(b))


@primitive("quotient /", 2, minimum=1)
def _quotient(_logo: Interpreter, a: Value, b: Value | None = None) -> Number:
    if b is None:
        a, b = 1, a
    dividend, divisor = number(a), number(b)
    if divisor == 0:
        raise BadInputError(b, 4, _DIVISOR)
    return divide(dividend, divisor)


@primitive("remainder", 2)
def _remainder(_logo: Interpreter, a: Value, b: Value) -> Number:
    dividend, divisor = number(a), number(b)
    if divisor == 0:
        raise BadInputError(b, 4, _DIVISOR)
    if isinstance(dividend, int) and isinstance(divisor, int):
        result = abs(dividend) % abs(divisor)
        return -result if dividend < 0 else result
    return math.fmod(dividend, divisor)


@primitive("modulo", 2)
def _modulo(_logo: Interpreter, a: Value, b: Value) -> Number:
    dividend, divisor = number(a), number(b)
    if divisor == 0:
        raise BadInputError(b, 4, _DIVISOR)
    return dividend % divisor + 0  # and so never -0


@primitive("int", 1)
def _int(_logo: Interpreter, a: Value) -> Number:
    return _finite(int(_finite(number(a), a)), a)


@primitive("round", 1)
def _round(_logo: Interpreter, a: Value) -> Number:
    value = _finite(number(a), a)
    rounded = value if isinstance(value, int) else math.floor(abs(value) + 0.5)
    return _finite(-rounded if isinstance(value, float) and value < 0 else rounded, a)


@primitive("abs", 1)
def _abs(_logo: Interpreter, a: Value) -> Number:
    return abs(number(a))


def _real(value: Value, function: Callable[[float], float]) -> Number:
    """A function of the reals; where it has no finite value, the input is not liked."""
    try:
        return _finite(_whole_if_exact(function(number(value))), value)
    except (ValueError, OverflowError):
        raise BadInputError(value, wanted=_RESULT) from None


@primitive("sqrt", 1)
def _sqrt(_logo: Interpreter, a: Value) -> Number:
    return _real(a, math.sqrt)


@primitive("power", 2)
def _power(_logo: Interpreter, a: Value, b: Value) -> Number:
    base, exponent = number(a), number(b)
    if isinstance(base, int) and isinstance(exponent, int) and 0 <= exponent <= 64:
        return _finite(base**exponent, b)
    if base == 0 and exponent < 0:
        raise BadInputError(b)
    return _real(b, lambda _: math.pow(base, exponent))


@primitive("exp", 1)
def _exp(_logo: Interpreter, a: Value) -> Number:
    return _real(a, math.exp)


@primitive("log10", 1)
def _log10(_logo: Interpreter, a: Value) -> Number:
    return _real(a, math.log10)


@primitive("ln", 1)
def _ln(_logo: Interpreter, a: Value) -> Number:
    return _real(a, math.log)


# The sines that people know by heart are exact, so that they compare equal.
_SINES = {0.0: 0.0, 30.0: 0.5, 90.0: 1.0, 150.0: 0.5, 180.0: 0.0, 210.0: -0.5, 270.0: -1.0, 330.0: -0.5}


def _sine_of(degrees: float) -> float:
    turned = degrees % 360.0
    return _SINES[turned] if turned in _SINES else math.sin(math.radians(degrees))


def _cosine_of(degrees: float) -> float:
    turned = (degrees + 90.0) % 360.0
    return _SINES[turned] if turned in _SINES else math.cos(math.radians(degrees))


@primitive("sin", 1)
def _sin(_logo: Interpreter, a: Value) -> Number:
    return _real(a, _sine_of)


@primitive("cos", 1)
def _cos(_logo: Interpreter, a: Value) -> Number:
    return _real(a, _cosine_of)


@primitive("tan", 1)
def _tan(_logo: Interpreter, a: Value) -> Number:
    def tangent(degrees: float) -> float:
        sine, cosine = _sine_of(degrees), _cosine_of(degrees)
        if cosine == 0.0:
            raise ValueError
        return math.copysign(1.0, sine * cosine) if degrees % 90.0 == 45.0 else sine / cosine

    return _real(a, tangent)


@primitive("radsin", 1)
def _radsin(_logo: Interpreter, a: Value) -> Number:
    return _real(a, math.sin)


@primitive("radcos", 1)
def _radcos(_logo: Interpreter, a: Value) -> Number:
    return _real(a, math.cos)


def _angle(a: Value, b: Value | None) -> float:
    if b is None:
        return math.atan(number(a))
    x, y = number(a), number(b)
    return math.atan2(y, x)


@primitive("arctan", 1, maximum=2)
def _arctan(_logo: Interpreter, a: Value, b: Value | None = None) -> Number:
    return _whole_if_exact(math.degrees(_angle(a, b)))


@primitive("radarctan", 1, maximum=2)
def _radarctan(_logo: Interpreter, a: Value, b: Value | None = None) -> Number:
    return _whole_if_exact(_angle(a, b))


@primitive("pi", 0)
def _pi(_logo: Interpreter) -> Number:
    return math.pi


def _sequence(start: Number, end: Number, count: int) -> list[Value]:
    step = (end - start) / (count - 1) if count > 1 else 0.0
    return [_whole_if_exact(float(start + i * step)) for i in range(count)]


@primitive("iseq", 2)
def _iseq(_logo: Interpreter, a: Value, b: Value) -> Value:
    start, end = integer(a), integer(b)
    step = 1 if end >= start else -1
    return make_list(range(start, end + step, step))


@primitive("rseq", 3)
def _rseq(_logo: Interpreter, a: Value, b: Value, c: Value) -> Value:
    count = natural(c)
    return make_list(_sequence(number(a), number(b), count))


# --- predicates -----------------------------------------------------------------------------------------------


@primitive("lessp less? <", 2)
def _lessp(_logo: Interpreter, a: Value, b: Value) -> Value:
    return answer(condition=number(a) < number(b))


@primitive("greaterp greater? >", 2)
def _greaterp(_logo: Interpreter, a: Value, b: Value) -> Value:
    return answer(condition=number(a) > number(b))


@primitive("lessequalp lessequal? <=", 2)
def _lessequalp(_logo: Interpreter, a: Value, b: Value) -> Value:
    return answer(condition=number(a) <= number(b))


@primitive("greaterequalp greaterequal? >=", 2)
def _greaterequalp(_logo: Interpreter, a: Value, b: Value) -> Value:
    return answer(condition=number(a) >= number(b))


# --- random numbers -------------------------------------------------------------------------------------------


@primitive("random", 1, maximum=2)
def _random(logo: Interpreter, a: Value, b: Value | None = None) -> Number:
    if b is None:
        size = natural(a)
        return logo.random.randrange(size) if size else 0
    low, high = integer(a), integer(b)
    if high < low:
        raise BadInputError(b)
    return logo.random.randint(low, high)


@primitive("rerandom", 0, maximum=1)
def _rerandom(logo: Interpreter, seed: Value = 42) -> None:
    logo.random.seed(integer(seed))


# --- bits -----------------------------------------------------------------------------------------------------


_WORD = 0xFFFFFFFF


def _bits(value: Value) -> int:
    found = number(value)
    if found != int(found):
        raise BadInputError(value, 4, "a whole number")
    return int(found)


@primitive("bitand", 2, minimum=0, maximum=-1)
def _bitand(_logo: Interpreter, inputs: list[Value]) -> Number:
    result = -1
    for each in inputs:
        result &= _bits(each)
    return result


@primitive("bitor", 2, minimum=0, maximum=-1)
def _bitor(_logo: Interpreter, inputs: list[Value]) -> Number:
    result = 0
    for each in inputs:
        result |= _bits(each)
    return result


@primitive("bitxor", 2, minimum=0, maximum=-1)
def _bitxor(_logo: Interpreter, inputs: list[Value]) -> Number:
    result = 0
    for each in inputs:
        result ^= _bits(each)
    return result


@primitive("bitnot", 1)
def _bitnot(_logo: Interpreter, a: Value) -> Number:
    return ~_bits(a)


def _shifted(value: int, places: int, b: Value) -> Number:
    if abs(places) > 64:
        raise BadInputError(b, wanted="at most 64 places")
    return _finite(value << places if places >= 0 else value >> -places, b)


@primitive("ashift", 2)
def _ashift(_logo: Interpreter, a: Value, b: Value) -> Number:
    return _shifted(_bits(a), _bits(b), b)


@primitive("lshift", 2)
def _lshift(_logo: Interpreter, a: Value, b: Value) -> Number:
    """To the right, a negative number is the pattern of 32 bits that it is in UCBLogo, and zeros come in."""
    value, places = _bits(a), _bits(b)
    return _shifted(value & _WORD if value < 0 and places < 0 else value, places, b)


@primitive("form", 3)
def _form(_logo: Interpreter, a: Value, width: Value, precision: Value) -> Value:
    """A number in a width, with so many decimals; with a width less than 0, by a format of C's ``printf``."""
    if number(width) < 0:
        return _form_as_in_c(a, precision)
    if natural(width) > 1000:
        raise BadInputError(width)
    if natural(precision) > 100:
        raise BadInputError(precision)
    return f"{number(a):{natural(width) or ''}.{natural(precision)}f}"


def _form_as_in_c(a: Value, form: Value) -> str:
    from turtlewire.logo.c_format import formatted

    try:
        return formatted(float(number(a)), plain(text(form)))
    except ValueError:
        raise BadInputError(form, wanted="a format of C with one %e, %f, %g or %a: |%8.3f|") from None
