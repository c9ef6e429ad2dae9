"""Dialects: sets of messages as data, and the classes that are made from them (F10).

A dialect is a TOML file (docs/protocols/frame.md). ``load`` makes of it everything that the codec, both ends, the
documentation and the robot's C++ header need; the three that ship with turtlewire come from ``shipped``.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import msgspec

from turtlewire.errors import DataError, MessageError
from turtlewire.protocols.checksums import Checksum, Coverage, algorithm
from turtlewire.protocols.frame import messages as typed
from turtlewire.protocols.frame.description import (
    AmbiguousDescription,
    Description,
    DialectError,
    MessageDescription,
    read,
)
from turtlewire.protocols.frame.message import FrameMessage
from turtlewire.protocols.message import parse

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from turtlewire.protocols.message import AnyField

SHIPPED = ("0.1", "0.1-literal", "telemetry")
TO_ROBOT, FROM_ROBOT = "to robot", "from robot"
# kind -> (letter of the struct module, Python type)
_WIRE: dict[str, tuple[str, type]] = {
    "u8": ("B", int),
    "bool": ("?", bool),  # reads any byte but 0 as true (F8)
    "u16": ("H", int),
    "i16": ("h", int),
    "u32": ("I", int),
    "i32": ("i", int),
    "f32": ("f", float),
}


class Entry(NamedTuple):
    """One message of a dialect.

    Attributes:
        message_type: its class.
        type: the byte that it begins with.
        direction: "to robot", "from robot" or "both".
        channel: what it is a set-point of, or empty; the newest set-point of a channel wins.
        key: the field that tells the channel's members apart (an engine's number), or empty.
        below: the count that the key stays below, or empty.
        stop: the other fields' values that stop what it moves (F13), or None.
        is_decoded: False where several messages share a type and an ambiguous one is reported (F1).
        is_sent: False for the ambiguous one.
    """

    message_type: type[FrameMessage]
    type: int
    direction: str
    channel: str
    key: str
    below: str
    stop: dict[str, float] | None
    is_decoded: bool = True
    is_sent: bool = True

    def goes(self, direction: str) -> bool:
        """Whether it goes this way."""
        return self.direction in (direction, "both")

    @property
    def layout(self) -> struct.Struct:
        """Type and fields, big endian."""
        return struct.Struct(">B" + field_letters(self.message_type.FIELDS))


def field_letters(fields: Iterable[AnyField]) -> str:
    """What the struct module calls these fields."""
    return "".join(_WIRE[field.kind][0] for field in fields)


class Dialect:
    """A set of messages, and the settings of one robot that speaks it.

    Attributes:
        name, title: from the file.
        baud: of the line (F12).
        checksum: algorithm and coverage (F2).
        counts: how many servos, engines and the like the robot has: numbers (ids) stay below.
        entries: the messages, in the order of the file, then the ambiguous ones.
        enumerations: an ``IntEnum`` for each, by name; its members may be used wherever a message wants a number.
    """

    def __init__(
        self, description: Description, classes: Mapping[str, type[FrameMessage]] | None = None
    ) -> None:
        self._description = description
        self.name = description.name
        self.title = description.title
        self.baud = description.baud
        self.checksum = Checksum(algorithm(description.algorithm), Coverage(description.coverage))
        self.counts = dict(description.counts)
        self.enumerations = {
            name: cast("type[IntEnum]", IntEnum(_pascal(name), members))
            for name, members in description.enumerations.items()
        }
        self._classes = {} if classes is None else dict(classes)
        self.entries = tuple(self._made(description))
        self._by_class = {entry.message_type: entry for entry in self.entries}

    def _made(self, description: Description) -> Iterator[Entry]:
        shared = {name for ambiguous in description.ambiguous for name in ambiguous.messages}
        for message in description.messages:
            yield Entry(
                self._class(message, message.fields),
                message.type,
                message.direction,
                message.channel,
                message.key,
                message.below,
                message.stop,
                is_decoded=message.name not in shared,
            )
        by_name = {message.name: message for message in description.messages}
        for ambiguous in description.ambiguous:
            like = by_name[ambiguous.messages[0]]
            made = self._class(ambiguous, like.fields)
            yield Entry(made, like.type, like.direction, "", like.key, like.below, None, is_sent=False)

    def _class(
        self, described: MessageDescription | AmbiguousDescription, fields: tuple[AnyField, ...]
    ) -> type[FrameMessage]:
        if described.name not in self._classes:
            self._classes[described.name] = _message_class(described.name, described.doc, fields)
        return self._classes[described.name]

    def __repr__(self) -> str:
        return f"<Dialect {self.name}: {', '.join(t.__name__ for t in self.types)}>"

    @property
    def types(self) -> tuple[type[FrameMessage], ...]:
        """The classes of all messages."""
        return tuple(entry.message_type for entry in self.entries)

    def __getitem__(self, name: str) -> type[FrameMessage]:
        """The class of a message by its name, ``SetLamp`` or ``set_lamp``. Raises ``MessageError``."""
        for message_type in self.types:
            if name in (message_type.__name__, message_type.name()):
                return message_type
        raise MessageError(
            f"{self.name} has no message {name!r}; it has {', '.join(t.name() for t in self.types)}"
        )

    def entry(self, message: FrameMessage) -> Entry:
        """What the dialect says about a message. Raises ``MessageError`` if it has none of this type."""
        entry = self._by_class.get(type(message))
        if entry is None:
            raise MessageError(f"{message.name()} is no message of the dialect {self.name}")
        return entry

    def high(self, entry: Entry, field: AnyField) -> float:
        """The greatest value of a field, for this robot: it has so many servos, engines and so on."""
        if field.name == entry.key:
            return min(field.high, self.counts[entry.below] - 1)
        return field.high

    def check(self, message: FrameMessage) -> Entry:
        """What the dialect says about a message that may be sent as it is (F4).

        Raises ``MessageError`` if the message is not of this dialect, is one that only a decoder reports, or has a
        field out of range.
        """
        entry = self.entry(message)
        if not entry.is_sent:
            raise MessageError(f"{message.name()} cannot be sent: it is what a decoder reports")
        message.check()
        if entry.key:
            value = getattr(message, entry.key)
            count = self.counts[entry.below]
            if value >= count:
                raise MessageError(
                    f"{message.name()}: {entry.key} is {value}, but this robot has {count} {entry.below}: "
                    f"numbers begin with 0"
                )
        return entry

    def pack(self, message: FrameMessage, direction: str) -> bytes:
        """The bytes of a message within a frame: type and fields.

        Raises ``MessageError`` as ``check`` does, and if the message does not go this way.
        """
        entry = self.check(message)
        if not entry.goes(direction):
            raise MessageError(f"{message.name()} goes {entry.direction}, not {direction}")
        return entry.layout.pack(entry.type, *message.values())

    def parse(self, text: str) -> FrameMessage:
        """A message from its text form, ``engine_forward engine_id=0 speed=200``. Raises ``MessageError``."""
        message = cast("FrameMessage", parse(text, self.types))
        self.check(message)
        return message

    def stop_messages(self) -> list[FrameMessage]:
        """What an emergency stop says: a stop for every known engine (F13)."""
        messages: list[FrameMessage] = []
        for entry in self.entries:
            if entry.stop is None:
                continue
            if entry.key:
                numbers = range(self.counts[entry.below])
                messages += [entry.message_type(**{entry.key: n}, **entry.stop) for n in numbers]
            else:
                messages.append(entry.message_type(**entry.stop))
        return messages

    def configured(
        self,
        *,
        counts: Mapping[str, int] | None = None,
        types: Mapping[str, int] | None = None,
        crc: str | None = None,
        coverage: str | None = None,
        baud: int | None = None,
    ) -> Dialect:
        """The same messages, the same classes, another robot's settings.

        Args:
            counts: how many there are, 0..256: ``{"engines": 4}``.
            types: other type bytes: ``{"EngineBackward": 7}`` (F1, ``backward_type``).
            crc: a catalogue name (F2).
            coverage: where the CRC begins: magic, seq, size or payload (F2).
            baud: of the line (F12).

        Raises ``DataError`` for what the dialect does not have, a value out of range, and a type that is taken.
        """
        described = self._description
        for name, count in (counts or {}).items():
            if name not in self.counts:
                raise DataError(
                    f"{self.name} counts no {name!r}; it counts {', '.join(self.counts) or 'nothing'}"
                )
            if not 0 <= count <= 256:
                raise DataError(f"{name} must be from 0 to 256, not {count}")
        for name, number in (types or {}).items():
            if name not in [message.name for message in described.messages]:
                raise DataError(f"{self.name} has no message {name!r}")
            if not 0 <= number <= 255:
                raise DataError(f"the type of {name} must be from 0 to 255, not {number}")
        if coverage is not None and coverage not in [c.value for c in Coverage]:
            raise DataError(f"coverage must be {', '.join(c.value for c in Coverage)}, not {coverage!r}")
        messages = tuple(m._replace(type=(types or {}).get(m.name, m.type)) for m in described.messages)
        changed = described._replace(
            counts={**described.counts, **(counts or {})},
            messages=messages,
            algorithm=described.algorithm if crc is None else algorithm(crc).name,
            coverage=coverage or described.coverage,
            baud=baud or described.baud,
        )
        self._check_types(changed)
        return Dialect(changed, self._classes)

    def _check_types(self, described: Description) -> None:
        shared = [frozenset(ambiguous.messages) for ambiguous in described.ambiguous]
        for n, one in enumerate(described.messages):
            for other in described.messages[:n]:
                meet = one.direction == other.direction or "both" in (one.direction, other.direction)
                ambiguous = any({one.name, other.name} <= names for names in shared)
                if meet and (one.type == other.type) != ambiguous:
                    raise DataError(
                        f"{other.name} and {one.name} would have type {other.type:02X} and {one.type:02X}: the dialect "
                        f"{self.name} has them {'the same' if ambiguous else 'different'}"
                        + (
                            ""
                            if ambiguous
                            else " (the dialect 0.1-literal is for robots that have them the same)"
                        )
                    )


def _pascal(name: str) -> str:
    return name.title().replace("_", "")


def _message_class(name: str, doc: str, fields: tuple[AnyField, ...]) -> type[FrameMessage]:
    made = msgspec.defstruct(
        name,
        [(field.name, _WIRE[field.kind][1]) for field in fields],
        bases=(FrameMessage,),
        namespace={"__doc__": doc, "FIELDS": fields},
        module=__name__,
        frozen=True,
        gc=False,
    )
    return cast("type[FrameMessage]", made)


def read_dialect(text: str, file: str = "dialect") -> Dialect:
    """The dialect that a TOML text describes; ``file`` is what errors call it. Raises ``DialectError``."""
    return Dialect(read(text, file))


def load(path: str | Path) -> Dialect:
    """The dialect in a TOML file.

    Raises ``DialectError`` naming file and line, ``DataError`` if the file cannot be read.
    """
    try:
        text = Path(path).read_text("utf-8")
    except OSError as error:
        raise DataError(f"{path}: {error.strerror or error}") from None
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise DialectError(str(path), line, "this is not UTF-8") from None
    return read_dialect(text, str(path))


@cache
def shipped(name: str) -> Dialect:
    """A dialect that comes with turtlewire, by its name in ``SHIPPED``. Raises ``DataError``.

    The messages of ``0.1`` and ``0.1-literal`` are the typed classes of ``turtlewire.protocols.frame.messages``.
    """
    if name not in SHIPPED:
        raise DataError(
            f"there is no dialect {name!r}; known are {', '.join(SHIPPED)}, or the name of a file"
        )
    file = f"{name}.toml"
    text = (resources.files("turtlewire.protocols.frame") / "dialects" / file).read_text("utf-8")
    classes: dict[str, Any] = {} if name == "telemetry" else {t.__name__: t for t in typed.MESSAGES}
    return Dialect(read(text, file), classes)
