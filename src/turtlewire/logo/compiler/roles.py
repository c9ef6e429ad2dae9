"""What an emitter is given: who knows the names of things, and how its function ends."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from turtlewire.logo.compiler.emit import Emitter
    from turtlewire.logo.procedures import UserProcedure
    from turtlewire.logo.syntax import Call, Invocation, Literal, Node


class RefusedError(Exception):
    """This cannot be made Python of; the evaluator does it."""


class Ending:
    """How the function ends; at top level, by no instruction."""

    def nothing(self, emitter: Emitter, node: Node | None) -> None:  # noqa: ARG002 - for those that do
        """STOP."""
        raise RefusedError("STOP and OUTPUT are for procedures")

    def output(self, emitter: Emitter, node: Call) -> None:  # noqa: ARG002
        """OUTPUT."""
        raise RefusedError("STOP and OUTPUT are for procedures")

    def takes_over(self, emitter: Emitter, node: Invocation) -> bool:  # noqa: ARG002 - for those that do
        """A procedure is called last: whether it takes the place of the one that is running."""
        return False


class Namer(Protocol):
    """By which names functions find what they use; see ``Compiler``, which has the things themselves."""

    def primitive(self, primitive: Any, *, moves: bool) -> str:
        """The function of a primitive."""

    def procedure(self, procedure: UserProcedure, *, as_command: bool) -> str:
        """The function of a procedure."""

    def constant(self, value: Any, node: Literal) -> str:
        """A list that stands in the program."""

    def always_outputs(self, procedure: UserProcedure) -> bool:
        """Whether a procedure outputs whenever it ends."""

    def never_outputs(self, procedure: UserProcedure) -> bool:
        """Whether a procedure never outputs."""
