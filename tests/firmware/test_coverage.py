"""Every line and every branch of the core is reached by the fixed inputs, in every dialect."""

from __future__ import annotations

import gzip
import json
import shutil
import subprocess
from collections import defaultdict
from typing import TYPE_CHECKING, Any

from .core import INSTANTIATED, LIBRARY, SOURCES, build, run
from .fixed_inputs import fixed

if TYPE_CHECKING:
    from pathlib import Path

CORE = LIBRARY / "src" / "turtlewire"
FILES = sorted(path.name for path in CORE.iterdir() if path.suffix in (".h", ".cpp"))
# Exceptions would add branches that no robot has.
# What is made of instantiated.cpp, which nobody calls, tells only that there is code.
NOWHERE = "_GLOBAL__N_17Handler"
FLAGS = ("-O0", "--coverage", "-fno-exceptions", "-fkeep-inline-functions")


def lines_of_the_core(folder: Path) -> dict[str, list[Any]]:
    """gcov's lines of each file of the core; those of templates once for each type that they were made for."""
    program = build(folder, *FLAGS, str(INSTANTIATED))
    for expected in fixed().values():
        expected.compare(run(program, expected.commands))
    return gcov(folder)


def gcov(folder: Path) -> dict[str, list[Any]]:
    assert shutil.which("gcov"), "no gcov: it comes with g++ (Debian: apt install g++)"
    notes = sorted(folder.glob("*.gcno"))
    assert len(notes) == len(SOURCES) + 2, notes
    subprocess.run(
        ["gcov", "--json-format", "--branch-probabilities", *map(str, notes)],
        cwd=folder,
        check=True,
        capture_output=True,
    )
    lines: dict[str, list[Any]] = defaultdict(list)
    for path in folder.glob("*.gcov.json.gz"):
        for file in json.loads(gzip.decompress(path.read_bytes()))["files"]:
            name = file["file"].rsplit("/", 1)[-1]
            if file["file"].endswith(f"turtlewire/{name}"):
                lines[name] += file["lines"]
    return lines


def missing(name: str, lines: list[Any]) -> list[str]:
    """What no input reaches.

    Inline functions are compiled with every file that includes their header, and templates for each type: frame.h is
    complete for each dialect; a dialect's own templates all together, as a message of which all values are valid is
    never refused.
    """
    together = name.startswith("frame_")
    reached = {line["line_number"] for line in lines if line["count"]}
    found = [f"{n}: no input comes here" for n in sorted({line["line_number"] for line in lines} - reached)]
    made: dict[tuple[str, int], list[Any]] = defaultdict(list)
    for line in lines:
        if not together and NOWHERE in line["function_name"]:
            continue
        made["" if together else line["function_name"], line["line_number"]].append(line)
    for (function, number), same in sorted(made.items(), key=lambda item: item[0][1]):
        if number in reached and not any(line["count"] for line in same):
            found.append(f"{number}: not reached ({function})")
        branches = zip(*(line["branches"] for line in same), strict=True)
        found += [
            f"{number}: branch {place} not taken ({function})"
            for place, each in enumerate(branches)
            if not any(branch["count"] for branch in each)
        ]
    return found


def test_every_line_and_branch_is_reached(tmp_path: Path) -> None:
    covered = lines_of_the_core(tmp_path)
    assert sorted(covered) == FILES
    assert {name: missing(name, lines) for name, lines in covered.items()} == {name: [] for name in FILES}
