"""``turtlewire run PROGRAM``: a Logo program drives a robot, and its picture comes out."""

from __future__ import annotations

import contextlib
import random
from pathlib import Path
from typing import TYPE_CHECKING

from turtlewire.cli import options, preview, program
from turtlewire.cli.connected import Connected, as_turtles, save_picture
from turtlewire.cli.progress import Bar
from turtlewire.cli.report import Report
from turtlewire.cli.signals import Interrupted
from turtlewire.errors import LinkLostError, TurtlewireError, UsageError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Mapping

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
  turtlewire run dance.logo --robot elsie --port rosa=sim:simple
      on two robots, of different kinds: TELL "ROSA, TELL [ELSIE ROSA]
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
        summary="run a Logo program on a robot, or on several",
        description="Run a Logo program on a robot, or on several, which it tells by their names. Without --port, a "
        "simulated robot in this process runs it.",
        examples=EXAMPLES,
    )
    parser.add_argument("program", metavar="PROGRAM.logo", help="the program; - is the standard input")
    options.add_targets(parser, options.PORTS + "; or sim:walter?slip=0.01&arena=FILE, a simulated one")
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
    program.bound_memory()
    if arguments.preview is not None:
        code = preview.go_on(arguments, _targets(arguments), program.read(arguments.program), name)
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

        arguments, report = self._arguments, self._report
        targets = _targets(arguments)
        report.meets(targets)
        source = program.read(arguments.program)
        for path in arguments.picture:
            picture.check(path)
        robots = Connected(
            targets, report.notify, report.announce, lambda of, link: report.robots[of].see(link)
        )
        try:
            # Two of them, because the first one's finally may be hit by a signal itself; the second cannot.
            try:
                self._drive(robots.robots, source, name)
            except LinkLostError:
                robots.stop()  # those that are there
                self._reach(robots)
                raise
            finally:
                self._signals.hold()
        finally:
            for lost in robots.lost:
                report.cannot_reach(lost)
            try:
                robots.close()
            finally:
                report.measure(robots.robots)
                if arguments.statistics:
                    for each in report.robots.values():
                        each.describe()
                self._save_pictures(robots.robots, name)

    def _drive(self, robots: Mapping[str, Robot], source: str, name: str) -> None:
        """Run the program to its end and the robots to their last motions."""
        from turtlewire.cli.typed import TypedPast
        from turtlewire.deviation import Followed
        from turtlewire.logo import Interpreter

        arguments, report = self._arguments, self._report
        origins = {each: robot.trace.pose for each, robot in robots.items()}
        turtles = {each: Followed(robot) for each, robot in robots.items()}
        interpreter = Interpreter(
            as_turtles(turtles),
            report.keep_output,
            random.Random(arguments.seed),
            step_mm=arguments.step_mm,
            compiled_at=program.compiled_at(),
        )
        try:
            with Bar([*robots.values()], interpreter.progress, shown=not arguments.json) as bar:
                if not arguments.json:
                    interpreter.write = bar.write
                interpreter.streams.keyboard = TypedPast(bar)
                interpreter.run(source, name)
                for each, robot in robots.items():
                    self._finish(each, robot, interpreter)
                for each, robot in robots.items():
                    report.robots[each].deviates(robot, turtles[each], origins[each])
        finally:
            self.position = interpreter.position

    def _reach(self, robots: Connected) -> None:
        """Links were lost, and the program with them: wait until the robots are reached again, and so are stopped."""
        self._report.waits(robots.lost)
        # In vain, or not for so long: the report says that they were not stopped. Why, the driver has told.
        with contextlib.suppress(Interrupted):
            robots.reach()
            if not robots.lost:
                self._report.reached()

    def _finish(self, name: str, robot: Robot, interpreter: Interpreter) -> None:
        """The program is through; the robot may have some of it to do yet."""
        try:
            robot.finish()
            self._report.robots[name].finished(robot)
        except TurtlewireError as error:
            position = interpreter.position
            if position is not None:
                error.add_note(f"in the last motions of {position.file}, whose end is line {position.line}")
            raise

    def _save_pictures(self, robots: Mapping[str, Robot], name: str) -> None:
        """Write the pictures of what was drawn so far. One that fails keeps none of the others from being written."""
        for path in dict.fromkeys(self._arguments.picture):
            try:
                save_picture([*robots.values()], path, name)
            except TurtlewireError as error:
                self.not_drawn.append(error)
            else:
                self._report.drawn(path)


def _targets(arguments: argparse.Namespace) -> dict[str, Target]:
    """The robots by their names; simulated ones get the seed and the pace that they do not name themselves."""
    from turtlewire.configuration import target

    found = options.targets(arguments)
    if not found:
        found = {"walter": options.with_settings(target("sim:walter"), arguments.set)}
    if arguments.speed == "max" and any(not each.is_simulated for each in found.values()):
        raise UsageError("--speed max is for the simulated robot; a robot at a port takes its own time")
    # Beside a robot that takes its time the others take theirs.
    pace = arguments.speed or ("max" if all(each.is_simulated for each in found.values()) else "real")
    return {
        name: _with_options(each, arguments, pace, arguments.seed + number)
        for number, (name, each) in enumerate(found.items())
    }


def _with_options(found: Target, arguments: argparse.Namespace, pace: str, seed: int) -> Target:
    """A robot as the options want it; each simulated one has a chance of its own. Raises ``UsageError``."""
    from turtlewire.simulated import simulated

    if arguments.faults is not None:
        from turtlewire.links.faults import Faults

        found = found._replace(faults=Faults.parse(arguments.faults))
    if arguments.require_replies:
        found = options.with_replies(found)
    found.settings()  # complain of them before anything is opened
    if not found.is_simulated:
        return found
    simulated(found)
    if "pace" in found.simulation and arguments.speed is not None:
        raise UsageError(f"--speed {arguments.speed} and {found.name!r} both say how fast: leave one out")
    return found._replace(simulation={"seed": str(seed), "pace": pace, **found.simulation})
