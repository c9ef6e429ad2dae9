"""The two kernels of a fleet, and the robots over their wires: they must all come to the same."""

from __future__ import annotations

import math
import random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from turtlewire.errors import UsageError
from turtlewire.protocols.frame.codec import FrameEncoder
from turtlewire.protocols.frame.dialect import shipped
from turtlewire.protocols.frame.messages import EngineBackward, EngineForward
from turtlewire.protocols.walter.codec import Mode
from turtlewire.simulator.car import CarSettings, SimulatedCar
from turtlewire.simulator.fleet import ArrayFleet
from turtlewire.simulator.frame_robot import FrameRobotSettings, SimulatedFrameRobot
from turtlewire.simulator.scalar_fleet import AnySettings, ScalarFleet
from turtlewire.simulator.settings import Settings
from turtlewire.simulator.walter import SimulatedWalter
from turtlewire.simulator.world import TOUCH_MM, Disc, Wall, World
from turtlewire.turtle import Pose

SIDE = 900.0
CORNERS = [(-SIDE, -SIDE), (SIDE, -SIDE), (SIDE, SIDE), (-SIDE, SIDE)]
ROOM = World(
    (
        *(Wall(*one, *other) for one, other in zip(CORNERS, CORNERS[1:] + CORNERS[:1], strict=True)),
        Wall(-300.0, 200.0, 250.0, 320.0),
        Wall(500.0, -700.0, 520.0, -100.0),
    ),
    discs=(Disc(-400.0, -350.0, 60.0), Disc(300.0, 650.0, 0.5)),
)
PWM = st.integers(-255, 255)
KINDS: tuple[Any, ...] = (
    st.builds(
        CarSettings,
        world=st.just(ROOM),
        lag_s=st.sampled_from([0.0, 0.2]),
        coast_s=st.sampled_from([None, 0.0, 0.4]),
        backward_factor=st.sampled_from([1.0, 0.8]),
        steer_deg_per_s=st.sampled_from([math.inf, 60.0]),
        trim_deg=st.sampled_from([0.0, -2.0]),
        sag=st.sampled_from([0.0, 0.3]),
        battery_s=st.just(3.0),
    ),
    st.builds(
        FrameRobotSettings,
        world=st.just(ROOM),
        lag_s=st.sampled_from([0.0, 0.2]),
        coast_s=st.sampled_from([None, 0.0, 0.4]),
        backward_factor=st.sampled_from([1.0, 0.8]),
        right_factor=st.sampled_from([1.0, 0.9]),
        sag=st.sampled_from([0.0, 0.3]),
        battery_s=st.just(3.0),
    ),
    st.builds(Settings, world=st.just(ROOM), sag=st.sampled_from([0.0, 0.3]), battery_s=st.just(3.0)),
)


@st.composite
def crowds(draw: st.DrawFn) -> list[AnySettings]:
    chance = random.Random(draw(st.integers(0, 10_000)))
    robots: list[AnySettings] = []
    for kind in draw(st.lists(st.sampled_from(KINDS), min_size=1, max_size=6)):
        robot = draw(kind)
        while True:
            place = Pose(chance.uniform(-SIDE, SIDE), chance.uniform(-SIDE, SIDE), chance.uniform(0.0, 360.0))
            middle = place.moved(robot.offset_mm)
            if ROOM.gap(middle.x_mm, middle.y_mm, robot.radius_mm) > 1.0:
                break
        values = {name: getattr(robot, name) for name in robot.__dataclass_fields__}
        robots.append(type(robot)(**{**values, "start": place}))
    return robots


def assert_same(one: list[Pose], other: list[Pose], tolerance: float = 1e-5) -> None:
    for a, b in zip(one, other, strict=True):
        assert math.dist(a[:2], b[:2]) < tolerance
        assert abs((a.heading_deg - b.heading_deg + 180.0) % 360.0 - 180.0) < tolerance


@settings(deadline=None, max_examples=30)
@given(crowds(), st.data())
def test_the_two_kernels_agree(robots: list[AnySettings], data: st.DataObject) -> None:
    scalar, array = ScalarFleet(robots), ArrayFleet(robots)
    count = len(robots)
    for _ in range(data.draw(st.integers(1, 4))):
        first, second = (data.draw(st.lists(PWM, min_size=count, max_size=count)) for _ in range(2))
        scalar.set_points(first, second)
        array.set_points(first, second)
        for _ in range(5):
            scalar.step(10)
            array.step(10)
            assert_same(scalar.poses(), array.poses())
            assert scalar.bumpers() == array.bumpers()
            for robot, pose in zip(robots, array.poses(), strict=True):
                middle = pose.moved(robot.offset_mm)
                assert ROOM.gap(middle.x_mm, middle.y_mm, robot.radius_mm) > -TOUCH_MM
    assert scalar.time_s == array.time_s


def simple_bytes(drive: int, steer: int) -> bytes:
    return f"{'FB'[drive < 0]}{abs(drive):03}000{'RL'[steer < 0]}{abs(steer):03}000".encode()


@settings(deadline=None, max_examples=25)
@given(crowds(), PWM, PWM)
def test_a_fleet_is_what_its_robots_are_over_their_wires(
    robots: list[AnySettings], first: int, second: int
) -> None:
    wired: list[SimulatedCar | SimulatedFrameRobot | SimulatedWalter] = []
    firsts, seconds = [], []
    for robot in robots:
        told = first, second
        values = {name: getattr(robot, name) for name in robot.__dataclass_fields__} | {"baud": None}
        match robot:
            case CarSettings():
                car = SimulatedCar(CarSettings(**values))
                car.write(simple_bytes(first, second))
                wired.append(car)
            case FrameRobotSettings():
                twin = SimulatedFrameRobot(FrameRobotSettings(**values))
                messages = [
                    EngineForward(n, s) if s >= 0 else EngineBackward(n, -s)
                    for n, s in enumerate((first, second))
                ]
                twin.write(b"".join(FrameEncoder(shipped("0.1")).encode(messages)))
                wired.append(twin)
            case Settings():
                # A WALTER has its battery's strength from the start of each motion.
                values |= {"mode": Mode.DIRECT, "sag": 0.0}
                walter = SimulatedWalter(Settings(**values))
                walter.write(b"G" + bytes([abs(first)]) + (b"A" if first >= 0 else b"Z"))
                wired.append(walter)
                told = first, 0
        firsts.append(told[0])
        seconds.append(told[1])
    fleet = ArrayFleet(
        [
            Settings(world=ROOM, start=robot.start) if isinstance(robot, Settings) else robot
            for robot in robots
        ]
    )
    fleet.set_points(firsts, seconds)
    for seconds_later in (0.5, 1.0, 2.0):
        fleet.step(round((seconds_later - fleet.time_s) * 100.0))
        for body in wired:
            while body.now < seconds_later:
                body.read(seconds_later)
        assert_same([body.pose for body in wired], fleet.poses())


def test_slip_and_noise_have_the_same_statistics_in_both_kernels() -> None:
    robots = [CarSettings(seed=n, slip=0.2, noise=5.0) for n in range(200)]
    ways = []
    for fleet in (ScalarFleet(robots), ArrayFleet(robots)):
        fleet.set_points([255.0] * 200, [0.0] * 200)
        fleet.step(300)
        ways.append(fleet.poses())
    for number in range(2):
        means = [sum(pose[number] for pose in poses) / 200.0 for poses in ways]
        spreads = [
            math.sqrt(sum((pose[number] - mean) ** 2 for pose in poses) / 200.0)
            for poses, mean in zip(ways, means, strict=True)
        ]
        assert means[0] == pytest.approx(means[1], abs=0.4 * spreads[0])
        assert spreads[0] == pytest.approx(spreads[1], rel=0.4)
        assert spreads[0] > 5.0


def test_robots_of_two_worlds_are_no_fleet() -> None:
    for kernel in (ScalarFleet, ArrayFleet):
        with pytest.raises(UsageError, match="same world"):
            kernel([Settings(), Settings(world=ROOM, start=Pose())])
        with pytest.raises(UsageError, match="at least one"):
            kernel([])
