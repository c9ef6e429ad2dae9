"""TRACE: what is printed when a traced procedure is invoked and when it ends, and when a traced name gets a value.

And STEP of variables: what is printed when a local variable hides one.
"""

from __future__ import annotations

from turtlewire.logo.values import Value, show, show_in_error, spelled, to_text

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter


def quoted(value: Value) -> str:
    """A value as a program would have to say it."""
    if isinstance(value, str):
        return '"' + (spelled(value) if value else "")
    return to_text(value) if isinstance(value, int | float) else show_in_error(value)


def _traced(value: Value) -> str:
    return f'"{show(value)}' if isinstance(value, str) else show(value)


def tell_invoked(logo: Interpreter, name: str, inputs: list[Value]) -> None:
    """A traced procedure begins: others are a column further in until it ends."""
    shown = "".join([f" {_traced(each)}" for each in inputs])
    logo.write(f"{' ' * logo.marks.trace_depth}( {name}{shown} )\n")
    logo.marks.trace_depth += 1


def tell_ended(logo: Interpreter, name: str, value: Value | None) -> None:
    """It has ended, with a value or without one."""
    ending = "stops" if value is None else f"outputs {_traced(value)}"
    logo.write(f"{' ' * logo.marks.trace_depth}{name} {ending}\n")


def tell_variable(logo: Interpreter, name: str, value: Value) -> None:
    """A traced variable has got a value."""
    logo.write(f'Make "{name} {_traced(value)}\n')


def tell_property(logo: Interpreter, owner: str, name: str, value: Value) -> None:
    """A traced property list has got a property."""
    logo.write(f'Pprop "{owner} "{name} {_traced(value)}\n')


def tell_shadowed(logo: Interpreter, name: str) -> None:
    """A stepped variable is hidden by one of the same name, an input or a local one."""
    where = ""
    if logo.procedure is not None:
        line = logo.instruction
        shown = f"\n{show(line)}" if line is not None else ""
        where = f"  in {logo.procedure.name}{shown}"  # UCBLogo's two spaces
    logo.streams.tell(f"{name} shadowed by local in procedure call{where}\n")
