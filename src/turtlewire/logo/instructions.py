"""Which lists in a program are instructions: the inputs that primitives run, known without running anything."""

from __future__ import annotations

from turtlewire.logo.evaluator import Interpreter
from turtlewire.logo.reader import Line
from turtlewire.logo.screen import ScreenTurtle
from turtlewire.logo.syntax import Call, Invocation, Literal

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator

    from turtlewire.logo.syntax import Node

ALL = -1  # every input

# The inputs that are run, by the full name of the primitive: as instructions, as an expression, or as a template.
INSTRUCTIONS: dict[str, tuple[int, ...]] = {
    "if": (1, 2),
    "ifelse": (1, 2),
    "iftrue": (0,),
    "iffalse": (0,),
    "run": (0,),
    "repeat": (1,),
    "forever": (0,),
    "for": (1,),
    "while": (1,),
    "until": (1,),
    "do.while": (0,),
    "do.until": (0,),
    "catch": (1,),
    "onlimit": (0,),
    "onstop": (0,),
    "ask": (1,),
}
EXPRESSIONS: dict[str, tuple[int, ...]] = {
    "if": (0,),
    "ifelse": (0,),
    "test": (0,),
    "while": (0,),
    "until": (0,),
    "do.while": (1,),
    "do.until": (1,),
    "runresult": (0,),
    "not": (0,),
    "and": (ALL,),
    "or": (ALL,),
}
TEMPLATES: dict[str, tuple[int, ...]] = {
    "apply": (0,),
    "invoke": (0,),
    "map": (0,),
    "map.se": (0,),
    "filter": (0,),
    "find": (0,),
    "reduce": (0,),
    "crossmap": (0,),
    "foreach": (ALL,),  # the last one; the others are data
}


def run_lists(node: Node) -> Iterator[tuple[Line, str]]:
    """The lists that a call runs, as far as they stand in it: each with the table's name.

    ``"instructions"``, ``"expression"``, or ``"template"``; of a lambda, what stands behind its inputs.
    """
    if not isinstance(node, Call):
        return
    name, inputs = node.primitive.name, node.inputs
    if name == "foreach":
        inputs = inputs[-1:]
    for role, table in (
        ("instructions", INSTRUCTIONS),
        ("expression", EXPRESSIONS),
        ("template", TEMPLATES),
    ):
        wanted = table.get(name, ())
        for index, each in enumerate(inputs):
            if not (index in wanted or ALL in wanted):
                continue
            line = each.line if isinstance(each, Literal) else None
            if line is None:
                continue
            if role != "template" or not (line.items and isinstance(line.items[0], Line)):
                yield line, role
            elif not any(isinstance(item, Line) for item in line.items[1:2]):  # else it is a whole procedure
                yield line.rest(), role


def inputs_of(node: Node) -> list[Node]:
    """The nodes within a node."""
    return node.inputs if isinstance(node, Call | Invocation) else []


def scratch() -> Interpreter:
    """A workspace to define procedures in; nothing is run in it."""
    return Interpreter(ScreenTurtle(), lambda _text: None, None)  # type: ignore[arg-type]  # no chance without a run
