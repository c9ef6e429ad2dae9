"""Control structures, but for loops: conditions, ends of procedures, catching and throwing.

A list that is run in a primitive's own place (IF, RUN) is handed to the evaluator as a ``RunList``, so that its last
instruction can be a tail call.
"""

from __future__ import annotations

from turtlewire.logo.errors import LogoError, did_not_output, outside_procedure
from turtlewire.logo.pausing import CONTINUE, pause
from turtlewire.logo.primitives.inputs import key, text, truth
from turtlewire.logo.procedures import (
    COMMAND,
    OPERATION,
    BadInputError,
    Chapter,
    Goto,
    Output,
    Result,
    RunList,
    Stop,
    ThrowError,
)
from turtlewire.logo.syntax import Call, Invocation
from turtlewire.logo.tags import has_tag
from turtlewire.logo.values import (
    NIL,
    VALUE_TYPES,
    List,
    Value,
    equal,
    make_list,
    plain,
    show_in_error,
    to_words,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive


_TEST_FIRST = "A TEST with a condition must come before it in the same procedure."

# --- conditions -----------------------------------------------------------------------------------------------


@primitive("if", 2, maximum=3)
def _if(logo: Interpreter, condition: Value, then: Value, otherwise: Value | None = None) -> Result:
    if truth(logo, condition):
        return RunList(then)
    return None if otherwise is None else RunList(otherwise)


@primitive("ifelse", 3)
def _ifelse(logo: Interpreter, condition: Value, then: Value, otherwise: Value) -> Result:
    return RunList(then if truth(logo, condition) else otherwise)


@primitive("test", 1)
def _test(logo: Interpreter, condition: Value) -> None:
    logo.test = truth(logo, condition)


@primitive("iftrue ift", 1)
def _iftrue(logo: Interpreter, instructions: Value) -> Result:
    if logo.test is None:
        raise LogoError(25, "iftrue without TEST", hint=_TEST_FIRST)
    return RunList(instructions) if logo.test else None


@primitive("iffalse iff", 1)
def _iffalse(logo: Interpreter, instructions: Value) -> Result:
    if logo.test is None:
        raise LogoError(25, "iffalse without TEST", hint=_TEST_FIRST)
    return None if logo.test else RunList(instructions)


# --- running lists, ending procedures -------------------------------------------------------------------------


@primitive("run", 1)
def _run(_logo: Interpreter, instructions: Value) -> Result:
    return RunList(instructions)


@primitive("runresult", 1)
def _runresult(logo: Interpreter, instructions: Value) -> Result:
    result = logo.run_list(instructions, OPERATION)
    if result is None:
        return NIL
    if type(result) in VALUE_TYPES:
        return make_list((result,))  # type: ignore[arg-type]
    raise LogoError(38, "Can't use OUTPUT or STOP inside RUNRESULT")


@primitive("stop", 0)
def _stop(logo: Interpreter) -> Result:
    if logo.procedure is None:
        raise outside_procedure("stop")
    return Stop()


@primitive("output op", 1)
def _output(_logo: Interpreter, value: Value) -> Result:
    return Output(value)


@primitive(".maybeoutput", 1)
def _maybeoutput(_logo: Interpreter, value: Value) -> Result:
    return Output(value)


@primitive("goto", 1)
def _goto(logo: Interpreter, tag: Value) -> Result:
    if logo.procedure is None:
        raise outside_procedure("goto")
    if isinstance(tag, list) or not has_tag(logo, logo.procedure, key(tag)):
        raise BadInputError(tag, 4, f"a word that stands behind TAG in a line of {logo.procedure.name}")
    return Goto(key(tag))


@primitive("tag", 1)
def _tag(_logo: Interpreter, _name: Value) -> None:
    """A place for GOTO to go to."""


@primitive("pause", 0)
def _pause(logo: Interpreter) -> Result:
    return pause(logo)


@primitive("continue co", 1, minimum=0)
def _continue(_logo: Interpreter, value: Value | None = None) -> None:
    raise ThrowError(CONTINUE, value)


@primitive("ignore", 1)
def _ignore(_logo: Interpreter, _value: Value) -> None:
    """The value is dropped."""


@primitive("bye", 0)
def _bye(_logo: Interpreter) -> None:
    raise ThrowError("toplevel", None)


# --- one of several ------------------------------------------------------------------------------------------


def _is_else(word_or_list: Value) -> bool:
    return isinstance(word_or_list, str) and plain(word_or_list).lower() == "else"


def _clause(command: str, clause: Value) -> tuple[Value, List]:
    """The first member of a clause, and the instructions behind it."""
    if not isinstance(clause, list):
        raise BadInputError(clause, wanted="clauses in brackets, each a list in brackets")
    if not clause:
        raise LogoError(35, f"Empty {command} clause", hint="A clause has a condition and instructions.")
    return clause[0], clause[1]


@primitive("case", 2)
def _case(_logo: Interpreter, value: Value, clauses: Value) -> Result:
    pending = _clauses(clauses)
    while pending:
        first, instructions = _clause("CASE", pending[0])
        pending = pending[1]
        if _is_else(first) or _is_among(value, first):
            return RunList(instructions)
    return None


def _clauses(value: Value) -> List:
    if not isinstance(value, list):
        raise BadInputError(value, wanted="clauses in brackets, each a list in brackets")
    return value


def _is_among(value: Value, values: Value) -> bool:
    """Whether a value is a member of a list, or a letter of a word."""
    if isinstance(values, list):
        rest = values
        while rest:
            if equal(rest[0], value):
                return True
            rest = rest[1]
        return False
    return not isinstance(value, list) and plain(text(value)).lower() in [*plain(text(values)).lower()]


@primitive("cond", 1)
def _cond(logo: Interpreter, clauses: Value) -> Result:
    pending = _clauses(clauses)
    while pending:
        first, instructions = _clause("COND", pending[0])
        pending = pending[1]
        if _is_else(first) or _holds(logo, first):
            return RunList(instructions)
    return None


def _holds(logo: Interpreter, condition: Value) -> bool:
    value = logo.value_of(condition, single=True)
    if value is None:
        last = logo.parsed(condition).last
        raise did_not_output(last.name if isinstance(last, Call | Invocation) else "[]", "cond")
    lowered = value.lower() if isinstance(value, str) else ""
    if lowered not in ("true", "false"):
        raise LogoError(35, f"{show_in_error(value)} not TRUE or FALSE")
    return lowered == "true"


# --- catching and throwing ------------------------------------------------------------------------------------


@primitive("catch", 2)
def _catch(logo: Interpreter, tag: Value, instructions: Value) -> Result:
    wanted = key(tag)
    state = logo.levels.depth
    action = logo.variables.pop("erract", None) if wanted == "error" else None
    try:
        result = logo.run_list(instructions, OPERATION if logo.value_wanted else COMMAND)
    except ThrowError as thrown:
        if thrown.tag != wanted:
            raise
        logo.levels.leave_to(state)
        return thrown.value
    except LogoError as error:
        if wanted != "error":
            raise
        logo.levels.leave_to(state)
        error.is_for_caller = False
        logo.last_error = error
        return None
    finally:
        if action is not None:
            logo.variables.setdefault("erract", action)
    return result


@primitive("throw", 1, maximum=2)
def _throw(logo: Interpreter, tag: Value, value: Value | None = None) -> None:
    wanted = key(tag)
    if wanted != "error":
        raise ThrowError(wanted, value)
    if value is None:
        raise LogoError(21, 'Throw "Error')
    error = LogoError(35, to_words(value))
    # So that a procedure can complain of its inputs as a primitive does.
    error.is_for_caller = logo.procedure is not None
    raise error


@primitive("error", 0)
def _error(logo: Interpreter) -> Value:
    error, logo.last_error = logo.last_error, None
    if error is None:
        return NIL
    if error.procedure is None:
        return make_list((error.number, error.text, NIL, NIL))
    instruction = error.instruction if error.instruction is not None else NIL
    return make_list((error.number, error.text, error.procedure, instruction))
