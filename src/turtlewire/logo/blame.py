"""Who is to blame, and where: errors get their place in the program and the procedure that was running."""

from __future__ import annotations

from turtlewire.logo import errors
from turtlewire.logo.syntax import Call, Code, Failure, Invocation, Literal, Node, Variable
from turtlewire.logo.values import show_in_error

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn

    from turtlewire.logo.errors import LogoError
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.procedures import Result, UserProcedure
    from turtlewire.logo.reader import Line
    from turtlewire.logo.tokens import Place


def placed(
    logo: Interpreter, error: LogoError, place: Place, procedure: UserProcedure | None = None
) -> LogoError:
    """The error with the place and the running procedure (or the given one), unless it knows them already."""
    if not error.is_placed:
        error.is_placed = True
        running = procedure or logo.procedure
        if error.procedure is None and running is not None:
            error.procedure = running.name
            # The evaluator knows where it is; of a compiled procedure, its text tells.
            line = line_of(running, place) if procedure is not None else None
            error.instruction = line.value if line is not None else logo.instruction
    if error.position is None and place is not None:
        error.position = place[0].position(place[1])
    return error


def refuse_value(logo: Interpreter, node: Node, value: Result) -> NoReturn:
    """A value that no command takes."""
    error = errors.unused_value(show_in_error(value), from_procedure=type(node) is Invocation)  # type: ignore[arg-type]
    raise placed(logo, error, node.place)


def about_input(logo: Interpreter, node: Node, wanted_by: str) -> LogoError:
    """The error of an input that is no value: a variable without one, or a command."""
    if isinstance(node, Variable):
        return errors.no_value(node.name, list(logo.variables))
    name = node.name if isinstance(node, Call | Invocation) else "run"
    return errors.did_not_output(name, wanted_by)


def refuse_several(code: Code) -> None:
    """A list that stands for a value may hold one expression only.

    Raises:
        LogoError: it holds several.
    """
    last = code.last
    if code.instructions and last is not None and not isinstance(last, Failure):
        raise errors.several_expressions(" ".join([_spelled(each) for each in (*code.instructions, last)]))


def _spelled(node: Node) -> str:
    """An expression as the parser sees it, each call in brackets: as UCBLogo shows it."""
    if isinstance(node, Literal):
        shown = show_in_error(node.value)
        return f'"{shown}' if isinstance(node.value, str | list) else shown
    if isinstance(node, Variable):
        return f":{node.name}"
    if isinstance(node, Call | Invocation):
        if node.name == "-" and len(node.inputs) == 1:
            return f"[-- 0 {_spelled(node.inputs[0])}]"
        return f"[{' '.join([node.name, *[_spelled(each) for each in node.inputs]])}]"
    return "..."


def line_of(procedure: UserProcedure, place: Place) -> Line | None:
    """The line of a procedure's body that a place is in, ``None``: in none."""
    found = None
    if place is not None:
        source, offset = place
        for line in procedure.body:
            if line.source is source and line.offsets and line.offsets[0] <= offset:
                found = line
        if found is not None and offset > source.end_of(found):
            return None
    return found


def annotate(logo: Interpreter, error: BaseException, node: Node) -> None:
    """Note on an error of the robot or its link which command of the program it happened in."""
    if error is logo.escaping:
        return
    logo.escaping = error
    position = node.place[0].position(node.place[1]) if node.place is not None else logo.position
    name = node.name if isinstance(node, Call | Invocation) else ""
    if position is None:
        error.add_note(f"in {name}")
    else:
        error.add_note(f"in {position.file}, line {position.line}, {name}:\n{position.marked()}")
