"""Procedures and lines of a program as Python's syntax, and that as code: what takes long, and so is kept."""

from __future__ import annotations

import ast
import hashlib
from typing import TYPE_CHECKING, Any, NamedTuple

from turtlewire.logo.compiler import python as py
from turtlewire.logo.compiler.emit import Emitter, is_simple
from turtlewire.logo.compiler.ending import ProcedureEnding
from turtlewire.logo.compiler.facts import Survey, local_names
from turtlewire.logo.compiler.kinds import Kinds
from turtlewire.logo.compiler.lines import LineWriter
from turtlewire.logo.compiler.roles import Namer, RefusedError
from turtlewire.logo.compiler.sites import LOOPS, identifier, primitive_name
from turtlewire.logo.compiler.store import Kept
from turtlewire.logo.syntax import Call
from turtlewire.logo.values import show

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.logo.compiler.facts import Facts
    from turtlewire.logo.compiler.sites import Site
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.procedures import Primitive, UserProcedure
    from turtlewire.logo.reader import Line
    from turtlewire.logo.syntax import Invocation, Literal
    from turtlewire.logo.values import Value


# Variables that primitives ask for.
_HEEDED = frozenset((
    "allowgetset", "buttonact", "caseignoredp", "commandline", "erract", "fullprintp", "keyact", "loadnoisily",
    "printdepthlimit", "printwidthlimit", "redefp", "startup", "unburyonedit", "usealternatenames",
))  # fmt: skip


class Written(NamedTuple):
    """A function that is written.

    Attributes:
        procedure: what it is made of; ``None``: a line of the program.
        kept: its code, and what it uses.
        sites: its instructions that can fail.
        lists: the lists that stand in it, by the name by which it finds each.
        calls: the procedures that it names.
    """

    procedure: UserProcedure | None
    kept: Kept
    sites: list[Site]
    lists: dict[str, Value]
    calls: list[UserProcedure]


class _Draft(NamedTuple):
    """A function before it is compiled; ``names``: its variables that are in Python locals."""

    tree: list[ast.stmt]
    sites: list[Site]
    names: dict[str, str]
    uses: _Uses


class _Uses:
    """What a function uses: to be there when it runs, also when it comes from the store."""

    def __init__(self, origin: int) -> None:
        self.origin = origin  # where in its file it begins
        self.primitives: dict[tuple[str, bool], None] = {}
        self.calls: dict[str, UserProcedure] = {}
        self.lists: dict[str, int] = {}
        self.values: dict[str, Value] = {}


class Writer(Namer):
    """Writes the functions of a workspace; good until something is defined.

    Args:
        logo: the workspace.
    """

    def __init__(self, logo: Interpreter) -> None:
        self._logo = logo
        self._survey = Survey(logo)
        self._uses = _Uses(0)
        self._drafts: dict[UserProcedure, _Draft] = {}
        self._jumped_to: dict[UserProcedure, set[UserProcedure]] = {}
        self._wanted: list[UserProcedure] = []
        self.refused: dict[UserProcedure, str] = {}

    # ------------------------------------------------------------------ what the compiler asks for

    def procedures(self, procedure: UserProcedure) -> list[Written]:
        """The functions of a procedure and of all that it reaches; those that are refused without code."""
        self._wanted = [procedure]
        self._drafts.clear()
        self._jumped_to.clear()
        for each in self._wanted:  # which grows
            if each.function is None and not each.is_refused and each not in self.refused:
                self._draft(each)
        drafts = {each: draft for each, draft in self._drafts.items() if each not in self.refused}
        refused = [
            Written(each, Kept(None, why, {}, [], [], []), [], {}, []) for each, why in self.refused.items()
        ]
        return refused + [_finished(each, draft, each.name) for each, draft in drafts.items()]

    def line(self, line: Line) -> Written:
        """The function of a line of the program that has a loop in it; without code when it is refused."""
        survey = self._survey
        nodes = survey.parse(line)
        facts = survey.facts_of(nodes)
        self._drafts.clear()
        self._wanted = []
        self._uses = _Uses(line.offsets[0] if line.offsets else 0)
        try:
            if not any(
                isinstance(node, Call) and node.primitive.name in LOOPS for node in survey.walk(nodes)
            ):
                raise RefusedError("no loop in it")
            self._refuse_unseen(facts)
            may_be_local = self._may_be_local(facts, survey.reached_from(facts))
            emitter = LineWriter(survey, nodes, facts, self, may_be_local).written()
        except RefusedError as refused:
            return Written(None, Kept(None, str(refused), {}, [], [], []), [], {}, [])
        tree: list[ast.stmt] = [py.function("line", [], emitter.body)]
        return _finished(None, _Draft(tree, emitter.sites, emitter.names, self._uses), "line")

    def sites_of(self, procedure: UserProcedure) -> list[Site]:
        """The instructions of a procedure that can fail, as numbered in its function."""
        return self._written(procedure).sites

    def source(self, procedure: UserProcedure) -> str | None:
        """The Python that a procedure becomes, as text; ``None`` when it is refused."""
        self._drafts.clear()
        self._wanted = []
        draft = self._draft(procedure)
        return ast.unparse(py.module(draft.tree)) if draft is not None else None

    # ------------------------------------------------------------------ procedures

    def _draft(self, procedure: UserProcedure) -> _Draft | None:
        if procedure in self.refused:
            return None
        try:
            draft = self._drafts[procedure] = self._written(procedure)
        except RefusedError as refused:
            self._refuse(procedure, str(refused))
            return None
        return draft

    def _refuse(self, procedure: UserProcedure, why: str) -> None:
        self.refused[procedure] = why
        self._drafts.pop(procedure, None)
        for each in self._jumped_to.get(procedure, ()):
            if each not in self.refused:
                self._refuse(each, f"it leaves its place to {procedure.name}")

    def _refuse_unseen(self, facts: Facts) -> None:
        """What the evaluator keeps in tables of its own, other procedures would not find."""
        for each in self._survey.reached_from(facts):
            found = self._survey.facts(each)
            if found.asks_count or found.asks_slot or found.asks_test:
                raise RefusedError(f"{each.name} asks for what its caller counts")

    def _written(self, procedure: UserProcedure) -> _Draft:
        survey = self._survey
        if not is_simple(procedure) or procedure.is_erased:
            raise RefusedError("inputs that can be left out")
        if self._logo.is_watched(procedure):
            raise RefusedError("it is traced or stepped")
        facts = survey.facts(procedure)
        self._refuse_unseen(facts)
        uses = self._uses = _Uses(procedure.title.offsets[0] if procedure.title is not None else 0)
        nodes = survey.body(procedure)
        may_be_local = self._may_be_local(facts, survey.reached(procedure))
        emitter = Emitter(survey, facts, self, may_be_local)
        name = identifier(procedure.name.lower())

        def jump_to(node: Invocation) -> tuple[str, str, int]:
            target = node.procedure
            if target in self.refused:
                raise RefusedError(f"it leaves its place to {target.name}")
            self._jumped_to.setdefault(target, set()).add(procedure)
            self._want(target)
            return f"q_{identifier(target.name.lower())}", f"r_{name}", emitter.site(node, "output")

        ending = ProcedureEnding(survey, procedure, jump_to, self._may_stand)
        emitter.ending = ending
        parameters: list[str] = []
        hidden: list[str] = []
        for key in procedure.inputs:
            parameter = f"{identifier(key)}_"
            if parameter in parameters:
                raise RefusedError("two inputs of one name")
            parameters.append(parameter)
            if may_be_local(key):
                emitter.names[key] = parameter
            else:
                hidden.append(key)
        emitter.binds_dynamically = bool(hidden)
        self._bind_locals(emitter, procedure, may_be_local)
        emitter.kinds = Kinds(
            survey, nodes, set(emitter.names).difference(procedure.inputs), facts.free.union(procedure.inputs)
        )
        if nodes:
            emitter.site(nodes[0])  # where it is when it is nowhere in particular
        body = emitter.within(lambda: self._body(emitter, procedure, nodes))
        if ending.begins_anew:
            body = [py.forever(body)]
            if ending.minds:
                body.insert(0, py.assign("late", py.const(0)))
        elif ending.minds:
            body.insert(0, py.assign("late", py.const(0)))
        if hidden:
            body = _bound(hidden, body)
        inner = py.function(f"q_{name}", parameters, body)
        tree: list[ast.stmt] = [inner]
        given: list[ast.expr] = [py.name(each) for each in parameters]
        result = py.walrus("result", py.call(f"q_{name}", *given))
        if ending.jumps:
            # The calls that it leaves to its caller are done here; those who leave theirs to it take it as it is.
            is_jump = py.has_type(result, "tuple")
            bounced = py.at(1, py.call("bounce", py.name("result")))
            answer = py.either(is_jump, bounced, py.name("result"))
            tree.append(py.function(f"p_{name}", parameters, [py.give(answer)]))
        else:
            tree.append(py.assign(f"p_{name}", py.name(f"q_{name}")))
        return _Draft(tree, emitter.sites, dict(emitter.names), uses)

    def _may_stand(self, emitter: Emitter, procedure: UserProcedure) -> bool:
        """Whether a procedure's instructions may stand in the function of another; then its variables are there.

        Raises:
            RefusedError: they may not, because of a variable.
        """
        survey, facts = self._survey, self._survey.facts(procedure)
        reached = survey.reached(procedure)
        if not is_simple(procedure) or procedure.is_erased or procedure in self.refused:
            return False
        if self._logo.is_watched(procedure) or any(survey.facts(each).moves for each in reached):
            return False  # what a limit sensor starts might define it anew
        may_be_local = self._may_be_local(facts, reached)
        for key in procedure.inputs:
            if not may_be_local(key):
                return False
            emitter.names[key] = f"{identifier(key)}_"
        if len({emitter.names[key] for key in procedure.inputs}) < len(procedure.inputs):
            return False
        self._bind_locals(emitter, procedure, may_be_local)
        own = {key for node in survey.body(procedure) if isinstance(node, Call) for key in _declared(node)}
        emitter.kinds = Kinds(
            survey,
            survey.body(procedure),
            own.difference(procedure.inputs),
            facts.free.union(procedure.inputs),
        )
        self._uses.calls[procedure.name.lower()] = procedure
        return True

    def _body(self, emitter: Emitter, procedure: UserProcedure, nodes: list[Any]) -> None:
        facts = emitter.facts
        if not facts.moves or len(nodes) < 2 or procedure in emitter.survey.reached(procedure):
            emitter.instructions(nodes, tail=True)
            emitter.ending.nothing(emitter, None)
            return
        # How far it is, for those who watch: what moves the robot can take long.
        level = py.name("level")
        place = ast.Subscript(level, py.const(0), py.STORE)

        def watched() -> None:
            for index, node in enumerate(nodes):
                if index:
                    emitter.body.append(py.when(py.is_some(level), [ast.Assign([place], py.const(index))]))
                emitter.instruction(node, tail=False)
            emitter.ending.nothing(emitter, None)

        body = emitter.within(watched)
        leave = py.when(py.is_some(level), [py.do(py.call("leave"))])
        emitter.body.append(py.assign("level", py.call("enter", py.const(len(nodes)))))
        emitter.body.append(ast.Try(body, [], [], [leave]))

    def _bind_locals(
        self, emitter: Emitter, procedure: UserProcedure, may_be_local: Callable[[str], bool]
    ) -> None:
        """Local variables are in Python locals from the beginning: so nothing may have meant another's before."""
        survey = self._survey
        seen = set(procedure.inputs)
        nodes = survey.body(procedure)
        for index, node in enumerate(nodes):
            if not isinstance(node, Call) or node.primitive.name not in ("local", "localmake"):
                continue
            for key in local_names(node):
                if key is None or not may_be_local(key):
                    raise RefusedError("a local variable that other procedures see")
                if key not in seen and key in survey.facts_of([*nodes[:index], *node.inputs[1:]]).free:
                    raise RefusedError("a local variable that was another one before")
                if key not in emitter.names:
                    emitter.names[key] = f"{identifier(key)}_"
                emitter.uncertain.add(emitter.names[key])
                seen.add(key)

    def _may_be_local(self, facts: Facts, reached: frozenset[UserProcedure]) -> Callable[[str], bool]:
        survey = self._survey
        if facts.touches_any or any(survey.facts(each).touches_any for each in reached):
            return lambda _: False
        seen: set[str] = set()
        for each in reached:
            seen |= survey.facts(each).free
        return lambda key: key not in seen and key not in _HEEDED

    # ------------------------------------------------------------------ names

    def _want(self, procedure: UserProcedure) -> None:
        self._uses.calls[procedure.name.lower()] = procedure
        if procedure not in self._wanted:
            self._wanted.append(procedure)

    def primitive(self, primitive: Primitive, *, moves: bool) -> str:
        """The name of a primitive's function."""
        self._uses.primitives[primitive.name, moves] = None
        return primitive_name(primitive.name, moves=moves)

    def procedure(self, procedure: UserProcedure, *, as_command: bool) -> str:
        """The name of a procedure's function."""
        self._want(procedure)
        return f"{'c' if as_command else 'p'}_{identifier(procedure.name.lower())}"

    def constant(self, value: Any, node: Literal) -> str:
        """The name of a list that stands in the program."""
        if not value:
            return "NIL"
        behind = node.place[1] - self._uses.origin if node.place is not None else 0
        content = hashlib.sha256(show(value).encode(errors="surrogatepass")).hexdigest()[:12]
        name = f"k{content}_{behind}".replace("-", "m")
        self._uses.lists[name] = behind
        self._uses.values[name] = value
        return name

    def always_outputs(self, procedure: UserProcedure) -> bool:
        """Whether a procedure outputs whenever it ends."""
        return self._survey.always_outputs(procedure)

    def never_outputs(self, procedure: UserProcedure) -> bool:
        """Whether a procedure never outputs."""
        return self._survey.never_outputs(procedure)


def _declared(node: Call) -> list[str]:
    """The names that a LOCAL or LOCALMAKE gives."""
    if node.primitive.name not in ("local", "localmake"):
        return []
    return [key for key in local_names(node) if key is not None]


def _finished(procedure: UserProcedure | None, draft: _Draft, title: str) -> Written:
    code = compile(py.module(draft.tree), f"<{title}>", "exec")
    uses = draft.uses
    lists = list(uses.lists.items())
    kept = Kept(code, "", draft.names, list(uses.primitives), list(uses.calls), lists)
    return Written(procedure, kept, draft.sites, uses.values, list(uses.calls.values()))


def _bound(keys: list[str], body: list[ast.stmt]) -> list[ast.stmt]:
    """A body within which variables have the values of inputs, and those of before again after it."""
    before: list[ast.stmt] = []
    after: list[ast.stmt] = []
    for key in keys:
        name, old = f"{identifier(key)}_", f"old_{identifier(key)}"
        place = ast.Subscript(py.name("V"), py.const(key), py.STORE)
        get = ast.Call(ast.Attribute(py.name("V"), "get", py.LOAD), [py.const(key)], [])
        before += [py.assign(old, get), ast.Assign([place], py.name(name))]
        pop = ast.Call(ast.Attribute(py.name("V"), "pop", py.LOAD), [py.const(key), py.NONE], [])
        restore = ast.Assign([place], py.name(old))
        after.append(py.when(py.is_none(py.name(old)), [py.do(pop)], [restore]))
    return [*before, ast.Try(body, [], [], after)]
