"""What all messages of all protocols have in common."""

from __future__ import annotations

import re
import struct
from typing import Any, ClassVar, Generic, NamedTuple, Self, TypeVar, overload

import msgspec

from turtlewire.errors import MessageError

# kind -> (bytes on the wire, signed). f32 is a number with a fraction, all others are whole.
KINDS = {
    "u8": (1, False),
    "bool": (1, False),
    "bit": (1, False),
    "u16": (2, False),
    "i16": (2, True),
    "u32": (4, False),
    "i32": (4, True),
    "f32": (4, True),
}
TRUTHS = {"false": 0, "true": 1}
_F32 = struct.Struct(">f")
_WORD = re.compile(r"\S+")


def text_name(class_name: str) -> str:
    """The name in the text form: ``SetSpeed`` is ``set_speed``, ``XReply`` is ``x_reply``."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", class_name).lower()


def nearest_f32(value: float) -> float:
    """What becomes of a number on a wire that carries 32-bit floats. Raises ``OverflowError`` beyond their range."""
    rounded: float = _F32.unpack(_F32.pack(value))[0]
    return rounded


class Field(NamedTuple):
    """One field of a message as the wire carries it: big endian, a whole number, ``low`` <= value <= ``high``.

    A field with ``choices`` (pairs of a name and a number) takes only these numbers, and shows their names.
    """

    name: str
    kind: str
    low: int
    high: int
    unit: str
    choices: tuple[tuple[str, int], ...] = ()

    def fits(self, value: object) -> bool:
        """Whether a message may carry this value here."""
        if not isinstance(value, int) or not self.low <= value <= self.high:
            return False
        return not self.choices or value in dict(self.choices).values()

    def expectation(self) -> str:
        """What fits, in words."""
        if self.choices:
            return "one of " + ", ".join(f"{name} ({number})" for name, number in self.choices)
        return f"a whole number from {self.low} to {self.high} ({self.unit})"

    def text(self, value: int) -> str:
        """The text form of a value: its name where it has one; a truth value as 0 or 1."""
        return {number: name for name, number in self.choices}.get(value, str(+value))

    def read(self, text: str) -> int:
        """The value of a text form. Raises ``ValueError`` with what is wrong."""
        names = dict(self.choices) or (TRUTHS if self.kind == "bool" else {})
        if text.lower() in names:
            return names[text.lower()]
        try:
            return int(text, 0)
        except ValueError:
            known = f" and none of {', '.join(names)}" if names else ""
            raise ValueError(f"{text!r} is not a whole number{known}") from None


class RealField(NamedTuple):
    """One field of a message that is a 32-bit float, big endian: ``low`` <= value <= ``high``; never NaN."""

    name: str
    kind: str
    low: float
    high: float
    unit: str

    def fits(self, value: object) -> bool:
        """Whether a message may carry this value here, rounded as the wire rounds it."""
        if not isinstance(value, int | float):
            return False
        try:
            return self.low <= nearest_f32(value) <= self.high
        except OverflowError:
            return False

    def expectation(self) -> str:
        """What fits, in words."""
        return f"a number from {self.text(self.low)} to {self.text(self.high)} ({self.unit})"

    def text(self, value: float) -> str:
        """The shortest text form that the wire cannot tell from the value."""
        for digits in range(6, 9):
            short = f"{value:.{digits}g}"
            if float(short) == value or _F32.pack(float(short)) == _F32.pack(value):
                return short
        return f"{value:.9g}"

    def read(self, text: str) -> float:
        """The value of a text form, rounded as the wire rounds it. Raises ``ValueError`` with what is wrong."""
        try:
            value = float(text)
        except ValueError:
            raise ValueError(f"{text!r} is not a number") from None
        try:
            return nearest_f32(value)
        except OverflowError:
            return value  # for ``fits`` to refuse


AnyField = Field | RealField


class AnyMessage(msgspec.Struct, frozen=True):
    """A message of any protocol: immutable, equal when type and fields are equal.

    Fields are the numbers that the wire carries, in the unit that their name states. They are checked
    when the message is encoded or read from text, not when it is made: decoders make many.
    """

    FIELDS: ClassVar[tuple[AnyField, ...]] = ()

    @classmethod
    def name(cls) -> str:
        """The name in the text form (``text_name``)."""
        return text_name(cls.__name__)

    def values(self) -> tuple[float, ...]:
        """The fields' values in the order of the wire."""
        return tuple(getattr(self, field.name) for field in self.FIELDS)

    def check(self) -> Self:
        """Return self. Raises ``MessageError`` if a field's value is of the wrong kind or out of its range."""
        for field in self.FIELDS:
            value: Any = getattr(self, field.name)
            if not field.fits(value):
                raise MessageError(_misfit(type(self), field, value))
        return self

    def __str__(self) -> str:
        """The text form: the name, then each field as ``name=value`` (a truth value as 0 or 1)."""
        values: tuple[Any, ...] = self.values()
        pairs = zip(self.FIELDS, values, strict=True)
        return self.name() + "".join(f" {field.name}={field.text(value)}" for field, value in pairs)


class Message(AnyMessage, frozen=True):
    """A message whose fields are whole numbers, one and all."""

    FIELDS: ClassVar[tuple[Field, ...]] = ()

    def values(self) -> tuple[int, ...]:
        """The fields' values in the order of the wire."""
        return tuple(getattr(self, field.name) for field in self.FIELDS)


MessageT_co = TypeVar("MessageT_co", bound=AnyMessage, covariant=True)


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


def _misfit(message_type: type[AnyMessage], field: AnyField, value: Any) -> str:
    return f"{message_type.name()}: {field.name} is {value!r}, but must be {field.expectation()}"


@overload
def parse(text: str, types: tuple[type[Message], ...]) -> Message: ...
@overload
def parse(text: str, types: tuple[type[AnyMessage], ...]) -> AnyMessage: ...
def parse(text: str, types: tuple[type[AnyMessage], ...]) -> AnyMessage:
    """Read the text form of a message: ``forward distance_half_mm=200`` (or just ``forward 200``).

    Raises ``MessageError`` naming what is wrong, where, and what is known.
    """
    words = list(_WORD.finditer(text))
    known = {message_type.name(): message_type for message_type in types}
    if not words or words[0][0].lower() not in known:
        what = f"there is no message {words[0][0]!r}" if words else "there is no message in an empty text"
        raise MessageError(f"{what}; known are {', '.join(known)}", words[0].span() if words else None)
    message_type = known[words[0][0].lower()]
    fields = {field.name: field for field in message_type.FIELDS}
    unset = list(fields)
    values: dict[str, float] = {}
    for word in words[1:]:
        name, equals, value = word[0].rpartition("=")
        name = name.lower() if equals else (unset[0] if unset else "")
        if name not in unset:
            known_fields = " ".join(fields) or "no fields"
            raise MessageError(
                f"{text!r}: {word[0]!r} fits no field; {words[0][0]} has {known_fields}", word.span()
            )
        unset.remove(name)
        try:
            values[name] = fields[name].read(value)
        except ValueError as error:
            raise MessageError(f"{text!r}: {error}", word.span()) from None
        if not fields[name].fits(values[name]):
            raise MessageError(_misfit(message_type, fields[name], values[name]), word.span())
    if unset:
        raise MessageError(f"{text!r} lacks {' and '.join(unset)}", (words[-1].end(), words[-1].end()))
    return message_type(**values)
