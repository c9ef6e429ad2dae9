"""How a procedure's function ends: STOP, OUTPUT, and the calls that take its place.

A call of itself in the last place is a jump to its beginning. A call of another procedure that leads back to this one
is given back to whoever called, as a tuple (function, record and number of where it stood, inputs ...): so any number
of them needs no stack. No Logo value is a tuple. The number is negative where a value is output.
"""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from turtlewire.logo.compiler import python as py
from turtlewire.logo.compiler.emit import Ending, RefusedError, is_simple
from turtlewire.logo.syntax import Call, Invocation, OutputCall

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.logo.compiler.emit import Emitter
    from turtlewire.logo.compiler.facts import Survey
    from turtlewire.logo.procedures import UserProcedure
    from turtlewire.logo.syntax import Node


class ProcedureEnding(Ending):
    """How a procedure ends.

    Args:
        survey: what is known of all procedures.
        procedure: the one.
        jump_to: the name of the function that a call in the last place is left to, and where it stands: in whose
            record, and at which number.

    Attributes:
        begins_anew: whether it jumps to its beginning.
        jumps: whether it leaves calls to whoever called it.
    """

    def __init__(
        self, survey: Survey, procedure: UserProcedure, jump_to: Callable[[Invocation], tuple[str, str, int]]
    ) -> None:
        self._procedure = procedure
        self._jump_to = jump_to
        self._leads_back = {
            each for each in survey.reached(procedure) if procedure in survey.reached(each)
        } | {procedure}
        nodes = survey.body(procedure)
        outputs = [node for node in survey.walk(nodes) if isinstance(node, OutputCall)]
        again_as_command = any(self._is_self(node) for node in survey.last(nodes))
        again_for_value = any(self._is_self(node.inputs[0]) for node in outputs)
        # A procedure that was called for no value may find itself, later, where a value is output; or the other way.
        self._minds_value = again_as_command and bool(outputs)
        self._minds_nothing = again_for_value and not survey.always_outputs(procedure)
        self.begins_anew = False
        self.jumps = False

    def _is_self(self, node: Node) -> bool:
        return isinstance(node, Invocation) and node.procedure is self._procedure

    @property
    def minds(self) -> bool:
        """Whether it must remember how it began anew."""
        return self._minds_value or self._minds_nothing

    def nothing(self, emitter: Emitter, node: Node | None) -> None:
        """STOP, or the end of the body."""
        if node is None and emitter.body and isinstance(emitter.body[-1], ast.Return | ast.Continue):
            return
        if self._minds_nothing:
            late = py.compare(py.name("late"), ast.Lt(), py.const(0))
            emitter.body.append(py.when(late, [py.do(py.call("late_silence", py.name("late")))]))
        emitter.body.append(py.give())

    def output(self, emitter: Emitter, node: Call) -> None:
        """OUTPUT."""
        value = node.inputs[0]
        if isinstance(value, Invocation) and self._takes_over(emitter, value, as_command=False):
            return
        made = emitter.value(value, node.name)
        if self._minds_value:
            made = emitter.kept(made)
            late = py.compare(py.name("late"), ast.Gt(), py.const(0))
            emitter.body.append(py.when(late, [py.do(py.call("late_value", py.name("late"), made))]))
        emitter.body.append(py.give(made))

    def takes_over(self, emitter: Emitter, node: Invocation) -> bool:
        """A command that comes last."""
        return self._takes_over(emitter, node, as_command=True)

    def _takes_over(self, emitter: Emitter, node: Invocation, *, as_command: bool) -> bool:
        if node.procedure not in self._leads_back:
            return False
        if self._is_self(node) and not emitter.loops:
            self._begin_anew(emitter, node, as_command=as_command)
            return True
        if emitter.binds_dynamically:
            raise RefusedError("a call in the last place, which must see the variables of those before it")
        if not is_simple(node.procedure):
            raise RefusedError(f"{node.name} takes inputs that can be left out")
        function, record, number = self._jump_to(node)
        place = py.const(number if as_command else -number)
        inputs = emitter.values(node.inputs, node.name)
        self.jumps = True
        emitter.body.append(py.give(ast.Tuple([py.name(function), py.name(record), place, *inputs], py.LOAD)))
        return True

    def _begin_anew(self, emitter: Emitter, node: Invocation, *, as_command: bool) -> None:
        keys = self._procedure.inputs
        values = emitter.values(node.inputs, node.name)
        if self.minds:
            number = emitter.site(node, "output")
            emitter.body.append(py.assign("late", py.const(number if as_command else -number)))
        changed = [
            (key, value)
            for key, value in zip(keys, values, strict=True)
            if not (isinstance(value, ast.Name) and value.id == emitter.names.get(key))
        ]
        if len(changed) == 1:
            emitter.set_variable(*changed[0])
        elif changed:
            targets = [emitter.place(key) for key, _ in changed]
            made = ast.Tuple([value for _, value in changed], py.LOAD)
            emitter.body.append(ast.Assign([ast.Tuple(targets, py.STORE)], made))
        self.begins_anew = True
        emitter.body.append(ast.Continue())
