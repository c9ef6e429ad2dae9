"""The core of the firmware, compiled for this computer: what its robots' ends make of bytes."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Self

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

LIBRARY = Path(__file__).parents[2] / "firmware" / "Turtlewire"
SOURCES = sorted((LIBRARY / "src" / "turtlewire").glob("*.cpp"))
RUNNER = LIBRARY / "extras" / "test" / "runner.cpp"
INSTANTIATED = RUNNER.with_name("instantiated.cpp")
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wsign-conversion", "-Wshadow", "-Werror"]
SANITIZERS = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]


def compiler() -> str:
    """The C++ compiler of this system."""
    found = shutil.which("g++") or shutil.which("clang++")
    assert found, "no C++ compiler: install g++ (Debian: apt install g++)"
    return found


def build(folder: Path, *flags: str) -> Path:
    """Compile the core and its runner; return the program."""
    program = folder / "runner"
    command = [
        compiler(),
        "-std=c++11",
        *WARNINGS,
        *flags,
        *map(str, SOURCES),
        str(RUNNER),
        "-o",
        str(program),
    ]
    made = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    assert made.returncode == 0, made.stderr
    return program


class Outcome(NamedTuple):
    """What one command led to: what the robot did, in order, and its state after it."""

    events: list[str]
    state: dict[str, str]


class Core:
    """The runner at work: a robot at a time. A context manager."""

    def __init__(self, program: Path) -> None:
        self._process = subprocess.Popen(
            [program],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "LC_ALL": "C"},
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        self._process.stdout.close()
        assert self._process.wait() == 0

    def do(self, commands: list[str]) -> list[Outcome]:
        """Run commands of the runner; what each of them led to."""
        assert self._process.stdin is not None
        self._process.stdin.write("\n".join([*commands, "flush\n"]))
        self._process.stdin.flush()
        return [self._outcome() for _ in commands]

    def _outcome(self) -> Outcome:
        assert self._process.stdout is not None
        found = next(outcomes(iter(self._process.stdout.readline, "")), None)
        assert found is not None, "the runner ended: it says why above"
        return found


def run(program: Path, commands: list[str]) -> list[Outcome]:
    """What many commands led to, in a process of their own. Raises ``CalledProcessError`` if it fails."""
    done = subprocess.run(
        [program], input="\n".join([*commands, ""]), capture_output=True, text=True, check=True
    )
    return list(outcomes(done.stdout.splitlines()))


def outcomes(lines: Iterable[str]) -> Iterator[Outcome]:
    """What the lines that the runner wrote tell."""
    events: list[str] = []
    for line in lines:
        if line.startswith("="):
            state = line[1:].split()
            yield Outcome(events, dict(zip(state[::2], state[1::2], strict=True)))
            events = []
        else:
            events.append(line.rstrip("\n"))


def arrive(data: bytes, at_ms: int = 0) -> str:
    """The command by which bytes arrive, at a time in milliseconds."""
    return f"bytes {data.hex() or '-'} {at_ms}"
