from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from turtlewire.protocols.columns import Capture, Errors, Messages, Reasons, in_order
from turtlewire.protocols.message import Decoded, Malformed
from turtlewire.protocols.simple.messages import Accepted, DriveForward, SimpleMessage, Stop

if TYPE_CHECKING:
    from turtlewire.protocols.columns import Fields


def capture() -> Capture[SimpleMessage]:
    places = np.array([1, 3, 8], np.int64)
    errors = Errors(np.array([0, 5]), np.array([1, 3]), np.array([1, 0]), ("first", "second"))
    fields: dict[type[SimpleMessage], Fields] = {DriveForward: {"speed": np.array([7, 9], np.uint8)}}
    kinds = np.array([1, 0, 1], np.uint8)
    return Capture(bytes(range(10)), {Stop: 2, DriveForward: 2, Accepted: 1}, places, kinds, fields, errors)


def test_the_messages_of_one_type() -> None:
    offset, fields = capture().of(DriveForward)
    assert offset.tolist() == [1, 8]
    assert {name: column.tolist() for name, column in fields.items()} == {"speed": [7, 9]}
    assert capture().of(Stop).offset.tolist() == [3]
    none: Messages = capture().of(Accepted)
    assert none.offset.tolist() == []
    assert none.fields == {}


def test_a_type_that_the_wire_does_not_carry_is_an_error() -> None:
    with pytest.raises(KeyError):
        capture().of(SimpleMessage)


def test_one_object_for_each_in_the_order_of_the_wire() -> None:
    assert capture().items() == [
        Malformed(0, b"\x00", "second"),
        Decoded(1, b"\x01\x02", DriveForward(7)),
        Decoded(3, b"\x03\x04", Stop()),
        Malformed(5, b"\x05\x06\x07", "first"),
        Decoded(8, b"\x08\x09", DriveForward(9)),
    ]


def test_each_reason_is_asked_for_once() -> None:
    asked: list[int] = []

    def text(code: int) -> str:
        asked.append(code)
        return f"reason {code}"

    reasons = Reasons(100, text)
    index, texts = reasons.numbered(np.array([99, 3, 99, 3]))
    assert [texts[n] for n in index.tolist()] == ["reason 99", "reason 3", "reason 99", "reason 3"]
    assert len(texts) == 2
    index, texts = reasons.numbered(np.array([0, 3], np.uint8))
    assert [texts[n] for n in index.tolist()] == ["reason 0", "reason 3"]
    assert sorted(asked) == [0, 3, 99]
    index, texts = reasons.numbered(np.empty(0, np.int64))
    assert (index.tolist(), texts) == ([], ())


def test_columns_are_put_in_order_together() -> None:
    offset, kind = in_order(np.array([5, 1, 3]), np.array([0, 1, 2], np.uint8))
    assert offset.tolist() == [1, 3, 5]
    assert kind.tolist() == [1, 2, 0]
