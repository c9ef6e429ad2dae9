"""Which procedures are compiled, when, and together with which; and what is known of those that are."""

from __future__ import annotations

import ast
import hashlib
from typing import TYPE_CHECKING, Any, NamedTuple

from turtlewire.logo.calls import invoke
from turtlewire.logo.compiler import python as py
from turtlewire.logo.compiler.emit import Emitter, Namer, RefusedError, identifier, is_simple
from turtlewire.logo.compiler.ending import ProcedureEnding
from turtlewire.logo.compiler.facts import Survey, local_names
from turtlewire.logo.compiler.fast import FAST
from turtlewire.logo.compiler.faults import Record, innermost, translated
from turtlewire.logo.compiler.runtime import helpers
from turtlewire.logo.compiler.store import Kept, Store
from turtlewire.logo.events import watching_limits
from turtlewire.logo.primitives import PRIMITIVES
from turtlewire.logo.procedures import Primitive, UserProcedure
from turtlewire.logo.syntax import Call, Invocation, Literal
from turtlewire.logo.values import show

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import CodeType, FrameType

    from turtlewire.logo.compiler.emit import Site
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.reader import Line
    from turtlewire.logo.syntax import Node
    from turtlewire.logo.tokens import Place
    from turtlewire.logo.values import Value

_LOOPS = frozenset(
    (
        "repeat",
        "forever",
        "for",
        "while",
        "until",
        "do.while",
        "do.until",
        "foreach",
        "map",
        "filter",
        "reduce",
    )
)


class _Uses:
    """What a function uses, to be found again when it comes from the store."""

    def __init__(self) -> None:
        self.primitives: dict[tuple[str, bool], None] = {}
        self.calls: dict[str, None] = {}
        self.lists: dict[str, int] = {}


class _Draft(NamedTuple):
    """A function that is written and not yet compiled; ``names``: its variables that are in Python locals."""

    procedure: UserProcedure | None
    name: str
    tree: list[ast.stmt]
    sites: list[Site]
    names: dict[str, str]
    uses: _Uses | None = None  # None: it cannot be kept


class Compiler(Namer):
    """Compiles the procedures of a workspace.

    Args:
        logo: the workspace.
        is_used: whether anything is compiled at all.
        store: where compiled procedures are kept for the next time, if they are.
    """

    def __init__(self, logo: Interpreter, *, is_used: bool, store: Store | None = None) -> None:
        self._logo = logo
        self._store = store
        self._texts: list[str] | None = None  # of all procedures; None: not asked yet
        self._kept: dict[str, Kept] = {}
        self._is_new = False  # whether there is something to keep
        self._uses = _Uses()
        self._origin = 0  # where in its file the procedure begins that is being written
        self._is_used = is_used
        self._is_fresh = False  # whether nothing has been found out since the last definition
        self._globals: dict[str, Any] = helpers(logo)
        self._records: dict[CodeType, Record] = {}
        self._jumps: list[tuple[Site, bool]] = []
        self._globals["jumps"] = self._jumps
        self._moving: set[str] = set()
        self._survey = Survey(logo)
        self._drafts: dict[UserProcedure, _Draft] = {}
        self._refused: dict[UserProcedure, str] = {}
        self._jumped_to: dict[UserProcedure, set[UserProcedure]] = {}
        self._wanted: list[UserProcedure] = []

    # ------------------------------------------------------------------ what the evaluator asks for

    def function(self, procedure: UserProcedure) -> Callable[..., Any] | None:
        """The function of a procedure; ``None`` when it is the evaluator's."""
        self._is_fresh = False
        is_to_come = procedure.function is None and not procedure.is_refused and self._is_used
        if is_to_come and (self._store is None or not self._install(procedure)):
            self._compile(procedure)
        return procedure.function

    def line(self, line: Line) -> Callable[[], Any] | None:
        """The function of a line of the program that has a loop in it; ``None`` when it is the evaluator's."""
        if not self._is_used:
            return None
        self._is_fresh = False
        nodes = self._survey.parse(line)
        if not any(
            isinstance(node, Call) and node.primitive.name in _LOOPS for node in self._survey.walk(nodes)
        ):
            return None
        facts = self._survey.facts_of(nodes)
        reached = self._survey.reached_from(facts)
        emitter = Emitter(self._survey, facts, self, self._may_be_local(facts, reached))
        emitter.is_line = True
        self._wanted = []
        try:
            self._refuse_unseen(facts)
            emitter.site(nodes[0])  # where it is when it is nowhere in particular
            emitter.instructions(nodes)
        except RefusedError:
            return None
        name = f"line_{len(self._records)}"
        drafts = [_Draft(None, name, [py.function(name, [], emitter.body)], emitter.sites, {})]
        self._finish(drafts)
        function: Callable[[], Any] = self._globals[name]
        return function

    def switch_off(self) -> None:
        """Compile nothing from now on: the program wants to put values in the place of errors (ERRACT)."""
        self._is_used = False
        self.forget()

    def forget(self) -> None:
        """A procedure has been defined, or defined anew, or erased: nothing that was known is certain."""
        if self._is_fresh:
            return
        self._is_fresh = True
        self._texts = None
        self._survey = Survey(self._logo)
        self._refused.clear()
        for procedure in self._logo.procedures.values():
            if isinstance(procedure, UserProcedure):
                procedure.function = None
                procedure.is_refused = False
                self._offer(procedure)

    def place_of(self, error: BaseException) -> tuple[Place, UserProcedure | None]:
        """Where in the program a compiled function raised this, and in which procedure; ``None`` when none did."""
        found = innermost(self._records, error)
        return (found[1].node.place, found[0].procedure) if found is not None else (None, None)

    def place_in(self, code: CodeType, line: int | None) -> Place:
        """Where in the program a compiled function is; ``None`` when it is none of them."""
        record = self._records.get(code)
        return record.site_at(line).node.place if record is not None else None

    def translated(self, fault: Exception) -> Exception:
        """The Logo error that a fault in a compiled function is."""
        return translated(self._logo, self._records, fault)

    def locals_from(self, frame: FrameType | None) -> dict[str, Value]:
        """The variables that compiled functions have in Python locals, as seen from one of them."""
        found: dict[str, Value] = {}
        while frame is not None:
            record = self._records.get(frame.f_code)
            if record is not None and record.names:
                values = frame.f_locals
                for key, name in record.names.items():
                    if key not in found and name in values:
                        found[key] = values[name]
            frame = frame.f_back
        return found

    def node_at(self, frame: FrameType) -> tuple[Node, UserProcedure | None]:
        """The instruction that a compiled function is at, and its procedure."""
        record = self._records[frame.f_code]
        return record.site_at(frame.f_lineno).node, record.procedure

    def source(self, procedure: UserProcedure) -> str | None:
        """The Python that a procedure became, as text; ``None`` when it is the evaluator's."""
        self._is_fresh = False
        self._drafts.clear()
        self._wanted = []
        draft = self._draft(procedure)
        if draft is None:
            return None
        return ast.unparse(py.module(draft.tree))

    def refusal(self, procedure: UserProcedure) -> str:
        """Why a procedure is the evaluator's; "" for one that is not."""
        return self._refused.get(procedure, "")

    # ------------------------------------------------------------------ compiling

    def _compile(self, procedure: UserProcedure) -> None:
        self._wanted = [procedure]
        self._drafts.clear()
        self._jumped_to.clear()
        for each in self._wanted:  # which grows
            if each.function is None and not each.is_refused and each not in self._refused:
                self._draft(each)
        for each, why in self._refused.items():
            each.is_refused = True
            self._keep(each, Kept(None, why, {}, [], [], []))
        drafts = [draft for each, draft in self._drafts.items() if each not in self._refused]
        self._finish(drafts)

    def _draft(self, procedure: UserProcedure) -> _Draft | None:
        if procedure in self._drafts:
            return self._drafts[procedure]
        if procedure in self._refused:
            return None
        try:
            draft = self._drafts[procedure] = self._written(procedure)
        except RefusedError as refused:
            self._refuse(procedure, str(refused))
            return None
        return draft

    def _refuse(self, procedure: UserProcedure, why: str) -> None:
        self._refused[procedure] = why
        self._drafts.pop(procedure, None)
        for each in self._jumped_to.get(procedure, ()):
            if each not in self._refused:
                self._refuse(each, f"it leaves its place to {procedure.name}")

    def _refuse_unseen(self, facts: Any) -> None:
        """What the evaluator keeps in tables of its own, other procedures would not find."""
        for each in self._survey.reached_from(facts):
            found = self._survey.facts(each)
            if found.asks_count or found.asks_slot or found.asks_test:
                raise RefusedError(f"{each.name} asks for what its caller counts")

    def _written(self, procedure: UserProcedure) -> _Draft:
        self._is_fresh = False
        survey = self._survey
        if not is_simple(procedure) or procedure.is_erased:
            raise RefusedError("inputs that can be left out")
        if self._logo.is_watched(procedure):
            raise RefusedError("it is traced or stepped")
        facts = survey.facts(procedure)
        self._refuse_unseen(facts)
        uses = self._uses = _Uses()
        self._origin = procedure.title.offsets[0] if procedure.title is not None else 0
        nodes = survey.body(procedure)
        may_be_local = self._may_be_local(facts, survey.reached(procedure))
        emitter = Emitter(survey, facts, self, may_be_local)

        def jump_to(node: Invocation, as_command: bool) -> tuple[str, int]:
            target = node.procedure
            if target in self._refused:
                raise RefusedError(f"it leaves its place to {target.name}")
            self._jumped_to.setdefault(target, set()).add(procedure)
            self._want(target)
            site = emitter.sites[emitter.site(node, "output") - 1]
            self._jumps.append((site, as_command))
            return f"q_{identifier(target.name.lower())}", len(self._jumps) - 1

        ending = ProcedureEnding(survey, procedure, jump_to)
        emitter.ending = ending
        parameters: list[str] = []
        hidden: list[str] = []
        for key in procedure.inputs:
            name = f"{identifier(key)}_"
            if name in parameters:
                raise RefusedError("two inputs of one name")
            parameters.append(name)
            if may_be_local(key):
                emitter.names[key] = name
            else:
                hidden.append(key)
        emitter.binds_dynamically = bool(hidden)
        self._bind_locals(emitter, procedure, may_be_local)
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
        name = identifier(procedure.name.lower())
        inner = py.function(f"q_{name}", parameters, body)
        tree: list[ast.stmt] = [inner]
        given: list[ast.expr] = [py.name(each) for each in parameters]
        result = py.walrus("result", py.call(f"q_{name}", *given))
        if ending.jumps:
            # The calls that it leaves to its caller are done here; those who leave theirs to it take it as it is.
            is_jump = py.compare(py.call("type", result), ast.Is(), py.name("tuple"))
            bounced = py.at(1, py.call("bounce", py.name("result"), py.name("jumps")))
            answer = py.either(is_jump, bounced, py.name("result"))
            tree.append(py.function(f"p_{name}", parameters, [py.give(answer)]))
        else:
            tree.append(py.assign(f"p_{name}", py.name(f"q_{name}")))
        kept = None if ending.jumps else uses  # a jump is a number that is only good now
        return _Draft(procedure, f"q_{name}", tree, emitter.sites, dict(emitter.names), kept)

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

    def _may_be_local(self, facts: Any, reached: frozenset[UserProcedure]) -> Callable[[str], bool]:
        survey = self._survey
        if facts.touches_any or any(survey.facts(each).touches_any for each in reached):
            return lambda _: False
        seen: set[str] = set()
        for each in reached:
            seen |= survey.facts(each).free
        return lambda key: key not in seen

    def _finish(self, drafts: list[_Draft]) -> None:
        """Make functions of what is written, and of what it names."""
        for draft in drafts:
            title = draft.procedure.name if draft.procedure is not None else draft.name
            code = compile(py.module(draft.tree), f"<{title}>", "exec")
            exec(code, self._globals)
            record = Record(draft.procedure, draft.sites, draft.names)
            if draft.procedure is None:
                self._records[self._globals[draft.name].__code__] = record
                continue
            self._enter(draft.procedure, record)
            if (uses := draft.uses) is not None:
                lists = list(uses.lists.items())
                kept = Kept(code, "", draft.names, list(uses.primitives), list(uses.calls), lists)
                self._keep(draft.procedure, kept)
        for each in self._wanted:
            if each.function is None:
                self._offer(each)
        self._drafts.clear()

    def _enter(self, procedure: UserProcedure, record: Record) -> None:
        """The functions of a procedure are made: from now on they are what is called."""
        key = identifier(procedure.name.lower())
        function = self._globals[f"c_{key}"] = self._globals[f"p_{key}"]
        self._records[self._globals[f"q_{key}"].__code__] = record
        self._records[function.__code__] = record
        procedure.function = function

    # ------------------------------------------------------------------ what is kept

    def save(self) -> None:
        """Keep what was compiled for the next time."""
        if self._store is not None and self._is_new and self._texts:
            self._store.save(self._texts, self._kept)
            self._is_new = False

    def _load(self) -> None:
        """Find what is kept of the procedures that there are now; of those that a program has made, nothing is."""
        texts: list[str] = []
        for name, procedure in sorted(self._logo.procedures.items()):
            if isinstance(procedure, UserProcedure):
                if not procedure.full_text or procedure.title is None or self._logo.is_watched(procedure):
                    self._texts = []
                    return
                texts.append("\n".join((name, *procedure.full_text)))
            elif procedure is not PRIMITIVES.get(name):
                self._texts = []
                return
        assert self._store is not None
        self._texts = texts
        self._kept = self._store.load(texts)
        self._is_new = False

    def _is_known(self, procedure: UserProcedure) -> bool:
        """Whether it is called by its name: templates are procedures without one."""
        return self._logo.procedures.get(procedure.name.lower()) is procedure

    def _keep(self, procedure: UserProcedure, kept: Kept) -> None:
        if self._texts and self._is_known(procedure):
            self._kept[procedure.name.lower()] = kept
            self._is_new = True

    def _install(self, procedure: UserProcedure) -> bool:
        """Make the functions of a procedure from what is kept of it; whether that could be done."""
        if self._texts is None:
            self._load()
        kept = self._kept.get(procedure.name.lower()) if self._texts and self._is_known(procedure) else None
        if kept is None:
            return False
        if kept.code is None:
            procedure.is_refused = True
            self._refused[procedure] = kept.refusal
            return True
        assert procedure.title is not None
        lines = {offset: line for each in procedure.body for offset, line in each.lists()}
        for name, behind in kept.lists:
            line = lines[procedure.title.offsets[0] + behind]
            self._logo.remember(line)
            self._globals[name] = line.value
        for name, moves in kept.primitives:
            primitive = self._logo.procedures[name]
            assert isinstance(primitive, Primitive)
            self.primitive(primitive, moves=moves)
        for name in kept.calls:
            called = self._logo.procedures[name]
            assert isinstance(called, UserProcedure)
            if called.function is None:
                self._offer(called)
        exec(kept.code, self._globals)
        self._enter(procedure, Record(procedure, lambda: self._written(procedure).sites, kept.names))
        return True

    # ------------------------------------------------------------------ what the evaluator is left

    def _offer(self, procedure: UserProcedure) -> None:
        """Until a procedure is compiled, or for good: whoever calls it comes here first."""
        name = identifier(procedure.name.lower())

        def operation(*inputs: Value) -> Value | None:
            return self._called(procedure, list(inputs), wants_value=True)

        def command(*inputs: Value) -> Value | None:
            return self._called(procedure, list(inputs), wants_value=False)

        self._globals[f"p_{name}"] = self._globals[f"q_{name}"] = operation
        self._globals[f"c_{name}"] = command

    def _called(self, procedure: UserProcedure, inputs: list[Value], *, wants_value: bool) -> Value | None:
        call = Invocation(procedure, procedure.name, [], None)
        return invoke(self._logo, call, inputs, wants_value=wants_value)

    # ------------------------------------------------------------------ names

    def _want(self, procedure: UserProcedure) -> None:
        self._uses.calls[procedure.name.lower()] = None
        if procedure not in self._wanted:
            self._wanted.append(procedure)

    def primitive(self, primitive: Primitive, *, moves: bool) -> str:
        """The function of a primitive."""
        self._uses.primitives[primitive.name, moves] = None
        name = f"{'m' if moves else 'f'}_{identifier(primitive.name)}"
        if name not in self._globals:
            if moves:
                self._globals[name] = watching_limits(self._logo, primitive)
                self._moving.add(name)
            else:
                faster = FAST.get(primitive.name)
                self._globals[name] = faster(primitive.function) if faster else primitive.function
        return name

    def procedure(self, procedure: UserProcedure, *, as_command: bool) -> str:
        """The function of a procedure."""
        self._want(procedure)
        return f"{'c' if as_command else 'p'}_{identifier(procedure.name.lower())}"

    def constant(self, value: Any, node: Literal) -> str:
        """A list that stands in the program."""
        if not value:
            return "NIL"
        behind = node.place[1] - self._origin if node.place is not None else 0
        content = hashlib.sha256(show(value).encode(errors="surrogatepass")).hexdigest()[:12]
        name = f"k{content}_{behind}".replace("-", "m")
        self._uses.lists[name] = behind
        self._globals[name] = value
        return name

    def always_outputs(self, procedure: UserProcedure) -> bool:
        """Whether a procedure outputs whenever it ends."""
        return self._survey.always_outputs(procedure)

    def never_outputs(self, procedure: UserProcedure) -> bool:
        """Whether a procedure never outputs."""
        return self._survey.never_outputs(procedure)

    def moving_names(self) -> frozenset[str]:
        """The names of all that may move the robot."""
        return frozenset(self._moving)


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
