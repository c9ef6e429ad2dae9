"""Compiled procedures, kept on disk: a program that is started again is not compiled again.

A file holds what became of all procedures of one workspace, and the text of all of them: so whatever a compiled
procedure relies on is the same, or the file is another one. What cannot be read is as good as not there.
"""

from __future__ import annotations

import marshal
import os
import sys
from zlib import crc32

from turtlewire.named_tuple import NamedTuple

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable
    from types import CodeType
    from typing import Any

FILES_KEPT = 200
SUFFIX = ".logo-code"
_CHECK_BYTES = 4


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
        self._folder = folder

    def load(self, texts: Iterable[str]) -> dict[str, Kept]:
        """What is kept of the procedures with these texts, all of them; empty when nothing is."""
        key = _key(texts)
        try:
            with open(self._path(key), "rb") as file:
                data = file.read()
            found = contents(data)
        except (OSError, ValueError, EOFError, TypeError):
            return {}
        # Two programs may have files of the same name, if rarely.
        return {name: Kept(*each) for name, each in found[1].items()} if found[0] == key else {}

    def save(self, texts: Iterable[str], kept: dict[str, Kept]) -> None:
        """Keep what became of the procedures with these texts. A folder that cannot be written to is no error."""
        key = _key(texts)
        path = self._path(key)
        new = f"{path}.{os.getpid()}"
        try:
            os.makedirs(self._folder, exist_ok=True)
            with open(new, "wb") as file:
                file.write(packed(key, {name: tuple(each) for name, each in kept.items()}))
            os.replace(new, path)  # in one step: another program may read it now
            with os.scandir(self._folder) as entries:
                files = [
                    (each.stat().st_mtime_ns, each.path) for each in entries if each.name.endswith(SUFFIX)
                ]
            for _, old in sorted(files)[:-FILES_KEPT]:
                os.unlink(old)
        except OSError:
            return  # another program may have removed an old file, too

    def _path(self, key: str) -> str:
        return f"{self._folder}/{crc32(key.encode()):08x}{SUFFIX}"


def packed(key: str, entries: dict[str, tuple[Any, ...]]) -> bytes:
    """What a file holds: that it is whole, what it is of, and what was made of that."""
    content = marshal.dumps((key, entries))
    return crc32(content).to_bytes(_CHECK_BYTES) + content


def contents(data: bytes) -> tuple[str, dict[str, tuple[Any, ...]]]:
    """What a file is of, and what was made of that.

    Raises:
        ValueError, EOFError, TypeError: it is no such file, or not whole.
    """
    content = data[_CHECK_BYTES:]
    if crc32(content).to_bytes(_CHECK_BYTES) != data[:_CHECK_BYTES]:
        raise ValueError("the file is not whole")
    key, entries = marshal.loads(content)
    return key, entries


def _key(texts: Iterable[str]) -> str:
    """What a file is of: these texts, and which Python and which Logo have made it: code is for one version of each."""
    logo = os.path.dirname(os.path.dirname(__file__))
    made_by: list[tuple[str, int, int]] = []
    for folder in (logo, os.path.dirname(__file__), f"{logo}/primitives"):
        with os.scandir(folder) as entries:
            for each in entries:
                if each.name.endswith(".py"):
                    status = each.stat()
                    made_by.append((each.name, status.st_size, status.st_mtime_ns))
    return repr((sys.version, sorted(made_by), *texts))
