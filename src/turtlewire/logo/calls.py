"""Calls of procedures, and how they end: by STOP, by OUTPUT, or by leaving their place to what they call last."""

from __future__ import annotations

from turtlewire.logo import blame, errors, tags, tracing
from turtlewire.logo.errors import LogoError
from turtlewire.logo.procedures import BODY, LAST, OPERATION, ExitError, Goto, Output, RunList, Stop, TailCall
from turtlewire.logo.scope import bind
from turtlewire.logo.syntax import Invocation
from turtlewire.logo.values import VALUE_TYPES, show_in_error

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.procedures import Primitive, Result, UserProcedure
    from turtlewire.logo.syntax import MaybeOutputCall, Node, OutputCall
    from turtlewire.logo.values import Value

MAX_DEPTH = 30_000  # procedures within procedures; deeper is a program that never ends


def call_primitive(logo: Interpreter, primitive: Primitive, inputs: list[Value]) -> Result:
    """Call a primitive; written out by count, because ``f(*inputs)`` would go through the C stack."""
    function = primitive.function
    count = len(inputs)
    if primitive.maximum_inputs < 0:
        return function(logo, inputs)
    if count == 1:
        return function(logo, inputs[0])
    if count == 2:
        return function(logo, inputs[0], inputs[1])
    if count == 0:
        return function(logo)
    return function(logo, inputs[0], inputs[1], inputs[2])


def call_compiled(
    logo: Interpreter, function: Callable[..., Value | None], inputs: list[Value]
) -> Value | None:
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
        error = logo.compiler.translated(fault)
        if error is fault:
            raise
        raise error from None


def invoke(logo: Interpreter, node: Invocation, inputs: list[Value], *, wants_value: bool) -> Value | None:
    """Invoke a user's procedure, and whatever takes its place.

    Raises:
        LogoError: too many procedures within procedures, or what the procedure raises.
    """
    if logo.depth >= MAX_DEPTH:
        raise errors.stack_overflow()
    outer = (logo.hidden, logo.procedure, logo.must_output, logo.test, logo.body, logo.is_traced)
    marks = logo.marks
    depth = marks.trace_depth
    hidden: dict[str, Value | None] = {}
    logo.hidden = hidden
    logo.must_output = wants_value
    logo.depth += 1
    tail_call: TailCall | None = None
    caller = logo.procedure
    result: Result = None
    procedure, is_traced = node.procedure, False
    try:
        while True:
            procedure = node.procedure
            function = logo.compiler.function(procedure)
            if function is not None and len(inputs) == len(procedure.inputs):
                value = call_compiled(logo, function, inputs)
                result = None if value is None else Output(value)
                break
            bind(logo, procedure, inputs, node.name)
            logo.procedure = procedure
            traced = marks.traced.procedures
            logo.is_traced = is_traced = bool(traced) and procedure.name.lower() in traced
            if is_traced:
                tracing.tell_invoked(logo, procedure.name, inputs)
            result = _run_body(logo, procedure)
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
                blame.placed(logo, error, node.place, caller)
        raise
    finally:
        logo.depth -= 1
        for name, value in hidden.items():
            if value is None:
                logo.variables.pop(name, None)
            else:
                logo.variables[name] = value
        (logo.hidden, logo.procedure, logo.must_output, logo.test, logo.body, logo.is_traced) = outer
        marks.trace_depth = depth
    value = result.value if type(result) is Output else None
    if is_traced:
        tracing.tell_ended(logo, procedure.name, value)
    if tail_call is not None and not tail_call.may_output and (value is not None) is not wants_value:
        if value is None:
            mismatch = errors.did_not_output(node.name, "output")
        else:
            mismatch = errors.unused_value(show_in_error(value), from_procedure=True)
        blame.placed(logo, mismatch, node.place, caller)
        return logo.fail(mismatch, node.place)
    return value


def _run_body(logo: Interpreter, procedure: UserProcedure) -> Result:
    """Run the lines of a procedure, watched for ``progress`` when it is one of the outermost."""
    code = logo.body_of(procedure)
    watched = logo.levels.enter(len(code.instructions) + 1)
    logo.body = code, watched or [0]
    try:
        while True:
            try:
                result = logo.run_code(code, LAST, logo.body[1])
            except ExitError as ended:
                result = ended.signal
            if type(result) is not Goto:
                return result
            code = tags.code_from(logo, procedure, result.tag)
            logo.body = code, [0]
    finally:
        if watched is not None:
            logo.levels.leave()


def expansion(logo: Interpreter, node: Invocation, inputs: list[Value], *, may_be_empty: bool) -> RunList:
    """What a macro outputs, to be run in its caller's place.

    Raises:
        LogoError: it is no list, or empty where it may not be.
    """
    value = invoke(logo, node, inputs, wants_value=True)
    if type(value) is not list:
        error = errors.no_expansion(show_in_error(value) if value is not None else "nothing")
        error.procedure = node.procedure.name
        error.instruction = node.procedure.body[-1].value if node.procedure.body else None
        raise error
    if not (value or may_be_empty):
        raise errors.no_expansion("[]")
    return RunList(value)


def inputs_of(logo: Interpreter, node: Invocation) -> list[Value]:
    """The inputs of an invocation, evaluated."""
    inputs: list[Value] = []
    for each in node.inputs:
        value = logo.evaluate(each)
        if type(value) not in VALUE_TYPES:
            value = logo.instead(each, node.name, value)
        inputs.append(value)  # type: ignore[arg-type]
    return inputs


# --- OUTPUT -------------------------------------------------------------------------------------------------------


def output(logo: Interpreter, node: OutputCall, how: int) -> Result:
    """OUTPUT: the value of its input; a procedure that computes it takes the place of the running one."""
    if logo.procedure is None:
        logo.fail(errors.outside_procedure(node.name), node.place)
    each = node.inputs[0]
    if (
        type(each) is Invocation
        and logo.must_output
        and how in (LAST, BODY)
        and not (each.procedure.is_macro or logo.is_traced)
    ):
        return TailCall(each, inputs_of(logo, each))
    value = _evaluate_last(logo, each)
    if type(value) not in VALUE_TYPES:
        value = logo.instead(each, node.name, value)
    return Output(value)  # type: ignore[arg-type]


def maybe_output(logo: Interpreter, node: MaybeOutputCall, how: int) -> Result:
    """.MAYBEOUTPUT: the same; without a value it is STOP."""
    if logo.procedure is None:
        logo.fail(errors.outside_procedure(node.name), node.place)
    each = node.inputs[0]
    takes_place = how in (LAST, BODY) and not logo.is_traced
    if type(each) is Invocation and takes_place and not each.procedure.is_macro:
        return TailCall(each, inputs_of(logo, each), may_output=True)
    result = _evaluate_last(logo, each)
    if result is None:
        return Stop()
    return Output(result) if type(result) in VALUE_TYPES else result  # type: ignore[arg-type]


def _evaluate_last(logo: Interpreter, node: Node) -> Result:
    """The input of OUTPUT: as if it were the last instruction, it may be a list of several."""
    result = logo.evaluate(node, in_place=True)
    return logo.run_list(result.instructions, OPERATION) if type(result) is RunList else result
