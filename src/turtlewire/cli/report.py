"""What people, or with ``--json`` programs, are told of a run: while it goes on, and how it ended."""

from __future__ import annotations

import json
import time
from typing import TYPE_CHECKING, Any

from turtlewire.cli import output
from turtlewire.cli.robot_report import UNKNOWN, RobotReport
from turtlewire.cli.signals import INTERRUPTED, Interrupted
from turtlewire.errors import LinkError, TurtlewireError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from turtlewire.configuration import Target
    from turtlewire.connect import Robot
    from turtlewire.logo import Position


class Report:
    """Gathers what is known of a run; ``end`` tells it, however the run ended.

    Args:
        program: what the program is called.
        as_json: gather everything, the program's output too, into one JSON object.

    Attributes:
        robots: what is known of each robot, by its name.
    """

    def __init__(self, program: str, *, as_json: bool) -> None:
        self._as_json = as_json
        self.robots: dict[str, RobotReport] = {}
        self._started = time.perf_counter()
        self._output: list[str] = []
        self._errors: list[str] = []
        self._was_reached_again = False
        self._result: dict[str, Any] = {
            "outcome": "done",
            "exit_code": 0,
            "program": program,
            "error": None,
            "warnings": [],
            "pictures": [],
            "host_seconds": 0.0,
        }

    def meets(self, targets: Mapping[str, Target]) -> None:
        """Which robots they are."""
        self.robots = {name: RobotReport(target) for name, target in targets.items()}

    def notify(self, name: str, text: str) -> None:
        """A warning of the driver of this robot."""
        told = text if len(self.robots) == 1 else f"{name}: {text}"
        self._result["warnings"].append(told)
        if not self._as_json:
            output.tell(f"turtlewire: {told}")

    def announce(self, path: str) -> None:
        """Where the robot has to be, for a new pty."""
        output.tell(f"waiting for the robot at {path}")

    def waits(self, names: list[str]) -> None:
        """The links to these were lost, which has ended the program; they are to be stopped yet."""
        if any(self.robots[name].is_real for name in names):
            which = "the robot" if len(self.robots) == 1 else " and ".join(names)
            output.tell(
                f"turtlewire: the program has ended. Waiting until {which} {'are' if len(names) > 1 else 'is'} reached "
                "again, and stopped; Ctrl-C ends the waiting"
            )

    def reached(self) -> None:
        """All of them were, and stand."""
        self._was_reached_again = True

    def cannot_reach(self, name: str) -> None:
        """When all is over, there is no link to this robot."""
        self.robots[name].is_reachable = False

    def keep_output(self, text: str) -> None:
        """Output of the program, for ``--json``."""
        self._output.append(text)

    def measure(self, robots: Mapping[str, Robot]) -> None:
        """The figures of the connections, however far they came."""
        for name, robot in robots.items():
            self.robots[name].measure(robot)
        self._result["host_seconds"] = time.perf_counter() - self._started

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
        if isinstance(error, LinkError) and not self._was_reached_again and len(self.robots) == 1:
            self.cannot_reach(*self.robots)
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
            output.write(json.dumps(self._all()) + "\n")
        elif self._errors:
            output.tell(
                "\n".join([*(f"turtlewire: {error}" for error in self._errors), *self._what_is_left()])
            )
        else:
            output.tell("\n".join(self._summary()))
        if not self._as_json:
            for name, robot in self.robots.items():
                if robot.connection:
                    of = "" if len(self.robots) == 1 else f" of {name}"
                    output.tell("\n".join([f"statistics{of}:", *robot.statistics()]))
        code: int = self._result["exit_code"]
        return code

    def _all(self) -> dict[str, Any]:
        """Everything: of one robot as it is, of several by their names."""
        told = self._result | {"output": "".join(self._output)}
        if len(self.robots) < 2:
            return told | next((robot.result for robot in self.robots.values()), UNKNOWN)
        return told | {"robots": {name: robot.result for name, robot in self.robots.items()}}

    def _what_is_left(self) -> Iterator[str]:
        """After an error: the state of the robots and of the drawing."""
        for name, robot in self.robots.items():
            yield from robot.state("The robot" if len(self.robots) == 1 else name)
        if self._result["pictures"]:
            yield f"What was drawn until then is in {', '.join(self._result['pictures'])}."

    def _summary(self) -> Iterator[str]:
        host_s = self._result["host_seconds"]
        yield f"{self._result['program']}: done"
        for name, robot in self.robots.items():
            if len(self.robots) > 1:
                yield f"{name}:"
            yield from robot.summary(host_s)
        if self._result["pictures"]:
            lead = "  drawn      " if len(self.robots) == 1 else "drawn: "
            yield f"{lead}{', '.join(self._result['pictures'])}"
