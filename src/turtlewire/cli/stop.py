"""``turtlewire stop --port URL``: stop whatever robot is there, from any state."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.cli import options, output
from turtlewire.errors import LinkClosedError, RobotError, UsageError

if TYPE_CHECKING:
    import argparse

    from turtlewire.cli.signals import Signals

EXAMPLES = """\
examples:
  turtlewire stop --port /dev/ttyUSB0
  turtlewire stop --port socket://robot.local:2000 --require-replies && echo "it stands"
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "stop",
        summary="stop a robot, whatever it is doing",
        description="Stop a robot, whatever it is doing; then ask where it is.",
        examples=EXAMPLES,
    )
    parser.add_argument("--robot", choices=["walter"], default="walter", help="what robot it is (walter)")
    parser.add_argument("--port", metavar="URL", required=True, help=options.PORTS)
    options.add_require_replies(parser)
    options.add_settings(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Send the stop first; then see whether the robot confirms it."""
    from turtlewire.connect import is_simulated, stop

    del signals  # one that comes before the stop is sent may end this, and later it does no harm
    port: str = arguments.port
    if is_simulated(port):
        raise UsageError(f"{port} is a robot of its own in each process: there is nothing to stop")
    if port in ("pty", "pty:"):
        raise UsageError("pty is a new port, with no robot at it yet: name the port of the robot")
    settings = options.settings(arguments.set, require_replies=arguments.require_replies)
    try:
        pose = stop(port, settings)
    except LinkClosedError as error:
        options.explain_refusal(error, port)
        error.add_note("Nothing confirms that the robot was stopped.")
        raise
    except RobotError as error:
        error.add_note(f"The stop was sent to {port} before that, but nothing confirms it.")
        raise
    if pose is None:
        output.tell(f"the stop was sent to {port}; the robot answers nothing, so nothing confirms it")
    else:
        output.write(
            f"stopped: the robot answers, at x {pose.x_mm:g} mm, y {pose.y_mm:g} mm, "
            f"heading {pose.heading_deg:g} degrees\n"
        )
    return 0
