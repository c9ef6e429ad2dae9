"""``turtlewire``: the command line. One module a command; this one has what they share."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from typing import TYPE_CHECKING, NoReturn

from turtlewire.cli import run, simulate, stop
from turtlewire.errors import TurtlewireError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import FrameType

INTERRUPTED = 130
EPILOG = "exit codes: 0 done, 1 the program or its data is wrong, 2 usage, 3 robot or link, 130 interrupted"


class Terminated(KeyboardInterrupt):
    """SIGTERM came: the same way out as Ctrl-C, so that the robot is stopped."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return its exit code."""
    options = _parser().parse_args(arguments)
    signal.signal(signal.SIGTERM, _terminate)
    try:
        code: int = options.execute(options)
        sys.stdout.flush()
    except TurtlewireError as error:
        print("\n".join([f"turtlewire: {error}", *getattr(error, "__notes__", [])]), file=sys.stderr)
        return error.exit_code
    except BrokenPipeError:
        # Whoever read our output has gone; what is left to flush must not complain again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except KeyboardInterrupt:
        print("turtlewire: interrupted", file=sys.stderr)
        return INTERRUPTED
    return code


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="turtlewire",
        description="Drive, program and trust any small serial robot.",
        epilog=EPILOG,
    )
    parser.add_argument("--version", action="version", version=_Version())
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for command in (run, simulate, stop):
        command.add_parser(commands)
    return parser


class _Version(str):
    """The version, looked up when it is asked for: that takes longer than anything else here."""

    __slots__ = ()

    def __mod__(self, _: object) -> str:
        from importlib.metadata import version

        return f"turtlewire {version('turtlewire')}"

    def __str__(self) -> str:
        return self % ()


def _terminate(number: int, frame: FrameType | None) -> NoReturn:
    del number, frame
    raise Terminated
