"""The top level: a whole program, line by line; what it throws and nothing catches ends here."""

from __future__ import annotations

from turtlewire.logo import blame, errors
from turtlewire.logo.calls import call_compiled
from turtlewire.logo.definitions import define_from_title
from turtlewire.logo.errors import LogoError
from turtlewire.logo.procedures import COMMAND, ThrowError
from turtlewire.logo.reader import Definition, read

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.reader import Line
    from turtlewire.logo.tokens import Place


def run_lines(logo: Interpreter, source: str, name: str) -> None:
    """Read a program and run its lines.

    Raises:
        LogoError: the program is wrong. Nothing of it has run when it could not be read.
    """
    logo.reset()
    if logo.debugger is not None:
        logo.debugger.begin()
    if "erract" in source.lower():
        logo.compiler.switch_off()
    program = read(source, name)
    level = logo.levels.start(len(program))
    function = None
    try:
        for index, line in enumerate(program):
            level[0] = index
            if isinstance(line, Definition):
                define_from_title(logo, line)
                continue
            function = logo.compiler.line(line) if not logo.is_all_watched else None
            if function is not None:
                call_compiled(logo, function, [])
            else:
                logo.run_line(line, COMMAND)
    except ThrowError as thrown:
        if thrown.tag != "toplevel":
            error = LogoError(14, f"Can't find catch tag for {thrown.tag}")
            place = logo.compiler.place_of(thrown)[0] or logo.place
            raise blame.placed(logo, error, place) from None
    except MemoryError as full:
        logo.reserve = b""  # what is to be done on the way out needs some
        place, procedure = logo.compiler.place_of(full)
        if place is None:  # there may be no memory to tell where
            place = logo.place if function is None else _beginning(program[level[0]])
        raise blame.placed(logo, errors.out_of_space(), place, procedure) from None
    except RecursionError as deep:
        place, procedure = logo.compiler.place_of(deep)
        raise blame.placed(logo, errors.stack_overflow(), place or logo.place, procedure) from None
    logo.levels.finish()


def _beginning(line: Line | Definition) -> Place:
    title = line.title if isinstance(line, Definition) else line
    return (title.source, title.offsets[0]) if title.source is not None and title.offsets else None
