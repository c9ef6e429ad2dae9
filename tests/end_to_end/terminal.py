"""A terminal for programs under test: a real pty, and what a real terminal would show of what they write."""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import sys
import termios
import threading
from typing import TYPE_CHECKING

import pyte

from .conftest import COMMAND, DEADLINE_S, wait_until

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

# How often a key repeats that is held.
REPEAT_S = 0.03
# Makes the terminal at its standard input its controlling one, as a shell does, and becomes the program.
LOGIN = (
    "import fcntl, os, sys, termios; os.setsid(); fcntl.ioctl(0, termios.TIOCSCTTY, 0); "
    "os.execv(sys.argv[1], sys.argv[1:])"
)
NOHUP = "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN); "
# What pyte does not know, and would print: questions and modes of the kitty keyboard protocol.
UNKNOWN = re.compile(rb"\x1b\[[=<>?][\d;]*u|\x1b\[\?\d+\$p")
QUESTION = b"\x1b[?u"
UNFINISHED = re.compile(rb"\x1b(\[[\d;=<>?]*\$?)?\Z")


class Terminal:
    """A terminal of a certain size, and what was sent to it.

    With ``tells_releases`` it knows the kitty keyboard protocol: it says so, and answers as long as it takes anything.
    """

    def __init__(self, columns: int, rows: int = 24, *, tells_releases: bool = False) -> None:
        self._near, self.far = pty.openpty()
        self._screen = pyte.HistoryScreen(columns, rows, history=10_000)
        self._stream = pyte.ByteStream(self._screen)
        self._received = bytearray()
        self._lock = threading.Lock()
        self._takes = threading.Event()
        self._takes.set()
        self._answer = b"\x1b[?27u" if tells_releases else b""
        self._woken, self._wake = os.pipe()
        self.resize(columns, rows)
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def resize(self, columns: int, rows: int) -> None:
        """Somebody pulls at its corner."""
        with self._lock:
            self._screen.resize(rows, columns)
        fcntl.ioctl(self._near, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def _read(self) -> None:
        data = b""
        while True:
            ready, _, _ = select.select([self._near, self._woken], [], [])
            if self._woken in ready:
                return
            try:
                piece = os.read(self._near, 4096)
            except OSError:  # EIO: nobody has the terminal any more
                return
            data += piece
            unfinished = UNFINISHED.search(data)
            end = unfinished.start() if unfinished else len(data)
            with self._lock:
                self._received += piece
                self._stream.feed(UNKNOWN.sub(b"", data[:end]))
            if self._answer and QUESTION in data[:end]:
                os.write(self._near, self._answer)
            data = data[end:]
            self._takes.wait()

    @property
    def text(self) -> str:
        """All that was written to it."""
        return self._received.decode("utf-8", "replace")

    def lines(self) -> list[str]:
        """What stays on the screen, and what has scrolled off it, as a real terminal shows it."""
        with self._lock:
            width = self._screen.columns
            gone = ["".join(row[x].data for x in range(width)) for row in self._screen.history.top]
            return [line.rstrip() for line in (*gone, *self._screen.display)]

    @property
    def shown(self) -> str:
        """What stands on the screen now."""
        with self._lock:
            return "\n".join(self._screen.display)

    def wait_for(self, text: str) -> None:
        """Until this stands on the screen."""
        try:
            wait_until(lambda: text in self.shown, text)
        except AssertionError:
            raise AssertionError(f"waited in vain for {text!r}; the screen is\n{self.shown}") from None

    def wait_for_match(self, pattern: str) -> re.Match[str]:
        """Until something like this stands on the screen."""
        found: list[re.Match[str]] = []

        def is_there() -> bool:
            match = re.search(pattern, self.shown)
            found.extend([match] if match else [])
            return bool(found)

        wait_until(is_there, f"{pattern!r} on\n{self.shown}")
        return found[0]

    # ------------------------------------------------------------------ who sits there

    def press(self, keys: str) -> None:
        """Press keys, one after the other."""
        os.write(self._near, keys.encode())

    @contextlib.contextmanager
    def holding(self, key: str) -> Iterator[list[str]]:
        """Hold a key: it is sent, and again and again until this is left. Gives what was sent so far."""
        released = threading.Event()
        sent = [key]

        def repeat() -> None:
            while not released.wait(REPEAT_S):
                with contextlib.suppress(OSError):  # the window was closed meanwhile
                    self.press(key)
                    sent.append(key)

        self.press(key)
        thread = threading.Thread(target=repeat, daemon=True)
        thread.start()
        try:
            yield sent
        finally:
            released.set()
            thread.join(DEADLINE_S)

    def stall(self) -> None:
        """It takes no more of what it is shown, as behind a connection that hangs."""
        self._takes.clear()

    def go_on(self) -> None:
        """It does again."""
        self._takes.set()

    def run(
        self,
        arguments: list[str],
        folder: Path,
        environment: Mapping[str, str] | None = None,
        *,
        nohup: bool = False,
    ) -> subprocess.Popen[bytes]:
        """Run turtlewire on it, as a shell does: the terminal is its controlling one. With ``nohup``, as that does."""
        return subprocess.Popen(
            [sys.executable, "-c", (NOHUP if nohup else "") + LOGIN, *COMMAND, *arguments],
            cwd=folder,
            env=clean_environment() | dict(environment or {}),
            stdin=self.far,
            stdout=self.far,
            stderr=self.far,
        )

    # ------------------------------------------------------------------ its end

    def hang_up(self) -> None:
        """Its window is closed: whoever still has it loses it."""
        self._takes.set()
        os.write(self._wake, b".")
        self._thread.join(DEADLINE_S)
        for descriptor in (self.far, self._near):
            os.close(descriptor)
        self.far = self._near = -1

    def close(self) -> None:
        """It was needed until now."""
        if self._near >= 0:
            self.hang_up()
        os.close(self._woken)
        os.close(self._wake)


def clean_environment() -> dict[str, str]:
    """An ordinary terminal, whatever the tests run in."""
    environment = {**os.environ, "TERM": "xterm-256color", "PYTHONUNBUFFERED": ""}
    for name in ("COLUMNS", "LINES", "NO_COLOR", "FORCE_COLOR", "TERM_PROGRAM", "COLORTERM"):
        environment.pop(name, None)
    return environment
