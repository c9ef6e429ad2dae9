"""How a procedure's function ends: STOP, OUTPUT, and the calls that take its place.

A call of itself in the last place is a jump to its beginning. A short procedure that leads back to this one and is
called in the last place stands there itself, so that both are one loop. Any other call that leads back is given back
to whoever called, as a tuple (function, record and number of where it stood, inputs ...): so any number of them needs
no stack. No Logo value is a tuple. The number is negative where a value is output.
"""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from turtlewire.logo.compiler import python as py
from turtlewire.logo.compiler.emit import is_simple
from turtlewire.logo.compiler.roles import Ending, RefusedError
from turtlewire.logo.syntax import Call, Invocation, Literal, OutputCall

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.logo.compiler.emit import Blamed, Emitter
    from turtlewire.logo.compiler.facts import Survey
    from turtlewire.logo.compiler.python import Expr, Stmt
    from turtlewire.logo.procedures import UserProcedure
    from turtlewire.logo.syntax import Node

_MOST_NODES = 400  # of the procedures that stand in one function
_MOST_DEEP = 4  # procedures that stand in one another


class ProcedureEnding(Ending):
    """How a procedure ends.

    Args:
        survey: what is known of all procedures.
        procedure: the one.
        jump_to: the name of the function that a call in the last place is left to, and where it stands: in whose
            record, and at which number.
        may_stand: whether a procedure's instructions may stand where it is called last; then its variables are the
            emitter's.

    Attributes:
        begins_anew: whether it jumps to its beginning.
        jumps: whether it leaves calls to whoever called it.
    """

    def __init__(
        self,
        survey: Survey,
        procedure: UserProcedure,
        jump_to: Callable[[Invocation], tuple[str, str, int]],
        may_stand: Callable[[Emitter, UserProcedure], bool],
    ) -> None:
        self._procedure = procedure
        self._jump_to = jump_to
        self._may_stand = may_stand
        self._survey = survey
        self._standing: list[UserProcedure] = []  # those whose instructions are being written here
        self._stood = 0
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
        self._output_of(emitter, node.inputs[0], node.name)

    def _output_of(self, emitter: Emitter, value: Node, wanted_by: str, blamed: Blamed | None = None) -> None:
        """OUTPUT of an expression; of each branch by itself, when it is an IFELSE."""
        if isinstance(value, Invocation):
            # Who wants the value is told when there is none: but not by who takes the place.
            is_wanted = wanted_by == "output" or self._survey.always_outputs(value.procedure)
            if is_wanted and self._takes_over(emitter, value, as_command=False):
                return
        elif isinstance(value, Call) and value.primitive.name in ("if", "ifelse") and len(value.inputs) == 3:
            lines = [each.line if isinstance(each, Literal) else None for each in value.inputs[1:]]
            parsed = [self._survey.parse(line) if line is not None else [] for line in lines]
            if all(len(nodes) == 1 for nodes in parsed):
                condition = emitter.condition(value.inputs[0], value)
                branches = [
                    self._branch(emitter, node, value.name, blamed or (value, wanted_by))
                    for (node,) in parsed
                ]
                emitter.body.append(py.when(condition, branches[0]))
                emitter.body += branches[1]
                return
        made = emitter.value(value, wanted_by, blamed)
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
        if self._stands(emitter, node, as_command=as_command):
            return True
        function, record, number = self._jump_to(node)
        place = py.const(number if as_command else -number)
        inputs = emitter.values(node.inputs, node.name)
        self.jumps = True
        emitter.body.append(py.give(ast.Tuple([py.name(function), py.name(record), place, *inputs], py.LOAD)))
        return True

    def _branch(self, emitter: Emitter, node: Node, wanted_by: str, blamed: Blamed) -> list[Stmt]:
        return emitter.within(lambda: self._output_of(emitter, node, wanted_by, blamed))

    def _stands(self, emitter: Emitter, node: Invocation, *, as_command: bool) -> bool:
        """Write the instructions of the procedure that is called in the place of the call, if that can be."""
        survey, called = self._survey, node.procedure
        is_like = survey.never_outputs if as_command else survey.always_outputs
        if emitter.loops or self.minds or called in self._standing or called is self._procedure:
            return False
        if not (is_like(called) and is_like(self._procedure) and self._may_be_short(called)):
            return False
        body, sites, names, uncertain = (
            len(emitter.body),
            len(emitter.sites),
            emitter.names,
            emitter.uncertain,
        )
        emitter.names, emitter.uncertain = dict(names), set(uncertain)
        outer = emitter.procedure, emitter.kinds, emitter.has_test
        values = emitter.values(node.inputs, node.name)
        self._standing.append(called)
        try:
            if not self._may_stand(emitter, called):
                raise RefusedError("it cannot stand here")
            self._set_inputs(emitter, called, values)
            emitter.procedure = called
            emitter.has_test = False
            emitter.instructions(survey.body(called), tail=True)
            self.nothing(emitter, None)
        except RefusedError:
            del emitter.body[body:], emitter.sites[sites:]
            emitter.names, emitter.uncertain = names, uncertain
            return False
        finally:
            self._standing.pop()
            emitter.procedure, emitter.kinds, emitter.has_test = outer
        return True

    def _may_be_short(self, called: UserProcedure) -> bool:
        """Whether a procedure is short enough to be written where it is called, and does nothing of its own there."""
        within = list(self._survey.walk(self._survey.body(called)))
        self._stood += len(within)
        if self._stood > _MOST_NODES or len(self._standing) >= _MOST_DEEP:
            return False
        ends = [*self._survey.last(self._survey.body(called))]
        for node in within:
            if isinstance(node, OutputCall):
                ends += self._choices(node.inputs[0])
        if any(isinstance(node, Invocation) and node.procedure is called for node in ends):
            return False  # a loop by itself
        # An error that it throws is told of its caller.
        return not any(isinstance(node, Call) and node.primitive.name == "throw" for node in within)

    def _choices(self, node: Node) -> list[Node]:
        """The expressions that an expression comes to: those of an IFELSE, or itself."""
        if not isinstance(node, Call) or node.primitive.name not in ("if", "ifelse"):
            return [node]
        lines = [each.line for each in node.inputs[1:] if isinstance(each, Literal) and each.line is not None]
        return [end for line in lines for each in self._survey.parse(line) for end in self._choices(each)]

    def _begin_anew(self, emitter: Emitter, node: Invocation, *, as_command: bool) -> None:
        values = emitter.values(node.inputs, node.name)
        if self.minds:
            number = emitter.site(node, "output")
            emitter.body.append(py.assign("late", py.const(number if as_command else -number)))
        self._set_inputs(emitter, self._procedure, values)
        self.begins_anew = True
        emitter.body.append(ast.Continue())

    @staticmethod
    def _set_inputs(emitter: Emitter, procedure: UserProcedure, values: list[Expr]) -> None:
        changed = [
            (key, value)
            for key, value in zip(procedure.inputs, values, strict=True)
            if not (isinstance(value, ast.Name) and value.id == emitter.names.get(key))
        ]
        if len(changed) == 1:
            emitter.set_variable(*changed[0])
        elif changed:
            targets = [emitter.place(key) for key, _ in changed]
            made = ast.Tuple([value for _, value in changed], py.LOAD)
            emitter.body.append(ast.Assign([ast.Tuple(targets, py.STORE)], made))
