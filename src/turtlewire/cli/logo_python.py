"""``turtlewire logo --show-python``: what the compiler makes of the procedures of programs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.cli import output, program

if TYPE_CHECKING:
    from turtlewire.logo import Interpreter


def execute(programs: list[str]) -> int:
    """Show programs as Python, without running them. Raises ``DataError`` or ``LogoError`` for one that is wrong."""
    import random

    from turtlewire.logo import Interpreter, ScreenTurtle
    from turtlewire.logo.definitions import define_from_title
    from turtlewire.logo.reader import Definition, read

    for each in programs or ["-"]:
        logo = Interpreter(ScreenTurtle(), output.write, random.Random())
        lines = read(program.read(each), program.name_of(each))
        definitions = [line for line in lines if isinstance(line, Definition)]
        for definition in definitions:
            define_from_title(logo, definition)
        output.write("\n\n".join(_shown(logo, str(definition.title.items[1])) for definition in definitions))
        output.write("\n" if definitions else "")
    return 0


def _shown(logo: Interpreter, name: str) -> str:
    from turtlewire.logo.procedures import UserProcedure

    procedure = logo.procedures[name.lower()]
    assert isinstance(procedure, UserProcedure)
    source = logo.compiler.source(procedure)
    if source is None:
        return f"# {name} is left to the evaluator: {logo.compiler.refusal(procedure)}"
    return f"# {name}\n{source}"
