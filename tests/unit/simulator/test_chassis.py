from __future__ import annotations

import math
import statistics

import pytest

from turtlewire.simulator.chassis import Chassis, Wheels, chords, drive
from turtlewire.turtle import HOME, Pose

TRACK_MM = 100.0


def test_equal_wheels_drive_straight() -> None:
    assert drive(Pose(1.0, 2.0, 90.0), Wheels(50.0, 50.0), TRACK_MM) == Pose(51.0, 2.0, 90.0)
    assert drive(Pose(1.0, 2.0, 90.0), Wheels(-50.0, -50.0), TRACK_MM) == Pose(-49.0, 2.0, 90.0)


def test_opposite_wheels_turn_on_the_spot_clockwise_when_the_left_one_goes_ahead() -> None:
    quarter = TRACK_MM * math.pi / 4.0
    assert drive(Pose(3.0, 4.0, 10.0), Wheels(quarter, -quarter), TRACK_MM) == Pose(3.0, 4.0, 100.0)
    assert drive(Pose(3.0, 4.0, 10.0), Wheels(-quarter, quarter), TRACK_MM) == Pose(3.0, 4.0, 280.0)


def test_one_wheel_at_rest_is_the_centre_of_an_arc() -> None:
    half_circle = TRACK_MM * math.pi
    pose = drive(HOME, Wheels(half_circle, 0.0), TRACK_MM)
    assert pose == pytest.approx(Pose(TRACK_MM, 0.0, 180.0))
    pose = drive(HOME, Wheels(half_circle / 2.0, 0.0), TRACK_MM)
    assert pose == pytest.approx(Pose(TRACK_MM / 2.0, TRACK_MM / 2.0, 90.0))
    pose = drive(HOME, Wheels(0.0, -half_circle / 2.0), TRACK_MM)
    assert pose == pytest.approx(Pose(-TRACK_MM / 2.0, -TRACK_MM / 2.0, 90.0))


def test_an_arc_in_pieces_ends_where_the_whole_one_does() -> None:
    pose = whole = Pose(10.0, 20.0, 33.0)
    for _ in range(7):
        pose = drive(pose, Wheels(30.0, 22.0), TRACK_MM)
    whole = drive(whole, Wheels(210.0, 154.0), TRACK_MM)
    assert pose == pytest.approx(whole, abs=1e-6)


def test_the_smallest_difference_there_is_is_no_turn() -> None:
    assert drive(HOME, Wheels(0.0, 5e-324), TRACK_MM) == HOME


def test_headings_stay_whole_over_many_turns() -> None:
    chassis, pose = Chassis(90.0, TRACK_MM), HOME
    for _ in range(1000):
        pose = drive(pose, chassis.turning(123.0), TRACK_MM)
    assert pose.heading_deg == 123_000 % 360


def test_a_heading_just_below_a_whole_turn_is_zero() -> None:
    assert drive(Pose(0.0, 0.0, 359.9999999999), Wheels(1e-14, -1e-14), TRACK_MM).heading_deg == 0.0


def test_chords_stay_as_near_to_the_arc_as_they_must() -> None:
    wheels = Wheels(1000.0, 900.0)
    pieces = chords(wheels, TRACK_MM, 0.1)
    radius, angle = 950.0, 1.0
    assert radius * (1.0 - math.cos(angle / pieces / 2.0)) <= 0.1
    assert radius * (1.0 - math.cos(angle / (pieces - 1) / 2.0)) > 0.1


@pytest.mark.parametrize("wheels", [Wheels(500.0, 500.0), Wheels(500.0, -500.0), Wheels(0.0, 0.0)])
def test_a_straight_line_and_a_turn_on_the_spot_are_one_chord(wheels: Wheels) -> None:
    assert chords(wheels, TRACK_MM, 0.1) == 1


def test_a_tight_arc_is_not_cut_short_by_its_own_circle() -> None:
    assert chords(Wheels(TRACK_MM * math.pi * 2.0, 0.0), TRACK_MM, 1000.0) == 4


def test_ideal_wheels_do_what_they_are_told() -> None:
    chassis = Chassis(90.0, TRACK_MM)
    assert chassis.is_ideal
    assert chassis.travel(Wheels(12.5, -3.0)) == (Wheels(12.5, -3.0), Wheels(12.5, -3.0))


def test_slip_loses_up_to_its_fraction_of_ground_and_none_of_the_wheels_travel() -> None:
    chassis = Chassis(90.0, TRACK_MM, slip=0.02)
    assert not chassis.is_ideal
    lost = []
    for _ in range(500):
        turned, ground = chassis.travel(Wheels(100.0, -100.0))
        assert turned == Wheels(100.0, -100.0)
        lost += [100.0 - ground.left_mm, 100.0 + ground.right_mm]
    assert 0.0 <= min(lost) < 0.1
    assert 1.9 < max(lost) < 2.0
    assert statistics.mean(lost) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(("distance_mm", "spread_mm"), [(1000.0, 3.0), (250.0, 1.5), (-4000.0, 6.0)])
def test_noise_grows_with_the_square_root_of_the_distance(distance_mm: float, spread_mm: float) -> None:
    chassis = Chassis(90.0, TRACK_MM, noise_mm=3.0)
    turned: list[float] = []
    for _ in range(2000):
        travel = chassis.travel(Wheels(distance_mm, distance_mm))
        assert travel.turned == travel.ground
        turned += travel.turned
    assert statistics.mean(turned) == pytest.approx(distance_mm, abs=0.3)
    assert statistics.stdev(turned) == pytest.approx(spread_mm, rel=0.05)


def test_noise_never_turns_a_wheel_the_other_way() -> None:
    chassis = Chassis(90.0, TRACK_MM, noise_mm=50.0)
    travels = [chassis.travel(Wheels(0.5, -0.5)).turned for _ in range(200)]
    assert min(t.left_mm for t in travels) == 0.0
    assert max(t.right_mm for t in travels) == 0.0


def test_the_same_seed_gives_the_same_wheels() -> None:
    def travels(seed: int) -> list[object]:
        chassis = Chassis(90.0, TRACK_MM, 0.1, 1.0, seed)
        return [chassis.travel(Wheels(100.0, 100.0)) for _ in range(5)]

    assert travels(1) == travels(1) != travels(2)
