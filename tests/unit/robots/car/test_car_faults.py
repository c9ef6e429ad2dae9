"""A car over a wire that loses and damages bytes: what is sent again, and what is an error (decisions S8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.unit.robots.car.wires import Damage, mute, pass_time
from turtlewire.errors import NoReplyError, PoseUncertainError, TurtlewireError
from turtlewire.links.faults import Faults, FaultyLink
from turtlewire.links.memory import MemoryLink
from turtlewire.robots.car import AsyncCar, Car, Settings
from turtlewire.robots.runner import InlineRunner
from turtlewire.simulator.car import SimulatedCar

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.unit.robots.car.conftest import Bench, MakeBench

FORWARD = b"F124000"  # speed 100 of 255
HALT = b"F000000"


def fail(made: Bench, move: Callable[[], object]) -> str:
    """The error of a motion that something happened to. The car stands, and stays where it is."""
    with pytest.raises(PoseUncertainError, match="Nothing was resumed") as caught:
        move()
    stood = made.robot.pose
    pass_time(made.robot, 2.0)
    assert made.robot.pose == stood
    assert (made.robot.drive, made.robot.steer) == (0, 0)
    return str(caught.value)


def between(made: Bench) -> bool:
    """Whether the turtle is believed to be no further off than half of what is uncertain."""
    return made.off_mm <= made.turtle.statistics.distance_mm / 2.0 + 1.0


@pytest.mark.parametrize("becomes", [b"", FORWARD[:6], b"?" + FORWARD[1:]], ids=["lost", "cut", "flipped"])
def test_s8_a_motion_whose_beginning_is_lost(bench: MakeBench, becomes: bytes) -> None:
    made = bench()
    made.wire.to_robot = Damage(FORWARD, {0: becomes})
    text = fail(made, lambda: made.turtle.forward(200))
    assert made.wire.bytes_sent.count(FORWARD) == 1
    assert "between x 0 mm, y 0 mm" in text
    assert made.robot.pose.y_mm < 10.0  # the way back into step may complete what was cut, and then stops it
    assert between(made)
    stood_mm = made.robot.pose.y_mm
    made.turtle.forward(10)
    assert made.robot.pose.y_mm - stood_mm == pytest.approx(10.0, abs=0.05)


def test_s8_a_motion_whose_reply_is_lost(bench: MakeBench) -> None:
    made = bench()
    made.wire.to_host = Damage(b"K", {0: b""})
    fail(made, lambda: made.turtle.forward(200))
    assert 0.0 < made.robot.pose.y_mm < 200.0
    assert between(made)


@pytest.mark.parametrize("becomes", [b"", HALT[:6], b"?" + HALT[1:]], ids=["lost", "cut", "flipped"])
def test_s8_a_motion_whose_end_is_lost(bench: MakeBench, becomes: bytes) -> None:
    made = bench()
    made.wire.to_robot = Damage(HALT, {0: becomes})
    text = fail(made, lambda: made.turtle.forward(200))
    assert "between x 0 mm, y 200 mm" in text
    assert 200.0 < made.robot.pose.y_mm < 350.0
    assert between(made)


def test_s8_a_motion_whose_last_reply_is_lost(bench: MakeBench) -> None:
    made = bench()
    made.wire.to_host = Damage(b"K", {1: b""})
    text = fail(made, lambda: made.turtle.forward(200))
    assert "between x 0 mm, y 200 mm" in text
    assert made.robot.pose.y_mm == pytest.approx(200.0, abs=0.1)


@pytest.mark.parametrize("command", [b"R255000", b"L255000"])
def test_s8_steering_that_is_lost_while_the_car_stands_is_sent_again(
    bench: MakeBench, command: bytes
) -> None:
    made = bench()
    made.wire.to_robot = damage = Damage(command, {0: b""})
    made.turtle.right(90)
    made.turtle.forward(100)
    assert damage.seen >= 2
    assert made.off_mm < 0.05
    assert made.turtle.statistics.resynchronisations == 2
    assert made.notes == []


def test_s8_a_turn_in_which_something_is_lost_ends_there(bench: MakeBench) -> None:
    made = bench()
    made.wire.to_robot = Damage(b"B124000", {0: b""})
    made.turtle.right(90)
    fail(made, made.turtle.finish)
    heading = made.turtle.pose.heading_deg
    assert made.robot.pose.heading_deg < heading < 90.0
    made.turtle.finish()  # it turns no further by itself
    assert made.turtle.pose.heading_deg == heading


def test_s8_by_hand_what_is_wanted_is_sent_again(bench: MakeBench) -> None:
    made = bench()
    made.turtle.drive(0.5, 0.5)
    assert made.goes_on(0.5)
    made.wire.to_host = Damage(b"K", {0: b"F"})
    made.turtle.drive(0.6, 0.6)
    assert made.goes_on(2.0)
    assert (made.robot.drive, made.robot.steer) == (169, 153)
    assert "was stopped and set going again (a valid command was rejected)" in made.notes[0]


def test_s8_what_no_longer_is_wanted_is_not_sent_again(bench: MakeBench) -> None:
    made = bench()
    made.wire.to_host = Damage(b"K", {0: b"F"})
    made.turtle.drive(0.6, 0.6, valid_s=0.1)
    assert not made.goes_on(2.0)
    assert made.robot.drive == 0


def test_s8_something_lost_while_a_program_takes_over_from_a_hand_is_an_error(bench: MakeBench) -> None:
    made = bench()
    made.turtle.drive(0.6, 0.6)
    assert made.goes_on(0.5)
    made.wire.forget()
    made.wire.to_host = Damage(b"K", {0: b"F"})
    fail(made, lambda: made.turtle.forward(200))
    assert b"F169000" not in made.wire.bytes_sent  # what the hand wanted is not sent again


def test_an_interrupt_while_a_program_takes_over_from_a_hand_stops_the_car(bench: MakeBench) -> None:
    made = bench()
    made.turtle.drive(0.6, 0.6, valid_s=1.0)
    assert made.goes_on(0.5)

    def interrupt(data: bytes) -> bytes:
        if HALT in data:
            raise KeyboardInterrupt
        return data

    made.wire.to_robot = interrupt
    with pytest.raises(KeyboardInterrupt):
        made.turtle.forward(200)
    made.wire.to_robot = bytes
    pass_time(made.robot, 1.0)
    assert made.robot.drive == 0


def test_s8_a_set_point_that_gets_lost_again_and_again_is_given_up(bench: MakeBench) -> None:
    made = bench(retries=2)
    made.wire.to_robot = lambda data: data.replace(b"F169000", b"?169000")
    made.turtle.drive(0.6, 0)
    with pytest.raises(NoReplyError, match=r"drive_forward speed=169 got lost .* drive 0, steering 0"):
        made.goes_on(10.0)
    assert made.robot.drive == 0
    made.turtle.drive(0.5, 0)
    assert made.goes_on(1.0)


def test_silence_while_a_program_drives_is_an_error_that_says_what_is_not_known(bench: MakeBench) -> None:
    made = bench()
    made.wire.at(0.3, lambda: setattr(made.wire, "to_host", mute))
    with pytest.raises(NoReplyError, match="Whether it drives is not known"):
        made.turtle.forward(400)
    pass_time(made.robot, 0.1)
    assert made.robot.drive == 0  # it was told, though it did not answer
    with pytest.raises(NoReplyError):
        made.turtle.forward(10)
    made.wire.to_host = bytes
    made.turtle.forward(10)
    assert made.robot.drive == 0


def test_silence_while_driven_by_hand_is_told_by_the_next_command(bench: MakeBench) -> None:
    made = bench()
    made.turtle.drive(0.5, 0)
    made.wire.to_host = mute
    with pytest.raises(NoReplyError):
        made.goes_on(10.0)
    assert made.robot.drive == 0


@pytest.mark.parametrize("rate", [0.0005, 0.003])
def test_noise_ends_in_the_right_place_or_in_an_error(rate: float) -> None:
    outcomes: list[type[TurtlewireError] | None] = []
    for seed in range(30):
        robot, runner = SimulatedCar(), InlineRunner()
        link = FaultyLink(
            MemoryLink(robot), Faults(lose=rate, add=rate, flip=rate, duplicate=rate, seed=seed)
        )
        driver = AsyncCar(link, Settings())
        try:
            runner.run(driver.connect())
            with Car(driver, runner) as turtle:
                for _ in range(4):
                    turtle.forward(40)
                    turtle.right(90)
                turtle.finish()
            outcomes.append(None)
        except TurtlewireError as error:
            outcomes.append(type(error))
        pass_time(robot, 0.2)
        assert robot.drive == 0  # however it ended
    assert set(outcomes) <= {None, PoseUncertainError, NoReplyError}
    assert None in outcomes
    assert PoseUncertainError in outcomes
