"""How fast something moves, by where it was."""

from __future__ import annotations

import pytest

from turtlewire.helm.speedometer import Speedometer
from turtlewire.turtle import HOME, Pose


def test_ahead_back_and_turning() -> None:
    for rate in (100.0, -100.0):
        meter, pose = Speedometer(), Pose(0.0, 0.0, 30.0)
        for n in range(20):
            meter.at(pose.moved(rate * n * 0.08), n * 0.08)
        assert meter.speed_mm_per_s == pytest.approx(rate)
        assert meter.turn_deg_per_s == 0.0
    meter = Speedometer()
    for n in range(20):
        meter.at(Pose(0.0, 0.0, (350.0 + n * 0.08 * 90.0) % 360.0), n * 0.08)
    assert meter.turn_deg_per_s == pytest.approx(90.0)
    assert meter.speed_mm_per_s == 0.0


def test_it_stands_as_soon_as_it_stands_and_soon_has_its_speed() -> None:
    meter = Speedometer()
    meter.at(HOME, 0.0)
    assert meter.speed_mm_per_s == 0.0
    for n in range(1, 20):
        meter.at(Pose(0.0, 8.0 * n), n * 0.08)
    assert meter.speed_mm_per_s == pytest.approx(100.0)
    meter.at(Pose(0.0, 8.0 * 19), 20 * 0.08)
    assert meter.speed_mm_per_s == 0.0
    for n in range(1, 6):
        meter.at(Pose(0.0, 8.0 * 19 + 16.0 * n), (20 + n) * 0.08)
    assert meter.speed_mm_per_s == pytest.approx(200.0, rel=0.05)
    meter.at(Pose(0.0, 9999.0), 25 * 0.08)  # at the same time
    assert len(meter._poses) < 8
