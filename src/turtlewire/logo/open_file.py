"""A file that a program has open, and a buffer that stands for one: text in UTF-8, positions in bytes."""

from __future__ import annotations

import os

from turtlewire.logo.errors import LogoError
from turtlewire.logo.values import word

TYPE_CHECKING = False
if TYPE_CHECKING:
    from pathlib import Path
    from typing import BinaryIO, NoReturn

    from turtlewire.logo.values import List, Value

_FILE_SYSTEM_ERROR = 18
_CANNOT_OPEN = 40
_BEGINNING_MARK = "\ufeff"  # which Windows' Notepad puts before a text


def cannot_open(name: str, error: OSError, path: Path) -> LogoError:
    """A file that is not there, or may not be read or written."""
    reasons: list[tuple[type[OSError], str]] = [
        (IsADirectoryError, f"{path} is a folder."),
        (PermissionError, f"You may not open {path}: its permissions forbid it."),
    ]
    reason = next((text for kind, text in reasons if isinstance(error, kind)), f"{path}: {error.strerror}.")
    if isinstance(error, FileNotFoundError):
        folder = path.absolute().parent
        reason = f"There is no such file in {folder}." if folder.is_dir() else f"There is no folder {folder}."
    return LogoError(_CANNOT_OPEN, f"I can't open file {name or '||'}", hint=reason)


def _file_system_error(path: Path, reason: str) -> LogoError:
    return LogoError(_FILE_SYSTEM_ERROR, "File system error", hint=f"{path}: {reason}")


def decode(data: bytes, path: Path) -> str:
    """The text of bytes.

    Raises:
        LogoError: they are not UTF-8.
    """
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise _not_text(path, data[error.start]) from None


def _not_text(path: Path, byte: int) -> LogoError:
    reason = f"this is not text in UTF-8: there is a byte {byte:02X}. Save the file as UTF-8."
    return _file_system_error(path, reason)


class OpenFile:
    """A file that is open.

    Args:
        name: what the program calls it, for errors.
        path: where it is.
        mode: as of Python's ``open``: ``rb``, ``wb``, ``ab`` or ``r+b``; of the last, the position is the end.

    Raises:
        LogoError: it cannot be opened.
    """

    def __init__(self, name: str, path: Path, mode: str) -> None:
        self.name = name
        self.can_read = mode in ("rb", "r+b")
        self.can_write = mode != "rb"
        self._path = path
        try:
            self._file: BinaryIO = path.open(mode)  # type: ignore[assignment]
            if mode == "r+b":
                self._file.seek(0, os.SEEK_END)
        except OSError as error:
            raise cannot_open(name, error, path) from None
        except ValueError:  # a name with a NUL
            raise cannot_open(name, OSError(0, "no file can have this name"), path) from None

    def _refuse(self, error: OSError) -> NoReturn:
        raise _file_system_error(self._path, f"{error.strerror or error}.") from None

    def write(self, text: str) -> None:
        """Write a text at the position."""
        try:
            self._file.write(text.encode("utf-8"))
        except OSError as error:
            self._refuse(error)

    def read_line(self) -> str:
        """The next line with its newline, ``""`` at the end of the file."""
        try:
            is_beginning = self._file.tell() == 0
            line = decode(self._file.readline(), self._path)
        except OSError as error:
            self._refuse(error)
        return line.removeprefix(_BEGINNING_MARK) if is_beginning else line

    def read_character(self) -> str:
        """The next character, ``""`` at the end of the file."""
        try:
            data = self._file.read(1)
            if data >= b"\xc0":
                data += self._file.read(1 if data < b"\xe0" else 2 if data < b"\xf0" else 3)
        except OSError as error:
            self._refuse(error)
        return decode(data, self._path)

    def is_at_end(self) -> bool:
        """Whether nothing is left to be read."""
        try:
            rest = self._file.read(1)
            if rest:
                self._file.seek(-1, os.SEEK_CUR)
        except OSError as error:
            self._refuse(error)
        return not rest

    @property
    def position(self) -> int:
        """Where the next byte is read or written, from 0."""
        try:
            return self._file.tell()
        except OSError as error:
            self._refuse(error)

    @position.setter
    def position(self, position: int) -> None:
        try:
            self._file.seek(position)
        except OSError as error:
            self._refuse(error)

    def close(self) -> None:
        """Write what is to be written, and close the file."""
        try:
            self._file.close()
        except OSError as error:
            self._refuse(error)


class Buffer:
    """What is written to a list ``[variable size]``: so many characters, for the variable.

    Attributes:
        target: the list, which must be the same one each time.
        is_implicit: SETWRITE opened it, and so the next SETWRITE closes it.
    """

    def __init__(self, target: List, size: int, *, is_implicit: bool) -> None:
        self.target = target
        self.is_implicit = is_implicit
        self._left = size
        self._pieces: list[str] = []
        self._length = 0

    def write(self, text: str) -> None:
        """Keep a text, as far as there is room for it."""
        kept = text[: self._left]
        self._left -= len(kept)
        self._length += len(kept)
        self._pieces.append(kept)

    @property
    def position(self) -> int:
        """How many characters were kept."""
        return self._length

    def value(self) -> Value:
        """All that was written, as one word."""
        return word("".join(self._pieces))
