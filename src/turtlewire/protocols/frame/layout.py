"""How messages stand in frames: what a decoder looks up, prepared once for a dialect and a direction."""

from __future__ import annotations

from functools import cache
from struct import Struct
from typing import TYPE_CHECKING, Any, NamedTuple

from turtlewire.protocols.frame.dialect import field_letters
from turtlewire.protocols.frame.message import HEADER, MAX_FRAME, FrameMessage
from turtlewire.protocols.message import KINDS, Field

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from turtlewire.protocols.checksums import Checksum
    from turtlewire.protocols.frame.dialect import Dialect

# Sequence numbers in a row are compared with a piece of this.
_SEQS = bytes(range(256)) * 2


class Limit(NamedTuple):
    """The restriction of one field: its place among the fields, its range, and the numbers that it may be or None."""

    place: int
    low: float
    high: float
    among: frozenset[int] | None


class Layout(NamedTuple):
    """How one message stands in a payload.

    ``size`` is that of type and fields; ``unpack_from`` reads the fields, ``letters`` in the struct module's language,
    and ``limits`` names those that can break their restriction.
    """

    message_type: type[FrameMessage]
    letters: str
    size: int
    unpack_from: Callable[[bytes, int], tuple[Any, ...]]
    limits: tuple[Limit, ...]


class Shape(NamedTuple):
    """Frames of one size that have the same messages in the same places.

    ``places`` are those of what must be alike: magic, size, the types. ``parts`` are the messages' classes, their
    restrictions, and how to read their fields from a whole frame.
    """

    size: int
    places: tuple[tuple[int, int], ...]
    parts: tuple[tuple[type[FrameMessage], tuple[Limit, ...], Struct], ...]


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
        letters = field_letters(entry.message_type.FIELDS)
        fields = Struct(">" + letters)
        table[entry.type] = Layout(
            entry.message_type, letters, 1 + fields.size, fields.unpack_from, tuple(limits)
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


def keeping(limits: tuple[Limit, ...], rows: Sequence[tuple[Any, ...]]) -> int:
    """How many rows of values keep the restrictions, up to the first that does not."""
    count = len(rows)
    for place, low, high, among in limits:
        values = [row[place] for row in rows]
        kept = [low <= value <= high and (among is None or value in among) for value in values]
        if False in kept:
            count = min(count, kept.index(False))
    return count


def shape_of(frame: bytes, table: list[Layout | None], last: Shape | None) -> Shape:
    """The shape of a frame whose types are known; the last one if it is the same."""
    there = []
    at = HEADER
    while at < len(frame) - 1:
        layout = table[frame[at]]
        assert layout is not None, "a frame with an unknown type was ignored"
        there.append((at, layout))
        at += layout.size
    places = tuple((place, frame[place]) for place in (0, 2, *(place for place, _ in there)))
    if last is not None and last.places == places:
        return last
    parts = []
    for place, layout in there:
        behind = len(frame) - place - layout.size
        parts.append((layout.message_type, layout.limits, Struct(f">{place + 1}x{layout.letters}{behind}x")))
    return Shape(len(frame), places, tuple(parts))


def alike(buffer: bytes, at: int, count: int, shape: Shape) -> int:
    """How many of ``count`` frames from ``at`` on have the shape."""
    for place, byte in shape.places:
        column = buffer[at + place : at + count * shape.size : shape.size]
        count = len(column) - len(column.lstrip(bytes((byte,))))
    return count


def following(seqs: bytes, due: int) -> int:
    """How many sequence numbers follow one another as they should, ``due`` first."""
    for at in range(0, len(seqs), 256):
        piece = seqs[at : at + 256]
        if not _SEQS.startswith(piece, due):
            return at + next(n for n, seq in enumerate(piece) if seq != _SEQS[due + n])
    return len(seqs)


@cache
def _after_zeros(step: bytes) -> tuple[bytes, ...]:
    """What a byte has become in the register when so many bytes of zeros have followed it: 0, 1, 2 ..."""
    rows = [step]
    while len(rows) < MAX_FRAME:
        rows.append(rows[-1].translate(step))
    return tuple(rows)


def right_crcs(buffer: bytes, at: int, count: int, size: int, checksum: Checksum, step: bytes) -> int:
    """How many of ``count`` frames of one size have a right CRC, up to the first that has not.

    A CRC is linear but for what its initial value and final XOR add: the frames' first bytes are taken through the
    register together, then their second ones, and so on, and summed up. ``step`` is the algorithm's table.
    """
    algorithm, first = checksum.algorithm, checksum.coverage.first
    rows = _after_zeros(step)
    total = 0
    for place in range(first, size):
        column = buffer[at + place : at + count * size : size]
        total ^= int.from_bytes(column.translate(rows[size - 1 - place]), "little")
    left = algorithm.residue ^ algorithm.crc(bytes(size - first))
    return count - len(total.to_bytes(count, "little").lstrip(bytes((left,))))
