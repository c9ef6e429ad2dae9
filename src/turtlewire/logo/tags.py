"""GOTO and TAG: where in a procedure a tag stands."""

from __future__ import annotations

from turtlewire.logo.syntax import Call, Code, Literal, Node, Pending
from turtlewire.logo.values import plain, to_text

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.procedures import UserProcedure
    from turtlewire.logo.reader import Line


def has_tag(logo: Interpreter, procedure: UserProcedure, tag: str) -> bool:
    """Whether a TAG with this literal word, in lower case, is one of the instructions of a procedure's lines."""
    return _find(logo, procedure, tag) is not None


def code_from(logo: Interpreter, procedure: UserProcedure, tag: str) -> Code:
    """The code of a procedure from a tag on.

    Raises:
        ValueError: there is no such tag.
    """
    found = _find(logo, procedure, tag)
    if found is None:
        raise ValueError(f"{procedure.name} has no tag {tag}")
    nodes, lines, index = found
    return Code(nodes[index:], logo.epoch, lines[index:])


def _find(logo: Interpreter, procedure: UserProcedure, tag: str) -> tuple[list[Node], list[Line], int] | None:
    """The instructions of a procedure, their lines, and which of them is the tag."""
    code = logo.body_of(procedure)
    nodes = [*code.instructions, *([code.last] if code.last is not None else [])]
    lines = list(code.lines)
    index = 0
    while index < len(nodes):
        node = nodes[index]
        if isinstance(node, Pending):
            # An unknown word before the tag in its line: parsed as far as can be, which is at least one instruction.
            parsed = logo.parse_pending(node)
            nodes[index : index + 1] = parsed
            lines[index : index + 1] = [lines[index]] * len(parsed)
            continue
        if isinstance(node, Call) and node.primitive.name == "tag" and _is(node.inputs[0], tag):
            return nodes, lines, index
        index += 1
    return None


def _is(node: Node, tag: str) -> bool:
    return (
        isinstance(node, Literal)
        and isinstance(node.value, str | int | float)
        and plain(to_text(node.value)).lower() == tag
    )
