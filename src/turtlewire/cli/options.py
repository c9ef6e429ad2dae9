"""Options that several commands have."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from turtlewire.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.errors import LinkClosedError
    from turtlewire.robots.walter import Settings

PORTS = "a device (/dev/ttyUSB0, COM3), serial:///dev/ttyUSB0?baud=9600, socket://host:port, or pty"
# How a robot can be driven: --set NAME=VALUE.
SETTINGS: dict[str, Callable[[str], Any]] = {
    "baud": int,
    "speed": int,
    "mm_per_s_per_unit": float,
    "deg_per_s_per_unit": float,
    "groups": lambda text: frozenset(text.upper()),
    "gentle": lambda text: {"1": True, "yes": True, "on": True, "0": False, "no": False, "off": False}[text],
    "boot_s": float,
    "reply_timeout_s": float,
    "max_unfenced": int,
    "heartbeat_s": float,
}


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
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def add_require_replies(parser: argparse.ArgumentParser) -> None:
    """``--require-replies``: no robot that answers nothing."""
    parser.add_argument(
        "--require-replies", action="store_true", help="refuse a robot that answers no queries (exit code 3)"
    )


def add_settings(parser: argparse.ArgumentParser) -> None:
    """``--set``: how to drive the robot."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help=f"a setting of the robot: {', '.join(SETTINGS)}",
    )


def settings(assignments: list[str], **more: Any) -> Settings:
    """The settings that ``--set`` options make. Raises ``UsageError``."""
    from turtlewire.robots.walter import Settings

    values: dict[str, Any] = dict(more)
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        if not equals or name not in SETTINGS:
            raise UsageError(f"--set {assignment}: write NAME=VALUE; the names are {', '.join(SETTINGS)}")
        try:
            values[name] = SETTINGS[name](text)
        except (ValueError, KeyError):
            raise UsageError(f"--set {assignment}: {text!r} is no value for {name}") from None
    return Settings(**values).checked()


def explain_refusal(error: LinkClosedError, port: str) -> None:
    """Note on a link that ended before the robot had said anything why that may be."""
    if port.startswith("socket:"):
        error.add_note(
            "It was closed at once. Is it in use by another program? A robot has one host at a time."
        )


def positive(text: str) -> float:
    """A number above 0, for argparse."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number above 0")
    return value
