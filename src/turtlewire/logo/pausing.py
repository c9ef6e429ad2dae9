"""PAUSE: a prompt within a procedure, and CONTINUE, which ends it.

Whoever has a user to ask gives the interpreter the function ``ask``: it gets the prompt and returns what was typed,
one or several whole instruction lines, or ``None`` when there is nothing more to come.
"""

from __future__ import annotations

from turtlewire.logo.definitions import define_from_title
from turtlewire.logo.errors import LogoError
from turtlewire.logo.procedures import COMMAND, Result, ThrowError
from turtlewire.logo.reader import Definition, read

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter

CONTINUE = "pause"  # the tag that CONTINUE throws
_STOPPED = 16


def pause(logo: Interpreter) -> Result:
    """Ask for instructions and run them where the program is, until CONTINUE; what it is given is the result.

    An error in them is told, and does not end the pause. THROW "TOPLEVEL and the end of what is typed end the program.

    Raises:
        LogoError: there is nobody to ask.
        ThrowError: what was typed threw it.
    """
    if logo.ask is None:
        raise LogoError(
            _STOPPED,
            "pause needs someone to ask",
            hint="The program runs without a terminal: leave PAUSE out.",
        )
    if logo.acting_on is not None:
        logo.write(f"{logo.acting_on.explain()}\n")
    logo.write("Pausing...\n")
    prompt = f"{logo.procedure.name}? " if logo.procedure is not None else "? "
    # What an error leaves behind is put right by whoever it passes; only what this procedure itself is doing is here.
    while (typed := logo.ask(prompt)) is not None:
        try:
            result = _run_typed(logo, typed)
        except LogoError as error:
            logo.write(f"{error.explain()}\n")
        except ThrowError as thrown:
            if thrown.tag != CONTINUE:
                raise
            return thrown.value
        else:
            if result is not None:
                return result
    raise ThrowError("toplevel", None)


def _run_typed(logo: Interpreter, typed: str) -> Result:
    for line in read(typed, "pause"):
        if isinstance(line, Definition):
            define_from_title(logo, line)
        else:
            result = logo.run_line(line, COMMAND)
            if result is not None:
                return result
    return None
