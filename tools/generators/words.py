"""src/turtlewire/console/words.py: what each Logo word does, in one line, as the tables of docs/logo.md have it."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from tools.generators.python import ROOT

if TYPE_CHECKING:
    from pathlib import Path

_PAGE = ROOT / "docs" / "logo.md"
_MODULE = ROOT / "src" / "turtlewire" / "console" / "words.py"
_ROW = re.compile(r"^\| (`.*?`) \| (.*) \|$", re.MULTILINE)
_NAME = re.compile(r"`` (`) ``|`(.+?)`")


def rows() -> list[tuple[list[str], str]]:
    """The names in each row of the tables, and what stands beside them, without marks."""
    page = _PAGE.read_text("utf-8").partition("## All words")[2].partition("\n## ")[0]
    found: list[tuple[list[str], str]] = []
    for cell, marked in _ROW.findall(page):
        names = [quote or name for quote, name in _NAME.findall(cell)]
        text = marked.replace("`", "").replace("\\|", "|")
        if text.startswith("The same") and not text.startswith("The same as"):  # as the row above
            found.append((names, f"The same as {found[-1][0][0]}{text.removeprefix('The same')}"))
        else:
            found.append((names, text))
    return found


def files() -> dict[Path, str]:
    """The module."""
    lines = [
        '"""What each Logo word does, for completion. Made by `make generate` from docs/logo.md; do not edit."""',
        "",
        "from __future__ import annotations",
        "",
        "HELP: dict[str, str] = {",
    ]
    for names, text in rows():
        lines += [f"    {_quoted(name)}: {_quoted(text)}," for name in names]
    return {_MODULE: "\n".join([*lines, "}"]) + "\n"}


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\")
    if '"' in text and "'" not in text:
        return f"'{escaped}'"
    return '"' + escaped.replace('"', '\\"') + '"'
