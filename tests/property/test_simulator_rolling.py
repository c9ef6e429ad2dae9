"""What must hold for robots that roll, whatever is sent to them, however their time is cut up, alone and together."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from turtlewire.protocols.frame.codec import FrameEncoder
from turtlewire.protocols.frame.dialect import shipped
from turtlewire.protocols.frame.messages import EngineBackward, EngineForward, SetServoPosition
from turtlewire.protocols.simple import messages as simple
from turtlewire.protocols.simple.codec import encode
from turtlewire.protocols.walter import messages as walter
from turtlewire.protocols.walter.codec import Mode
from turtlewire.protocols.walter.codec import encode as encode_walter
from turtlewire.simulator.body import Body
from turtlewire.simulator.car import CarSettings, SimulatedCar
from turtlewire.simulator.company import share_world
from turtlewire.simulator.frame_robot import FrameRobotSettings, SimulatedFrameRobot
from turtlewire.simulator.settings import BodySettings, Settings
from turtlewire.simulator.walter import SimulatedWalter
from turtlewire.simulator.world import TOUCH_MM, Disc, Wall, World
from turtlewire.turtle import Pose

AnyBody = Body[BodySettings]
Make = Callable[[], AnyBody]
Session = list[tuple[bytes, float]]
Came = list[tuple[float, bytes]]

ROOM = World(
    (
        Wall(-400.0, -400.0, 400.0, -400.0),
        Wall(400.0, -400.0, 400.0, 400.0),
        Wall(400.0, 400.0, -400.0, 400.0),
        Wall(-400.0, 400.0, -400.0, -400.0),
        Wall(250.0, 150.0, 300.0, 120.0),
    ),
    discs=(Disc(-300.0, 100.0, 30.0),),
)
COMMON: dict[str, st.SearchStrategy[Any]] = {
    "baud": st.sampled_from([None, 9600]),
    "world": st.sampled_from([World(), ROOM]),
    "seed": st.integers(0, 3),
    "slip": st.sampled_from([0.0, 0.05]),
    "noise": st.sampled_from([0.0, 2.0]),
    "sag": st.sampled_from([0.0, 0.0, 0.4]),
    "battery_s": st.just(5.0),
    "boot_s": st.sampled_from([0.0, 0.01]),
    "watchdog_s": st.sampled_from([None, 0.7]),
    "lag_s": st.sampled_from([0.0, 0.15]),
}
CARS = st.builds(
    CarSettings,
    steer_deg_per_s=st.sampled_from([math.inf, 90.0]),
    pen_down=st.booleans(),
    trim_deg=st.sampled_from([0.0, 1.0]),
    **COMMON,
)
FRAME_ROBOTS = st.builds(
    FrameRobotSettings,
    dialect=st.sampled_from([shipped("0.1"), shipped("telemetry")]),
    servo_deg_per_s=st.sampled_from([math.inf, 200.0]),
    **COMMON,
)
PWM = st.integers(0, 255)
SIMPLE = st.one_of(
    [
        st.builds(t, PWM)
        for t in (simple.DriveForward, simple.DriveBackward, simple.SteerLeft, simple.SteerRight)
    ]
    + [st.just(simple.Stop())]
).map(encode)
ENGINE = st.integers(0, 1)
MESSAGES = st.one_of(
    st.builds(EngineForward, ENGINE, PWM),
    st.builds(EngineBackward, ENGINE, PWM),
    st.builds(SetServoPosition, ENGINE, st.integers(0, 180)),
)
WHEEL_MM_PER_S = st.integers(-800, 800)
TELEMETRY = shipped("telemetry")
SPEEDS = st.builds(TELEMETRY["SetWheelSpeeds"], WHEEL_MM_PER_S, WHEEL_MM_PER_S)
FRAMES = st.one_of(
    st.lists(MESSAGES, max_size=3).map(lambda m: b"".join(FrameEncoder(shipped("0.1")).encode(m))),
    SPEEDS.map(lambda m: b"".join(FrameEncoder(TELEMETRY).encode([m]))),
)
PAUSES = st.floats(0.0, 3.0)


def sessions(commands: st.SearchStrategy[bytes]) -> st.SearchStrategy[Session]:
    data = st.lists(st.one_of(commands, commands, st.binary(max_size=3)), max_size=4).map(b"".join)
    return st.lists(st.tuples(data, PAUSES), max_size=4)


ROBOTS = st.one_of(
    st.tuples(CARS.map(lambda s: lambda: SimulatedCar(s)), sessions(SIMPLE)),
    st.tuples(FRAME_ROBOTS.map(lambda s: lambda: SimulatedFrameRobot(s)), sessions(FRAMES)),
)


def in_one_go(robot: AnyBody, until: float) -> Came:
    came = []
    while robot.now < until:
        data = robot.read(until)
        if data:
            came.append((robot.now, data))
    return came


def by_events(robot: AnyBody, until: float) -> Came:
    came = []
    while robot.now < until:
        at = min(robot.next_event(), until)
        assert at >= robot.now
        data = robot.read(at)
        assert robot.now == at
        if data:
            came.append((robot.now, data))
    return came


def in_slices(robot: AnyBody, until: float) -> Came:
    came = []
    while robot.now < until:
        data = robot.read(min(until, robot.now + 0.037))
        if data:
            came.append((robot.now, data))
        # Looking leaves no mark.
        assert robot.trace.pose == robot.pose
    return came


def byte_by_byte(robot: AnyBody, data: bytes) -> None:
    for value in data:
        robot.write(bytes([value]))


def outcome(
    make: Make,
    session: Session,
    wait: Callable[[AnyBody, float], Came],
    write: Callable[[AnyBody, bytes], None] = Body.write,
) -> object:
    """Everything that can be seen of a robot during and after a session."""
    robot = make()
    actions: list[object] = []
    robot.events = actions.append
    came: Came = []
    time_s = 0.0
    for data, pause_s in session:
        write(robot, data)
        time_s += pause_s
        came += wait(robot, time_s)
    assert isinstance(robot, SimulatedCar | SimulatedFrameRobot)
    return actions, came, robot.now, robot.pose, robot.odometer, robot.statistics, robot.trace.strokes


@settings(deadline=None, max_examples=60)
@given(ROBOTS)
def test_nothing_depends_on_how_writing_and_reading_are_cut_up(robot: tuple[Make, Session]) -> None:
    whole = outcome(*robot, in_one_go)
    assert outcome(*robot, by_events) == whole
    assert outcome(*robot, in_slices) == whole
    assert outcome(*robot, in_one_go, byte_by_byte) == whole


def covered_gap(robot: AnyBody, world: World) -> float:
    disc = robot.disc()
    return world.gap(*disc)


@settings(deadline=None, max_examples=60)
@given(ROBOTS)
def test_no_obstacle_is_ever_driven_into(case: tuple[Make, Session]) -> None:
    make, session = case
    robot = make()
    time_s = 0.0
    for data, pause_s in session:
        robot.write(data)
        time_s += pause_s
        while robot.now < time_s:
            robot.read(min(time_s, robot.now + 0.05))
            assert covered_gap(robot, robot.settings.world) > -TOUCH_MM


START = (Pose(-200.0, -200.0, 45.0), Pose(150.0, -200.0, 300.0), Pose(0.0, 180.0, 200.0))


def company(seed: int) -> tuple[SimulatedCar, SimulatedFrameRobot, SimulatedWalter]:
    """One of each kind, close together in one room."""
    car = SimulatedCar(CarSettings(world=ROOM, start=START[0], baud=None, lag_s=0.1, seed=seed, slip=0.02))
    frame = SimulatedFrameRobot(FrameRobotSettings(world=ROOM, start=START[1], baud=None))
    turtle = SimulatedWalter(Settings(world=ROOM, start=START[2], mode=Mode.DIRECT))
    share_world([car, frame, turtle])
    return car, frame, turtle


KEYS = st.sampled_from(
    [walter.StartForward(), walter.StartBackward(), walter.StartLeft(), walter.SetMoveSpeed(255)]
).map(encode_walter)
TOGETHER = st.lists(st.tuples(SIMPLE, FRAMES, KEYS, PAUSES), max_size=5)


@settings(deadline=None, max_examples=40)
@given(TOGETHER, st.integers(0, 3))
def test_robots_in_one_world_never_overlap(
    session: list[tuple[bytes, bytes, bytes, float]], seed: int
) -> None:
    robots = company(seed)
    time_s = 0.0
    for *data, pause_s in session:
        for robot, sent in zip(robots, data, strict=True):
            robot.write(sent)
        time_s += pause_s
        while robots[0].now < time_s:
            robots[0].read(min(time_s, robots[0].now + 0.05))
            assert {robot.now for robot in robots} == {robots[0].now}
            for one, other in itertools.combinations(robots, 2):
                a, b = one.disc(), other.disc()
                assert math.dist(a[:2], b[:2]) - a.radius_mm - b.radius_mm > -0.1
            for robot in robots:
                assert covered_gap(robot, ROOM) > -2.0 * TOUCH_MM


@settings(deadline=None, max_examples=25)
@given(TOGETHER, st.integers(0, 2), st.floats(0.001, 0.2))
def test_in_company_too_nothing_depends_on_who_reads_and_when(
    session: list[tuple[bytes, bytes, bytes, float]], reader: int, slice_s: float
) -> None:
    def seen(wait: Callable[[list[AnyBody], float], None]) -> object:
        robots = company(1)
        time_s = 0.0
        for *data, pause_s in session:
            for robot, sent in zip(robots, data, strict=True):
                robot.write(sent)
            time_s += pause_s
            wait([*robots], time_s)
        return [(robot.pose, robot.odometer, robot.statistics, robot.trace.strokes) for robot in robots]

    def one_reads(robots: list[AnyBody], until: float) -> None:
        in_one_go(robots[0], until)

    def in_turns(robots: list[AnyBody], until: float) -> None:
        turn = itertools.cycle([*robots[reader:], *robots[:reader]])
        while robots[0].now < until:
            next(turn).read(min(until, robots[0].now + slice_s))

    assert seen(in_turns) == seen(one_reads)
