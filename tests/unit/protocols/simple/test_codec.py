from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any, ClassVar

import pytest

from tools.generators import simple
from turtlewire.errors import MessageError, UsageError
from turtlewire.protocols.message import Decoded, Field, Malformed, parse
from turtlewire.protocols.simple import messages
from turtlewire.protocols.simple.codec import CommandDecoder, ReplyDecoder, encode, layouts
from turtlewire.protocols.simple.messages import (
    COMMANDS,
    EMERGENCY_STOP,
    MESSAGES,
    REPLIES,
    DriveForward,
    Headlights,
    SimpleCommand,
    Stop,
)

ROOT = Path(__file__).parents[4]
SPEC: dict[str, Any] = tomllib.loads((ROOT / "spec/protocols/simple.toml").read_text("utf-8"))


def extension(
    letter: bytes = b"V", channel: str = "servos", fields: tuple[Field, ...] = ()
) -> type[SimpleCommand]:
    class Extension(SimpleCommand, frozen=True):
        LETTER: ClassVar[bytes] = letter
        CHANNEL: ClassVar[str] = channel
        FIELDS: ClassVar[tuple[Field, ...]] = fields

    return Extension


# The source's table, read by hand: letter, digits, channel.
SOURCE = {
    "DriveForward": ("F", "vvv---", "drive", 1),
    "DriveBackward": ("B", "vvv---", "drive", -1),
    "SteerLeft": ("L", "vvv---", "steer", -1),
    "SteerRight": ("R", "vvv---", "steer", 1),
    "Stop": ("S", "------", "", 1),
    "Headlights": ("H", "abcd--", "lights", 1),
}


def test_the_description_is_the_sources_table() -> None:
    described = {message["name"]: message for message in SPEC["message"]}
    assert [*described] == [*SOURCE, "Accepted", "Rejected"]
    for command_type in COMMANDS:
        letter, positions, channel, sign = SOURCE[command_type.__name__]
        assert letter.encode() == command_type.LETTER
        assert (channel, sign) == (command_type.CHANNEL, command_type.SIGN)
        assert (channel in ("drive", "steer")) == command_type.STOPPED
        assert simple.wire(described[command_type.__name__], 7) == letter + positions
    assert [reply.LETTER for reply in REPLIES] == [b"K", b"F"]
    assert (messages.BAUD, messages.LENGTH, messages.DONT_CARE, messages.MAX_WINDOW) == (9600, 7, b"0", 8)
    assert messages.PROBE == b"S"
    assert EMERGENCY_STOP == b"S" * 14


def test_generated_files_are_current_and_complete() -> None:
    for path, text in simple.files().items():
        assert path.read_text("utf-8") == text, f"{path.name}: run `make generate`"
    table = [line for line in simple.page(SPEC).splitlines() if line.startswith("| `")]
    assert [line.split("`")[1] for line in table] == [message.__name__ for message in MESSAGES]
    assert {line.count("|") for line in table} == {6}


def test_every_value_goes_there_and_back() -> None:
    for command_type in COMMANDS[:4]:
        wire = b"".join(encode(command_type(value)) for value in range(256))
        assert len(wire) == 256 * 7
        items = CommandDecoder().receive_data(wire)
        assert [item.message.values() for item in items if isinstance(item, Decoded)] == [
            (value,) for value in range(256)
        ]


@pytest.mark.parametrize("value", [-1, 256, 1000])
def test_what_does_not_fit_is_not_encoded(value: int) -> None:
    with pytest.raises(MessageError, match=f"speed is {value}"):
        encode(DriveForward(value))
    with pytest.raises(MessageError, match="left_lower"):
        encode(Headlights(1, value, 0, 0))


def test_text_form() -> None:
    assert str(DriveForward(100)) == "drive_forward speed=100"
    assert (
        str(Headlights(*map(bool, (1, 0, 1, 0))))
        == "headlights left_upper=1 left_lower=0 right_upper=1 right_lower=0"
    )
    assert encode(Headlights(*map(bool, (1, 0, 1, 0)))) == b"H101000"
    for message_type in COMMANDS:
        message = message_type(*(1 for _ in message_type.FIELDS))
        assert parse(str(message), MESSAGES) == message


def test_reset_forgets_what_has_begun_and_goes_on_counting() -> None:
    decoder = CommandDecoder()
    assert decoder.receive_data(b"F25") == []
    assert decoder.pending == b"F25"
    decoder.reset()
    assert decoder.pending == b""
    assert decoder.receive_data(b"S000000") == [Decoded(3, b"S000000", Stop())]


def test_replies_count_on() -> None:
    decoder = ReplyDecoder()
    decoder.receive_data(b"KK")
    assert decoder.receive_data(b"*") == [Malformed(2, b"*", "no reply '*'")]


# ------------------------------------------------------------------------------------------------- extensions (S10)


def test_an_extension_has_six_positions() -> None:
    fields = (
        Field("a", "bit", 0, 1, ""),
        Field("b", "u16", 5, 999, ""),
        Field("c", "bit", 0, 1, ""),
        Field("d", "bit", 0, 1, ""),
    )

    class Six(SimpleCommand, frozen=True):
        LETTER: ClassVar[bytes] = b"K"
        CHANNEL: ClassVar[str] = "six"
        FIELDS: ClassVar[tuple[Field, ...]] = fields
        a: int
        b: int
        c: int
        d: int

    assert encode(Six(1, 999, 0, 1)) == b"K199901"
    decoder = CommandDecoder((Six,))
    items = decoder.receive_data(b"K101270K1004xx")
    assert items[0] == Decoded(0, b"K101270", Six(1, 12, 1, 0))
    assert items[1] == Malformed(7, b"K1004xx", "six: b is 4, but must be 5 to 999")


@pytest.mark.parametrize("letter", [b"F", b"S", b"H", b"", b"VV", b"v", b"7", b"\xc4"])
def test_an_extension_needs_a_letter_of_its_own(letter: bytes) -> None:
    with pytest.raises(
        UsageError, match=r"must be one capital letter A to Z that no other command has \(taken are FBLRSH"
    ):
        layouts((extension(letter),))


def test_two_extensions_need_two_letters_and_may_share_a_channel() -> None:
    assert len(layouts((extension(b"V"), extension(b"W")))) == 8
    with pytest.raises(UsageError, match="taken are FBLRSHV"):
        layouts((extension(b"V"), extension(b"V", "other")))


@pytest.mark.parametrize("channel", ["", "drive", "steer", "lights"])
def test_an_extension_needs_a_channel_of_its_own(channel: str) -> None:
    with pytest.raises(UsageError, match=re.escape("one of its own (taken are drive, lights, steer)")):
        layouts((extension(channel=channel),))


@pytest.mark.parametrize(
    "fields",
    [
        (Field("a", "u8", 0, 256, ""),),
        (Field("a", "u16", 0, 1000, ""),),
        (Field("a", "bit", 0, 2, ""),),
        (Field("a", "u8", -1, 5, ""),),
        (Field("a", "u8", 6, 5, ""),),
        (Field("a", "i16", 0, 5, ""),),
        (Field("x", "u8", 0, 5, ""), Field("y", "u8", 0, 5, ""), Field("a", "bit", 0, 1, "")),
    ],
)
def test_an_extensions_fields_must_fit(fields: tuple[Field, ...]) -> None:
    with pytest.raises(UsageError, match=r"extension: a \(.*does not fit: there are six positions"):
        layouts((extension(fields=fields),))
