"""The processes in which programs run: how one is started, and that it ends."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys

# What a process needs to know of the machine.
ENVIRONMENT = ("PATH", "PYTHONPATH", "LANG", "LC_ALL", "LC_CTYPE", "SYSTEMROOT", "LD_LIBRARY_PATH")


class Worker:
    """A process that waits for a job: see ``pipe``. Raises ``OSError`` when there can be none.

    A mistake of ours in it is seen where the server's are: programs themselves cannot write there.

    Attributes:
        stdin, stdout: its ends of the pipe.
    """

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            # -P: no file of a program's is taken for one of Python's
            [sys.executable, "-P", "-m", "turtlewire.console.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={name: os.environ[name] for name in ENVIRONMENT if name in os.environ},
            start_new_session=True,  # Ctrl-C at the terminal is the server's
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self.stdin, self.stdout = self._process.stdin, self._process.stdout

    @property
    def pid(self) -> int:
        """The number of the process."""
        return self._process.pid

    def kill(self) -> None:
        """End it at once, whatever it is doing."""
        self._process.kill()

    def wait(self) -> int:
        """Wait until it has ended; 0: by itself, and in order."""
        return self._process.wait()

    def end(self) -> None:
        """End it, and let go of it."""
        self.kill()
        self.wait()
        for file in (self.stdin, self.stdout):
            with contextlib.suppress(OSError):
                file.close()
