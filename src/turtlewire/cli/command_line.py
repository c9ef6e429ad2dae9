"""The parser of the command line: all commands, or the one that is wanted."""

from __future__ import annotations

import argparse
import importlib
from typing import TYPE_CHECKING

from turtlewire.cli import options

if TYPE_CHECKING:
    from collections.abc import Sequence

EPILOG = """\
examples:
  turtlewire run examples/rose.logo --picture rose.svg
  turtlewire drive                               (by keyboard)
  turtlewire simulate walter --listen pty        (prints a URL)
  turtlewire run examples/rose.logo --port URL   (in another terminal)
  turtlewire stop --port URL

exit codes:
  0 done, 1 the program or its data is wrong, 2 usage, 3 robot or link, 130 interrupted
"""
# Each is a module beside this one, loaded when it is wanted; in this order they are listed.
COMMANDS = (
    "run",
    "logo",
    "drive",
    "console",
    "calibrate",
    "simulate",
    "stop",
    "doctor",
    "ports",
    "robots",
    "encode",
    "decode",
    "identify",
    "monitor",
    "dialect",
    "firmware",
)


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """What a command line says; ``execute`` in it is the function of the command.

    Raises:
        SystemExit: help or the version was asked for and has been given, or the command line is wrong, which was told.
    """
    # To load the others takes longer than many a program.
    return _parser(arguments[:1] if arguments[0] in COMMANDS else COMMANDS).parse_args(arguments)


def help_text() -> str:
    """What ``turtlewire --help`` says."""
    return _parser(COMMANDS).format_help()


def _parser(names: Sequence[str]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="turtlewire",
        description="Drive, program and trust any small serial robot.",
        epilog=EPILOG,
        formatter_class=options.Formatter,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="show the version and exit")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for name in names:
        importlib.import_module(f"turtlewire.cli.{name}").add_parser(commands)
    return parser


class _Version(argparse.Action):
    """The version, looked up when it is asked for: that takes longer than anything else here."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        print(f"turtlewire {version('turtlewire')}")
        parser.exit()
