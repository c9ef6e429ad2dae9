"""The evaluator: plain and complete; what it does is the measure for anything faster.

Variables are dynamically scoped: one table of values, and each running procedure remembers what its inputs and locals
hid (shallow binding). A procedure called last, or by OUTPUT, takes the place of its caller; what the caller's own
variables hid stays remembered with it, so dynamic scope is not disturbed. Calls that are not last nest Python calls
of Python functions, which CPython keeps off the C stack; nothing between two of them may be a C function.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from turtlewire.errors import LimitReachedError, StoppedError, TurtlewireError
from turtlewire.logo import blame, erract, errors, tags, tracing
from turtlewire.logo.errors import LogoError, Position
from turtlewire.logo.events import Events, handle_limit
from turtlewire.logo.library import VARIABLES
from turtlewire.logo.marks import Marks
from turtlewire.logo.primitives import PRIMITIVES
from turtlewire.logo.procedures import (
    BODY,
    COMMAND,
    LAST,
    OPERATION,
    BadInputError,
    ExitError,
    Goto,
    Output,
    Primitive,
    Result,
    RunList,
    Stop,
    TailCall,
    ThrowError,
    UserProcedure,
)
from turtlewire.logo.progress import Progress
from turtlewire.logo.reader import Definition, Line, line_of, read
from turtlewire.logo.recursion import room_for_recursion
from turtlewire.logo.scope import bind
from turtlewire.logo.streams import Streams
from turtlewire.logo.syntax import (
    Call,
    Code,
    Failure,
    Invocation,
    Literal,
    MaybeOutputCall,
    Node,
    OutputCall,
    Parser,
    Pending,
    Unknown,
    Variable,
)
from turtlewire.logo.tokens import Place, tokenize
from turtlewire.logo.turtles import Turtles
from turtlewire.logo.values import VALUE_TYPES, List, Value, show_in_error
from turtlewire.logo.workspace import define_from_title

if TYPE_CHECKING:
    import random
    from collections.abc import Callable, Mapping
    from types import FrameType

    from turtlewire.logo.compiler import Compiler
    from turtlewire.turtle import Turtle

MAX_DEPTH = 30_000  # procedures within procedures; deeper is a program that never ends
_LINES_KEPT = 20_000
_FRAMES = 1_200_000  # Python calls that this may take: ten for each, when it is not compiled


class Interpreter:
    """A Logo workspace with a turtle; programs that run in it one after the other share it.

    Args:
        turtle: what the graphics and robot primitives command: one turtle, or several by their names.
        write: called with each piece of text that the program prints.
        random: where RANDOM and PICK get their numbers from, and what RERANDOM seeds.
        step_mm: how many millimetres one turtle step is; more than 0.
        compiles: whether procedures become Python functions, which is faster; nothing else depends on it.
        compiled_at: a folder where compiled programs are kept for the next time; ``None``: they are not.
    """

    def __init__(
        self,
        turtle: Turtle | Mapping[str, Turtle],
        write: Callable[[str], object],
        random: random.Random,
        step_mm: float = 1.0,
        *,
        compiles: bool = True,
        compiled_at: str | None = None,
    ) -> None:
        if not 0 < step_mm < float("inf"):
            raise ValueError(f"step_mm must be more than 0, not {step_mm}")
        self.turtles = Turtles(turtle)
        self.turtle = self.turtles.as_one(self.turtles.told)
        self.write = write
        self.random = random
        self.step_mm = step_mm
        self.primitives = PRIMITIVES
        self.procedures: dict[str, Primitive | UserProcedure] = dict(PRIMITIVES)
        self.variables: dict[str, Value] = dict(VARIABLES)
        # The lists of programs, and others that were run, by their first cell: how each was read, and its code.
        self._lines: dict[int, tuple[List, Line]] = {}
        self.lists_change = False  # whether a program has changed a list: it may no longer be what was read
        self.property_lists: dict[str, dict[str, tuple[Value, Value]]] = {}  # names as given, and values
        self.marks = Marks()
        self.marks.buried.variables.update(VARIABLES)
        self._epoch = 0  # changes with every definition: parsed code of an older one is parsed anew
        self.procedure: UserProcedure | None = None
        self.test: bool | None = None
        self.slots: list[Value] = []  # what ? stands for
        self.iteration: tuple[int, list[Value]] | None = (
            None  # what # and ?REST stand for: how far, through what
        )
        self.baskets: tuple[Value, Value] | None = None  # what ?IN and ?OUT stand for
        self.repeat_count = -1
        self.events = Events()
        self.last_error: LogoError | None = None
        self.symbols_made = 0
        self.acting_on: LogoError | None = None  # the error for which ERRACT is running
        self.ask: Callable[[str], str | None] | None = None  # see ``pausing``
        self.escaping: BaseException | None = None  # an error of the robot that is on its way out
        self.hidden: dict[str, Value | None] = {}  # what the running procedure's variables hide
        self.value_wanted = False  # whether what the primitive that is running outputs is used
        self._wants_value = False
        self._depth = 0
        self._node: Node | None = None
        self._ended_at: Place = None  # where a compiled program was when it was interrupted
        self._body: tuple[Code, list[int]] | None = None  # of the running procedure, and how far it is
        self._is_traced = False  # whether the running procedure is: then nothing takes its place
        self.levels = Progress()
        self.streams = Streams(self)
        self._compiles = compiles
        self._compiled_at = compiled_at
        self._compiler: Compiler | None = None

    # --- running programs -------------------------------------------------------------------------------------

    def run(self, source: str, name: str = "", *, keeps_files: bool = False) -> None:
        """Run a whole program.

        Args:
            source: the program's text.
            name: its file name, for error messages.
            keeps_files: whether the files that it opens stay open, for the next one; ``streams.finish`` closes them.

        Raises:
            LogoError: the program is wrong. Nothing of it has run when it could not be read.
            LinkError, RobotError, MessageError: whatever the turtle raised, with a note of the place in the program.
        """
        failed = True
        try:
            with room_for_recursion(_FRAMES):
                try:
                    self._run(source, name)
                except BaseException as error:
                    if self._compiler is not None:
                        self._ended_at = self._compiler.place_of(error)[0]
                    if isinstance(error, KeyboardInterrupt | StoppedError):
                        self._say_last_words()
                    raise
            failed = False
        finally:
            self.streams.keyboard.rest()
            if self._compiler is not None:
                self._compiler.save()
            if not keeps_files:
                self.streams.finish(failed=failed)
            elif failed:
                self.streams.to_terminal()

    def _say_last_words(self) -> None:
        from turtlewire.logo.last_words import speak  # it needs this module

        speak(self)

    def _run(self, source: str, name: str) -> None:
        self.reset()
        self._ended_at = None
        if "erract" in source.lower():
            self.compiler.switch_off()
        program = read(source, name)
        level = self.levels.start(len(program))
        try:
            for index, line in enumerate(program):
                level[0] = index
                if isinstance(line, Definition):
                    define_from_title(self, line)
                elif (function := self.compiler.line(line)) is not None:
                    self._call(function, [])
                else:
                    self.run_line(line, COMMAND)
        except ThrowError as thrown:
            if thrown.tag != "toplevel":
                error = LogoError(14, f"Can't find catch tag for {thrown.tag}")
                place = self.compiler.place_of(thrown)[0] or self._place_now()
                raise blame.placed(self, error, place) from None
        except RecursionError as deep:
            place, procedure = self.compiler.place_of(deep)
            raise blame.placed(self, errors.stack_overflow(), place or self._place_now(), procedure) from None
        self.levels.finish()

    def reset(self) -> None:
        """Forget what a program that ended in an error, or by a key, may have left behind."""
        self._is_traced = False
        self.marks.trace_depth = 0
        self.procedure = None
        self.test = None
        self.repeat_count = -1
        self.iteration = None
        self.baskets = None
        self.slots = []
        self.hidden = {}
        self._depth = 0
        self.acting_on = None
        self.escaping = None
        self._node = None
        self._body = None

    def progress(self) -> float | None:
        """How far the program has come, 0 to 1, an estimate that never goes back; ``None`` before the first run.

        Cheap, and safe to ask from another thread.
        """
        return self.levels.estimate()

    @property
    def position(self) -> Position | None:
        """Where in the program the evaluator is, ``None`` before it has begun. Safe to ask from another thread."""
        place = self._place_now()
        # What runs last in whatever thread it is: compiled, it says so itself.
        for frame in sys._current_frames().values():
            here: FrameType | None = frame
            while here is not None:
                if here.f_code is _EVALUATES and here.f_locals.get("self") is self:
                    break
                found = self.compiler.place_in(here.f_code, here.f_lineno)
                if found is not None:
                    return found[0].position(found[1])
                here = here.f_back
        place = self._ended_at or place
        return place[0].position(place[1]) if place is not None else None

    @property
    def instruction(self) -> List | None:
        """The line of its body that the running procedure is at, ``None`` at top level."""
        if self._body is None:
            return None
        code, level = self._body
        return code.lines[level[0]].value if level[0] < len(code.lines) else None

    def _place_now(self) -> Place:
        node = self._node
        return node.place if node is not None else None

    # --- instruction lists ------------------------------------------------------------------------------------

    def run_list(self, instructions: Value, how: int = COMMAND) -> Result:
        """Run an instruction list (or a word, as a list of it).

        Returns:
            With ``how == OPERATION`` the value of its last expression, if any; otherwise ``None``; or what ended
            it early: a ``Stop``, ``Output`` or ``TailCall``, to be handed on at once.
        """
        return self.run_code(self.parsed(instructions), how)

    def value_of(self, instructions: Value, *, single: bool = False) -> Value | None:
        """The value that an instruction list outputs, ``None`` without one.

        Raises:
            LogoError: with ``single``, when it holds more than one expression.
        """
        code = self.parsed(instructions)
        if single:
            blame.refuse_several(code)
        result = self.run_code(code, OPERATION)
        if result is None or type(result) in VALUE_TYPES:
            return result  # type: ignore[return-value]
        raise ExitError(result)

    def set_limit_handler(self, handler: List | None) -> None:
        """Install what is run when a limit sensor ends a command, or remove it."""
        self.turtles.all.set_step_by_step(handler is not None)
        self.events.limit = handler
        self.events.limit_changed = True

    def parsed(self, instructions: Value) -> Code:
        """The code of an instruction list; kept with the list until a procedure is defined."""
        if not isinstance(instructions, list):
            return self._parse(Line((instructions,)))
        return self._code_of(self.line(instructions))

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

    def run_line(self, line: Line, how: int = COMMAND) -> Result:
        """``run_list`` for a line of the program."""
        return self.run_code(self._code_of(line), how)

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

    def _code_of(self, line: Line) -> Code:
        code: Code | None = line.code
        if code is None or code.epoch != self._epoch:
            code = line.code = self._parse(line)
        return code

    def _parse(self, line: Line) -> Code:
        return Code(Parser(tokenize(line), self.procedures, self.remember).parse(), self._epoch)

    def run_code(self, code: Code, how: int, level: list[int] | None = None) -> Result:
        """Run parsed instructions; see ``run_list``. ``level`` is what ``progress`` watches them by, if it does."""
        before = how if how < LAST else BODY if how == LAST else COMMAND
        place: Place = None
        try:
            while True:
                for node in code.instructions:
                    self._node = node
                    result = self.evaluate(node, before)
                    if result is not None:
                        if type(result) in VALUE_TYPES:
                            blame.refuse_value(self, node, result)
                        return result
                    if level is not None:
                        level[0] += 1
                last = code.last
                if last is None:
                    return None
                self._node = last
                result = self.evaluate(last, how, in_place=True)
                if type(result) is not RunList:
                    if how != OPERATION and type(result) in VALUE_TYPES:
                        blame.refuse_value(self, last, result)
                    return result
                # A list in the place of the last instruction, as of IF or of a macro: not one call deeper.
                place = last.place or place
                code = self.parsed(result.instructions)
                level = None
        except LogoError as error:
            if place is not None and not error.is_for_caller:
                blame.placed(self, error, place)
            raise

    def _run_body(self, procedure: UserProcedure) -> Result:
        """Run the lines of a procedure, watched for ``progress`` when it is one of the outermost."""
        code = self.body_of(procedure)
        watched = self.levels.enter(len(code.instructions) + 1)
        self._body = code, watched or [0]
        try:
            while True:
                try:
                    result = self.run_code(code, LAST, self._body[1])
                except ExitError as ended:
                    result = ended.signal
                if type(result) is not Goto:
                    return result
                code = tags.code_from(self, procedure, result.tag)
                self._body = code, [0]
        finally:
            if watched is not None:
                self.levels.leave()

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

    # --- expressions ------------------------------------------------------------------------------------------

    def evaluate(self, node: Node, how: int = OPERATION, *, in_place: bool = False) -> Result:
        """Evaluate one expression or instruction.

        Args:
            node: the expression or instruction.
            how: how its result is used, see ``procedures``.
            in_place: the result may be a ``RunList``, which the caller runs; otherwise it is run here.
        """
        # type() and not isinstance(): mypy narrows by both, and this is where the time goes.
        if type(node) is Literal:
            return node.value
        if type(node) is Variable:
            found = self.variables.get(node.key)
            return found if found is not None else self._instead(node, "", None)
        if type(node) is OutputCall:
            return self._output(node, how)
        if not (type(node) is Call or type(node) is Invocation):
            return self._evaluate_unparsed(node, how)
        inputs: list[Value] = []
        try:
            for each in node.inputs:
                if type(each) is Literal:
                    inputs.append(each.value)
                    continue
                value = self.variables.get(each.key) if type(each) is Variable else self.evaluate(each)
                if type(value) not in VALUE_TYPES:
                    value = self._instead(each, node.name, value)
                inputs.append(value)  # type: ignore[arg-type]
            result: Result
            if isinstance(node, Invocation):
                if node.procedure.is_macro:
                    result = self.expansion(node, inputs, may_be_empty=in_place or how != OPERATION)
                elif how == LAST and not self._wants_value and not self._is_traced:
                    return TailCall(node, inputs)
                else:
                    return self.invoke(node, inputs, wants_value=how == OPERATION)
            else:
                self.value_wanted = how == OPERATION
                result = self.call_primitive(node.primitive, inputs)
            if type(result) is RunList and not in_place:
                code = self.parsed(result.instructions)
                if how == OPERATION:
                    blame.refuse_several(code)
                return self.run_code(code, how)
            return result
        except BadInputError as bad:
            return self._instead_of_bad(node, inputs, bad, how)
        except LogoError as error:
            if error.is_for_caller:
                raise
            if error.is_known:
                blame.placed(self, error, node.place)
                raise
            return self.fail(error, node.place)
        except LimitReachedError as limit:
            return handle_limit(self, limit, node)
        except TurtlewireError as trouble:
            blame.annotate(self, trouble, node)
            raise

    def call_primitive(self, primitive: Primitive, inputs: list[Value]) -> Result:
        """Call a primitive; written out by count, because ``f(*inputs)`` would go through the C stack."""
        function = primitive.function
        count = len(inputs)
        if primitive.maximum_inputs < 0:
            return function(self, inputs)
        if count == 1:
            return function(self, inputs[0])
        if count == 2:
            return function(self, inputs[0], inputs[1])
        if count == 0:
            return function(self)
        return function(self, inputs[0], inputs[1], inputs[2])

    def _has_setter(self, name: str) -> bool:
        return name in self.variables or name in self.marks.declared

    def _output(self, node: OutputCall, how: int) -> Result:
        if self.procedure is None:
            self.fail(errors.outside_procedure(node.name), node.place)
        each = node.inputs[0]
        if (
            type(each) is Invocation
            and self._wants_value
            and how in (LAST, BODY)
            and not (each.procedure.is_macro or self._is_traced)
        ):
            return TailCall(each, self.inputs_of(each))
        value = self._evaluate_last(each)
        if type(value) not in VALUE_TYPES:
            value = self._instead(each, node.name, value)
        return Output(value)  # type: ignore[arg-type]

    def _evaluate_last(self, node: Node) -> Result:
        """The input of OUTPUT: as if it were the last instruction, it may be a list of several."""
        result = self.evaluate(node, in_place=True)
        return self.run_list(result.instructions, OPERATION) if type(result) is RunList else result

    def _maybe_output(self, node: MaybeOutputCall, how: int) -> Result:
        if self.procedure is None:
            self.fail(errors.outside_procedure(node.name), node.place)
        each = node.inputs[0]
        takes_place = how in (LAST, BODY) and not self._is_traced
        if type(each) is Invocation and takes_place and not each.procedure.is_macro:
            return TailCall(each, self.inputs_of(each), may_output=True)
        result = self._evaluate_last(each)
        if result is None:
            return Stop()
        return Output(result) if type(result) in VALUE_TYPES else result  # type: ignore[arg-type]

    def inputs_of(self, node: Invocation) -> list[Value]:
        """The inputs of an invocation, evaluated."""
        inputs: list[Value] = []
        for each in node.inputs:
            value = self.evaluate(each)
            if type(value) not in VALUE_TYPES:
                value = self._instead(each, node.name, value)
            inputs.append(value)  # type: ignore[arg-type]
        return inputs

    def _evaluate_unparsed(self, node: Node, how: int) -> Result:
        if isinstance(node, MaybeOutputCall):
            return self._maybe_output(node, how)
        if isinstance(node, Failure):
            return self.fail(node.error.copy(), node.place)
        if isinstance(node, Pending):
            return self.run_code(Code(self.parse_pending(node), self._epoch), how)
        assert isinstance(node, Unknown)
        value = self.variables.get(node.name.lower())
        if value is None:
            return self.fail(errors.unknown_procedure(node.name, list(self.procedures)), node.place)
        return value

    def parse_pending(self, node: Pending) -> list[Node]:
        """The rest of a line, now that its first instruction is to run."""
        return Parser(node.tokens, self.procedures, self.remember, self._has_setter).parse()

    def expansion(self, node: Invocation, inputs: list[Value], *, may_be_empty: bool) -> RunList:
        """What a macro outputs, to be run in its caller's place."""
        value = self.invoke(node, inputs, wants_value=True)
        if type(value) is not list:
            error = errors.no_expansion(show_in_error(value) if value is not None else "nothing")
            error.procedure = node.procedure.name
            error.instruction = node.procedure.body[-1].value if node.procedure.body else None
            raise error
        if not (value or may_be_empty):
            raise errors.no_expansion("[]")
        return RunList(value)

    # --- errors -----------------------------------------------------------------------------------------------

    def fail(self, error: LogoError, place: Place) -> Value:
        """Give an error its place and raise it; or output what ERRACT says instead, if it does."""
        blame.placed(self, error, place)
        return erract.value_instead(self, error)

    def _instead(self, node: Node, wanted_by: str, result: Result) -> Value:
        """What stands in for an input that is no value; otherwise its error is raised, or the procedure ends."""
        if isinstance(result, Stop | Output | Goto):
            raise ExitError(result)
        return self.fail(blame.about_input(self, node, wanted_by), node.place)

    def _instead_of_bad(
        self, node: Call | Invocation, inputs: list[Value], bad: BadInputError, how: int
    ) -> Result:
        """Call a primitive again with what ERRACT says instead of an input that it does not like."""
        error = errors.does_not_like(
            node.name, show_in_error(bad.value), number=bad.number, wanted=bad.wanted
        )
        value = self.fail(error, node.place)
        if isinstance(node, Call):
            for index, each in enumerate(inputs):
                if each is bad.value:
                    literals: list[Node] = [Literal(given, node.place) for given in inputs]
                    literals[index] = Literal(value, node.place)
                    erract.refuse_loop(self, bad.value, value)
                    return self.evaluate(Call(node.primitive, node.name, literals, node.place), how)
        raise error

    # --- procedures -------------------------------------------------------------------------------------------

    def invoke(self, node: Invocation, inputs: list[Value], *, wants_value: bool) -> Value | None:
        """Invoke a user's procedure, and whatever takes its place."""
        if self._depth >= MAX_DEPTH:
            raise errors.stack_overflow()
        outer = (self.hidden, self.procedure, self._wants_value, self.test, self._body, self._is_traced)
        marks = self.marks
        depth = marks.trace_depth
        hidden: dict[str, Value | None] = {}
        self.hidden = hidden
        self._wants_value = wants_value
        self._depth += 1
        tail_call: TailCall | None = None
        caller = self.procedure
        result: Result = None
        procedure, is_traced = node.procedure, False
        try:
            while True:
                procedure = node.procedure
                function = self.compiler.function(procedure)
                if function is not None and len(inputs) == len(procedure.inputs):
                    value = self._call(function, inputs)
                    result = None if value is None else Output(value)
                    break
                bind(self, procedure, inputs, node.name)
                self.procedure = procedure
                traced = marks.traced.procedures
                self._is_traced = is_traced = bool(traced) and procedure.name.lower() in traced
                if is_traced:
                    tracing.tell_invoked(self, procedure.name, inputs)
                result = self._run_body(procedure)
                if type(result) is not TailCall:
                    break
                tail_call, caller = result, procedure
                node, inputs = result.node, result.inputs
        except ExitError as ended:
            result = ended.signal
        except LogoError as error:
            if error.is_for_caller:
                error.is_for_caller = False
                if tail_call is not None:
                    blame.placed(self, error, node.place, caller)
            raise
        finally:
            self._depth -= 1
            for name, value in hidden.items():
                if value is None:
                    self.variables.pop(name, None)
                else:
                    self.variables[name] = value
            (self.hidden, self.procedure, self._wants_value, self.test, self._body, self._is_traced) = outer
            marks.trace_depth = depth
        value = result.value if type(result) is Output else None
        if is_traced:
            tracing.tell_ended(self, procedure.name, value)
        if tail_call is not None and not tail_call.may_output and (value is not None) is not wants_value:
            if value is None:
                mismatch = errors.did_not_output(node.name, "output")
            else:
                mismatch = errors.unused_value(show_in_error(value), from_procedure=True)
            blame.placed(self, mismatch, node.place, caller)
            return self.fail(mismatch, node.place)
        return value

    def _call(self, function: Callable[..., Value | None], inputs: list[Value]) -> Value | None:
        """Call a compiled function; written out by count, as ``call_primitive``."""
        count = len(inputs)
        try:
            if count == 0:
                return function()
            if count == 1:
                return function(inputs[0])
            if count == 2:
                return function(inputs[0], inputs[1])
            if count == 3:
                return function(inputs[0], inputs[1], inputs[2])
            return function(*inputs)
        except Exception as fault:
            error = self.compiler.translated(fault)
            if error is fault:
                raise
            raise error from None

    @property
    def epoch(self) -> int:
        """Counts what changes the meaning of programs: definitions, and what is traced and stepped."""
        return self._epoch

    @epoch.setter
    def epoch(self, epoch: int) -> None:
        self._epoch = epoch
        if self._compiler is not None:
            self._compiler.forget()

    @property
    def compiler(self) -> Compiler:
        """What makes Python functions of procedures; loaded when there is something to compile."""
        if self._compiler is None:
            from turtlewire.logo.compiler import Compiler, Store

            store = Store(self._compiled_at) if self._compiled_at is not None else None
            self._compiler = Compiler(self, is_used=self._compiles, store=store)
        return self._compiler

    @compiler.setter
    def compiler(self, compiler: Compiler) -> None:
        self._compiler = compiler

    def is_watched(self, procedure: UserProcedure) -> bool:
        """Whether somebody wants to see each instruction of a procedure, or its calls, or a variable."""
        traced, name = self.marks.traced, procedure.name.lower()
        return bool(traced.variables) or name in traced.procedures or name in self.marks.stepped.procedures

    # --- limit sensors ----------------------------------------------------------------------------------------

    def watching_limits(self, primitive: Primitive) -> Callable[..., Result]:
        """A primitive that moves the robot, for compiled functions: ONLIMIT is heeded."""
        function = primitive.function

        def none(logo: Interpreter) -> Result:
            try:
                return function(logo)
            except LimitReachedError as limit:
                return self._limit_reached(limit, sys._getframe(1))

        def one(logo: Interpreter, value: Value) -> Result:
            try:
                return function(logo, value)
            except LimitReachedError as limit:
                return self._limit_reached(limit, sys._getframe(1))

        def more(logo: Interpreter, *inputs: Value) -> Result:
            try:
                return function(logo, *inputs)
            except LimitReachedError as limit:
                return self._limit_reached(limit, sys._getframe(1))

        fewest, most = primitive.minimum_inputs, primitive.maximum_inputs
        if fewest == most == 0:
            return none
        return one if fewest == most == 1 else more

    def _limit_reached(self, limit: LimitReachedError, frame: FrameType) -> Result:
        node, procedure = self.compiler.node_at(frame)
        outer, self.procedure = self.procedure, procedure
        try:
            return handle_limit(self, limit, node)
        finally:
            self.procedure = outer


_EVALUATES = Interpreter.run_code.__code__
