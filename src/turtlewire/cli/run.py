"""``turtlewire run PROGRAM``: a Logo program drives a robot, and its picture comes out."""

from __future__ import annotations

import random
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from turtlewire.cli import options
from turtlewire.cli.progress import Bar
from turtlewire.cli.report import Report
from turtlewire.cli.signals import Interrupted
from turtlewire.errors import DataError, LinkClosedError, TurtlewireError, UsageError

if TYPE_CHECKING:
    import argparse

    from turtlewire.cli.signals import Signals
    from turtlewire.logo import Interpreter, Position
    from turtlewire.robots.walter import Walter

EXAMPLES = """\
examples:
  turtlewire run rose.logo --picture rose.png
      on a simulated robot, as fast as the processor allows
  turtlewire run rose.logo --port /dev/ttyUSB0
      on the robot at this port
  turtlewire run maze.logo --port "sim:walter?arena=maze.toml&slip=0.02&seed=7"
      on a simulated robot among walls, whose wheels slip
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
    parser.add_argument("--robot", choices=["walter"], default="walter", help="what robot it is (walter)")
    parser.add_argument(
        "--port", metavar="URL", help=options.PORTS + "; or sim:walter?slip=0.01&arena=FILE, a simulated one"
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
    options.add_settings(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Run the program. Whatever happens, the robot is stopped, the pictures are written, and it is told."""
    name = "standard input" if arguments.program == "-" else arguments.program
    is_real = arguments.port is not None and not arguments.port.startswith("sim:")
    report = Report(name, as_json=arguments.json, is_real=is_real)
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
        url = _url(arguments)
        source = _read(arguments.program)
        for path in arguments.picture:
            picture.check(path)
        settings = options.settings(arguments.set, require_replies=arguments.require_replies)
        try:
            robot = connect(url, settings, notify=report.notify, announce=report.announce)
        except LinkClosedError as error:
            options.explain_refusal(error, url)
            raise
        try:
            # Two of them, because the first one's finally may be hit by a signal itself; the second cannot.
            try:
                self._drive(robot, source, name)
            finally:
                self._signals.hold()
        finally:
            try:
                robot.close(finish=False)
            finally:
                report.measure(robot)
                self._save_pictures(robot, name)

    def _drive(self, robot: Walter, source: str, name: str) -> None:
        """Run the program to its end and the robot to its last motion."""
        from turtlewire.logo import Interpreter

        arguments, report = self._arguments, self._report
        interpreter = Interpreter(
            robot, report.keep_output, random.Random(arguments.seed), step_mm=arguments.step_mm
        )
        try:
            with Bar(robot, interpreter.progress, shown=not arguments.json) as bar:
                if not arguments.json:
                    interpreter.write = bar.write
                interpreter.run(source, name)
                self._finish(robot, interpreter)
        finally:
            self.position = interpreter.position

    def _finish(self, robot: Walter, interpreter: Interpreter) -> None:
        """The program is through; the robot may have some of it to do yet."""
        try:
            robot.finish()
            self._report.finished(robot)
        except TurtlewireError as error:
            position = interpreter.position
            if position is not None:
                error.add_note(f"in the last motions of {position.file}, whose end is line {position.line}")
            raise

    def _save_pictures(self, robot: Walter, name: str) -> None:
        """Write the pictures of what was drawn so far. One that fails keeps none of the others from being written."""
        from turtlewire import picture

        for path in dict.fromkeys(self._arguments.picture):
            try:
                picture.save(robot.trace, path, title=name, walls=robot.walls)
            except TurtlewireError as error:
                self.not_drawn.append(error)
            else:
                self._report.drawn(path)


def _read(program: str) -> str:
    """The text of a program."""
    try:
        data = Path(program).read_bytes() if program != "-" else sys.stdin.buffer.read() if sys.stdin else b""
        # Windows' Notepad begins a file with a mark, and ends lines with CR LF.
        return data.decode("utf-8-sig").replace("\r\n", "\n")
    except OSError as error:
        raise DataError(f"cannot read the program {program}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise DataError(
            f"{program} is not text in UTF-8: in line {line}, byte {error.start} is {error.object[error.start]:02X}. "
            "Save it as UTF-8"
        ) from error


def _url(arguments: argparse.Namespace) -> str:
    """The robot's URL; a simulated one gets the seed and the pace that it does not name itself."""
    from urllib.parse import parse_qsl, urlsplit

    from turtlewire.connect import simulated

    port: str | None = arguments.port
    if port is not None and not port.startswith("sim:"):
        if arguments.speed == "max":
            raise UsageError("--speed max is for the simulated robot; a robot at a port takes its own time")
        return port
    url = port or f"sim:{arguments.robot}"
    # A complaint is to name the URL as it was given.
    simulated(url)
    given = dict(parse_qsl(urlsplit(url).query))
    if "pace" in given and arguments.speed is not None:
        raise UsageError(f"--speed {arguments.speed} and {url!r} both say how fast: leave one out")
    defaults = {"seed": str(arguments.seed), "pace": arguments.speed or "max"}
    for key, value in defaults.items():
        if key not in given:
            url += f"{'&' if '?' in url else '?'}{key}={value}"
    return url
