"""Standard output and standard error: whatever becomes of them, the robot comes first."""

from __future__ import annotations

import errno
import io
import os
import sys

from turtlewire.errors import OutputError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import TextIO


def prepare() -> None:
    """Make both usable: open, able to take every character, and quick to show what is written."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            # The lowest free number, which is this one. A port must not become standard output.
            os.open(os.devnull, os.O_RDWR)
    # Closed, as by `>&-`; print() would write nothing, but write() would fail.
    sys.stdout = sys.stdout or io.TextIOWrapper(io.FileIO(os.devnull, "w"))
    sys.stderr = sys.stderr or io.TextIOWrapper(io.FileIO(os.devnull, "w"))
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace", line_buffering=True)


def write(text: str) -> None:
    """Write to standard output. Raises ``OutputError``."""
    try:
        sys.stdout.write(text)
    except OSError as error:
        raise _explained(error) from error


def tell(text: str) -> None:
    """Say something to people, on standard error; if nobody is there, nothing is lost by it."""
    try:
        print(text, file=sys.stderr, flush=True)
    except OSError:
        _give_up(sys.stderr)


def finish() -> None:
    """Write what has not been written yet. Raises ``OutputError``."""
    try:
        sys.stdout.flush()
    except OSError as error:
        raise _explained(error) from error


def leave(code: int) -> None:
    """End this program at once, when all is written and closed.

    Python would take what a script has made apart, piece by piece: a tenth of the time of a long one. Whoever wants to
    hear warnings (``-X dev``, ``-W``) wants that.
    """
    if not (sys.flags.dev_mode or sys.warnoptions):
        sys.stderr.flush()
        os._exit(code)


def _explained(error: OSError) -> OutputError:
    _give_up(sys.stdout)
    if error.errno in (errno.EPIPE, errno.EINVAL):  # EINVAL: Windows
        return OutputError(
            "the output is no longer read: the program that it was piped into has ended (head does that)"
        )
    return OutputError(f"cannot write the output: {error.strerror or error}")


def _give_up(stream: TextIO) -> None:
    """What could not be written is still in the buffer: let Python's own end not stumble over it."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    except OSError:
        return
