"""``turtlewire logo --check``: what is wrong with programs, without running them."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from turtlewire.cli import output, program

if TYPE_CHECKING:
    from turtlewire.logo.checking import Finding

FOUND = 1


def execute(programs: list[str], *, as_json: bool) -> int:
    """Check programs, the standard input if there are none. Raises ``DataError`` for one that cannot be read."""
    from turtlewire.logo.checking import check

    found: list[Finding] = []
    for each in programs or ["-"]:
        found += check(program.read(each), program.name_of(each))
    if as_json:
        output.write(json.dumps({"findings": [_as_json(each) for each in found]}) + "\n")
    elif found:
        output.write("\n".join(each.explain() for each in found) + "\n")
    return FOUND if found else 0


def _as_json(finding: Finding) -> dict[str, Any]:
    position = finding.position
    return {
        "file": position.file,
        "line": position.line,
        "column": position.column,
        "kind": finding.kind,
        "message": finding.message,
        "hint": finding.hint,
    }
