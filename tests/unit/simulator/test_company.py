"""One world, many robots: one time for all, and bodies in one another's way."""

from __future__ import annotations

import math
from typing import Any

import pytest

from turtlewire.errors import UsageError
from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import Mode, encode
from turtlewire.simulator.car import CarSettings, SimulatedCar
from turtlewire.simulator.company import find_starts, share_world
from turtlewire.simulator.walter import Settings, SimulatedWalter
from turtlewire.simulator.world import Disc, Wall, World
from turtlewire.turtle import HOME, Pose

NORTH = Pose(0.0, 500.0, 0.0)


def walter(start: Pose | None = None, **settings: Any) -> SimulatedWalter:
    return SimulatedWalter(Settings(baud=None, start=start, **settings))


def car(start: Pose | None = None, **settings: Any) -> SimulatedCar:
    return SimulatedCar(CarSettings(baud=None, start=start, steer_deg_per_s=math.inf, **settings))


def wait(robot: SimulatedWalter | SimulatedCar, until: float) -> bytes:
    came = b""
    while robot.now < until:
        came += robot.read(until)
    return came


def test_what_one_waits_for_all_live_through() -> None:
    one, other = walter(), car(NORTH)
    share_world([one, other])
    other.write(b"B140000")
    one.write(encode(m.Right(90)) + encode(m.QueryHeading()))
    assert one.read(10.0) == encode(m.HeadingReply(90))
    assert other.now == one.now == pytest.approx(0.9)
    assert other.read(0.0) == b"K"  # it has been waiting since 0 s
    # Backwards to where the discs touch: 500 + 80 - 90 - 120 mm of room.
    assert other.pose.y_mm == pytest.approx(500.0 - 0.9 * 250.0)


def test_a_turtle_that_runs_into_another_robot_trips_its_sensor_there() -> None:
    one, other = walter(), walter(NORTH)
    share_world([one, other])
    one.write(encode(m.Forward(2000)))
    assert wait(one, 9.0) == encode(m.LimitFront())
    assert one.pose == pytest.approx(Pose(0.0, 320.0, 0.0), abs=1e-6)
    one.write(encode(m.Forward(20)))
    assert wait(one, 10.0) == encode(m.LimitFront())
    assert one.statistics.refused == 1
    one.write(encode(m.Back(20)))
    assert wait(one, 11.0) == b""
    assert one.pose == pytest.approx(Pose(0.0, 310.0, 0.0), abs=1e-6)


def test_who_drives_off_in_time_is_not_met() -> None:
    one, other = walter(), walter(NORTH, speed=200)
    share_world([one, other])
    one.write(encode(m.Forward(1200)))
    other.write(encode(m.Forward(1400)))
    assert wait(one, 9.0) == b""
    assert one.pose == pytest.approx(Pose(0.0, 600.0, 0.0))
    assert other.pose == pytest.approx(Pose(0.0, 1200.0, 0.0))


def test_a_car_is_held_by_a_robot_and_goes_on_when_that_has_left() -> None:
    one, other = car(), walter(Pose(0.0, 500.0, 90.0))
    share_world([one, other])
    one.write(b"F140000")
    wait(one, 3.0)
    assert one.pose == pytest.approx(Pose(0.0, 500.0 - 90.0 - 120.0 - 80.0, 0.0), abs=1e-6)
    assert one.bumper == "front"
    other.write(encode(m.Forward(1000)))
    wait(one, 9.0)
    assert str(one.bumper) == "None"
    assert one.pose.y_mm > 800.0
    assert one.statistics.bumps < 10  # it brushes along what leaves, and is not counted at every step


def test_two_that_meet_head_on_both_stop() -> None:
    one, other = car(), car(Pose(0.0, 900.0, 180.0))
    share_world([one, other])
    for robot in (one, other):
        robot.write(b"F140000")
    wait(other, 5.0)
    gap = math.dist(one.disc()[:2], other.disc()[:2]) - 240.0
    assert gap == pytest.approx(0.0, abs=0.1)
    assert (one.bumper, other.bumper) == ("front", "front")
    assert one.pose.y_mm == pytest.approx(900.0 - other.pose.y_mm, abs=5.0)


def test_ghosts_drive_through_one_another_but_not_through_walls() -> None:
    wall = World((Wall(-500.0, 800.0, 500.0, 800.0),))
    one, other = walter(world=wall), walter(NORTH, world=wall)
    share_world([one, other], solid=False)
    one.write(encode(m.Forward(4000)))
    assert wait(other, 20.0) == b""
    assert one.read(0.0) == encode(m.LimitFront())
    assert one.pose.y_mm == pytest.approx(710.0)


def test_endless_motion_in_company_stops_in_time() -> None:
    one, other = walter(mode=Mode.DIRECT), walter(NORTH)
    share_world([one, other])
    one.write(b"A")
    assert wait(one, 2.0) == b""
    one.write(b"G\xff")  # faster, on the way
    assert wait(one, 9.0) == encode(m.LimitFront())
    assert one.pose.y_mm == pytest.approx(320.0)


def test_who_cannot_share_a_world() -> None:
    far = Pose(0.0, 2000.0, 0.0)
    with pytest.raises(UsageError, match="robot 2 is in another world than robot 1"):
        share_world([walter(), walter(far, world=World((Wall(5000.0, 0.0, 5000.0, 1.0),)))])
    late = walter(far)
    late.read(1.0)
    with pytest.raises(UsageError, match="robot 2 has lived already"):
        share_world([walter(), late])
    taken = [walter(), walter(far)]
    share_world(taken)
    with pytest.raises(UsageError, match="robot 1 has lived already"):
        share_world(taken)
    with pytest.raises(UsageError, match="robots 1 and 3 overlap at their starts, by 30 mm"):
        share_world([walter(), walter(far), walter(Pose(150.0, 0.0, 0.0))])
    share_world([walter(), walter()], solid=False)
    same = walter()
    with pytest.raises(UsageError, match="twice"):
        share_world([same, same])


def places(*robots: SimulatedWalter | SimulatedCar, spacing_mm: float = 500.0) -> list[tuple[float, ...]]:
    return [robot.settings.first_pose for robot in find_starts(robots, spacing_mm)]


def test_robots_get_the_starts_of_their_world_and_then_the_places_around_the_first() -> None:
    world = World((), Pose(10.0, 20.0, 30.0), more_starts=(Pose(1000.0, 0.0, 90.0),))
    assert places(*(walter(world=world) for _ in range(6))) == [
        (10.0, 20.0, 30.0),
        (1000.0, 0.0, 90.0),
        (510.0, 20.0, 30.0),
        (-490.0, 20.0, 30.0),
        (510.0, 520.0, 30.0),
        (510.0, -480.0, 30.0),
    ]


def test_a_start_of_its_own_stays_and_is_taken() -> None:
    assert places(walter(), walter(Pose(500.0, 50.0, 7.0)), walter()) == [
        HOME,
        (500.0, 50.0, 7.0),
        (-500, 0, 0),
    ]
    # The own start comes first, wherever its robot stands in the row.
    assert places(walter(), walter(Pose(0.0, 100.0, 0.0)))[0] == (500.0, 0.0, 0.0)


def test_a_hundred_robots_have_room_and_keep_their_kind_and_settings() -> None:
    robots = [car(seed=n) if n % 2 else walter(seed=n) for n in range(100)]
    found = find_starts(robots, 300.0)
    share_world(found)  # complains of any that overlap
    assert [(type(robot), robot.settings.seed) for robot in found] == [
        (type(robot), robot.settings.seed) for robot in robots
    ]


def test_nobody_starts_in_a_wall_or_beyond_it() -> None:
    # A room of 1200 mm with a pillar to the right: three more places in it, 400 mm apart, and none outside.
    corners = [(-600.0, -200.0), (600.0, -200.0), (600.0, 600.0), (-600.0, 600.0)]
    walls = tuple(Wall(*a, *b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))
    room = World(walls, discs=(Disc(400.0, 0.0, 30.0),))
    robots = [walter(world=room) for _ in range(4)]
    assert places(*robots, spacing_mm=400.0) == [HOME, (-400, 0, 0), (400, 400, 0), (0, 400, 0)]
    with pytest.raises(UsageError, match="no room for robot 6 in this arena"):
        find_starts([*robots, walter(world=room), walter(world=room)], 400.0)


def test_a_start_that_the_world_names_must_be_free() -> None:
    world = World((Wall(900.0, -50.0, 900.0, 50.0),), more_starts=(Pose(900.0, 0.0, 0.0),))
    with pytest.raises(UsageError, match="does not fit at its start, x 900 mm"):
        find_starts([walter(world=world), walter(world=world)], 500.0)
