"""The files of a program that may come from anybody: those in one folder, and of the machine nothing else."""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.logo.errors import LogoError
from turtlewire.logo.streams import Streams

if TYPE_CHECKING:
    from pathlib import Path

    from turtlewire.logo import Interpreter

_CANNOT_OPEN = 40
# So many files may a program open to write them: nobody fills a disk with empty ones.
MOST_WRITTEN = 100


class ConfinedStreams(Streams):
    """The streams of an interpreter whose file words reach what is in a folder, and nothing else.

    Args:
        logo: the interpreter.
        folder: where files are; ``None``: there are none at all.
    """

    def __init__(self, logo: Interpreter, folder: Path | None) -> None:
        super().__init__(logo)
        self._folder = folder.resolve() if folder is not None else None
        self._written: set[Path] = set()

    def path(self, name: str) -> Path:
        """Where a file of this name is.

        Raises:
            LogoError: it is not in the folder.
        """
        folder = self._folder
        if folder is None:
            raise _refused(name, "There is no folder for files here.")
        try:
            found = (folder / self.prefix / name).resolve()
            is_inside = found.is_relative_to(folder) and found != folder
        except (OSError, ValueError, RuntimeError):  # a name with a NUL, links in a circle
            is_inside = False
            found = folder
        if not is_inside or any(part.startswith(".") for part in found.relative_to(folder).parts):
            raise _refused(
                name, "A program in the console opens files of the programs folder, and no others."
            )
        return found

    def open(self, name: str, mode: str) -> None:
        """Open a file.

        Raises:
            LogoError: it is open, cannot be opened, or is one too many that is written.
        """
        if mode != "rb":
            self._written.add(self.path(name))
            if len(self._written) > MOST_WRITTEN:
                raise _refused(name, f"A program in the console may write {MOST_WRITTEN} files.")
        super().open(name, mode)


def _refused(name: str, why: str) -> LogoError:
    return LogoError(_CANNOT_OPEN, f"I can't open file {name or '||'}", hint=why)
