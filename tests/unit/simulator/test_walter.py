"""Logo control: what each command does and exactly when (PROTOCOLS W1 to W10, W14; section 4)."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import Mode, encode
from turtlewire.simulator.walter import Action, Settings, SimulatedWalter
from turtlewire.trace import Stroke
from turtlewire.turtle import HOME, Pose

Run = Callable[..., bytes]
BYTE_S = 10 / 9600
INSTANT = Settings(baud=None)


def sent(*messages: m.WalterMessage) -> bytes:
    return b"".join(map(encode, messages))


def robot_and_log(settings: Settings = INSTANT) -> tuple[SimulatedWalter, list[Action]]:
    robot, log = SimulatedWalter(settings), list[Action]()
    robot.events = log.append
    return robot, log


def check_times(log: list[Action], expected: list[tuple[str, float]]) -> None:
    assert [action.what for action in log] == [what for what, _ in expected]
    assert [action.time_s for action in log] == pytest.approx([time_s for _, time_s in expected], abs=1e-9)


def moves(robot: SimulatedWalter) -> bool:
    # A call: mypy would take it that a property asked twice is the same twice.
    return robot.is_moving


# The line and time


def test_a_command_acts_when_its_last_bit_has_arrived_and_takes_its_time(run: Run) -> None:
    robot, log = robot_and_log(Settings())
    run(robot, sent(m.Forward(200), m.Right(90)))
    check_times(
        log,
        [
            ("started forward distance_half_mm=200", 4 * BYTE_S),
            ("ended forward distance_half_mm=200", 4 * BYTE_S + 1.0),
            ("started right angle_deg=90", 4 * BYTE_S + 1.0),
            ("ended right angle_deg=90", 4 * BYTE_S + 1.9),
        ],
    )
    assert robot.pose == robot.odometer == Pose(0.0, 100.0, 90.0)


def test_the_reply_comes_byte_by_byte(run: Run) -> None:
    robot = SimulatedWalter()
    robot.write(sent(m.QueryHeading()))
    reply, came, when = encode(m.HeadingReply(0)), b"", []
    while data := robot.read(1.0):
        came += data
        when.append(robot.now)
    assert came == reply
    assert when == pytest.approx([(3 + i) * BYTE_S for i in range(1, len(reply) + 1)], abs=1e-9)
    assert robot.now == 1.0


def test_without_a_baud_rate_bytes_take_no_time() -> None:
    robot = SimulatedWalter(INSTANT)
    robot.write(sent(m.QueryHeading()))
    assert robot.next_event() == 0.0
    assert robot.read(0.0) == encode(m.HeadingReply(0))
    assert robot.now == 0.0


def test_time_never_goes_back() -> None:
    robot = SimulatedWalter()
    assert robot.read(5.0) == b""
    assert robot.read(2.0) == b""
    assert robot.now == 5.0


def test_reading_for_ever_ends_when_nothing_more_will_happen() -> None:
    robot = SimulatedWalter(INSTANT)
    robot.write(sent(m.Forward(200)))
    assert robot.read(math.inf) == b""
    assert robot.now == 1.0
    assert robot.next_event() == math.inf


def test_bytes_that_have_not_gone_out_can_be_taken_back(run: Run) -> None:
    robot = SimulatedWalter()
    robot.write(sent(m.Forward(200), m.Forward(1000)))
    robot.read(4.5 * BYTE_S)
    assert robot.bytes_on_line == 4
    robot.discard_output()
    assert robot.bytes_on_line == 1
    run(robot, m.EMERGENCY_STOP)
    assert robot.odometer.y_mm < 2.0
    assert robot.mode is Mode.DIRECT


def test_bytes_that_arrive_during_the_boot_are_lost(run: Run) -> None:
    robot = SimulatedWalter(Settings(boot_s=4.5 * BYTE_S))
    run(robot, sent(m.Forward(200), m.Back(50)))
    assert robot.statistics.lost_bytes == 4
    assert robot.statistics.bytes_in == 4
    assert robot.odometer == Pose(0.0, -25.0, 0.0)


# Commands, in order (W9)


def test_speed_counts_for_the_moves_and_turns_after_it(run: Run) -> None:
    robot, log = robot_and_log(Settings(baud=None, mm_per_s_per_unit=2.0, deg_per_s_per_unit=0.5))
    run(robot, sent(m.Forward(400), m.SetSpeed(20), m.Forward(400), m.Left(20)))
    assert [action.time_s for action in log if action.what.startswith("ended")] == [
        pytest.approx(1.0),
        pytest.approx(6.0),
        pytest.approx(8.0),
    ]
    assert robot.speed == robot.turn_speed == 20
    assert robot.odometer == Pose(0.0, 400.0, 340.0)


def test_turns_go_all_the_way_round(run: Run) -> None:
    robot = SimulatedWalter(INSTANT)
    run(robot, sent(m.Right(725), m.Left(1)))
    assert robot.odometer.heading_deg == 4.0
    assert robot.statistics.turned_deg == 726.0


def test_back_drives_back(run: Run) -> None:
    robot = SimulatedWalter(INSTANT)
    run(robot, sent(m.Right(90), m.Back(7)))
    assert robot.odometer == Pose(-3.5, 0.0, 90.0)
    assert robot.statistics.distance_mm == 3.5


def test_moves_and_turns_of_nothing_take_no_time(run: Run) -> None:
    robot = SimulatedWalter(Settings(baud=None, speed=0))
    robot.write(sent(m.Forward(0), m.Right(0), m.QueryHeading()))
    assert robot.read(1.0) == encode(m.HeadingReply(0))
    assert robot.now == 0.0


def test_at_speed_zero_a_motion_waits_until_it_is_stopped(run: Run) -> None:
    robot, log = robot_and_log(Settings(baud=None, speed=0))
    run(robot, sent(m.Forward(2)))
    assert robot.next_event() == math.inf
    assert not moves(robot)
    assert robot.odometer == HOME
    run(robot, sent(m.SelectDirect()))
    assert log[-1].what == "stopped forward distance_half_mm=2"


def test_the_pen_takes_its_time_and_the_next_command_waits_for_it(run: Run) -> None:
    robot, log = robot_and_log()
    run(robot, sent(m.PenDown(), m.Forward(200), m.PenUp(), m.QueryPen()), 0.05)
    assert not robot.pen_is_down
    run(robot)
    check_times(
        log,
        [
            ("pen down", 0.1),
            ("started forward distance_half_mm=200", 0.1),
            ("ended forward distance_half_mm=200", 1.1),
            ("pen up", 1.2),
        ],
    )


def test_a_pen_that_is_there_already_takes_no_time() -> None:
    robot, _ = robot_and_log(Settings(baud=None, pen_down=True))
    robot.write(sent(m.PenDown(), m.QueryPen()))
    assert robot.read(1.0) == encode(m.PenReply(1))
    assert robot.now == 0.0


def test_the_trace_is_what_the_pen_drew(run: Run) -> None:
    robot = SimulatedWalter(INSTANT)
    run(robot, sent(m.Forward(20), m.PenDown(), m.Right(90), m.Forward(20), m.PenUp(), m.Forward(20)))
    assert robot.trace.strokes == [
        Stroke(pen_down=False, points=[(0.0, 0.0), (0.0, 10.0)]),
        Stroke(pen_down=True, points=[(0.0, 10.0), (10.0, 10.0)]),
        Stroke(pen_down=False, points=[(10.0, 10.0), (20.0, 10.0)]),
    ]
    robot.clear_trace()
    assert robot.trace.strokes == []
    assert robot.trace.start == Pose(20.0, 10.0, 90.0)


def test_the_trace_holds_the_running_motion_up_to_now_and_asking_leaves_no_mark(run: Run) -> None:
    robot = SimulatedWalter(Settings(baud=None, pen_down=True))
    run(robot, sent(m.Forward(20), m.Right(90), m.Forward(200)), 1.25)
    assert robot.trace.pose == robot.pose == pytest.approx(Pose(25.0, 10.0, 90.0))
    expected = [(0.0, 0.0), (0.0, 10.0), (robot.pose.x_mm, 10.0)]
    assert robot.trace.strokes == [Stroke(pen_down=True, points=expected)]
    assert moves(robot)
    run(robot)
    assert not moves(robot)
    assert robot.trace.strokes == [Stroke(pen_down=True, points=[(0.0, 0.0), (0.0, 10.0), (100.0, 10.0)])]


def test_a_trace_asked_for_on_the_way_has_all_strokes(run: Run) -> None:
    robot = SimulatedWalter(INSTANT)
    data = sent(m.Forward(2), m.PenDown(), m.Forward(2), m.PenUp(), m.Forward(2), m.PenDown(), m.Forward(2))
    run(robot, data, 0.335)
    halfway = robot.trace.strokes
    assert [stroke.pen_down for stroke in halfway] == [False, True, False, True]
    assert halfway[3].points == [(0.0, 3.0), (0.0, pytest.approx(3.5))]
    run(robot)
    assert robot.trace.strokes[:3] == halfway[:3]
    assert robot.trace.strokes[3].points == [(0.0, 3.0), (0.0, 4.0)]


def test_a_new_sheet_in_the_middle_of_a_motion(run: Run) -> None:
    robot = SimulatedWalter(Settings(baud=None, pen_down=True))
    run(robot, sent(m.Forward(200)), 0.25)
    robot.clear_trace()
    assert robot.trace.start == Pose(0.0, 25.0, 0.0)
    run(robot)
    assert robot.trace.strokes == [Stroke(pen_down=True, points=[(0.0, 25.0), (0.0, 100.0)])]


def test_horn_and_lamp(run: Run) -> None:
    robot, log = robot_and_log()
    assert (robot.horn, robot.lamp) == ("off", False)
    run(robot, sent(m.HornLow(), m.LampOn()))
    assert (robot.horn, robot.lamp) == ("low", True)
    run(robot, sent(m.HornHigh(), m.LampOff()))
    assert (robot.horn, robot.lamp) == ("high", False)
    run(robot, sent(m.HornOff()))
    assert robot.horn == "off"
    assert [action.what for action in log] == ["horn low", "lamp on", "horn high", "lamp off", "horn off"]


def test_a_robot_without_a_group_does_not_know_its_commands(run: Run) -> None:
    robot = SimulatedWalter(Settings(baud=None, groups=frozenset("Q")))
    reply = run(robot, sent(m.HornLow(), m.LampOn(), m.TurnTo(90), m.QueryHeading()))
    assert (robot.horn, robot.lamp) == ("off", False)
    assert reply == encode(m.HeadingReply(0))
    assert robot.statistics.malformed == 3
    assert robot.statistics.commands == 1


def test_the_statistics_count_what_was_done_and_dropped(run: Run) -> None:
    robot = SimulatedWalter(INSTANT)
    run(robot, b"?\r" + sent(m.QueryX(), m.Forward(10)))
    assert robot.statistics == (2, 9, 5, 0, 1, 0, 0, 0, 0, 5.0, 0.0)


def test_statistics_hold_the_running_motion(run: Run) -> None:
    robot = SimulatedWalter(INSTANT)
    run(robot, sent(m.Forward(200)), 0.5)
    assert robot.statistics.distance_mm == 50.0
    run(robot, sent(m.Right(90)), 0.75)
    assert (robot.statistics.distance_mm, robot.statistics.turned_deg) == (100.0, 25.0)


# The C group (W10)


def moved(run: Run, *messages: m.WalterMessage) -> SimulatedWalter:
    """The robot after these, from x 30, y 40, heading 90."""
    robot = SimulatedWalter(INSTANT)
    run(robot, sent(m.Forward(80), m.Right(90), m.Forward(60), *messages))
    return robot


def test_reset_location_makes_this_the_origin_and_keeps_the_heading(run: Run) -> None:
    robot = moved(run, m.ResetLocation())
    assert robot.odometer == Pose(0.0, 0.0, 90.0)
    assert robot.pose == Pose(30.0, 40.0, 90.0)


def test_home_is_reached_in_a_straight_line(run: Run) -> None:
    robot = moved(run, m.GoHome())
    assert robot.odometer == pytest.approx(Pose(0.0, 0.0, 180.0 + math.degrees(math.atan2(3, 4))), abs=1e-6)
    assert robot.statistics.distance_mm == pytest.approx(120.0)


def test_home_from_home_moves_nothing(run: Run) -> None:
    robot = SimulatedWalter(INSTANT)
    run(robot, sent(m.Right(20), m.GoHome(), m.GoTo(0, 0)))
    assert robot.odometer == Pose(0.0, 0.0, 20.0)
    assert robot.statistics.turned_deg == 20.0


@pytest.mark.parametrize(
    ("heading", "turned"), [(100, 10.0), (80, 10.0), (270, 180.0), (271, 179.0), (0, 90.0), (450, 0.0)]
)
def test_turning_to_a_heading_goes_the_shorter_way(run: Run, heading: int, turned: float) -> None:
    robot = moved(run, m.TurnTo(heading))
    assert robot.odometer.heading_deg == heading % 360
    assert robot.statistics.turned_deg == 90.0 + turned


@pytest.mark.parametrize(
    ("command", "x_mm", "y_mm"),
    [
        (m.GoTo(-20, 100), -10.0, 50.0),
        (m.GoTo(60, 81), 30.0, 40.5),
        (m.GoToX(-31), -15.5, 40.0),
        (m.GoToX(60), 30.0, 40.0),
        (m.GoToY(-32768), 30.0, -16384.0),
        (m.GoToY(32767), 30.0, 16383.5),
    ],
)
def test_going_to_a_place_keeps_the_heading(
    run: Run, command: m.LogoCommand, x_mm: float, y_mm: float
) -> None:
    robot = moved(run, command)
    assert robot.odometer == pytest.approx(Pose(x_mm, y_mm, 90.0), abs=1e-6)
    assert robot.odometer.heading_deg == 90.0
    expected = 70.0 + math.hypot(x_mm - 30.0, y_mm - 40.0)
    assert robot.statistics.distance_mm == pytest.approx(expected)


def test_a_command_of_several_motions_starts_and_ends_once(run: Run) -> None:
    robot, log = robot_and_log()
    run(robot, sent(m.GoTo(200, 0)))
    # 90 degrees, 100 mm, 90 degrees, at 100 a second
    check_times(
        log,
        [
            ("started go_to x_half_mm=200 y_half_mm=0", 0.0),
            ("ended go_to x_half_mm=200 y_half_mm=0", 2.8),
        ],
    )


# Queries


def test_queries_are_answered_when_their_turn_comes(run: Run) -> None:
    robot = SimulatedWalter(INSTANT)
    robot.write(sent(m.QueryY(), m.Forward(201), m.QueryY(), m.Right(45), m.QueryHeading()))
    assert robot.read(10.0) == encode(m.YReply(0))
    assert robot.read(10.0) == encode(m.YReply(201))
    assert robot.now == pytest.approx(1.005)
    assert robot.read(10.0) == encode(m.HeadingReply(45))
    assert robot.now == pytest.approx(1.455)


def test_every_query(run: Run) -> None:
    robot = moved(run, m.PenDown())
    queries = (
        m.QueryLocation(),
        m.QueryX(),
        m.QueryY(),
        m.QueryHeading(),
        m.QueryPen(),
        m.QueryTowards(0, 0),
    )
    assert run(robot, sent(m.QueryTowards(100, 40))) == encode(m.TowardsReply(135))
    assert run(robot, sent(*queries)) == sent(
        m.LocationReply(60, 80),
        m.XReply(60),
        m.YReply(80),
        m.HeadingReply(90),
        m.PenReply(1),
        m.TowardsReply(217),
    )


def test_answers_are_rounded_half_up_and_headings_stay_below_360(run: Run) -> None:
    robot = SimulatedWalter(INSTANT)
    run(robot, sent(m.GoTo(-1, 0), m.GoTo(-1, 114)))  # half a millimetre
    assert run(robot, sent(m.QueryTowards(-2, 114))) == encode(m.TowardsReply(270))
    assert run(robot, sent(m.QueryTowards(-2, 1000))) == encode(m.TowardsReply(0))
    run(robot, sent(m.ResetLocation(), m.TurnTo(30), m.Forward(1)))  # x 0.25 mm: half a unit
    assert run(robot, sent(m.QueryX())) == encode(m.XReply(1))
    run(robot, sent(m.ResetLocation(), m.Back(1)))  # x -0.25 mm: minus half a unit
    assert run(robot, sent(m.QueryX())) == encode(m.XReply(0))


def test_coordinates_saturate(run: Run) -> None:
    robot = SimulatedWalter(INSTANT)
    run(robot, sent(m.Forward(65535), m.Right(90), m.Back(65535)), 2000.0)
    assert run(robot, sent(m.QueryLocation())) == encode(m.LocationReply(-32768, 32767))


# Stopping and losing


def test_direct_control_ends_the_motion_where_it_is_and_abandons_the_queue(run: Run) -> None:
    robot, log = robot_and_log()
    run(robot, sent(m.Forward(200), m.Right(90), m.Forward(200)), 0.5)
    run(robot, sent(m.SelectDirect()))
    assert robot.mode is Mode.DIRECT
    assert robot.odometer == Pose(0.0, 50.0, 0.0)
    assert log[-1] == (0.5, "stopped forward distance_half_mm=200")
    run(robot, sent(m.SelectLogo(), m.QueryY()))
    assert robot.odometer == Pose(0.0, 50.0, 0.0)


@pytest.mark.parametrize("seconds", [0.0, 0.3, 1.2, 1.95, 5.0])
def test_attention_stops_from_any_state(run: Run, seconds: float) -> None:
    robot = SimulatedWalter()
    run(robot, sent(m.Forward(200), m.Right(90), m.Forward(200), m.GoTo(1, 2))[:-3], seconds)
    run(robot, m.ATTENTION, 0.1)
    pose = robot.odometer
    assert not moves(robot)
    assert robot.mode is Mode.LOGO
    assert run(robot, sent(m.QueryPen())) == encode(m.PenReply(0))
    assert robot.odometer == pose


def test_commands_beyond_the_queue_are_lost_and_counted(run: Run) -> None:
    robot = SimulatedWalter(INSTANT)
    run(robot, sent(m.Forward(2)) * (m.QUEUE_COMMANDS + 4))
    assert robot.statistics.overflowed == 3  # one is under way
    assert robot.odometer.y_mm == m.QUEUE_COMMANDS + 1


def test_the_largest_window_never_overflows(run: Run) -> None:
    robot = SimulatedWalter()
    for command in (m.PenUp(), m.PenDown(), m.ResetLocation(), m.QueryX(), m.SetSpeed(3), m.Forward(1)):
        run(robot, encode(m.Forward(1000)))
        data = encode(command)
        run(robot, data * (m.MAX_UNFENCED_BYTES // len(data)))
    assert robot.statistics.overflowed == 0


def test_the_watchdog_stops_a_robot_whose_host_is_silent(run: Run) -> None:
    robot, log = robot_and_log(Settings(baud=None, watchdog_s=0.5))
    run(robot, sent(m.Forward(20), m.Forward(200), m.Right(90)))
    assert robot.odometer == Pose(0.0, 50.0, 0.0)
    assert log[-2:] == [(0.5, "watchdog"), (0.5, "stopped forward distance_half_mm=200")]
    assert robot.statistics.watchdog_stops == 1
    assert robot.next_event() == math.inf
    run(robot, sent(m.Right(10)))
    assert robot.odometer == Pose(0.0, 50.0, 10.0)
    assert robot.statistics.watchdog_stops == 1


def test_an_empty_line_feeds_the_watchdog_and_noise_does_not(run: Run) -> None:
    robot = SimulatedWalter(Settings(baud=None, watchdog_s=0.5))
    run(robot, sent(m.Forward(200)), 0.4)
    run(robot, b"\r", 0.4)
    run(robot, b"?\r", 0.4)  # ill-formed: nothing valid
    assert robot.odometer.y_mm == pytest.approx(90.0)


def test_the_watchdog_works_in_direct_control(run: Run) -> None:
    robot = SimulatedWalter(Settings(baud=None, watchdog_s=0.5, mode=Mode.DIRECT))
    run(robot, b"A", 0.3)
    run(robot, b"\r")
    assert robot.odometer.y_mm == pytest.approx(80.0)


# Wheels that fail


def test_slip_shows_on_the_ground_and_not_in_the_odometer(run: Run) -> None:
    robot = SimulatedWalter(Settings(baud=None, slip=0.05, pen_down=True, seed=3))
    reply = run(robot, sent(m.Forward(2000), m.Right(90), m.QueryLocation(), m.QueryHeading()))
    assert reply == sent(m.LocationReply(0, 2000), m.HeadingReply(90))
    assert robot.odometer == pytest.approx(Pose(0.0, 1000.0, 90.0))
    assert 950.0 < math.hypot(robot.pose.x_mm, robot.pose.y_mm) < 999.0
    assert abs(robot.pose.heading_deg - 90.0) > 0.5
    assert robot.trace.pose == robot.pose
    assert len(robot.trace.strokes[0].points) > 5  # an arc: the wheels slip unequally


def test_noise_shows_in_the_odometer_too(run: Run) -> None:
    robot = SimulatedWalter(Settings(baud=None, noise=5.0, seed=3))
    run(robot, sent(m.Forward(2000)))
    assert robot.odometer == robot.pose
    assert 0.1 < abs(robot.odometer.y_mm - 1000.0) < 20.0


def test_going_to_a_place_corrects_itself_by_the_odometer(run: Run) -> None:
    robot = SimulatedWalter(Settings(baud=None, noise=2.0, seed=1))
    for _ in range(20):
        run(robot, sent(m.GoTo(2000, 2000), m.GoTo(0, 0)))
    assert math.hypot(robot.odometer.x_mm, robot.odometer.y_mm) < 60.0


def test_the_same_seed_gives_the_same_bits_and_another_one_others(run: Run) -> None:
    def poses(seed: int) -> object:
        robot = SimulatedWalter(Settings(slip=0.02, noise=1.0, seed=seed, pen_down=True))
        replies = run(robot, sent(m.Forward(2000), m.Right(90), m.GoTo(5, 5), m.QueryLocation()))
        return replies, robot.pose, robot.odometer, robot.trace.strokes, robot.statistics

    assert poses(7) == poses(7)
    assert poses(7) != poses(8)
