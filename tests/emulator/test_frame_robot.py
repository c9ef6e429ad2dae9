"""FrameRobot on the emulated Uno: engines, servos, telemetry, and a stop that is heard (F1..F13)."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tools.firmware import budgets
from turtlewire.protocols.frame.codec import Frame, FrameDecoder, FrameEncoder, frame_bytes
from turtlewire.protocols.frame.dialect import FROM_ROBOT, load
from turtlewire.protocols.frame.host import stop_bytes

from .chip import Chip

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from turtlewire.firmware import Built

SKETCH = Path(__file__).parents[2] / "firmware" / "Turtlewire" / "examples" / "FrameRobot"
DIALECT = load(SKETCH / "dialect.toml")
PWM, DIRECTION, BUMPER = (5, 6), (7, 8), 4
TCCR1A, ICR1, OCR1 = 0x80, 0x86, (0x88, 0x8A)  # registers of timer 1
TEN_PERIODS_S = 10 * 64 * 256 / 16e6


@pytest.fixture
def chip(built: Callable[[str], Built]) -> Iterator[Chip]:
    with Chip(built("FrameRobot").elf, DIALECT.baud) as chip:
        chip.press(BUMPER, 1)
        chip.run(0.05)
        yield chip


def engines(chip: Chip) -> list[int]:
    found = []
    for pwm, direction in zip(PWM, DIRECTION, strict=True):
        value = max(0, round(chip.duty(pwm, TEN_PERIODS_S) * 256.0) - 1)
        found.append(value if chip.level(direction) else -value)
    return found


def send(chip: Chip, *texts: str) -> None:
    (data,) = FrameEncoder(DIALECT).encode([DIALECT.parse(text) for text in texts])
    chip.receive(data)
    chip.run(len(data) * 10 / DIALECT.baud + 0.002)


def test_engines_and_servos_in_one_frame(chip: Chip) -> None:
    assert engines(chip) == [0, 0]
    send(chip, "engine_forward engine_id=0 speed=200", "engine_backward engine_id=1 speed=17")
    assert engines(chip) == [200, -17]
    send(
        chip, "set_servo_position servo_id=0 position_deg=0", "set_servo_position servo_id=1 position_deg=180"
    )
    assert [servo_us(chip, register) for register in OCR1] == [500, 2500]
    send(chip, "set_servo_position servo_id=0 position_deg=90")
    assert [servo_us(chip, register) for register in OCR1] == [1500, 2500]


def servo_us(chip: Chip, register: int) -> int:
    """The width of a servo's pulses, which timer 1 makes in hardware: this emulator does not show them at the pins.

    Fast PWM up to ICR1, both outputs set at the bottom and cleared at the match; a tick is half a microsecond.
    """
    assert (chip.peek(TCCR1A), chip.peek(TCCR1A + 1) & 0x1F) == (0xA2, 0x1A)
    assert chip.peek(ICR1) + 256 * chip.peek(ICR1 + 1) + 1 == 20_000 * 2
    return (chip.peek(register) + 256 * chip.peek(register + 1) + 1) // 2


def test_a_frame_counts_whole_or_not_at_all(chip: Chip) -> None:
    """F3: an unknown type, a message cut short and a wrong CRC move nothing; F4: a message out of range only itself."""
    right = bytes.fromhex("01 00 C8")
    for payload in (right + b"\x77", right + b"\x01\x01"):
        chip.receive(frame_bytes(DIALECT, 0, payload))
    chip.receive(frame_bytes(DIALECT, 0, right)[:-1] + b"\x00")
    chip.run(0.01)
    assert engines(chip) == [0, 0]
    chip.receive(frame_bytes(DIALECT, 1, bytes.fromhex("01 02 FF 01 01 32")))
    chip.run(0.01)
    assert engines(chip) == [0, 50]


def test_a_stop_is_heard_from_within_any_frame(chip: Chip) -> None:
    """F13: left in the middle of the longest frame, the robot hears the stop that is repeated."""
    send(chip, "engine_forward engine_id=0 speed=200", "engine_forward engine_id=1 speed=200")
    for begun in (1, 3, 60, 127):
        longest = frame_bytes(DIALECT, 9, bytes.fromhex("01 00 FF") * 41)
        chip.receive(longest[:begun] + stop_bytes(FrameEncoder(DIALECT)))
        chip.run(0.05)
        assert engines(chip) == [0, 0]
        send(chip, "engine_forward engine_id=0 speed=200")
        assert engines(chip) == [200, 0]


def test_what_was_begun_is_given_up(chip: Chip) -> None:
    """F5: after a pause, or behind a false magic, the next frame counts."""
    chip.receive(b"\xa3\x00\x20\xa3")
    chip.run(0.12)
    send(chip, "engine_forward engine_id=1 speed=3")
    assert engines(chip) == [0, 3]


def test_it_tells_how_it_is(chip: Chip) -> None:
    chip.voltage(0, 2.5)  # a third of the battery's
    chip.run(0.3)
    chip.press(BUMPER, 0)
    chip.run(0.3)
    decoder = FrameDecoder(DIALECT, FROM_ROBOT)
    items = decoder.receive_data(bytes(sent.byte for sent in chip.sent()))
    assert all(isinstance(item, Frame) for item in items)
    told = [
        dict(zip(("time_ms", "battery_v", "bumper"), message.values(), strict=True))
        for item in items
        if isinstance(item, Frame)
        for message in item.messages
    ]
    assert len(told) >= 5
    times = [each["time_ms"] for each in told]
    assert all(99 <= b - a <= 101 for a, b in pairwise(times))
    assert (told[0]["bumper"], told[-1]["bumper"]) == (False, True)
    assert told[-1]["battery_v"] == pytest.approx(7.5, abs=0.02)
    assert decoder.statistics.lost == 0


def test_full_frames_back_to_back_are_all_taken(chip: Chip) -> None:
    """Eight frames of 41 messages each at full rate: none is lost, whatever the robot has to do."""
    encoder = FrameEncoder(DIALECT)
    for speed in range(8):
        chip.receive(encoder.frame(bytes([1, 0, speed]) * 41))
    send(chip, "engine_backward engine_id=1 speed=99")
    chip.run(0.1)
    assert chip.overruns == 0
    assert engines(chip) == [7, -99]


def test_its_stack(built: Callable[[str], Built], chip: Chip) -> None:
    program = built("FrameRobot")
    send(chip, "engine_forward engine_id=0 speed=200")
    chip.run(0.2)
    assert 2048 - program.ram_bytes - chip.untouched_bytes <= budgets()["FrameRobot"].stack
