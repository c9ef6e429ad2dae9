"""Fleets: which kernel, what set-points mean, what a bump does; and what importing the simulator costs."""

from __future__ import annotations

import subprocess
import sys

import pytest

from turtlewire.simulator.car import CarSettings
from turtlewire.simulator.fleet import ArrayFleet
from turtlewire.simulator.frame_robot import FrameRobotSettings
from turtlewire.simulator.scalar_fleet import MANY, ScalarFleet, make_fleet
from turtlewire.simulator.settings import Settings
from turtlewire.simulator.walter import SimulatedWalter
from turtlewire.simulator.world import Disc, Wall, World
from turtlewire.turtle import Pose

AHEAD = World((Wall(-9000.0, 500.0, 9000.0, 500.0),), discs=(Disc(0.0, -500.0, 100.0),))
Kernel = type[ScalarFleet] | type[ArrayFleet]
KERNELS = pytest.mark.parametrize("kernel", [ScalarFleet, ArrayFleet])


def test_few_robots_get_the_scalar_kernel_and_many_the_other() -> None:
    assert isinstance(make_fleet([Settings()] * MANY), ScalarFleet)
    assert isinstance(make_fleet([Settings()] * (MANY + 1)), ArrayFleet)


@KERNELS
def test_set_points_are_what_the_wires_carry(kernel: Kernel) -> None:
    fleet = kernel([CarSettings(), FrameRobotSettings(right_factor=0.5), Settings(), Settings()])
    fleet.set_points([140, 130, 100, 0], [0, 130, 0, -90])
    fleet.step(100)
    assert fleet.time_s == pytest.approx(1.0)
    car, frame, walter, turned = fleet.poses()
    assert car == pytest.approx(Pose(0.0, 250.0, 0.0))
    assert frame.heading_deg > 10.0
    assert walter == pytest.approx(Pose(0.0, 100.0, 0.0))
    assert turned == pytest.approx(Pose(0.0, 0.0, 270.0))
    fleet.set_points([0, 0, 999, 0], [0, 0, 0, 0])
    fleet.step(100)
    assert fleet.poses()[0] == car
    assert fleet.poses()[2] == pytest.approx(Pose(0.0, 355.0, 0.0))  # cut at 255


@KERNELS
def test_a_bump_stops_a_walter_and_holds_the_others(kernel: Kernel) -> None:
    places = [Pose(x, 0.0, 0.0) for x in (-3000.0, 0.0, 3000.0)]
    fleet = kernel(
        [
            CarSettings(world=AHEAD, start=places[0]),
            FrameRobotSettings(world=AHEAD, start=places[1]),
            Settings(world=AHEAD, start=places[2]),
        ]
    )
    fleet.set_points([255] * 3, [0, 255, 0])
    fleet.step(300)
    assert fleet.bumpers() == [True, True, True]
    ends = [(-3000.0, 300.0, 0.0), (0.0, 410.0, 0.0), (3000.0, 410.0, 0.0)]
    for pose, end in zip(fleet.poses(), ends, strict=True):
        assert pose == pytest.approx(end, abs=1e-6)
    fleet.step(100)
    assert fleet.poses()[2] == pytest.approx(ends[2], abs=1e-6)
    fleet.set_points([-255, -255, -100], [0, -255, 0])
    fleet.step(20)
    assert fleet.bumpers() == [False, False, False]
    fleet.step(400)
    assert fleet.poses()[1] == pytest.approx((0.0, -310.0, 0.0), abs=1e-6)  # the pillar behind
    assert fleet.bumpers()[1]


def test_arrays_are_there_for_whoever_computes_with_them() -> None:
    fleet = ArrayFleet([Settings(start=Pose(1.0, 2.0, 3.0))] * 2)
    assert fleet.x_mm.tolist() == [1.0, 1.0]
    assert fleet.y_mm.tolist() == [2.0, 2.0]
    assert fleet.heading_deg.tolist() == [3.0, 3.0]
    assert not fleet.bumped.any()


def test_a_crowd_in_an_empty_world_and_outside_of_all_walls() -> None:
    world = World((Wall(0.0, 0.0, 10.0, 0.0),))
    fleet = ArrayFleet([Settings(world=world, start=Pose(0.0, 5000.0, 180.0))] * 3)
    fleet.set_points([100, 255, 100], [0, 0, 30])
    fleet.step(3000)
    assert fleet.poses()[1] == pytest.approx(Pose(0.0, 90.0, 180.0), abs=1e-6)
    assert fleet.poses()[0].y_mm == pytest.approx(2000.0)
    assert fleet.bumpers() == [False, True, False]


def test_thousands_of_walls_are_no_matter() -> None:
    walls = tuple(Wall(100.0 * n, 300.0, 100.0 * n + 50.0, 300.0) for n in range(-1000, 1000))
    fleet = ArrayFleet([Settings(world=World(walls), start=Pose(500.0 * n, 0.0, 0.0)) for n in range(50)])
    fleet.set_points([200] * 50, [0] * 50)
    fleet.step(200)
    assert all(pose.y_mm == pytest.approx(210.0) for pose in fleet.poses())


def test_a_walter_with_an_old_battery_is_slower() -> None:
    robot = SimulatedWalter(Settings(baud=None, sag=0.5, battery_s=10.0))
    robot.write(b"F\x0f\xa0\r")  # 2000 mm at 100 of 255
    while robot.next_event() < float("inf"):
        robot.read(1e6)
    assert robot.now == pytest.approx(1e6)
    robot.write(b"F\x00\xc8\rQP\r")
    start = robot.now
    robot.read(1e9)
    assert robot.now - start == pytest.approx(1.0 / (1.0 - 0.5 * 20.0 * 100.0 / 255.0 / 10.0), rel=1e-6)


@pytest.mark.parametrize("module", ["walter", "car", "company", "scalar_fleet"])
def test_what_one_robot_needs_is_light(module: str) -> None:
    code = f"import sys, turtlewire.simulator.{module}; print(*({{'asyncio', 'numpy'}} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
