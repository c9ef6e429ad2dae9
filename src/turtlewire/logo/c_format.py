"""A number by a format of C's ``printf``, as FORM takes it."""

from __future__ import annotations

import re

_DIRECTIVE = re.compile(
    r"%(?P<flags>[-+ #0]*)(?P<width>[0-9]{0,3})(?P<precision>(?:\.[0-9]{0,3})?)l?(?P<kind>[efgEFGaA%])"
)


def formatted(number: float, form: str) -> str:
    """The number in the place of the directive for a float in the format; there may be none.

    Raises:
        ValueError: there is a directive for something else, for a second number, or none behind a ``%``.
    """
    pieces: list[str] = []
    at, is_used = 0, False
    while (percent := form.find("%", at)) >= 0:
        found = _DIRECTIVE.match(form, percent)
        if found is None or (found["kind"] != "%" and is_used):
            raise ValueError(f"no directive for a number: {form[percent:]}")
        pieces.append(form[at:percent])
        if found["kind"] == "%":
            pieces.append("%")
        else:
            pieces.append(_written(number, found))
            is_used = True
        at = found.end()
    return "".join([*pieces, form[at:]])


def _written(number: float, found: re.Match[str]) -> str:
    flags, width, precision, kind = found["flags"], found["width"], found["precision"], found["kind"]
    if kind not in "aA":
        text: str = f"%{flags}{width}{precision}{kind}" % number
        return text
    if precision or flags.strip("-"):
        raise ValueError("a number in base 16 takes a width only")
    mantissa, _, exponent = number.hex().partition("p")
    text = (mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa) + f"p{exponent}"
    text = text.upper() if kind == "A" else text
    return text.ljust(int(width or 0)) if flags else text.rjust(int(width or 0))
