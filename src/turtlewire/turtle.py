"""The turtle that Logo and people program against: an interface, and the pose.

Whatever draws (a robot over its wire, a screen) implements ``Turtle``; whatever programs
(Logo, a Python program) uses only this. Distances are millimetres, angles degrees; headings are
Logo's: 0 = +Y (up), clockwise.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

from turtlewire.named_tuple import NamedTuple

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable

# An arc is drawn as a polygon whose sides leave the true circle by at most this much.
ARC_SAGITTA_MM = 0.25
# No arc has more than 3600 sides, however large its radius.
FINEST_ARC_DEG = 0.1
_DIRECTIONS_KEPT = 4096
TONES = ("off", "low", "high")


class Pose(NamedTuple):
    """A place and a direction: millimetres, and degrees with 0 = +Y, clockwise."""

    x_mm: float = 0.0
    y_mm: float = 0.0
    heading_deg: float = 0.0

    def moved(self, distance_mm: float) -> Pose:
        """The pose after driving straight (backwards when negative)."""
        dx, dy = direction(self.heading_deg)
        return Pose(self.x_mm + distance_mm * dx, self.y_mm + distance_mm * dy, self.heading_deg)

    def turned(self, angle_deg: float) -> Pose:
        """The pose after turning clockwise (counter-clockwise when negative)."""
        return Pose(self.x_mm, self.y_mm, (self.heading_deg + angle_deg) % 360.0)

    def bearing_to(self, x_mm: float, y_mm: float) -> float:
        """The heading, 0 <= h < 360, that looks at a point; 0 for the place itself."""
        dx, dy = x_mm - self.x_mm, y_mm - self.y_mm
        return math.degrees(math.atan2(dx, dy)) % 360.0 if dx or dy else 0.0

    def distance_to(self, x_mm: float, y_mm: float) -> float:
        """How far a point is away, in millimetres."""
        return math.hypot(x_mm - self.x_mm, y_mm - self.y_mm)


HOME = Pose()


class _Directions(dict[float, tuple[float, float]]):
    """The unit vectors of headings: programs turn by the same angles again and again."""

    def __missing__(self, heading_deg: float) -> tuple[float, float]:
        h = heading_deg % 360.0
        if h % 90.0 == 0.0:
            found = ((0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0))[int(h // 90.0) % 4]
        else:
            radians = math.radians(h)
            found = math.sin(radians), math.cos(radians)
        if len(self) >= _DIRECTIONS_KEPT:
            self.clear()
        self[heading_deg] = found
        return found


# The unit vector of a heading, exact for the four right angles, so squares close exactly.
direction: Callable[[float], tuple[float, float]] = _Directions().__getitem__


def wrapped(angle_deg: float) -> float:
    """The same direction as -180 < angle <= 180."""
    angle = angle_deg % 360.0
    return angle - 360.0 if angle > 180.0 else angle


def arc_polygon(angle_deg: float, radius_mm: float) -> tuple[int, float, float]:
    """What an arc is drawn as: the number of sides, the length of one, and the turn from one to the next.

    The sides leave the circle by at most ``ARC_SAGITTA_MM``; the turn has the sign of the angle.
    """
    radius = abs(radius_mm)
    if not radius or not angle_deg:
        return 0, 0.0, 0.0
    sweep = max(-360.0, min(360.0, angle_deg))
    finest = 2.0 * math.degrees(math.acos(max(0.5, 1.0 - ARC_SAGITTA_MM / radius)))
    sides = max(1, math.ceil(abs(sweep) / max(finest, FINEST_ARC_DEG)))
    turn = sweep / sides
    return sides, 2.0 * radius * math.sin(math.radians(abs(turn) / 2.0)), turn


def arc_tangent(angle_deg: float, radius_mm: float) -> float:
    """The turn from the radius to the direction in which the arc is drawn: 90 degrees, to its side."""
    return math.copysign(90.0, angle_deg * radius_mm)


class Turtle(ABC):
    """A turtle with a pen, as Logo knows it.

    Methods return when the turtle has accepted the command; a robot may still be moving (``finish``
    waits). Any of them may raise ``LinkError`` or ``RobotError``: among them ``LimitReachedError``,
    which belongs to this or an earlier motion, and after which the turtle stands still where the error says.
    """

    @abstractmethod
    def forward(self, distance_mm: float) -> None:
        """Drive straight ahead; backwards when negative."""

    @abstractmethod
    def right(self, angle_deg: float) -> None:
        """Turn clockwise on the spot; counter-clockwise when negative. Whole turns are made."""

    def back(self, distance_mm: float) -> None:
        """Drive straight backwards; ahead when negative."""
        self.forward(-distance_mm)

    def left(self, angle_deg: float) -> None:
        """Turn counter-clockwise on the spot; clockwise when negative."""
        self.right(-angle_deg)

    @abstractmethod
    def set_position(self, x_mm: float, y_mm: float) -> None:
        """Go straight to a point and keep the heading."""

    def set_x(self, x_mm: float) -> None:
        """Go to an x coordinate along a line parallel to the x axis; the heading is kept."""
        self.set_position(x_mm, self.pose.y_mm)

    def set_y(self, y_mm: float) -> None:
        """Go to a y coordinate along a line parallel to the y axis; the heading is kept."""
        self.set_position(self.pose.x_mm, y_mm)

    @abstractmethod
    def set_heading(self, heading_deg: float) -> None:
        """Turn, the shorter way, to an absolute heading."""

    @abstractmethod
    def home(self) -> None:
        """Go to the origin and look up (heading 0)."""

    @property
    @abstractmethod
    def pose(self) -> Pose:
        """Where the exact turtle is, without the rounding of any robot."""

    def towards(self, x_mm: float, y_mm: float) -> float:
        """The heading, 0 <= h < 360, that looks at a point."""
        return self.pose.bearing_to(x_mm, y_mm)

    @abstractmethod
    def pen_up(self) -> None:
        """Lift the pen."""

    @abstractmethod
    def pen_down(self) -> None:
        """Lower the pen."""

    @property
    @abstractmethod
    def is_pen_down(self) -> bool:
        """Whether the pen is down."""

    def arc(self, angle_deg: float, radius_mm: float) -> None:
        """Draw a part of a circle around the turtle, starting at its heading, clockwise.

        The turtle ends where it was, with its heading and pen as they were.
        """
        sides, chord_mm, turn_deg = arc_polygon(angle_deg, radius_mm)
        start, was_down = self.pose, self.is_pen_down
        if sides:
            self.pen_up()
            self.forward(radius_mm)
            self.right(arc_tangent(angle_deg, radius_mm) + turn_deg / 2)
            if was_down:
                self.pen_down()
            for _ in range(sides):
                self.forward(chord_mm)
                self.right(turn_deg)
            self.pen_up()
            self.set_position(start.x_mm, start.y_mm)
            self.set_heading(start.heading_deg)
            if was_down:
                self.pen_down()

    @abstractmethod
    def clean(self) -> None:
        """Start a new sheet: forget what was drawn. Only the trace; ink on a floor stays."""

    def clear_screen(self) -> None:
        """``clean``, with the turtle home. A robot drives there with its pen up."""
        was_down = self.is_pen_down
        if self.pose != HOME:
            self.pen_up()
            self.home()
            if was_down:
                self.pen_down()
        self.clean()

    @abstractmethod
    def set_speed(self, speed: int) -> None:
        """Set the speed, 1 (slow) to 255 (fast). Raises ``MessageError`` outside."""

    @abstractmethod
    def horn(self, tone: str) -> None:
        """Sound the horn: ``"off"``, ``"low"`` or ``"high"``. Raises ``NotSupportedError`` without one."""

    @abstractmethod
    def lamp(self, on: bool) -> None:
        """Switch the lamp. Raises ``NotSupportedError`` without one."""

    @abstractmethod
    def wait(self, seconds: float) -> None:
        """Let the motion end, then let this much of the robot's time pass."""

    @abstractmethod
    def finish(self) -> None:
        """Wait until every motion is done."""

    @abstractmethod
    def stop(self) -> None:
        """Stop at once and forget every motion not yet done."""

    @abstractmethod
    def set_step_by_step(self, on: bool) -> None:
        """Whether each motion ends before its method returns.

        Off (the default) lets motions be sent ahead, so that the robot never waits for its host. A program
        that handles limits (ONLIMIT) needs it on: an error must arrive in the motion it belongs to.
        """
