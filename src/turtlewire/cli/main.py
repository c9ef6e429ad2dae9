"""``turtlewire``: the command line. One module a command; this one has what they share."""

from __future__ import annotations

import argparse
import importlib
import sys
from typing import TYPE_CHECKING

from turtlewire.cli import options, output
from turtlewire.cli.signals import INTERRUPTED, Interrupted, Signals
from turtlewire.errors import TurtlewireError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import TracebackType

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
USAGE = 2
# Each is a module beside this one, loaded when it is wanted; in this order they are listed.
COMMANDS = (
    "run",
    "logo",
    "drive",
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


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return its exit code."""
    output.prepare()
    sys.excepthook = _tell_of_bug
    arguments = sys.argv[1:] if arguments is None else arguments
    # To load the others takes longer than many a program.
    parser = _parser(arguments[:1] if arguments and arguments[0] in COMMANDS else COMMANDS)
    if not arguments:
        output.tell(parser.format_help())
        return USAGE
    parsed = parser.parse_args(arguments)
    with Signals() as signals:
        try:
            try:
                code: int = parsed.execute(parsed, signals)
            finally:
                output.finish()
        except TurtlewireError as error:
            output.tell("\n".join([f"turtlewire: {error}", *getattr(error, "__notes__", [])]))
            return error.exit_code
        except Interrupted as error:
            output.tell("\n".join([f"turtlewire: interrupted ({error})", *getattr(error, "__notes__", [])]))
            return INTERRUPTED
    return code


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


def _tell_of_bug(kind: type[BaseException], error: BaseException, where: TracebackType | None) -> None:
    """An exception that nobody raised on purpose: a paragraph too; the traceback with ``python -X dev``."""
    if sys.flags.dev_mode:
        sys.__excepthook__(kind, error, where)
        return
    import traceback

    frames = traceback.extract_tb(where)
    place = f" ({frames[-1].filename}, line {frames[-1].lineno})" if frames else ""
    output.tell(
        f"turtlewire: this is a bug in turtlewire, please report it: {kind.__name__}: {error}{place}. "
        "With PYTHONDEVMODE=1 in the environment it tells more"
    )
