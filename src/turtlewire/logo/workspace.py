"""A workspace: what names mean in it, and the code of the lists that are run; it holds until something is defined."""

from __future__ import annotations

from turtlewire.logo.library import VARIABLES
from turtlewire.logo.marks import Marks
from turtlewire.logo.primitives import PRIMITIVES
from turtlewire.logo.reader import Line, line_of
from turtlewire.logo.syntax import Code, Parser
from turtlewire.logo.tokens import tokenize

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.debugging import Debugger
    from turtlewire.logo.procedures import Primitive, UserProcedure
    from turtlewire.logo.syntax import Node, Pending
    from turtlewire.logo.values import List, Value

_LINES_KEPT = 20_000


class Workspace:
    """Procedures, variables and property lists, and how each list was read that is a program's.

    Attributes:
        primitives: the primitives by all of their names, in lower case, as they were at the beginning.
        procedures: what each name means now: one of them, or a procedure of the program's.
        variables: the values of variables, global or not: see ``scope``.
        property_lists: the properties by their owner and name: the names as given, and the values.
        marks: what is buried, traced or stepped.
        lists_change: whether a program has changed a list: it may no longer be what was read.
        debugger: who looks at each line before it runs; set by ``attach``, and by STEP.
    """

    def __init__(self) -> None:
        self.primitives = PRIMITIVES
        self.procedures: dict[str, Primitive | UserProcedure] = dict(PRIMITIVES)
        self.variables: dict[str, Value] = dict(VARIABLES)
        self.property_lists: dict[str, dict[str, tuple[Value, Value]]] = {}
        self.marks = Marks()
        self.marks.buried.variables.update(VARIABLES)
        self.lists_change = False
        self.debugger: Debugger | None = None
        # The lists of programs, and others that were run, by their first cell: how each was read, and its code.
        self._lines: dict[int, tuple[List, Line]] = {}
        self._epoch = 0  # changes with every definition: parsed code of an older one is parsed anew

    @property
    def is_all_watched(self) -> bool:
        """Whether somebody wants to see each instruction of the program, or what becomes of a variable."""
        marks, debugger = self.marks, self.debugger
        if marks.traced.variables or marks.stepped.variables:
            return True
        return debugger is not None and debugger.on_stop is not None

    def is_watched(self, procedure: UserProcedure) -> bool:
        """Whether somebody wants to see each instruction of a procedure, or its calls, or a variable."""
        marks, name = self.marks, procedure.name.lower()
        return self.is_all_watched or name in marks.traced.procedures or name in marks.stepped.procedures

    # --- how lists were read ----------------------------------------------------------------------------------

    def line(self, cells: List) -> Line:
        """How a list was read, if it was; otherwise as if it had been, without a place."""
        if not cells:
            return Line(())
        known = self._lines.get(id(cells))
        if known is None:
            if len(self._lines) >= _LINES_KEPT:
                self.forget_lines()
            known = self._lines[id(cells)] = (cells, line_of(cells))
        return known[1]

    def remember(self, line: Line) -> None:
        """Know a list of the program, and those within it, again when they are run as values."""
        pending = [line]
        for each in pending:
            cells = each.value
            if cells and id(cells) not in self._lines and (not self.lists_change or each.is_current()):
                self._lines[id(cells)] = (cells, each)
                pending += [item for item in each.items if isinstance(item, Line)]

    def forget_lines(self) -> None:
        """Parse everything anew that is run from now on: a list has been changed, or there are too many."""
        self._lines.clear()
        self._epoch += 1

    # --- their code -------------------------------------------------------------------------------------------

    def parsed(self, instructions: Value) -> Code:
        """The code of an instruction list; kept with the list until a procedure is defined."""
        if not isinstance(instructions, list):
            return self._parse(Line((instructions,)))
        return self.code_of(self.line(instructions))

    def code_of(self, line: Line) -> Code:
        """``parsed`` for a line of the program."""
        code: Code | None = line.code
        if code is None or code.epoch != self._epoch:
            code = line.code = self._parse(line)
        return code

    def _parse(self, line: Line) -> Code:
        return Code(Parser(tokenize(line), self.procedures, self.remember).parse(), self._epoch)

    def body_of(self, procedure: UserProcedure) -> Code:
        """The code of a procedure's body."""
        code: Code | None = procedure.code
        if code is None or code.epoch != self._epoch:
            nodes: list[Node] = []
            lines: list[Line] = []
            for line in procedure.body:
                nodes += Parser(tokenize(line), self.procedures, self.remember).parse()
                lines += [line] * (len(nodes) - len(lines))
            code = procedure.code = Code(nodes, self._epoch, lines)
        return code

    def parse_pending(self, node: Pending) -> list[Node]:
        """The rest of a line, now that its first instruction is to run."""
        return Parser(node.tokens, self.procedures, self.remember, self._has_setter).parse()

    def _has_setter(self, name: str) -> bool:
        return name in self.variables or name in self.marks.declared
