from __future__ import annotations

import pytest

from turtlewire.errors import MessageError
from turtlewire.protocols.message import Decoded, Malformed
from turtlewire.protocols.walter.codec import ALL_GROUPS, MAX_RAW, CommandDecoder, Mode, ReplyDecoder, encode
from turtlewire.protocols.walter.messages import (
    DIRECT_KEYS,
    LOGO_COMMANDS,
    MESSAGES,
    ROBOT_MESSAGES,
    EmptyLine,
    Forward,
    GoTo,
    HeadingReply,
    LimitFront,
    LocationReply,
    PenReply,
    PenUp,
    SelectDirect,
    SetMoveSpeed,
    SetSpeed,
    Stop,
    WalterMessage,
)


@pytest.mark.parametrize(
    ("message", "data"),
    [
        (Forward(0x0D0A), "46 0D 0A 0D"),
        (SetSpeed(13), "56 0D 0D"),
        (GoTo(-1, -32768), "43 4C FF FF 80 00 0D"),
        (HeadingReply(5), "51 48 00 05 0D"),  # two bytes, though 359 is the most
        (LocationReply(1, -2), "51 4C 00 01 FF FE 0D"),
        (PenReply(down=True), "51 50 01 0D"),
        (EmptyLine(), "0D"),
        (Stop(), "20"),
        (SetMoveSpeed(13), "47 0D"),
    ],
)
def test_encode(message: WalterMessage, data: str) -> None:
    assert encode(message) == bytes.fromhex(data)


@pytest.mark.parametrize(
    "message", [Forward(65536), Forward(-1), SetSpeed(256), GoTo(0, 40000), HeadingReply(360), PenReply(2)]
)
def test_encode_refuses_what_the_wire_cannot_carry(message: WalterMessage) -> None:
    with pytest.raises(MessageError, match=f"^{message.name()}: .* must be a whole number from"):
        encode(message)


def decoder_of(message_type: type[WalterMessage]) -> CommandDecoder | ReplyDecoder:
    if message_type in ROBOT_MESSAGES:
        return ReplyDecoder()
    return CommandDecoder(Mode.DIRECT if message_type in DIRECT_KEYS else Mode.LOGO)


@pytest.mark.parametrize("message_type", MESSAGES, ids=lambda message: message.name())
def test_both_ends_of_every_range_come_back(message_type: type[WalterMessage]) -> None:
    for values in (
        [field.low for field in message_type.FIELDS],
        [field.high for field in message_type.FIELDS],
        [field.high - n for n, field in enumerate(message_type.FIELDS)],
    ):
        message = message_type(*values)
        data = encode(message)
        assert decoder_of(message_type).receive_data(data) == [Decoded(0, data, message)]


@pytest.mark.parametrize("command", [c for c in LOGO_COMMANDS if c.LETTERS], ids=lambda c: c.name())
def test_every_byte_but_ret_is_wrong_where_ret_must_be(command: type[WalterMessage]) -> None:
    data = encode(command(*(field.low for field in command.FIELDS)))[:-1]
    for byte in range(256):
        items = CommandDecoder().receive_data(data + bytes([byte]) + b"\r")
        if byte == 0x0D:
            assert [type(item) for item in items] == [Decoded, Decoded]  # and an empty line
        else:
            assert items == [Malformed(0, data + bytes([byte]) + b"\r", f"{byte:02X} where RET must be")]


def test_every_first_byte_in_logo_control() -> None:
    letters = {command.LETTERS[:1] for command in LOGO_COMMANDS}
    for byte in range(256):
        decoder = CommandDecoder()
        items = decoder.receive_data(bytes([byte]))
        if byte == 0x0D:
            assert items == [Decoded(0, b"\r", EmptyLine())]
            continue
        assert items == []
        assert decoder.pending == 1
        (item, *_) = decoder.receive_data(b"????????\r")
        assert isinstance(item, Malformed)
        assert item.reason.startswith("unknown letter") == (
            bytes([byte]).upper() not in letters or bytes([byte]).upper() in b"PHECQ"
        )


def test_every_byte_in_direct_control() -> None:
    keys = {key.LETTERS: key for key in DIRECT_KEYS}
    for byte in range(256):
        decoder = CommandDecoder(Mode.DIRECT)
        items = decoder.receive_data(bytes([byte]))
        key = keys.get(bytes([byte]).upper())
        if key is not None and key.FIELDS:
            assert (items, decoder.pending) == ([], 1)
        elif key is not None:
            assert items == [Decoded(0, bytes([byte]), key())]
        elif byte == 0x0D:
            assert items == [Decoded(0, b"\r", EmptyLine())]
        else:
            assert items == [Malformed(0, bytes([byte]), f"no key {byte:02X}")]


def test_the_mode_follows_the_stream() -> None:
    decoder = CommandDecoder()
    modes = []
    for byte in b"2\r1":
        modes.append(decoder.mode)
        decoder.receive_data(bytes([byte]))
    assert modes == [Mode.LOGO, Mode.LOGO, Mode.DIRECT]
    assert decoder.mode is Mode.LOGO


def test_reset_forgets_what_has_begun_and_keeps_mode_and_offset() -> None:
    decoder = CommandDecoder()
    decoder.receive_data(b"F\x00")
    decoder.reset()
    assert decoder.pending == 0
    assert decoder.receive_data(b"PU\r") == [Decoded(2, b"PU\r", PenUp())]
    decoder.receive_data(b"?")  # a line that is being dropped
    decoder.reset()
    assert decoder.receive_data(b"2\r") == [Decoded(6, b"2\r", SelectDirect())]
    decoder.reset()  # no LF is awaited any more
    assert decoder.mode is Mode.DIRECT
    assert decoder.receive_data(b"\n") == [Malformed(8, b"\n", "no key 0A")]
    decoder.receive_data(b"G")
    decoder.reset()
    assert decoder.receive_data(b" ") == [Decoded(10, b" ", Stop())]


@pytest.mark.parametrize("decoder", [CommandDecoder(), ReplyDecoder()], ids=["commands", "replies"])
def test_a_line_without_end_keeps_a_bounded_number_of_bytes(decoder: CommandDecoder | ReplyDecoder) -> None:
    dropped = []
    for _ in range(10 * MAX_RAW):
        dropped += decoder.receive_data(b"?")
        assert decoder.pending < MAX_RAW
    assert dropped == [Malformed(n * MAX_RAW, b"?" * MAX_RAW, "unknown letter '?'") for n in range(10)]
    assert decoder.receive_data(b"\r") == [Malformed(10 * MAX_RAW, b"\r", "unknown letter '?'")]
    assert decoder.receive_data(b"\n\r") == [Decoded(10 * MAX_RAW + 2, b"\r", EmptyLine())]


def test_groups_that_a_robot_lacks_are_unknown_letters() -> None:
    for command in LOGO_COMMANDS:
        data = encode(command(*(0 for _ in command.FIELDS)))
        for group in ALL_GROUPS:
            (item, *_) = CommandDecoder(groups=ALL_GROUPS - {group}).receive_data(data)
            assert isinstance(item, Malformed) == (group == command.GROUP)


def test_two_decoders_do_not_share_what_they_have_taken() -> None:
    first, second = CommandDecoder(), CommandDecoder()
    first.receive_data(b"F\x00")
    assert second.receive_data(b"PU\r") == [Decoded(0, b"PU\r", PenUp())]
    assert first.receive_data(b"\xc8\r") == [Decoded(0, b"F\x00\xc8\r", Forward(200))]


def test_no_bytes_are_no_items() -> None:
    assert CommandDecoder().receive_data(b"") == []
    assert ReplyDecoder().receive_data(b"") == []


@pytest.mark.parametrize("bit", range(256))
def test_the_bit_of_a_pen_reply(bit: int) -> None:
    data = b"QP" + bytes([bit]) + b"\r"
    (item,) = ReplyDecoder().receive_data(data)
    down = {0x00: 0, 0x01: 1, 0x30: 0, 0x31: 1}.get(bit)
    if down is None:
        assert item == Malformed(0, data, "pen_reply: value out of range")
    else:
        assert item == Decoded(0, data, PenReply(down))


@pytest.mark.parametrize("heading_deg", [0, 13, 359, 360, 3341, 65535])
def test_a_heading_beyond_359_makes_the_line_ill_formed_up_to_its_own_ret(heading_deg: int) -> None:
    data = b"QH" + heading_deg.to_bytes(2, "big") + b"\r"
    (item, after) = ReplyDecoder().receive_data(data + b"\nLF\r")
    if heading_deg < 360:
        assert item == Decoded(0, data, HeadingReply(heading_deg))
    else:
        assert item == Malformed(0, data, "heading_reply: value out of range")
    assert after == Decoded(6, b"LF\r", LimitFront())


def test_a_line_that_breaks_off_names_the_letter_that_came() -> None:
    assert CommandDecoder().receive_data(b"c\r") == [Malformed(0, b"c\r", "RET after 'c'")]
    assert ReplyDecoder().receive_data(b"L\r") == [Malformed(0, b"L\r", "RET after 'L'")]
