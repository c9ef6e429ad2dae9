"""``turtlewire stop --port URL``: stop whatever robot is there, from any state."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from turtlewire.cli import options
from turtlewire.errors import UsageError

if TYPE_CHECKING:
    import argparse


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = commands.add_parser(
        "stop", help="stop a robot, whatever it is doing", description="Stop a robot, whatever it is doing."
    )
    parser.add_argument("--robot", choices=["walter"], default="walter", help="what robot it is (walter)")
    parser.add_argument("--port", metavar="URL", required=True, help=options.PORTS)
    options.add_settings(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Send the stop first; then see whether the robot confirms it."""
    from turtlewire.connect import is_simulated, stop

    if is_simulated(arguments.port):
        raise UsageError(f"{arguments.port} is a robot of its own in each process: there is nothing to stop")
    pose = stop(arguments.port, options.settings(arguments.set))
    if pose is None:
        print(f"the stop was sent to {arguments.port}; the robot confirms nothing", file=sys.stderr)
    else:
        print(
            f"stopped: the robot answers, at x {pose.x_mm:g} mm, y {pose.y_mm:g} mm, heading {pose.heading_deg:g}"
        )
    return 0
