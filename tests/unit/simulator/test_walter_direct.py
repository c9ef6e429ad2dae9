"""Direct control: keys act when they arrive, also on the motion under way."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from turtlewire.protocols.walter.codec import Mode
from turtlewire.simulator.walter import Action, Settings, SimulatedWalter
from turtlewire.trace import Stroke
from turtlewire.turtle import HOME, Pose

Run = Callable[..., bytes]


def moves(robot: SimulatedWalter) -> bool:
    # A call: mypy would take it that a property asked twice is the same twice.
    return robot.is_moving


@pytest.fixture
def robot() -> SimulatedWalter:
    return SimulatedWalter(Settings(baud=None, mode=Mode.DIRECT))


@pytest.mark.parametrize(
    ("key", "pose"),
    [
        (b"A", Pose(0.0, 50.0, 0.0)),
        (b"a", Pose(0.0, 50.0, 0.0)),
        (b"Z", Pose(0.0, -50.0, 0.0)),
        (b".", Pose(0.0, 0.0, 50.0)),
        (b",", Pose(0.0, 0.0, 310.0)),
    ],
)
def test_a_start_key_moves_until_space(robot: SimulatedWalter, run: Run, key: bytes, pose: Pose) -> None:
    run(robot, key, 0.25)
    assert moves(robot)
    assert robot.next_event() == math.inf
    run(robot, b"", 0.25)
    run(robot, b" ", 1.0)
    assert not moves(robot)
    assert robot.odometer == robot.pose == pytest.approx(pose)


def test_a_new_start_key_replaces_the_motion(robot: SimulatedWalter, run: Run) -> None:
    log: list[Action] = []
    robot.events = log.append
    run(robot, b"A", 0.5)
    run(robot, b".", 0.9)
    run(robot, b"Z", 0.25)
    run(robot, b" ", 1.0)
    assert robot.odometer == pytest.approx(Pose(-25.0, 50.0, 90.0))
    assert [action.what for action in log] == [
        "started start_forward",
        "stopped start_forward",
        "started start_right",
        "stopped start_right",
        "started start_backward",
        "stopped start_backward",
    ]
    assert robot.statistics.commands == 4
    assert robot.statistics.distance_mm == pytest.approx(75.0)


def test_speeds_act_on_the_motion_under_way(robot: SimulatedWalter, run: Run) -> None:
    run(robot, b"A", 1.0)
    run(robot, b"G\x14", 1.0)
    run(robot, b"D", 1.0)
    run(robot, b"CCC", 1.0)
    assert robot.odometer.y_mm == pytest.approx(100.0 + 20.0 + 21.0 + 18.0)
    assert (robot.speed, robot.turn_speed) == (18, 100)


def test_turning_speeds_act_on_the_turn_under_way(robot: SimulatedWalter, run: Run) -> None:
    run(robot, b".", 1.0)
    run(robot, b"B\x0a", 1.0)
    run(robot, b"FF", 1.0)
    run(robot, b"V", 1.0)
    assert robot.odometer.heading_deg == pytest.approx(100.0 + 10.0 + 12.0 + 11.0)
    assert (robot.speed, robot.turn_speed) == (100, 11)


@pytest.mark.parametrize(
    ("keys", "speed", "turn_speed"),
    [(b"G\xfeDDD", 255, 100), (b"G\x01CCC", 0, 100), (b"B\xfeFFF", 100, 255), (b"B\x01VVV", 100, 0)],
)
def test_speeds_saturate(robot: SimulatedWalter, run: Run, keys: bytes, speed: int, turn_speed: int) -> None:
    run(robot, keys)
    assert (robot.speed, robot.turn_speed) == (speed, turn_speed)


def test_speed_zero_waits_and_goes_on_when_it_is_raised(robot: SimulatedWalter, run: Run) -> None:
    run(robot, b"A", 0.5)
    run(robot, b"G\x00", 5.0)
    assert robot.odometer.y_mm == pytest.approx(50.0)
    assert not moves(robot)
    run(robot, b"G\x0a", 1.0)
    assert robot.odometer.y_mm == pytest.approx(60.0)
    assert moves(robot)


def test_the_pen_moves_while_the_robot_drives(robot: SimulatedWalter, run: Run) -> None:
    run(robot, b"A", 0.5)
    run(robot, b"X", 0.5)
    run(robot, b"S", 0.5)
    run(robot, b" ")
    ends = [(stroke.pen_down, [round(y, 9) for _, y in stroke.points]) for stroke in robot.trace.strokes]
    assert ends == [(False, [0.0, 60.0]), (True, [60.0, 110.0]), (False, [110.0, 150.0])]


def test_a_pen_called_back_before_it_arrived(robot: SimulatedWalter, run: Run) -> None:
    log: list[Action] = []
    robot.events = log.append
    run(robot, b"X", 0.05)
    run(robot, b"S")
    assert [action.what for action in log] == ["pen up"]
    assert log[0].time_s == pytest.approx(0.15)
    assert robot.trace.strokes == []


def test_one_stops_and_returns_to_logo_control(robot: SimulatedWalter, run: Run) -> None:
    run(robot, b"A", 0.5)
    run(robot, b"1F\x00\x14\r")
    assert robot.mode is Mode.LOGO
    assert robot.odometer == pytest.approx(Pose(0.0, 60.0, 0.0))


def test_a_speed_set_by_key_holds_in_logo_control(robot: SimulatedWalter, run: Run) -> None:
    run(robot, b"G\x0aB\x051F\x00\x14\rR\x00\x0a\r", 2.0)
    assert robot.odometer == pytest.approx(Pose(0.0, 10.0, 5.0))


def test_what_is_no_key_is_counted_and_moves_nothing(robot: SimulatedWalter, run: Run) -> None:
    run(robot, b"Q\x00")
    assert robot.statistics.malformed == 2
    assert robot.odometer == HOME


def test_logo_commands_wait_for_a_pen_on_its_way(robot: SimulatedWalter, run: Run) -> None:
    run(robot, b"X1F\x00\x02\r")
    assert robot.trace.strokes == [Stroke(pen_down=True, points=[(0.0, 0.0), (0.0, 1.0)])]


def test_imperfect_wheels_drive_for_ever_in_pieces(run: Run) -> None:
    robot = SimulatedWalter(Settings(baud=None, mode=Mode.DIRECT, slip=0.02, noise=1.0, seed=5))
    log: list[Action] = []
    robot.events = log.append
    robot.write(b"A")
    assert robot.read(math.inf) == b""  # and comes back, though the robot drives on for ever
    assert robot.next_event() == pytest.approx(10.0)
    run(robot, b"", 35.0)
    run(robot, b".", 10.0)
    assert robot.next_event() - robot.now == pytest.approx(0.8)
    run(robot, b" ")
    assert robot.statistics.distance_mm == pytest.approx(3500.0)
    assert robot.statistics.turned_deg == pytest.approx(1000.0)
    assert [action.what.split()[0] for action in log] == ["started", "stopped"] * 2
    assert robot.pose != robot.odometer
