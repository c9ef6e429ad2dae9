"""Turtle graphics: one turtle step is ``step_mm`` millimetres on the robot."""

from __future__ import annotations

import math

from turtlewire.logo.primitives.inputs import answer, finite, point
from turtlewire.logo.procedures import BadInputError, Chapter
from turtlewire.logo.values import Number, Value, make_list, narrowed

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.evaluator import Interpreter

chapter = Chapter()
primitive = chapter.primitive

_EXACT = 1e15
_FAR = 1e200  # up to here nothing can become infinite
_PLAIN_NUMBERS = frozenset((int, float))


def _millimetres(logo: Interpreter, steps: Value) -> float:
    if type(steps) in _PLAIN_NUMBERS and -_FAR < steps < _FAR:  # type: ignore[operator]
        return steps * logo.step_mm  # type: ignore[operator]
    distance = narrowed(finite(steps)) * logo.step_mm
    if math.isinf(distance):
        raise BadInputError(steps)
    return distance


def _whole_if_exact(value: float) -> Number:
    return int(value) if value.is_integer() and abs(value) < _EXACT else value


def _coordinate(logo: Interpreter, millimetres: float) -> Number:
    """A coordinate in turtle steps, to six decimals as in UCBLogo: the noise of sines and cosines is not to be seen."""
    return _whole_if_exact(round(millimetres / logo.step_mm, 6))


def _degrees(angle: Value) -> float:
    if type(angle) in _PLAIN_NUMBERS and -_FAR < angle < _FAR:  # type: ignore[operator]
        return float(angle)  # type: ignore[arg-type]
    return float(narrowed(finite(angle)))


def _place(logo: Interpreter, a: Value, b: Value | None) -> tuple[float, float]:
    """A point, in millimetres: from a list of two numbers, or from two numbers."""
    if b is None:
        x, y = point(a)
        if not (math.isfinite(x * logo.step_mm) and math.isfinite(y * logo.step_mm)):
            raise BadInputError(a)
        return x * logo.step_mm, y * logo.step_mm
    return _millimetres(logo, a), _millimetres(logo, b)


@primitive("forward fd", 1)
def _forward(logo: Interpreter, steps: Value) -> None:
    logo.turtle.forward(_millimetres(logo, steps))


@primitive("back bk", 1)
def _back(logo: Interpreter, steps: Value) -> None:
    logo.turtle.back(_millimetres(logo, steps))


@primitive("left lt", 1)
def _left(logo: Interpreter, angle: Value) -> None:
    logo.turtle.left(_degrees(angle))


@primitive("right rt", 1)
def _right(logo: Interpreter, angle: Value) -> None:
    logo.turtle.right(_degrees(angle))


@primitive("setpos", 1, maximum=2)
def _setpos(logo: Interpreter, a: Value, b: Value | None = None) -> None:
    logo.turtle.set_position(*_place(logo, a, b))


@primitive("setxy", 2)
def _setxy(logo: Interpreter, x: Value, y: Value) -> None:
    logo.turtle.set_position(*_place(logo, x, y))


@primitive("setx", 1)
def _setx(logo: Interpreter, x: Value) -> None:
    logo.turtle.set_x(_millimetres(logo, x))


@primitive("sety", 1)
def _sety(logo: Interpreter, y: Value) -> None:
    logo.turtle.set_y(_millimetres(logo, y))


@primitive("setheading seth", 1)
def _setheading(logo: Interpreter, angle: Value) -> None:
    logo.turtle.set_heading(_degrees(angle))


@primitive("home", 0)
def _home(logo: Interpreter) -> None:
    logo.turtle.home()


@primitive("arc", 2)
def _arc(logo: Interpreter, angle: Value, radius: Value) -> None:
    logo.turtle.arc(_degrees(angle), _millimetres(logo, radius))


@primitive("pos", 0)
def _pos(logo: Interpreter) -> Value:
    pose = logo.turtle.pose
    return make_list((_coordinate(logo, pose.x_mm), _coordinate(logo, pose.y_mm)))


@primitive("xcor", 0)
def _xcor(logo: Interpreter) -> Value:
    return _coordinate(logo, logo.turtle.pose.x_mm)


@primitive("ycor", 0)
def _ycor(logo: Interpreter) -> Value:
    return _coordinate(logo, logo.turtle.pose.y_mm)


@primitive("heading", 0)
def _heading(logo: Interpreter) -> Value:
    return _whole_if_exact(logo.turtle.pose.heading_deg)


@primitive("towards", 1, maximum=2)
def _towards(logo: Interpreter, a: Value, b: Value | None = None) -> Value:
    return _whole_if_exact(logo.turtle.towards(*_place(logo, a, b)))


@primitive("distance", 1, maximum=2)
def _distance(logo: Interpreter, a: Value, b: Value | None = None) -> Value:
    return _whole_if_exact(logo.turtle.pose.distance_to(*_place(logo, a, b)) / logo.step_mm)


@primitive("penup pu", 0)
def _penup(logo: Interpreter) -> None:
    logo.turtle.pen_up()


@primitive("pendown pd", 0)
def _pendown(logo: Interpreter) -> None:
    logo.turtle.pen_down()


@primitive("pendownp pendown?", 0)
def _pendownp(logo: Interpreter) -> Value:
    return answer(condition=logo.turtle.is_pen_down)


@primitive("clean", 0)
def _clean(logo: Interpreter) -> None:
    logo.turtle.clean()


@primitive("clearscreen cs", 0)
def _clearscreen(logo: Interpreter) -> None:
    logo.turtle.clear_screen()


@primitive("hideturtle ht showturtle st", 0)
def _show_or_hide(_logo: Interpreter) -> None:
    """A robot is always to be seen."""


@primitive("splitscreen ss fullscreen fs textscreen ts", 0)
def _divide_screen(_logo: Interpreter) -> None:
    """A robot has no screen to divide."""


@primitive("shownp shown?", 0)
def _shownp(_logo: Interpreter) -> Value:
    return answer(condition=True)
