"""The robots of a command: connected one after the other, and stopped together, whatever the way out is."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

from turtlewire.cli import options
from turtlewire.errors import LinkClosedError, LinkError, TurtlewireError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from turtlewire.configuration import Target
    from turtlewire.connect import Robot
    from turtlewire.links.link import Link
    from turtlewire.turtle import Turtle

LOST = ("reconnecting", "closed")


class Connected:
    """Robots by the names that a program knows them by.

    Args:
        targets: which robots; at least one.
        notify: told the name of a robot, and what people should know.
        announce: told the path that a robot is to be at, for a new pty.
        wrap: given the name of a robot and its link, returns the link to use.

    Raises what ``connect`` does; those that were connected before have been stopped then.
    """

    def __init__(
        self,
        targets: Mapping[str, Target],
        notify: Callable[[str, str], None],
        announce: Callable[[str], None],
        wrap: Callable[[str, Link], Link] | None = None,
    ) -> None:
        self.robots: dict[str, Robot] = {}
        try:
            for name, target in targets.items():
                self._connect(name, target, notify, announce, wrap)
        except BaseException:
            self.close()
            raise

    def _connect(
        self,
        name: str,
        target: Target,
        notify: Callable[[str, str], None],
        announce: Callable[[str], None],
        wrap: Callable[[str, Link], Link] | None,
    ) -> None:
        from turtlewire.connect import connect

        try:
            self.robots[name] = connect(
                target,
                notify=lambda text: notify(name, text),
                announce=announce,
                wrap=None if wrap is None else lambda link: wrap(name, link),
            )
        except LinkClosedError as error:
            options.explain_refusal(error, target.port)
            raise

    def stop(self) -> None:
        """Stop all at once; one that cannot be reached is stopped when it is, which its driver tells."""
        self._stop([*self.robots.values()])

    def _stop(self, robots: Sequence[Robot]) -> None:
        for robot in robots:
            with contextlib.suppress(TurtlewireError):
                robot.stop()

    @property
    def lost(self) -> list[str]:
        """Those that cannot be reached."""
        return [name for name, robot in self.robots.items() if robot.link_state in LOST]

    def reach(self) -> None:
        """Wait until those whose links were lost are reached again, and so are stopped; or given up."""
        for name in self.lost:
            with contextlib.suppress(LinkError):
                self.robots[name].reconnected()

    def close(self) -> None:
        """Stop all at once, and let go of them. Raises what one of them had to say, after all were let go."""
        robots = [*self.robots.values()]
        self._stop(robots[1:])  # to let go of the first one stops it, and may take its time then
        self._close(robots)

    def _close(self, robots: Sequence[Robot]) -> None:
        if robots:
            try:
                robots[0].close(finish=False)
            finally:
                self._close(robots[1:])


def as_turtles(turtles: Mapping[str, Turtle]) -> Turtle | Mapping[str, Turtle]:
    """What a program is given: one that has no name of its own is called as Logo calls it."""
    from turtlewire.configuration import PROTOCOLS

    (name, turtle), *others = turtles.items()
    return turtle if not others and name in PROTOCOLS else turtles


def save_picture(robots: Sequence[Robot], path: Path, title: str, *, moves: bool = False) -> None:
    """Draw what all of them drew, each with a colour of its own; an .svg may move.

    Raises ``UsageError`` or ``OutputError``.
    """
    from turtlewire import picture

    first, *others = robots
    picture.save(
        first.trace,
        path,
        title=title,
        obstacles=list(dict.fromkeys(each for robot in robots for each in robot.obstacles)),
        others=[robot.trace for robot in others],
        moves=moves and picture.format_of(path) == ".svg",
    )
