"""``turtlewire dialect``: what a dialect of frame has, and what is made of it: a page, the robot's C++ header (F10)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from turtlewire.cli import options, output
from turtlewire.errors import DataError, OutputError, UsageError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable

    from turtlewire.cli.signals import Signals
    from turtlewire.protocols.frame.dialect import Dialect

EXAMPLES = """\
examples:
  turtlewire dialect check lawn-mower.toml
      is it right? what messages are there?
  turtlewire dialect header lawn-mower.toml --count wheels=6 > lawn_mower.h
      for the robot's firmware: structs, pack, unpack, valid, the CRC
  turtlewire dialect page telemetry --output telemetry.md
      a table of every message, for people; telemetry comes with turtlewire
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "dialect",
        summary="check a dialect of frame, and make a page or the robot's header of it",
        description="Check a dialect of frame, and make its page in Markdown or the robot's C++11 header of it.",
        examples=EXAMPLES,
    )
    parser.add_argument("what", choices=["check", "page", "header"], help="what to do")
    parser.add_argument(
        "dialect", metavar="DIALECT", help="a TOML file, or one that comes along: 0.1, 0.1-literal, telemetry"
    )
    parser.add_argument(
        "--count",
        action="append",
        default=[],
        metavar="NAME=N",
        help="how many the robot has of what the dialect counts, as often as wanted: engines=4",
    )
    parser.add_argument("--crc", metavar="NAME", help="algorithm, as CRC-8/SMBUS (the dialect's)")
    parser.add_argument("--coverage", metavar="FROM", help="magic, seq, size or payload (the dialect's)")
    parser.add_argument(
        "--output", metavar="FILE", type=Path, help="write it there rather than to standard output"
    )
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Read the dialect; write what was asked for."""
    from turtlewire.protocols.frame.dialect import SHIPPED, load, shipped

    del signals
    name = arguments.dialect
    dialect = shipped(name) if name in SHIPPED else load(name)
    counts = dict(_count(text) for text in arguments.count)
    try:
        dialect = dialect.configured(counts=counts, crc=arguments.crc, coverage=arguments.coverage)
    except DataError as error:  # the file is right; an option is not
        raise UsageError(str(error)) from None
    text = _MAKERS[arguments.what](dialect)
    if arguments.output is None:
        output.write(text)
        return 0
    try:
        arguments.output.write_text(text, "utf-8")
    except OSError as error:
        raise OutputError(f"cannot write {arguments.output}: {error.strerror}") from error
    output.tell(f"written {arguments.output}")
    return 0


def _count(text: str) -> tuple[str, int]:
    name, _, number = text.partition("=")
    if not name or not number.isdecimal():
        raise UsageError(f"--count {text}: write NAME=NUMBER, as in --count engines=4")
    return name, int(number)


def _check(dialect: Dialect) -> str:
    """What it has, a line for each message."""
    counts = "".join(f", {number} {name}" for name, number in dialect.counts.items())
    lines = [f"{dialect.name}: {dialect.title} ({dialect.baud} baud, {dialect.checksum}{counts})"]
    for entry in dialect.entries:
        fields = " ".join(field.name for field in entry.message_type.FIELDS)
        stops = "; stops" if entry.stop is not None else ""
        lines.append(
            f"  {entry.type:02X}  {entry.direction:<10}  {entry.message_type.name()} {fields}".rstrip()
            + stops
        )
    if not dialect.stop_messages():
        lines.append("  no message has a stop: an emergency stop would have nothing to say (F13)")
    return "\n".join(lines) + "\n"


def _page(dialect: Dialect) -> str:
    from turtlewire.protocols.frame.page import page

    return page(dialect).rstrip("\n") + "\n"


def _header(dialect: Dialect) -> str:
    from turtlewire.protocols.frame.header import header

    return header(dialect)


_MAKERS: dict[str, Callable[[Dialect], str]] = {"check": _check, "page": _page, "header": _header}
