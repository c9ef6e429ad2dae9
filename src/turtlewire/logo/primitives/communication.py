"""Communication: what a program writes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.logo.procedures import Chapter
from turtlewire.logo.values import show, to_words

if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.values import Value

chapter = Chapter()
primitive = chapter.primitive


@primitive("print pr", 1, minimum=0, maximum=-1)
def _print(logo: Interpreter, inputs: list[Value]) -> None:
    logo.write(" ".join([to_words(each) for each in inputs]) + "\n")


@primitive("type", 1, minimum=0, maximum=-1)
def _type(logo: Interpreter, inputs: list[Value]) -> None:
    logo.write("".join([to_words(each) for each in inputs]))


@primitive("show", 1, minimum=0, maximum=-1)
def _show(logo: Interpreter, inputs: list[Value]) -> None:
    logo.write(" ".join([show(each) for each in inputs]) + "\n")
