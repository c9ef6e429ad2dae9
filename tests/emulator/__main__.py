"""A sketch on an emulated Uno, behind a pseudo-terminal, at the pace of the clock on the wall.

    python -m tests.emulator PROGRAM.elf --baud 9600 --port FOLDER/port [--high 14 --high 15]

Standard input takes commands, one a line, and each of them is answered by a line of JSON:

    state            levels of the pins 0 to 19, duty (0..255) of the PWM pins 5 and 6, and what else can be told
    drawing          what its steppers and its pen servo have drawn since power-on
    press PIN LEVEL  something outside pulls a pin
    reset            the reset button
    unplug           no power, no port
    plug             power again: it boots; its port has the same name, and is another one

It ends with its standard input.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import sys
from pathlib import Path
from typing import Any

from turtlewire.simulator.server import serve

from .board import PINS
from .chip import Chip
from .turtle import drawing


class Served:
    """A chip and its port, which comes and goes."""

    def __init__(self, chip: Chip, port: Path) -> None:
        self._chip = chip
        self._port = port
        self._stopped = asyncio.Event()
        self._serving: asyncio.Task[None] | None = None

    async def do(self, command: str, *words: str) -> object:
        """Carry out one command; what it is answered by."""
        chip = self._chip
        match command:
            case "plug":
                ready = asyncio.Event()
                self._stopped = asyncio.Event()
                self._serving = asyncio.create_task(self._serve(ready))
                await ready.wait()
            case "unplug":
                await self.unplug()
                chip.reset()
            case "reset":
                chip.reset()
            case "press":
                chip.press(int(words[0]), int(words[1]))
            case "drawing":
                trace = drawing(chip)
                return {"pose": trace.pose, "strokes": trace.strokes}
            case _:
                return self._state()
        return {}

    async def unplug(self) -> None:
        """No power: its time stands still, and so does all that it does."""
        if self._serving is not None:
            self._stopped.set()
            await self._serving
            self._serving = None
            self._port.unlink()

    async def _serve(self, ready: asyncio.Event) -> None:
        def link(path: str) -> None:
            self._port.symlink_to(path)
            ready.set()

        await serve(self._chip, "pty", ready=link, stopped=self._stopped)

    def _state(self) -> dict[str, Any]:
        chip = self._chip
        return {
            "time_s": chip.now,
            "levels": [chip.level(pin) for pin in range(len(PINS))],
            "duty": {str(pin): chip.pwm(pin) for pin in (5, 6)},
            "edges": {str(pin): len(chip.edges(pin)) for pin in range(len(PINS))},
            "overruns": chip.overruns,
        }


async def main() -> None:
    """Read the command line, then commands."""
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=Path)
    parser.add_argument("--baud", type=int, required=True)
    parser.add_argument("--port", type=Path, required=True)
    parser.add_argument("--high", type=int, action="append", default=[])
    arguments = parser.parse_args()
    commands = asyncio.StreamReader()
    loop = asyncio.get_running_loop()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(commands), sys.stdin)
    with Chip(arguments.program, arguments.baud) as chip:
        for pin in arguments.high:
            chip.press(pin, 1)
        served = Served(chip, arguments.port)
        await served.do("plug")
        print("{}", flush=True)
        while line := await commands.readline():
            print(json.dumps(await served.do(*line.decode().split())), flush=True)
        await served.unplug()


asyncio.run(main())
