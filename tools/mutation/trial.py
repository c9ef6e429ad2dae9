"""The trial of one mutant: the core with a mistake is compiled, and gets the fixed inputs."""

from __future__ import annotations

import shutil
import subprocess
from enum import Enum
from typing import TYPE_CHECKING

from tests.firmware.core import LIBRARY, RUNNER, SANITIZERS, SOURCES, compiler, outcomes
from tests.firmware.fixed_inputs import fixed

if TYPE_CHECKING:
    from pathlib import Path

    from tests.firmware.expected import Expected
    from tools.mutation.operators import Mutant

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
            return self._verdict(mutant.file.replace(".", "_").split("_")[0])
        finally:
            path.write_text(text, "utf-8")

    def _verdict(self, protocol: str) -> Verdict:
        if not self._build():
            return Verdict.STILLBORN
        right = self._right[protocol]
        if self._run(protocol) != right and not self._agrees(protocol):
            return Verdict.KILLED
        # What reads or writes beyond an array may have been lucky.
        assert self._build("-g", *SANITIZERS)
        return (
            Verdict.SURVIVED if self._run(protocol) is not None and self._agrees(protocol) else Verdict.KILLED
        )

    def _build(self, *flags: str) -> bool:
        files = [str(self._tree / path.relative_to(LIBRARY)) for path in (RUNNER, *SOURCES)]
        command = [compiler(), "-std=c++11", "-w", "-O0", *flags, *files, "-o", "runner"]
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
