"""Options that several commands have."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING

from turtlewire.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Mapping

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


class _AddRobot(argparse.Action):
    """Keeps ``--robot`` and ``--port`` in the order in which they stand: the first robot is the one that is told."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: object,
        option_string: str | None = None,
    ) -> None:
        del parser, option_string
        namespace.robots = [*namespace.robots, (self.metavar, values)]


def add_targets(parser: argparse.ArgumentParser, port_help: str) -> None:
    """``--robot`` and ``--port``, as often as wanted, and ``--set``: which robots, and how to drive them."""
    again = "; as often as wanted"
    parser.set_defaults(robots=[])
    parser.add_argument("--robot", dest="robots", action=_AddRobot, metavar="NAME", help=ROBOT + again)
    parser.add_argument(
        "--port",
        dest="robots",
        action=_AddRobot,
        metavar="URL",
        help=port_help + "; NAME=URL gives it a name" + again,
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a setting of the robots, as often as wanted; what there is, a wrong one says; ROBOT:NAME=VALUE for one",
    )


def targets(arguments: argparse.Namespace) -> dict[str, Target]:
    """The robots that these options mean, by the names that programs know them by; none if no option says.

    A robot is called as in ``robots.toml`` or as ``NAME=URL`` says; another one by its protocol, and by a number if
    there are several of that. One protocol and one port without a name are one robot.

    Raises ``UsageError`` or ``DataError``.
    """
    from turtlewire import configuration

    given: list[tuple[str, str]] = arguments.robots
    named: list[tuple[str, argparse.Namespace]] = []
    for kind, value in given:
        name, equals, url = value.partition("=") if kind == "URL" else ("", "", value)
        if not (equals and configuration.NAME.fullmatch(name)):
            name, url = "", value
        is_port = kind == "URL"
        one = argparse.Namespace(robot=None if is_port else url, port=url if is_port else None, set=[])
        if not name and configuration.NAME.fullmatch(url):
            name = url  # a protocol is none
        named.append((name, one))
    if sorted(kind for kind, _ in given) == ["NAME", "URL"]:
        # What the one at the port speaks; or a contradiction, which is told.
        robot, port = (next(one for _, one in named if getattr(one, which)) for which in ("robot", "port"))
        if robot.robot in configuration.PROTOCOLS and not any(name for name, _ in named):
            named = [("", argparse.Namespace(robot=robot.robot, port=port.port, set=[]))]
    found: dict[str, Target] = {}
    for name, one in named:
        meant = target(one)
        assert meant is not None
        _put(found, name, meant)
    return {
        name: with_settings(each, _settings_of(name, found, arguments.set)) for name, each in found.items()
    }


def _put(found: dict[str, Target], name: str, meant: Target) -> None:
    """Add a robot by its name. Raises ``UsageError`` for a second one of that name."""
    if not name:
        number = 1
        while (name := f"{meant.protocol}{number}" if number > 1 else meant.protocol) in found:
            number += 1
    if name.lower() in (known.lower() for known in found):
        raise UsageError(f"two robots are called {name}: give one of them another name, --port NAME=URL")
    found[name] = meant


def _settings_of(name: str, found: Mapping[str, Target], assignments: list[str]) -> list[str]:
    """Those that are for this robot. Raises ``UsageError`` for one that is for none."""
    for_it: list[str] = []
    for assignment in assignments:
        setting = assignment.partition("=")[0]
        robot, colon, _ = setting.partition(":")
        if not colon:
            for_it.append(assignment)
        elif robot not in found:
            raise UsageError(
                f"--set {assignment}: no robot here is called {robot}; there is {', '.join(found)}"
            )
        elif robot == name:
            for_it.append(assignment[len(robot) + 1 :])
    return for_it


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
