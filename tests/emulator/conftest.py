"""The sketches, built once, and the boards that run them."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Protocol

import pytest

from turtlewire.firmware import BOARDS, Built, Sketch, build, find_sketch

CONSTANT = r"^(const(?:expr)? \w+ {name} = )[^;]+;"


class Build(Protocol):
    """``built("SimpleCar")``: a sketch, built for the Uno; ``built("SimpleCar", BAUD="115200")``: a changed copy."""

    def __call__(self, name: str, **constants: str) -> Built:
        """The program; constants of the sketch, or of a header that stands beside it, by their new values."""


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Build:
    """Sketches, built once for each set of constants."""
    made: dict[tuple[str, ...], Built] = {}
    folder = tmp_path_factory.mktemp("firmware")

    def get(name: str, **constants: str) -> Built:
        key = (name, *(f"{constant}={value}" for constant, value in constants.items()))
        if key not in made:
            sketch = find_sketch(name)
            if constants:
                copied = shutil.copytree(sketch.path.parent, folder / "sketches" / "-".join(key) / name)
                _change(Path(copied), constants)
                sketch = Sketch(name, Path(copied) / sketch.path.name)
            made[key] = build(sketch, BOARDS["uno"], folder / "-".join(key), "avr-gcc")
        return made[key]

    return get


def _change(folder: Path, constants: dict[str, str]) -> None:
    sources = [path for path in folder.iterdir() if path.suffix in (".ino", ".h")]
    for name, value in constants.items():
        changed = 0
        for path in sources:
            text, count = re.subn(
                CONSTANT.format(name=name), rf"\g<1>{value};", path.read_text("utf-8"), flags=re.MULTILINE
            )
            path.write_text(text, "utf-8")
            changed += count
        assert changed == 1, f"{name} stands {changed} times in {folder}"
