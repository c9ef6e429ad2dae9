"""The evaluator: plain and complete; what it does is the measure for anything faster.

Variables are dynamically scoped: one table of values, and each running procedure remembers what its inputs and locals
hid (shallow binding). A procedure called last, or by OUTPUT, takes the place of its caller; what the caller's own
variables hid stays remembered with it, so dynamic scope is not disturbed. Calls that are not last nest Python calls
of Python functions, which CPython keeps off the C stack; nothing between two of them may be a C function.
"""

from __future__ import annotations

from turtlewire.errors import LimitReachedError, StoppedError, TurtlewireError
from turtlewire.logo import blame, calls, erract, errors
from turtlewire.logo.errors import LogoError, Position
from turtlewire.logo.events import Events, handle_limit
from turtlewire.logo.procedures import (
    BODY,
    COMMAND,
    LAST,
    OPERATION,
    BadInputError,
    ExitError,
    Goto,
    Output,
    Result,
    RunList,
    Stop,
    TailCall,
    UserProcedure,
)
from turtlewire.logo.progress import Progress, running_place
from turtlewire.logo.room import RoomForRecursion, reserve
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
    Pending,
    Unknown,
    Variable,
)
from turtlewire.logo.top_level import run_lines
from turtlewire.logo.turtles import Turtles
from turtlewire.logo.values import VALUE_TYPES, List, Value
from turtlewire.logo.workspace import Workspace

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from random import Random

    from turtlewire.logo.compiler import Compiler
    from turtlewire.logo.debugging import Debugger
    from turtlewire.logo.reader import Line
    from turtlewire.logo.tokens import Place
    from turtlewire.turtle import Turtle

_FRAMES = 1_200_000  # Python calls that this may take: ten for each, when it is not compiled


class Interpreter(Workspace):
    """A Logo workspace with a turtle; programs that run in it one after the other share it.

    Args:
        turtle: what the graphics and robot primitives command: one turtle, or several by their names.
        write: called with each piece of text that the program prints.
        random: where RANDOM and PICK get their numbers from, or what makes that when it is wanted.
        step_mm: how many millimetres one turtle step is; more than 0.
        compiles: whether procedures become Python functions, which is faster; nothing else depends on it.
        compiled_at: a folder where compiled programs are kept for the next time; ``None``: they are not.
    """

    def __init__(
        self,
        turtle: Turtle | Mapping[str, Turtle],
        write: Callable[[str], object],
        random: Random | Callable[[], Random],
        step_mm: float = 1.0,
        *,
        compiles: bool = True,
        compiled_at: str | None = None,
    ) -> None:
        if not 0 < step_mm < float("inf"):
            raise ValueError(f"step_mm must be more than 0, not {step_mm}")
        super().__init__()
        self.turtles = Turtles(turtle)
        self.turtle = self.turtles.as_one(self.turtles.told)
        self.write = write
        self._random = random
        self.step_mm = step_mm
        self.procedure: UserProcedure | None = None
        self.test: bool | None = None
        self.slots: list[Value] = []  # what ? stands for
        self.iteration: tuple[int, list[Value]] | None = None  # of # and ?REST: how far, through what
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
        self.must_output = False  # whether what the running procedure outputs is used
        self.depth = 0  # of procedures within procedures
        self.node: Node | None = None  # the instruction that the evaluator is at
        self._ended_at: Place = None  # where a compiled program was when it was interrupted
        self.body: tuple[Code, list[int]] | None = None  # of the running procedure, and how far it is
        self.is_traced = False  # whether the running procedure is: then nothing takes its place
        self.levels = Progress()
        self.streams = Streams(self)
        self._compiles = compiles
        self._compiled_at = compiled_at
        self._compiler: Compiler | None = None
        self.reserve = b""  # memory for the end of a program that has used up all the rest

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
        self.reserve = reserve()
        try:
            with RoomForRecursion(_FRAMES):
                try:
                    self._ended_at = None
                    run_lines(self, source, name)
                except BaseException as error:
                    if self._compiler is not None:
                        self._ended_at = self._compiler.place_of(error)[0]
                    if isinstance(error, KeyboardInterrupt | StoppedError):
                        from turtlewire.logo.last_words import speak  # it needs this module

                        speak(self)
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

    def reset(self) -> None:
        """Forget what a program that ended in an error, or by a key, may have left behind."""
        self.is_traced = False
        self.marks.trace_depth = 0
        self.procedure = None
        self.test = None
        self.repeat_count = -1
        self.iteration = None
        self.baskets = None
        self.slots = []
        self.hidden = {}
        self.depth = 0
        self.acting_on = None
        self.escaping = None
        self.node = None
        self.body = None

    def attach(self, debugger: Debugger | None) -> None:
        """Have a debugger look at the programs that begin from now on; ``None``: nobody looks any longer."""
        self.debugger = debugger
        self.epoch += 1  # nothing that is looked at is compiled

    def progress(self) -> float | None:
        """An estimate, 0 to 1, that never goes back; ``None`` before the first run. Cheap, and safe in any thread."""
        return self.levels.estimate()

    @property
    def position(self) -> Position | None:
        """Where in the program the evaluator is, ``None`` before it has begun. Safe to ask from another thread."""
        place = running_place(self, Interpreter.run_code.__code__) or self._ended_at or self.place
        return place[0].position(place[1]) if place is not None else None

    @property
    def instruction(self) -> List | None:
        """The line of its body that the running procedure is at, ``None`` at top level."""
        if self.body is None:
            return None
        code, level = self.body
        return code.lines[level[0]].value if level[0] < len(code.lines) else None

    @property
    def place(self) -> Place:
        """Where the instruction that the evaluator is at stands."""
        return node.place if (node := self.node) is not None else None

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

    def run_line(self, line: Line, how: int = COMMAND) -> Result:
        """``run_list`` for a line of the program."""
        return self.run_code(self.code_of(line), how)

    def run_code(self, code: Code, how: int, level: list[int] | None = None) -> Result:
        """Run parsed instructions; see ``run_list``. ``level`` is what ``progress`` watches them by, if it does."""
        before = how if how < LAST else BODY if how == LAST else COMMAND
        place: Place = None
        debugger = self.debugger
        depth = debugger.enter(is_body=level is not None) if debugger is not None else 0
        try:
            while True:
                for node in code.instructions:
                    self.node = node
                    if debugger is not None:
                        debugger.before(self, node, code, how, level)
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
                self.node = last
                if debugger is not None:
                    debugger.before(self, last, code, how, level)
                result = self.evaluate(last, how, in_place=True)
                if type(result) is not RunList:
                    if how != OPERATION and type(result) in VALUE_TYPES:
                        blame.refuse_value(self, last, result)
                    return result
                # A list in the place of the last instruction, as of IF or of a macro: not one call deeper.
                place = last.place or place
                code = self.parsed(result.instructions)
                level = None
                if debugger is not None:
                    debugger.in_place(depth)
        except LogoError as error:
            if place is not None and not error.is_for_caller:
                blame.placed(self, error, place)
            raise
        finally:
            if debugger is not None:
                debugger.leave(depth)

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
            return found if found is not None else self.instead(node, "", None)
        if type(node) is OutputCall:
            return calls.output(self, node, how)
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
                    value = self.instead(each, node.name, value)
                inputs.append(value)  # type: ignore[arg-type]
            result: Result
            if isinstance(node, Invocation):
                if node.procedure.is_macro:
                    result = calls.expansion(self, node, inputs, may_be_empty=in_place or how != OPERATION)
                elif how == LAST and not self.must_output and not self.is_traced:
                    return TailCall(node, inputs)
                else:
                    return calls.invoke(self, node, inputs, wants_value=how == OPERATION)
            else:
                self.value_wanted = how == OPERATION
                result = calls.call_primitive(self, node.primitive, inputs)
            if type(result) is RunList and not in_place:
                code = self.parsed(result.instructions)
                if how == OPERATION:
                    blame.refuse_several(code)
                return self.run_code(code, how)
            return result
        except BadInputError as bad:
            return erract.call_again(self, node, inputs, bad, how)
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

    def _evaluate_unparsed(self, node: Node, how: int) -> Result:
        if isinstance(node, MaybeOutputCall):
            return calls.maybe_output(self, node, how)
        if isinstance(node, Failure):
            return self.fail(node.error.copy(), node.place)
        if isinstance(node, Pending):
            return self.run_code(Code(self.parse_pending(node), self._epoch), how)
        assert isinstance(node, Unknown)
        value = self.variables.get(node.name.lower())
        if value is None:
            return self.fail(errors.unknown_procedure(node.name, list(self.procedures)), node.place)
        return value

    # --- errors -----------------------------------------------------------------------------------------------

    def fail(self, error: LogoError, place: Place) -> Value:
        """Give an error its place and raise it; or output what ERRACT says instead, if it does."""
        blame.placed(self, error, place)
        return erract.value_instead(self, error)

    def instead(self, node: Node, wanted_by: str, result: Result) -> Value:
        """What stands in for an input that is no value; otherwise its error is raised, or the procedure ends."""
        if isinstance(result, Stop | Output | Goto):
            raise ExitError(result)
        return self.fail(blame.about_input(self, node, wanted_by), node.place)

    # --- what is made when it is wanted ------------------------------------------------------------------------

    @property
    def random(self) -> Random:
        """Where RANDOM and PICK get their numbers from."""
        if callable(self._random):
            self._random = self._random()
        return self._random

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
