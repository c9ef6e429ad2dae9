from __future__ import annotations

import pytest

from turtlewire.errors import MessageError
from turtlewire.logo import ScreenTurtle
from turtlewire.turtle import Pose


def test_it_records_what_it_draws() -> None:
    turtle = ScreenTurtle()
    turtle.forward(10)
    turtle.right(90)
    turtle.pen_up()
    turtle.back(5)
    turtle.pen_down()
    turtle.set_position(1, 2)
    turtle.set_heading(-90)
    assert turtle.pose == Pose(1, 2, 270)
    assert [(s.pen_down, s.points) for s in turtle.trace.strokes] == [
        (True, [(0, 0), (0, 10)]),
        (False, [(0, 10), (-5, 10)]),
        (True, [(-5, 10), (1, 2)]),
    ]
    turtle.home()
    turtle.clean()
    assert turtle.trace.strokes == []
    assert turtle.pose == Pose()


def test_it_keeps_what_it_is_told() -> None:
    turtle = ScreenTurtle()
    turtle.wait(0.5)
    turtle.wait(1)
    turtle.set_speed(7)
    turtle.horn("high")
    turtle.lamp(on=True)
    turtle.set_step_by_step(on=True)
    turtle.finish()
    turtle.stop()
    assert (turtle.elapsed_s, turtle.speed, turtle.tone) == (1.5, 7, "high")
    assert turtle.is_lamp_on
    assert turtle.is_step_by_step


def test_what_no_turtle_can_do() -> None:
    turtle = ScreenTurtle()
    with pytest.raises(MessageError):
        turtle.set_speed(0)
    with pytest.raises(MessageError):
        turtle.horn("loud")
