"""What a program wants to be done when a limit sensor ends a command, and when a stop ends the program."""

from __future__ import annotations

import sys

from turtlewire.errors import LimitReachedError, StoppedError, TurtlewireError
from turtlewire.logo import blame
from turtlewire.logo.procedures import COMMAND
from turtlewire.logo.turtles import LimitsReachedError, Turtles
from turtlewire.turtle import Pose, Turtle

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType

    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.procedures import Primitive, Result
    from turtlewire.logo.syntax import Node
    from turtlewire.logo.values import List, Value

LAST_WORDS_S = 2.0  # how long the horn may sound before control is given back


class Events:
    """The handlers of a program.

    Attributes:
        limit: the list of ONLIMIT.
        limit_changed: whether the handler that is running has done ONLIMIT.
        sensor: the sensor of the limit that was reached last, ``""`` before the first.
        stop: the list of ONSTOP.
    """

    def __init__(self) -> None:
        self.limit: List | None = None
        self.limit_changed = False
        self.sensor = ""
        self.stop: List | None = None


def set_limit_handler(logo: Interpreter, handler: List | None) -> None:
    """Install what is run when a limit sensor ends a command, or remove it."""
    logo.turtles.all.set_step_by_step(handler is not None)
    logo.events.limit = handler
    logo.events.limit_changed = True


def handle_limit(logo: Interpreter, limit: LimitReachedError, node: Node) -> Result:
    """Run the ONLIMIT list in place of the rest of the command that a limit sensor ended.

    Of several turtles each that a limit has stopped is told alone, one after the other.

    Raises:
        LimitReachedError: there is no ONLIMIT.
    """
    events, turtles = logo.events, logo.turtles
    handler = events.limit
    team = limit.reached if isinstance(limit, LimitsReachedError) else ()
    if handler is None or limit is logo.escaping:
        if team and limit is not logo.escaping:
            limit.add_note(f"It happened to {' and '.join([turtles.owner(turtle) for turtle, _ in team])}.")
        blame.annotate(logo, limit, node)
        raise limit
    reached = team or ((logo.turtle, limit),)
    outer = turtles.told
    events.limit = None  # a limit within the handler is an error, unless it does ONLIMIT itself
    events.limit_changed = False
    index = 0
    try:
        while index < len(reached):
            turtle, each = reached[index]
            index += 1
            if team:
                logo.turtle = turtles.tell((turtles.owner(turtle),))
            events.sensor = each.sensor
            result = logo.run_list(handler, COMMAND)
            if result is not None:
                return result
    finally:
        if not events.limit_changed:
            events.limit = handler
        if team:
            logo.turtle = turtles.tell(outer)
    return None


def watching_limits(logo: Interpreter, primitive: Primitive) -> Callable[..., Result]:
    """A primitive that moves the robot, for compiled functions: ONLIMIT is heeded."""
    function = primitive.function

    def none(_logo: Interpreter) -> Result:
        try:
            return function(logo)
        except LimitReachedError as limit:
            return limit_reached(logo, limit, sys._getframe(1))

    def one(_logo: Interpreter, value: Value) -> Result:
        try:
            return function(logo, value)
        except LimitReachedError as limit:
            return limit_reached(logo, limit, sys._getframe(1))

    def more(_logo: Interpreter, *inputs: Value) -> Result:
        try:
            return function(logo, *inputs)
        except LimitReachedError as limit:
            return limit_reached(logo, limit, sys._getframe(1))

    fewest, most = primitive.minimum_inputs, primitive.maximum_inputs
    if fewest == most == 0:
        return none
    return one if fewest == most == 1 else more


def limit_reached(logo: Interpreter, limit: LimitReachedError, frame: FrameType) -> Result:
    """What ONLIMIT makes of a limit sensor that ended a command of a compiled function, whose frame this is."""
    node, procedure = logo.compiler.node_at(frame)
    outer, logo.procedure = logo.procedure, procedure
    try:
        return handle_limit(logo, limit, node)
    finally:
        logo.procedure = outer


class StoppedTurtle(Turtle):
    """A turtle that was stopped: it answers, hoots and blinks, and does not move.

    Args:
        turtle: the one that was stopped.
    """

    def __init__(self, turtle: Turtle) -> None:
        self._turtle = turtle
        self._left_s = LAST_WORDS_S

    def _refuse(self, *_inputs: object) -> None:
        raise StoppedError(
            "the robot was stopped: nothing that ONSTOP runs moves it, its pen or its settings"
        )

    def forward(self, distance_mm: float) -> None:
        """Refused."""
        self._refuse(distance_mm)

    def right(self, angle_deg: float) -> None:
        """Refused."""
        self._refuse(angle_deg)

    def set_position(self, x_mm: float, y_mm: float) -> None:
        """Refused."""
        self._refuse(x_mm, y_mm)

    def set_heading(self, heading_deg: float) -> None:
        """Refused."""
        self._refuse(heading_deg)

    def home(self) -> None:
        """Refused."""
        self._refuse()

    def arc(self, angle_deg: float, radius_mm: float) -> None:
        """Refused."""
        self._refuse(angle_deg, radius_mm)

    def pen_up(self) -> None:
        """Refused: the pen's motor would move."""
        self._refuse()

    def pen_down(self) -> None:
        """Refused: the pen's motor would move."""
        self._refuse()

    def clean(self) -> None:
        """Refused: what was drawn is to be seen."""
        self._refuse()

    def clear_screen(self) -> None:
        """Refused."""
        self._refuse()

    def set_speed(self, speed: int) -> None:
        """Refused."""
        self._refuse(speed)

    def set_step_by_step(self, on: bool) -> None:
        """Refused."""
        self._refuse(on)

    @property
    def pose(self) -> Pose:
        """Where the exact turtle was when it was stopped."""
        return self._turtle.pose

    @property
    def is_pen_down(self) -> bool:
        """Whether the pen is down."""
        return self._turtle.is_pen_down

    def horn(self, tone: str) -> None:
        """Sound the horn."""
        self._turtle.horn(tone)

    def lamp(self, on: bool) -> None:
        """Switch the lamp."""
        self._turtle.lamp(on)

    def wait(self, seconds: float) -> None:
        """Wait, for ``LAST_WORDS_S`` in all: who stopped it wants control back."""
        if seconds > self._left_s:
            raise StoppedError(f"the robot was stopped: ONSTOP may wait for {LAST_WORDS_S:g} s in all")
        self._left_s -= seconds
        self._turtle.wait(seconds)

    def finish(self) -> None:
        """There is no motion to wait for."""

    def stop(self) -> None:
        """Stop again."""
        self._turtle.stop()


def stopped(turtles: Turtles) -> Turtles:
    """The same turtles, stopped. One that cannot be stopped (its link is lost) keeps no other from it.

    Whoever owns the robots stops them too, and tells of one that could not be stopped.
    """
    for name in turtles.names:
        try:
            turtles.as_one([name]).stop()
        except TurtlewireError:
            continue
    still = Turtles({name: StoppedTurtle(turtles.as_one([name])) for name in turtles.names})
    still.tell(turtles.told)
    return still
