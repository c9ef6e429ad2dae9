"""``turtlewire calibrate``: a robot is measured by somebody with a tape, and what comes of it is written down."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING, Any

from turtlewire.cli import options, output
from turtlewire.cli.signals import Interrupted
from turtlewire.errors import LinkClosedError, TurtlewireError, UsageError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterator
    from pathlib import Path

    from turtlewire.cli.signals import Signals
    from turtlewire.configuration import AnySettings, Target
    from turtlewire.connect import Robot
    from turtlewire.links.link import Link
    from turtlewire.robots.calibrating import Finding, Person, Plan, Procedure, Progress

LEAST_SPACE_MM = 200.0
MOST_SPACE_MM = 20_000.0
MOST_REPEATS = 20
# What is less is rounding of numbers, not of a measure.
SPECK = 1e-9
EXAMPLES = """\
examples:
  turtlewire calibrate --robot elsie
      measure the robot that robots.toml calls elsie, and write there what was found
  turtlewire calibrate --port "/dev/ttyUSB0?protocol=simple" --write herbie
      measure the car at this port, and enter it in robots.toml as herbie
  turtlewire calibrate --robot herbie --steps steering,speed --space-mm 2000 --repeats 3
      only how it steers and how fast it is, with two metres of space, each thing three times
  turtlewire calibrate --port "sim:simple?trim_deg=2&wheelbase_mm=171"
      a simulated car, measured by who sees it: how it works, and how well

The steps of each robot are in docs/calibration.md; a wrong one at --steps names them.
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "calibrate",
        summary="measure how fast a robot is, how it turns, where its pen is",
        description="Measure what a robot does when it is told something, with a tape and a protractor, and write it "
        "to robots.toml. Without --port, a simulated WALTER in this process is measured.",
        examples=EXAMPLES,
    )
    options.add_target(parser, options.PORTS + "; or sim:simple?trim_deg=2, a simulated one")
    parser.add_argument(
        "--steps",
        metavar="STEP,...",
        type=_steps,
        help="only these steps; a wrong one names those that there are",
    )
    parser.add_argument(
        "--space-mm",
        metavar="MM",
        type=_within(LEAST_SPACE_MM, MOST_SPACE_MM),
        default=1000.0,
        help="how much space there is: no drive is planned to be longer (1000)",
    )
    parser.add_argument(
        "--repeats",
        metavar="N",
        type=_repeats,
        default=2,
        help="how often each thing is measured, and averaged (2)",
    )
    parser.add_argument(
        "--measure",
        choices=["person", "simulated"],
        help="who measures: somebody at this terminal, or for a simulated robot (where that is the default) "
        "somebody who sees what it truly does",
    )
    parser.add_argument(
        "--noise",
        metavar="MM",
        type=_within(0.0, 100.0),
        default=0.0,
        help="how badly the simulated person measures: the standard deviation, in mm and in degrees (0)",
    )
    parser.add_argument("--seed", metavar="N", type=int, default=0, help="of that (0)")
    parser.add_argument(
        "--write",
        metavar="NAME",
        nargs="?",
        const="",
        help="write it to robots.toml without asking: to the entry of that name, or of the robot that was named",
    )
    parser.add_argument("--json", action="store_true", help="print what was found as one JSON object")
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Measure, tell, write. Whatever happens, the robot is stopped, and nothing is written but by who wants it."""
    from turtlewire.robots.calibrating import Plan

    target = options.target(arguments)
    if target is None:
        from turtlewire import configuration

        target = options.with_settings(configuration.target("sim:walter"), arguments.set)
    calibration = _Calibration(arguments, target, signals)
    calibration.measure(Plan(arguments.space_mm, arguments.repeats, arguments.steps))
    return calibration.end()


class _Calibration:
    """One calibration, from its options to the file."""

    def __init__(self, arguments: argparse.Namespace, target: Target, signals: Signals) -> None:
        self._arguments = arguments
        self._target = target
        self._signals = signals
        self._is_simulated = target.is_simulated and arguments.measure != "person"
        self._body: Any = None
        self._procedure: Procedure[Any] | None = None
        self._check()

    def _check(self) -> None:
        """Complain of what is wrong before anything is opened."""
        from turtlewire import configuration, robots_file
        from turtlewire.robots.calibrating import steps

        arguments, target = self._arguments, self._target
        if arguments.measure == "simulated" and not target.is_simulated:
            raise UsageError(
                "--measure simulated is for a simulated robot in this process: nobody else sees what a robot at a port "
                "does, but a person"
            )
        known = steps(target.protocol)
        unknown = (arguments.steps or frozenset()) - set(known)
        if unknown:
            text = "\n".join(f"  {name:<14} {what}" for name, what in known.items())
            raise UsageError(f"there is no step {', '.join(sorted(unknown))}; this robot has\n{text}")
        is_named = bool(configuration.NAME.fullmatch(target.name))
        self._name = arguments.write or (target.name if is_named else "")
        if arguments.write == "" and not is_named:
            raise UsageError("--write: under which name? A robot at a port needs one: --write NAME")
        if self._name:
            robots_file.check_name(self._name)
            if is_named and self._name != target.name:
                raise UsageError(
                    f"--robot {target.name} and --write {self._name} name different robots: leave out the latter name"
                )
            if not is_named and self._name in configuration.entries():
                raise UsageError(
                    f"--write {self._name}: {configuration.path()} has a robot of that name already; to measure that "
                    f"one, say --robot {self._name}"
                )
        self._settings = self._all_settings()

    def _all_settings(self) -> AnySettings:
        if not self._target.is_simulated:
            return self._target.settings()
        from turtlewire.simulated import simulated

        return simulated(self._target).target.settings()

    # ------------------------------------------------------------------ measuring

    def measure(self, plan: Plan) -> None:
        """Connect, and go through the steps; the robot is stopped, whatever the way out is."""
        from turtlewire.connect import connect

        try:
            robot = connect(self._target, notify=self._notify, announce=self._announce, wrap=self._see)
        except LinkClosedError as error:
            options.explain_refusal(error, self._target.port)
            raise
        try:
            try:
                progress = self._guided(robot, plan)
            except Interrupted:
                output.tell("\nNothing was written.")
                raise
            except TurtlewireError as error:
                error.add_note("Nothing was written.")
                raise
            finally:
                self._signals.hold()
        finally:
            robot.close(finish=False)
        self._procedure = progress.procedure

    def _guided(self, robot: Robot, plan: Plan) -> Progress:
        from turtlewire.robots.calibrating import Progress, guide, procedure

        progress = Progress(lambda: procedure(robot, self._settings, plan))
        guide(progress, self._person(robot))
        return progress

    def _person(self, robot: Robot) -> Person:
        from turtlewire.robots.calibrating import SimulatedPerson, steps

        if not self._is_simulated:
            from turtlewire.cli.measuring import TerminalPerson

            known = steps(self._target.protocol)
            return TerminalPerson(robot, known, in_background=not self._target.is_simulated)
        assert self._body is not None
        return SimulatedPerson(self._body, self._arguments.noise, self._arguments.seed, self._notify)

    def _see(self, link: Link) -> Link:
        """The link to the robot, as it is; what is at its far end, if that can be seen."""
        from turtlewire.links.faults import FaultyLink
        from turtlewire.links.memory import MemoryLink

        within = link.within if isinstance(link, FaultyLink) else link
        self._body = within.end if isinstance(within, MemoryLink) else None
        return link

    def _notify(self, text: str) -> None:
        if not self._arguments.json:
            output.tell(text)

    def _announce(self, path: str) -> None:
        output.tell(f"waiting for the robot at {path}")

    # ------------------------------------------------------------------ telling

    def end(self) -> int:
        """Tell what was found, and write it if that is wanted; return the exit code."""
        assert self._procedure is not None
        findings = [finding for finding in self._procedure.found.values() if finding.values]
        lines = self._changed(dict(self._procedure.lines())) if findings else {}
        if not self._arguments.json:
            output.write("\n".join(_table(findings)) + "\n")
            if findings and not lines:
                output.tell("nothing of that is new")
        files = self._write(lines) if lines and self._is_wanted() else []
        if self._arguments.json:
            output.write(json.dumps(self._result(findings, lines, files)) + "\n")
        return 0

    def _result(self, findings: list[Finding], lines: dict[str, Any], files: list[Path]) -> dict[str, Any]:
        found = [
            {
                "name": finding.name,
                "unit": finding.unit,
                "old": finding.old,
                "new": finding.new,
                "spread": finding.spread,
                "values": list(finding.values),
            }
            for finding in findings
        ]
        return {
            "robot": self._target.name,
            "protocol": self._target.protocol,
            "found": found,
            "lines": lines,
            "written": [str(file) for file in files],
        }

    def _changed(self, lines: dict[str, Any]) -> dict[str, Any]:
        """Those lines that say something else than the robot's entry does."""
        from turtlewire import configuration
        from turtlewire.robots import calibration

        entry = configuration.entries().get(self._name)
        old: Any = configuration.defaults(self._target.protocol)
        if entry is not None:
            old = entry.target().settings()
        # A WALTER's settings have no calibration of their own, but its values.
        before = calibration.lines(old.calibration) if hasattr(old, "calibration") else old._asdict()
        changed = {key: value for key, value in lines["calibration"].items() if value != before[key]}
        return {"calibration": changed} if changed else {}

    def _is_wanted(self) -> bool:
        from turtlewire import configuration, robots_file

        if self._arguments.write is not None:
            return True
        if self._is_simulated or self._arguments.json or not sys.stdin.isatty():
            return False
        file = configuration.path()
        if self._name:
            return _asked(f"write this to {file}, as {self._name}? [y/n] ") in ("y", "yes")
        while name := _asked(f"write this to {file}? The name of the robot (nothing: do not write it): "):
            try:
                robots_file.check_name(name)
            except UsageError as error:
                output.tell(f"  {error}")
                continue
            if name in configuration.entries():
                output.tell("  there is a robot of that name already")
                continue
            self._name = name
            return True
        return False

    def _write(self, lines: dict[str, Any]) -> list[Path]:
        from turtlewire import configuration, robots_file

        if self._name not in configuration.entries():
            where = robots_file.options(self._target.name)
            if not self._target.is_simulated:
                where["protocol"] = self._target.protocol
            lines = {**where, **lines}
        elif self._target.protocol == "walter" and not self._target.is_simulated:
            # The same values may stand there as settings.
            lines = {**dict.fromkeys(lines["calibration"]), **lines}
        files = robots_file.write(self._name, lines)
        for file in files:
            output.tell(f"written to {file}")
        return files


def _asked(question: str) -> str:
    print(question, end="", file=sys.stderr, flush=True)
    return sys.stdin.readline().strip()


def _table(findings: list[Finding]) -> Iterator[str]:
    """Old, new and spread of each value, in columns."""
    rows = [("", "old", "new", "spread")]
    for finding in findings:
        unit = f", {finding.unit}" if finding.unit else ""
        spread = f"± {_short(finding.spread)}" if finding.spread is not None else ""
        rows.append((f"{finding.name}{unit}", _short(finding.old), _short(finding.new), spread))
    if len(rows) == 1:
        yield "nothing was measured"
        return
    widths = [max(len(row[column]) for row in rows) for column in range(4)]
    for name, old, new, spread in rows:
        yield f"{name:<{widths[0]}}  {old:>{widths[1]}}  {new:>{widths[2]}}  {spread}".rstrip()


def _short(value: float | str | None) -> str:
    if isinstance(value, str | None):
        return value or "-"
    return f"{0.0 if abs(value) < SPECK else value:.4g}"


def _steps(text: str) -> frozenset[str]:
    return frozenset(filter(None, (name.strip() for name in text.split(","))))


def _repeats(text: str) -> int:
    import argparse

    if not text.isdecimal() or not 1 <= int(text) <= MOST_REPEATS:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 1 to {MOST_REPEATS}")
    return int(text)


def _within(low: float, high: float) -> Any:
    import argparse

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = low - 1.0
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text!r} is not a number from {low:g} to {high:g}")
        return value

    return read
