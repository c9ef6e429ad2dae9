"""Builds every sketch for the Uno, and compares what they take with firmware/budgets.toml.

python -m tools.firmware build/firmware

The folder gets a .hex and an .elf of each, and sizes.json; the table is printed. Exit code 1: one takes too much.
"""

from __future__ import annotations

import json
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tools.generators.python import ROOT
from turtlewire.errors import TurtlewireError
from turtlewire.firmware import BOARDS, SKETCHES, build

if TYPE_CHECKING:
    from turtlewire.firmware import Built

BUDGETS_FILE = ROOT / "firmware" / "budgets.toml"
BOARD = BOARDS["uno"]


class Budget(NamedTuple):
    """What a sketch may take, in bytes."""

    flash: int
    ram: int
    stack: int

    def excess(self, program: Built) -> list[str]:
        """What a program takes beyond that, for people."""
        used = (("flash", program.flash_bytes, self.flash), ("RAM", program.ram_bytes, self.ram))
        return [f"{size - most} bytes of {what} too many" for what, size, most in used if size > most]


def budgets(file: Path = BUDGETS_FILE) -> dict[str, Budget]:
    """The budget of each sketch, by its name."""
    tables = tomllib.loads(file.read_text("utf-8"))
    return {name: Budget(**table) for name, table in tables.items()}


def table(programs: list[Built], allowed: dict[str, Budget]) -> str:
    """The sizes for people: of flash and RAM what is taken, and what may be."""
    rows = [("sketch", "flash", "may be", "RAM", "may be", "")]
    for program in programs:
        budget = allowed[program.sketch]
        flash, most_flash = str(program.flash_bytes), str(budget.flash)
        ram, most_ram = str(program.ram_bytes), str(budget.ram)
        rows.append((program.sketch, flash, most_flash, ram, most_ram, ", ".join(budget.excess(program))))
    return "".join(
        f"{name:12}{flash:>8}{most_flash:>8}{ram:>8}{most_ram:>8}  {note}".rstrip() + "\n"
        for name, flash, most_flash, ram, most_ram, note in rows
    )


def main(folder: Path, budgets_file: Path = BUDGETS_FILE) -> int:
    """Build, and compare; the exit code."""
    allowed = budgets(budgets_file)
    try:
        with ThreadPoolExecutor(cpu_count()) as threads:
            programs = list(threads.map(lambda sketch: build(sketch, BOARD, folder), SKETCHES.values()))
    except TurtlewireError as error:
        print(error, file=sys.stderr)
        return 1
    sizes = {
        program.sketch: {
            "board": program.board.name,
            "tool": program.tool,
            "hex": program.hex.name,
            "flash_bytes": program.flash_bytes,
            "ram_bytes": program.ram_bytes,
            "excess": allowed[program.sketch].excess(program),
        }
        for program in programs
    }
    (folder / "sizes.json").write_text(json.dumps(sizes, indent=2) + "\n", "utf-8")
    print(table(programs, allowed), end="")
    return 1 if any(size["excess"] for size in sizes.values()) else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
