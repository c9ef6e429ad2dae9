"""``turtlewire run PROGRAM``: a Logo program drives a robot, and its picture comes out."""

from __future__ import annotations

import contextlib
import random
from pathlib import Path
from typing import TYPE_CHECKING

from turtlewire.cli import options, preview, program
from turtlewire.cli.progress import Bar
from turtlewire.cli.report import Report
from turtlewire.cli.signals import Interrupted
from turtlewire.errors import (
    LinkClosedError,
    LinkError,
    LinkLostError,
    TurtlewireError,
    UsageError,
)

if TYPE_CHECKING:
    import argparse

    from turtlewire.cli.signals import Signals
    from turtlewire.configuration import Target
    from turtlewire.connect import Robot
    from turtlewire.logo import Interpreter, Position

EXAMPLES = """\
examples:
  turtlewire run rose.logo --picture rose.png
      on a simulated robot, as fast as the processor allows
  turtlewire run rose.logo --port /dev/ttyUSB0
      on the robot at this port
  turtlewire run rose.logo --robot elsie --statistics
      on the robot that robots.toml calls elsie, with figures for a bug report
  turtlewire run --preview rose.logo --port /dev/ttyUSB0
      first says how large the drawing is and how long it takes, and asks
  turtlewire run maze.logo --port "sim:walter?arena=maze.toml&slip=0.02&seed=7"
      on a simulated robot among walls, whose wheels slip
  turtlewire run rose.logo --robot simple --faults lose:0.001,seed:7
      on a simulated car, whose line loses a byte in a thousand
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "run",
        summary="run a Logo program on a robot",
        description="Run a Logo program on a robot. Without --port, a simulated robot in this process runs it.",
        examples=EXAMPLES,
    )
    parser.add_argument("program", metavar="PROGRAM.logo", help="the program; - is the standard input")
    options.add_target(parser, options.PORTS + "; or sim:walter?slip=0.01&arena=FILE, a simulated one")
    parser.add_argument(
        "--faults",
        metavar="FAULTS",
        help="what goes wrong on the way to the robot: lose:0.01,flip:0.001,delay:0.1,seed:7 and more",
    )
    parser.add_argument(
        "--picture",
        metavar="FILE",
        action="append",
        default=[],
        type=Path,
        help="draw it there: .svg or .png, as often as wanted",
    )
    parser.add_argument(
        "--speed", choices=["real", "max"], help="pace of the simulated robot (max)", default=None
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=0,
        metavar="N",
        help="of RANDOM, and of the simulated robot's slip and noise (0)",
    )
    parser.add_argument(
        "--step-mm", type=options.positive, default=1.0, metavar="MM", help="length of a Logo step (1)"
    )
    options.add_require_replies(parser)
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object instead of text, whatever happens"
    )
    parser.add_argument(
        "--statistics",
        action="store_true",
        help="say at the end what the connection was like: for a bug report",
    )
    preview.add_options(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Run the program. Whatever happens, the robot is stopped, the pictures are written, and it is told."""
    name = program.name_of(arguments.program)
    preview.check_options(arguments)
    if arguments.preview is not None:
        code = preview.go_on(arguments, _target(arguments), program.read(arguments.program), name)
        if code is not None:
            return code
    report = Report(name, as_json=arguments.json)
    run = _Run(arguments, signals, report)
    try:
        run.all(name)
    except TurtlewireError as error:
        report.failed(error, run.position)
    except Interrupted as error:
        report.interrupted(error, run.position)
    except BaseException as error:
        # A mistake of ours: main says so; but who waits for JSON gets it.
        report.failed(error)
        if arguments.json:
            report.end(signals.received)
        raise
    for failure in run.not_drawn:
        report.failed(failure)
    return report.end(signals.received)


class _Run:
    """One run, from its options to its pictures.

    Attributes:
        position: where in the program it ended, once that has begun.
        not_drawn: what kept pictures from being written.
    """

    def __init__(self, arguments: argparse.Namespace, signals: Signals, report: Report) -> None:
        self._arguments = arguments
        self._signals = signals
        self._report = report
        self.position: Position | None = None
        self.not_drawn: list[TurtlewireError] = []

    def all(self, name: str) -> None:
        """Everything, in order."""
        from turtlewire import picture
        from turtlewire.connect import connect

        arguments, report = self._arguments, self._report
        target = _target(arguments)
        report.meets(target)
        source = program.read(arguments.program)
        for path in arguments.picture:
            picture.check(path)
        try:
            robot = connect(target, notify=report.notify, announce=report.announce, wrap=report.see)
        except LinkClosedError as error:
            options.explain_refusal(error, target.port)
            raise
        try:
            # Two of them, because the first one's finally may be hit by a signal itself; the second cannot.
            try:
                self._drive(robot, source, name)
            except LinkLostError:
                self._reach(robot)
                raise
            finally:
                self._signals.hold()
        finally:
            if robot.link_state in ("reconnecting", "closed"):
                report.cannot_reach()
            try:
                robot.close(finish=False)
            finally:
                report.measure(robot)
                if arguments.statistics:
                    report.describe()
                self._save_pictures(robot, name)

    def _drive(self, robot: Robot, source: str, name: str) -> None:
        """Run the program to its end and the robot to its last motion."""
        from turtlewire.cli.typed import TypedPast
        from turtlewire.deviation import Followed
        from turtlewire.logo import Interpreter

        arguments, report = self._arguments, self._report
        origin, turtle = robot.trace.pose, Followed(robot)
        interpreter = Interpreter(
            turtle,
            report.keep_output,
            random.Random(arguments.seed),
            step_mm=arguments.step_mm,
            compiled_at=program.compiled_at(),
        )
        try:
            with Bar(robot, interpreter.progress, shown=not arguments.json) as bar:
                if not arguments.json:
                    interpreter.write = bar.write
                interpreter.streams.keyboard = TypedPast(bar)
                interpreter.run(source, name)
                self._finish(robot, interpreter)
                report.deviates(robot, turtle, origin)
        finally:
            self.position = interpreter.position

    def _reach(self, robot: Robot) -> None:
        """The link was lost, and the program with it: wait until the robot is reached again, and so is stopped."""
        self._report.waits()
        # In vain, or not for so long: the report says that it was not stopped. Why, the driver has told.
        with contextlib.suppress(LinkError, Interrupted):
            robot.reconnected()
            self._report.reached()

    def _finish(self, robot: Robot, interpreter: Interpreter) -> None:
        """The program is through; the robot may have some of it to do yet."""
        try:
            robot.finish()
            self._report.finished(robot)
        except TurtlewireError as error:
            position = interpreter.position
            if position is not None:
                error.add_note(f"in the last motions of {position.file}, whose end is line {position.line}")
            raise

    def _save_pictures(self, robot: Robot, name: str) -> None:
        """Write the pictures of what was drawn so far. One that fails keeps none of the others from being written."""
        from turtlewire import picture

        for path in dict.fromkeys(self._arguments.picture):
            try:
                picture.save(robot.trace, path, title=name, obstacles=robot.obstacles)
            except TurtlewireError as error:
                self.not_drawn.append(error)
            else:
                self._report.drawn(path)


def _target(arguments: argparse.Namespace) -> Target:
    """The robot; a simulated one gets the seed and the pace that it does not name itself."""
    from turtlewire.configuration import target
    from turtlewire.simulated import simulated

    found = options.target(arguments) or options.with_settings(target("sim:walter"), arguments.set)
    if arguments.faults is not None:
        from turtlewire.links.faults import Faults

        found = found._replace(faults=Faults.parse(arguments.faults))
    if arguments.require_replies:
        found = options.with_replies(found)
    found.settings()  # complain of them before anything is opened
    if not found.is_simulated:
        if arguments.speed == "max":
            raise UsageError("--speed max is for the simulated robot; a robot at a port takes its own time")
        return found
    simulated(found)
    if "pace" in found.simulation and arguments.speed is not None:
        raise UsageError(f"--speed {arguments.speed} and {found.name!r} both say how fast: leave one out")
    defaults = {"seed": str(arguments.seed), "pace": arguments.speed or "max"}
    return found._replace(simulation={**defaults, **found.simulation})
