"""Flashing a program to a board, by arduino-cli or avrdude."""

from __future__ import annotations

import shutil
import subprocess
from typing import TYPE_CHECKING

from turtlewire.errors import LinkError, UsageError
from turtlewire.firmware.build import TOOLS_ADVICE

if TYPE_CHECKING:
    from turtlewire.firmware.build import Built


def flash_command(built: Built, port: str) -> list[str]:
    """What flashes this program at a port. Raises ``UsageError`` if there is no tool for it."""
    board = built.board
    if shutil.which("avrdude"):
        where = ["-P", port, "-b", str(board.baud)]
        return [
            "avrdude",
            "-p",
            board.chip,
            "-c",
            board.bootloader,
            *where,
            "-D",
            "-U",
            f"flash:w:{built.hex}:i",
        ]
    if shutil.which("arduino-cli"):
        return ["arduino-cli", "upload", "--fqbn", board.fqbn, "--port", port, "--input-file", str(built.hex)]
    raise UsageError(f"there is nothing to flash with: {TOOLS_ADVICE}")


def flash(built: Built, port: str) -> None:
    """Flash a program; what the tool says goes to standard error.

    Raises ``UsageError`` (no tool), ``LinkError`` (the board does not take it).
    """
    command = flash_command(built, port)
    done = subprocess.run(command, stdout=2, check=False)
    if done.returncode:
        raise LinkError(
            f"{built.sketch} could not be flashed to the {built.board.name} at {port}; {command[0]} said why. "
            "Is it the right port and board, and is no other program using the port? (`turtlewire ports`)"
        )
