"""The turtle of a program that runs in a process of its own: what it is told, the server's robot does."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from turtlewire.errors import TurtlewireError
from turtlewire.turtle import HOME, Pose, Turtle

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

# What a program can have done with a turtle: the names of its methods, and what their inputs are.
CALLS: Mapping[str, tuple[type, ...]] = {
    "forward": (float,),
    "right": (float,),
    "set_position": (float, float),
    "set_heading": (float,),
    "home": (),
    "arc": (float, float),
    "pen_up": (),
    "pen_down": (),
    "clean": (),
    "clear_screen": (),
    "set_speed": (int,),
    "horn": (str,),
    "lamp": (bool,),
    "wait": (float,),
    "finish": (),
    "stop": (),
}
# What those may still do that a stop has ended: ONSTOP's last words.
LAST_WORDS = frozenset(("horn", "lamp", "wait", "finish", "stop"))


class FarTurtle(Turtle):
    """A turtle whose methods are calls.

    Each motion ends before its method returns: so the line that a program is at is the one whose motion is to be
    seen, a pause is one of the robot, too, and a limit is told in the motion that it belongs to.

    Args:
        call: has a method of the server's turtle called, by its name and inputs, and tells the pose and the pen after
            it; raises what that raised.
    """

    def __init__(self, call: Callable[[str, tuple[Any, ...]], Mapping[str, Any]]) -> None:
        self._call = call
        self._pose = HOME
        self._is_pen_down = True

    def stands(self, pose: Pose, *, pen_down: bool) -> None:
        """This is where the robot is."""
        self._pose, self._is_pen_down = pose, pen_down

    def _do(self, name: str, *inputs: float | str) -> None:
        told = self._call(name, inputs)
        self.stands(Pose(*told["pose"]), pen_down=told["pen"])

    def forward(self, distance_mm: float) -> None:
        """Drive straight ahead."""
        self._do("forward", distance_mm)

    def right(self, angle_deg: float) -> None:
        """Turn clockwise."""
        self._do("right", angle_deg)

    def set_position(self, x_mm: float, y_mm: float) -> None:
        """Go straight to a point."""
        self._do("set_position", x_mm, y_mm)

    def set_heading(self, heading_deg: float) -> None:
        """Turn to an absolute heading."""
        self._do("set_heading", heading_deg)

    def home(self) -> None:
        """Go to the origin and look up."""
        self._do("home")

    def arc(self, angle_deg: float, radius_mm: float) -> None:
        """Draw a part of a circle around the turtle."""
        self._do("arc", angle_deg, radius_mm)

    @property
    def pose(self) -> Pose:
        """Where it is."""
        return self._pose

    def pen_up(self) -> None:
        """Lift the pen."""
        self._do("pen_up")

    def pen_down(self) -> None:
        """Lower the pen."""
        self._do("pen_down")

    @property
    def is_pen_down(self) -> bool:
        """Whether the pen is down."""
        return self._is_pen_down

    def clean(self) -> None:
        """Start a new sheet."""
        self._do("clean")

    def clear_screen(self) -> None:
        """``clean``, with the turtle home."""
        self._do("clear_screen")

    def set_speed(self, speed: int) -> None:
        """Set the speed, 1 to 255."""
        self._do("set_speed", speed)

    def horn(self, tone: str) -> None:
        """Sound the horn."""
        self._do("horn", tone)

    def lamp(self, on: bool) -> None:
        """Switch the lamp."""
        self._do("lamp", on)

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        self._do("wait", seconds)

    def finish(self) -> None:
        """Wait until every motion is done."""
        self._do("finish")

    def stop(self) -> None:
        """Stop at once."""
        self._do("stop")

    def set_step_by_step(self, on: bool) -> None:
        """It always is."""


def checked(message: dict[str, Any]) -> tuple[Any, ...]:
    """The name and the inputs of a call. Raises ``TurtlewireError`` for one that no program can make."""
    name, inputs = message["call"], message.get("inputs")
    kinds = CALLS.get(name) if isinstance(name, str) else None
    if kinds is None or not isinstance(inputs, list) or len(inputs) != len(kinds):
        raise TurtlewireError(f"a turtle cannot do this: {name!r}")
    for kind, each in zip(kinds, inputs, strict=True):
        wanted = (int, float) if kind is float else kind
        if not isinstance(each, wanted) or (kind is not bool and isinstance(each, bool)):
            raise TurtlewireError(f"{name} wants no {each!r}")
        if isinstance(each, float) and not math.isfinite(each):
            raise TurtlewireError(f"{name} wants a finite number")
    return (name, *inputs)
