"""The trial of one mutant: the core with a mistake is compiled, and gets the fixed inputs."""

from __future__ import annotations

import re
import shutil
import subprocess
from enum import Enum
from typing import TYPE_CHECKING

from tests.firmware.core import LIBRARY, RUNNER, SANITIZERS, SOURCES, compiler, outcomes
from tests.firmware.fixed_inputs import fixed

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from tests.firmware.expected import Expected
    from tools.mutation.operators import Mutant

FILES = (RUNNER, *SOURCES)
# Mutants loop for ever and print without end.
LIMITS = "ulimit -t 5; ulimit -f 262144; exec"


class Verdict(Enum):
    """What became of a mutant."""

    KILLED = "killed"
    SURVIVED = "survived"
    STILLBORN = "does not compile"


class Trials:
    """Tries mutants in a folder of its own. Not for several threads at once: each needs its own.

    Raises ``AssertionError`` when it is made if the core fails without any mutation.
    """

    def __init__(self, folder: Path, inputs: dict[str, Expected] | None = None) -> None:
        self._folder = folder
        self._tree = folder / "Turtlewire"
        shutil.copytree(LIBRARY, self._tree)
        self._inputs = inputs or fixed()
        assert self._build(), "the core does not compile"
        self._right: dict[str, str | None] = {}
        for protocol in self._inputs:
            self._right[protocol] = self._run(protocol)
            assert self._agrees(protocol), f"the core fails for {protocol}: see tests/firmware"

    def try_out(self, mutant: Mutant) -> Verdict:
        """Compile the core with a mistake and see whether the Python ends disagree with it, or sanitizers do."""
        path = self._tree / "src" / "turtlewire" / mutant.file
        text = path.read_text("utf-8")
        lines = text.splitlines()
        assert lines[mutant.line - 1].startswith(mutant.original), f"{mutant} is out of date"
        lines[mutant.line - 1] = mutant.mutated
        try:
            path.write_text("\n".join([*lines, ""]), "utf-8")
            return self._verdict(mutant.file)
        finally:
            path.write_text(text, "utf-8")

    def _verdict(self, file: str) -> Verdict:
        protocol = re.split(r"\W|_", file)[0]
        # A header is a part of its own source and of the runner.
        parts = (protocol, RUNNER.stem) if file.endswith(".h") else ()
        mutated = [path for path in FILES if path.name == file or path.stem in parts]
        if not self._build(mutated):
            return Verdict.STILLBORN
        right = self._right[protocol]
        if self._run(protocol) != right and not self._agrees(protocol):
            return Verdict.KILLED
        # What reads or writes beyond an array may have been lucky.
        assert self._build(FILES, *SANITIZERS)
        is_right = self._run(protocol) is not None and self._agrees(protocol)
        return Verdict.SURVIVED if is_right else Verdict.KILLED

    def _build(self, mutated: Iterable[Path] = (), *flags: str) -> bool:
        """Compile the mutated sources, and link them with what is right of the others."""
        objects = []
        for path in FILES:
            made = ("mutated-" if path in mutated else "right-") + path.stem + ".o"
            objects.append(made)
            if path in mutated or not (self._folder / made).exists():
                source = str(self._tree / path.relative_to(LIBRARY))
                if not self._compile("-c", *flags, source, "-o", made):
                    return False
        return self._compile(*flags, *objects, "-o", "runner")

    def _compile(self, *arguments: str) -> bool:
        command = [compiler(), "-std=c++11", "-w", "-O0", "-fno-exceptions", "-fno-rtti", *arguments]
        return subprocess.run(command, cwd=self._folder, capture_output=True, check=False).returncode == 0

    def _run(self, protocol: str) -> str | None:
        """What the runner said; None if it failed."""
        commands = "\n".join([*self._inputs[protocol].commands, ""])
        told = self._folder / "told"
        with told.open("w") as out:
            done = subprocess.run(
                ["/bin/sh", "-c", f"{LIMITS} ./runner"],
                cwd=self._folder,
                input=commands,
                text=True,
                stdout=out,
                stderr=subprocess.DEVNULL,
                check=False,
            )
        return told.read_text("utf-8", "replace") if done.returncode == 0 else None

    def _agrees(self, protocol: str) -> bool:
        """Whether what was said last is what the Python ends say."""
        try:
            with (self._folder / "told").open(encoding="utf-8", errors="replace") as lines:
                self._inputs[protocol].compare(outcomes(lines))
        except (AssertionError, ValueError, KeyError, IndexError):
            return False
        return True
