"""A turtle that is exact and only records what it draws: for previews, and for running programs without a robot."""

from __future__ import annotations

from turtlewire.errors import MessageError
from turtlewire.trace import Stroke, Trace
from turtlewire.turtle import TONES, Pose, Turtle, direction

_SPEEDS = range(1, 256)


class ScreenTurtle(Turtle):
    """An exact turtle without a robot.

    Attributes:
        elapsed_s: the time it was told to wait, in seconds; nothing waits.
        speed: the speed that was set last, 1 to 255.
        tone: the horn's tone, ``"off"``, ``"low"`` or ``"high"``.
        is_lamp_on: whether the lamp is on.
        is_step_by_step: see ``Turtle.set_step_by_step``.
    """

    def __init__(self) -> None:
        self._trace = Trace()
        self.elapsed_s = 0.0
        self.speed = 255
        self.tone = "off"
        self.is_lamp_on = False
        self.is_step_by_step = False
        # Apart, and not as a pose: a program may draw a million lines.
        self._x_mm = self._y_mm = self._heading_deg = 0.0
        self._dx, self._dy = direction(0.0)
        self._points: list[tuple[float, float]] | None = None  # of the stroke that is being drawn
        self._pen_down = True

    @property
    def trace(self) -> Trace:
        """What it drew."""
        self._trace.pose = self.pose
        return self._trace

    def _move(self, x_mm: float, y_mm: float) -> None:
        before = self._x_mm, self._y_mm
        if (x_mm, y_mm) == before:
            return
        self._x_mm, self._y_mm = x_mm, y_mm
        if self._points is None:
            strokes = self._trace.strokes
            if not strokes or strokes[-1].pen_down != self._pen_down:
                strokes.append(Stroke(self._pen_down, [before]))
            self._points = strokes[-1].points
        self._points.append((x_mm, y_mm))

    def _turn_to(self, heading_deg: float) -> None:
        self._heading_deg = heading = heading_deg % 360.0
        self._dx, self._dy = direction(heading)

    def forward(self, distance_mm: float) -> None:
        """Drive straight ahead; backwards when negative."""
        x_before, y_before = self._x_mm, self._y_mm
        x_mm, y_mm = x_before + distance_mm * self._dx, y_before + distance_mm * self._dy
        points = self._points
        if points is None or (x_mm == x_before and y_mm == y_before):
            self._move(x_mm, y_mm)
            return
        # As ``_move``: it is what most programs do most.
        self._x_mm = x_mm
        self._y_mm = y_mm
        points.append((x_mm, y_mm))

    def right(self, angle_deg: float) -> None:
        """Turn clockwise; counter-clockwise when negative."""
        self._heading_deg = heading = (self._heading_deg + angle_deg) % 360.0
        self._dx, self._dy = direction(heading)

    def set_position(self, x_mm: float, y_mm: float) -> None:
        """Go straight to a point and keep the heading."""
        self._move(x_mm, y_mm)

    def set_heading(self, heading_deg: float) -> None:
        """Turn to an absolute heading."""
        self._turn_to(heading_deg)

    def home(self) -> None:
        """Go to the origin and look up."""
        self._move(0.0, 0.0)
        self._turn_to(0.0)

    @property
    def pose(self) -> Pose:
        """Where the turtle is."""
        return Pose(self._x_mm, self._y_mm, self._heading_deg)

    def pen_up(self) -> None:
        """Lift the pen."""
        self._pen_down = False
        self._points = None

    def pen_down(self) -> None:
        """Lower the pen."""
        self._pen_down = True
        self._points = None

    @property
    def is_pen_down(self) -> bool:
        """Whether the pen is down."""
        return self._pen_down

    def clean(self) -> None:
        """Forget what was drawn."""
        self.trace.clear()
        self._points = None

    def set_speed(self, speed: int) -> None:
        """Set the speed, 1 to 255. Raises ``MessageError`` outside."""
        if speed not in _SPEEDS:
            raise MessageError(f"the speed must be 1 to 255, not {speed}")
        self.speed = speed

    def horn(self, tone: str) -> None:
        """Sound the horn. Raises ``MessageError`` for an unknown tone."""
        if tone not in TONES:
            raise MessageError(f"the horn has the tones {', '.join(TONES)}, not {tone}")
        self.tone = tone

    def lamp(self, on: bool) -> None:
        """Switch the lamp."""
        self.is_lamp_on = on

    def wait(self, seconds: float) -> None:
        """Count the time; nothing waits."""
        self.elapsed_s += seconds

    def finish(self) -> None:
        """Nothing is ever under way."""

    def stop(self) -> None:
        """Nothing is ever under way."""

    def set_step_by_step(self, on: bool) -> None:
        """Remember it."""
        self.is_step_by_step = on
