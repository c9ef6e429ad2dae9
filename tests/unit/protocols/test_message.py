from __future__ import annotations

from typing import Any

import pytest

from turtlewire.errors import MessageError
from turtlewire.protocols.message import KINDS, parse
from turtlewire.protocols.walter.messages import (
    MESSAGES,
    EmptyLine,
    Forward,
    GoTo,
    GoToX,
    HeadingReply,
    LogoCommand,
    PenReply,
    SetSpeed,
    Stop,
    XReply,
)


@pytest.mark.parametrize(
    ("message", "text"),
    [
        (Forward(200), "forward distance_half_mm=200"),
        (GoTo(-1, 32767), "go_to x_half_mm=-1 y_half_mm=32767"),
        (GoToX(0), "go_to_x x_half_mm=0"),
        (XReply(-5), "x_reply x_half_mm=-5"),
        (Stop(), "stop"),
        (EmptyLine(), "empty_line"),
    ],
)
def test_text_form(message: LogoCommand, text: str) -> None:
    assert str(message) == text
    assert parse(text, MESSAGES) == message


def test_a_truth_value_is_written_as_the_bit_it_is() -> None:
    assert str(PenReply(down=True)) == "pen_reply down=1"
    assert parse(str(PenReply(down=False)), MESSAGES) == PenReply(0)


def test_names_are_unique_and_read_as_words() -> None:
    names = [message.name() for message in MESSAGES]
    assert len(set(names)) == len(MESSAGES) == 50
    assert {"set_speed", "go_to_x", "x_reply", "y_reply", "query_towards"} <= set(names)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("forward 200", Forward(200)),
        ("FORWARD Distance_Half_MM=200", Forward(200)),
        ("  go_to   1\t-2  ", GoTo(1, -2)),
        ("go_to y_half_mm=-2 x_half_mm=1", GoTo(1, -2)),
        ("go_to y_half_mm=-2 1", GoTo(1, -2)),
        ("set_speed 0xFF", SetSpeed(255)),
    ],
)
def test_parse_takes_fields_by_name_and_by_place(text: str, message: LogoCommand) -> None:
    assert parse(text, MESSAGES) == message


ONLY = (Forward, Stop, GoTo)


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("", "there is no message in an empty text; known are forward, stop, go_to"),
        (" \t ", "there is no message in an empty text; known are forward, stop, go_to"),
        ("fly 3", "there is no message 'fly'; known are forward, stop, go_to"),
        ("forward", "'forward' lacks distance_half_mm"),
        ("go_to", "'go_to' lacks x_half_mm and y_half_mm"),
        ("go_to y_half_mm=1", "'go_to y_half_mm=1' lacks x_half_mm"),
        ("forward 1 2", "'forward 1 2': '2' fits no field; forward has distance_half_mm"),
        ("forward speed=1", "'forward speed=1': 'speed=1' fits no field; forward has distance_half_mm"),
        ("forward =1", "'forward =1': '=1' fits no field; forward has distance_half_mm"),
        ("go_to 1 x_half_mm=1", "'x_half_mm=1' fits no field; go_to has x_half_mm y_half_mm"),
        ("stop 1", "'stop 1': '1' fits no field; stop has no fields"),
        ("forward far", "'forward far': 'far' is not a whole number"),
        ("forward 1.5", "'forward 1.5': '1.5' is not a whole number"),
        ("forward distance_half_mm=", "'' is not a whole number"),
        (
            "forward 65536",
            "forward: distance_half_mm is 65536, but must be a whole number from 0 to 65535 (half millimetres)",
        ),
        ("forward -1", "distance_half_mm is -1, but must be a whole number from 0 to 65535"),
        ("go_to 0 32768", "y_half_mm is 32768, but must be a whole number from -32768 to 32767"),
    ],
)
def test_parse_says_what_is_wrong(text: str, error: str) -> None:
    with pytest.raises(MessageError) as caught:
        parse(text, ONLY)
    assert error in str(caught.value)


@pytest.mark.parametrize("message_type", [m for m in MESSAGES if m.FIELDS], ids=lambda m: m.name())
def test_check_takes_both_ends_of_a_range_and_nothing_beyond(message_type: Any) -> None:
    for n, field in enumerate(message_type.FIELDS):
        for value, fits in (
            (field.low, True),
            (field.high, True),
            (field.low - 1, False),
            (field.high + 1, False),
        ):
            values = [0] * len(message_type.FIELDS)
            values[n] = value
            message = message_type(*values)
            if fits:
                assert message.check() is message
            else:
                with pytest.raises(MessageError, match=f"{field.name} is {value}, but must be"):
                    message.check()


def test_every_range_fits_its_kind() -> None:
    for message_type in MESSAGES:
        for field in message_type.FIELDS:
            size, signed = KINDS[field.kind]
            assert field.low == (-(1 << (8 * size - 1)) if signed else 0)
            assert 0 < field.high < 1 << (8 * size - signed)


@pytest.mark.parametrize("value", [1.0, "1", None, 1.5])
def test_check_takes_integers_only(value: Any) -> None:
    with pytest.raises(MessageError, match="must be a whole number from 0 to 65535"):
        Forward(value).check()


def test_messages_are_values() -> None:
    assert Forward(1) == Forward(1)
    assert Forward(1) != Forward(2)
    assert len({Forward(1), Forward(1), SetSpeed(1)}) == 2
    assert HeadingReply(90).values() == (90,)
    with pytest.raises(AttributeError):
        Forward(1).distance_half_mm = 2  # type: ignore[misc]
