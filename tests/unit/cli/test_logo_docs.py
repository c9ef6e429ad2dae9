"""docs/logo-tools.md: its commands print what it says. Its prompt is in the end-to-end tests."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PAGE = (ROOT / "docs" / "logo-tools.md").read_text("utf-8")
BLOCKS = re.findall(r"^```text\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
PROGRAMS = {match[1]: block for block in BLOCKS if (match := re.match(r"; (\S+\.logo)\n", block))}
COMMANDS = [block for block in BLOCKS if block.startswith("$ ")]


@pytest.mark.parametrize("block", COMMANDS, ids=lambda block: block.splitlines()[0])
def test_a_command_prints_what_the_page_says(block: str, tmp_path: Path) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    for name, text in PROGRAMS.items():
        (tmp_path / name).write_text(text, "utf-8")
    command, _, output = block.partition("\n")
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "-c", command.removeprefix("$ ")],
        cwd=tmp_path,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout == output


def test_there_are_some() -> None:
    assert len(COMMANDS) >= 4
    assert len(PROGRAMS) >= 3
