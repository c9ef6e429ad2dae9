"""Every example in the documentation is run, and every link leads somewhere."""

from __future__ import annotations

import os
import random
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from turtlewire.logo import Interpreter, ScreenTurtle

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\[[^\]]*\]\(([^)#\s]+)[^)]*\)|(?:src|href)=\"([^\"#]+)\"")


class Block(NamedTuple):
    page: Path
    line: int
    text: str


def blocks(language: str) -> list[Block]:
    return [
        Block(page, text.count("\n", 0, match.start()) + 1, match[2])
        for page in PAGES
        for text in [page.read_text("utf-8")]
        for match in BLOCK.finditer(text)
        if match[1] == language
    ]


def name(block: Block) -> str:
    return f"{block.page.relative_to(ROOT)}:{block.line}"


def run(command: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


@pytest.mark.parametrize("block", blocks("python"), ids=name)
def test_python_runs(block: Block, tmp_path: Path) -> None:
    for file in blocks("toml"):
        dialect = re.search(r'^dialect = "(.+)"$', file.text, re.MULTILINE)
        if dialect and file.page == block.page:  # the page's own dialect, as the reader has saved it
            (tmp_path / f"{dialect[1]}.toml").write_text(file.text, "utf-8")
    done = run([sys.executable, "-W", "error", "-c", block.text], tmp_path)
    assert done.returncode == 0, done.stderr
    assert not done.stderr


@pytest.mark.parametrize("block", blocks("logo"), ids=name)
def test_logo_prints_what_stands_below_it(
    block: Block, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # for the files that it writes
    written: list[str] = []
    Interpreter(ScreenTurtle(), written.append, random.Random(0)).run(block.text, name(block))
    behind = block.page.read_text("utf-8").split("\n")[block.line + block.text.count("\n") + 1 :]
    if behind[1:2] == ["```text"]:
        assert "".join(written) == "".join([line + "\n" for line in behind[2 : behind.index("```", 2)]])


@pytest.mark.parametrize("block", blocks("console"), ids=name)
def test_commands_run(block: Block, tmp_path: Path) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    commands = [line[2:] for line in block.text.splitlines() if line.startswith("$ ")]
    assert commands
    for command in commands:
        done = run(["sh", "-c", command], tmp_path)
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for match in LINK.finditer(page.read_text("utf-8")):
        target = match[1] or match[2]
        if "://" not in target:
            assert (page.parent / target).exists(), f"{target} in {page.name}"


def test_there_is_something_to_run() -> None:
    assert len(blocks("python")) >= 4
    assert blocks("logo")
    assert blocks("console")


def test_the_readme_is_ten_lines_of_each_and_names_the_test_command() -> None:
    readme = (ROOT / "README.md").read_text("utf-8")
    for language in ("python", "logo"):
        first = next(block for block in blocks(language) if block.page.name == "README.md")
        assert len(first.text.splitlines()) <= 10
    assert "make test" in readme
    assert len(readme.splitlines()) < 120
