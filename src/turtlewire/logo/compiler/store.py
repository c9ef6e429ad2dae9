"""Compiled procedures, kept on disk: a program that is started again is not compiled again.

A file holds what became of all procedures of one workspace, by the text of all of them: so whatever a compiled
procedure relies on is the same, or the file is another one. What cannot be read is as good as not there.
"""

from __future__ import annotations

import hashlib
import marshal
import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable
    from types import CodeType

FILES_KEPT = 200
_DIGEST_BYTES = 32


def _made_by() -> tuple[object, ...]:
    """Which Python, and which compiler: code is for one version of each."""
    files = sorted(Path(__file__).parent.parent.rglob("*.py"))
    return (sys.version, *((each.name, each.stat().st_size, each.stat().st_mtime_ns) for each in files))


class Kept(NamedTuple):
    """What is kept of a procedure.

    Attributes:
        code: what makes its functions; ``None``: it is left to the evaluator.
        refusal: why.
        names: its variables that are in Python locals.
        primitives: those that it uses, and which of them move the robot.
        calls: the procedures that it names.
        lists: those that stand in it: by which name it finds each, and how far behind its title each stands.
    """

    code: CodeType | None
    refusal: str
    names: dict[str, str]
    primitives: list[tuple[str, bool]]
    calls: list[str]
    lists: list[tuple[str, int]]


class Store:
    """A folder of compiled programs.

    Args:
        folder: made when something is put there.
    """

    def __init__(self, folder: str) -> None:
        self._folder = Path(folder)

    def load(self, texts: Iterable[str]) -> dict[str, Kept]:
        """What is kept of the procedures with these texts, all of them; empty when nothing is."""
        with suppress(OSError, ValueError, EOFError, TypeError):
            data = self._path(texts).read_bytes()
            digest, content = data[:_DIGEST_BYTES], data[_DIGEST_BYTES:]
            if hashlib.sha256(content).digest() == digest:
                found: dict[str, tuple[Any, ...]] = marshal.loads(content)
                return {name: Kept(*each) for name, each in found.items()}
        return {}

    def save(self, texts: Iterable[str], kept: dict[str, Kept]) -> None:
        """Keep what became of the procedures with these texts. A folder that cannot be written to is no error."""
        content = marshal.dumps({name: tuple(each) for name, each in kept.items()})
        path = self._path(texts)
        new = path.with_suffix(f".{os.getpid()}")
        with suppress(OSError):
            path.parent.mkdir(parents=True, exist_ok=True)
            new.write_bytes(hashlib.sha256(content).digest() + content)
            new.replace(path)  # in one step: another program may read it now
            files = sorted(path.parent.glob("*.logo-code"), key=lambda each: each.stat().st_mtime_ns)
            for old in files[:-FILES_KEPT]:
                old.unlink(missing_ok=True)

    def _path(self, texts: Iterable[str]) -> Path:
        key = repr((_made_by(), *texts))
        return self._folder / f"{hashlib.sha256(key.encode(errors='surrogatepass')).hexdigest()}.logo-code"
