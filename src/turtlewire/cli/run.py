"""``turtlewire run PROGRAM``: a Logo program drives a robot, and its picture comes out."""

from __future__ import annotations

import json
import random
import signal
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from turtlewire.cli import options
from turtlewire.errors import DataError, TurtlewireError, UsageError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable, Iterator

    from turtlewire.robots.walter import Walter

REFRESH_S = 0.1


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = commands.add_parser(
        "run",
        help="run a Logo program on a robot",
        description="Run a Logo program on a robot. Without --port, a simulated robot in this process runs it.",
    )
    parser.add_argument("program", metavar="PROGRAM.logo", help="the program; - is the standard input")
    parser.add_argument("--robot", choices=["walter"], default="walter", help="what robot it is (walter)")
    parser.add_argument(
        "--port", metavar="URL", help=options.PORTS + "; or sim:walter?slip=0.01&arena=FILE, a simulated one"
    )
    parser.add_argument(
        "--picture", metavar="FILE", action="append", default=[], type=Path, help="draw it there (.svg, .png)"
    )
    parser.add_argument(
        "--speed", choices=["real", "max"], help="pace of the simulated robot (max)", default=None
    )
    parser.add_argument(
        "--seed", type=int, default=0, help="of RANDOM, and of the simulated robot's slip and noise (0)"
    )
    parser.add_argument("--step-mm", type=options.positive, default=1.0, help="length of a Logo step (1)")
    parser.add_argument(
        "--require-replies", action="store_true", help="refuse a robot that answers no queries"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")
    options.add_settings(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Run the program. Whatever happens, the robot is stopped and the pictures are written."""
    from turtlewire import picture
    from turtlewire.connect import connect

    name, source = _read(arguments.program)
    for path in arguments.picture:
        picture.check(path)
    settings = options.settings(arguments.set, require_replies=arguments.require_replies)
    report = _Report(arguments, name)
    robot = connect(_url(arguments), settings, notify=report.notify, announce=report.announce)
    try:
        report.run(robot, source, name)
    except KeyboardInterrupt:
        # From here on only the stop counts, which takes no longer than its bytes.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        raise
    finally:
        try:
            robot.close(finish=False)
        finally:
            report.save_pictures(robot, arguments.picture)
    return report.end()


def _read(program: str) -> tuple[str, str]:
    """The name and the text of a program."""
    if program == "-":
        return "standard input", sys.stdin.read()
    try:
        return program, Path(program).read_text("utf-8")
    except OSError as error:
        raise DataError(f"cannot read the program {program}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise DataError(
            f"{program} is not text in UTF-8: byte {error.start} is {error.object[error.start]:02X}"
        ) from error


def _url(arguments: argparse.Namespace) -> str:
    port: str | None = arguments.port
    if port is not None and not port.startswith("sim:"):
        if arguments.speed == "max":
            raise UsageError("--speed max is for the simulated robot; a robot at a port takes its own time")
        return port
    url = port or f"sim:{arguments.robot}"
    defaults = {"seed": str(arguments.seed), "pace": arguments.speed or "max"}
    for key, value in defaults.items():
        if f"{key}=" not in url:
            url += f"{'&' if '?' in url else '?'}{key}={value}"
    return url


class _Report:
    """What people, or machines, are told while the program runs and afterwards."""

    def __init__(self, arguments: argparse.Namespace, name: str) -> None:
        self._json: bool = arguments.json
        self._seed: int = arguments.seed
        self._step_mm: float = arguments.step_mm
        self._started = time.perf_counter()
        self._output: list[str] = []
        self._result: dict[str, Any] = {"program": name, "warnings": [], "pictures": []}

    def notify(self, text: str) -> None:
        """A warning of the driver."""
        self._result["warnings"].append(text)
        if not self._json:
            print(f"turtlewire: {text}", file=sys.stderr)

    def announce(self, path: str) -> None:
        """Where the robot has to be, for a new pty."""
        print(f"waiting for the robot at {path}", file=sys.stderr, flush=True)

    def run(self, robot: Walter, source: str, name: str) -> None:
        """Run the program to its end and the robot to its last motion."""
        from turtlewire.logo import Interpreter

        with _Progress(robot, quiet=self._json) as progress:
            write = self._output.append if self._json else progress.write
            interpreter = Interpreter(
                robot, write=write, random=random.Random(self._seed), step_mm=self._step_mm
            )
            progress.watch(interpreter.progress)
            try:
                interpreter.run(source, name)
                robot.finish()
                self._measure(robot)
            except (TurtlewireError, KeyboardInterrupt) as error:
                self._result["statistics"] = robot.statistics._asdict()
                self._fail(error)
                raise

    def _measure(self, robot: Walter) -> None:
        reported = robot.reported_pose() if "Q" in robot.groups else None
        statistics = robot.statistics
        self._result |= {
            "outcome": "done",
            "statistics": statistics._asdict(),
            "robot_pose": reported and reported._asdict(),
            "host_pose": robot.pose._asdict(),
            "host_seconds": time.perf_counter() - self._started,
        }

    def _fail(self, error: BaseException) -> None:
        self._result["outcome"] = "error" if isinstance(error, TurtlewireError) else "interrupted"
        self._result["error"] = {
            "type": type(error).__name__,
            "message": "\n".join([str(error), *getattr(error, "__notes__", [])]),
        }
        if self._json:
            self._print_json()

    def save_pictures(self, robot: Walter, paths: list[Path]) -> None:
        """Write the pictures of what was drawn so far."""
        from turtlewire import picture

        for path in paths:
            picture.save(robot.trace, path, title=self._result["program"], walls=robot.walls)
            self._result["pictures"].append(str(path))

    def end(self) -> int:
        """Tell how it went."""
        if self._json:
            self._print_json()
        else:
            print("\n".join(self._summary()), file=sys.stderr)
        return 0

    def _print_json(self) -> None:
        print(json.dumps(self._result | {"output": "".join(self._output)}))

    def _summary(self) -> Iterator[str]:
        figures, host = self._result["statistics"], self._result["host_pose"]
        robot = self._result["robot_pose"]
        robot_s, host_s = figures["seconds"], self._result["host_seconds"]
        yield f"{self._result['program']}: done"
        yield (
            f"  sent       {figures['commands']} commands ({figures['fences']} of them fences) "
            f"in {figures['bytes_sent']} bytes; {figures['bytes_received']} bytes came back"
        )
        yield f"  driven     {figures['distance_mm'] / 1000:.2f} m in {_duration(robot_s)} of the robot's time"
        yield f"  took       {_duration(host_s)} ({robot_s / host_s:.0f} times as fast as the robot)"
        yield f"  host pose  {_pose(host)}"
        yield f"  robot pose {_pose(robot) if robot else 'it cannot tell'}"
        if figures["corrections"]:
            yield f"  corrected  {figures['corrections']} times: the robot was not where it should have been"
        if self._result["pictures"]:
            yield f"  drawn      {', '.join(self._result['pictures'])}"


def _duration(seconds: float) -> str:
    minutes, rest = divmod(seconds, 60.0)
    return f"{minutes:.0f} min {rest:.1f} s" if minutes else f"{rest:.2f} s"


def _pose(pose: dict[str, float]) -> str:
    # + 0.0 makes a plain zero of a negative one.
    x, y, heading = (round(pose[key], 3) + 0.0 for key in ("x_mm", "y_mm", "heading_deg"))
    return f"x {x:g} mm, y {y:g} mm, heading {heading % 360.0:g} degrees"


class _Progress:
    """A progress bar on a terminal, and the program's output past it."""

    def __init__(self, robot: Walter, *, quiet: bool) -> None:
        self._robot = robot
        self._shown = not quiet and sys.stderr.isatty()
        self._ended = threading.Event()
        self._line = ""

    def __enter__(self) -> _Progress:
        if self._shown:
            from rich.console import Console
            from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

            self._bar = Progress(
                TextColumn("drawing"),
                BarColumn(),
                TaskProgressColumn(),
                TextColumn("{task.description}"),
                console=Console(stderr=True),
                redirect_stdout=False,
                redirect_stderr=False,
            )
            self._task = self._bar.add_task("", total=1.0)
            self._bar.start()
        return self

    def watch(self, progress: Callable[[], float | None]) -> None:
        """Show from here on how far the program is."""
        if self._shown:
            self._thread = threading.Thread(target=self._follow, args=(progress,), daemon=True)
            self._thread.start()

    def _follow(self, progress: Callable[[], float | None]) -> None:
        while not self._ended.wait(REFRESH_S):
            self._show(progress() or 0.0)

    def _show(self, done: float) -> None:
        figures = self._robot.statistics
        text = (
            f"{figures.commands} commands, {figures.distance_mm / 1000:.2f} m, "
            f"{_duration(figures.seconds)} of the robot's time"
        )
        self._bar.update(self._task, completed=done, description=text)

    def write(self, text: str) -> None:
        """Output of the program; past the bar in whole lines, if both are on the terminal."""
        if not (self._shown and sys.stdout.isatty()):
            sys.stdout.write(text)
            return
        *lines, self._line = (self._line + text).split("\n")
        for line in lines:
            self._bar.console.print(line, markup=False, highlight=False, soft_wrap=True)

    def __exit__(self, kind: type[BaseException] | None, error: object, traceback: object) -> None:
        if not self._shown:
            return
        self._ended.set()
        self._thread.join()
        if kind is None:
            self._show(1.0)
        self._bar.stop()
        if self._line:
            print(self._line)
