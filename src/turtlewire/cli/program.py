"""The text of a Logo program, from a file or from the standard input."""

from __future__ import annotations

import io
import os
import sys

from turtlewire.errors import DataError

STANDARD_INPUT = "standard input"


def name_of(program: str) -> str:
    """What a program is called in messages."""
    return STANDARD_INPUT if program == "-" else program


def read(program: str) -> str:
    """The text of a program; ``-`` is the standard input.

    Raises ``DataError`` for a file that cannot be read, or that is not text.
    """
    try:
        if program == "-":
            data = sys.stdin.buffer.read() if sys.stdin else b""
        else:
            with io.FileIO(program) as file:  # pathlib takes longer to load than a short program to run
                data = file.readall()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise DataError(f"cannot read the program {program}: {reason}") from error
    return text_of(data, program)


def text_of(data: bytes, program: str) -> str:
    """The text that the bytes of a program are. Raises ``DataError``, which says where they are none."""
    try:
        # Windows' Notepad begins a file with a mark, and ends lines with CR LF.
        return data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise DataError(
            f"{program} is not text in UTF-8: in line {line}, byte {error.start} is {error.object[error.start]:02X}. "
            "Save it as UTF-8"
        ) from error


def bound_memory() -> None:
    """A program that wants more memory than the computer has is told so, before the system ends it as it likes.

    Then nothing would stop the robot. (There are no such bounds on Windows, and macOS does not keep them.)
    """
    try:
        import resource

        most = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") * 3 // 4
        bound, hard = resource.getrlimit(resource.RLIMIT_AS)
        if bound == resource.RLIM_INFINITY or bound > most > 0:
            resource.setrlimit(resource.RLIMIT_AS, (most, hard))
    except (ImportError, AttributeError, OSError, ValueError):
        return  # it is no worse than without


def compiled_at() -> str | None:
    """Where compiled programs are kept for the next time; ``None``: nowhere, when there is no place for such things."""
    home = os.path.expanduser("~")  # noqa: PTH111 - pathlib takes longer to load than all else here
    folder = os.environ.get("XDG_CACHE_HOME") or (f"{home}/.cache" if home != "~" else "")
    return f"{folder}/turtlewire/logo" if folder else None
