"""``turtlewire firmware``: build the robot's program, and flash it to a board."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from turtlewire.cli import options, output
from turtlewire.errors import UsageError

if TYPE_CHECKING:
    import argparse

    from turtlewire.cli.signals import Signals
    from turtlewire.firmware import Built

EXAMPLES = """\
examples:
  turtlewire firmware build SimpleCar
      SimpleCar.hex and SimpleCar.elf, for an Arduino Uno
  turtlewire firmware flash SimpleCar --board nano --port /dev/ttyUSB0
      build it and put it on the board; then: turtlewire doctor /dev/ttyUSB0
  turtlewire firmware flash my_robot/ --port /dev/ttyACM0 --dry-run
      build a sketch of one's own, and show what would flash it
"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command."""
    parser = options.add_command(
        commands,
        "firmware",
        summary="build a robot's program, and flash it to an Arduino",
        description="Build a robot's program with whichever of arduino-cli, arduino-builder or avr-gcc is there, and "
        "flash it to an Arduino.",
        examples=EXAMPLES,
    )
    parser.add_argument("what", choices=["build", "flash"], help="what to do; flash builds first")
    parser.add_argument(
        "sketch", metavar="SKETCH", help="one that comes along, such as SimpleCar; or a folder"
    )
    parser.add_argument("--board", choices=["uno", "nano", "mega"], default="uno", help="what for (uno)")
    parser.add_argument("--port", metavar="PORT", help="flash: where the board is: /dev/ttyUSB0, COM3")
    parser.add_argument(
        "--tool", choices=["arduino-cli", "arduino-builder", "avr-gcc"], help="build with this one"
    )
    parser.add_argument(
        "--output", metavar="FOLDER", type=Path, default=Path(), help="where the files go (here)"
    )
    parser.add_argument(
        "--dry-run", action="store_true", help="flash: only show the command that would do it"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Build, then flash if that is wanted."""
    from turtlewire.firmware import BOARDS, build, find_sketch, flash
    from turtlewire.firmware.flash import flash_command

    del signals
    if arguments.what == "flash" and arguments.port is None:
        raise UsageError("flash needs --port: `turtlewire ports` shows where boards may be")
    built = build(find_sketch(arguments.sketch), BOARDS[arguments.board], arguments.output, arguments.tool)
    command = flash_command(built, arguments.port) if arguments.what == "flash" else None
    if arguments.json:
        output.write(json.dumps(_described(built, command)) + "\n")
    else:
        flash_share = _share(built.flash_bytes, built.board.flash_bytes)
        ram_share = _share(built.ram_bytes, built.board.ram_bytes)
        output.tell(
            f"{built.sketch} for the {built.board.name}, built by {built.tool}: "
            f"{flash_share} of flash, {ram_share} of RAM"
        )
        output.write(f"{built.hex}\n")
    if command is None:
        return 0
    if arguments.dry_run:
        output.tell(f"would be flashed by: {shlex.join(command)}")
        return 0
    flash(built, arguments.port)
    output.tell(f"flashed: what now? turtlewire doctor {arguments.port}")
    return 0


def _share(used: int, most: int) -> str:
    return f"{used} bytes ({100 * used / most:.0f}%)"


def _described(built: Built, command: list[str] | None) -> dict[str, object]:
    return {
        "sketch": built.sketch,
        "board": built.board.name,
        "tool": built.tool,
        "hex": str(built.hex),
        "elf": str(built.elf),
        "flash_bytes": built.flash_bytes,
        "ram_bytes": built.ram_bytes,
        "flash_command": command,
    }
