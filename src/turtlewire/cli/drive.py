"""``turtlewire drive``: a robot by keyboard, on a terminal."""

from __future__ import annotations

import argparse
import os
import sys
from typing import TYPE_CHECKING

from turtlewire.cli import options, output
from turtlewire.cli.progress import duration
from turtlewire.cli.signals import Interrupted
from turtlewire.errors import LinkClosedError, UsageError

if TYPE_CHECKING:
    from textual.driver import Driver

    from turtlewire.cli.signals import Signals
    from turtlewire.configuration import Target
    from turtlewire.dashboard.controls import Controls
    from turtlewire.helm.helm import Helm

# How long a key counts, in milliseconds: the pause before keys repeat is 660 at most by default (a bare X server),
# the time between repetitions 40.
FIRST_MS, HOLD_MS = 700.0, 250.0
LEAST_MS, MOST_MS = 50.0, 5000.0
EXAMPLES = """\
examples:
  turtlewire drive
      a simulated WALTER, in real time
  turtlewire drive --port /dev/ttyUSB0
      the WALTER at this port
  turtlewire drive --robot simple --port /dev/ttyUSB0
      the car at this port
  turtlewire drive --robot elsie
      the robot that robots.toml calls elsie
  turtlewire drive --port "sim:frame?dialect=telemetry&arena=maze.toml&slip=0.02"
      a simulated robot among walls, whose wheels slip

Keys drive while they are held; Space stops, Q quits. The bottom of the screen shows the keys of this robot.
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "drive",
        summary="drive a robot by keyboard",
        description="Drive a robot by keyboard. Without --port, a simulated robot in this process is driven.",
        examples=EXAMPLES,
    )
    options.add_target(parser, options.PORTS + "; or sim:walter?arena=FILE, a simulated one")
    parser.add_argument(
        "--faults",
        metavar="FAULTS",
        help="what goes wrong on the way to the robot: lose:0.01,flip:0.001,delay:0.1,seed:7 and more",
    )
    parser.add_argument(
        "--hold-ms",
        type=_milliseconds,
        default=HOLD_MS,
        metavar="MS",
        help=f"a key that repeats drives for so long after its last repetition ({HOLD_MS:.0f})",
    )
    parser.add_argument(
        "--first-ms",
        type=_milliseconds,
        default=FIRST_MS,
        metavar="MS",
        help="a key drives for so long when it is pressed: longer than the keyboard's pause before it repeats "
        f"({FIRST_MS:.0f})",
    )
    parser.add_argument(
        "--latched",
        action="store_true",
        help="what a key began goes on until Space or another key, as the protocols have it",
    )
    parser.set_defaults(execute=execute)


def _milliseconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not LEAST_MS <= value <= MOST_MS:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a number of milliseconds from {LEAST_MS:g} to {MOST_MS:g}"
        )
    return value


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Drive until somebody quits. Whatever happens, the robot is stopped."""
    target, pace = _target(arguments)
    _need_terminal()
    from turtlewire.dashboard.app import Dashboard
    from turtlewire.helm.helm import Helm

    helm = Helm(target, pace=pace, announce=_announce)
    output.tell(f"connecting to the {helm.title} ...")
    try:
        helm.connect()
    except LinkClosedError as error:
        options.explain_refusal(error, target.port)
        raise
    try:
        try:
            dashboard = Dashboard(
                helm, _controls(arguments, target), latched=arguments.latched, driver_class=_terminal()
            )
            signals.then(dashboard.interrupt)
            dashboard.run(mouse=False)
        finally:
            signals.hold()
    finally:
        helm.close()
    failure = dashboard.failure or helm.failure
    if failure is not None:
        raise failure
    if signals.received or dashboard.has_hung_up:
        raise Interrupted(signals.received or "the terminal is gone")
    _summarize(helm)
    return 0


def _target(arguments: argparse.Namespace) -> tuple[Target, float]:
    """The robot, and the pace of a simulated one."""
    from turtlewire.configuration import target

    found = options.target(arguments) or options.with_settings(target("sim:walter"), arguments.set)
    if arguments.faults is not None:
        from turtlewire.links.faults import Faults

        found = found._replace(faults=Faults.parse(arguments.faults))
    return options.by_hand(found)


def _need_terminal() -> None:
    """Raises ``UsageError`` where there is nobody to drive."""
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise UsageError(
            "drive needs a terminal for its keys and its picture: run it in one, without a pipe. "
            "A program drives a robot by `turtlewire run`, or in Python"
        )
    if os.environ.get("TERM", "dumb") == "dumb" and os.name != "nt":
        raise UsageError("drive needs a terminal that can be drawn on, and TERM says that this one is dumb")


def _announce(path: str) -> None:
    output.tell(f"waiting for the robot at {path}")


def _controls(arguments: argparse.Namespace, target: Target) -> Controls:
    from turtlewire.dashboard.controls import Controls
    from turtlewire.dashboard.layouts import layout

    return Controls(
        layout(target.protocol),
        speed=target.settings().speed,
        has_full_lock=target.protocol == "simple",
        first_s=arguments.first_ms / 1000.0,
        hold_s=arguments.hold_ms / 1000.0,
        latched=arguments.latched,
    )


def _terminal() -> type[Driver] | None:
    if os.name == "nt":
        return None
    from turtlewire.dashboard.terminal import Terminal

    return Terminal


def _summarize(helm: Helm) -> None:
    view = helm.view
    output.tell(f"The robot was stopped, after {view.distance_mm / 1000.0:.2f} m in {duration(view.time_s)}.")
