"""Which procedures are compiled, when, and together with which; and what is known of those that are."""

from __future__ import annotations

from turtlewire.logo.calls import invoke
from turtlewire.logo.compiler.fast import FAST, MOVES
from turtlewire.logo.compiler.faults import Record, innermost, translated
from turtlewire.logo.compiler.runtime import helpers
from turtlewire.logo.compiler.sites import LOOPS, identifier, primitive_name
from turtlewire.logo.events import watching_limits
from turtlewire.logo.primitives import PRIMITIVES
from turtlewire.logo.procedures import Primitive, UserProcedure
from turtlewire.logo.reader import Line
from turtlewire.logo.syntax import Invocation
from turtlewire.logo.values import show

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from types import CodeType, FrameType
    from typing import Any

    from turtlewire.logo.compiler.sites import Site
    from turtlewire.logo.compiler.store import Kept, Store
    from turtlewire.logo.compiler.writing import Writer
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.syntax import Node
    from turtlewire.logo.tokens import Place
    from turtlewire.logo.values import Value

_LINES_KEPT = 1000  # of the lines that programs with the same procedures have run


class Compiler:
    """Compiles the procedures of a workspace.

    Args:
        logo: the workspace.
        is_used: whether anything is compiled at all.
        store: where compiled procedures are kept for the next time, if they are.
    """

    def __init__(self, logo: Interpreter, *, is_used: bool, store: Store | None = None) -> None:
        self._logo = logo
        self._store = store
        self._texts: list[str] | None = None  # of what is kept together; None: not asked yet
        self._kept: dict[str, Kept] = {}
        self._is_new = False  # whether there is something to keep
        self._is_used = is_used
        self._is_fresh = False  # whether nothing has been found out since the last definition
        self._globals: dict[str, Any] = helpers(logo)
        self._records: dict[CodeType, Record] = {}
        self._refused: dict[UserProcedure, str] = {}
        self._found_writer: Writer | None = None

    @property
    def _writer(self) -> Writer:
        """What writes functions; loaded when there is one to write."""
        if self._found_writer is None:
            from turtlewire.logo.compiler.writing import Writer

            self._found_writer = Writer(self._logo)
            self._found_writer.refused.update(self._refused)
        self._is_fresh = False
        return self._found_writer

    # ------------------------------------------------------------------ what the evaluator asks for

    def function(self, procedure: UserProcedure) -> Callable[..., Any] | None:
        """The function of a procedure; ``None`` when it is the evaluator's."""
        self._is_fresh = False
        is_to_come = procedure.function is None and not procedure.is_refused and self._is_used
        if is_to_come and not self._install(procedure):
            for written in self._writer.procedures(procedure):
                made_of = written.procedure
                assert made_of is not None
                if self._is_known(made_of):
                    self._keep(made_of.name.lower(), written.kept)
                self._provide(written.kept, written.lists, written.calls)
                self._enter(made_of, written.kept, written.sites)
        return procedure.function

    def line(self, line: Line) -> Callable[[], Any] | None:
        """The function of a line of the program that has a loop in it; ``None`` when it is the evaluator's."""
        if not self._is_used or self._logo.marks.traced.variables or not _mentions_loop(line):
            return None
        self._is_fresh = False
        key = f"\n{_spelled_out(line)}"
        kept = self._known(line).get(key)
        if kept is not None:
            self._provide_kept(kept, [line], line.offsets[0])
            return self._enter_line(kept, lambda: self._writer.line(line).sites)
        written = self._writer.line(line)
        self._keep(key, written.kept)
        self._provide(written.kept, written.lists, written.calls)
        return self._enter_line(written.kept, written.sites)

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
        self._found_writer = None
        self._refused.clear()
        for procedure in self._logo.procedures.values():
            if isinstance(procedure, UserProcedure):
                procedure.function = None
                procedure.is_refused = False
                self._offer(procedure)

    def place_of(self, error: BaseException) -> tuple[Place, UserProcedure | None]:
        """Where in the program a compiled function raised this, and in which procedure; ``None``: the evaluator did."""
        found = innermost(self._records, error)
        if found is None:
            return None, None
        record, site, trace = found
        evaluates, inner = type(self._logo).run_code.__code__, trace.tb_next
        while inner is not None:
            if inner.tb_frame.f_code is evaluates:
                return None, None
            inner = inner.tb_next
        return site.node.place, record.owner(site)

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
        site = record.site_at(frame.f_lineno)
        return site.node, record.owner(site)

    def source(self, procedure: UserProcedure) -> str | None:
        """The Python that a procedure became, as text; ``None`` when it is the evaluator's."""
        return self._writer.source(procedure)

    def refusal(self, procedure: UserProcedure) -> str:
        """Why a procedure is the evaluator's; "" for one that is not."""
        return self._writer.refused.get(procedure, "")

    # ------------------------------------------------------------------ functions

    def _enter(
        self, procedure: UserProcedure, kept: Kept, sites: list[Site] | Callable[[], list[Site]]
    ) -> None:
        """Make the functions of a procedure: from now on they are what is called."""
        if kept.code is None:
            procedure.is_refused = True
            self._refused[procedure] = kept.refusal
            return
        exec(kept.code, self._globals)
        key = identifier(procedure.name.lower())
        function = self._globals[f"c_{key}"] = self._globals[f"p_{key}"]
        record = self._globals[f"r_{key}"] = Record(procedure, sites, kept.names)
        self._records[self._globals[f"q_{key}"].__code__] = record
        self._records[function.__code__] = record
        procedure.function = function

    def _enter_line(
        self, kept: Kept, sites: list[Site] | Callable[[], list[Site]]
    ) -> Callable[[], Any] | None:
        if kept.code is None:
            return None
        exec(kept.code, self._globals)
        function: Callable[[], Any] = self._globals.pop("line")
        self._records[function.__code__] = Record(None, sites, kept.names)
        return function

    def _provide(self, kept: Kept, lists: dict[str, Value], calls: Iterable[UserProcedure]) -> None:
        """Let a function find what it uses."""
        self._globals.update(lists)
        for primitive, moves in kept.primitives:
            name = primitive_name(primitive, moves=moves)
            if name not in self._globals:
                self._globals[name] = self._function_of(PRIMITIVES[primitive], moves=moves)
        for called in calls:
            if called.function is None:
                self._offer(called)

    def _function_of(self, primitive: Primitive, *, moves: bool) -> Callable[..., Any]:
        faster = (MOVES if moves else FAST).get(primitive.name)
        if faster is not None:
            return faster(primitive.function)
        return watching_limits(self._logo, primitive) if moves else primitive.function

    def _provide_kept(self, kept: Kept, lines: Iterable[Line], origin: int) -> None:
        """Let a function from the store find what it uses: its lists stand in the lines that it was made of."""
        lists: dict[str, Value] = {}
        if kept.lists:
            by_offset = {offset: line for each in lines for offset, line in each.lists()}
            for name, behind in kept.lists:
                line = by_offset[origin + behind]
                self._logo.remember(line)
                lists[name] = line.value
        calls = [self._logo.procedures[name] for name in kept.calls]
        self._provide(kept, lists, [each for each in calls if isinstance(each, UserProcedure)])

    # ------------------------------------------------------------------ what is kept

    def save(self) -> None:
        """Keep what was compiled for the next time."""
        if self._store is not None and self._is_new and self._texts:
            lines = [key for key in self._kept if key.startswith("\n")]
            for key in lines[:-_LINES_KEPT]:
                del self._kept[key]
            self._store.save(self._texts, self._kept)
            self._is_new = False

    def _known(self, line: Line | None = None) -> dict[str, Kept]:
        """What is kept of the procedures that there are now; of those that a program has made, nothing is.

        Where there are no procedures, it is what is kept of the program that a line is of.
        """
        if self._texts is None:
            self._is_new = False
            self._texts = self._texts_now(line) if self._store is not None else []
            self._kept = self._store.load(self._texts) if self._store is not None and self._texts else {}
        return self._kept

    def _texts_now(self, line: Line | None) -> list[str]:
        texts: list[str] = []
        for name, procedure in sorted(self._logo.procedures.items()):
            if isinstance(procedure, UserProcedure):
                if not procedure.full_text or procedure.title is None or self._logo.is_watched(procedure):
                    return []
                texts.append("\n".join((name, *procedure.full_text)))
            elif procedure is not PRIMITIVES.get(name):
                return []
        if not texts and line is not None and line.source is not None:
            texts.append(line.source.text)
        return texts

    def _keep(self, key: str, kept: Kept) -> None:
        if self._texts:
            self._kept[key] = kept
            self._is_new = True

    def _is_known(self, procedure: UserProcedure) -> bool:
        """Whether it is called by its name: templates are procedures without one."""
        return self._logo.procedures.get(procedure.name.lower()) is procedure

    def _install(self, procedure: UserProcedure) -> bool:
        """Make the functions of a procedure from what is kept of it; whether that could be done."""
        kept = self._known().get(procedure.name.lower()) if self._is_known(procedure) else None
        if kept is None:
            return False
        assert procedure.title is not None
        self._provide_kept(kept, procedure.body, procedure.title.offsets[0])
        self._enter(procedure, kept, lambda: self._writer.sites_of(procedure))
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


def _mentions_loop(line: Line) -> bool:
    """Whether a loop's name stands in a line."""
    pending = [line]
    for each in pending:
        for item in each.items:
            if isinstance(item, Line):
                pending.append(item)
            elif isinstance(item, str) and item.rpartition("(")[2].rstrip("0123456789").lower() in LOOPS:
                return True
    return False


def _spelled_out(line: Line) -> str:
    """All that a line says, and where its lists stand in it: two lines with the same do the same."""
    origin = line.offsets[0] if line.offsets else 0
    places = [offset - origin for offset, _ in line.lists()]
    return f"{show(line.value, repr, with_origins=True)} {places}"
