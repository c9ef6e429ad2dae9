"""What can be seen and heard of a robot, put together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.helm.speedometer import Speedometer
from turtlewire.helm.view import Notice, View
from turtlewire.helm.wire import Messages, Tap
from turtlewire.links.real_time import RealTimeLink
from turtlewire.protocols import catalogue
from turtlewire.robots.frame import Frame
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.configuration import Target
    from turtlewire.connect import AsyncRobot
    from turtlewire.helm.path import Path
    from turtlewire.links.link import Link
    from turtlewire.trace import Obstacle

KINDS = {"walter": "WALTER", "simple": "car", "frame": "two-engine robot"}
# What is further off than this from where it was reckoned to be has not driven there.
JUMP_MM = 20.0


def title(target: Target) -> str:
    """What to call a robot."""
    kind = KINDS[target.protocol]
    if target.is_simulated:
        return f"simulated {kind}"
    return (
        f"{kind} at {target.name}"
        if target.name == target.port
        else f"{target.name}, a {kind} at {target.port}"
    )


class Ear:
    """Hears what passes on a robot's wire: ``connect`` is given this to wrap its link.

    Args:
        target: the robot.
        pace: of a simulated one, which lives in real time: seconds of its time for each second on the wall.
        between: given the link in real time, returns the link to use instead, below what listens here.

    Attributes:
        messages: what was heard.
        link: once it is open.
    """

    def __init__(
        self, target: Target, pace: float, between: Callable[[Link], Link] = lambda link: link
    ) -> None:
        self.messages = Messages(codec(target), phrases(target.protocol))
        self.link: Link
        self._pace = pace
        self._between = between

    def __call__(self, link: Link) -> Link:
        """Listen to this link."""
        in_real_time = link if link.in_background else RealTimeLink(link, self._pace)
        self.link = Tap(self._between(in_real_time), self.messages)
        return self.link


def codec(target: Target) -> catalogue.Codec:
    """What a robot speaks. Raises ``DataError`` for a dialect that cannot be read."""
    if target.protocol != "frame":
        return catalogue.codec(target.protocol)
    return catalogue.Frame(target.overrides.get("dialect") or target.simulation.get("dialect", "0.1"))


def phrases(protocol: str) -> dict[bytes, str]:
    """What stops a robot from any state (S7, W7, W8); F13 consists of frames like any others."""
    if protocol == "walter":
        from turtlewire.protocols.walter import messages

        return {
            messages.EMERGENCY_STOP: "emergency stop",
            messages.ATTENTION: "attention: stop, Logo control",
        }
    if protocol == "simple":
        from turtlewire.protocols.simple.messages import EMERGENCY_STOP

        return {EMERGENCY_STOP: "emergency stop"}
    return {}


class Sight:
    """Looks at a robot.

    Args:
        robot: connected.
        ear: hears what passes on its wire.
        is_seen: it is a simulated one, whose true place can be seen.
        path: where it goes is added to this; None: nobody wants to know.

    Attributes:
        obstacles: what stands around it, in the turtle's coordinates.
        lamp, horn: whether they are on, as far as is known.
        is_told: whether the robot has told where it is since it stands.
    """

    def __init__(self, robot: AsyncRobot, ear: Ear, *, is_seen: bool, path: Path | None = None) -> None:
        self._robot = robot
        self._messages = ear.messages
        self._is_seen = is_seen
        self._link = ear.link
        self._started_s = self._link.now()
        # The ground, from where the robot stood at first.
        self._frame = Frame(robot.trace.start if is_seen else robot.pose)
        self._speedometer = Speedometer()
        self._jumps = self._jumped = 0
        self._distance_mm = 0.0
        self._pose = self._frame.from_robot(robot.trace.pose) if is_seen else robot.pose
        self.obstacles = [self._from_ground(obstacle) for obstacle in robot.obstacles]
        self.lamp = self.horn = self.is_told = False
        self._path = path
        if path is not None:
            path.begin(self._pose, robot.trace)

    @property
    def origin(self) -> Pose | None:
        """Where on the ground its coordinates begin, and which way they look; None: nobody knows."""
        return self._frame.origin if self._is_seen else None

    @property
    def elapsed_s(self) -> float:
        """Since the link was opened."""
        return self._link.now() - self._started_s

    def told(self, pose: Pose) -> None:
        """The robot says where it is."""
        if not self._is_seen and self._pose.distance_to(pose.x_mm, pose.y_mm) > JUMP_MM:
            self._jumps += 1
        self.is_told = True

    def look(self, notices: tuple[Notice, ...], *, is_over: bool) -> View:
        """Look at it now."""
        robot, now = self._robot, self.elapsed_s
        pose = self._frame.from_robot(robot.trace.pose) if self._is_seen else robot.pose
        self._distance_mm += self._pose.distance_to(pose.x_mm, pose.y_mm)
        self._pose = pose
        self._speedometer.at(pose, now)
        if self._path is not None:
            self._go_on(self._path)
        features = robot.features
        return View(
            time_s=now,
            pose=pose,
            certainty="seen" if self._is_seen else "told" if self.is_told else "reckoned",
            distance_mm=self._distance_mm,
            speed_mm_per_s=self._speedometer.speed_mm_per_s,
            turn_deg_per_s=self._speedometer.turn_deg_per_s,
            pen_down=robot.is_pen_down if "pen" in features else None,
            lamp=self.lamp if "lamp" in features else None,
            horn=self.horn,
            link="closed" if is_over else robot.link_state,
            figures=robot.statistics._asdict(),
            lines=self._messages.lines(),
            notices=notices,
            jumped=self._jumps,
        )

    def _go_on(self, path: Path) -> None:
        """The path goes on to where the robot is. What a simulated one has drawn is seen, to the last point."""
        robot = self._robot
        if self._is_seen:
            path.follow(robot.trace, self._frame.from_robot, self._pose)
            return
        if path.is_cleared(robot.trace):
            path.clear()
        has_jumped, self._jumped = self._jumps != self._jumped, self._jumps
        path.move(self._pose, pen_down=robot.is_pen_down and not has_jumped)

    def _from_ground(self, obstacle: Obstacle) -> Obstacle:
        if len(obstacle) == 3:
            x, y, radius = obstacle
            middle = self._frame.from_robot(Pose(x, y))
            return (middle.x_mm, middle.y_mm, radius)
        x1, y1, x2, y2 = obstacle
        one, other = self._frame.from_robot(Pose(x1, y1)), self._frame.from_robot(Pose(x2, y2))
        return (one.x_mm, one.y_mm, other.x_mm, other.y_mm)
