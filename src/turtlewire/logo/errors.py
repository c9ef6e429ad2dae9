"""Logo's errors: the sentences and numbers of the Berkeley manual, and where in the program they happened."""

from __future__ import annotations

from turtlewire.errors import ProgramError
from turtlewire.logo.values import plain, spelled
from turtlewire.named_tuple import NamedTuple

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence

    from turtlewire.logo.values import List


class Position(NamedTuple):
    """A place in a program; line and column count from 1, ``text`` is the whole source line."""

    file: str
    line: int
    column: int
    text: str

    def marked(self) -> str:
        """The source line with a caret under the place."""
        lead = "".join("\t" if c == "\t" else " " for c in self.text[: self.column - 1])
        return f"    {self.text}\n    {lead}^"


class LogoError(ProgramError):
    """A Logo program is wrong, in the words of UCBLogo.

    Attributes:
        number: the error's number in the Berkeley manual.
        text: UCBLogo's sentence alone.
        procedure: the procedure that was running, or ``None`` at top level.
        position: where, or ``None`` when it came from a list that no file contains.
        hint: what to do about it, when that is known; ``""`` otherwise.
    """

    def __init__(self, number: int, text: str, position: Position | None = None, hint: str = "") -> None:
        super().__init__(text)
        self.number = number
        self.text = text
        self.procedure: str | None = None
        self.position = position
        self.hint = hint
        self.instruction: List | None = None  # the line of the procedure, as ERROR outputs it
        self.is_placed = False
        self.is_known = False  # ERRACT had its chance
        self.is_for_caller = False  # the place is the one where the running procedure was invoked
        self.wrong_name = ""
        self.known_names: Sequence[str] = ()

    def copy(self) -> LogoError:
        """The same error, to be raised anew."""
        error = LogoError(self.number, self.text, self.position, self.hint)
        error.wrong_name, error.known_names = self.wrong_name, self.known_names
        return error

    def explain(self) -> str:
        """The paragraph for people: where, what, the source line marked, and what might help."""
        sentence = f"{self.text} in {self.procedure}" if self.procedure else self.text
        hint = self.advice()
        if self.position is None:
            return f"{sentence}\n{hint}" if hint else sentence
        where = f"{self.position.file}, line {self.position.line}, column {self.position.column}"
        lines = [f"{where}: {sentence}", self.position.marked()]
        if hint:
            lines.append(hint)
        return "\n".join(lines)

    def advice(self) -> str:
        """What to do about it, ``""`` if that is not known."""
        if self.hint or not self.wrong_name:
            return self.hint
        from turtlewire.logo.hints import about_name  # only a failing program needs it

        return about_name(self.number, self.wrong_name, self.known_names)

    def __str__(self) -> str:
        return self.explain()


def does_not_like(procedure: str, shown: str, *, number: int = 7, wanted: str = "") -> LogoError:
    """An input of the wrong kind; ``shown`` is the input as SHOW prints it, ``wanted`` says what is liked."""
    hint = f"{procedure} wants {wanted}." if wanted else ""
    return LogoError(number, f"{procedure} doesn't like {shown} as input", hint=hint)


def not_enough_inputs(procedure: str, usage: str = "") -> LogoError:
    """A procedure got fewer inputs than it needs."""
    return LogoError(6, f"not enough inputs to {procedure}", hint=usage)


def too_many_inputs(procedure: str, usage: str = "") -> LogoError:
    """A parenthesised procedure got more inputs than it takes."""
    return LogoError(8, f"too many inputs to {procedure}", hint=usage)


def unexpected_parenthesis() -> LogoError:
    """A ``)`` where none can be."""
    return LogoError(12, "unexpected ')'", hint="This ) has no ( before it, or nothing between them.")


def outside_procedure(name: str) -> LogoError:
    """A STOP or OUTPUT at top level."""
    return LogoError(
        31,
        f"Can only use {name} inside a procedure",
        hint=f"{name} ends the procedure that it stands in, and here none is running.",
    )


def did_not_output(procedure: str, wanted_by: str) -> LogoError:
    """A command stood where an operation was needed."""
    hint = f"{wanted_by} needs a value here, and {procedure} gives it none."
    if wanted_by.lower() in _TAKE_INSTRUCTIONS:
        hint += " Instructions for later stand in brackets: [ ]."
    return LogoError(5, f"{procedure} didn't output to {wanted_by}", hint=hint)


_TAKE_INSTRUCTIONS = frozenset(
    ("repeat", "if", "ifelse", "for", "forever", "while", "until", "run", "foreach")
)


def unused_value(shown: str, *, from_procedure: bool = False) -> LogoError:
    """A value that no command takes."""
    return LogoError(
        30 if from_procedure else 9,
        f"You don't say what to do with {shown}",
        hint="No command takes this value: put one before it, such as PRINT, or take the value away.",
    )


def no_expansion(shown: str) -> LogoError:
    """A macro that did not output the list which is to be run in its place."""
    return LogoError(
        29,
        f"Macro returned {shown} instead of a list",
        hint="A macro outputs a list of instructions, which are run in its place.",
    )


def several_expressions(shown: str) -> LogoError:
    """A list that stands for a value, with more than one expression in it."""
    return LogoError(
        43,
        f"Runlist [{shown}] has more than one expression",
        hint="A list that stands for a value holds one expression and nothing else.",
    )


def no_value(name: str, known_names: Sequence[str] = ()) -> LogoError:
    """A variable without a value."""
    error = LogoError(11, f"{spelled(name)} has no value")
    error.wrong_name, error.known_names = plain(name), known_names
    return error


def unknown_procedure(name: str, known_names: Sequence[str] = (), *, number: int = 13) -> LogoError:
    """A word that is neither a procedure nor, with Logo's getter syntax, a variable; 24 when it is to be applied."""
    error = LogoError(number, f"I don't know how to {spelled(name)}")
    error.wrong_name, error.known_names = plain(name), known_names
    return error


def is_primitive(name: str) -> LogoError:
    """A primitive where only a procedure of the user's will do."""
    return LogoError(
        22,
        f"{name} is a primitive",
        hint="Primitives are changed only while REDEFP is true, and some not even then.",
    )


def out_of_space() -> LogoError:
    """There is no more memory, or the program may have no more."""
    return LogoError(1, "out of space", hint="Does a word or a list grow without an end?")


def stack_overflow() -> LogoError:
    """Procedures called one another too deep, or brackets are nested too deep."""
    return LogoError(
        2,
        "stack overflow",
        hint="A procedure calls itself without an end, or far too deep: does it ever stop?",
    )
