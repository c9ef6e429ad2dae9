from __future__ import annotations

import random
from typing import TYPE_CHECKING, Any, ClassVar

import pytest

from turtlewire.errors import UsageError
from turtlewire.protocols.message import Decoded, Field, Malformed
from turtlewire.protocols.simple.bulk import decode_commands, decode_replies
from turtlewire.protocols.simple.codec import CommandDecoder
from turtlewire.protocols.simple.messages import (
    COMMANDS,
    REPLIES,
    Accepted,
    DriveForward,
    Headlights,
    Rejected,
    SimpleCommand,
    SteerLeft,
    Stop,
)

if TYPE_CHECKING:
    from turtlewire.protocols.columns import Capture, Messages


class Servo(SimpleCommand, frozen=True):
    LETTER: ClassVar[bytes] = b"V"
    CHANNEL: ClassVar[str] = "servo"
    FIELDS: ClassVar[tuple[Field, ...]] = (Field("place", "u16", 5, 900, "units"),)
    place: int


def columns(messages: Messages) -> dict[str, list[int]]:
    return {name: column.tolist() for name, column in messages.fields.items()}


def errors(capture: Capture[Any]) -> list[tuple[Any, ...]]:
    found = capture.errors
    texts = [found.reasons[reason] for reason in found.reason.tolist()]
    return list(zip(found.offset.tolist(), found.length.tolist(), texts, strict=True))


def test_commands_become_columns() -> None:
    capture = decode_commands(b"F255xyzS------L007000F000000H0190zz" + b"F12345")
    assert set(capture.types) == set(COMMANDS)
    assert capture.of(DriveForward).offset.tolist() == [0, 21]
    assert columns(capture.of(DriveForward)) == {"speed": [255, 0]}
    assert capture.of(DriveForward).fields["speed"].dtype == "u1"
    assert capture.of(Stop).offset.tolist() == [7]
    assert columns(capture.of(Stop)) == {}
    assert columns(capture.of(SteerLeft)) == {"lock": [7]}
    assert list(columns(capture.of(Headlights)).values()) == [[0], [1], [1], [0]]
    assert errors(capture) == []


def test_what_is_wrong_is_told_in_order_with_one_text_for_each_reason() -> None:
    capture = decode_commands(b"x000000F256000F1x/000H01:/00B25600_F256111x111111S000000f000000")
    assert errors(capture) == [
        (0, 7, "unknown letter 'x'"),
        (7, 7, "drive_forward: speed is 256, but must be 0 to 255"),
        (14, 7, "drive_forward: 'x' where a digit of speed must be"),
        (21, 7, "headlights: ':' where a digit of right_upper must be"),
        (28, 7, "drive_backward: speed is 256, but must be 0 to 255"),
        (35, 7, "drive_forward: speed is 256, but must be 0 to 255"),
        (42, 7, "unknown letter 'x'"),
        (56, 7, "unknown letter 'f'"),
    ]
    assert len(capture.errors.reasons) == 6
    assert capture.of(Stop).offset.tolist() == [49]


def test_digits_in_front_of_what_is_wrong_are_no_reason() -> None:
    capture = decode_commands(b"F9x0000F9y0000F0y0000F09/000")
    assert [text[15:18] for *_, text in errors(capture)] == ["'x'", "'y'", "'y'", "'/'"]
    assert len(capture.errors.reasons) == 3


def test_an_extension_has_columns_too() -> None:
    capture = decode_commands(b"V900abcV901000V005000V004000V000000", (Servo,))
    assert columns(capture.of(Servo)) == {"place": [900, 5]}
    assert capture.of(Servo).fields["place"].dtype == "u2"
    assert errors(capture) == [
        (7, 7, "servo: place is 901, but must be 5 to 900"),
        (21, 7, "servo: place is 4, but must be 5 to 900"),
        (28, 7, "servo: place is 0, but must be 5 to 900"),
    ]
    assert [text for *_, text in errors(decode_commands(b"V900abc"))] == ["unknown letter 'V'"]


def test_an_extension_that_cannot_be_told_is_refused() -> None:
    with pytest.raises(UsageError, match="channel"):
        decode_commands(b"", (DriveForward,))


def test_replies_become_columns() -> None:
    capture = decode_replies(b"KFxK\nx")
    assert set(capture.types) == set(REPLIES)
    assert capture.of(Accepted).offset.tolist() == [0, 3]
    assert capture.of(Rejected).offset.tolist() == [1]
    assert errors(capture) == [(2, 1, "no reply 'x'"), (4, 1, "no reply 0A"), (5, 1, "no reply 'x'")]
    assert len(capture.errors.reasons) == 2


def test_the_items_are_the_streaming_decoders() -> None:
    assert decode_commands(b"S000000q123456F007000").items() == [
        Decoded(0, b"S000000", Stop()),
        Malformed(7, b"q123456", "unknown letter 'q'"),
        Decoded(14, b"F007000", DriveForward(7)),
    ]
    assert decode_replies(b"?K").items() == [Malformed(0, b"?", "no reply '?'"), Decoded(1, b"K", Accepted())]


def test_nothing_gives_nothing() -> None:
    assert decode_commands(b"F12345").items() == []
    assert decode_replies(b"").items() == []


def test_a_long_and_noisy_capture() -> None:
    chance = random.Random(1)
    data = bytes(
        chance.choice(b"FBLRSHX") if at % 7 == 0 else chance.choice(b"0122345678" * 4 + b"x/:")
        for at in range(70_000)
    )
    assert decode_commands(data).items() == CommandDecoder().receive_data(data)
