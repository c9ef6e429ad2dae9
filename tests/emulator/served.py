"""An emulated board in a process of its own, behind a port: what a test plugs in, looks at and unplugs."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from turtlewire.trace import Stroke, Trace
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from turtlewire.firmware import Built

ROOT = Path(__file__).parents[2]


class ServedBoard:
    """``python -m tests.emulator`` at work. A context manager; when it is left, so is the board.

    Attributes:
        port: a path that is the same whenever it is plugged in.
    """

    def __init__(self, program: Built, baud: int, folder: Path, high: tuple[int, ...] = ()) -> None:
        self.port = str(folder / "ttyROBOT")
        command = [sys.executable, "-m", "tests.emulator", str(program.elf), "--baud", str(baud)]
        command += ["--port", self.port, *(word for pin in high for word in ("--high", str(pin)))]
        self._process = subprocess.Popen(
            command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def __enter__(self) -> Self:
        self._answer()
        return self

    def __exit__(self, *_: object) -> None:
        self._process.communicate()
        assert self._process.returncode == 0

    def do(self, command: str) -> Any:
        """Have it do something; what it says to that."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{command}\n")
        self._process.stdin.flush()
        return self._answer()

    def _answer(self) -> Any:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert line, "the board has ended: it says why above"
        return json.loads(line)

    def duty(self, pin: int) -> int:
        """What is set for a PWM pin, 0..255."""
        return int(self.do("state")["duty"][str(pin)])

    def drawing(self) -> Trace:
        """What its steppers and its pen servo have drawn."""
        told = self.do("drawing")
        trace = Trace()
        trace.strokes = [Stroke(down, [(x, y) for x, y in points]) for down, points in told["strokes"]]
        trace.pose = Pose(*told["pose"])
        return trace
