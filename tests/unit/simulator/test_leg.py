from __future__ import annotations

import math

import pytest

from turtlewire.simulator.car import CarSettings
from turtlewire.simulator.chassis import Wheels
from turtlewire.simulator.leg import Leg, free_s
from turtlewire.simulator.world import Wall, World
from turtlewire.turtle import HOME

SETTINGS = CarSettings(radius_mm=100.0, track_mm=130.0, wheelbase_mm=200.0)
AHEAD = World((Wall(-1000.0, 500.0, 1000.0, 500.0),))


@pytest.mark.parametrize(
    ("wheels", "seconds"),
    [
        (Wheels(100.0, 100.0), 3.0),  # 300 mm of room before the disc
        (Wheels(-100.0, -100.0), 3.0),
        (Wheels(65.0, -65.0), 3.0),  # turning, the disc's middle goes round at 100 mm/s
        (Wheels(165.0, 35.0), 1.5),
        (Wheels(0.0, 0.0), math.inf),
    ],
)
def test_how_long_nothing_can_be_met(wheels: Wheels, seconds: float) -> None:
    assert free_s(SETTINGS, HOME, wheels, AHEAD) == pytest.approx(seconds)
    assert free_s(SETTINGS, HOME, wheels, World()) == math.inf


def test_a_leg_ends_where_the_disc_touches() -> None:
    leg = Leg(SETTINGS, HOME, Wheels(1000.0, 1000.0), 0.5, AHEAD)
    assert leg.contact is not None
    assert leg.seconds == pytest.approx(0.3)
    assert leg.pose(leg.seconds) == pytest.approx((0.0, 300.0, 0.0))
    held = Leg(SETTINGS, leg.pose(leg.seconds), Wheels(1000.0, 1000.0), 0.5, AHEAD, pivots=False)
    assert held.held_by is not None
    assert held.ground == (0.0, 0.0)
    assert held.pose(0.2) == held.start
