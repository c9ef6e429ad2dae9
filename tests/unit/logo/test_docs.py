"""docs/logo.md: its programs run and print what it says, and its tables are complete."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from turtlewire.logo.primitives import PRIMITIVES

if TYPE_CHECKING:
    from .conftest import Session

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "logo.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```logo\n(.*?)```\n(?:\n```text\n(.*?)```)?", PAGE, re.DOTALL)
ROWS = re.findall(r"^\| (`.*?`) \| (.*) \|$", PAGE, re.MULTILINE)
_NAME = re.compile(r"`` (`) ``|`(.+?)`")


@pytest.mark.parametrize(("program", "output"), EXAMPLES)
def test_example(session: Session, program: str, output: str) -> None:
    assert session.run(program) == output


def test_there_are_examples() -> None:
    assert len(EXAMPLES) == PAGE.count("```logo") > 10


def test_the_tables_have_every_primitive_and_no_other() -> None:
    names = [name for row, _ in ROWS for name in _names(row)]
    assert sorted(names) == sorted(PRIMITIVES)


def _names(row: str) -> list[str]:
    """The names in a row of a table; the backquote is written between two of them."""
    return [backquote or name for backquote, name in _NAME.findall(row)]


def test_synonyms_stand_in_one_row() -> None:
    for row, line in ROWS:
        names = _names(row)
        assert len({id(PRIMITIVES[name]) for name in names}) == 1
        assert line.endswith((".", "?", "`"))
