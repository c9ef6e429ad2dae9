"""What a whole capture becomes when it is decoded at once: columns, by NumPy (the extra ``turtlewire[bulk]``).

One row for each message, in the order of the wire, tells where it begins and of which type it is; the fields of all
messages of one type stand together. This is what bulk decoders give of protocols whose bytes are messages and nothing
else.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import repeat
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

import numpy as np

from turtlewire.protocols.message import AnyMessage, Decoded, Malformed

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

MessageT = TypeVar("MessageT", bound=AnyMessage)
Column = Any  # NDArray of the field's kind
Fields = dict[str, Column]  # a column for each field, by name


class Messages(NamedTuple):
    """All messages of one type, in order.

    Attributes:
        offset: where in the capture each begins.
        fields: a column for each field, by name.
    """

    offset: NDArray[np.int64]
    fields: Fields


class Errors(NamedTuple):
    """All bytes that are no message, in order.

    Attributes:
        offset: where in the capture they begin.
        length: how many they are.
        reason: why, as an index of ``reasons``.
        reasons: the texts, each once.
    """

    offset: NDArray[np.int64]
    length: NDArray[np.int64]
    reason: NDArray[np.int64]
    reasons: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Capture(Generic[MessageT]):
    """All that a streaming decoder makes of a capture.

    Attributes:
        data: the capture.
        types: the messages' classes that there may be, and how many bytes each has on the wire.
        offset: where in the capture each message begins, in order.
        kind: of which type each is, as an index of ``types``.
        fields: of each type that has fields, their columns by name: a value for each message of this type, in order.
        errors: what is no message.
    """

    data: bytes
    types: dict[type[MessageT], int]
    offset: NDArray[np.int64]
    kind: NDArray[np.uint8]
    fields: dict[type[MessageT], Fields]
    errors: Errors

    def of(self, message_type: type[MessageT]) -> Messages:
        """All messages of one type. Raises ``KeyError`` if it is none of ``types``."""
        number = {known: number for number, known in enumerate(self.types)}[message_type]
        return Messages(self.offset[self.kind == number], self.fields.get(message_type, {}))

    def items(self) -> list[Decoded[MessageT] | Malformed]:
        """What ``receive_data`` of the streaming decoder returns: one object for each, which takes its time."""
        data = self.data
        lengths = list(self.types.values())
        messages = [self._messages(message_type) for message_type in self.types]
        items: list[Decoded[MessageT] | Malformed] = [
            Decoded(offset, data[offset : offset + lengths[kind]], next(messages[kind]))
            for offset, kind in zip(self.offset.tolist(), self.kind.tolist(), strict=True)
        ]
        of_errors = (column.tolist() for column in self.errors[:3])
        items += (
            Malformed(offset, data[offset : offset + length], self.errors.reasons[reason])
            for offset, length, reason in zip(*of_errors, strict=True)
        )
        return sorted(items, key=lambda item: item.offset)

    def _messages(self, message_type: type[MessageT]) -> Iterator[MessageT]:
        columns = [column.tolist() for column in self.fields.get(message_type, {}).values()]
        return map(message_type, *columns) if columns else repeat(message_type())


class Reasons:
    """The texts of what is wrong: a bulk decoder knows only codes that stand for them, from 0 to below ``codes``.

    ``text`` gives that of a code; it is asked once for each. No two codes have the same.
    """

    def __init__(self, codes: int, text: Callable[[int], str]) -> None:
        self._codes = codes
        self._text = cache(text)

    def numbered(self, code: NDArray[Any]) -> tuple[NDArray[np.int64], tuple[str, ...]]:
        """For each code the index of its text, and the texts."""
        if not len(code):
            return np.empty(0, np.int64), ()
        seen = np.zeros(self._codes, np.bool_)
        seen[code] = True
        present = np.flatnonzero(seen)
        index = np.zeros(self._codes, np.int64)
        index[present] = np.arange(len(present))
        return index.take(code), tuple(map(self._text, present.tolist()))


def in_order(offset: NDArray[np.int64], *others: NDArray[Any]) -> tuple[NDArray[Any], ...]:
    """Columns, put in the order of their offsets."""
    order = np.argsort(offset, kind="stable")
    return tuple(column.take(order) for column in (offset, *others))
