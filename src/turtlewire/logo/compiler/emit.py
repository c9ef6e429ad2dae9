"""Logo procedures as Python functions: instructions become statements, operations expressions.

An operation that needs statements of its own (MAP) puts them before the statement that it stands in; what is evaluated
before it moves there too, so that everything happens in Logo's order.
"""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from turtlewire.logo.compiler import python as py
from turtlewire.logo.compiler.facts import MOVING, RUNS, chapter_of, is_plain, literal_name
from turtlewire.logo.compiler.kinds import Kinds
from turtlewire.logo.compiler.roles import Ending, RefusedError
from turtlewire.logo.compiler.sites import Operand, Site, identifier
from turtlewire.logo.syntax import Call, Invocation, Literal, Node, Variable
from turtlewire.logo.values import EXACT, Array

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from turtlewire.logo.compiler.facts import Facts, Survey
    from turtlewire.logo.compiler.python import Expr, Stmt
    from turtlewire.logo.compiler.roles import Namer
    from turtlewire.logo.procedures import UserProcedure
    from turtlewire.logo.reader import Line

# Of whom it is said that they have output nothing, and who wanted it.
Blamed = tuple[Node, str]

_MOST_INPUTS = 12
_MEASURED = frozenset(("forward", "back", "right", "left"))


class Emitter:
    """Makes one function.

    Args:
        survey: what is known of all procedures.
        facts: what is known of this one.
        namer: gives the Python name of a procedure, primitive or constant, by which the function finds it.
        may_be_local: whether a variable can be kept in a Python local.
    """

    def __init__(
        self, survey: Survey, facts: Facts, namer: Namer, may_be_local: Callable[[str], bool]
    ) -> None:
        self.survey = survey
        self.facts = facts
        self.namer = namer
        self.may_be_local = may_be_local
        self.sites: list[Site] = []
        self.body: list[Stmt] = []
        self.names: dict[str, str] = {}  # variables in Python locals
        self.uncertain: set[str] = set()  # Python locals that may have no value yet
        self.kinds = Kinds(survey)  # what kinds of numbers its variables hold
        self.slots: list[str] = []  # what ? stands for
        self.count = ""  # what REPCOUNT and # stand for
        self.asked_count = False
        self.has_test = False
        self.binds_dynamically = False  # whether other procedures see its variables
        self.loops = 0  # how many Python loops are open
        self.is_line = False  # whether it is a line of the program, and no procedure
        self.procedure: UserProcedure | None = None  # whose instructions are written, if it is another one's
        self.ending: Ending = Ending()
        self._names_made = 0

    # ------------------------------------------------------------------ small things

    def temp(self, stem: str = "t") -> str:
        """A new Python variable."""
        self._names_made += 1
        return f"{stem}{self._names_made}"

    def site(self, node: Node, wanted_by: str = "", operands: tuple[Operand, ...] = ()) -> int:
        """The number of an instruction that can fail."""
        self.sites.append(Site(node, wanted_by, operands, self.procedure))
        return len(self.sites)

    def within(self, work: Callable[[], None]) -> list[Stmt]:
        """The statements that this work puts down, on a list of their own."""
        outer, self.body = self.body, []
        try:
            work()
            return self.body
        finally:
            self.body = outer

    def is_certain(self, value: Expr) -> bool:
        """Whether a value is there, whatever happens."""
        return isinstance(value, ast.Constant) or (
            isinstance(value, ast.Name) and value.id not in self.uncertain
        )

    def kept(self, value: Expr, *, always: bool = False) -> Expr:
        """A value that can be named more than once; ``always``: and is certain."""
        if isinstance(value, ast.Constant | ast.Name) and not (always and not self.is_certain(value)):
            return value
        name = self.temp()
        self.body.append(py.assign(name, value))
        return py.name(name)

    def named(self, value: Expr) -> tuple[Expr, Expr]:
        """A value for its first use, and for those after it in the same expression."""
        if isinstance(value, ast.Constant | ast.Name):
            return value, value
        name = self.temp()
        return py.walrus(name, value), py.name(name)

    def operand(self, node: Node, value: Expr) -> tuple[Expr, Operand]:
        """A value, such that it can be found again when what is done with it fails."""
        if isinstance(value, ast.Constant):
            return value, Operand(node, "constant", value.value)
        if isinstance(value, ast.Name):
            return value, Operand(node, "local", value.id)
        if isinstance(value, ast.NamedExpr):
            return value, Operand(node, "local", value.target.id)
        name = (
            self.temp()
        )  # also for what other procedures see: it may be another's again when the error is told
        return py.walrus(name, value), Operand(node, "local", name)

    def values(self, nodes: Sequence[Node], wanted_by: str) -> list[Expr]:
        """The values of inputs, in their order."""
        return self.in_order(nodes, lambda node: self.value(node, wanted_by))

    def in_order(self, nodes: Sequence[Node], make: Callable[[Node], Expr]) -> list[Expr]:
        """Several expressions, such that each is evaluated after those before it."""
        made: list[Expr] = []
        for node in nodes:
            before = len(self.body)
            value = make(node)
            if len(self.body) > before:  # it needs statements: what comes before it must be done before them
                for index, each in enumerate(made):
                    if not isinstance(each, ast.Constant):
                        name = self.temp()
                        self.body.insert(before, py.assign(name, each))
                        before += 1
                        made[index] = py.name(name)
            made.append(value)
        return made

    def operands(self, node: Call) -> tuple[list[Expr], tuple[Operand, ...]]:
        """The inputs of an operation that may fail in place."""
        pairs = [
            self.operand(each, value)
            for each, value in zip(node.inputs, self.values(node.inputs, node.name), strict=True)
        ]
        return [pair[0] for pair in pairs], tuple(pair[1] for pair in pairs)

    def block(self, line: Line, *, tail: bool = False, loop: bool = False) -> list[Stmt]:
        """The instructions of a list, as statements; ``loop``: of a loop."""
        nodes = self.survey.parse(line)
        self.loops += loop
        has_test = self.has_test
        try:
            return self.within(lambda: self.instructions(nodes, tail=tail))
        finally:
            self.loops -= loop
            self.has_test = has_test  # nobody knows whether the list is run

    def instructions(self, nodes: Sequence[Node], *, tail: bool = False) -> None:
        """Put down the statements of instructions."""
        for index, node in enumerate(nodes):
            self.instruction(node, tail=tail and index == len(nodes) - 1)

    @staticmethod
    def line(node: Node) -> Line:
        """A list that stands in the program."""
        if isinstance(node, Literal) and node.line is not None:
            return node.line
        raise RefusedError("a list that is computed is run")

    # ------------------------------------------------------------------ instructions

    def instruction(self, node: Node, *, tail: bool) -> None:
        """Put down one instruction; ``tail``: nothing of the procedure comes after it."""
        from turtlewire.logo.compiler import control

        if isinstance(node, Invocation):
            control.invoke(self, node, tail=tail)
            return
        if isinstance(node, Call):
            command = control.COMMANDS.get(node.primitive.name)
            if command is not None:
                command(self, node, tail)
                return
            if self._is_command(node):
                self._command(node)
                return
        number = self.site(node)
        self.body.append(py.do(py.at(number, py.call("unused", self.value(node, "")))))

    @staticmethod
    def _is_command(node: Call) -> bool:
        return node.primitive.function.__annotations__.get("return") == "None"

    def _command(self, node: Call) -> None:
        chapter = chapter_of(node)
        if not is_plain(node.primitive.name, chapter):
            raise RefusedError(f"{node.name} is the evaluator's")
        number = self.site(node)
        made = py.at(number, self._primitive(node))
        if chapter not in MOVING:
            self.body.append(py.do(made))
            return
        # A limit sensor may have ended it, and what is run then may end the procedure.
        result = self.temp()
        ended = [py.give(py.call("finished", py.name(result)))]
        self.body.append(py.when(py.is_some(py.walrus(result, made)), ended))

    def _primitive(self, node: Call) -> Expr:
        primitive = node.primitive
        inputs = self.values(node.inputs, node.name)
        name = self.namer.primitive(primitive, moves=chapter_of(node) in MOVING)
        if primitive.maximum_inputs < 0:
            return py.call(name, py.name("logo"), ast.List(inputs, py.LOAD))
        if primitive.name in _MEASURED:  # a float takes less time, and is as good
            inputs = [_as_float(each) for each in inputs]
        return py.call(name, py.name("logo"), *inputs)

    # ------------------------------------------------------------------ values

    def value(self, node: Node, wanted_by: str, blamed: Blamed | None = None) -> Expr:
        """The value of an expression; where there is none, that is an error, of the expression or who is blamed."""
        if isinstance(node, SlotNode):
            return py.name(node.slot)
        if isinstance(node, Literal):
            return self.literal(node)
        if isinstance(node, Variable):
            return self.variable(node)
        if isinstance(node, Invocation):
            made = self.invocation(node, wanted_by)
            if self.namer.always_outputs(node.procedure):
                return made
            return self.needed(*(blamed or (node, wanted_by)), made)
        if isinstance(node, Call):
            return self.operation(node, wanted_by, blamed)
        raise RefusedError("it is not understood yet")

    def result(self, line: Line, wanted_by: str, blamed: Blamed | None = None) -> Expr:
        """The value that a list outputs: that of its last expression."""
        nodes = self.survey.parse(line)
        if not nodes:
            raise RefusedError("a list that outputs nothing")
        self.instructions(nodes[:-1])
        return self.value(nodes[-1], wanted_by, blamed)

    def raw(self, node: Node, wanted_by: str) -> Expr:
        """The value of an expression, ``None`` where there is none."""
        if isinstance(node, Invocation):
            return self.invocation(node, wanted_by)
        return self.value(node, wanted_by)

    def literal(self, node: Literal) -> Expr:
        """What stands in the program."""
        value = node.value
        if type(value) in (int, float, str):
            return py.const(value)  # type: ignore[arg-type]
        if isinstance(value, Array):
            raise RefusedError("an array that stands in the program")
        return py.name(self.namer.constant(value, node))

    def variable(self, node: Variable) -> Expr:
        """A variable's value."""
        number = self.site(node)
        local = self.names.get(node.key)
        made = py.name(local) if local is not None else py.index(py.name("V"), py.const(node.key))
        return py.at(number, made)  # type: ignore[no-any-return]

    def place(self, key: str) -> Expr:
        """Where a variable's value is put."""
        local = self.names.get(key)
        if local is not None:
            return ast.Name(local, py.STORE)
        return ast.Subscript(py.name("V"), py.const(key), py.STORE)

    def set_variable(self, key: str, value: Expr) -> None:
        """Give a variable a value."""
        self.body.append(ast.Assign([self.place(key)], value))

    def invocation(self, node: Invocation, wanted_by: str, *, as_command: bool = False) -> Expr:
        """A call of a user's procedure."""
        if len(node.inputs) > _MOST_INPUTS or not is_simple(node.procedure):
            raise RefusedError(f"{node.name} takes inputs that can be left out")
        inputs = self.values(node.inputs, node.name)
        number = self.site(node, wanted_by)
        return py.at(number, py.call(self.namer.procedure(node.procedure, as_command=as_command), *inputs))  # type: ignore[no-any-return]

    def needed(self, node: Node, wanted_by: str, value: Expr) -> Expr:
        """A value; an error where there is none."""
        number = self.site(node, wanted_by)
        name = self.temp()
        silent = py.at(number, py.call("silent"))
        return py.either(py.is_some(py.walrus(name, value)), py.name(name), silent)

    def operation(self, node: Call, wanted_by: str, blamed: Blamed | None = None) -> Expr:
        """A primitive that outputs."""
        from turtlewire.logo.compiler import control, inline

        name = node.primitive.name
        made = inline.OPERATIONS.get(name)
        if made is not None:
            return made(self, node)
        if name in inline.CONDITIONS:
            return py.either(inline.CONDITIONS[name](self, node), py.const("true"), py.const("false"))
        runs = control.CHOICES.get(name)
        if runs is not None:
            return runs(self, node, blamed or (node, wanted_by))
        made = control.OPERATIONS.get(name)
        if made is not None:
            return made(self, node)
        if self._is_command(node) or name in RUNS or not is_plain(name, chapter_of(node)):
            raise RefusedError(f"{node.name} is the evaluator's")
        number = self.site(node, wanted_by)
        return py.at(number, self._primitive(node))  # type: ignore[no-any-return]

    def condition(self, node: Node, asker: Call, *, in_list: bool = False) -> Expr:
        """The truth of an expression, as a Python condition; ``in_list``: it is all that a list holds."""
        from turtlewire.logo.compiler import inline

        if isinstance(node, Call):
            made = inline.CONDITIONS.get(node.primitive.name)
            if made is not None:
                return made(self, node)
        if isinstance(node, Literal):
            if node.value in ("true", "false"):
                return ast.Constant(value=node.value == "true")
            if node.line is not None and not in_list:
                nodes = self.survey.parse(node.line)
                if len(nodes) == 1:
                    return self.condition(nodes[0], asker, in_list=True)
            raise RefusedError("a condition that is none")
        first, again = self.named(self.raw(node, asker.name))
        return self.truth(first, again, node, asker, in_list=in_list)

    def truth(self, first: Expr, again: Expr, node: Node, asker: Call, *, in_list: bool = False) -> Expr:
        """The truth of a value that is named once, and then again."""
        self.sites.append(Site(node, asker.name, (), self.procedure, asker))
        number = len(self.sites)
        is_true = py.compare(first, ast.Eq(), py.const("true"))
        is_other = py.compare(again, ast.NotEq(), py.const("false"))
        found = py.call("truth_from_list" if in_list else "truth", again)
        return py.any_of(is_true, py.all_of(is_other, py.at(number, found)))

    def bind(self, key: str) -> str:
        """A Python local for a variable."""
        return self.temp(f"{identifier(key)}_")


def _as_float(value: Expr) -> Expr:
    is_whole = isinstance(value, ast.Constant) and type(value.value) is int and abs(value.value) <= EXACT
    return py.const(float(value.value)) if is_whole else value  # type: ignore[attr-defined]


def is_simple(procedure: UserProcedure) -> bool:
    """Whether a procedure has all of its inputs always, and is no macro."""
    return not (procedure.optional or procedure.rest or procedure.is_macro)


class SlotNode(Literal):
    """What a template's slot holds, as an input of a procedure that is named."""

    __slots__ = ("slot",)

    def __init__(self, slot: str) -> None:
        super().__init__("", None)
        self.slot = slot


def key_of(node: Node) -> str:
    """The variable's name that stands in the program."""
    key = literal_name(node)
    if key is None:
        raise RefusedError("a variable whose name is computed")
    return key
