"""SimpleCar on the emulated Uno: its pins, its answers, its patience and its stack (S1..S10)."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tools.firmware import budgets
from turtlewire.errors import NoReplyError, PoseUncertainError
from turtlewire.links.memory import MemoryLink
from turtlewire.protocols.simple.messages import BAUD, MAX_WINDOW
from turtlewire.protocols.simple.robot import Robot
from turtlewire.robots.car import AsyncCar, Settings

from .chip import Chip

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from turtlewire.firmware import Built

VECTORS = Path(__file__).parents[2] / "spec" / "vectors" / "simple"
DRIVE_PWM, DRIVE_DIRECTION, STEER_PWM, STEER_DIRECTION = 5, 7, 6, 8
HEADLIGHTS = (9, 10, 11, 12)
BOOTED_S = 0.12
# Of timer 0: 64 * 256 cycles each, of which a value of n is high for n + 1 256ths.
TEN_PERIODS_S = 10 * 64 * 256 / 16e6


@pytest.fixture
def chip(built: Callable[[str], Built]) -> Iterator[Chip]:
    with Chip(built("SimpleCar").elf, BAUD) as chip:
        chip.run(BOOTED_S)
        yield chip


def state(chip: Chip) -> dict[str, object]:
    """What the pins do, as the vectors tell it."""
    values = []
    for pwm, direction in ((DRIVE_PWM, DRIVE_DIRECTION), (STEER_PWM, STEER_DIRECTION)):
        value = max(0, round(chip.duty(pwm, TEN_PERIODS_S) * 256.0) - 1)
        values.append(value if chip.level(direction) else -value)
    lights = "".join(str(chip.level(pin)) for pin in HEADLIGHTS)
    return {"drive": values[0], "steer": values[1], "lights": lights}


def vectors() -> list[dict[str, Any]]:
    found = [
        v
        for path in sorted(VECTORS.glob("*.json"))
        for v in json.loads(path.read_text("utf-8")).get("vectors", [])
    ]
    return [v for v in found if v["direction"] == "to robot" and not v.get("extensions")]


@pytest.mark.parametrize("vector", vectors(), ids=lambda vector: vector["id"])
def test_the_vectors_are_answered_and_carried_out(chip: Chip, vector: dict[str, Any]) -> None:
    data, replies = bytes.fromhex(vector["bytes"]), bytes.fromhex(vector["replies"])
    chip.receive(data)
    assert chip.reply(len(replies), len(data) / 900 + 0.1) == replies
    chip.run(0.02)
    assert [sent.byte for sent in chip.sent()] == []
    assert state(chip) == vector["state"]


def test_it_shows_at_power_on_that_it_lives_and_stands_still(built: Callable[[str], Built]) -> None:
    with Chip(built("SimpleCar").elf, BAUD) as chip:
        chip.run(0.05)
        assert state(chip) == {"drive": 0, "steer": 0, "lights": "1111"}
        chip.run(0.3)
        assert state(chip) == {"drive": 0, "steer": 0, "lights": "0000"}
        assert chip.rate == pytest.approx(BAUD, rel=0.005)


@pytest.mark.parametrize("command", [b"F200000", b"B200000", b"L200000", b"R200000", b"S000000", b"H110000"])
def test_from_any_byte_on_the_host_gets_back_in_step(chip: Chip, command: bytes) -> None:
    """S7: after at most seven S there is an answer, and the stop that follows is answered K; everything stands."""
    for pending in range(7):
        chip.receive(command[:pending])
        chip.run(0.02)
        assert chip.sent() == []
        spent = 0
        while not (reply := chip.reply(0, 0.0) or _after_one_s(chip)):
            spent += 1
            assert spent < 7
        assert reply in (b"K", b"F")
        chip.receive(b"S000000")
        assert chip.reply() == b"K"
        found = state(chip)
        assert (found["drive"], found["steer"]) == (0, 0)


def _after_one_s(chip: Chip) -> bytes:
    chip.receive(b"S")
    return chip.reply(1, 0.02)


def test_the_longest_window_is_answered_in_full(chip: Chip) -> None:
    """S9: two hundred commands, eight at a time, and none lost; then a stop on top of a full window."""
    for number in range(25):
        chip.receive(b"".join(b"F%03d000" % (8 * number + n) for n in range(MAX_WINDOW)))
        assert chip.reply(MAX_WINDOW) == b"K" * MAX_WINDOW
    chip.receive(b"F255000" * MAX_WINDOW + b"S000000")
    assert chip.reply(MAX_WINDOW + 1) == b"K" * (MAX_WINDOW + 1)
    assert state(chip) == {"drive": 0, "steer": 0, "lights": "0000"}
    assert chip.overruns == 0


def test_an_answer_comes_at_once(chip: Chip) -> None:
    """The firmware's own share of a round trip, between the last byte's stop bit and the answer's start bit."""
    chip.receive(b"F100000", after_s=0.001)
    start_s = chip.now_s
    byte_s = 10.0 / BAUD
    chip.run(0.001 + 7 * byte_s + 2 * byte_s)
    (answer,) = chip.sent()
    share_s = (answer.time_s - 10.0 / chip.rate) - (start_s + 0.001 + 7 * byte_s)
    assert 0.0 < share_s < 60e-6


def test_its_stack(built: Callable[[str], Built], chip: Chip) -> None:
    program = built("SimpleCar")
    chip.receive(b"H101000F128000X")
    chip.run(0.1)
    assert 2048 - program.ram_bytes - chip.untouched_bytes <= budgets()["SimpleCar"].stack


STREAMS = st.lists(
    st.builds(
        lambda letter, digits: letter + digits,
        st.sampled_from([b"F", b"B", b"L", b"R", b"S", b"H", b"x"]),
        st.sampled_from([b"000000", b"255999", b"256000", b"12a000", b"1101--", b"9"]),
    )
    | st.binary(max_size=8),
    max_size=12,
).map(b"".join)


def check_like_python(chip: Chip, data: bytes) -> None:
    robot = Robot()
    replies = robot.receive_data(data).replies
    chip.receive(data)
    assert chip.reply(len(replies), len(data) / 900 + 0.1) == replies
    chip.run(0.01)
    lights = "".join(str(int(light)) for light in robot.lights)
    assert state(chip) == {"drive": robot.drive, "steer": robot.steer, "lights": lights}


@given(STREAMS)
@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_bytes_lead_to_what_python_says(built: Callable[[str], Built], data: bytes) -> None:
    with Chip(built("SimpleCar").elf, BAUD) as chip:
        chip.run(BOOTED_S)
        check_like_python(chip, data)


@pytest.mark.nightly
@given(STREAMS)
@settings(max_examples=10_000, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_ten_thousand_streams_lead_to_what_python_says(built: Callable[[str], Built], data: bytes) -> None:
    with Chip(built("SimpleCar").elf, BAUD) as chip:
        chip.run(BOOTED_S)
        check_like_python(chip, data)


def test_the_driver_drives_it(chip: Chip) -> None:
    """The same driver as ever, in the chip's own time: 100 mm ahead are so much time at so much PWM."""

    async def main() -> None:
        car = AsyncCar(MemoryLink(chip), Settings(speed=255))
        await car.connect()
        begun_s = chip.now
        await car.forward(200.0)
        assert state(chip) == {"drive": 0, "steer": 0, "lights": "0000"}
        driven_s = [edge.time_s for edge in chip.edges(DRIVE_PWM) if edge.time_s > begun_s]
        speed = 200.0 / (driven_s[-1] - driven_s[0])
        assert speed == pytest.approx(Settings().calibration.curve(1.0).speed_mm_per_s(255), rel=0.1)
        await car.close()

    asyncio.run(main())


def test_a_reset_midway_leaves_it_standing_and_the_driver_knows(chip: Chip) -> None:
    """Unplugged and plugged in again while it drives: it boots, stands, and is reached again, stopped."""

    async def main() -> None:
        car = AsyncCar(MemoryLink(chip), Settings())
        await car.connect()
        await car.motor(200)
        assert state(chip) == {"drive": 200, "steer": 0, "lights": "0000"}
        chip.reset()
        chip.receive(b"F2")  # what was on its way is heard by halves
        chip.run(BOOTED_S)
        assert state(chip)["drive"] == 0
        with pytest.raises((NoReplyError, PoseUncertainError)):
            await car.forward(50.0)
        assert state(chip)["drive"] == 0
        await car.motor(100)
        assert state(chip) == {"drive": 100, "steer": 0, "lights": "0000"}
        await car.close()
        assert state(chip)["drive"] == 0

    asyncio.run(main())
