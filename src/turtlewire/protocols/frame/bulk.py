"""A whole capture at once, to columns: the streaming decoder's result, by NumPy (the extra ``turtlewire[bulk]``)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from turtlewire.protocols.frame.bulk_frames import Frames, frames
from turtlewire.protocols.frame.bulk_messages import (
    COUNTS,
    INCONSISTENT,
    NOWHERE,
    UNKNOWN_TYPE,
    Column,
    fields,
    places,
    refused,
)
from turtlewire.protocols.frame.dialect import TO_ROBOT
from turtlewire.protocols.frame.layout import layouts

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from turtlewire.protocols.frame.dialect import Dialect
    from turtlewire.protocols.frame.layout import Layout
    from turtlewire.protocols.frame.message import FrameMessage


class Messages(NamedTuple):
    """All messages of one type, in order.

    Attributes:
        frame: of each, the index of its frame.
        offset: where in the capture its type byte stands.
        refused: whether it breaks its restriction (F4): not to be carried out.
        fields: a column for each field, by name.
    """

    frame: NDArray[np.int64]
    offset: NDArray[np.int64]
    refused: NDArray[np.bool_]
    fields: dict[str, Column]


class Capture(NamedTuple):
    """Every frame with a right CRC that a receiver takes, and its messages.

    Attributes:
        offset: where in the capture each frame's magic byte stands.
        seq: the sequence numbers.
        size: how many bytes of messages each carries.
        ignored: COUNTS; or UNKNOWN_TYPE or INCONSISTENT: then none of its messages is here (F3).
        messages: by the messages' classes.
    """

    offset: NDArray[np.int64]
    seq: NDArray[np.uint8]
    size: NDArray[np.uint8]
    ignored: NDArray[np.uint8]
    messages: dict[type[FrameMessage], Messages]


def decode(data: bytes, dialect: Dialect, direction: str = TO_ROBOT) -> Capture:
    """Decode a whole capture: what ``FrameDecoder.receive_data`` and then ``end`` take for frames.

    What is damaged has no place in the columns; the streaming decoder tells about it.
    """
    capture = np.frombuffer(data, np.uint8)
    table = layouts(dialect, direction)
    parts: list[Capture] = []
    number = 0
    for some in frames(capture, dialect.checksum):
        parts.append(_decoded(capture, some, number, table))
        number += len(some.offset)
    if not parts:
        parts.append(_decoded(capture, Frames(np.empty(0, np.int64), capture[:0], 0), 0, table))
    return parts[0] if len(parts) == 1 else _joined(parts)


def _decoded(capture: NDArray[np.uint8], some: Frames, before: int, table: list[Layout | None]) -> Capture:
    """The columns of some frames; so many others are before them."""
    sizes = np.array([0 if layout is None else layout.size for layout in table], np.uint8)
    ignored, there = places(capture, some, sizes)
    messages = {}
    for number, layout in enumerate(table):
        if layout is not None:
            mine = there.get(number, NOWHERE)
            columns = fields(capture, mine, layout)
            frame = mine.frame + before if before else mine.frame
            broken = refused(columns, layout, len(frame))
            messages[layout.message_type] = Messages(frame, mine.offset, broken, columns)
    return Capture(some.offset, capture[1:].take(some.offset), some.size, ignored, messages)


def _joined(parts: list[Capture]) -> Capture:
    """The columns of all parts, one behind the other."""
    messages = {}
    for message_type in parts[0].messages:
        of_type = [part.messages[message_type] for part in parts]
        frame, offset, broken = (np.concatenate([found[n] for found in of_type]) for n in range(3))
        columns = {
            name: np.concatenate([found.fields[name] for found in of_type]) for name in of_type[0].fields
        }
        messages[message_type] = Messages(frame, offset, broken, columns)
    offset, seq, size, ignored = (np.concatenate([part[n] for part in parts]) for n in range(4))
    return Capture(offset, seq, size, ignored, messages)


__all__ = ["COUNTS", "INCONSISTENT", "UNKNOWN_TYPE", "Capture", "Messages", "decode"]
