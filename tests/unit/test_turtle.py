"""Poses, headings and arcs; and what every turtle inherits."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from turtlewire import turtle
from turtlewire.turtle import (
    ARC_SAGITTA_MM,
    HOME,
    Pose,
    Turtle,
    arc_polygon,
    arc_tangent,
    direction,
    wrapped,
)

angles = st.floats(-1e4, 1e4)


class Plain(Turtle):
    """A turtle that does exactly what it is told and notes where it draws."""

    def __init__(self) -> None:
        self.here = HOME
        self.down = True
        self.drawn: list[tuple[Pose, Pose]] = []
        self.sheets = 0

    def forward(self, distance_mm: float) -> None:
        self._go(self.here.moved(distance_mm))

    def right(self, angle_deg: float) -> None:
        self.here = self.here.turned(angle_deg)

    def set_position(self, x_mm: float, y_mm: float) -> None:
        self._go(Pose(x_mm, y_mm, self.here.heading_deg))

    def _go(self, there: Pose) -> None:
        if self.down:
            self.drawn.append((self.here, there))
        self.here = there

    def set_heading(self, heading_deg: float) -> None:
        self.here = self.here._replace(heading_deg=heading_deg % 360.0)

    def home(self) -> None:
        self._go(HOME)

    @property
    def pose(self) -> Pose:
        return self.here

    def pen_up(self) -> None:
        self.down = False

    def pen_down(self) -> None:
        self.down = True

    @property
    def is_pen_down(self) -> bool:
        return self.down

    def clean(self) -> None:
        self.sheets += 1
        self.drawn.clear()

    def set_speed(self, speed: int) -> None: ...
    def horn(self, tone: str) -> None: ...
    def lamp(self, on: bool) -> None: ...
    def wait(self, seconds: float) -> None: ...
    def finish(self) -> None: ...
    def stop(self) -> None: ...
    def set_step_by_step(self, on: bool) -> None: ...


@pytest.mark.parametrize(
    ("heading", "ahead"),
    [(0, (0, 1)), (90, (1, 0)), (180, (0, -1)), (270, (-1, 0)), (360, (0, 1)), (-90, (-1, 0)), (450, (1, 0))],
)
def test_right_angles_are_exact(heading: float, ahead: tuple[float, float]) -> None:
    assert direction(heading) == ahead


@given(angles)
def test_a_direction_is_a_unit_vector_clockwise_from_up(heading: float) -> None:
    dx, dy = direction(heading)
    assert math.hypot(dx, dy) == pytest.approx(1.0)
    assert abs(wrapped(math.degrees(math.atan2(dx, dy)) - heading)) < 1e-6


def test_few_directions_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(turtle, "_DIRECTIONS_KEPT", 3)
    first = direction(0.5)
    assert direction(0.5) is first
    for tenth in range(40):
        direction(tenth / 10)
    assert direction(0.5) == first
    assert direction(0.5) is not first


@given(angles)
def test_wrapped(angle: float) -> None:
    assert -180.0 < wrapped(angle) <= 180.0
    assert (wrapped(angle) - angle) / 360.0 == pytest.approx(
        round((wrapped(angle) - angle) / 360.0), abs=1e-9
    )
    assert (wrapped(180), wrapped(-180), wrapped(181), wrapped(540)) == (180, 180, -179, 180)


def test_poses() -> None:
    assert HOME.moved(10) == Pose(0, 10, 0)
    assert HOME.turned(90).moved(-10) == Pose(-10, 0, 90)
    assert HOME.turned(-90).heading_deg == 270
    assert HOME.distance_to(3, 4) == 5
    bearings = [HOME.bearing_to(x, y) for x, y in ((0, 0), (0, 1), (1, 0), (0, -1), (-1, 0), (1, 1))]
    assert bearings == [0, 0, 90, 180, 270, 45]


@given(
    st.floats(-400.0, 400.0).filter(lambda a: abs(a) > 1e-3),
    st.floats(-5000.0, 5000.0).filter(lambda r: abs(r) > 0.01),
)
def test_the_sides_of_an_arc_stay_near_the_circle(angle: float, radius: float) -> None:
    sides, chord, turn = arc_polygon(angle, radius)
    swept = math.radians(abs(turn))
    assert sides * turn == pytest.approx(max(-360.0, min(360.0, angle)))
    assert chord == pytest.approx(2 * abs(radius) * math.sin(swept / 2))
    assert abs(radius) * (1 - math.cos(swept / 2)) <= ARC_SAGITTA_MM * 1.001
    # One side less would not do, unless the turns would be too coarse.
    if sides > 1:
        coarser = math.radians(min(360.0, abs(angle)) / (sides - 1))
        assert abs(radius) * (1 - math.cos(coarser / 2)) > ARC_SAGITTA_MM * 0.999 or coarser > math.radians(
            119
        )


@pytest.mark.parametrize(("angle", "radius"), [(0, 10), (10, 0), (0, 0)])
def test_no_arc(angle: float, radius: float) -> None:
    assert arc_polygon(angle, radius) == (0, 0.0, 0.0)
    turtle = Plain()
    turtle.arc(angle, radius)
    assert turtle.drawn == []


@pytest.mark.parametrize(("angle", "radius"), [(90, 50), (-90, 50), (90, -50), (-720, 50)])
@pytest.mark.parametrize("down", [True, False])
def test_an_arc_is_drawn_around_the_turtle(angle: float, radius: float, down: bool) -> None:
    turtle = Plain()
    turtle.set_heading(30)
    turtle.forward(5)
    turtle.drawn.clear()
    turtle.down = down
    start = turtle.pose
    turtle.arc(angle, radius)
    assert turtle.pose == start
    assert turtle.is_pen_down == down
    assert bool(turtle.drawn) == down
    if down:
        for _, end in turtle.drawn:
            assert start.distance_to(end.x_mm, end.y_mm) == pytest.approx(50.0)
        first, last = turtle.drawn[0][0], turtle.drawn[-1][1]
        began = start.bearing_to(first.x_mm, first.y_mm)
        ended = start.bearing_to(last.x_mm, last.y_mm)
        assert abs(wrapped(began - (30 if radius > 0 else 210))) < 1e-6
        assert abs(wrapped(ended - began - angle)) < 1e-6
    assert arc_tangent(angle, radius) == math.copysign(90, angle * radius)


def test_what_every_turtle_inherits() -> None:
    turtle = Plain()
    turtle.back(10)
    turtle.left(90)
    assert turtle.pose == Pose(0, -10, 270)
    turtle.set_x(5)
    turtle.set_y(6)
    assert turtle.pose == Pose(5, 6, 270)
    assert turtle.towards(5, 7) == 0


@pytest.mark.parametrize("down", [True, False])
def test_clear_screen_goes_home_without_drawing(down: bool) -> None:
    turtle = Plain()
    turtle.clear_screen()
    assert turtle.sheets == 1
    turtle.forward(10)
    turtle.down = down
    turtle.clear_screen()
    assert turtle.pose == HOME
    assert turtle.is_pen_down == down
    assert turtle.sheets == 2
    assert turtle.drawn == []
