"""Python's exceptions in compiled procedures, as the Logo errors that they are.

The line number of the innermost frame of a compiled procedure is that of the instruction that failed. When Python has
refused an operation that was written out in place, the primitive itself is asked what is wrong with its inputs.
"""

from __future__ import annotations

from turtlewire.errors import TurtlewireError
from turtlewire.logo import blame, errors
from turtlewire.logo.calls import call_primitive
from turtlewire.logo.compiler.runtime import ConditionError, LateError, SilentError, UnusedError
from turtlewire.logo.compiler.sites import Site, identifier
from turtlewire.logo.errors import LogoError
from turtlewire.logo.procedures import BadInputError
from turtlewire.logo.syntax import Call, Invocation, Literal, Variable
from turtlewire.logo.values import show, show_in_error

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from types import CodeType, FrameType, TracebackType
    from typing import Any

    from turtlewire.logo.compiler.sites import Operand
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.procedures import UserProcedure

# What a compiled procedure may raise, beside what its primitives do.
FAULTS: tuple[type[Exception], ...] = (
    TypeError, NameError, KeyError, IndexError, OverflowError, ZeroDivisionError, BadInputError, SilentError,
    UnusedError, LateError, LogoError, TurtlewireError,
)  # fmt: skip


_THROWN = 35


class Record:
    """A compiled function.

    Attributes:
        procedure: what it was made of; ``None``: a line of the program.
        sites: its instructions that can fail; found out when one has, if the function comes from the store.
        names: its variables that are in Python locals.
    """

    __slots__ = ("_sites", "names", "procedure")

    def __init__(
        self,
        procedure: UserProcedure | None,
        sites: list[Site] | Callable[[], list[Site]],
        names: dict[str, str],
    ) -> None:
        self.procedure = procedure
        self.names = names
        self._sites = sites

    @property
    def sites(self) -> list[Site]:
        """The instructions that can fail, by their numbers less one; there is one at least."""
        if not isinstance(self._sites, list):
            self._sites = self._sites()
        if not self._sites:
            self._sites.append(Site(Literal("", None), ""))
        return self._sites

    def owner(self, site: Site) -> UserProcedure | None:
        """Whose instruction it is."""
        return site.procedure or self.procedure

    def site_at(self, line: int | None) -> Site:
        """The instruction that a frame is at; the first for a frame that is between two (Python gives it no line)."""
        sites = self.sites
        return sites[line - 1] if line is not None and 1 <= line <= len(sites) else sites[0]


def innermost(
    records: dict[CodeType, Record], error: BaseException
) -> tuple[Record, Site, TracebackType] | None:
    """The compiled function that was running when this was raised, and at which instruction."""
    trace, found, outer = error.__traceback__, None, None
    while trace is not None:
        record = records.get(trace.tb_frame.f_code)
        if record is not None:
            outer, found = found, (record, record.site_at(trace.tb_lineno), trace)
        trace = trace.tb_next
    return outer if found is not None and _is_for_caller(error, found[0], found[1]) else found


def _is_for_caller(error: BaseException, record: Record, site: Site) -> bool:
    """Whether a procedure complains of what it was invoked with, by (THROW "ERROR text)."""
    return (
        isinstance(error, LogoError)
        and error.number == _THROWN
        and not error.is_placed
        and record.owner(site) is not None
        and isinstance(site.node, Call)
        and site.node.primitive.name == "throw"
    )


def translated(logo: Interpreter, records: dict[CodeType, Record], fault: Exception) -> Exception:
    """The error that is to be raised in place of a fault; the fault itself when it is one of turtlewire's own."""
    found = innermost(records, fault) if isinstance(fault, FAULTS) else None
    if found is None:
        return fault
    record, site, trace = found
    if isinstance(fault, LateError):
        record = fault.record or record
        site = record.site_at(fault.number)
    elif isinstance(fault, UnboundLocalError):
        site = _of_variable(record, site, trace, str(fault))
    if isinstance(fault, LogoError):
        error: Exception = fault
    elif isinstance(fault, TurtlewireError):
        blame.annotate(logo, fault, site.node)
        return fault
    else:
        is_innermost = trace.tb_next is None
        made = _error(logo, site, fault, trace.tb_frame if is_innermost else None)
        if made is None:
            return fault
        error = made
    assert isinstance(error, LogoError)
    # Where a value is missing, the expression is at fault; what is wrong with the value is said of who looks at it.
    node = site.asker if site.asker is not None and not isinstance(fault, SilentError) else site.node
    return blame.placed(logo, error, node.place, record.owner(site))


def _of_variable(record: Record, site: Site, trace: TracebackType, message: str) -> Site:
    """Where a variable is meant that has no value.

    Python does two instructions at once in code that is run often, and names the line of the first: here the second
    may be the one that failed.
    """
    lines = [place[0] for place in trace.tb_frame.f_code.co_positions()]
    following = trace.tb_lasti // 2 + 1
    for each in (site, record.site_at(lines[following] if following < len(lines) else None)):
        if isinstance(each.node, Variable) and f"'{identifier(each.node.key)}_" in message:
            return each
    return site


def _error(logo: Interpreter, site: Site, fault: Exception, frame: FrameType | None) -> LogoError | None:
    node = site.node
    if isinstance(fault, ConditionError):
        return errors.does_not_like(
            site.wanted_by, show_in_error(fault.value), number=fault.number, wanted=fault.wanted
        )
    if isinstance(fault, BadInputError):
        name = node.name if isinstance(node, Call | Invocation) else site.wanted_by
        return errors.does_not_like(
            name, show_in_error(fault.value), number=fault.number, wanted=fault.wanted
        )
    if isinstance(fault, UnusedError):
        return errors.unused_value(show_in_error(fault.value), from_procedure=isinstance(node, Invocation))
    if isinstance(fault, SilentError):
        name = node.name if isinstance(node, Call | Invocation) else show(getattr(node, "value", ""))
        return errors.did_not_output(name, site.wanted_by)
    if isinstance(fault, LateError):
        if fault.value is not None:
            return errors.unused_value(show_in_error(fault.value), from_procedure=True)
        assert isinstance(node, Invocation)
        return errors.did_not_output(node.name, "output")
    if frame is None:
        return None  # it comes from within a primitive: a mistake of ours
    if isinstance(fault, NameError | KeyError):
        if isinstance(node, Variable):
            known = [key for key in (*logo.variables, *logo.compiler.locals_from(frame)) if key != node.key]
            return errors.no_value(node.name, known)
        return None
    return _refused(logo, site, frame)


def _refused(logo: Interpreter, site: Site, frame: FrameType) -> LogoError | None:
    """Python has refused an operation: what the primitive says of its inputs."""
    node = site.node
    if not isinstance(node, Call) or not site.operands:
        return None
    values: list[Any] = [_found(operand, frame) for operand in site.operands]
    for operand, value in zip(site.operands, values, strict=True):
        if value is None:
            name = operand.node.name if isinstance(operand.node, Call | Invocation) else str(operand.what)
            return errors.did_not_output(name, node.name)
    try:
        call_primitive(logo, node.primitive, values)
    except BadInputError as bad:
        return errors.does_not_like(node.name, show_in_error(bad.value), number=bad.number, wanted=bad.wanted)
    return None


def _found(operand: Operand, frame: FrameType) -> Any:
    if operand.kind == "constant":
        return operand.what
    return frame.f_locals.get(operand.what, frame.f_globals.get(operand.what))
