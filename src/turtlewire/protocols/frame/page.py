"""A dialect's documentation: a page in Markdown with every message and its bytes (F10)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.protocols.frame.dialect import FROM_ROBOT, TO_ROBOT
from turtlewire.protocols.message import KINDS, Field

if TYPE_CHECKING:
    from turtlewire.protocols.frame.dialect import Dialect, Entry
    from turtlewire.protocols.message import AnyField

TITLES = {TO_ROBOT: "Host to robot", FROM_ROBOT: "Robot to host"}


def _value(entry: Entry, field: AnyField) -> str:
    """What a field may be."""
    if isinstance(field, Field) and field.choices:
        return ", ".join(f"{number} = {name}" for name, number in field.choices)
    if field.name == entry.key:
        return f"{field.low}.. below the number of {entry.below}"
    if isinstance(field, Field):
        return f"{field.low}..{field.high}"
    return f"{field.text(field.low)}..{field.text(field.high)}"


def _row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def page(dialect: Dialect, level: int = 1) -> str:
    """The dialect's page; ``level`` is that of its heading, 1..4."""
    mark = "#" * level
    counts = ", ".join(f"{count} {name}" for name, count in dialect.counts.items())
    out = [
        f"{mark} {dialect.title}",
        "",
        f"Dialect `{dialect.name}`: {dialect.baud} baud 8N1, {dialect.checksum.algorithm.name} from the "
        f"{dialect.checksum.coverage.value} on" + (f"; {counts}." if counts else "."),
    ]
    for direction, title in TITLES.items():
        entries = [entry for entry in dialect.entries if entry.goes(direction)]
        if not entries:
            continue
        out += ["", f"{mark}# {title}: {dialect.name}", ""]
        out += [_row("type", "message", "fields, in order", "bytes", "meaning"), _row(*["---"] * 5)]
        for entry in entries:
            fields = entry.message_type.FIELDS
            said = [
                f"`{f.name}` {f.kind}: {_value(entry, f)}" + ("" if f.unit == "number" else f" ({f.unit})")
                for f in fields
            ]
            size = 1 + sum(KINDS[f.kind][0] for f in fields)
            doc = entry.message_type.__doc__ or ""
            if entry.channel:
                doc += f" Set-point of `{entry.channel}`."
            if not entry.is_decoded:
                doc += " Other messages have this type too."
            if not entry.is_sent:
                doc += " Only reported, never sent."
            name = f"`{entry.message_type.__name__}`"
            out.append(_row(f"{entry.type:02X}", name, "; ".join(said), str(size), doc.strip()))
    return "\n".join(out) + "\n"
