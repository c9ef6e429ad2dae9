"""What people, or with ``--json`` programs, are told of a run: while it goes on, and how it ended."""

from __future__ import annotations

import json
import time
from typing import TYPE_CHECKING, Any

from turtlewire.cli import output
from turtlewire.cli.progress import duration
from turtlewire.cli.signals import INTERRUPTED, Interrupted
from turtlewire.errors import LinkError, TurtlewireError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from turtlewire.configuration import Target
    from turtlewire.connect import Robot
    from turtlewire.deviation import Followed
    from turtlewire.links.link import Link
    from turtlewire.logo import Position
    from turtlewire.turtle import Pose

# What is compared with the exact path.
DRAWINGS = {
    "seen": "as seen",
    "reported": "as the robot reports its way",
    "reckoned": "by reckoning; the robot cannot tell its way",
}


class Report:
    """Gathers what is known of a run; ``end`` tells it, however the run ended.

    Args:
        program: what the program is called.
        as_json: gather everything, the program's output too, into one JSON object.
    """

    def __init__(self, program: str, *, as_json: bool) -> None:
        self._as_json = as_json
        # The robot is a real one, or somebody else's: it takes its own time, and has to be stopped.
        self._is_real = False
        self._connection: dict[str, Any] = {}
        self._started = time.perf_counter()
        self._output: list[str] = []
        self._errors: list[str] = []
        self._is_reachable = True
        self._was_reached_again = False
        self._result: dict[str, Any] = {
            "outcome": "done",
            "exit_code": 0,
            "program": program,
            "error": None,
            "warnings": [],
            "pictures": [],
            "statistics": None,
            "robot_pose": None,
            "host_pose": None,
            "deviation_mm": None,
            "drawing": None,
            "host_seconds": 0.0,
        }

    def meets(self, target: Target) -> None:
        """Which robot it is."""
        self._target = target
        self._is_real = not target.is_simulated

    def see(self, link: Link) -> Link:
        """The link to it, as it is."""
        self._link = link
        return link

    def notify(self, text: str) -> None:
        """A warning of the driver."""
        self._result["warnings"].append(text)
        if not self._as_json:
            output.tell(f"turtlewire: {text}")

    def announce(self, path: str) -> None:
        """Where the robot has to be, for a new pty."""
        output.tell(f"waiting for the robot at {path}")

    def waits(self) -> None:
        """The link was lost, which has ended the program; the robot is to be stopped yet."""
        if self._is_real:
            output.tell(
                "turtlewire: the program has ended. Waiting until the robot is reached again, and stopped; Ctrl-C ends "
                "the waiting"
            )

    def reached(self) -> None:
        """It was, and stands."""
        self._was_reached_again = True

    def cannot_reach(self) -> None:
        """When all is over, there is no link to the robot."""
        self._is_reachable = False

    def keep_output(self, text: str) -> None:
        """Output of the program, for ``--json``."""
        self._output.append(text)

    def finished(self, robot: Robot) -> None:
        """The program is done: where is the robot, and where does it say that it is, if it can?"""
        from turtlewire.robots.walter import Walter

        if isinstance(robot, Walter) and "Q" in robot.groups:
            self._result["robot_pose"] = robot.reported_pose()._asdict()
        self._result["host_pose"] = robot.pose._asdict()

    def deviates(self, robot: Robot, turtle: Followed, origin: Pose) -> None:
        """What was drawn is compared with what should have been; ``origin``: the turtle's home, as the drawing has it.

        For a robot that cannot be seen, what was drawn is where it says that it went, or where it should have gone.
        """
        from turtlewire.deviation import between

        says = "Q" in getattr(robot, "groups", ())
        self._result["drawing"] = (
            "reported" if says and self._is_real else "reckoned" if self._is_real else "seen"
        )
        found = between(robot.trace, turtle.ideal, origin) if turtle.is_exact else None
        self._result["deviation_mm"] = found and found._asdict()

    def measure(self, robot: Robot) -> None:
        """The figures of the connection, however far it came."""
        self._result["statistics"] = robot.statistics._asdict()
        self._result["host_seconds"] = time.perf_counter() - self._started

    def describe(self) -> None:
        """What the connection was like: what people can put into a bug report."""
        import platform
        from importlib.metadata import version

        from turtlewire.links.faults import FaultyLink

        target, link = self._target, self._link
        self._connection = {
            "turtlewire": version("turtlewire"),
            "system": f"Python {platform.python_version()} on {platform.platform()}",
            "robot": target.protocol,
            "port": target.port,
            "settings": {**target.simulation, **{k: str(v) for k, v in target.overrides.items()}},
        }
        if isinstance(link, FaultyLink):
            self._connection["faults"] = {
                name: getattr(link, name) for name in ("lost", "added", "flipped", "duplicated")
            }
        self._result["connection"] = self._connection

    def drawn(self, path: Path) -> None:
        """A picture was written."""
        self._result["pictures"].append(str(path))

    def interrupted(self, error: Interrupted, position: Position | None) -> None:
        """A signal ended the run, at a place in the program if it had begun."""
        place = f" at {position.file}, line {position.line}" if position is not None else ""
        self._fail("interrupted", INTERRUPTED, error, f"interrupted ({error}){place}", position)

    def failed(self, error: BaseException, position: Position | None = None) -> None:
        """An error ended the run, or what comes after it; the first one counts.

        ``position`` is where the program was, for an error that does not know a place itself.
        """
        code = error.exit_code if isinstance(error, TurtlewireError) else 1
        if isinstance(error, LinkError) and not self._was_reached_again:
            self.cannot_reach()
        message = "\n".join([str(error) or type(error).__name__, *getattr(error, "__notes__", [])])
        self._fail("error", code, error, message, getattr(error, "position", None) or position)

    def _fail(
        self, outcome: str, code: int, error: BaseException, message: str, position: Position | None
    ) -> None:
        self._errors.append(message)
        if self._result["error"] is not None:
            return
        place = (
            {"file": position.file, "line": position.line, "column": position.column} if position else None
        )
        self._result["outcome"], self._result["exit_code"] = outcome, code
        self._result["error"] = {"type": type(error).__name__, "message": message, "position": place}

    def end(self, received: str) -> int:
        """Tell how it went; return the exit code. ``received``: the signal that came, if any.

        Raises ``OutputError`` if nobody takes what goes to standard output.
        """
        if received and self._result["error"] is None:
            # It came when all was done but the telling.
            self._result["exit_code"] = INTERRUPTED
        if self._as_json:
            output.write(json.dumps(self._result | {"output": "".join(self._output)}) + "\n")
        elif self._errors:
            output.tell(
                "\n".join([*(f"turtlewire: {error}" for error in self._errors), *self._what_is_left()])
            )
        else:
            output.tell("\n".join(self._summary()))
        if self._connection and not self._as_json:
            output.tell("\n".join(["statistics:", *_lines(self._connection | self._result["statistics"])]))
        code: int = self._result["exit_code"]
        return code

    def _what_is_left(self) -> Iterator[str]:
        """After an error: the state of the robot and of the drawing."""
        figures = self._result["statistics"]
        if figures is None:
            return
        if self._is_real and self._is_reachable:
            yield f"The robot was stopped, after {figures['distance_mm'] / 1000:.2f} m."
        elif self._is_real:
            yield "The robot cannot be reached to stop it: if it still moves, switch it off."
        if self._result["pictures"]:
            yield f"What was drawn until then is in {', '.join(self._result['pictures'])}."

    def _summary(self) -> Iterator[str]:
        figures, robot = self._result["statistics"], self._result["robot_pose"]
        # Those that are driven by set-points have neither commands to count nor a pose to tell.
        answers = "commands" in figures
        robot_s, host_s = figures["seconds"], self._result["host_seconds"]
        yield f"{self._result['program']}: done"
        counted = (
            f"{figures['commands']} commands ({figures['fences']} of them fences) in " if answers else ""
        )
        yield f"  sent       {counted}{figures['bytes_sent']} bytes; {figures['bytes_received']} bytes came back"
        yield f"  driven     {figures['distance_mm'] / 1000:.2f} m in {duration(robot_s)} of the robot's time"
        if not self._is_real:
            yield f"  took       {duration(host_s)} ({robot_s / host_s:.0f} times as fast as the robot)"
        yield f"  host pose  {_pose(self._result['host_pose'])}"
        if answers:
            yield f"  robot pose {_pose(robot) if robot else 'it cannot tell'}"
        yield from self._deviation()
        if figures.get("corrections"):
            yield f"  corrected  {figures['corrections']} times: the robot was not where it should have been"
        if self._result["pictures"]:
            yield f"  drawn      {', '.join(self._result['pictures'])}"

    def _deviation(self) -> Iterator[str]:
        deviation, drawing = self._result["deviation_mm"], self._result["drawing"]
        if deviation:
            yield (
                f"  deviation  {deviation['largest']:.2f} mm at most, {deviation['mean']:.2f} mm on average, "
                f"from the exact path ({DRAWINGS[drawing]})"
            )


def _pose(pose: dict[str, float]) -> str:
    # + 0.0 makes a plain zero of a negative one.
    x, y, heading = (round(pose[key], 3) + 0.0 for key in ("x_mm", "y_mm", "heading_deg"))
    return f"x {x:g} mm, y {y:g} mm, heading {heading % 360.0:g} degrees"


def _lines(figures: Mapping[str, object]) -> Iterator[str]:
    for name, value in figures.items():
        if isinstance(value, dict):
            text = ", ".join(f"{key} {part}" for key, part in value.items()) or "as by default"
        else:
            text = f"{value:.10g}" if isinstance(value, float) else "-" if value is None else str(value)
        yield f"  {name:20} {text}"
