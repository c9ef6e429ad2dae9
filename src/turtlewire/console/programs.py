"""Programs in a folder on the server, which pages open and save, and the examples that come along.

Nothing is read or written outside the folder, and what somebody else has saved meanwhile is not lost: who saves says
which version it was that they changed.
"""

from __future__ import annotations

import hashlib
import os
import re
import stat
import threading
from pathlib import Path
from typing import NamedTuple

from turtlewire import whole_file
from turtlewire.console.refusals import Refused

# The longest program, bytes; a hundred times what a class writes.
LARGEST = 200_000
MOST = 2_000
SUFFIX = ".logo"
# Letters of any script, digits, and a few signs within; not "..", and nothing hidden.
NAME = re.compile(r"\w(?:[\w .()+-]{0,62}[\w)+])?\.logo")
EXAMPLES = (Path(__file__).parents[1] / "examples", Path(__file__).parents[3] / "examples")


class Kept(NamedTuple):
    """A program as it is kept: its name, its text, and what says which version that is."""

    name: str
    source: str
    etag: str


class Entry(NamedTuple):
    """A program in the list: its name, its length in bytes, and when it was saved, seconds since 1970."""

    name: str
    size: int
    saved: float


def default_folder() -> Path:
    """Where programs are kept unless somebody says otherwise: the user's own folder for data (XDG)."""
    home = os.environ.get("XDG_DATA_HOME", "")
    base = Path(home) if Path(home).is_absolute() else Path.home() / ".local" / "share"
    return base / "turtlewire" / "programs"


class Programs:
    """The programs of a folder, which is made when the first one is saved. May be used from any thread.

    Args:
        folder: where they are.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder.absolute()
        self._lock = threading.Lock()

    def prepare(self) -> None:
        """Make the folder. Raises ``OSError``."""
        self.folder.mkdir(mode=0o755, parents=True, exist_ok=True)

    def all(self) -> list[Entry]:
        """What there is, by name. Raises ``Refused`` when the folder cannot be read."""
        found = []
        try:
            for path in self.folder.iterdir():
                if NAME.fullmatch(path.name):
                    about = path.lstat()
                    if stat.S_ISREG(about.st_mode):
                        found.append(Entry(path.name, about.st_size, about.st_mtime))
        except FileNotFoundError:
            return []
        except OSError as error:
            raise self._failed("read", error) from error
        return sorted(found, key=lambda entry: entry.name.casefold())

    def read(self, name: str) -> Kept:
        """A program. Raises ``Refused``: there is none, or it is no text."""
        path = self._path(name)
        try:
            about = path.lstat()
            if about.st_size > LARGEST:
                raise Refused(413, "too_large", f"{name} has {about.st_size} bytes, and may have {LARGEST}")
            data = path.read_bytes() if stat.S_ISREG(about.st_mode) else None
        except FileNotFoundError:
            data = None
        except OSError as error:
            raise self._failed("read", error) from error
        if data is None:
            raise Refused(404, "no_program", f"there is no program {name}")
        return _kept(name, data)

    def write(self, name: str, source: str, *, instead_of: str | None) -> Kept:
        """Save a program.

        Args:
            name: its name.
            source: its text.
            instead_of: the version (``etag``) that it takes the place of; ``None``: there is none of that name yet.

        Raises ``Refused``: the name or the size is not allowed, or another version is there; nothing is written then.
        """
        path = self._path(name)
        data = source.encode("utf-8", "replace")
        if len(data) > LARGEST:
            raise Refused(413, "too_large", f"a program has {LARGEST} bytes at most, and not {len(data)}")
        with self._lock:
            self._expect(name, instead_of)
            if instead_of is None and len(self.all()) >= MOST:
                raise Refused(413, "too_many", f"there are {MOST} programs already: delete some")
            try:
                self.prepare()
                whole_file.replace(path, data)
            except OSError as error:
                raise self._failed("written", error) from error
        return _kept(name, data)

    def delete(self, name: str, *, instead_of: str) -> None:
        """Delete this version of a program. Raises ``Refused``, as ``write``."""
        path = self._path(name)
        with self._lock:
            self._expect(name, instead_of)
            try:
                path.unlink()
            except OSError as error:
                raise self._failed("written", error) from error

    def _expect(self, name: str, etag: str | None) -> None:
        """Raises ``Refused`` when another version is there than the one that is meant."""
        try:
            there = self.read(name).etag
        except Refused as refused:
            if refused.status != 404:
                raise
            there = None
        if there == etag:
            return
        if etag is None:
            raise Refused(412, "exists", f"there is a program {name} already")
        if there is None:
            raise Refused(412, "gone", f"somebody has deleted {name} meanwhile")
        raise Refused(412, "changed", f"somebody has changed {name} meanwhile")

    def _path(self, name: str) -> Path:
        if not NAME.fullmatch(name):
            raise Refused(
                422,
                "name",
                f"{name!r} is no name for a program: letters, digits, spaces and - + ( ) ., "
                f"64 at most, and {SUFFIX} at the end",
            )
        path = self.folder / name
        if path.is_symlink():
            raise Refused(404, "no_program", f"{name} is a link, and not followed")
        return path

    def _failed(self, done: str, error: OSError) -> Refused:
        return Refused(
            500, "folder", f"the programs folder {self.folder} cannot be {done}: {error.strerror or error}"
        )


def examples() -> list[Kept]:
    """The examples that come along."""
    folder = next((place for place in EXAMPLES if place.is_dir()), None)
    paths = sorted(folder.glob(f"*{SUFFIX}")) if folder is not None else []
    return [_kept(path.name, path.read_bytes()) for path in paths]


def _kept(name: str, data: bytes) -> Kept:
    try:
        source = data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise Refused(415, "no_text", f"{name} is not text in UTF-8") from error
    return Kept(name, source, f'"{hashlib.sha256(data).hexdigest()[:32]}"')
