"""A turtle that is exact and only records what it draws: for previews, and for running programs without a robot."""

from __future__ import annotations

from turtlewire.errors import MessageError
from turtlewire.trace import Trace
from turtlewire.turtle import TONES, Pose, Turtle

_SPEEDS = range(1, 256)


class ScreenTurtle(Turtle):
    """An exact turtle without a robot.

    Attributes:
        trace: what it drew.
        elapsed_s: the time it was told to wait, in seconds; nothing waits.
        speed: the speed that was set last, 1 to 255.
        tone: the horn's tone, ``"off"``, ``"low"`` or ``"high"``.
        is_lamp_on: whether the lamp is on.
        is_step_by_step: see ``Turtle.set_step_by_step``.
    """

    def __init__(self) -> None:
        self.trace = Trace()
        self.elapsed_s = 0.0
        self.speed = 255
        self.tone = "off"
        self.is_lamp_on = False
        self.is_step_by_step = False
        self._pose = Pose()
        self._pen_down = True

    def _move(self, pose: Pose) -> None:
        self._pose = pose
        self.trace.move(pose, pen_down=self._pen_down)

    def forward(self, distance_mm: float) -> None:
        """Drive straight ahead; backwards when negative."""
        self._move(self._pose.moved(distance_mm))

    def right(self, angle_deg: float) -> None:
        """Turn clockwise; counter-clockwise when negative."""
        self._move(self._pose.turned(angle_deg))

    def set_position(self, x_mm: float, y_mm: float) -> None:
        """Go straight to a point and keep the heading."""
        self._move(Pose(x_mm, y_mm, self._pose.heading_deg))

    def set_heading(self, heading_deg: float) -> None:
        """Turn to an absolute heading."""
        self._move(Pose(self._pose.x_mm, self._pose.y_mm, heading_deg % 360.0))

    def home(self) -> None:
        """Go to the origin and look up."""
        self._move(Pose())

    @property
    def pose(self) -> Pose:
        """Where the turtle is."""
        return self._pose

    def pen_up(self) -> None:
        """Lift the pen."""
        self._pen_down = False

    def pen_down(self) -> None:
        """Lower the pen."""
        self._pen_down = True

    @property
    def is_pen_down(self) -> bool:
        """Whether the pen is down."""
        return self._pen_down

    def clean(self) -> None:
        """Forget what was drawn."""
        self.trace.clear()

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
