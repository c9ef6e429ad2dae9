"""Definitions as text: what PO and SAVE write, what FULLTEXT outputs, and titles for POT."""

from __future__ import annotations

from turtlewire.logo.tracing import quoted
from turtlewire.logo.values import (
    BACKSLASHED,
    BARRED,
    SPECIAL,
    Value,
    plain,
    show,
    show_in_error,
    spelled,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.procedures import UserProcedure
    from turtlewire.logo.values import List

    Properties = dict[str, tuple[Value, Value]]


_UNMARKED = frozenset(SPECIAL)


def as_written(text: str) -> str:
    """A word of a program, in which only marked characters need bars or backslashes."""
    if plain(text) == text:
        return text
    sign = text[0] if text[0] in '":' else ""
    body = text[len(sign) :]
    if not _UNMARKED.intersection(body) and not any(ord(c) >= BACKSLASHED for c in body):
        return sign + spelled(body)
    pieces: list[str] = []
    in_bars = False
    for c in text:
        is_barred = BARRED <= ord(c) < BACKSLASHED
        if is_barred is not in_bars:
            pieces.append("|")
            in_bars = is_barred
        seen = plain(c)
        needs_backslash = seen in "|\\" if is_barred else seen != c
        pieces.append(f"\\{seen}" if needs_backslash else seen)
    return "".join(pieces) + ("|" if in_bars else "")


def instructions(line: List) -> str:
    """A line of a procedure's body."""
    return show(line, as_written, with_origins=True)[1:-1]


def title(procedure: UserProcedure) -> str:
    """The title line of a procedure, as it was written if it was."""
    if procedure.full_text:
        return procedure.full_text[0]
    pieces = [
        ".macro" if procedure.is_macro else "to",
        procedure.name,
        *[f":{name}" for name in procedure.inputs],
    ]
    for each in procedure.optional:
        default = instructions(each.default.value)
        pieces.append(f"[:{each.name} {default}]")
    if procedure.rest:
        pieces.append(f"[:{procedure.rest}]")
    if procedure.default_inputs != procedure.minimum_inputs:
        pieces.append(str(procedure.default_inputs))
    return " ".join(pieces)


def full_text(procedure: UserProcedure) -> list[str]:
    """The lines of a procedure, from TO to END: as they were written if they were."""
    if procedure.full_text:
        return list(procedure.full_text)
    return [title(procedure), *[instructions(line.value) for line in procedure.body], "end"]


def procedure_text(procedure: UserProcedure) -> str:
    """A procedure as PO prints it, with an empty line behind it."""
    return "\n".join(full_text(procedure)) + "\n\n"


def variable_text(name: str, value: Value) -> str:
    """The instruction that gives a variable its value."""
    return f'Make "{spelled(name)} {_given(value)}\n'


def properties_text(name: str, properties: Properties) -> str:
    """The instructions that make a property list, the newest property first."""
    lines = [
        f"Pprop {quoted(name)} {_given(property_name)} {_given(value)}\n"
        for property_name, value in reversed(properties.values())
    ]
    return "".join(lines)


def property_list_text(name: str, members: List) -> str:
    """A property list in one line, as POT prints it."""
    return f"Plist {quoted(name)} = {show_in_error(members)}\n"


def _given(value: Value) -> str:
    return '"||' if value == "" else quoted(value)
