"""Workspace control: erasing, burying, tracing and stepping, by contents lists."""

from __future__ import annotations

from turtlewire.logo.debugging import Debugger
from turtlewire.logo.definitions import may_redefine
from turtlewire.logo.errors import is_primitive
from turtlewire.logo.library import LIBRARY
from turtlewire.logo.marks import Contents
from turtlewire.logo.primitives.inputs import answer
from turtlewire.logo.primitives.inspection import all_contents, contents_of, names_input
from turtlewire.logo.procedures import BadInputError, Chapter, Primitive, UserProcedure

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.values import Value

chapter = Chapter()
primitive = chapter.primitive


# --- erasing --------------------------------------------------------------------------------------------------


def _erase(logo: Interpreter, contents: Contents) -> None:
    for name in contents.procedures:
        procedure = logo.procedures.get(name)
        if procedure is None:
            continue
        if isinstance(procedure, Primitive):
            if not may_redefine(logo, name):
                raise is_primitive(name)
        else:
            procedure.is_erased = True
        del logo.procedures[name]
        if name in LIBRARY and isinstance(procedure, UserProcedure):
            logo.procedures[name] = logo.primitives[name]
        logo.marks.buried.procedures.discard(name)
        logo.epoch += 1
    for name in contents.variables:
        logo.variables.pop(name, None)
        logo.marks.declared.discard(name)
    for name in contents.property_lists:
        logo.property_lists.pop(name, None)


@primitive("erase er", 1)
def _erase_named(logo: Interpreter, what: Value) -> None:
    _erase(logo, contents_of(what))


@primitive("erall", 0)
def _erall(logo: Interpreter) -> None:
    _erase(logo, all_contents(logo))


@primitive("erps", 0)
def _erps(logo: Interpreter) -> None:
    _erase(logo, all_contents(logo)._replace(variables=[], property_lists=[]))


@primitive("erns", 0)
def _erns(logo: Interpreter) -> None:
    _erase(logo, all_contents(logo)._replace(procedures=[], property_lists=[]))


@primitive("erpls", 0)
def _erpls(logo: Interpreter) -> None:
    _erase(logo, all_contents(logo)._replace(procedures=[], variables=[]))


@primitive("ern", 1)
def _ern(logo: Interpreter, names: Value) -> None:
    _erase(logo, Contents([], names_input(names), []))


@primitive("erpl", 1)
def _erpl(logo: Interpreter, names: Value) -> None:
    _erase(logo, Contents([], [], names_input(names)))


# --- burying --------------------------------------------------------------------------------------------------


@primitive("bury", 1)
def _bury(logo: Interpreter, what: Value) -> None:
    logo.marks.buried.add(contents_of(what))


@primitive("buryall", 0)
def _buryall(logo: Interpreter) -> None:
    logo.marks.buried.add(all_contents(logo))


@primitive("buryname", 1)
def _buryname(logo: Interpreter, names: Value) -> None:
    logo.marks.buried.add(Contents([], names_input(names), []))


@primitive("unbury", 1)
def _unbury(logo: Interpreter, what: Value) -> None:
    logo.marks.buried.remove(contents_of(what))


@primitive("unburyall", 0)
def _unburyall(logo: Interpreter) -> None:
    logo.marks.buried.remove(logo.marks.buried.contents())


@primitive("unburyname", 1)
def _unburyname(logo: Interpreter, names: Value) -> None:
    logo.marks.buried.remove(Contents([], names_input(names), []))


def _asked(what: Value) -> Contents:
    """A contents list with a name in it: the first one is asked about."""
    contents = contents_of(what)
    if not (contents.procedures or contents.variables or contents.property_lists):
        raise BadInputError(what, 4, "a name, or a contents list with a name in it")
    return contents


@primitive("buriedp buried?", 1)
def _buriedp(logo: Interpreter, what: Value) -> Value:
    return answer(condition=logo.marks.buried.has_first_of(_asked(what)))


# --- tracing and stepping -------------------------------------------------------------------------------------


@primitive("trace", 1)
def _trace(logo: Interpreter, what: Value) -> None:
    logo.marks.traced.add(contents_of(what))
    logo.epoch += 1  # compiled code of what is traced is another one


@primitive("untrace", 1)
def _untrace(logo: Interpreter, what: Value) -> None:
    logo.marks.traced.remove(contents_of(what))
    logo.epoch += 1


@primitive("tracedp traced?", 1)
def _tracedp(logo: Interpreter, what: Value) -> Value:
    return answer(condition=logo.marks.traced.has_first_of(_asked(what)))


@primitive("step", 1)
def _step(logo: Interpreter, what: Value) -> None:
    logo.marks.stepped.add(contents_of(what))
    if logo.debugger is None:
        logo.debugger = Debugger()
    logo.epoch += 1


@primitive("unstep", 1)
def _unstep(logo: Interpreter, what: Value) -> None:
    logo.marks.stepped.remove(contents_of(what))
    if not logo.marks.stepped.procedures and logo.debugger is not None and logo.debugger.on_stop is None:
        logo.debugger = None
    logo.epoch += 1


@primitive("steppedp stepped?", 1)
def _steppedp(logo: Interpreter, what: Value) -> Value:
    return answer(condition=logo.marks.stepped.has_first_of(_asked(what)))
