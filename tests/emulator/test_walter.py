"""Walter on the emulated Uno: step pulses, servo pulses, switches, answers; the driver drawing with it (W1..W16)."""

from __future__ import annotations

import asyncio
import math
from typing import TYPE_CHECKING

import pytest

from tools.firmware import budgets
from turtlewire.links.memory import MemoryLink
from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import encode
from turtlewire.robots.walter import AsyncWalter, Settings

from .chip import Chip
from .turtle import SERVO, STEPS_PER_MM, TRACK_MM, pose, steps

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from turtlewire.firmware import Built

LAMP = 13
SWITCHES = {"front": 14, "back": 15, "left": 16, "right": 17}
BOOTED_S = 0.12


@pytest.fixture
def chip(built: Callable[[str], Built]) -> Iterator[Chip]:
    with Chip(built("Walter").elf, m.BAUD) as chip:
        for pin in SWITCHES.values():
            chip.press(pin, 1)
        chip.run(BOOTED_S)
        chip.receive(encode(m.SetSpeed(200)))
        chip.run(0.01)
        yield chip


def ask(chip: Chip, query: m.LogoCommand, within_s: float = 5.0) -> bytes:
    chip.receive(encode(query))
    reply = b""
    while not reply.endswith(b"\r") or len(reply) < 4:
        more = chip.reply(1, within_s)
        assert more, reply
        reply += more
    return reply


@pytest.mark.parametrize(
    ("command", "count", "left", "right"),
    [
        (m.Forward(100), 800, 1, 1),
        (m.Back(31), 248, -1, -1),
        (m.Right(90), round(math.pi * 140 / 4 * 16), 1, -1),
        (m.Left(45), round(math.pi * 140 / 8 * 16), -1, 1),
    ],
)
def test_a_motion_is_so_many_steps_at_so_many_a_second(
    chip: Chip, command: m.LogoCommand, count: int, left: int, right: int
) -> None:
    chip.receive(encode(command))
    ask(chip, m.QueryHeading())  # W9: answered when the motion is done
    made = steps(chip)
    assert {step[1:] for step in made} == {(left, right)}
    assert len(made) == pytest.approx(count, abs=1)
    speed = 200.0 if left == right else math.radians(200.0) * TRACK_MM / 2.0
    seconds = made[-1].time_s - made[0].time_s
    assert (len(made) - 1) / seconds == pytest.approx(speed * STEPS_PER_MM, rel=0.01)


def test_absolute_moves_and_what_it_says_of_itself(chip: Chip) -> None:
    chip.receive(encode(m.TurnTo(90)) + encode(m.GoTo(60, 80)))
    assert ask(chip, m.QueryLocation()) == encode(m.LocationReply(60, 80))
    assert ask(chip, m.QueryHeading()) == encode(m.HeadingReply(90))
    assert ask(chip, m.QueryTowards(60, 180)) == encode(m.TowardsReply(0))
    assert pose(chip) == pytest.approx((30.0, 40.0, 90.0), abs=0.2)
    chip.receive(encode(m.GoToX(-20)) + encode(m.GoToY(0)))
    assert ask(chip, m.QueryX()) == encode(m.XReply(-20))
    assert ask(chip, m.QueryY()) == encode(m.YReply(0))
    chip.receive(encode(m.ResetLocation()) + encode(m.Forward(20)) + encode(m.GoHome()))
    assert ask(chip, m.QueryLocation()) == encode(m.LocationReply(0, 0))
    assert pose(chip) == pytest.approx((-10.0, 0.0, 270.0), abs=0.3)


def test_pen_and_lamp(chip: Chip) -> None:
    def pulse_us() -> int:
        chip.run(0.05)
        (up, down) = [edge for edge in chip.edges(SERVO) if edge.time_s > chip.now - 0.05 and edge.level][
            :1
        ] + [edge for edge in chip.edges(SERVO) if edge.time_s > chip.now - 0.05 and not edge.level][-1:]
        highs = [e.time_s for e in chip.edges(SERVO) if e.level and e.time_s < down.time_s]
        assert highs[-1] - highs[-2] == pytest.approx(0.02, abs=1e-5)
        assert up.level
        return round((down.time_s - highs[-1]) * 1e6)

    assert abs(pulse_us() - 1000) < 20
    assert ask(chip, m.QueryPen()) == encode(m.PenReply(0))
    chip.receive(encode(m.PenDown()))
    begun_s = chip.now
    assert ask(chip, m.QueryPen()) == encode(m.PenReply(1))
    assert chip.now - begun_s > 0.1  # the servo takes its time, and what follows waits
    assert abs(pulse_us() - 1600) < 20
    chip.receive(encode(m.LampOn()))
    chip.run(0.02)
    assert chip.level(LAMP) == 1
    chip.receive(encode(m.LampOff()))
    chip.run(0.02)
    assert chip.level(LAMP) == 0


COMMANDS = [
    encode(t(*([3] * len(t.FIELDS)))) for t in m.LOGO_COMMANDS if t not in (m.EmptyLine, m.SelectDirect)
]


def test_attention_from_within_any_command(chip: Chip) -> None:
    """W7: after it the robot stands, in Logo control, with nothing queued, and answers."""
    for command in COMMANDS:
        for cut in range(len(command)):
            chip.receive(encode(m.Forward(2000)) + command[:cut] + m.ATTENTION)
            chip.run(0.04)
            made = len(steps(chip))
            assert ask(chip, m.QueryPen()) == encode(m.PenReply(0)), (command, cut)
            assert len(steps(chip)) == made, (command, cut)


def test_a_stop_acts_when_it_arrives(chip: Chip) -> None:
    """W8: whatever is queued, not a step more than a millisecond after its last byte; and it stays so."""
    chip.receive(encode(m.Forward(60000)) + encode(m.Right(90)) * 4)
    chip.run(0.1)
    chip.receive(m.EMERGENCY_STOP)
    chip.run(len(m.EMERGENCY_STOP) * 10 / m.BAUD + 0.001)
    made = len(steps(chip))
    assert made > 0
    chip.run(0.3)
    assert len(steps(chip)) == made
    chip.receive(b"1\r")
    assert ask(chip, m.QueryHeading()) == encode(m.HeadingReply(0))


def test_direct_control(chip: Chip) -> None:
    chip.receive(b"2\rG\x64A")
    chip.run(0.3)
    made = steps(chip)
    assert {step[1:] for step in made} == {(1, 1)}
    rate = len(made) / (made[-1].time_s - made[0].time_s)
    assert rate == pytest.approx(100 * STEPS_PER_MM, rel=0.02)
    chip.receive(b"d" * 20)  # faster, on the way
    chip.run(0.2)
    after = [step for step in steps(chip) if step.time_s > chip.now - 0.1]
    assert len(after) == pytest.approx(120 * STEPS_PER_MM * 0.1, rel=0.03)
    chip.receive(b" ")
    chip.run(0.005)
    made = steps(chip)
    chip.receive(b".")
    chip.run(0.1)
    assert {step[1:] for step in steps(chip)[len(made) :]} == {(1, -1)}
    chip.receive(b"1")
    chip.run(0.005)
    made = steps(chip)
    chip.run(0.1)
    assert len(steps(chip)) == len(made)


def test_a_limit_switch_ends_the_motion_and_the_queue(chip: Chip) -> None:
    """W13: an event, no step more, nothing queued; not towards it again, but away."""
    chip.receive(encode(m.Forward(2000)) + encode(m.Right(90)))
    chip.run(0.2)
    chip.press(SWITCHES["front"], 0)
    assert chip.reply(3) == encode(m.LimitFront())
    made = len(steps(chip))
    chip.run(0.2)
    assert len(steps(chip)) == made
    chip.receive(encode(m.Forward(10)))
    assert chip.reply(3) == encode(m.LimitFront())
    assert len(steps(chip)) == made
    chip.receive(encode(m.Back(10)))
    ask(chip, m.QueryPen())
    assert len(steps(chip)) == made + 80


def test_what_may_be_sent_ahead_fits(chip: Chip) -> None:
    """W9: 48 bytes of the shortest commands, at once, while it moves."""
    chip.receive(encode(m.Forward(400)))
    chip.run(0.02)
    chip.receive(encode(m.LampOn()) * 16)
    chip.run(1.5)
    assert chip.overruns == 0
    assert ask(chip, m.QueryY()) == encode(m.YReply(400))
    assert chip.level(LAMP) == 1


def test_its_stack(built: Callable[[str], Built], chip: Chip) -> None:
    program = built("Walter")
    chip.receive(encode(m.GoTo(20, 30)) + encode(m.HornHigh()))
    ask(chip, m.QueryLocation())
    assert 2048 - program.ram_bytes - chip.untouched_bytes <= budgets()["Walter"].stack


def test_the_driver_draws_with_it(chip: Chip) -> None:
    """The same driver as ever, in the chip's own time: the square that the steps have made closes."""

    async def main() -> None:
        robot = AsyncWalter(MemoryLink(chip), Settings(speed=200))
        await robot.connect()
        assert robot.groups >= {"Q", "C"}
        for _ in range(4):
            await robot.forward(40.0)
            await robot.right(90.0)
        await robot.finish()
        assert await robot.reported_pose() == pytest.approx((0.0, 0.0, 0.0), abs=0.51)
        await robot.close()

    asyncio.run(main())
    made = steps(chip)
    assert len(made) == pytest.approx(4 * (640 + math.pi * 140 / 4 * 16), abs=8)
    x_mm, y_mm, heading_deg = pose(chip)
    assert math.hypot(x_mm, y_mm) < 0.3
    assert min(heading_deg, 360.0 - heading_deg) < 0.3


def test_without_a_single_answer_it_is_drawn_with_too(built: Callable[[str], Built]) -> None:
    """WalterBasic (W10): the host goes by the time that motions take."""

    async def main(chip: Chip) -> None:
        robot = AsyncWalter(MemoryLink(chip), Settings(speed=200))
        await robot.connect()
        assert not robot.groups
        for _ in range(4):
            await robot.forward(20.0)
            await robot.right(90.0)
        await robot.finish()
        await robot.close()

    program = built("WalterBasic")
    with Chip(program.elf, m.BAUD) as chip:
        asyncio.run(main(chip))
        assert 2048 - program.ram_bytes - chip.untouched_bytes <= budgets()["WalterBasic"].stack
        assert len(steps(chip)) == pytest.approx(4 * (320 + math.pi * 140 / 4 * 16), abs=8)
        x_mm, y_mm, heading_deg = pose(chip)
        assert math.hypot(x_mm, y_mm) < 0.3
        assert min(heading_deg, 360.0 - heading_deg) < 0.3
