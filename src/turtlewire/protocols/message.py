"""What all messages of all protocols have in common."""

from __future__ import annotations

import re
from typing import Any, ClassVar, Generic, NamedTuple, Self, TypeVar

import msgspec

from turtlewire.errors import MessageError

# kind -> (bytes on the wire, signed)
KINDS = {"u8": (1, False), "bit": (1, False), "u16": (2, False), "i16": (2, True)}


class Field(NamedTuple):
    """One field of a message as the wire carries it: big endian, ``low`` <= value <= ``high``."""

    name: str
    kind: str
    low: int
    high: int
    unit: str


class Message(msgspec.Struct, frozen=True):
    """A message: immutable, equal when type and fields are equal.

    Fields are the integers that the wire carries, in the unit that their name states. They are checked
    when the message is encoded or read from text, not when it is made: decoders make many.
    """

    FIELDS: ClassVar[tuple[Field, ...]] = ()

    @classmethod
    def name(cls) -> str:
        """The name in the text form: ``SetSpeed`` is ``set_speed``, ``XReply`` is ``x_reply``."""
        return re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()

    def values(self) -> tuple[int, ...]:
        """The fields' values in the order of the wire."""
        return tuple(getattr(self, field.name) for field in self.FIELDS)

    def check(self) -> Self:
        """Return self. Raises ``MessageError`` if a field is not an integer within its range."""
        for field in self.FIELDS:
            value: Any = getattr(self, field.name)
            if not isinstance(value, int) or not field.low <= value <= field.high:
                raise MessageError(
                    f"{self.name()}: {field.name} is {value!r}, but must be a whole number from "
                    f"{field.low} to {field.high} ({field.unit})"
                )
        return self

    def __str__(self) -> str:
        """The text form: the name, then each field as ``name=value`` (a truth value as 0 or 1)."""
        pairs = zip(self.FIELDS, self.values(), strict=True)
        return self.name() + "".join(f" {field.name}={+value}" for field, value in pairs)


MessageT_co = TypeVar("MessageT_co", bound=Message, covariant=True)


class Decoded(NamedTuple, Generic[MessageT_co]):
    """A message, where in the stream its bytes began, and the bytes."""

    offset: int
    raw: bytes
    message: MessageT_co


class Malformed(NamedTuple):
    """Bytes that are no message, where in the stream they began, and why."""

    offset: int
    raw: bytes
    reason: str


def parse(text: str, types: tuple[type[Message], ...]) -> Message:
    """Read the text form of a message: ``forward distance_half_mm=200`` (or just ``forward 200``).

    Raises ``MessageError`` naming what is wrong and what is known.
    """
    words = text.split()
    known = {message_type.name(): message_type for message_type in types}
    if not words or words[0].lower() not in known:
        what = f"there is no message {words[0]!r}" if words else "there is no message in an empty text"
        raise MessageError(f"{what}; known are {', '.join(known)}")
    message_type = known[words[0].lower()]
    fields = {field.name: field for field in message_type.FIELDS}
    unset = list(fields)
    values: dict[str, int] = {}
    for word in words[1:]:
        name, equals, value = word.rpartition("=")
        name = name.lower() if equals else (unset[0] if unset else "")
        if name not in unset:
            raise MessageError(
                f"{text!r}: {word!r} fits no field; {words[0]} has " + (" ".join(fields) or "no fields")
            )
        unset.remove(name)
        try:
            values[name] = int(value, 0)
        except ValueError:
            raise MessageError(f"{text!r}: {value!r} is not a whole number") from None
    if unset:
        raise MessageError(f"{text!r} lacks {' and '.join(unset)}")
    return message_type(**values).check()
