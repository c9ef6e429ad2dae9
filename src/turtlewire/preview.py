"""What a program will do, without the robot: it is run on a simulated one of the same kind and speed first."""

from __future__ import annotations

import math
import random
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, NamedTuple

from turtlewire.configuration import PROTOCOLS
from turtlewire.deviation import Followed
from turtlewire.errors import LimitReachedError, TurtlewireError
from turtlewire.logo import Interpreter, Position
from turtlewire.logo.keyboard import Keyboard
from turtlewire.logo.streams import Streams
from turtlewire.logo.turtles import LimitsReachedError
from turtlewire.robots.frame import Frame
from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from turtlewire.configuration import Target
    from turtlewire.connect import Robot
    from turtlewire.simulator.world import World
    from turtlewire.trace import Stroke
    from turtlewire.turtle import Turtle

# A program that goes on for longer than this, in seconds of the robot's time, is not looked at to its end.
LONGEST_S = 7200.0
# How often the robot's clock is looked at: every so many motions.
LOOK = 50
CHANCE, SENSORS, KEYBOARD = "uses chance", "asks the limit sensors", "reads the keyboard"


class Extent(NamedTuple):
    """The smallest upright rectangle around points, in millimetres, as the turtle sees it: home is 0, 0."""

    left_mm: float
    right_mm: float
    bottom_mm: float
    top_mm: float

    def with_point(self, x_mm: float, y_mm: float) -> Extent:
        """The rectangle that holds this point, too."""
        return Extent(
            min(self.left_mm, x_mm),
            max(self.right_mm, x_mm),
            min(self.bottom_mm, y_mm),
            max(self.top_mm, y_mm),
        )


class Touch(NamedTuple):
    """Where a robot meets a wall: its place then, as the turtle sees it, and the line of the program."""

    x_mm: float
    y_mm: float
    line: int | None


class Preview(NamedTuple):
    """What a program would do.

    Attributes:
        way: the extent of all that the robot drives.
        drawing: the extent of what it draws; None: nothing.
        path_mm: how far it drives.
        pen_down_mm: how much of that with its pen down.
        seconds: how long it takes, in the robot's time.
        is_whole: whether the program came to its end within ``LONGEST_S``.
        has_arena: whether it is known what stands around the robot.
        touch: where it meets something first; None: nowhere.
        asks: why it may be otherwise each time: ``CHANCE``, ``SENSORS``, ``KEYBOARD``.
        error: what ended the program, if anything did.
        position: where in the program that was.
        strokes: what is to be seen in the end, and the way there, as the turtle sees it.
    """

    way: Extent
    drawing: Extent | None
    path_mm: float
    pen_down_mm: float
    seconds: float
    is_whole: bool
    has_arena: bool
    touch: Touch | None
    asks: tuple[str, ...]
    error: TurtlewireError | None
    position: Position | None
    strokes: Sequence[Stroke] = ()


def preview(
    target: Target,
    source: str,
    name: str,
    *,
    seed: int = 0,
    step_mm: float = 1.0,
    arena: str | None = None,
    start: Pose = HOME,
    files: Callable[[Interpreter], Streams] = Streams,
) -> Preview:
    """Run a program on a simulated robot like the target, in virtual time.

    What the program prints is dropped, and nobody types what it reads.

    Args:
        target: the robot that it is meant for.
        source: the program.
        name: its file name.
        seed: of RANDOM, and of the simulated robot's slip and noise.
        step_mm: the length of a Logo step.
        arena: an arena file, for a robot whose surroundings are not known otherwise.
        start: where the robot stands when the program begins, as the turtle sees it.
        files: what the program's files are.

    Raises ``UsageError`` or ``DataError`` for a target or an arena that means nothing.
    """
    (found,) = preview_all(
        {target.protocol: target},
        source,
        name,
        seed=seed,
        step_mm=step_mm,
        arena=arena,
        start=start,
        files=files,
    ).values()
    return found


def preview_all(
    targets: Mapping[str, Target],
    source: str,
    name: str,
    *,
    seed: int = 0,
    step_mm: float = 1.0,
    arena: str | None = None,
    start: Pose = HOME,
    files: Callable[[Interpreter], Streams] = Streams,
) -> dict[str, Preview]:
    """``preview`` of a program for several robots, by the names that it knows them by; each is in an arena of its own.

    How the program ends is the same for all. One that is alone, and called by its protocol, is Logo's ``turtle``.
    """
    from turtlewire.connect import connect

    chance = _Chance(seed)
    with ExitStack() as opened:
        watched: dict[str, _Watched] = {}
        began_s: dict[str, float] = {}
        for number, (each, target) in enumerate(targets.items()):
            like, world, radius_mm = _stand_in(target, seed + number, arena, start)
            robot = opened.enter_context(connect(like, notify=lambda _text: None))
            began_s[each] = robot.statistics.seconds
            watched[each] = _Watched(robot, Frame.matching(start, HOME), world, radius_mm)
        turtles: Turtle | Mapping[str, Turtle] = watched
        if len(watched) == 1 and each in PROTOCOLS:
            turtles = watched[each]
        logo = Interpreter(turtles, lambda _text: None, chance, step_mm)
        logo.streams = files(logo)
        keyboard = logo.streams.keyboard = _NoKeyboard()
        logo.ask = keyboard.go_on
        for one in watched.values():
            one.position = lambda: logo.position
        error: TurtlewireError | None = None
        is_whole = True
        try:
            logo.run(source, name)
            for one in watched.values():
                one.finish()
        except TooLongError:
            is_whole = False
        except TurtlewireError as caught:
            error = caught
            if isinstance(caught, LimitReachedError):
                _note_touch(caught, [*watched.values()], Frame.matching(start, HOME))
        seconds = {each: one.seconds - began_s[each] for each, one in watched.items()}
        for one in watched.values():
            one.stop_here()
    position = (getattr(error, "position", None) or logo.position) if error is not None else None
    found: dict[str, Preview] = {}
    for each, one in watched.items():
        asked = {CHANCE: chance.was_asked, SENSORS: one.asks_sensors, KEYBOARD: keyboard.was_asked}
        found[each] = Preview(
            one.way,
            one.drawing,
            one.path_mm,
            one.pen_down_mm,
            seconds[each],
            is_whole,
            one.has_arena,
            one.touch,
            tuple(reason for reason, has in asked.items() if has),
            error,
            position,
            one.ideal.strokes,
        )
    return found


def _stand_in(target: Target, seed: int, arena: str | None, start: Pose) -> tuple[Target, World, float]:
    """A simulated robot like the target where that stands, what is around it, and its radius in millimetres."""
    from turtlewire.simulated import simulated

    like = twin(target, seed, arena)
    body = simulated(like).robot.settings
    if start != HOME:
        ground = Frame(body.first_pose).to_robot(start)
        like = like._replace(simulation={**like.simulation, "start": ",".join(map(repr, ground))})
    return like, body.world, body.radius_mm


def _note_touch(limit: LimitReachedError, watched: Sequence[_Watched], frame: Frame) -> None:
    """A limit sensor has ended the program, where it is known whose that was."""
    reached: Sequence[tuple[Turtle, LimitReachedError]] = ()
    if isinstance(limit, LimitsReachedError):
        reached = limit.reached
    elif len(watched) == 1:
        reached = [(watched[0], limit)]
    for turtle, each in reached:
        if isinstance(turtle, _Watched):
            place = frame.from_robot(Pose(each.x_mm, each.y_mm))
            turtle.touched(place.x_mm, place.y_mm)


def twin(target: Target, seed: int = 0, arena: str | None = None) -> Target:
    """A simulated robot that is driven as this one, and as fast. Raises ``UsageError`` for wrong settings."""
    simulation: dict[str, Any] = {"seed": str(seed), **target.simulation, "pace": "max"}
    overrides = dict(target.overrides)
    if not target.is_simulated:
        settings = target.settings()
        if target.protocol == "walter":
            # It is as its driver believes it to be: also as far off.
            for each in ("mm_per_s_per_unit", "deg_per_s_per_unit", "distance_scale", "turn_scale"):
                simulation[each] = str(getattr(settings, each))
            groups = overrides.get("groups")
            if groups is not None:
                simulation["groups"] = "".join(sorted(groups))
        # The others are timed by their drivers, who know how fast they are; what they say besides takes no time.
        for each in ("baud", "boot_s", "dialect", "odometry_s"):
            overrides.pop(each, None)
    if arena is not None:
        simulation["arena"] = arena
    return target._replace(
        port=f"sim:{target.protocol}", simulation=simulation, overrides=overrides, faults=None
    )


class TooLongError(Exception):
    """The program goes on and on; no CATCH of Logo's sees this. A signal's handler may raise it, too."""


class _Chance(random.Random):
    """A generator that knows whether it was asked."""

    was_asked = False

    def random(self) -> float:
        self.was_asked = True
        return super().random()

    def getrandbits(self, k: int, /) -> int:
        self.was_asked = True
        return super().getrandbits(k)


class _NoKeyboard(Keyboard):
    """Nobody types; it knows whether it was asked."""

    def __init__(self) -> None:
        super().__init__(self._read)
        self.was_asked = False

    def _read(self) -> str:
        self.was_asked = True
        return ""

    def has_key(self) -> bool:
        self.was_asked = True
        return False

    def go_on(self, _prompt: str) -> str:
        """What somebody would type at a PAUSE, or before a line of STEP."""
        self.was_asked = True
        return "continue"


class _Placed(Followed):
    """A turtle that is elsewhere than the robot believes, which takes the place where it stands for its home."""

    def __init__(self, robot: Robot, frame: Frame) -> None:
        self._frame = frame
        super().__init__(robot)

    @property
    def pose(self) -> Pose:
        """Where the exact turtle is."""
        return self._frame.from_robot(self._turtle.pose)

    def _follow(self) -> None:
        """Whoever has this turtle does so."""

    def set_position(self, x_mm: float, y_mm: float) -> None:
        """Go straight to a point and keep the heading."""
        place = self._frame.to_robot(Pose(x_mm, y_mm))
        super().set_position(place.x_mm, place.y_mm)

    def set_heading(self, heading_deg: float) -> None:
        """Turn, the shorter way, to an absolute heading."""
        super().set_heading(self._frame.to_robot(Pose(heading_deg=heading_deg)).heading_deg)

    def home(self) -> None:
        """Go to the origin and look up."""
        self.set_position(0.0, 0.0)
        self.set_heading(0.0)


class _Watched(Followed):
    """A turtle whose way is measured, whatever sheet it is on."""

    def __init__(self, robot: Robot, frame: Frame, world: World, radius_mm: float) -> None:
        super().__init__(robot if frame.origin == HOME else _Placed(robot, frame))
        self._robot = robot
        self._world = world
        self._radius_mm = radius_mm
        self._origin = Frame(robot.trace.pose).to_robot(frame.to_robot(HOME))
        self._motions = 0
        x_mm, y_mm, _ = self.pose
        self.way = Extent(x_mm, x_mm, y_mm, y_mm)
        self.drawing: Extent | None = None
        self.path_mm = self.pen_down_mm = 0.0
        self.touch: Touch | None = None
        self.asks_sensors = False
        self.position: Callable[[], Position | None] = lambda: None

    def set_step_by_step(self, on: bool) -> None:
        """ONLIMIT."""
        self.asks_sensors = self.asks_sensors or on
        super().set_step_by_step(on)

    @property
    def has_arena(self) -> bool:
        """Whether it is known what stands around the robot."""
        return not self._world.is_empty

    @property
    def seconds(self) -> float:
        """The robot's time."""
        return self._robot.statistics.seconds

    def stop_here(self) -> None:
        """The program has ended, and with it the way."""
        self._robot.stop()

    def touched(self, x_mm: float, y_mm: float) -> None:
        """The robot has met a wall there; the first one counts."""
        if self.touch is None:
            position = self.position()
            self.touch = Touch(x_mm, y_mm, position.line if position is not None else None)

    def _follow(self) -> None:
        before = self.ideal.pose
        super()._follow()
        after = self.ideal.pose
        length_mm = before.distance_to(after.x_mm, after.y_mm)
        self._motions += 1
        if self._motions % LOOK == 0 and self._robot.statistics.seconds > LONGEST_S:
            raise TooLongError
        if not length_mm:
            return
        self.path_mm += length_mm
        self.way = self.way.with_point(after.x_mm, after.y_mm)
        if self.is_pen_down:
            self.pen_down_mm += length_mm
            drawing = self.drawing or Extent(before.x_mm, before.x_mm, before.y_mm, before.y_mm)
            self.drawing = drawing.with_point(before.x_mm, before.y_mm).with_point(after.x_mm, after.y_mm)
        if self.touch is None and not self._world.is_empty:
            self._look(before, after, length_mm)

    def _look(self, before: Pose, after: Pose, length_mm: float) -> None:
        """Whether something stands in the way of this motion."""
        # The turtle's home is where the robot stood, and looks where that looked.
        turned = math.radians(self._origin.heading_deg)
        sine, cosine = math.sin(turned), math.cos(turned)
        x = self._origin.x_mm + before.x_mm * cosine + before.y_mm * sine
        y = self._origin.y_mm - before.x_mm * sine + before.y_mm * cosine
        dx, dy = (after.x_mm - before.x_mm) / length_mm, (after.y_mm - before.y_mm) / length_mm
        direction = (dx * cosine + dy * sine, dy * cosine - dx * sine)
        contact = self._world.contact(x, y, direction, length_mm, self._radius_mm)
        if contact is not None:
            self.touched(before.x_mm + dx * contact.distance_mm, before.y_mm + dy * contact.distance_mm)
