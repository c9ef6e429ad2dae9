"""The mutants of the core, those among them that change nothing, and the report."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import NamedTuple

from tests.firmware.core import LIBRARY
from tools.mutation.operators import Mutant, mutants
from tools.mutation.trial import Verdict

# The other two dialects' headers are made by the same generator as the third, which has every kind of field.
FILES = (
    "simple.h",
    "simple.cpp",
    "simple_messages.h",
    "walter.h",
    "walter.cpp",
    "walter_messages.h",
    "frame.h",
    "frame_telemetry.h",
)
EQUIVALENT = Path(__file__).with_name("equivalent.toml")


def all_mutants() -> list[Mutant]:
    """Every mistake in every file."""
    folder = LIBRARY / "src" / "turtlewire"
    return [mutant for file in FILES for mutant in mutants(file, (folder / file).read_text("utf-8"))]


SUMMARY = (
    "{mutants} mutants: {stillborn} do not compile, {equivalent} change nothing, {killed} are noticed, "
    "{survived} are not: score {score:.1%}"
)


class Equivalent(NamedTuple):
    """Mutants that do the same: a line of a file, what it becomes (any number of them), and why nothing changes."""

    file: str
    original: str
    mutated: tuple[str, ...]
    reason: str

    def matches(self, mutant: Mutant) -> bool:
        """Whether this is one of them, wherever its line stands now."""
        return (
            mutant.file == self.file
            and mutant.original.strip() == self.original
            and mutant.mutated.strip() in self.mutated
        )


def equivalents() -> list[Equivalent]:
    """The list."""
    entries = tomllib.loads(EQUIVALENT.read_text("utf-8"))["equivalent"]
    return [Equivalent(e["file"], e["original"], tuple(e["mutated"]), e["reason"]) for e in entries]


class Report(NamedTuple):
    """What became of the mutants."""

    verdicts: dict[Mutant, Verdict]
    equivalents: list[Equivalent]

    def is_equivalent(self, mutant: Mutant) -> bool:
        """Whether the list has it."""
        return any(entry.matches(mutant) for entry in self.equivalents)

    def survivors(self) -> list[Mutant]:
        """Mistakes that nothing noticed."""
        survived = (mutant for mutant, verdict in self.verdicts.items() if verdict is Verdict.SURVIVED)
        return [mutant for mutant in survived if not self.is_equivalent(mutant)]

    def wrongly_listed(self) -> list[Mutant]:
        """Mistakes that the list calls none, but which were noticed."""
        noticed = (mutant for mutant, verdict in self.verdicts.items() if verdict is Verdict.KILLED)
        return [mutant for mutant in noticed if self.is_equivalent(mutant)]

    def is_good(self) -> bool:
        """Whether every mistake was noticed."""
        return not self.survivors() and not self.wrongly_listed()

    def data(self) -> dict[str, object]:
        """For ``--json``."""
        count = {verdict: list(self.verdicts.values()).count(verdict) for verdict in Verdict}
        survivors = self.survivors()
        killed = count[Verdict.KILLED]
        return {
            "mutants": len(self.verdicts),
            "stillborn": count[Verdict.STILLBORN],
            "killed": killed,
            "equivalent": count[Verdict.SURVIVED] - len(survivors),
            "survived": len(survivors),
            "score": round(killed / max(1, killed + len(survivors)), 4),
            "survivors": [mutant._asdict() for mutant in survivors],
            "wrongly listed as equivalent": [mutant._asdict() for mutant in self.wrongly_listed()],
        }

    def text(self) -> str:
        """For people."""
        data = self.data()
        return "\n".join(
            [
                *(f"survived  {mutant}" for mutant in self.survivors()),
                *(f"listed as equivalent, but noticed  {mutant}" for mutant in self.wrongly_listed()),
                SUMMARY.format_map(data),
            ]
        )
