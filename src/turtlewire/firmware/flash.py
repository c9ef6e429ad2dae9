"""Flashing a program to a board, by avrdude or arduino-cli; what went wrong, and what is on the board then."""

from __future__ import annotations

import contextlib
import os
import re
import select
import shutil
import subprocess
from typing import IO, TYPE_CHECKING

from turtlewire.errors import LinkError, UsageError
from turtlewire.firmware.build import TOOLS_ADVICE

if TYPE_CHECKING:
    from collections.abc import Iterator

    from turtlewire.firmware.build import Built

# avrdude asks ten times, five seconds each; a bootloader that is there answers the first, or the second.
ENOUGH_ATTEMPTS = 3
HAS_BEGUN = re.compile(r"\bwriting\b", re.IGNORECASE)
UNTOUCHED = "Nothing was written: the board has the program that it had."
WRITTEN = "All of it was written, but reading it back came to no good end: flash it again."
TORN = (
    "The board holds a part of this program, and of the one before: what that does to motors, nobody knows. Switch "
    "their power off, and flash it again: the bootloader is untouched, and takes it."
)


def flash_command(built: Built, port: str) -> list[str]:
    """What flashes this program at a port. Raises ``UsageError`` if there is no tool for it."""
    board = built.board
    if shutil.which("avrdude"):
        to = ["-p", board.chip, "-c", board.bootloader, "-P", port, "-b", str(board.baud)]
        # -D: a bootloader erases page by page, and cannot erase the chip. It is verified afterwards.
        return ["avrdude", *to, "-D", "-U", f"flash:w:{built.hex}:i"]
    if shutil.which("arduino-cli"):
        to = ["--fqbn", board.fqbn, "--port", port]
        return ["arduino-cli", "upload", *to, "--verbose", "--verify", "--input-file", str(built.hex)]
    raise UsageError(f"there is nothing to flash with: {TOOLS_ADVICE}")


def flash(built: Built, port: str, fileno: int | None) -> None:
    """Flash a program and read it back; what the tool says goes to standard error.

    Args:
        built: the program.
        port: the path of the serial port.
        fileno: of that port, opened by the caller and held meanwhile: avrdude waits for ever for a board that was
            unplugged. None: nobody watches it.

    Raises ``UsageError`` (no tool) or ``LinkError``; that and a ``KeyboardInterrupt`` have a note that says what is on
    the board then. However it ends, the tool has ended too.
    """
    command = flash_command(built, port)
    said = bytearray()
    try:
        code = _run(command, fileno, said)
        if code:
            raise LinkError(_failure(built, port, said.decode(errors="replace")))
    except (LinkError, KeyboardInterrupt) as error:
        error.add_note(_state(said.decode(errors="replace")))
        raise


def _run(command: list[str], fileno: int | None, said: bytearray) -> int:
    """Run the tool, pass on what it says, and return its exit code. Raises ``LinkError`` when it waits in vain."""
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as tool:
        try:
            assert tool.stdout is not None
            for data in _output(tool.stdout, fileno):
                said += data
                _pass_on(data)
                if said.count(b"not in sync") >= ENOUGH_ATTEMPTS:
                    tool.kill()
            return tool.wait()
        except BaseException:
            tool.kill()
            raise


def _output(pipe: IO[bytes], fileno: int | None) -> Iterator[bytes]:
    """What comes out of a pipe, as it comes. Raises ``LinkError`` when the port is gone."""
    if fileno is None:
        while data := os.read(pipe.fileno(), 4096):
            yield data
        return
    poll = select.poll()
    poll.register(pipe, select.POLLIN)
    poll.register(fileno, 0)  # only whether it has hung up
    while True:
        events = dict(poll.poll())
        if fileno in events:
            raise LinkError("the port is gone: was the board unplugged?")
        data = os.read(pipe.fileno(), 4096)
        if not data:
            return
        yield data


def _pass_on(data: bytes) -> None:
    with contextlib.suppress(OSError):  # nobody reads it: the board comes first
        os.write(2, data)


def _failure(built: Built, port: str, said: str) -> str:
    """What went wrong, for people: what they can do about it depends on what the tool said."""
    board = built.board
    text = f"{built.sketch} could not be flashed to the {board.name} at {port}: "
    if re.search("expected signature", said, re.IGNORECASE):
        found = re.search(r"signature = (0x[0-9a-f]+)", said)
        return (
            f"{text}the chip there{f', {found[1]},' if found else ''} is not the {board.chip} of the {board.name}. "
            "Is it another board (--board)?"
        )
    if re.search("not in sync|not responding|timeout communicating", said):
        other = {
            "nano": " (many have the old bootloader: --board nano-old)",
            "nano-old": " (or --board nano)",
        }
        return (
            f"{text}no bootloader answers there at {board.baud} baud. Is it the right port (`turtlewire ports`) and "
            f"board{other.get(board.name, '')}? Something at pins 0 and 1, such as a Bluetooth module, has to be "
            "unplugged meanwhile; a board that does not reset by itself is reset by its button as this begins"
        )
    if re.search("verification (error|mismatch)|content mismatch", said):
        return f"{text}what is on it now is not what was written. If that happens again, its chip is worn"
    return f"{text}see above. Is it the right port (`turtlewire ports`), and is no other program using it?"


def _state(said: str) -> str:
    """What is on the board, by what the tool said before it ended."""
    if "bytes of flash written" in said:
        return WRITTEN
    return TORN if HAS_BEGUN.search(said) else UNTOUCHED
