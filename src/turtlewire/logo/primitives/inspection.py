"""Workspace queries and inspection: what is there, as contents lists and as printed definitions."""

from __future__ import annotations

from turtlewire.logo import printout
from turtlewire.logo.errors import no_value, unknown_procedure
from turtlewire.logo.marks import Contents
from turtlewire.logo.primitives.inputs import answer, key
from turtlewire.logo.primitives.workspace import property_members, users
from turtlewire.logo.procedures import BadInputError, Chapter, Primitive, UserProcedure
from turtlewire.logo.values import NIL, List, Value, make_list, members_of

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive

_CONTENTS = "a name, a list of names, or a list of three lists: procedures, variables, property lists"


# --- contents lists -------------------------------------------------------------------------------------------


def contents_of(value: Value) -> Contents:
    """A contents list: a procedure's name, a list of them, or a list of up to three lists."""
    if isinstance(value, str | int | float):
        return Contents([key(value)], [], [])
    if not isinstance(value, list):
        raise BadInputError(value, 4, _CONTENTS)
    members = members_of(value)
    if not members or not isinstance(members[0], list):
        return Contents([_name(each, value) for each in members], [], [])
    if len(members) > 3:
        raise BadInputError(value, 4, _CONTENTS)
    kinds: list[list[str]] = [[], [], []]
    for place, member in enumerate(members):
        if not isinstance(member, list):
            raise BadInputError(value, 4, _CONTENTS)
        kinds[place] = [_name(each, value) for each in members_of(member)]
    return Contents(*kinds)


def _name(member: Value, whole: Value) -> str:
    if not isinstance(member, str | int | float):
        raise BadInputError(whole, 4, _CONTENTS)
    return key(member)


def names_input(value: Value) -> list[str]:
    """A name, or a list of names."""
    return [_name(each, value) for each in members_of(value)] if isinstance(value, list) else [key(value)]


def contents_list(contents: Contents) -> List:
    """A contents list as a value."""
    return make_list([make_list(names) for names in contents])


def _variables_list(names: list[str]) -> List:
    return make_list([NIL, make_list(names)])


def all_contents(logo: Interpreter) -> Contents:
    """What is in the workspace and not buried, in the order of the alphabet."""
    buried = logo.marks.buried
    procedures = [
        name
        for name, each in logo.procedures.items()
        if isinstance(each, UserProcedure) and name not in buried.procedures
    ]
    variables = [name for name in logo.variables if name not in buried.variables]
    lists = [name for name, each in logo.property_lists.items() if each and name not in buried.property_lists]
    return Contents(sorted(procedures), sorted(variables), sorted(lists))


@primitive("contents", 0)
def _contents(logo: Interpreter) -> Value:
    return contents_list(all_contents(logo))


@primitive("buried", 0)
def _buried(logo: Interpreter) -> Value:
    return contents_list(logo.marks.buried.contents())


@primitive("traced", 0)
def _traced(logo: Interpreter) -> Value:
    return contents_list(logo.marks.traced.contents())


@primitive("stepped", 0)
def _stepped(logo: Interpreter) -> Value:
    return contents_list(logo.marks.stepped.contents())


@primitive("procedures", 0)
def _procedures(logo: Interpreter) -> Value:
    return make_list(all_contents(logo).procedures)


@primitive("primitives", 0)
def _primitives(logo: Interpreter) -> Value:
    return make_list(sorted(name for name, each in logo.procedures.items() if isinstance(each, Primitive)))


@primitive("names", 0)
def _names(logo: Interpreter) -> Value:
    return _variables_list(all_contents(logo).variables)


@primitive("plists", 0)
def _plists(logo: Interpreter) -> Value:
    return contents_list(Contents([], [], all_contents(logo).property_lists))


@primitive("namelist", 1)
def _namelist(_logo: Interpreter, names: Value) -> Value:
    return _variables_list(names_input(names))


@primitive("pllist", 1)
def _pllist(_logo: Interpreter, names: Value) -> Value:
    return contents_list(Contents([], [], names_input(names)))


@primitive("plistp plist?", 1)
def _plistp(logo: Interpreter, name: Value) -> Value:
    return answer(condition=bool(logo.property_lists.get(key(name))))


@primitive("arity", 1)
def _arity(logo: Interpreter, name: Value) -> Value:
    procedure = logo.procedures.get(key(name))
    if procedure is None:
        raise unknown_procedure(key(name), list(logo.procedures), number=24)
    return make_list((procedure.minimum_inputs, procedure.default_inputs, procedure.maximum_inputs))


# --- printing -------------------------------------------------------------------------------------------------


def _value(logo: Interpreter, name: str) -> Value:
    value = logo.variables.get(name)
    if value is None:
        raise no_value(name, list(logo.variables))
    return value


def definitions(logo: Interpreter, contents: Contents) -> str:
    """Everything that a contents list names, as instructions.

    Raises:
        LogoError: a procedure or variable that is not there, or a primitive.
    """
    pieces = [printout.procedure_text(users(logo, name)) for name in contents.procedures]
    pieces += [printout.variable_text(name, _value(logo, name)) for name in contents.variables]
    for name in contents.property_lists:
        pieces.append(printout.properties_text(name, logo.property_lists.get(name, {})))
    return "".join(pieces)


def _titles(logo: Interpreter, contents: Contents) -> str:
    pieces = [printout.title(users(logo, name)) + "\n" for name in contents.procedures]
    pieces += [printout.variable_text(name, _value(logo, name)) for name in contents.variables]
    for name in contents.property_lists:
        members = property_members(logo, name)
        if members:
            pieces.append(printout.property_list_text(name, members))
    return "".join(pieces)


@primitive("printout po", 1)
def _po(logo: Interpreter, what: Value) -> None:
    logo.write(definitions(logo, contents_of(what)))


@primitive("poall", 0)
def _poall(logo: Interpreter) -> None:
    logo.write(definitions(logo, all_contents(logo)))


@primitive("pops", 0)
def _pops(logo: Interpreter) -> None:
    logo.write(definitions(logo, all_contents(logo)._replace(variables=[], property_lists=[])))


@primitive("pons", 0)
def _pons(logo: Interpreter) -> None:
    logo.write(definitions(logo, all_contents(logo)._replace(procedures=[], property_lists=[])))


@primitive("popls", 0)
def _popls(logo: Interpreter) -> None:
    logo.write(definitions(logo, all_contents(logo)._replace(procedures=[], variables=[])))


@primitive("pon", 1)
def _pon(logo: Interpreter, names: Value) -> None:
    logo.write(definitions(logo, Contents([], names_input(names), [])))


@primitive("popl", 1)
def _popl(logo: Interpreter, names: Value) -> None:
    logo.write(definitions(logo, Contents([], [], names_input(names))))


@primitive("pot", 1)
def _pot(logo: Interpreter, what: Value) -> None:
    logo.write(_titles(logo, contents_of(what)))


@primitive("pots", 0)
def _pots(logo: Interpreter) -> None:
    logo.write(_titles(logo, all_contents(logo)._replace(variables=[], property_lists=[])))


# --- help -----------------------------------------------------------------------------------------------------


@primitive("help", 1, minimum=0)
def _help(logo: Interpreter, name: Value | None = None) -> None:
    if name is None:
        logo.write(" ".join(sorted(logo.procedures)) + "\n")
        return
    procedure = logo.procedures.get(key(name))
    if procedure is None:
        logo.write(f"No help available on {key(name)}.\n")
        return
    if isinstance(procedure, Primitive):
        synonyms = [
            other for other, each in logo.procedures.items() if each is procedure and other != key(name)
        ]
        lines = [procedure.usage(key(name))]
        if procedure.maximum_inputs != procedure.default_inputs:
            most = "any number" if procedure.maximum_inputs < 0 else str(procedure.maximum_inputs)
            lines.append(f"Between parentheses: {procedure.minimum_inputs} to {most}.")
        if synonyms:
            lines.append(f"The same: {', '.join(synonyms)}.")
        logo.write(" ".join(lines) + "\n")
        return
    logo.write(printout.title(procedure) + "\n")
    for line in procedure.full_text[1:]:
        if not line.lstrip().startswith(";"):
            break
        logo.write(line + "\n")
