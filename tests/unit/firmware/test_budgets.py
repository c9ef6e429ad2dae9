"""What the sketches take: ``make firmware``, and what the manual says of it."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING

from tools.firmware import Budget, budgets, main
from tools.generators.python import ROOT
from turtlewire.firmware import SKETCHES

if TYPE_CHECKING:
    from pathlib import Path

    import pytest


def test_every_sketch_has_its_budget() -> None:
    """Two of them have limits from before they were written."""
    allowed = budgets()
    assert set(allowed) == set(SKETCHES)
    assert allowed["SimpleCar"] <= Budget(4096, 300, 2048)
    assert allowed["SimpleCar"].ram <= 300
    assert allowed["Walter"].flash <= 16384
    assert allowed["Walter"].ram <= 900


def test_the_manual_has_them() -> None:
    rows = re.findall(
        r"^\| `(\w+)` \|.*\| (\d+) and (\d+) bytes \|$",
        (ROOT / "docs" / "firmware.md").read_text("utf-8"),
        re.MULTILINE,
    )
    assert {name: (int(flash), int(ram)) for name, flash, ram in rows} == {
        name: budget[:2] for name, budget in budgets().items()
    }


def test_all_of_them_are_built(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(tmp_path) == 0
    sizes = json.loads((tmp_path / "sizes.json").read_text("utf-8"))
    assert set(sizes) == set(SKETCHES)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["sketch", "flash", "may", "be", "RAM", "may", "be"]
    allowed = budgets()
    for line, (name, size) in zip(lines[1:], sizes.items(), strict=True):
        assert (tmp_path / size["hex"]).is_file()
        assert (tmp_path / f"{name}.elf").is_file()
        numbers = [size["flash_bytes"], allowed[name].flash, size["ram_bytes"], allowed[name].ram]
        assert line.split() == [name, *map(str, numbers)]

    # What one takes is allowed, but of the other's flash and RAM there is a byte too little.
    text = ""
    for name, size in sizes.items():
        less = 1 if name == "Walter" else 0
        text += (
            f"[{name}]\nflash = {size['flash_bytes'] - less}\nram = {size['ram_bytes'] - less}\nstack = 0\n"
        )
    (tmp_path / "tight.toml").write_text(text)
    assert main(tmp_path, tmp_path / "tight.toml") == 1
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines if "many" in line] == ["Walter"]
    excess = ["1 bytes of flash too many", "1 bytes of RAM too many"]
    sizes = json.loads((tmp_path / "sizes.json").read_text("utf-8"))
    assert [size["excess"] for size in sizes.values()] == [[], [], excess, []]
