"""The evaluator: plain and complete; what it does is the measure for anything faster.

Variables are dynamically scoped: one table of values, and each running procedure remembers what its inputs and locals
hid (shallow binding). A procedure called last, or by OUTPUT, takes the place of its caller; what the caller's own
variables hid stays remembered with it, so dynamic scope is not disturbed. Calls that are not last nest Python calls
of Python functions, which CPython keeps off the C stack; nothing between two of them may be a C function.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, NoReturn

from turtlewire.errors import LimitReachedError, TurtlewireError
from turtlewire.logo import errors
from turtlewire.logo.errors import LogoError, Position
from turtlewire.logo.procedures import Output, Primitive, Result, RunList, Stop, TailCall, UserProcedure
from turtlewire.logo.progress import Progress
from turtlewire.logo.reader import Definition, read
from turtlewire.logo.syntax import (
    Call,
    Code,
    Failure,
    Invocation,
    Literal,
    Node,
    OutputCall,
    Parser,
    Pending,
    Place,
    Unknown,
    Variable,
    tokenize,
)
from turtlewire.logo.values import VALUE_TYPES, LogoList, Value, show_in_error
from turtlewire.logo.workspace import define_from_title

if TYPE_CHECKING:
    import random
    from collections.abc import Callable

    from turtlewire.turtle import Turtle

# How the result of an evaluation is used.
COMMAND = 0  # it must not output
BODY = 1  # the same, directly within a procedure's body: OUTPUT ends the procedure
LAST = 2  # the same, and nothing of the procedure comes after it
OPERATION = 3  # it must output

MAX_DEPTH = 30_000  # procedures within procedures; deeper is a program that never ends
_FRAMES = 10 * MAX_DEPTH  # Python calls that this may take

_limits: list[int] = []  # for each running program, the recursion limit to be put back


class BadInputError(Exception):
    """A primitive does not like an input; becomes "... doesn't like ... as input"."""

    def __init__(self, value: Value, number: int = 7) -> None:
        super().__init__(value)
        self.value = value
        self.number = number


class ThrowError(Exception):
    """THROW on its way to its CATCH."""

    def __init__(self, tag: str, value: Value | None) -> None:
        super().__init__(tag)
        self.tag = tag
        self.value = value


class _ExitError(Exception):
    """STOP or OUTPUT from within an input, on its way to the end of the procedure."""

    def __init__(self, signal: Result) -> None:
        super().__init__()
        self.signal = signal


class Interpreter:
    """A Logo workspace with a turtle; programs that run in it one after the other share it.

    Args:
        turtle: what the graphics and robot primitives command.
        write: called with each piece of text that the program prints.
        random: where RANDOM and PICK get their numbers from, and what RERANDOM seeds.
        step_mm: how many millimetres one turtle step is; more than 0.
    """

    def __init__(
        self, turtle: Turtle, write: Callable[[str], object], random: random.Random, step_mm: float = 1.0
    ) -> None:
        from turtlewire.logo.primitives import PRIMITIVES

        if not 0 < step_mm < float("inf"):
            raise ValueError(f"step_mm must be more than 0, not {step_mm}")
        self.turtle = turtle
        self.write = write
        self.random = random
        self.step_mm = step_mm
        self.procedures: dict[str, Primitive | UserProcedure] = dict(PRIMITIVES)
        self.variables: dict[str, Value] = {}
        self.property_lists: dict[str, dict[str, Value]] = {}
        self.epoch = 0  # changes with every definition: parsed code of an older one is parsed anew
        self.procedure: UserProcedure | None = None
        self.test: bool | None = None
        self.slots: list[Value] = []  # what ? stands for
        self.repeat_count = -1
        self.limit_handler: LogoList | None = None
        self.limit_handler_changed = False
        self.limit_sensor = ""
        self.last_error: LogoError | None = None
        self.symbols_made = 0
        self._hidden: dict[str, Value | None] = {}  # what the running procedure's variables hide
        self._wants_value = False
        self._depth = 0
        self._escaping: BaseException | None = None
        self._node: Node | None = None
        self.levels = Progress()

    # --- running programs -------------------------------------------------------------------------------------

    def run(self, source: str, name: str = "") -> None:
        """Run a whole program.

        Args:
            source: the program's text.
            name: its file name, for error messages.

        Raises:
            LogoError: the program is wrong. Nothing of it has run when it could not be read.
            LinkError, RobotError, MessageError: whatever the turtle raised, with a note of the place in the program.
        """
        limit = _limits[0] if _limits else sys.getrecursionlimit()
        _limits.append(limit)
        sys.setrecursionlimit(max(limit, _FRAMES))
        try:
            self._run(source, name)
        finally:
            # Another interpreter may be running in another thread: the last one puts back what the first one found.
            found = _limits[0] if len(_limits) == 1 else _FRAMES
            _limits.remove(limit)
            sys.setrecursionlimit(found)

    def _run(self, source: str, name: str) -> None:
        self._reset()
        program = read(source, name)
        level = self.levels.start(len(program))
        try:
            for index, line in enumerate(program):
                level[0] = index
                if isinstance(line, Definition):
                    define_from_title(self, line)
                else:
                    self.run_list(line, COMMAND)
        except ThrowError as thrown:
            if thrown.tag != "toplevel":
                error = LogoError(14, f"Can't find catch tag for {thrown.tag}")
                raise self._placed(error, self._place_now()) from None
        except RecursionError:
            raise self._placed(errors.stack_overflow(), self._place_now()) from None
        self.levels.finish()

    def _reset(self) -> None:
        """Forget what a program that ended in an error, or by a key, may have left behind."""
        self.procedure = None
        self.test = None
        self.repeat_count = -1
        self._hidden = {}
        self._depth = 0
        self._escaping = None
        self._node = None

    def progress(self) -> float | None:
        """How far the program has come, 0 to 1, an estimate that never goes back; ``None`` before the first run.

        Cheap, and safe to ask from another thread.
        """
        return self.levels.estimate()

    @property
    def position(self) -> Position | None:
        """Where in the program the evaluator is, ``None`` before it has begun. Safe to ask from another thread."""
        place = self._place_now()
        return place[0].position(place[1]) if place is not None else None

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

    def value_of(self, instructions: Value) -> Value | None:
        """The value that an instruction list outputs, ``None`` without one."""
        result = self.run_code(self.parsed(instructions), OPERATION)
        if result is None or type(result) in VALUE_TYPES:
            return result  # type: ignore[return-value]
        raise _ExitError(result)

    def set_limit_handler(self, handler: LogoList | None) -> None:
        """Install what is run when a limit sensor ends a command, or remove it."""
        self.turtle.set_step_by_step(handler is not None)
        self.limit_handler = handler
        self.limit_handler_changed = True

    def parsed(self, instructions: Value) -> Code:
        """The code of an instruction list; kept with the list until a procedure is defined."""
        if not isinstance(instructions, LogoList):
            instructions = LogoList((instructions,))
        code: Code | None = instructions.code
        if code is None or code.epoch != self.epoch:
            code = instructions.code = self._parse(instructions)
        return code

    def _parse(self, instructions: LogoList) -> Code:
        return Code(Parser(tokenize(instructions), self.procedures).parse(), self.epoch)

    def run_code(self, code: Code, how: int, level: list[int] | None = None) -> Result:
        """Run parsed instructions; see ``run_list``. ``level`` is what ``progress`` watches them by, if it does."""
        before = how if how < LAST else BODY if how == LAST else COMMAND
        for node in code.instructions:
            self._node = node
            result = self.evaluate(node, before)
            if result is not None:
                if type(result) in VALUE_TYPES:
                    self._refuse_value(node, result)
                return result
            if level is not None:
                level[0] += 1
        last = code.last
        if last is None:
            return None
        self._node = last
        result = self.evaluate(last, how)
        if how != OPERATION and type(result) in VALUE_TYPES:
            self._refuse_value(last, result)
        return result

    def _run_body(self, procedure: UserProcedure) -> Result:
        """Run the lines of a procedure, watched for ``progress`` when it is one of the outermost."""
        code: Code | None = procedure.code
        if code is None or code.epoch != self.epoch:
            nodes: list[Node] = []
            for line in procedure.body:
                nodes += Parser(tokenize(line), self.procedures).parse()
            code = procedure.code = Code(nodes, self.epoch)
        level = self.levels.enter(len(code.instructions) + 1)
        if level is None:
            return self.run_code(code, LAST)
        try:
            return self.run_code(code, LAST, level)
        finally:
            self.levels.leave()

    # --- expressions ------------------------------------------------------------------------------------------

    def evaluate(self, node: Node, how: int = OPERATION) -> Result:
        """Evaluate one expression or instruction."""
        # type() and not isinstance(): mypy narrows by both, and this is where the time goes.
        if type(node) is Literal:
            return node.value
        if type(node) is Variable:
            found = self.variables.get(node.key)
            return found if found is not None else self._refuse_variable(node)
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
                    self._refuse_input(each, node.name, value)
                inputs.append(value)  # type: ignore[arg-type]
            if isinstance(node, Invocation):
                if how == LAST and not self._wants_value:
                    return TailCall(node, inputs)
                return self.invoke(node, inputs, wants_value=how == OPERATION)
            result = self.call_primitive(node.primitive, inputs)
            if type(result) is RunList:
                return self.run_list(result.instructions, how)
            return result
        except BadInputError as bad:
            error = errors.does_not_like(node.name, show_in_error(bad.value), number=bad.number)
            raise self._placed(error, node.place) from None
        except LogoError as error:
            self._placed(error, node.place)
            raise
        except LimitReachedError as limit:
            return self._handle_limit(limit, node)
        except TurtlewireError as trouble:
            self._annotate(trouble, node)
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

    def _output(self, node: OutputCall, how: int) -> Result:
        if self.procedure is None:
            raise self._placed(LogoError(31, f"Can only use {node.name} inside a procedure"), node.place)
        each = node.inputs[0]
        if type(each) is Invocation and self._wants_value and how in (LAST, BODY):
            return TailCall(each, self._inputs_of(each))
        value = self.evaluate(each)
        if type(value) not in VALUE_TYPES:
            self._refuse_input(each, node.name, value)
        return Output(value)  # type: ignore[arg-type]

    def _inputs_of(self, node: Invocation) -> list[Value]:
        inputs: list[Value] = []
        for each in node.inputs:
            value = self.evaluate(each)
            if type(value) not in VALUE_TYPES:
                self._refuse_input(each, node.name, value)
            inputs.append(value)  # type: ignore[arg-type]
        return inputs

    def _evaluate_unparsed(self, node: Node, how: int) -> Result:
        if isinstance(node, Failure):
            raise self._placed(node.error.copy(), node.place)
        if isinstance(node, Pending):
            nodes = Parser(node.tokens, self.procedures, self.variables.__contains__).parse()
            return self.run_code(Code(nodes, self.epoch), how)
        assert isinstance(node, Unknown)
        value = self.variables.get(node.name.lower())
        if value is None:
            raise self._placed(errors.unknown_procedure(node.name, list(self.procedures)), node.place)
        return value

    # --- procedures -------------------------------------------------------------------------------------------

    def invoke(self, node: Invocation, inputs: list[Value], *, wants_value: bool) -> Value | None:
        """Invoke a user's procedure, and whatever takes its place."""
        if self._depth >= MAX_DEPTH:
            raise errors.stack_overflow()
        outer = (self._hidden, self.procedure, self._wants_value, self.test)
        hidden: dict[str, Value | None] = {}
        self._hidden = hidden
        self._wants_value = wants_value
        self._depth += 1
        tail_call: TailCall | None = None
        caller = self.procedure
        result: Result = None
        try:
            while True:
                procedure = node.procedure
                self._bind(procedure, inputs, node.name)
                self.procedure = procedure
                result = self._run_body(procedure)
                if type(result) is not TailCall:
                    break
                tail_call, caller = result, procedure
                node, inputs = result.node, result.inputs
        except _ExitError as ended:
            result = ended.signal
        finally:
            self._depth -= 1
            for name, value in hidden.items():
                if value is None:
                    self.variables.pop(name, None)
                else:
                    self.variables[name] = value
            self._hidden, self.procedure, self._wants_value, self.test = outer
        value = result.value if type(result) is Output else None
        if tail_call is not None and (value is not None) is not wants_value:
            if value is None:
                error = errors.did_not_output(node.name, "output")
            else:
                error = errors.unused_value(show_in_error(value), from_procedure=True)
            error.procedure = caller.name if caller is not None else None
            raise self._placed(error, node.place)
        return value

    def _bind(self, procedure: UserProcedure, inputs: list[Value], name: str) -> None:
        """Give the inputs their values; what the names meant before is remembered once per running procedure."""
        variables, hidden = self.variables, self._hidden
        count = len(procedure.inputs)
        if procedure.is_erased:
            raise errors.unknown_procedure(name, list(self.procedures))
        if len(inputs) < count:  # only when it was defined anew since the call was parsed
            raise errors.not_enough_inputs(name)
        index = 0
        for key in procedure.inputs:
            if key not in hidden:
                hidden[key] = variables.get(key)
            variables[key] = inputs[index]
            index += 1
        if len(inputs) == count and not procedure.optional and not procedure.rest:
            return
        for optional in procedure.optional:
            if index < len(inputs):
                value: Result = inputs[index]
            else:
                value = self.run_list(optional.default, OPERATION)
                if type(value) not in VALUE_TYPES:
                    raise LogoError(
                        37, f"Bad default expression for optional input: {show_in_error(optional.default)}"
                    )
            index += 1
            self.set_local(optional.name, value)  # type: ignore[arg-type]
        if procedure.rest:
            self.set_local(procedure.rest, LogoList(inputs[index:]))
        elif index < len(inputs):
            raise errors.too_many_inputs(name)

    def set_local(self, key: str, value: Value | None) -> None:
        """Make a variable local to the running procedure, with a value or without; at top level it is global."""
        if key not in self._hidden:
            self._hidden[key] = self.variables.get(key)
        if value is None:
            self.variables.pop(key, None)
        else:
            self.variables[key] = value

    # --- errors -----------------------------------------------------------------------------------------------

    def _refuse_value(self, node: Node, value: Result) -> NoReturn:
        error = errors.unused_value(show_in_error(value), from_procedure=type(node) is Invocation)  # type: ignore[arg-type]
        raise self._placed(error, node.place)

    def _refuse_variable(self, node: Node) -> NoReturn:
        assert isinstance(node, Variable)
        raise self._placed(errors.no_value(node.name, list(self.variables)), node.place)

    def _refuse_input(self, node: Node, wanted_by: str, result: Result) -> NoReturn:
        """An input that is no value: a variable without one, a command, or the end of the whole procedure."""
        if isinstance(node, Variable):
            self._refuse_variable(node)
        if isinstance(result, Stop | Output):
            raise _ExitError(result)
        name = node.name if isinstance(node, Call | Invocation) else "run"
        raise self._placed(errors.did_not_output(name, wanted_by), node.place)

    def _placed(self, error: LogoError, place: Place) -> LogoError:
        """The error with the place and the running procedure, unless it knows them already."""
        if not error.is_placed:
            error.is_placed = True
            if error.procedure is None and self.procedure is not None:
                error.procedure = self.procedure.name
        if error.position is None and place is not None:
            error.position = place[0].position(place[1])
        return error

    def _annotate(self, error: BaseException, node: Node) -> None:
        """Note on an error of the robot or its link which command of the program it happened in."""
        if error is self._escaping:
            return
        self._escaping = error
        position = node.place[0].position(node.place[1]) if node.place is not None else self.position
        name = node.name if isinstance(node, Call | Invocation) else ""
        if position is None:
            error.add_note(f"in {name}")
        else:
            error.add_note(f"in {position.file}, line {position.line}, {name}:\n{position.marked()}")

    def _handle_limit(self, limit: LimitReachedError, node: Node) -> Result:
        """Run the ONLIMIT list in place of the rest of the command that a limit sensor ended."""
        handler = self.limit_handler
        if handler is None or limit is self._escaping:
            self._annotate(limit, node)
            raise limit
        self.limit_sensor = limit.sensor
        self.limit_handler = None  # a limit within the handler is an error, unless it does ONLIMIT itself
        self.limit_handler_changed = False
        try:
            return self.run_list(handler, COMMAND)
        finally:
            if not self.limit_handler_changed:
                self.limit_handler = handler
