"""Who is to blame, and where: errors get their place in the program and the procedure that was running."""

from __future__ import annotations

from typing import TYPE_CHECKING, NoReturn

from turtlewire.logo import errors
from turtlewire.logo.procedures import ExitError, Output, Result, Stop
from turtlewire.logo.syntax import Call, Invocation, Node, Variable
from turtlewire.logo.values import show_in_error

if TYPE_CHECKING:
    from turtlewire.logo.errors import LogoError
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.tokens import Place


def placed(logo: Interpreter, error: LogoError, place: Place) -> LogoError:
    """The error with the place and the running procedure, unless it knows them already."""
    if not error.is_placed:
        error.is_placed = True
        if error.procedure is None and logo.procedure is not None:
            error.procedure = logo.procedure.name
    if error.position is None and place is not None:
        error.position = place[0].position(place[1])
    return error


def refuse_value(logo: Interpreter, node: Node, value: Result) -> NoReturn:
    """A value that no command takes."""
    error = errors.unused_value(show_in_error(value), from_procedure=type(node) is Invocation)  # type: ignore[arg-type]
    raise placed(logo, error, node.place)


def refuse_variable(logo: Interpreter, node: Variable) -> NoReturn:
    """A variable without a value."""
    raise placed(logo, errors.no_value(node.name, list(logo.variables)), node.place)


def refuse_input(logo: Interpreter, node: Node, wanted_by: str, result: Result) -> NoReturn:
    """An input that is no value: a variable without one, a command, or the end of the whole procedure."""
    if isinstance(node, Variable):
        refuse_variable(logo, node)
    if isinstance(result, Stop | Output):
        raise ExitError(result)
    name = node.name if isinstance(node, Call | Invocation) else "run"
    raise placed(logo, errors.did_not_output(name, wanted_by), node.place)


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
