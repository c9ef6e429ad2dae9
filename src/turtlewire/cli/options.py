"""Options that several commands have."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING

from turtlewire.errors import UsageError

if TYPE_CHECKING:
    from turtlewire.configuration import Target
    from turtlewire.errors import LinkClosedError

PORTS = (
    "a device (/dev/ttyUSB0, COM3), serial:///dev/ttyUSB0?baud=9600, socket://host:port, or pty; with options such "
    "as ?protocol=simple&window=4"
)
# Whoever drives by hand waits longer for a lost robot than a program does, and can end that.
RECONNECT_S = 3600.0
ROBOT = "a robot in robots.toml, or what the one at --port speaks: walter, simple or frame (walter)"


class Formatter(argparse.RawDescriptionHelpFormatter):
    """Lays out help to the terminal's width, which ``argparse`` itself would load half a library to find out."""

    def __init__(
        self, prog: str, indent_increment: int = 2, max_help_position: int = 24, width: int | None = None
    ) -> None:
        super().__init__(prog, indent_increment, max_help_position, width or _columns() - 2)


def _columns() -> int:
    columns = os.environ.get("COLUMNS", "")
    if columns.isdecimal() and int(columns):
        return int(columns)
    try:
        return os.get_terminal_size(1).columns or 80
    except OSError:
        return 80


def add_command(
    commands: argparse._SubParsersAction[argparse.ArgumentParser],
    name: str,
    *,
    summary: str,
    description: str,
    examples: str,
) -> argparse.ArgumentParser:
    """Add the parser of a command, with examples below its options."""
    return commands.add_parser(
        name,
        help=summary,
        description=description,
        epilog=examples,
        formatter_class=Formatter,
    )


def add_require_replies(parser: argparse.ArgumentParser) -> None:
    """``--require-replies``: no robot that answers nothing."""
    parser.add_argument(
        "--require-replies", action="store_true", help="refuse a robot that answers no queries (exit code 3)"
    )


def add_target(parser: argparse.ArgumentParser, port_help: str) -> None:
    """``--robot``, ``--port`` and ``--set``: which robot, and how to drive it."""
    parser.add_argument("--robot", metavar="NAME", help=ROBOT)
    parser.add_argument("--port", metavar="URL", help=port_help)
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a setting of the robot, as often as wanted; what there is, a wrong one says",
    )


def target(arguments: argparse.Namespace) -> Target | None:
    """The robot that these options mean, None if none of them says. Raises ``UsageError`` or ``DataError``."""
    from turtlewire import configuration

    robot: str | None = arguments.robot
    port: str | None = arguments.port
    if robot in configuration.PROTOCOLS:
        # sim:walter says itself what it is.
        found = configuration.target(port if port is not None else f"sim:{robot}", robot)
        if found.protocol != robot:
            raise UsageError(f"--robot {robot} and --port {port} mean different robots: leave one out")
    elif robot is not None and not configuration.NAME.fullmatch(robot):
        raise UsageError(f"argument --robot: invalid choice: {robot!r}: a port is named by --port")
    elif robot is not None:
        if robot not in configuration.entries():
            raise UsageError(
                f"argument --robot: invalid choice: {robot!r} (choose from {', '.join(configuration.PROTOCOLS)}, or a "
                f"robot in a file: {configuration.known()})"
            )
        if port is not None:
            raise UsageError(f"--robot {robot} and --port {port} both say where the robot is: leave one out")
        found = configuration.target(robot)
    elif port is not None:
        found = configuration.target(port)
    else:
        return None
    return with_settings(found, arguments.set)


def with_settings(found: Target, assignments: list[str]) -> Target:
    """The robot, driven as ``--set`` options say. Raises ``UsageError``."""
    from turtlewire.configuration import SETTINGS

    known = SETTINGS[found.protocol]
    values = dict(found.overrides)
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        if not equals or name not in known:
            raise UsageError(f"--set {assignment}: write NAME=VALUE; the names are {', '.join(known)}")
        try:
            values[name] = known[name].read(text)
        except (ValueError, KeyError):
            raise UsageError(
                f"--set {assignment}: {text!r} is no value for {name}, which must be {known[name].wanted}"
            ) from None
    return found._replace(overrides=values)


def by_hand(found: Target) -> tuple[Target, float]:
    """The robot, as somebody drives it by hand, and the pace of a simulated one: its seconds in one on the wall.

    Raises ``UsageError`` or ``DataError`` for what is wrong with its settings, before anything is opened.
    """
    found = found._replace(overrides={"reconnect_s": RECONNECT_S, **found.overrides})
    found.settings()
    if not found.is_simulated:
        return found, 1.0
    from turtlewire.simulated import simulated

    made = simulated(found)
    simulation = dict(found.simulation)
    if simulation.pop("pace", "real") == "max":
        raise UsageError(f"{found.name!r}: nobody can drive at pace=max; it can be real, or a number")
    return made.target._replace(simulation=simulation), made.pace or 1.0


def with_replies(found: Target) -> Target:
    """The robot, refused if it answers nothing. Raises ``UsageError`` for one that cannot answer at all."""
    if found.protocol == "frame":
        raise UsageError("--require-replies: a robot that speaks frame never answers")
    if found.protocol == "simple":  # without answers nothing goes on there
        return found
    return found._replace(overrides={**found.overrides, "require_replies": True})


def explain_refusal(error: LinkClosedError, port: str) -> None:
    """Note on a link that ended before the robot had said anything why that may be."""
    if port.startswith("socket:"):
        error.add_note(
            "It was closed at once. Is it in use by another program? A robot has one host at a time."
        )


def whole_positive(text: str) -> int:
    """A whole number above 0, for argparse."""
    if not text.isdecimal() or not int(text):
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number above 0")
    return int(text)


def positive(text: str) -> float:
    """A number above 0, for argparse."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number above 0")
    return value
