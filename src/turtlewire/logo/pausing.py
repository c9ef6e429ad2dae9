"""PAUSE: a prompt within a procedure, and CONTINUE, which ends it; and STEP, which shows lines and waits.

What is typed comes from the interpreter's ``ask``, if it has one: it gets the prompt and returns what was typed, one or
several whole instruction lines, or ``None`` when there is nothing more to come. Otherwise it is the keyboard's, if
somebody may be there.
"""

from __future__ import annotations

from turtlewire.logo.definitions import define_from_title
from turtlewire.logo.errors import LogoError
from turtlewire.logo.procedures import COMMAND, ExitError, Result, ThrowError
from turtlewire.logo.reader import Definition, read
from turtlewire.logo.unfinished import is_unfinished
from turtlewire.logo.values import show

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.reader import Line

CONTINUE = "pause"  # the tag that CONTINUE throws
_STOPPED = 16


def pause(logo: Interpreter) -> Result:
    """Ask for instructions and run them where the program is, until CONTINUE; what it is given is the result.

    An error in them is told, and does not end the pause. THROW "TOPLEVEL and the end of what is typed end the program.
    A debugger's front end is asked instead where nobody types.

    Raises:
        LogoError: there is nobody to ask.
        ThrowError: what was typed threw it.
    """
    debugger = logo.debugger
    if logo.ask is None and debugger is not None and debugger.on_stop is not None:
        debugger.paused(logo)
        return None
    if not _is_attended(logo):
        raise LogoError(
            _STOPPED,
            "pause needs someone to ask",
            hint="The program runs without a terminal: leave PAUSE out.",
        )
    if logo.acting_on is not None:
        logo.streams.tell(f"{logo.acting_on.explain()}\n")
    logo.streams.tell("Pausing...\n")
    prompt = f"{logo.procedure.name}? " if logo.procedure is not None else "? "
    # What an error leaves behind is put right by whoever it passes; only what this procedure itself is doing is here.
    while (typed := _ask(logo, prompt)) is not None:
        try:
            result = run_typed(logo, typed)
        except LogoError as error:
            logo.streams.tell(f"{error.explain()}\n")
        except ThrowError as thrown:
            if thrown.tag != CONTINUE:
                raise
            return thrown.value
        else:
            if result is not None:
                return result
    raise ThrowError("toplevel", None)


class Steps:
    """The lines of stepped procedures, shown in one run of a program."""

    def __init__(self) -> None:
        self._is_over = False  # by CONTINUE
        self._is_alone = False  # whether it was said that nobody types

    def show(self, logo: Interpreter, line: Line) -> None:
        """Show a line as UCBLogo does, and wait for the RETURN key.

        What is typed before it is run here, as at a PAUSE, and the line is shown again; CONTINUE ends the stepping of
        this run. Where nobody types lines are shown, and the program goes on.

        Raises:
            ExitError, ThrowError: what was typed ends the procedure, or more.
        """
        prompt = f"{show(line.value)} >>> "
        while not self._is_over:
            typed = None
            if self._is_alone or not _is_attended(logo):
                logo.streams.tell(f"{prompt}\n")
            else:
                typed = _ask(logo, prompt)
            if typed is None:
                self._tell_alone(logo)
                return
            if not typed.strip():
                return
            try:
                result = run_typed(logo, typed)
            except LogoError as error:
                logo.streams.tell(f"{error.explain()}\n")
            except ThrowError as thrown:
                if thrown.tag != CONTINUE:
                    raise
                self._is_over = True
            else:
                if result is not None:
                    raise ExitError(result)

    def _tell_alone(self, logo: Interpreter) -> None:
        if not self._is_alone:
            self._is_alone = True
            logo.streams.tell("Nobody types: stepping goes on without waiting.\n")


def _is_attended(logo: Interpreter) -> bool:
    return logo.ask is not None or logo.streams.keyboard.is_attended()


def _ask(logo: Interpreter, prompt: str) -> str | None:
    """What somebody types, whole instruction lines; ``None`` at the end of it."""
    if logo.ask is not None:
        return logo.ask(prompt)
    keyboard = logo.streams.keyboard
    logo.streams.tell(prompt)
    typed = keyboard.read_line()
    if not typed:
        logo.streams.tell("\n")
        return None
    while is_unfinished(text := typed.removesuffix("\n")):
        logo.streams.tell("> ")
        more = keyboard.read_line()
        if not more:
            break
        typed += more
    return text


def run_typed(logo: Interpreter, typed: str) -> Result:
    """Run what was typed where the program is.

    Raises:
        LogoError: it is wrong.
        ThrowError: it threw.
    """
    for line in read(typed, "pause"):
        if isinstance(line, Definition):
            define_from_title(logo, line)
        else:
            result = logo.run_line(line, COMMAND)
            if result is not None:
                return result
    return None
