"""Several turtles: which there are, who of them is told, and those who are told as one turtle."""

from __future__ import annotations

from turtlewire.errors import LimitReachedError
from turtlewire.turtle import Pose, Turtle

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

ALONE = "turtle"  # the name of a turtle that was given none


class LimitsReachedError(LimitReachedError):
    """Limit sensors stopped turtles of a team, each by its own sensor; the first of them speaks for all.

    Attributes:
        reached: the turtles, each with its own error.
    """

    def __init__(self, reached: Sequence[tuple[Turtle, LimitReachedError]]) -> None:
        first = reached[0][1]
        super().__init__(first.sensor, first.x_mm, first.y_mm, first.heading_deg)
        self.reached = reached


class Team(Turtle):
    """Turtles who are told the same: commands go to each of them, questions to the first.

    A limit sensor that stops one keeps no other from its command.

    Args:
        members: the turtles, at least one.
    """

    def __init__(self, members: Sequence[Turtle]) -> None:
        if not members:
            raise ValueError("a team has at least one member")
        self.members = tuple(members)

    def _each(self, tell: Callable[[Turtle], object]) -> None:
        reached: list[tuple[Turtle, LimitReachedError]] = []
        for member in self.members:
            try:
                tell(member)
            except LimitReachedError as limit:
                reached.append((member, limit))
        if reached:
            raise LimitsReachedError(reached)

    def forward(self, distance_mm: float) -> None:
        """Drive straight ahead."""
        self._each(lambda each: each.forward(distance_mm))

    def back(self, distance_mm: float) -> None:
        """Drive straight backwards."""
        self._each(lambda each: each.back(distance_mm))

    def right(self, angle_deg: float) -> None:
        """Turn clockwise."""
        self._each(lambda each: each.right(angle_deg))

    def left(self, angle_deg: float) -> None:
        """Turn counter-clockwise."""
        self._each(lambda each: each.left(angle_deg))

    def set_position(self, x_mm: float, y_mm: float) -> None:
        """Go straight to a point."""
        self._each(lambda each: each.set_position(x_mm, y_mm))

    def set_x(self, x_mm: float) -> None:
        """Go to an x coordinate; each keeps its own y."""
        self._each(lambda each: each.set_x(x_mm))

    def set_y(self, y_mm: float) -> None:
        """Go to a y coordinate; each keeps its own x."""
        self._each(lambda each: each.set_y(y_mm))

    def set_heading(self, heading_deg: float) -> None:
        """Turn to an absolute heading."""
        self._each(lambda each: each.set_heading(heading_deg))

    def home(self) -> None:
        """Go to the origin, each to its own, and look up."""
        self._each(lambda each: each.home())

    @property
    def pose(self) -> Pose:
        """Where the first is."""
        return self.members[0].pose

    def pen_up(self) -> None:
        """Lift the pens."""
        self._each(lambda each: each.pen_up())

    def pen_down(self) -> None:
        """Lower the pens."""
        self._each(lambda each: each.pen_down())

    @property
    def is_pen_down(self) -> bool:
        """Whether the pen of the first is down."""
        return self.members[0].is_pen_down

    def arc(self, angle_deg: float, radius_mm: float) -> None:
        """Draw a part of a circle, each around itself."""
        self._each(lambda each: each.arc(angle_deg, radius_mm))

    def clean(self) -> None:
        """Start new sheets."""
        self._each(lambda each: each.clean())

    def clear_screen(self) -> None:
        """``clean``, with each turtle home."""
        self._each(lambda each: each.clear_screen())

    def set_speed(self, speed: int) -> None:
        """Set the speed, 1 to 255."""
        self._each(lambda each: each.set_speed(speed))

    def horn(self, tone: str) -> None:
        """Sound the horns."""
        self._each(lambda each: each.horn(tone))

    def lamp(self, on: bool) -> None:
        """Switch the lamps."""
        self._each(lambda each: each.lamp(on))

    def wait(self, seconds: float) -> None:
        """Let the motion of all end, then let this much of the first one's time pass."""
        self.finish()
        self.members[0].wait(seconds)

    def finish(self) -> None:
        """Wait until every motion of all is done."""
        self._each(lambda each: each.finish())

    def stop(self) -> None:
        """Stop all at once. One that cannot be stopped keeps no other from it."""
        self._stop_from(0)

    def _stop_from(self, index: int) -> None:
        try:
            self.members[index].stop()
        finally:
            if index + 1 < len(self.members):
                self._stop_from(index + 1)

    def set_step_by_step(self, on: bool) -> None:
        """Whether each motion ends before its method returns."""
        self._each(lambda each: each.set_step_by_step(on))


class Turtles:
    """The turtles of a program by name, and who of them is told; at first the first.

    Args:
        given: a turtle, or turtles by name: at least one, no two of which differ in upper and lower case only.

    Attributes:
        told: the names of those who are told, as they were given.
    """

    def __init__(self, given: Turtle | Mapping[str, Turtle]) -> None:
        by_name = {ALONE: given} if isinstance(given, Turtle) else dict(given)
        self._by_key = {name.lower(): (name, turtle) for name, turtle in by_name.items()}
        if not by_name or len(self._by_key) != len(by_name):
            raise ValueError(f"turtles have different names, and there is at least one: not {list(by_name)}")
        self.told: tuple[str, ...] = (next(iter(by_name)),)

    @property
    def names(self) -> list[str]:
        """The names of all, in the order in which they were given."""
        return [name for name, _ in self._by_key.values()]

    def name_of(self, word: str) -> str | None:
        """The name that a word means, in whatever case it is written; ``None`` for none."""
        found = self._by_key.get(word.lower())
        return found[0] if found is not None else None

    def owner(self, turtle: Turtle) -> str:
        """The name of a turtle, one of these."""
        return next(name for name, each in self._by_key.values() if each is turtle)

    def tell(self, names: tuple[str, ...]) -> Turtle:
        """From now on these are told.

        Returns:
            The turtle that stands for them.
        """
        self.told = names
        return self.as_one(names)

    def as_one(self, names: Sequence[str]) -> Turtle:
        """The turtle with this name, or those with these names as a team."""
        turtles = [self._by_key[name.lower()][1] for name in names]
        return turtles[0] if len(turtles) == 1 else Team(turtles)

    @property
    def all(self) -> Turtle:
        """All of them, whoever is told."""
        return self.as_one(self.names)
