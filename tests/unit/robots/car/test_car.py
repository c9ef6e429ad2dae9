"""A car by its own commands, by hand, and on every way out (decisions S5..S9, section 4)."""

from __future__ import annotations

import asyncio
import gc
from typing import TYPE_CHECKING

import pytest

from tests.unit.robots.car.wires import Damage, mute, pass_time
from turtlewire.drive import Drive
from turtlewire.errors import (
    LinkClosedError,
    LinkLostError,
    MessageError,
    NoReplyError,
    NotSupportedError,
    StoppedError,
    UsageError,
)
from turtlewire.links.faults import Faults, FaultyLink
from turtlewire.links.memory import MemoryLink
from turtlewire.links.stream import open_port
from turtlewire.robots.car import AsyncCar, Car, Settings
from turtlewire.robots.runner import InlineRunner
from turtlewire.simulator.car import CarSettings, SimulatedCar
from turtlewire.simulator.server import serve
from turtlewire.turtle import Pose, Turtle

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.unit.robots.car.conftest import Bench, MakeBench
    from tests.unit.robots.car.wires import Wire

STOP = b"S" * 14  # section 4: what stops a robot in any state
WHOLE_STOP = b"S000000"


# ---------------------------------------------------------------- connecting (S7)


def test_s7_connecting_gets_in_step_and_stops_the_car(bench: MakeBench) -> None:
    made = bench()
    assert made.wire.bytes_sent == b"S" * 7 + WHOLE_STOP
    assert all(len(data) == 1 for _, data in made.wire.sent[:7])
    assert made.turtle.pose == Pose()
    assert made.turtle.statistics.resynchronisations == 1
    assert made.notes == []


def test_s7_whatever_the_car_was_in_the_middle_of_it_is_stopped(bench: MakeBench) -> None:
    def drive_first(wire: Wire) -> None:
        wire.robot.write(b"F200000F12")
        pass_time(wire.robot, 0.1)

    made = bench(prepare=drive_first)
    assert (made.robot.drive, made.robot.steer) == (0, 0)
    made.turtle.motor(90)
    assert made.robot.drive == 90


def test_a_car_that_boots_for_two_seconds_is_found(bench: MakeBench) -> None:
    made = bench({"boot_s": 2.0})
    assert made.robot.statistics.lost_bytes > 0
    assert 2.0 < made.robot.now < 3.0
    made.turtle.forward(10)
    assert made.off_mm < 0.05


def test_a_car_that_never_answers_is_refused_and_stopped(bench: MakeBench) -> None:
    wires: list[Wire] = []

    def prepare(wire: Wire) -> None:
        wire.to_host = mute
        wires.append(wire)

    with pytest.raises(NoReplyError, match="is the baud rate 9600 right"):
        bench(prepare=prepare, boot_s=0.0)
    assert wires[0].bytes_sent.endswith(STOP)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("baud", 1),
        ("speed", 0),
        ("speed", 256),
        ("turn", "waltz"),
        ("turn_space_mm", 0.0),
        ("tolerance_mm", float("nan")),
        ("window", 9),
        ("reply_delay_s", 0.0),
        ("retries", -1),
        ("boot_s", -1.0),
        ("heartbeat_s", 0.0),
    ],
)
def test_a_setting_that_drives_no_car_is_refused(name: str, value: object) -> None:
    settings = Settings(**{name: value})  # type: ignore[arg-type] # that is the point
    with pytest.raises(UsageError, match=name):
        AsyncCar(MemoryLink(SimulatedCar()), settings)


# ---------------------------------------------------------------- own commands


def test_own_commands_on_the_wire(bench: MakeBench) -> None:
    made = bench()
    made.wire.forget()
    made.turtle.motor(200)
    made.turtle.motor(-5)
    made.turtle.steer(-255)
    made.turtle.steer(7)
    made.turtle.motor(0)
    made.turtle.headlights(left_upper=True, left_lower=False, right_upper=True, right_lower=False)
    assert made.wire.bytes_sent == b"F200000B005000L255000R007000F000000H101000"
    assert (made.robot.drive, made.robot.steer) == (0, 7)
    assert made.robot.lights == (True, False, True, False)
    made.turtle.lamp(on=True)
    assert made.robot.lights == (True,) * 4


def refusals(turtle: Bench) -> list[Callable[[], object]]:
    car = turtle.turtle
    return [
        lambda: car.motor(256),
        lambda: car.motor(-256),
        lambda: car.motor(10.0),  # type: ignore[arg-type]
        lambda: car.steer(10.5),  # type: ignore[arg-type]
        lambda: car.motor(10, valid_s=0.0),
        lambda: car.steer(256),
        lambda: car.drive(1.1, 0),
        lambda: car.drive(0, -1.1),
        lambda: car.drive(float("nan"), 0),
        lambda: car.drive(0.5, 0, valid_s=-1),
        lambda: car.forward(2e6),
        lambda: car.right(float("nan")),
        lambda: car.set_position(float("inf"), 0),
        lambda: car.set_position(0, 2e6),
        lambda: car.set_heading(2e6),
        lambda: car.arc(2e6, 1),
        lambda: car.arc(1, 2e6),
        lambda: car.wait(2e6),
        lambda: car.set_speed(0),
        lambda: car.set_speed(256),
        lambda: car.horn("loud"),
    ]


def test_what_is_out_of_range_is_refused_before_any_byte_leaves(bench: MakeBench) -> None:
    made = bench()
    made.wire.forget()
    for refused in refusals(made):
        with pytest.raises(MessageError):
            refused()
    assert made.wire.bytes_sent == b""


def test_what_a_car_has(bench: MakeBench) -> None:
    made = bench()
    assert isinstance(made.turtle, Turtle)
    assert isinstance(made.turtle, Drive)
    assert made.turtle.features == {"headlights", "lamp"}
    assert made.turtle.turning_radius_mm == pytest.approx(300.916, abs=0.001)
    with pytest.raises(NotSupportedError, match="no horn"):
        made.turtle.horn("low")


# ---------------------------------------------------------------- by hand


@pytest.mark.parametrize(
    ("speed", "turn", "drive", "steer"),
    [(1, 0, 255, 0), (-1, 1, -255, 255), (0.5, -0.5, 148, -128), (0.001, 0, 41, 0), (0, 1, 0, 255)],
)
def test_speed_and_turn_are_pwm_beyond_the_dead_band_and_steering(
    bench: MakeBench, speed: float, turn: float, drive: int, steer: int
) -> None:
    made = bench()
    made.turtle.drive(speed, turn)
    made.goes_on(0.1)
    assert (made.robot.drive, made.robot.steer) == (drive, steer)


def test_a_car_out_of_true_drives_straight_when_nobody_turns(bench: MakeBench) -> None:
    from turtlewire.robots.calibration import CarCalibration

    made = bench({"trim_deg": 2.0}, calibration=CarCalibration(trim_deg=2.0))
    made.turtle.drive(0.5, 0)
    made.goes_on(2.0)
    assert made.robot.steer == -18
    assert abs(made.robot.pose.x_mm) < 3.0


def test_s9_a_joystick_builds_no_backlog_and_a_stop_is_not_behind_it(bench: MakeBench) -> None:
    made = bench(window=8)
    made.wire.forget()
    for n in range(100):
        made.turtle.drive(n / 100.0, n / 200.0)
    assert len(made.wire.bytes_sent) <= 8 * 7
    assert made.wire.discards == 0
    made.turtle.stop()
    assert made.wire.discards == 1
    assert made.wire.bytes_sent.endswith(STOP)
    assert made.robot.bytes_on_line <= len(STOP) + 1
    pass_time(made.robot, 1.0)
    assert (made.robot.drive, made.robot.steer) == (0, 0)
    made.wire.forget()
    made.goes_on(1.0)
    assert set(made.wire.bytes_sent) <= set(b"S0")  # back in step, and nothing of what was waiting


def test_the_newest_set_point_wins(bench: MakeBench) -> None:
    made = bench()
    for n in range(50):
        made.turtle.drive(n / 100.0, 0)
    made.turtle.drive(-0.5, 1)
    made.goes_on(0.2)
    assert (made.robot.drive, made.robot.steer) == (-148, 255)


def test_a_set_point_lives_as_long_as_it_is_valid(bench: MakeBench) -> None:
    made = bench()
    made.turtle.drive(0.5, 0.2, valid_s=0.3)
    assert made.goes_on(0.25)
    made.turtle.drive(0.5, 0.2, valid_s=0.3)
    assert made.goes_on(0.25)
    made.turtle.steer(0)  # does not make it live longer
    assert not made.goes_on(0.1)
    assert not made.goes_on(1.0)
    made.turtle.motor(100, valid_s=0.1)
    made.turtle.motor(100)
    assert made.goes_on(1.0)


def test_where_it_was_driven_by_hand_is_reckoned(bench: MakeBench) -> None:
    made = bench({"steer_deg_per_s": float("inf")})
    made.turtle.drive(0.5, 1)
    made.goes_on(3.0)
    assert made.off_mm < 12.0  # of 800 mm: steering goes out before the motor
    assert abs(made.turtle.pose.heading_deg) > 90.0
    made.turtle.forward(10)
    made.turtle.back(10)
    assert made.off_mm < 12.0
    assert made.robot.drive == 0


def test_driving_by_hand_takes_the_car_from_a_program(bench: MakeBench) -> None:
    made = bench()
    made.wire.at(0.5, lambda: made.turtle.drive(-0.5, 0))
    with pytest.raises(StoppedError, match="driven by hand"):
        made.turtle.forward(1000)
    made.goes_on(0.1)
    assert made.robot.drive == -148


# ---------------------------------------------------------------- stopping


def test_a_stop_while_a_program_drives(bench: MakeBench) -> None:
    made = bench()
    made.wire.at(0.5, made.turtle.stop)
    with pytest.raises(StoppedError):
        made.turtle.forward(1000)
    pass_time(made.robot, 1.0)
    stood = made.robot.pose
    assert 80.0 < stood.y_mm < 120.0
    assert made.off_mm < 0.01
    made.turtle.forward(50)
    assert made.robot.pose.y_mm - stood.y_mm == pytest.approx(50.0, abs=0.01)


def test_an_interrupt_while_the_wheels_turn_leaves_the_turtle_where_the_car_is(bench: MakeBench) -> None:
    made = bench()

    def interrupt() -> None:
        raise KeyboardInterrupt

    made.turtle.right(90)
    made.wire.at(0.1, interrupt)
    with pytest.raises(KeyboardInterrupt):
        made.turtle.forward(1000)
    assert made.robot.statistics.distance_mm == 0.0  # it had only begun to steer
    assert made.turtle.pose == Pose()


def test_after_a_stop_nothing_of_a_turn_is_left(bench: MakeBench) -> None:
    made = bench()
    made.turtle.right(90)
    made.turtle.stop()
    made.turtle.finish()
    assert made.turtle.pose == Pose()
    assert made.robot.pose == Pose()


def test_the_end_of_a_with_block_waits_and_then_stops(bench: MakeBench) -> None:
    made = bench()
    with made.turtle as turtle:
        turtle.forward(100)
        turtle.right(90)
    assert made.robot.pose.heading_deg == pytest.approx(90.0, abs=0.01)
    assert made.wire.bytes_sent.endswith(WHOLE_STOP)
    made.turtle.close()
    for use in (made.turtle.finish, lambda: made.turtle.drive(1, 0), made.turtle.stop):
        with pytest.raises(LinkClosedError):
            use()


def test_the_end_of_a_with_block_stops_who_drives_by_hand(bench: MakeBench) -> None:
    made = bench()
    with made.turtle as turtle:
        turtle.drive(1, 0)
    assert made.wire.bytes_sent.endswith(WHOLE_STOP)
    pass_time(made.robot, 0.1)
    assert made.robot.drive == 0


@pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt])
def test_an_error_while_the_car_drives_stops_it_at_once(bench: MakeBench, error: type[BaseException]) -> None:
    made = bench()

    def fail() -> None:
        raise error

    made.wire.at(0.5, fail)
    with pytest.raises(error), made.turtle as turtle:
        turtle.forward(1000)
    pass_time(made.robot, 1.0)
    assert 80.0 < made.robot.pose.y_mm < 120.0
    assert made.robot.drive == 0


def test_a_car_that_does_not_answer_when_it_is_let_go_gets_the_bytes_that_stop_any(bench: MakeBench) -> None:
    made = bench()
    made.turtle.drive(1, 0)
    made.wire.to_host = mute
    made.turtle.close(finish=False)
    assert made.wire.bytes_sent.endswith(STOP)
    assert made.robot.drive == 0


def test_a_car_out_of_step_is_brought_in_step_and_stopped_when_it_is_let_go(bench: MakeBench) -> None:
    made = bench()
    made.turtle.drive(1, 0)
    made.wire.robot.write(b"F2")  # what it is in the middle of now, its host does not know
    made.turtle.close(finish=False)
    assert made.robot.drive == 0
    assert made.wire.bytes_sent.endswith(WHOLE_STOP)


# ---------------------------------------------------------------- watchdog, the link, other ways to run it


def test_a_heartbeat_feeds_a_watchdog(bench: MakeBench) -> None:
    made = bench({"watchdog_s": 0.5}, heartbeat_s=0.2)
    made.turtle.forward(400)
    assert made.robot.statistics.watchdog_stops == 0
    assert made.off_mm < 0.1
    assert made.wire.bytes_sent.count(b"F124000") > 3


def test_a_link_that_ends_while_the_car_drives(bench: MakeBench) -> None:
    async def drive() -> None:
        link = FaultyLink(MemoryLink(SimulatedCar()), Faults(close_at_s=1.0))
        async with AsyncCar(link) as car:
            await car.connect()
            await car.forward(1000)

    with pytest.raises(LinkLostError):
        asyncio.run(drive())


def test_a_car_whose_pen_is_a_light_goes_on_after_its_link_was_lost() -> None:
    async def drive() -> None:
        robot = SimulatedCar()
        link = FaultyLink(MemoryLink(robot), Faults(close_at_s=1.0))
        async with AsyncCar(link, Settings(pen_light=True)) as car:
            await car.connect()
            with pytest.raises(LinkLostError):
                await car.forward(1000)
            await car.reconnected()
            await car.resume()
            assert robot.lights == (False, True, False, True)
            stood = robot.pose
            await car.forward(50)
            assert stood.distance_to(*robot.pose[:2]) == pytest.approx(50.0, abs=0.1)

    asyncio.run(drive())


def test_the_asynchronous_car_over_a_real_pty() -> None:
    async def draw() -> tuple[Pose, Pose, int]:
        robot = SimulatedCar(CarSettings(baud=None))
        url: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        stopped = asyncio.Event()
        server = asyncio.create_task(serve(robot, "pty", ready=url.set_result, stopped=stopped))
        async with AsyncCar(await open_port(await url, baud=9600), Settings(boot_s=0.0)) as car:
            await car.connect()
            await car.forward(60)
            await car.left(20)
            await car.back(30)
            await car.finish()
            pose = car.pose
        drive = robot.drive
        stopped.set()
        await server
        return pose, robot.pose, drive

    pose, true, drive = asyncio.run(draw())
    assert drive == 0
    assert pose.distance_to(true.x_mm, true.y_mm) < 20.0  # as far as the scheduler lets it


def test_a_car_that_is_lost_is_stopped() -> None:
    robot = SimulatedCar()
    runner = InlineRunner()
    driver = AsyncCar(MemoryLink(robot))
    runner.run(driver.connect())
    car = Car(driver, runner)
    car.motor(100)
    del car
    gc.collect()
    assert robot.drive == 0
    assert driver.is_over


def test_statistics_tell_what_happened(bench: MakeBench) -> None:
    made = bench()
    made.wire.to_host = Damage(b"K", {0: b"?K"})
    made.turtle.forward(100)
    made.turtle.back(30)
    figures = made.turtle.statistics
    assert figures.distance_mm == pytest.approx(130.0, abs=0.01)
    assert figures.bytes_sent == len(made.wire.bytes_sent)
    assert figures.malformed_replies == 1
    assert (figures.unexpected_replies, figures.resynchronisations) == (0, 1)
    assert figures.seconds == made.robot.now
