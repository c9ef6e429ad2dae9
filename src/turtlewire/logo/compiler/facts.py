"""What can be known of procedures before they run: which variables they touch, and whom they call.

Variables are dynamically scoped: a procedure sees those of its callers. One can be kept in a Python local only when no
procedure that is reached from there, by whatever way, means it by a name of its own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.logo.errors import LogoError
from turtlewire.logo.procedures import UserProcedure
from turtlewire.logo.reader import Line
from turtlewire.logo.syntax import Call, Failure, Invocation, Literal, Node, OutputCall, Parser, Variable
from turtlewire.logo.tokens import tokenize
from turtlewire.logo.values import plain, to_text

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.procedures import Primitive

# The chapters whose primitives only take values and give one: they touch no variables, and run no lists.
_PLAIN_CHAPTERS = frozenset(("arithmetic", "arrays", "data", "graphics", "logic", "predicates", "robot"))
# The chapters whose commands take the robot's time.
MOVING = frozenset(("graphics", "robot"))
_PLAIN = frozenset((
    "print", "show", "type", "gprop", "pprop", "remprop", "plist", "ignore", "throw", "procedurep", "primitivep",
    "definedp",
))  # fmt: skip
_NOT_PLAIN = frozenset(("onlimit", "onstop", "tell", "ask", "each", "who", "push", "pop", "queue", "{}"))
# Control primitives, and which of their inputs they run when it is a list that stands in the program.
RUNS = {
    "if": (1, 2), "ifelse": (1, 2), "iftrue": (0,), "iffalse": (0,), "run": (0,), "repeat": (1,), "forever": (0,),
    "for": (1,), "while": (0, 1), "until": (0, 1), "do.while": (0, 1), "do.until": (0, 1), "catch": (1,),
}  # fmt: skip
# What looks for the truth runs a list that is to say it: which inputs.
ASKS = {"if": 1, "ifelse": 1, "test": 1, "not": 1, "and": None, "or": None}
# Templates: which input is one.
TEMPLATES = {"map": 0, "filter": 0, "find": 0, "reduce": 0, "foreach": -1}
_NAMED = {"make": 0, "localmake": 0, "thing": 0, "name": 1}
_HARMLESS = frozenset(
    ("stop", "output", "test", "repcount", "#", "?", "local", "localmake", "make", "name", "thing")
)


# Ways of ending a procedure without a value.
_ENDS = frozenset(("stop", ".maybeoutput"))
# Primitives that run a list in their own place, and from which input on.
_LEADS_ON = {"if": 1, "ifelse": 1, "iftrue": 0, "iffalse": 0, "run": 0}


class Facts:
    """What a procedure does, by itself.

    Attributes:
        free: variables that it means and does not bind.
        calls: procedures that it names.
        touches_any: whether it may mean any variable and call any procedure, because it runs lists that it computes.
        asks_count: whether it asks for REPCOUNT outside of a REPEAT of its own.
        asks_slot: whether it asks for ``?`` outside of a template of its own.
        asks_test: whether it may ask for the TEST of its caller.
        moves: whether it moves the robot.
    """

    __slots__ = ("asks_count", "asks_slot", "asks_test", "calls", "free", "moves", "touches_any")

    def __init__(self) -> None:
        self.free: set[str] = set()
        self.calls: set[UserProcedure] = set()
        self.touches_any = False
        self.asks_count = False
        self.asks_slot = False
        self.asks_test = False
        self.moves = False


def is_plain(name: str, chapter: str) -> bool:
    """Whether a primitive only takes values and gives one."""
    return name in _PLAIN or (chapter in _PLAIN_CHAPTERS and name not in _NOT_PLAIN)


def chapter_of(node: Call) -> str:
    """The chapter of the manual that a primitive is of."""
    return node.primitive.function.__module__.rpartition(".")[2]


def literal_name(node: Node) -> str | None:
    """The variable's name that stands in the program, ``None`` when it is computed."""
    if isinstance(node, Literal) and isinstance(node.value, str | int | float):
        return plain(to_text(node.value)).lower()
    return None


def local_names(node: Call) -> list[str | None]:
    """The names that a LOCAL or LOCALMAKE gives; ``None`` for one that is computed."""
    if node.primitive.name == "localmake":
        return [literal_name(node.inputs[0])]
    names: list[str | None] = []
    for each in node.inputs:
        line = each.line if isinstance(each, Literal) else None
        if line is None:
            names.append(literal_name(each))
        else:
            names += [plain(item).lower() if isinstance(item, str) else None for item in line.items]
    return names


class Survey:
    """The facts of procedures, and of all that they reach; good until something is defined."""

    def __init__(self, logo: Interpreter) -> None:
        self._logo = logo
        self._bodies: dict[UserProcedure, list[Node]] = {}
        self._facts: dict[UserProcedure, Facts] = {}
        self._has_test = False
        self._reached: dict[UserProcedure, frozenset[UserProcedure]] = {}

    def parse(self, line: Line) -> list[Node]:
        """The instructions of a list, as they are understood now."""
        try:
            tokens = tokenize(line)
        except LogoError as error:
            return [Failure(error, None)]
        return Parser(tokens, self._logo.procedures, self._logo.remember).parse()

    def body(self, procedure: UserProcedure) -> list[Node]:
        """The instructions of a procedure."""
        found = self._bodies.get(procedure)
        if found is None:
            found = self._bodies[procedure] = [node for line in procedure.body for node in self.parse(line)]
        return found

    def facts(self, procedure: UserProcedure) -> Facts:
        """What a procedure does by itself."""
        found = self._facts.get(procedure)
        if found is None:
            found = self._facts[procedure] = self.facts_of(self.body(procedure), procedure.inputs)
            if procedure.optional or procedure.rest:
                found.touches_any = True
        return found

    def facts_of(self, nodes: Iterable[Node], inputs: Iterable[str] = ()) -> Facts:
        """What instructions do."""
        facts = Facts()
        self._has_test = False
        self._look(nodes, facts, frozenset(inputs), in_repeat=False, in_template=False)
        return facts

    def reached(self, procedure: UserProcedure) -> frozenset[UserProcedure]:
        """The procedures that are reached from one, itself among them only if it is called again."""
        found = self._reached.get(procedure)
        if found is None:
            found = self._reached[procedure] = self.reached_from(self.facts(procedure))
        return found

    def reached_from(self, facts: Facts) -> frozenset[UserProcedure]:
        """The procedures that instructions with these facts reach."""
        seen: set[UserProcedure] = set()
        pending = list(facts.calls)
        while pending:
            each = pending.pop()
            if each not in seen:
                seen.add(each)
                pending += self.facts(each).calls
        return frozenset(seen)

    def procedure(self, name: str) -> Primitive | UserProcedure | None:
        """What a name stands for."""
        return self._logo.procedures.get(name)

    def walk(self, nodes: Iterable[Node]) -> Iterator[Node]:
        """All nodes within instructions, those of lists that stand in the program and are run there among them."""
        pending = list(nodes)
        while pending:
            node = pending.pop()
            yield node
            if not isinstance(node, Call | Invocation):
                continue
            pending += node.inputs
            name = node.primitive.name if isinstance(node, Call) else ""
            if name in RUNS or name in ASKS or name in TEMPLATES:
                for each in node.inputs:
                    if isinstance(each, Literal) and each.line is not None:
                        pending += self.parse(each.line)

    def last(self, nodes: list[Node]) -> Iterator[Node]:
        """The instructions after which nothing of the procedure comes."""
        if not nodes:
            return
        node = nodes[-1]
        if isinstance(node, Call) and node.primitive.name in _LEADS_ON:
            for each in node.inputs[_LEADS_ON[node.primitive.name] :]:
                if isinstance(each, Literal) and each.line is not None:
                    yield from self.last(self.parse(each.line))
        else:
            yield node

    def always_outputs(self, procedure: UserProcedure) -> bool:
        """Whether a procedure outputs whenever it ends."""
        nodes = self.body(procedure)
        if self.facts(procedure).touches_any or not self._ends_by_output(nodes):
            return False
        return not any(isinstance(node, Call) and node.primitive.name in _ENDS for node in self.walk(nodes))

    def _ends_by_output(self, nodes: list[Node]) -> bool:
        node = nodes[-1] if nodes else None
        if isinstance(node, OutputCall):
            return node.primitive.name == "output"
        if not isinstance(node, Call) or node.primitive.name not in ("if", "ifelse") or len(node.inputs) != 3:
            return False
        return all(
            isinstance(each, Literal)
            and each.line is not None
            and self._ends_by_output(self.parse(each.line))
            for each in node.inputs[1:]
        )

    def never_outputs(self, procedure: UserProcedure) -> bool:
        """Whether a procedure never outputs."""
        if self.facts(procedure).touches_any:
            return False
        return not any(
            isinstance(node, Call) and node.primitive.name in ("output", ".maybeoutput")
            for node in self.walk(self.body(procedure))
        )

    # ------------------------------------------------------------------ looking through instructions

    def _look(
        self,
        nodes: Iterable[Node],
        facts: Facts,
        bound: frozenset[str],
        *,
        in_repeat: bool,
        in_template: bool,
    ) -> None:
        has_test = self._has_test
        for node in nodes:
            if isinstance(node, Literal):
                continue
            if isinstance(node, Variable):
                if node.key not in bound:
                    facts.free.add(node.key)
            elif isinstance(node, Invocation):
                facts.calls.add(node.procedure)
                facts.touches_any |= node.procedure.is_macro
                self._look(node.inputs, facts, bound, in_repeat=in_repeat, in_template=in_template)
            elif isinstance(node, Call):
                bound = self._look_at_call(node, facts, bound, in_repeat=in_repeat, in_template=in_template)
            else:  # what cannot be understood yet
                facts.touches_any = True
        self._has_test = has_test  # nobody knows whether a list is run

    def _look_at_call(
        self, node: Call, facts: Facts, bound: frozenset[str], *, in_repeat: bool, in_template: bool
    ) -> frozenset[str]:
        name, inputs = node.primitive.name, node.inputs
        if name in ASKS:
            for each in inputs[: ASKS[name]]:
                if isinstance(each, Literal) and each.line is not None:
                    nodes = self.parse(each.line)
                    self._look(nodes, facts, bound, in_repeat=in_repeat, in_template=in_template)
        if name == "repcount" or name == "#":
            facts.asks_count |= not in_repeat and not (name == "#" and in_template)
        elif name == "?":
            facts.asks_slot |= not in_template
        elif name == "?rest":
            facts.touches_any = True
        elif name == "test":
            self._has_test = True
        elif name in _NAMED or name == "local":
            keys = (
                local_names(node) if name in ("local", "localmake") else [literal_name(inputs[_NAMED[name]])]
            )
            for key in keys:
                if key is None:
                    facts.touches_any = True
                elif name in ("local", "localmake"):
                    self._look(inputs, facts, bound, in_repeat=in_repeat, in_template=in_template)
                    return bound | {key for key in keys if key}
                elif key not in bound:
                    facts.free.add(key)
        elif name in RUNS:
            facts.asks_test |= name in ("iftrue", "iffalse") and not self._has_test
            self._look_at_lists(node, RUNS[name], facts, bound, in_repeat or name == "repeat", in_template)
            if name == "for":
                return bound
        elif name in TEMPLATES:
            template = inputs[TEMPLATES[name]]
            if isinstance(template, Literal) and template.line is not None and not _is_lambda(template.line):
                nodes = self.parse(template.line)
                self._look(nodes, facts, bound, in_repeat=in_repeat, in_template=True)
            elif (key := literal_name(template)) is not None:
                called = self._logo.procedures.get(key)
                if isinstance(called, UserProcedure):
                    facts.calls.add(called)
                facts.touches_any |= called is None
            else:
                facts.touches_any = True
        elif not is_plain(name, chapter_of(node)) and name not in _HARMLESS:
            facts.touches_any = True
        facts.moves |= chapter_of(node) in MOVING
        self._look(inputs, facts, bound, in_repeat=in_repeat, in_template=in_template)
        return bound

    def _look_at_lists(
        self,
        node: Call,
        which: Iterable[int],
        facts: Facts,
        bound: frozenset[str],
        in_repeat: bool,
        in_template: bool,
    ) -> None:
        if node.primitive.name == "for":
            control = node.inputs[0]
            line = control.line if isinstance(control, Literal) else None
            if line is None or not line.items or not isinstance(line.items[0], str):
                facts.touches_any = True
                return
            for index in range(1, len(line.items)):
                nodes = self.parse(as_line(line, index))
                self._look(nodes, facts, bound, in_repeat=in_repeat, in_template=in_template)
            bound |= {plain(line.items[0]).lower()}
        for index in which:
            if index >= len(node.inputs):
                continue
            each = node.inputs[index]
            if isinstance(each, Literal):
                if each.line is not None:
                    nodes = self.parse(each.line)
                    self._look(nodes, facts, bound, in_repeat=in_repeat, in_template=in_template)
            else:
                facts.touches_any = True


def as_line(line: Line, index: int) -> Line:
    """An item of a list as a line of its own."""
    item = line.items[index]
    return item if isinstance(item, Line) else Line((item,), line.source, line.offsets[index : index + 1])


def _is_lambda(line: Line) -> bool:
    return bool(line.items) and isinstance(line.items[0], Line | list)
