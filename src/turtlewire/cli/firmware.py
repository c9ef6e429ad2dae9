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
  turtlewire firmware flash SimpleCar --robot elsie
      at the port that robots.toml has for elsie
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
    parser.add_argument(
        "--board",
        choices=["uno", "nano", "nano-old", "mega"],
        default="uno",
        help="what for (uno); nano-old: a Nano with the old bootloader",
    )
    parser.add_argument("--port", metavar="PORT", help="flash: where the board is: /dev/ttyUSB0, COM3")
    parser.add_argument("--robot", metavar="NAME", help="flash: the board of a robot in robots.toml")
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
    parser.set_defaults(execute=execute, set=[])


def execute(arguments: argparse.Namespace, signals: Signals) -> int:
    """Build, then flash if that is wanted."""
    from turtlewire.firmware import BOARDS, build, find_sketch, flash
    from turtlewire.firmware.flash import flash_command

    del signals
    port = _device(arguments)
    built = build(find_sketch(arguments.sketch), BOARDS[arguments.board], arguments.output, arguments.tool)
    command = None if port is None else flash_command(built, port)
    if not arguments.json:
        _tell(built)
    is_flashed = False
    if port is not None and command is not None:
        if arguments.dry_run:
            output.tell(f"would be flashed by: {shlex.join(command)}")
        else:
            from turtlewire.links.held import held

            with held(port) as fileno:
                flash(built, port, fileno)
            is_flashed = True
            output.tell(f"flashed, and read back. What now? turtlewire doctor {port}")
    if arguments.json:
        output.write(json.dumps(_described(built, command, is_flashed=is_flashed)) + "\n")
    return 0


def _device(arguments: argparse.Namespace) -> str | None:
    """Where the board is, as flashing tools call it; None: it is not to be flashed. Raises ``UsageError``."""
    from turtlewire.links.port import Port

    target = options.target(arguments)
    if arguments.what == "build":
        if target is not None or arguments.dry_run:
            raise UsageError("--port, --robot and --dry-run are for flash; build touches no board")
        return None
    if target is None:
        raise UsageError("flash needs --port, or --robot: `turtlewire ports` shows where boards may be")
    if target.is_simulated:
        raise UsageError(f"{target.name} is simulated: it has no firmware. A board is at a serial port")
    port = Port.parse(target.port)
    if port.kind != "serial":
        raise UsageError(
            f"{target.port} is no serial port, and boards are flashed at one: /dev/ttyUSB0, COM3"
        )
    return port.path


def _tell(built: Built) -> None:
    flash_share = _share(built.flash_bytes, built.board.flash_bytes)
    ram_share = _share(built.ram_bytes, built.board.ram_bytes)
    output.tell(
        f"{built.sketch} for the {built.board.name}, built by {built.tool}: "
        f"{flash_share} of flash, {ram_share} of RAM"
    )
    output.write(f"{built.hex}\n")


def _share(used: int, most: int) -> str:
    return f"{used} bytes ({100 * used / most:.0f}%)"


def _described(built: Built, command: list[str] | None, *, is_flashed: bool) -> dict[str, object]:
    return {
        "sketch": built.sketch,
        "board": built.board.name,
        "tool": built.tool,
        "hex": str(built.hex),
        "elf": str(built.elf),
        "flash_bytes": built.flash_bytes,
        "ram_bytes": built.ram_bytes,
        "flash_command": command,
        "flashed": is_flashed,
    }
