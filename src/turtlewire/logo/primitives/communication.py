"""Communication: what a program writes."""

from __future__ import annotations

from turtlewire.logo.procedures import Chapter
from turtlewire.logo.values import TRUE, plain, show, spelled, to_words, word

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.values import Value

chapter = Chapter()
primitive = chapter.primitive


def shown(logo: Interpreter, value: Value) -> str:
    """A value as SHOW prints it, with regard to FULLPRINTP, PRINTDEPTHLIMIT and PRINTWIDTHLIMIT."""
    return _limited(logo, value, 0) if _is_set(logo) else show(value)


def printed(logo: Interpreter, value: Value) -> str:
    """A value as PRINT prints it: the outermost brackets of a list left out."""
    if not _is_set(logo):
        return to_words(value)
    # The brackets that are left out do not count as a level.
    return _limited(logo, value, 1)[1:-1] if isinstance(value, list) else _limited(logo, value, 0)


def _is_set(logo: Interpreter) -> bool:
    variables = logo.variables
    return "fullprintp" in variables or "printdepthlimit" in variables or "printwidthlimit" in variables


def _limited(logo: Interpreter, value: Value, levels_more: int) -> str:
    setting = logo.variables.get("fullprintp")
    is_full = isinstance(setting, str) and setting.lower() == TRUE
    depth, width = _limit(logo, "printdepthlimit"), _limit(logo, "printwidthlimit")
    return show(
        value,
        spelled if is_full else plain,
        with_origins=is_full,
        depth=depth if depth < 0 else depth + levels_more,
        width=width,
    )


def _limit(logo: Interpreter, name: str) -> int:
    """A limit of printing: a whole number, 0 or more; anything else means that there is none."""
    setting = logo.variables.get(name)
    return int(setting) if isinstance(setting, int) and setting >= 0 else -1


@primitive("print pr", 1, minimum=0, maximum=-1)
def _print(logo: Interpreter, inputs: list[Value]) -> None:
    logo.write(" ".join([printed(logo, each) for each in inputs]) + "\n")


@primitive("type", 1, minimum=0, maximum=-1)
def _type(logo: Interpreter, inputs: list[Value]) -> None:
    logo.write("".join([printed(logo, each) for each in inputs]))


@primitive("show", 1, minimum=0, maximum=-1)
def _show(logo: Interpreter, inputs: list[Value]) -> None:
    logo.write(" ".join([shown(logo, each) for each in inputs]) + "\n")


@primitive("standout", 1)
def _standout(logo: Interpreter, value: Value) -> Value:
    return word(printed(logo, value))
