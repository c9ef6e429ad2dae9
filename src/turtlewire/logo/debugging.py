"""Looking at a program while it runs: line by line, up to a breakpoint, or from another thread.

A debugger is attached before a program begins; then the evaluator asks it before each line, in the thread that runs the
program, and it asks its front end what is to be done: that may take its time. STEP needs none: without a front end,
``pausing`` shows a line and waits for the RETURN key.

A line is what of a list or of a procedure's body begins in one line of the text; so the lines of a REPEAT over several
lines are lines, in each of its rounds, and so is the first instruction of each round when it stands in one.
"""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.errors import StoppedError
from turtlewire.logo import pausing
from turtlewire.logo.procedures import OPERATION, ExitError
from turtlewire.logo.values import NIL, show

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.logo.errors import Position
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.syntax import Code, Node
    from turtlewire.logo.values import Value


class Order(Enum):
    """How a program that stands before a line is to go on."""

    INTO = "into"  # up to the next line, whosever it is
    OVER = "over"  # the same, but procedures and lists that this line runs are run to their ends
    OUT = "out"  # until the running procedure has ended, or a breakpoint
    ON = "on"  # until a breakpoint, ``pause`` or the end
    END = "end"  # no further


class Reason(Enum):
    """Why a program stands before a line."""

    STEP = "step"  # an order of before, or STEP, or the program is to begin so
    BREAKPOINT = "breakpoint"
    PAUSE = "pause"  # somebody asked for it, or the program did by PAUSE


class Moment(NamedTuple):
    """A line that is about to run.

    Attributes:
        position: where it is; ``None`` for one that no file contains, as of DEFINE.
        procedure: the procedure that is running, ``""`` at top level.
        depth: how many procedures are running; one called last takes the place of its caller.
        text: the line as it stands in the file, or as a list.
    """

    position: Position | None
    procedure: str
    depth: int
    text: str


class _At(NamedTuple):
    """Where a level is: the line of the file, of a body its line, too, and the place in it."""

    line: tuple[str, int]
    body_line: int
    column: int


class Debugger:
    """Stops programs before their lines.

    While it is attached nothing is compiled: programs are slower, and mean the same.

    Args:
        on_stop: asked how to go on, in the thread of the program; it may block, and what it raises ends the program.
            ``None``: nobody looks, and only STEP stops.
        begins: the order under which each program begins; ``Order.INTO`` stops before its first line.

    Attributes:
        breakpoints: files and numbers of lines before which programs stop; may be replaced at any time.
        moment: the line that runs, ``None`` before the first one. Any thread may look.
        reason: why the program stands there, ``None`` while it runs. Any thread may look.
    """

    def __init__(
        self, on_stop: Callable[[Moment, Reason], Order] | None = None, begins: Order = Order.ON
    ) -> None:
        self.on_stop = on_stop
        self.begins = begins
        self.breakpoints: frozenset[tuple[str, int]] = frozenset()
        self.moment: Moment | None = None
        self.reason: Reason | None = None
        self._order = begins
        self._within = 0  # OVER and OUT stop at this level, or further out
        self._lines: list[_At | None] = []  # where each level is: bodies, and lists in them
        self._bodies: list[int] = []  # which of the levels are bodies
        self._is_busy = False  # whether a line is being looked at: what is run meanwhile is not
        self._steps = pausing.Steps()
        self._pause = False
        self._stop = False

    def begin(self) -> None:
        """A program begins."""
        self._order = self.begins
        self._lines, self._bodies = [], []
        self._steps = pausing.Steps()
        self._is_busy = self._pause = self._stop = False
        self.moment = self.reason = None

    # --- from any thread --------------------------------------------------------------------------------------

    def pause(self) -> None:
        """Have the program stop before its next line; a motion of the robot that has begun is finished first."""
        self._pause = True

    def stop(self) -> None:
        """Have the program end before its next instruction, by ``StoppedError``; ``stop`` of a robot stops that."""
        self._stop = True

    # --- while the program stands, in its thread --------------------------------------------------------------

    def run_here(self, logo: Interpreter, text: str) -> None:
        """Run instructions where the program stands, as at a PAUSE; to be called by ``on_stop``.

        Raises:
            LogoError: they are wrong.
            ThrowError, ExitError: they end the procedure, or more; ``on_stop`` lets these pass.
        """
        node = logo.node
        try:
            result = pausing.run_typed(logo, text)
        finally:
            logo.node = node
        if result is not None:
            raise ExitError(result)

    def own_variables(self, logo: Interpreter) -> dict[str, Value]:
        """The inputs and local variables of the running procedure that have a value."""
        return {name: logo.variables[name] for name in logo.hidden if name in logo.variables}

    # --- what the evaluator tells -----------------------------------------------------------------------------

    def enter(self, *, is_body: bool) -> int:
        """A list or a body begins.

        Returns:
            What is to be handed to ``leave``.
        """
        if self._stop:
            self._end()
        level = len(self._lines)
        if is_body:
            # It has taken the place of its caller, and so of the line that was to be gone over.
            self._within = min(self._within, level - 1)
            self._bodies.append(level)
        self._lines.append(None)
        return level

    def leave(self, level: int) -> None:
        """It has ended, in whatever way."""
        del self._lines[level:]
        bodies = self._bodies
        while bodies and bodies[-1] >= level:
            bodies.pop()

    def in_place(self, level: int) -> None:
        """A list begins in the place of the last instruction."""
        lines = self._lines
        lines[level:] = [lines[-1], None]

    def before(self, logo: Interpreter, node: Node, code: Code, how: int, level: list[int] | None) -> None:
        """An instruction is about to run; ``level``: how far a body is, ``None`` in other lists.

        Raises:
            StoppedError: ``stop`` was called.
            ExitError, ThrowError: what was typed ends the procedure, or more.
        """
        if self._stop:
            self._end()
        if self._is_busy or (how == OPERATION and level is None):
            return
        if self.on_stop is None:
            if level is not None and self._is_stepped(logo):
                self._show(logo, code, level[0])
            return
        position = node.place[0].position(node.place[1]) if node.place is not None else None
        body_line = id(code.lines[level[0]]) if level is not None else 0
        if position is not None:
            here = _At((position.file, position.line), body_line, position.column)
        else:
            here = _At(("", 0), body_line, 0)
        lines = self._lines
        last, lines[-1] = lines[-1], here
        if last is not None and last[:2] == here[:2]:
            return
        outer = lines[-2] if last is None and level is None and len(lines) > 1 else None
        if outer is not None and (outer.line, outer.column) == (here.line, here.column):
            return  # the same instruction, which was not known before
        text = position.text.strip() if position is not None else show(_list_of(code, level))
        procedure = logo.procedure.name if logo.procedure is not None else ""
        self.moment = Moment(position, procedure, logo.depth, text)
        reason = self._reason(logo, here, level)
        if reason is Reason.BREAKPOINT and outer is not None and outer.line == here.line:
            return  # a list within the line that has the breakpoint
        if reason is not None:
            self.look(self.moment, reason)

    def look(self, moment: Moment, reason: Reason) -> None:
        """Ask the front end how to go on from where the program is.

        Raises:
            StoppedError: no further.
        """
        assert self.on_stop is not None
        self._pause = False
        self._is_busy, self.reason = True, reason
        try:
            order = self.on_stop(moment, reason)
        finally:
            self._is_busy, self.reason = False, None
        if order is Order.END or self._stop:
            self._end()
        self._order = order
        if order is Order.OVER:
            self._within = len(self._lines) - 1
        elif order is Order.OUT:
            self._within = self._bodies[-1] - 1 if self._bodies else -1

    def paused(self, logo: Interpreter) -> None:
        """The program does PAUSE, and only the front end can be asked."""
        if not self._is_busy:
            self.look(self.moment or Moment(None, "", logo.depth, ""), Reason.PAUSE)

    # --- within -----------------------------------------------------------------------------------------------

    def _end(self) -> None:
        self._stop = False
        raise StoppedError("the program was stopped")

    def _is_stepped(self, logo: Interpreter) -> bool:
        return logo.procedure is not None and logo.procedure.name.lower() in logo.marks.stepped.procedures

    def _reason(self, logo: Interpreter, here: _At, level: list[int] | None) -> Reason | None:
        """Why the program is to stop before this line, if it is."""
        if self._pause:
            return Reason.PAUSE
        if here.line in self.breakpoints:
            return Reason.BREAKPOINT
        if self._order is Order.INTO or (level is not None and self._is_stepped(logo)):
            return Reason.STEP
        is_near = self._order in (Order.OVER, Order.OUT) and len(self._lines) - 1 <= self._within
        return Reason.STEP if is_near else None

    def _show(self, logo: Interpreter, code: Code, index: int) -> None:
        """Show a line of a stepped procedure when it begins, and wait; GOTO does not begin the line of its tag."""
        assert logo.procedure is not None
        line = code.lines[index]
        if code.lines[index - 1] is line if index else code is not logo.procedure.code:
            return
        node, self._is_busy = logo.node, True
        try:
            self._steps.show(logo, line)
        finally:
            logo.node, self._is_busy = node, False


def _list_of(code: Code, level: list[int] | None) -> Value:
    """The line of a body that no file contains."""
    return code.lines[level[0]].value if level is not None else NIL
