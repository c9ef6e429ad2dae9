"""How messages stand in frames: what a decoder looks up, prepared once for a dialect and a direction."""

from __future__ import annotations

from functools import lru_cache
from itertools import groupby
from struct import Struct
from typing import TYPE_CHECKING, Any, NamedTuple

from turtlewire.protocols.frame.dialect import field_letters
from turtlewire.protocols.message import KINDS, Field

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.protocols.frame.dialect import Dialect
    from turtlewire.protocols.frame.message import FrameMessage


class Limit(NamedTuple):
    """The restriction of one field: its place among the fields, its range, and the numbers that it may be or None."""

    place: int
    low: float
    high: float
    among: frozenset[int] | None


class Layout(NamedTuple):
    """How one message stands in a payload.

    ``size`` is that of type and fields; ``unpack_from`` reads the fields, ``letters`` in the struct module's language,
    and ``limits`` names those that can break their restriction. Where all fields are u8, ``allowed`` has for each of
    these the bytes that keep it.
    """

    message_type: type[FrameMessage]
    letters: str
    size: int
    unpack_from: Callable[[bytes, int], tuple[Any, ...]]
    limits: tuple[Limit, ...]
    allowed: tuple[bytes, ...] | None


@lru_cache(maxsize=32)
def layouts(dialect: Dialect, direction: str) -> list[Layout | None]:
    """What a decoder looks up by the type byte."""
    table: list[Layout | None] = [None] * 256
    for entry in dialect.entries:
        if not entry.is_decoded or not entry.goes(direction):
            continue
        limits = []
        for place, field in enumerate(entry.message_type.FIELDS):
            high = dialect.high(entry, field)
            choices = field.choices if isinstance(field, Field) else ()
            if choices or field.kind == "f32" or (field.low, high) != _everything(field.kind):
                among = frozenset(number for _, number in choices) if choices else None
                limits.append(Limit(place, field.low, high, among))
        # A letter with a number is read faster than so many letters.
        runs = groupby(field_letters(entry.message_type.FIELDS))
        letters = "".join(f"{len(list(run))}{letter}" for letter, run in runs)
        fields = Struct(">" + letters)
        allowed = None
        if [field.kind for field in entry.message_type.FIELDS] == ["u8"] * fields.size:
            alone = [(limit._replace(place=0),) for limit in limits]
            allowed = tuple(bytes(n for n in range(256) if keeps(limit, (n,))) for limit in alone)
        table[entry.type] = Layout(
            entry.message_type, letters, 1 + fields.size, fields.unpack_from, tuple(limits), allowed
        )
    return table


def _everything(kind: str) -> tuple[int, int]:
    """The range that no value on the wire can leave."""
    if kind == "bool":
        return (0, 1)  # any byte but 0 is read as true (F8)
    size, signed = KINDS[kind]
    top = (1 << (8 * size - signed)) - 1
    return (-top - 1 if signed else 0, top)


def keeps(limits: tuple[Limit, ...], values: tuple[Any, ...]) -> bool:
    """Whether the values of a message keep its restrictions. NaN is in no range."""
    for place, low, high, among in limits:
        value = values[place]
        if not low <= value <= high or (among is not None and value not in among):
            return False
    return True
