"""What must hold for a simulated WALTER whatever is sent to it and however its time is cut up."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hypothesis import given, settings
from hypothesis import strategies as st

from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import Mode, encode
from turtlewire.simulator.chassis import Wheels, drive
from turtlewire.simulator.walter import Action, Settings, SimulatedWalter
from turtlewire.simulator.world import TOUCH_MM, Wall, World
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from collections.abc import Callable

ROOM = World(
    (
        Wall(-300.0, -300.0, 300.0, -300.0),
        Wall(300.0, -300.0, 300.0, 300.0),
        Wall(300.0, 300.0, -300.0, 300.0),
        Wall(-300.0, 300.0, -300.0, -300.0),
        Wall(150.0, 150.0, 200.0, 120.0),
    )
)
ROBOTS = st.builds(
    Settings,
    baud=st.sampled_from([None, 9600, 115200]),
    world=st.sampled_from([World(), ROOM]),
    seed=st.integers(0, 3),
    slip=st.sampled_from([0.0, 0.05]),
    noise=st.sampled_from([0.0, 2.0]),
    mode=st.sampled_from(Mode),
    boot_s=st.sampled_from([0.0, 0.01]),
    watchdog_s=st.sampled_from([None, 0.7]),
    groups=st.frozensets(st.sampled_from("CQHE")),
)
DISTANCES = st.integers(0, 900)


def _command(message_type: type[m.WalterMessage]) -> st.SearchStrategy[bytes]:
    fields = [st.integers(max(field.low, -800), min(field.high, 800)) for field in message_type.FIELDS]
    return st.builds(message_type, *fields).map(encode)


LOGO = st.one_of([_command(t) for t in m.LOGO_COMMANDS])
KEYS = st.one_of([_command(t) for t in m.DIRECT_KEYS])
# Mostly what means something, in either mode, and some noise.
DATA = st.lists(st.one_of(LOGO, LOGO, KEYS, st.binary(max_size=6)), max_size=12).map(b"".join)
# What the host sends, and how long it waits afterwards.
SESSIONS = st.lists(st.tuples(DATA, st.floats(0.0, 20.0)), max_size=5)


def outcome(
    robot_settings: Settings,
    session: list[tuple[bytes, float]],
    *,
    write: Callable[[SimulatedWalter, bytes], None] = SimulatedWalter.write,
    wait: Callable[[SimulatedWalter, float], list[tuple[float, bytes]]],
) -> object:
    """Everything that can be seen of a robot during and after a session."""
    robot = SimulatedWalter(robot_settings)
    actions: list[Action] = []
    robot.events = actions.append
    came: list[tuple[float, bytes]] = []
    time_s = 0.0
    for data, pause_s in session:
        write(robot, data)
        time_s += pause_s
        came += wait(robot, time_s)
    seen = (robot.now, robot.pose, robot.odometer, robot.statistics, robot.trace.strokes)
    return actions, came, seen, robot.mode, robot.speed, robot.turn_speed, robot.pen_is_down, robot.horn


def in_one_go(robot: SimulatedWalter, until: float) -> list[tuple[float, bytes]]:
    came = []
    while robot.now < until:
        data = robot.read(until)
        if data:
            came.append((robot.now, data))
    return came


def by_events(robot: SimulatedWalter, until: float) -> list[tuple[float, bytes]]:
    came = []
    while robot.now < until:
        at = min(robot.next_event(), until)
        assert at >= robot.now
        data = robot.read(at)
        assert robot.now == at
        if data:
            came.append((robot.now, data))
    return came


def in_slices(robot: SimulatedWalter, until: float) -> list[tuple[float, bytes]]:
    came = []
    while robot.now < until:
        data = robot.read(min(until, robot.now + 0.037))
        if data:
            came.append((robot.now, data))
        # Looking leaves no mark.
        assert robot.trace.pose == robot.pose
        robot.statistics  # noqa: B018
    return came


def byte_by_byte(robot: SimulatedWalter, data: bytes) -> None:
    for value in data:
        robot.write(bytes([value]))


@settings(deadline=None)
@given(ROBOTS, SESSIONS)
def test_nothing_depends_on_how_writing_and_reading_are_cut_up(
    robot_settings: Settings, session: list[tuple[bytes, float]]
) -> None:
    whole = outcome(robot_settings, session, wait=in_one_go)
    assert outcome(robot_settings, session, wait=by_events) == whole
    assert outcome(robot_settings, session, wait=in_slices) == whole
    assert outcome(robot_settings, session, write=byte_by_byte, wait=in_one_go) == whole


@settings(deadline=None)
@given(ROBOTS, st.binary(max_size=300))
def test_no_bytes_crash_it_and_attention_always_brings_it_back(robot_settings: Settings, data: bytes) -> None:
    robot = SimulatedWalter(robot_settings)
    robot.read(1.0)
    robot.write(data)
    in_one_go(robot, 10.0)
    robot.write(m.ATTENTION)
    in_one_go(robot, 11.0)
    assert robot.mode is Mode.LOGO
    assert not robot.is_moving
    pose = robot.pose
    robot.write(encode(m.QueryPen()))
    came = b"".join(data for _, data in in_one_go(robot, 12.0))
    answers = [encode(m.PenReply(0)), encode(m.PenReply(1))]
    assert came in answers if "Q" in robot_settings.groups else came == b""
    assert robot.pose == pose


@settings(deadline=None)
@given(ROBOTS, SESSIONS)
def test_no_wall_is_ever_driven_through(robot_settings: Settings, session: list[tuple[bytes, float]]) -> None:
    robot = SimulatedWalter(robot_settings)
    time_s = 0.0
    for data, pause_s in session:
        robot.write(data)
        time_s += pause_s
        in_one_go(robot, time_s)
        for stroke in robot.trace.strokes:
            for x_mm, y_mm in stroke.points:
                # 2 TOUCH_MM: contact is found on chords of the arcs that slipping wheels drive.
                assert robot_settings.world.gap(x_mm, y_mm, robot_settings.radius_mm) > -2.0 * TOUCH_MM


# At speed 0 a motion waits for ever, and its host with it.
QUEUED = st.one_of([_command(t) for t in m.LOGO_COMMANDS if t.QUEUED]).filter(
    lambda data: data != encode(m.SetSpeed(0))
)


@settings(deadline=None)
@given(st.lists(QUEUED, max_size=60), st.sampled_from([None, 9600]))
def test_a_host_that_keeps_to_its_window_never_overflows(commands: list[bytes], baud: int | None) -> None:
    robot = SimulatedWalter(Settings(baud=baud))
    fence = encode(m.QueryPen())
    written, unfenced = 0, 0
    for command in commands:
        if unfenced + len(command) + len(fence) > m.MAX_UNFENCED_BYTES:
            robot.write(fence)
            written += 1
            while robot.next_event() < math.inf:
                robot.read(math.inf)
            assert robot.statistics.commands == written
            unfenced = 0
        robot.write(command)
        written += 1
        unfenced += len(command)
    while robot.next_event() < math.inf:
        robot.read(math.inf)
    assert robot.statistics.overflowed == robot.statistics.malformed == 0


TRAVEL = st.floats(-2000.0, 2000.0)


@settings(deadline=None)
@given(TRAVEL, TRAVEL, st.floats(0.0, 1.0), st.floats(0.0, 359.9))
def test_an_arc_cut_anywhere_ends_in_the_same_place(
    left: float, right: float, part: float, heading: float
) -> None:
    start = Pose(1.0, -2.0, heading)
    whole = drive(start, Wheels(left, right), 140.0)
    middle = drive(start, Wheels(left * part, right * part), 140.0)
    end = drive(middle, Wheels(left * (1.0 - part), right * (1.0 - part)), 140.0)
    assert math.dist(whole[:2], end[:2]) < 1e-5
    assert abs((whole.heading_deg - end.heading_deg + 180.0) % 360.0 - 180.0) < 1e-6
    assert 0.0 <= whole.heading_deg < 360.0


COORDINATES = st.floats(-1000.0, 1000.0)
HALF = st.integers(-2000, 2000).map(lambda value: value / 2.0)


@settings(deadline=None)
@given(HALF, HALF, HALF, HALF, st.integers(0, 359), st.floats(0.0, 3000.0))
def test_contact_is_where_the_disc_first_touches(
    x1: float, y1: float, x2: float, y2: float, heading: int, far_mm: float
) -> None:
    if (x1, y1) == (x2, y2):
        return
    world, here = World((Wall(x1, y1, x2, y2),)), Pose(0.0, 0.0, heading)
    if world.gap(0.0, 0.0, 90.0) <= TOUCH_MM:
        return
    end = here.moved(1.0)
    contact = world.contact(0.0, 0.0, (end.x_mm, end.y_mm), far_mm, 90.0)
    free_mm = far_mm if contact is None else contact.distance_mm
    assert free_mm <= far_mm
    for i in range(101):
        point = here.moved(free_mm * i / 100.0)
        assert world.gap(point.x_mm, point.y_mm, 90.0) > -1e-3
    if contact is not None:
        point = here.moved(free_mm)
        assert abs(world.gap(point.x_mm, point.y_mm, 90.0)) < 1e-6
