"""The Arduino library, where it is, and its sketches."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from turtlewire.errors import UsageError

HERE = Path(__file__).parent
# In a wheel it lies beside this file; in a checkout, in a folder of its own.
PLACES = (HERE / "Turtlewire", HERE.parents[2] / "firmware" / "Turtlewire")


class Sketch(NamedTuple):
    """A program for a board: its name, and its file."""

    name: str
    path: Path


def library() -> Path:
    """The folder of the Arduino library ``Turtlewire``."""
    return next(place for place in PLACES if place.is_dir())


def _shipped() -> dict[str, Sketch]:
    found = sorted(library().glob("examples/*/*.ino"))
    return {path.stem: Sketch(path.stem, path) for path in found}


SKETCHES = _shipped()


def find_sketch(text: str) -> Sketch:
    """The sketch that is meant: the name of one that comes along, a folder with an ``.ino`` in it, or such a file.

    Raises ``UsageError``.
    """
    if text in SKETCHES:
        return SKETCHES[text]
    path = Path(text)
    if path.is_dir():
        path = path / f"{path.absolute().name}.ino"
    if path.suffix == ".ino" and path.is_file():
        return Sketch(path.stem, path)
    raise UsageError(
        f"there is no sketch {text!r}: write {', '.join(SKETCHES)}, or the path of a folder with an .ino of its name"
    )
