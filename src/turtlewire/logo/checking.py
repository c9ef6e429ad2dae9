"""Finding mistakes in a program without running it. What only a run could tell is not reported.

Procedures may be made while the program runs (DEFINE, LOAD), variables belong to whoever is running (dynamic scope),
and lists may be data: see ``survey`` for how each of them silences what can then no longer be known.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from turtlewire.logo import errors
from turtlewire.logo.definitions import define_from_title
from turtlewire.logo.errors import LogoError, Position
from turtlewire.logo.instructions import inputs_of, run_lists, scratch
from turtlewire.logo.procedures import UserProcedure
from turtlewire.logo.reader import Definition, Line, read
from turtlewire.logo.survey import SPECIAL, Words, lines_of
from turtlewire.logo.syntax import (
    Call,
    Failure,
    Invocation,
    Literal,
    Node,
    Parser,
    Pending,
    Unknown,
    Variable,
)
from turtlewire.logo.tokens import PRECEDENCE, Place, Token, tokenize
from turtlewire.logo.values import plain, show_in_error

if TYPE_CHECKING:
    from collections.abc import Sequence

# What leaves the list that it stands in, whatever comes behind.
_LEAVES = frozenset(("stop", "output", ".maybeoutput", "throw", "goto", "bye"))
_LOOPS = frozenset(("repeat", "forever", "for", "while", "until", "do.while", "do.until"))
_UNKNOWN_PROCEDURE = 13
_ALREADY_DEFINED = (15, 22)


class Finding(NamedTuple):
    """Something wrong with a program.

    Attributes:
        position: where.
        kind: ``"syntax"``, ``"unknown procedure"``, ``"no value"``, ``"inputs"``, ``"unused value"``,
            ``"unused input"``, ``"unused local"`` or ``"unreachable"``.
        message: what.
        hint: what to do about it, ``""`` if that is not known.
    """

    position: Position
    kind: str
    message: str
    hint: str

    def explain(self) -> str:
        """The paragraph for people."""
        place = f"{self.position.file}, line {self.position.line}, column {self.position.column}"
        return "\n".join(filter(None, [f"{place}: {self.message}", self.position.marked(), self.hint]))


def check(text: str, name: str) -> list[Finding]:
    """What is wrong with a program, in the order of its lines.

    Args:
        text: the program.
        name: its file name, for positions.
    """
    try:
        program = read(text, name)
    except LogoError as error:
        position = error.position or Position(name, 1, 1, "")  # though the reader always knows
        return [Finding(position, "syntax", error.text, error.advice())]
    try:
        return _Check(program).findings()
    except RecursionError:
        place = Position(name, 1, 1, text.partition("\n")[0])
        return [Finding(place, "syntax", "brackets are nested too deep to be looked at", "")]


class _Check:
    def __init__(self, program: Sequence[Line | Definition]) -> None:
        self._program = program
        self._found: dict[tuple[int, int, str], Finding] = {}
        self._logo = scratch()
        self._words = Words().add(list(lines_of(program)))
        self._bodies: list[tuple[UserProcedure, Definition, Words]] = []
        self._where: dict[str, int] = {}  # the line that a procedure is defined in
        self._defined: set[str] = set()  # so far, while the program is gone through
        self._changing = set(self._words.defined)  # procedures whose number of inputs changes while it runs
        self._procedure: UserProcedure | None = None

    def findings(self) -> list[Finding]:
        """All of them."""
        for each in self._program:
            if isinstance(each, Definition):
                self._define(each)
        for key in self._changing:
            self._logo.procedures.pop(key, None)
        inputs = {key for procedure, _, _ in self._bodies for key in _names(procedure)}
        self._given = self._words.given | inputs | SPECIAL
        for each in self._program:
            if isinstance(each, Definition):
                self._defined.add(_title_key(each))
            else:
                self._lines([each], is_strict=True)
        for procedure, definition, _ in self._bodies:
            self._procedure = procedure
            for optional in procedure.optional:
                self._lines([optional.default], is_strict=False)
            self._lines(definition.body, is_strict=True)
        self._look_for_unused()
        return [self._found[key] for key in sorted(self._found)]

    # --- procedures ---------------------------------------------------------------------------------------------

    def _define(self, definition: Definition) -> None:
        key = _title_key(definition)
        before = self._logo.procedures.get(key)
        arity = (before.minimum_inputs, before.default_inputs, before.maximum_inputs) if before else None
        try:
            define_from_title(self._logo, definition)
        except LogoError as error:
            if error.number in _ALREADY_DEFINED and "redefp" in self._words.given:
                self._changing.add(key)
            else:
                self._report(error.position, "syntax", error.text, error.advice())
            return
        procedure = self._logo.procedures[key]
        assert isinstance(procedure, UserProcedure)
        if arity not in (
            None,
            (procedure.minimum_inputs, procedure.default_inputs, procedure.maximum_inputs),
        ):
            self._changing.add(key)
        own = UserProcedure(procedure.name)  # the next definition changes the other one in place
        own.inputs, own.optional, own.rest = procedure.inputs, procedure.optional, procedure.rest
        words = Words().add([*definition.body, *(optional.default for optional in own.optional)])
        self._bodies.append((own, definition, words))
        place = definition.title.position(0)
        self._where.setdefault(key, place.line if place is not None else 0)

    def _look_for_unused(self) -> None:
        """Inputs and locals that nothing can read: neither the procedure itself, nor what it calls, nor a list."""
        if self._words.reads_unknown:
            return
        lists = Words().add([line for line in lines_of(self._program) for line in _data(line)])
        for procedure, definition, words in self._bodies:
            # A procedure with a variable of that name of its own reads that one.
            others = [
                other.read - _names(its) - set(other.local)
                for its, where, other in self._bodies
                if where is not definition
            ]
            elsewhere = lists.read.union(*others)
            for kind, names in (("input", _names(procedure)), ("local", set(words.local))):
                for key in names - words.read - elsewhere - SPECIAL:
                    self._report_unused(kind, key, procedure, definition, words)

    def _report_unused(
        self, kind: str, key: str, procedure: UserProcedure, definition: Definition, words: Words
    ) -> None:
        if kind == "local":
            position = _position(words.local[key].place)
        else:
            position = next(
                (
                    definition.title.position(index)
                    for index, item in enumerate(definition.title.items)
                    if index > 1 and _input_key(item) == key
                ),
                None,
            )
        self._report(
            position,
            f"unused {kind}",
            f"{procedure.name} never uses its {kind} {key}",
            f"Use it as :{key}, or take it away.",
        )

    # --- instructions -------------------------------------------------------------------------------------------

    def _lines(self, lines: Sequence[Line], *, is_strict: bool) -> bool:
        """Check instructions; whether what comes behind them can never be reached.

        With ``is_strict`` a value that is left over is an error, also at the end.
        """
        nodes: list[Node] = []
        for line in lines:
            nodes += self._parsed(line)
        left_by: Node | None = None
        for index, node in enumerate(nodes):
            if left_by is not None:
                self._report_unreachable(left_by, node, nodes[index:])
                break
            self._visit(node)
            if (is_strict or index + 1 < len(nodes)) and _is_value(node):
                self._report_unused_value(node)
            if self._leaves(node):
                left_by = node
        return left_by is not None

    def _parsed(self, line: Line) -> list[Node]:
        """The instructions in a line, up to the first whose inputs cannot be told apart."""
        try:
            tokens: list[Token] = tokenize(line)
        except LogoError as error:
            self._report(error.position, "syntax", error.text, error.advice())
            return []
        procedures = self._logo.procedures
        nodes = Parser(tokens, procedures, lambda _line: None).parse()
        while nodes and isinstance(nodes[-1], Pending):
            pending = nodes.pop()
            assert isinstance(pending, Pending)
            more = Parser(pending.tokens, procedures, lambda _line: None, self._given.__contains__).parse()
            for node in more:
                nodes.append(node)
                if any(self._is_unknown(each) for each in _all_nodes([node])):
                    return nodes
        return nodes

    def _is_unknown(self, node: Node) -> bool:
        if isinstance(node, Unknown):
            key = plain(node.name).lower()
            return key not in self._given or key in self._changing
        return False

    def _visit(self, root: Node) -> None:
        for node in _all_nodes([root]):
            if isinstance(node, Variable):
                self._check_variable(node)
            elif isinstance(node, Unknown):
                self._check_unknown(node.name, node.place)
            elif isinstance(node, Failure):
                self._report_failure(node)
            elif isinstance(node, Invocation) and self._procedure is None:
                self._check_order(node)
            elif (
                isinstance(node, Call)
                and self._procedure is None
                and node.name.lower() in ("stop", "output", "op")
            ):
                error = errors.outside_procedure(node.name)
                self._report(_position(node.place), "syntax", error.text, error.advice())
            name = node.primitive.name if isinstance(node, Call) else ""
            if name == "catch" and _is_word(node, "error"):
                continue  # what is wrong there is wanted
            for line, role in run_lists(node):
                if role != "instructions" or name not in ("if", "ifelse"):  # those: see ``_leaves``
                    self._lines([line], is_strict=role == "instructions" and name in _LOOPS)
                else:
                    self._lines([line], is_strict=False)

    def _leaves(self, node: Node) -> bool:
        """Whether nothing behind this is ever reached."""
        if not isinstance(node, Call):
            return False
        name = node.primitive.name
        if name in _LEAVES:
            return True
        if name in ("if", "ifelse") and len(node.inputs) == 3:
            lists = [each.line for each in node.inputs[1:] if isinstance(each, Literal)]
            return len(lists) == 2 and all(line is not None and self._list_leaves(line) for line in lists)
        return False

    def _list_leaves(self, line: Line) -> bool:
        return any(self._leaves(node) for node in self._parsed(line))

    # --- reports ------------------------------------------------------------------------------------------------

    @property
    def _errors_are_acted_on(self) -> bool:
        """Whether the program may have ERRACT put a value in the place of what has none."""
        return "erract" in self._words.given

    def _check_variable(self, node: Variable) -> None:
        if node.key in self._given or self._words.gives_unknown or self._errors_are_acted_on:
            return
        if node.key.isdigit():
            return  # a slot of CROSSMAP
        error = errors.no_value(node.name, sorted(self._given))
        message = f"{plain(node.name)} is never given a value"
        self._report(_position(node.place), "no value", message, error.advice())

    def _check_unknown(self, name: str, place: Place) -> None:
        key = plain(name).lower()
        if key in self._changing or self._words.defines_unknown:
            return
        if key in self._given or self._errors_are_acted_on:
            return
        error = errors.unknown_procedure(name, list(self._logo.procedures))
        self._report(_position(place), "unknown procedure", error.text, error.advice())

    def _check_order(self, node: Invocation) -> None:
        key = plain(node.name).lower()
        if (
            key in self._defined
            or key in self._changing
            or self._words.defines_unknown
            or key not in self._where
        ):
            return
        error = errors.unknown_procedure(node.name)
        hint = f"It is defined later, in line {self._where[key]}: it must come before it is used."
        self._report(_position(node.place), "unknown procedure", error.text, hint)

    def _report_failure(self, node: Failure) -> None:
        error = node.error
        if error.number == _UNKNOWN_PROCEDURE:
            key = plain(error.wrong_name).lower()
            if key in self._changing or self._words.defines_unknown:
                return
            self._report(error.position, "unknown procedure", error.text, error.advice())
        else:
            self._report(error.position, "inputs", error.text, error.advice())

    def _report_unused_value(self, node: Node) -> None:
        shown = show_in_error(node.value) if isinstance(node, Literal) else f":{node.name}"  # type: ignore[union-attr]
        if isinstance(node, Call):
            shown = f"what {node.name} outputs"
        error = errors.unused_value(shown)
        self._report(_position(node.place), "unused value", error.text, error.advice())

    def _report_unreachable(self, left_by: Node, node: Node, rest: Sequence[Node]) -> None:
        if any(isinstance(each, Call) and each.primitive.name == "tag" for each in rest):
            return  # GOTO gets there
        name = left_by.name if isinstance(left_by, Call) else ""
        self._report(
            _position(node.place),
            "unreachable",
            f"{name} comes before this: it is never run",
            "Take it away, or move it.",
        )

    def _report(self, position: Position | None, kind: str, message: str, hint: str) -> None:
        if position is not None:
            finding = Finding(position, kind, message, hint)
            self._found.setdefault((position.line, position.column, kind), finding)


def _all_nodes(roots: Sequence[Node]) -> list[Node]:
    """These nodes and all within them."""
    found = list(roots)
    for node in found:
        found += inputs_of(node)
    return found


def _is_word(node: Node, word: str) -> bool:
    """Whether the first input is this quoted word."""
    first = inputs_of(node)[0]
    return isinstance(first, Literal) and isinstance(first.value, str) and first.value.lower() == word


def _is_value(node: Node) -> bool:
    """Whether this outputs a value for certain."""
    return isinstance(node, Literal | Variable) or (isinstance(node, Call) and node.name in PRECEDENCE)


def _names(procedure: UserProcedure) -> set[str]:
    """The names of all inputs."""
    rest = {procedure.rest} if procedure.rest else set()
    return {*procedure.inputs, *(each.name for each in procedure.optional), *rest}


def _title_key(definition: Definition) -> str:
    items = definition.title.items
    return plain(items[1]).lower() if len(items) > 1 and isinstance(items[1], str) else ""


def _input_key(item: object) -> str:
    if isinstance(item, Line):
        item = item.items[0] if item.items else ""
    return plain(item).lstrip(':"').lower() if isinstance(item, str) else ""


def _position(place: Place) -> Position | None:
    return place[0].position(place[1]) if place is not None else None


def _data(line: Line) -> list[Line]:
    """The lists in a line."""
    return [item for item in line.items if isinstance(item, Line)]
