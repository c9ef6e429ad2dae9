from __future__ import annotations

import random
from typing import Any

import pytest

from turtlewire.protocols.message import Decoded, Malformed
from turtlewire.protocols.walter import bulk_lines
from turtlewire.protocols.walter.bulk import WalterCapture, decode_commands, decode_replies
from turtlewire.protocols.walter.codec import CommandDecoder, Mode, ReplyDecoder, encode
from turtlewire.protocols.walter.messages import (
    ATTENTION,
    DIRECT_KEYS,
    EMERGENCY_STOP,
    LOGO_COMMANDS,
    ROBOT_MESSAGES,
    EmptyLine,
    Forward,
    GoTo,
    HeadingReply,
    LimitFront,
    PenReply,
    PenUp,
    QueryHeading,
    SelectDirect,
    SelectLogo,
    SetMoveSpeed,
    SetSpeed,
    SetTurnSpeed,
    StartForward,
    Stop,
    WalterMessage,
)


def found(capture: WalterCapture) -> dict[type[WalterMessage], tuple[Any, ...]]:
    """Of the types of which there are any: the offsets, then each field's values."""
    assert capture.offset.tolist() == sorted(capture.offset.tolist())
    messages = {message_type: capture.of(message_type) for message_type in capture.types}
    return {
        message_type: (offset.tolist(), *(column.tolist() for column in fields.values()))
        for message_type, (offset, fields) in messages.items()
        if len(offset)
    }


def errors(capture: WalterCapture) -> list[tuple[Any, ...]]:
    offset, length, reason, reasons = capture.errors
    texts = [reasons[index] for index in reason.tolist()]
    return list(zip(offset.tolist(), length.tolist(), texts, strict=True))


def test_lines_become_columns() -> None:
    capture = decode_commands(b"F\x01\x02\rpu\r\nCL\xff\x38\x01\x2c\rf\r\n\rV\x64\r\nf\xff")
    assert found(capture) == {
        Forward: ([0, 15], [258, 3338]),
        PenUp: ([4],),
        GoTo: ([8], [-200], [300]),
        SetSpeed: ([19], [100]),
    }
    assert set(capture.types) == {*LOGO_COMMANDS, *DIRECT_KEYS}
    columns = capture.fields[GoTo]
    assert list(columns) == ["x_half_mm", "y_half_mm"]
    assert columns["x_half_mm"].dtype == "i2"
    assert capture.fields[Forward]["distance_half_mm"].dtype == "u2"
    assert errors(capture) == []
    assert capture.mode is Mode.LOGO


def test_what_looks_like_a_line_within_another_is_none() -> None:
    capture = decode_commands(b"F\x002\rCLPUPU\rCL2\r2\r\rPU\r")
    assert found(capture) == {
        Forward: ([0], [50]),
        GoTo: ([4, 11], [0x5055, 0x320D], [0x5055, 0x320D]),
        PenUp: ([18],),
    }
    assert capture.mode is Mode.LOGO


@pytest.mark.parametrize(
    ("data", "wrong"),
    [
        (b"x\r", [(0, 2, "unknown letter 'x'")]),
        (b"\n\r", [(0, 2, "unknown letter 0A")]),
        (b"p?abc\r", [(0, 6, "unknown letter '?' after 'p'")]),
        (b"P\r", [(0, 2, "RET after 'P'")]),
        (b"P\x00\rP\r", [(0, 3, "unknown letter 00 after 'P'"), (3, 2, "RET after 'P'")]),
        (b"\x00\r2\r\x00", [(0, 2, "unknown letter 00"), (4, 1, "no key 00")]),
        (b"F\x00\x00\x00\r", [(0, 5, "00 where RET must be")]),
        (b"F\x00\x00\x00\r\x00\r", [(0, 5, "00 where RET must be"), (5, 2, "unknown letter 00")]),
        (b"F\r\r\r\rx\r", [(5, 2, "unknown letter 'x'")]),
        (b"PU\n\r", [(0, 4, "0A where RET must be")]),
        (b"xyz", []),
        (b"P", []),
        (b"PU", []),
        (b"x" * 64, [(0, 64, "unknown letter 'x'")]),
        (b"x" * 63 + b"\r\n", [(0, 64, "unknown letter 'x'")]),
        (b"x" * 130, [(0, 64, "unknown letter 'x'"), (64, 64, "unknown letter 'x'")]),
        (b"x" * 64 + b"\r", [(0, 64, "unknown letter 'x'"), (64, 1, "unknown letter 'x'")]),
        (
            b"x\r\n\nx\rx\r",
            [(0, 2, "unknown letter 'x'"), (3, 3, "unknown letter 0A"), (6, 2, "unknown letter 'x'")],
        ),
    ],
)
def test_a_wrong_line_is_dropped_up_to_its_ret(data: bytes, wrong: list[tuple[Any, ...]]) -> None:
    capture = decode_commands(data)
    assert errors(capture) == wrong
    assert capture.items() == CommandDecoder().receive_data(data)
    assert len(capture.errors.reasons) == len({text for *_, text in wrong})


def test_lines_go_on_after_a_wrong_one() -> None:
    capture = decode_commands(b"PU\rFPU\rPU\r\nPU\rPU\r")
    assert found(capture) == {Forward: ([3], [0x5055]), PenUp: ([0, 7, 11, 14],)}
    capture = decode_commands(b"PU\rxPU\rPU\r?" + b"F12\r" * 9 + b"PU\r")
    assert found(capture) == {PenUp: ([0, 7, 47],), Forward: ([15, 19, 23, 27, 31, 35, 39, 43], [0x3132] * 8)}
    assert errors(capture) == [(3, 4, "unknown letter 'x'"), (10, 5, "unknown letter '?'")]


def test_modes_change_in_the_stream() -> None:
    capture = decode_commands(b"2\r\nAG1b\r\r\n\n1PU\r2\r 1" + ATTENTION + EMERGENCY_STOP)
    assert found(capture) == {
        SelectDirect: ([0, 15, 25, 36],),
        StartForward: ([3],),
        SetMoveSpeed: ([4], [0x31]),
        SetTurnSpeed: ([6], [13]),
        EmptyLine: ([8, 29],),
        SelectLogo: ([11, 18, 28],),
        PenUp: ([12],),
        Stop: ([17, 27, 38],),
    }
    assert errors(capture) == [
        (10, 1, "no key 0A"),
        (19, 6, "unknown letter 00"),
        (30, 6, "unknown letter 00"),
    ]
    assert capture.mode is Mode.DIRECT


def test_keys_that_take_a_byte_take_each_other() -> None:
    assert found(decode_commands(b"gGGg1", Mode.DIRECT)) == {
        SetMoveSpeed: ([0, 2], [0x47, 0x67]),
        SelectLogo: ([4],),
    }
    capture = decode_commands(b"GbB1 G", Mode.DIRECT)
    assert found(capture) == {SetMoveSpeed: ([0], [0x62]), SetTurnSpeed: ([2], [0x31]), Stop: ([4],)}
    assert capture.mode is Mode.DIRECT


def test_the_byte_that_a_key_takes_may_look_like_a_change_of_mode() -> None:
    assert found(decode_commands(b"G11PU\r", Mode.DIRECT)) == {
        SetMoveSpeed: ([0], [0x31]),
        SelectLogo: ([2],),
        PenUp: ([3],),
    }


def test_the_first_key_may_change_the_mode() -> None:
    assert found(decode_commands(b"1PU\r", Mode.DIRECT)) == {SelectLogo: ([0],), PenUp: ([1],)}


def test_a_run_of_such_keys_ends_with_its_part() -> None:
    """The B before the change of mode is an argument in Logo control, and no key."""
    capture = decode_commands(b"V2\r2\r1F\x00B\r2\r1PU\r")
    assert found(capture) == {
        SetSpeed: ([0], [0x32]),
        SelectDirect: ([3, 10],),
        SelectLogo: ([5, 12],),
        Forward: ([6], [0x42]),
        PenUp: ([13],),
    }


def test_a_group_that_is_missing_is_unknown() -> None:
    capture = decode_commands(b"QH\rE1\r", groups=frozenset("Q"))
    assert found(capture) == {QueryHeading: ([0],)}
    assert errors(capture) == [(3, 3, "unknown letter 'E'")]
    assert EmptyLine in capture.types
    assert not any(getattr(message_type, "GROUP", "") in {"C", "H", "E"} for message_type in capture.types)


def test_replies_become_columns() -> None:
    capture = decode_replies(b"QH\x01\x67\rLF\r\nqp\x01\rQP0\rQP1\rQP\x00\r\r")
    assert found(capture) == {
        HeadingReply: ([0], [359]),
        LimitFront: ([5],),
        PenReply: ([9, 13, 17, 21], [1, 0, 1, 0]),
        EmptyLine: ([25],),
    }
    assert set(capture.types) == {*ROBOT_MESSAGES, EmptyLine}
    assert errors(capture) == []


def test_a_reply_with_a_value_that_is_none_is_dropped() -> None:
    capture = decode_replies(b"QH\x01\x68\rQP2\rQP/\rQP\x02\rQH\x00\x00\r2\r")
    assert found(capture) == {HeadingReply: ([17], [0])}
    assert errors(capture) == [
        (0, 5, "heading_reply: value out of range"),
        (5, 4, "pen_reply: value out of range"),
        (9, 4, "pen_reply: value out of range"),
        (13, 4, "pen_reply: value out of range"),
        (22, 2, "unknown letter '2'"),
    ]
    assert len(capture.errors.reasons) == 3


def test_the_items_are_the_streaming_decoders() -> None:
    assert decode_commands(b"V\x07\r\n2\rG\x08?").items() == [
        Decoded(0, b"V\x07\r", SetSpeed(7)),
        Decoded(4, b"2\r", SelectDirect()),
        Decoded(6, b"G\x08", SetMoveSpeed(8)),
        Malformed(8, b"?", "no key 3F"),
    ]
    assert decode_replies(b"QP1\rx\r").items() == [
        Decoded(0, b"QP1\r", PenReply(1)),
        Malformed(4, b"x\r", "unknown letter 'x'"),
    ]


def stream(chance: random.Random, types: tuple[type[WalterMessage], ...], count: int) -> bytes:
    data = b""
    for message_type in chance.choices(types, k=count):
        values = [chance.randint(field.low, field.high) for field in message_type.FIELDS]
        data += encode(message_type(*values)) + chance.choice((b"", b"", b"\n"))
    return bytes(chance.randrange(256) if chance.random() < 0.005 else byte for byte in data)


@pytest.mark.parametrize("block", [1, 7, 64, 1 << 17])
def test_long_and_noisy_captures_in_blocks_of_any_size(block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bulk_lines, "BLOCK", block)
    chance = random.Random(block)
    count = min(block * 300, 1500)
    for types in (LOGO_COMMANDS, (*LOGO_COMMANDS, *DIRECT_KEYS)):
        data = stream(chance, types, count)
        assert decode_commands(data).items() == CommandDecoder().receive_data(data)
    data = stream(chance, ROBOT_MESSAGES, count)
    assert decode_replies(data).items() == ReplyDecoder().receive_data(data)


def test_a_block_may_end_within_the_first_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bulk_lines, "BLOCK", 2)
    assert found(decode_commands(b"F\r\r\rPU\r")) == {Forward: ([0], [0x0D0D]), PenUp: ([4],)}
