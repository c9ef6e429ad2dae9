"""Limit sensors (W13): contact stops, tells and forgets; what presses on is refused; the rest is free."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import Mode, encode
from turtlewire.simulator.walter import Action, Settings, SimulatedWalter
from turtlewire.simulator.world import Wall, World
from turtlewire.turtle import Pose

Run = Callable[..., bytes]
AHEAD = World((Wall(-1000.0, 190.0, 1000.0, 190.0),))
# The ends of two walls, in the way of the disc's sides.
GATE = World((Wall(-1000.0, 200.0, -85.0, 200.0), Wall(86.0, 200.0, 1000.0, 200.0)))


def sent(*messages: m.WalterMessage) -> bytes:
    return b"".join(map(encode, messages))


def robot_in(world: World, **settings: object) -> SimulatedWalter:
    made = Settings(baud=None, world=world, **settings)  # type: ignore[arg-type] # any setting
    return SimulatedWalter(made)


def test_contact_stops_the_motion_tells_the_host_and_abandons_the_queue(run: Run) -> None:
    robot, log = robot_in(AHEAD), list[Action]()
    robot.events = log.append
    robot.write(sent(m.Forward(400), m.Right(90), m.QueryX()))
    assert robot.read(10.0) == encode(m.LimitFront())
    assert robot.now == pytest.approx(1.0)
    assert run(robot) == b""
    assert robot.odometer == pytest.approx(Pose(0.0, 100.0, 0.0))
    assert [action.what for action in log] == [
        "started forward distance_half_mm=400",
        "stopped forward distance_half_mm=400",
        "limit front",
    ]
    assert robot.statistics.limits == 1
    assert robot.statistics.distance_mm == pytest.approx(100.0)


def test_the_event_is_sent_at_the_baud_rate() -> None:
    robot = SimulatedWalter(Settings(world=AHEAD))
    robot.write(sent(m.Forward(400)))
    assert robot.read(10.0) == b"L"
    assert robot.now == pytest.approx(1.0 + 5 * 10 / 9600)


@pytest.mark.parametrize(
    ("heading", "command", "event"),
    [
        (0, m.Forward(600), m.LimitFront()),
        (180, m.Back(600), m.LimitBack()),
        (90, m.Forward(0), None),
    ],
)
def test_ahead_and_astern(
    run: Run, heading: int, command: m.LogoCommand, event: m.RobotMessage | None
) -> None:
    robot = robot_in(AHEAD, start=Pose(0.0, 0.0, heading))
    assert run(robot, encode(command)) == (encode(event) if event else b"")


@pytest.mark.parametrize(
    ("x_mm", "command", "event"),
    [
        (-4.0, m.Forward(600), m.LimitLeft()),
        (4.0, m.Forward(600), m.LimitRight()),
        (-70.0, m.Forward(600), m.LimitFront()),
    ],
)
def test_a_glancing_contact_trips_a_side(
    run: Run, x_mm: float, command: m.LogoCommand, event: m.RobotMessage
) -> None:
    robot = robot_in(GATE, start=Pose(x_mm, 0.0, 0.0))
    assert run(robot, encode(command)) == encode(event)


@pytest.mark.parametrize(("x_mm", "event"), [(-4.0, m.LimitRight()), (4.0, m.LimitLeft())])
def test_astern_the_sides_are_the_robots_own(run: Run, x_mm: float, event: m.RobotMessage) -> None:
    robot = robot_in(GATE, start=Pose(x_mm, 0.0, 180.0))
    assert run(robot, encode(m.Back(600))) == encode(event)


@pytest.mark.parametrize(
    ("bearing", "event"),
    [
        (59, m.LimitFront()),
        (61, m.LimitRight()),
        (-59, m.LimitFront()),
        (-61, m.LimitLeft()),
        (119, m.LimitRight()),
        (121, m.LimitBack()),
        (-119, m.LimitLeft()),
        (-121, m.LimitBack()),
    ],
)
def test_the_sensors_share_the_circle_at_60_degrees(run: Run, bearing: int, event: m.RobotMessage) -> None:
    # The robot faces so that the wall ahead of it in the world lies at this bearing, and moves towards it.
    robot = robot_in(AHEAD, start=Pose(0.0, 0.0, -bearing))
    command = m.Forward(4000) if abs(bearing) < 90 else m.Back(4000)
    assert run(robot, encode(command)) == encode(event)


def test_pressing_on_is_refused_and_told_again(run: Run) -> None:
    robot = robot_in(AHEAD)
    run(robot, sent(m.Forward(400)))
    log: list[Action] = []
    robot.events = log.append
    pose = robot.odometer
    robot.write(sent(m.Right(10), m.Left(10), m.Forward(10), m.Right(90), m.QueryX()))
    assert robot.read(robot.now + 1.0) == encode(m.LimitFront())
    assert run(robot) == b""
    assert robot.odometer == pose
    assert [action.what for action in log[-2:]] == ["refused forward distance_half_mm=10", "limit front"]
    assert robot.statistics[6:8] == (1, 2)


def test_a_turn_and_the_way_back_are_free(run: Run) -> None:
    robot = robot_in(AHEAD)
    run(robot, sent(m.Forward(400)))
    assert run(robot, sent(m.Back(40))) == b""
    assert robot.odometer == pytest.approx(Pose(0.0, 80.0, 0.0))
    assert run(robot, sent(m.Forward(400))) == encode(m.LimitFront())
    assert run(robot, sent(m.Right(450), m.Forward(40), m.Back(20))) == b""
    assert robot.odometer == pytest.approx(Pose(10.0, 100.0, 90.0))


def test_a_motion_of_nothing_is_not_refused(run: Run) -> None:
    robot = robot_in(AHEAD)
    run(robot, sent(m.Forward(400)))
    assert run(robot, sent(m.Forward(0), m.QueryX())) == encode(m.XReply(0))


def test_a_limit_ends_a_command_of_several_motions(run: Run) -> None:
    robot = robot_in(AHEAD)
    assert run(robot, sent(m.Right(90), m.GoTo(0, 600), m.QueryX())) == encode(m.LimitFront())
    assert robot.odometer == pytest.approx(Pose(0.0, 100.0, 0.0))  # it does not turn back


def test_limits_work_in_direct_control(run: Run) -> None:
    robot = robot_in(AHEAD, mode=Mode.DIRECT)
    assert run(robot, b"A") == encode(m.LimitFront())
    assert robot.is_moving is False
    assert run(robot, b"A") == encode(m.LimitFront())
    assert robot.statistics[6:8] == (1, 2)
    assert run(robot, b".", 1.8) == b""
    assert run(robot, b"A", 0.1) == b""
    assert robot.odometer == pytest.approx(Pose(0.0, 90.0, 180.0))


def test_a_change_of_speed_moves_the_time_of_contact() -> None:
    robot = robot_in(AHEAD, mode=Mode.DIRECT)
    robot.write(b"A")
    robot.read(0.5)
    robot.write(b"G\x0a")
    assert robot.read(100.0) == encode(m.LimitFront())
    assert robot.now == pytest.approx(5.5)


def test_slip_cannot_push_a_turning_robot_into_a_wall(run: Run) -> None:
    held = 0
    for seed in range(40):
        robot = robot_in(AHEAD, slip=0.2, seed=seed, start=Pose(0.0, 100.0, 0.0))
        assert run(robot, sent(m.Right(170))) == b""
        assert robot.odometer == Pose(0.0, 0.0, 170.0)
        assert 130.0 < robot.pose.heading_deg < 170.0
        assert AHEAD.gap(robot.pose.x_mm, robot.pose.y_mm, 90.0) > -0.001
        if robot.pose[:2] == (0.0, 100.0):
            held += 1  # the wall holds it: it turns in place
        else:
            assert robot.pose.y_mm < 100.0
    assert 0 < held < 40


def test_wheels_that_slip_meet_walls_on_their_true_way(run: Run) -> None:
    seeds = range(40)
    for seed in seeds:
        robot = robot_in(AHEAD, slip=0.1, seed=seed, start=Pose(0.0, -800.0, 10.0))
        assert run(robot, sent(m.Forward(4000))) == encode(m.LimitFront())
        assert abs(AHEAD.gap(robot.pose.x_mm, robot.pose.y_mm, 90.0)) < 0.001
        assert robot.odometer.y_mm > robot.pose.y_mm + 800.0
        assert run(robot, sent(m.Forward(10))) == encode(m.LimitFront())
        assert robot.statistics.refused == 1
        assert run(robot, sent(m.Back(40))) == b""


def test_slipping_wheels_stop_at_a_wall_met_on_the_way_round(run: Run) -> None:
    # The wall is 5 m off: many pieces of an endless motion later.
    robot = robot_in(World((Wall(-1e5, 5090.0, 1e5, 5090.0),)), slip=0.001, seed=2, mode=Mode.DIRECT)
    assert run(robot, b"A") == encode(m.LimitFront())
    assert robot.pose.y_mm == pytest.approx(5000.0, abs=0.001)
