"""What is remembered of a compiled function: which instruction each of its places comes from."""

from __future__ import annotations

from turtlewire.logo.values import plain
from turtlewire.named_tuple import NamedTuple

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from turtlewire.logo.procedures import UserProcedure
    from turtlewire.logo.syntax import Call, Node

# What makes a line of the program worth compiling.
LOOPS = frozenset((
    "repeat", "forever", "for", "while", "until", "do.while", "do.until", "foreach", "map", "filter", "reduce",
))  # fmt: skip


class Operand(NamedTuple):
    """Where an input of an operation is found again when the operation has failed.

    ``kind``: ``constant`` (what it is) or ``local`` (the Python variable).
    """

    node: Node
    kind: str
    what: Any


class Site:
    """An instruction that can fail.

    Attributes:
        node: the instruction.
        wanted_by: who wants its value.
        operands: its inputs, if they can be found again.
        asker: who runs it, or looks at its value, to know what is true.
        procedure: whose instruction it is, when it stands in the function of another one.
    """

    __slots__ = ("asker", "node", "operands", "procedure", "wanted_by")

    def __init__(
        self,
        node: Node,
        wanted_by: str,
        operands: tuple[Operand, ...] = (),
        procedure: UserProcedure | None = None,
        asker: Call | None = None,
    ) -> None:
        self.node = node
        self.wanted_by = wanted_by
        self.operands = operands
        self.procedure = procedure
        self.asker = asker


def identifier(text: str) -> str:
    """A Python name for a Logo name; different for different ones."""
    return "".join(
        c if c.isascii() and c.isalnum() and not c.isupper() else f"_{ord(c):x}_" for c in plain(text)
    )


def primitive_name(name: str, *, moves: bool) -> str:
    """The name of the function of a primitive that moves the robot, or does not."""
    return f"{'m' if moves else 'f'}_{identifier(name)}"
