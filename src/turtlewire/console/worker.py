"""``python -m turtlewire.console.worker``: the process in which a program of the console runs, or is previewed.

Whatever the program does, the server goes on hearing a stop: it is another process, with bounds on what it takes of the
machine, and its robot is a ``FarTurtle``. It ends when nobody is at the other end of its pipe any more.
"""

from __future__ import annotations

import contextlib
import os
import queue
import random
import resource
import signal
import sys
import threading
import time
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NoReturn

from turtlewire.console import pipe
from turtlewire.console.confined import ConfinedStreams
from turtlewire.console.far_turtle import FarTurtle
from turtlewire.console.standing import FrontEnd
from turtlewire.errors import StoppedError, TurtlewireError
from turtlewire.logo import Interpreter
from turtlewire.logo.keyboard import Keyboard
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from collections.abc import Mapping


# What a program may take of the machine: bytes of memory, bytes in one file, files open at a time.
MEMORY, FILE_SIZE, OPEN_FILES = 1 << 30, 10_000_000, 64
# Less urgent than the server and whatever drives a robot.
NICENESS = 5
# How often what the program writes is handed on, and where it is told, seconds; and how many characters at a time.
TICK_S = 0.05
PIECE = 16_000
# A line typed; and how many of them wait to be read.
LONGEST_LINE, MOST_LINES = 10_000, 1_000


def main() -> NoReturn:
    """Do the job that the server says."""
    incoming, outgoing = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, 0)
    os.dup2(nowhere, 1)
    job = pipe.receive(incoming)
    if job is not None:
        _restrict(job)
        if "preview" in job:
            from turtlewire.console.previewing import preview_here

            pipe.send(outgoing, {"previewed": preview_here(job["preview"])})
        else:
            Work(job["run"], incoming, outgoing).do()
    os._exit(0)  # and not by way of what a program has left behind


def _restrict(job: Mapping[str, Any]) -> None:
    """What a program may take of the machine."""
    with contextlib.suppress(OSError):
        os.nice(NICENESS)
    for which, most in (
        (resource.RLIMIT_AS, MEMORY),
        (resource.RLIMIT_FSIZE, FILE_SIZE),
        (resource.RLIMIT_NOFILE, OPEN_FILES),
        (resource.RLIMIT_CORE, 0),
    ):
        hard = resource.getrlimit(which)[1]
        bound = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(which, (bound, bound))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # a full file is an error, like any other
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.chdir("/")
    folder = job.get("folder")
    if folder is not None:
        with contextlib.suppress(OSError):  # then its files cannot be opened
            Path(folder).mkdir(parents=True, exist_ok=True)
            os.chdir(folder)


class Interrupted(KeyboardInterrupt):
    """Somebody has stopped the program."""


class Work:
    """One run of a program.

    Args:
        job: what to run, as ``runs`` says it.
        incoming, outgoing: the pipe.
    """

    def __init__(self, job: Mapping[str, Any], incoming: IO[bytes], outgoing: IO[bytes]) -> None:
        self._job = job
        self._incoming, self._outgoing = incoming, outgoing
        self._sending = threading.Lock()
        self._replies: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._calls = 0
        self._stop_lock = threading.Lock()
        self._is_calling = False  # the main thread waits for a reply
        self._is_stopped = False
        self._knows_it = False  # that it was stopped: what it calls now are its last words
        self._written: list[str] = []
        self._length = 0
        self._room = threading.Condition()
        self._told_at: list[Any] | None = None
        self.turtle = FarTurtle(self._call)
        self.turtle.stands(Pose(*job["pose"]), pen_down=job["pen"])
        self.logo = Interpreter(self.turtle, self.write, random.Random(), job["step_mm"])
        folder = job["folder"]
        self.logo.streams = ConfinedStreams(self.logo, Path(folder) if folder is not None else None)
        self.keyboard = self.logo.streams.keyboard = FarKeyboard(self)
        self.front_end = FrontEnd(self.logo, self._say_in_turn, job["name"], is_paused=job["paused"])
        self.front_end.set_breakpoints(job["breakpoints"])

    # ------------------------------------------------------------------ the whole of it

    def do(self) -> None:
        """Run the program, and tell how it ended."""
        signal.signal(signal.SIGINT, self._interrupt)
        threading.Thread(target=self._listen, daemon=True).start()
        threading.Thread(target=self._tick, daemon=True).start()
        self.say({"began": True})
        ended = self._run()
        self.flush()
        with contextlib.suppress(OSError, ValueError):
            self.say({"ended": ended})

    def _run(self) -> dict[str, Any]:
        """How the program ended."""
        job = self._job
        try:
            self.logo.run(job["source"], job["name"])
            self.turtle.finish()
        except (Interrupted, StoppedError):
            return {"how": "stopped"}
        except TurtlewireError as error:
            return {"how": "failed", "error": pipe.failure(error, self.logo.position)}
        return {"how": "ended"}

    # ------------------------------------------------------------------ to the server

    def say(self, message: Mapping[str, Any]) -> None:
        """Send a message, whichever thread it is."""
        with self._sending:
            pipe.send(self._outgoing, message)

    def write(self, text: str) -> None:
        """What the program prints. A program that prints on and on waits until it is handed on."""
        with self._room:
            self._written.append(text)
            self._length += len(text)
            while self._length > PIECE:
                self._room.wait()

    def flush(self) -> None:
        """Hand on what was written."""
        with self._room:
            text, self._written, self._length = "".join(self._written), [], 0
            self._room.notify_all()
        for start in range(0, len(text), PIECE):
            self.say({"wrote": text[start : start + PIECE]})

    def _tick(self) -> None:
        while True:
            time.sleep(TICK_S)
            with contextlib.suppress(OSError, ValueError, MemoryError):
                self.flush()
                self._tell_place()

    def _tell_place(self) -> None:
        at = self.front_end.at()
        if at is not None and at != self._told_at:
            self._told_at = at
            self.say({"at": at})

    def _say_in_turn(self, message: Mapping[str, Any]) -> None:
        self.flush()
        self.say(message)

    def _call(self, name: str, inputs: tuple[Any, ...]) -> Mapping[str, Any]:
        """Have the server's turtle do something; raises what that raised."""
        if self._is_stopped and not self._knows_it:
            self._be_stopped()
        if not self._knows_it:
            self.front_end.before_motion()
        self.flush()
        self._calls += 1
        with self._stop_lock:
            self._is_calling = True
        try:
            self.say({"call": name, "inputs": inputs, "number": self._calls, "at": self.front_end.at()})
            while True:
                reply = self._replies.get()
                if reply.get("stopped") and not self._knows_it:
                    self._be_stopped()
                if reply.get("number") == self._calls:
                    break
        finally:
            with self._stop_lock:
                self._is_calling = False
        if self._is_stopped and not self._knows_it:
            self._be_stopped()  # the stop came a moment after the reply
        if "error" in reply:
            error = pipe.error_of(reply["error"])
            if isinstance(error, StoppedError):
                self._knows_it = True
            raise error
        return reply

    def _be_stopped(self) -> NoReturn:
        self._knows_it = True
        raise StoppedError("the program was stopped")

    # ------------------------------------------------------------------ from the server

    def _listen(self) -> None:
        while (message := pipe.receive(self._incoming)) is not None:
            if "reply" in message:
                self._replies.put(message["reply"])
            elif "typed" in message:
                self.keyboard.type(message["typed"])
            elif "stop" in message:
                self._stop()
            else:
                self.front_end.told(message)
        os._exit(1)  # the server is gone, and with it the robot

    def _stop(self) -> None:
        """End the program: by the call that it waits for, or wherever it is."""
        with self._stop_lock:
            self._is_stopped = True
            if self._is_calling:
                self._replies.put({"stopped": True})
                return
        ident = threading.main_thread().ident
        assert ident is not None
        signal.pthread_kill(ident, signal.SIGINT)  # so that it wakes from whatever it waits for

    def _interrupt(self, *_: object) -> None:
        if self._is_stopped and not self._knows_it:
            self._knows_it = True
            raise Interrupted


class FarKeyboard(Keyboard):
    """Somebody who types in a page.

    Args:
        work: whose program reads.
    """

    def __init__(self, work: Work) -> None:
        super().__init__(self._wait_for_line)
        self._work = work
        self._lines: queue.Queue[str | None] = queue.Queue(MOST_LINES)
        self._is_over = False

    def type(self, text: str | None) -> None:
        """A line that was typed; ``None``: nobody types any more. One that nobody reads for long is dropped."""
        with contextlib.suppress(queue.Full):
            self._lines.put_nowait(text[:LONGEST_LINE] if text is not None else None)

    def has_key(self) -> bool:
        """Whether something was typed."""
        return super().has_key() or not self._lines.empty()

    def _wait_for_line(self) -> str:
        if self._is_over:
            return ""
        self._work.flush()
        if self._lines.empty():
            self._work.say({"asks": True})
        line = self._lines.get()
        self._is_over = line is None
        self._work.say({"read": line})
        return "" if line is None else f"{line}\n"


if __name__ == "__main__":
    if sys.flags.safe_path:  # or else a file of a program's could be taken for one of Python's
        main()
    raise SystemExit("this is started by the console, with python -P")
