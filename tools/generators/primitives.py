"""src/turtlewire/logo/primitives/index.py: where the function of each Logo word is, so that it can be loaded late."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tools.generators.python import ROOT
from turtlewire.logo.primitives import chapter

if TYPE_CHECKING:
    from pathlib import Path

    from turtlewire.logo.procedures import Primitive

_FOLDER = ROOT / "src" / "turtlewire" / "logo" / "primitives"
_NO_CHAPTERS = ("__init__", "index", "inputs")


def chapters() -> dict[str, dict[str, Primitive]]:
    """The primitives by all of their names, in each chapter."""
    names = sorted(path.stem for path in _FOLDER.glob("*.py") if path.stem not in _NO_CHAPTERS)
    return {name: chapter(name).primitives for name in names}


def files() -> dict[Path, str]:
    """The index."""
    lines = [
        '"""Which chapter has which primitives. Made by `make generate` from the chapters; do not edit."""',
        "",
        "from __future__ import annotations",
        "",
        "# The names of each, the full one first; how many inputs it takes without parentheses; the fewest and the",
        "# most within them, -1 for any number.",
        "CHAPTERS: dict[str, tuple[tuple[str, int, int, int], ...]] = {",
    ]
    for name, primitives in chapters().items():
        lines.append(f'    "{name}": (')
        for each in dict.fromkeys(primitives.values()):
            words = " ".join([word for word, primitive in primitives.items() if primitive is each])
            numbers = f"{each.default_inputs}, {each.minimum_inputs}, {each.maximum_inputs}"
            lines.append(f'        ("{words}", {numbers}),')
        lines.append("    ),")
    return {_FOLDER / "index.py": "\n".join([*lines, "}"]) + "\n"}
