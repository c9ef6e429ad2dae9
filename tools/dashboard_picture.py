"""Makes docs/pictures/drive.svg: the dashboard of ``turtlewire drive``, while somebody drives through the maze.

python -m tools.dashboard_picture > docs/pictures/drive.svg

The robot is a simulated one, in virtual time, so that the picture is the same each time.
"""

from __future__ import annotations

import asyncio
import re
import sys
from typing import TYPE_CHECKING, Any, cast

from tools.generators.python import ROOT
from turtlewire.configuration import target
from turtlewire.connect import connect_async
from turtlewire.dashboard.app import HOLD, Dashboard
from turtlewire.dashboard.controls import Controls
from turtlewire.dashboard.layouts import layout
from turtlewire.helm.sight import Ear, Sight
from turtlewire.helm.view import Notice
from turtlewire.helm.wire import Tap
from turtlewire.robots.runner import InlineRunner

if TYPE_CHECKING:
    from turtlewire.configuration import Target
    from turtlewire.helm.helm import Helm
    from turtlewire.helm.view import View
    from turtlewire.links.link import Link

SIZE = (100, 30)
LOOK_S = 0.08
# Speed, turn and seconds.
WAY = [
    (0.4, 0.0, 0.5),
    (0.0, 0.4, 0.885),
    (0.4, 0.0, 2.95),
    (0.0, -0.4, 0.885),
    (0.4, 0.0, 2.8),
    (0.0, 0.4, 0.885),
    (0.4, 0.0, 2.4),
]


class VirtualEar(Ear):
    """One that leaves the time virtual."""

    def __call__(self, link: Link) -> Link:
        """Listen to this link."""
        self.link = Tap(link, self.messages)
        return self.link


class Still:
    """What a dashboard sees of a helm that has been at work, and is not any more."""

    refused = 0
    title = "simulated WALTER"

    def __init__(self, robot: Any, sight: Sight) -> None:
        self.features, self.obstacles = robot.features, sight.obstacles
        self.notices = [Notice(0.0, "note", HOLD)]
        self._sight = sight
        self.view: View
        self.look()

    def look(self) -> None:
        """See where the robot is now."""
        self.view = self._sight.look(tuple(self.notices), is_over=False)

    def nothing(self, *_: object) -> None:
        """It does nothing any more."""

    steer = stop = do = note = nothing


async def _drive(app: Dashboard, still: Still, robot: Any, link: Link, runner: InlineRunner) -> None:
    for speed, turn, seconds in WAY:
        runner.run(robot.drive(speed, turn))
        until = link.now() + seconds
        while link.now() < until:
            runner.run(robot._wire.until(lambda: False, min(until, link.now() + LOOK_S)))
            still.look()
            app.show_all()
    app.show_all()


def picture() -> str:
    """The picture, as SVG."""
    maze: Target = target(f"sim:walter?arena={ROOT}/examples/maze.toml")
    ear, runner = VirtualEar(maze, 1.0), InlineRunner()
    robot = runner.run(connect_async(maze, notify=lambda _: None, wrap=ear))
    still = Still(robot, Sight(robot, ear, is_seen=True))
    controls = Controls(layout("walter"), speed=102, has_full_lock=False, first_s=1e6, hold_s=1e6)
    app = Dashboard(cast("Helm", still), controls)

    async def show() -> str:
        async with app.run_test(size=SIZE) as pilot:
            await pilot.press("up")
            await _drive(app, still, robot, ear.link, runner)
            await pilot.pause()
            return app.export_screenshot(title="turtlewire drive")

    try:
        return _at_home(asyncio.run(show()))
    finally:
        runner.run(robot.close(finish=False))


def _at_home(svg: str) -> str:
    """Without fonts from elsewhere: a picture in a page may not load any."""
    svg = re.sub(r"\s*@font-face \{.*?\n    \}\n", "\n", svg, flags=re.DOTALL)
    return re.sub(r"font-family: [^;]+;", "font-family: monospace;", svg)


if __name__ == "__main__":
    sys.stdout.write(picture())
