"""Programs that run on a robot: each in a process of its own, whose turtle is this robot, lent by the helm.

A thread for each run hands on what the process says; whoever else asks for something never waits. Whatever becomes of
the process, the robot stands when the run is over.
"""

from __future__ import annotations

import contextlib
import threading
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from turtlewire.console import pipe
from turtlewire.console.far_turtle import LAST_WORDS, checked
from turtlewire.console.said import Output, cleaned, sayable
from turtlewire.console.workers import Worker
from turtlewire.errors import StoppedError, TurtlewireError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from turtlewire.connect import AsyncRobot
    from turtlewire.helm.lease import Lease

# How long the last words of a program (ONSTOP) may take, seconds; then its process is ended.
LAST_WORDS_S = 3.0
FINAL = frozenset(("ended", "failed", "stopped"))


class Program(NamedTuple):
    """What is to be run.

    Attributes:
        source: its text.
        name: its file name, for messages.
        is_paused: whether it stands before its first line.
        breakpoints: numbers of lines before which it stops, from 1.
    """

    source: str
    name: str
    is_paused: bool = False
    breakpoints: tuple[int, ...] = ()


class Lender(Protocol):
    """Who has the robot."""

    def borrow(self) -> Lease:
        """The robot. Raises ``TurtlewireError`` when it is not reached."""

    def halt(self) -> None:
        """Stop the robot at once, ahead of everything, and end what is done with it; never waits."""


class Run:
    """One run of a program. It begins at once, in a thread of its own; its methods may be called from any thread.

    Args:
        program: what is run.
        number: of this run, for those who watch.
        lender: who has the robot.
        folder: where the program's files are; ``None``: it has none.

    Attributes:
        program: what is run.
        state: what is to be seen of it, made anew with every change, ready for JSON.
    """

    def __init__(self, program: Program, number: int, lender: Lender, folder: Path | None) -> None:
        self.program = program
        self._number = number
        self._lender = lender
        self._folder = folder
        self._lock = threading.RLock()
        self._sending = threading.Lock()
        self._output = Output()
        self._phase = "starting"
        self._at: Sequence[Any] = (None, None, "", 0)
        self._is_pausing = self._is_asking = self._is_stopping = False
        self._paused: dict[str, Any] | None = None
        self._error: dict[str, Any] | None = None
        self._breakpoints = program.breakpoints
        self._worker: Worker | None = None
        self._lease: Lease | None = None
        self._speaks_last = False
        self.state: dict[str, Any] = {}
        self._changed()
        self._thread = threading.Thread(target=self._run, name=f"turtlewire program {number}", daemon=True)
        self._thread.start()

    # ------------------------------------------------------------------ from whoever asks

    @property
    def is_over(self) -> bool:
        """Whether it has ended, and the robot stands."""
        return self._phase in FINAL

    @property
    def is_stopping(self) -> bool:
        """Whether it was stopped, and says its last words: the robot stands."""
        return self._is_stopping

    def output(self, since: int) -> tuple[int, str]:
        """What the program has written from a character on, and where that begins."""
        with self._lock:
            return self._output.since(since)

    def pause(self) -> None:
        """Have it stop before its next line or motion."""
        with self._lock:
            if self._paused is None:
                self._is_pausing = True
                self._changed()
        self._tell({"pause": True})

    def go(self, how: str) -> None:
        """Let it go on from where it stands: ``"into"``, ``"over"``, ``"out"`` or ``"on"``."""
        with self._lock:
            self._is_pausing = False
            self._changed()
        self._tell({"go": how})

    def type(self, text: str | None) -> None:
        """Somebody types a line; ``None``: nobody types any more."""
        self._tell({"typed": text})

    def do(self, text: str) -> None:
        """Run instructions where the program stands."""
        self._tell({"do": text})

    def set_breakpoints(self, lines: tuple[int, ...]) -> None:
        """Stop before these lines, counted from 1, and no others."""
        with self._lock:
            self._breakpoints = lines
            self._changed()
        self._tell({"breakpoints": lines})

    def stop(self) -> None:
        """End it: the robot was stopped. Its last words it may say, if it has any; it does not take long."""
        with self._lock:
            if self._is_stopping or self.is_over:
                return
            self._is_stopping = True
            self._paused = None
            self._changed()
        timer = threading.Timer(LAST_WORDS_S, self._kill)
        timer.daemon = True
        timer.start()
        self._tell({"stop": True})

    def close(self) -> None:
        """End it, whatever it is doing, and wait until it has."""
        with self._lock:
            if not self.is_over:
                self._is_stopping = True
                self._lender.halt()
        self._kill()
        self._thread.join()

    def _tell(self, message: dict[str, Any]) -> None:
        """Something for the process; not yet, or no longer there, it needs to know nothing."""
        worker = self._worker
        if worker is not None:
            with self._sending, contextlib.suppress(OSError, ValueError):
                pipe.send(worker.stdin, message)

    def _kill(self) -> None:
        worker = self._worker
        if worker is not None:
            worker.kill()

    # ------------------------------------------------------------------ in its thread

    def _run(self) -> None:
        how = "failed"
        try:
            how = self._whole()
        except TurtlewireError as error:
            if isinstance(error, StoppedError):
                how = "stopped"
            else:
                self._error = pipe.told(error)
        except OSError as error:  # no process could be started
            self._error = {"kind": "process", "text": f"no process for the program: {error.strerror}"}
        finally:
            if self._worker is not None:
                self._worker.end()
            if how != "ended":
                self._lender.halt()  # whatever has ended it, the robot stands
            self._leave()
            with self._lock:
                self._phase = "stopped" if self._is_stopping else how
                self._paused, self._is_asking, self._is_pausing = None, False, False
                self._changed()

    def _whole(self) -> str:
        """The run from its beginning to its end; how it ended."""
        self._lease = self._lender.borrow()
        pose, pen = self._lease.call(_begin).result()
        worker = Worker()
        program, folder = self.program, self._folder
        job = {
            "source": program.source, "name": program.name, "paused": program.is_paused,
            "breakpoints": self._breakpoints, "folder": str(folder) if folder is not None else None,
            "pose": pose, "pen": pen, "step_mm": 1.0,
        }  # fmt: skip
        with self._sending, contextlib.suppress(OSError):
            pipe.send(worker.stdin, {"run": job, "folder": job["folder"]})
        with self._lock:
            self._worker = worker
            if self._is_stopping:
                raise StoppedError("it was stopped before it had begun")
        threading.Thread(target=self._watch, args=(worker,), daemon=True).start()
        while (message := pipe.receive(worker.stdout)) is not None:
            if "ended" in message:
                return self._ended(message["ended"])
            if "call" in message:
                self._reply(message)
            else:
                self._heard(message)
        self._error = {"kind": "process", "text": "the program's process has ended by itself"}
        return "failed"

    def _watch(self, worker: Worker) -> None:
        """A process that is gone needs no robot that goes on with its last motion."""
        if worker.wait() != 0 and not self.is_over:
            self._lender.halt()

    def _ended(self, ended: dict[str, Any]) -> str:
        error = ended.get("error")
        self._error = cleaned(error) if isinstance(error, dict) else None
        return (
            "ended"
            if ended.get("how") == "ended"
            else "stopped"
            if ended.get("how") == "stopped"
            else "failed"
        )

    def _heard(self, message: dict[str, Any]) -> None:
        """The process tells something."""
        with self._lock:
            if "wrote" in message:
                self._output.add(sayable(message["wrote"]))
            if "at" in message and isinstance(message["at"], list):
                self._at = (message["at"] + [None] * 4)[:4]
            if "asks" in message:
                self._is_asking = True
            if "read" in message:
                self._is_asking = False
                if isinstance(message["read"], str):
                    self._output.add(sayable(message["read"]) + "\n")
            if "paused" in message and not self._is_stopping:
                self._is_pausing = False
                self._paused = {"reason": message["paused"], "variables": cleaned(message["variables"])}
            if "goes_on" in message:
                self._paused = None
            if "began" in message:
                self._phase = "running"
            self._changed()

    # ------------------------------------------------------------------ the robot

    def _reply(self, message: dict[str, Any]) -> None:
        """The process calls a method of its turtle."""
        reply: dict[str, Any] = {"number": message.get("number")}
        at = message.get("at")
        if isinstance(at, list):
            self._heard({"at": at})
        try:
            pose, pen = self._call(*checked(message))
            reply |= {"pose": pose, "pen": pen}
        except TurtlewireError as error:
            reply["error"] = pipe.told(error)
        self._tell({"reply": reply})

    def _call(self, name: str, *inputs: Any) -> tuple[Sequence[float], bool]:
        """Have the robot do something, and wait; where it is then, and whether its pen is down."""
        if self._is_stopping and name in LAST_WORDS and not self._speaks_last:
            self._speaks_last = True
            self._give_back()
            self._lease = self._lender.borrow()
        lease = self._lease
        assert lease is not None
        if self._is_stopping and name not in LAST_WORDS:
            raise StoppedError("the program was stopped")

        async def work(robot: AsyncRobot) -> tuple[Sequence[float], bool]:
            await getattr(robot, name)(*inputs)
            return robot.pose, robot.is_pen_down

        return lease.call(work).result()

    def _give_back(self) -> None:
        with self._lock:
            lease, self._lease = self._lease, None
        if lease is not None:
            lease.close()

    def _leave(self) -> None:
        """The robot is as it was before, for whoever drives it next."""
        self._give_back()
        with contextlib.suppress(TurtlewireError):
            lease = self._lender.borrow()
            try:
                lease.call(lambda robot: robot.set_step_by_step(on=False)).result()
            finally:
                lease.close()

    # ------------------------------------------------------------------ what is to be seen

    def _changed(self) -> None:
        file, line, procedure, depth = self._at
        self.state = {
            "number": self._number,
            "name": self.program.name,
            "phase": self._seen_phase(),
            "file": file,
            "line": line,
            "procedure": procedure,
            "depth": depth,
            "paused": self._paused,
            "breakpoints": self._breakpoints,
            "written": self._output.written,
            "error": self._error,
        }

    def _seen_phase(self) -> str:
        if self._phase in FINAL:
            return self._phase
        if self._is_stopping:
            return "stopping"
        if self._paused is not None:
            return "paused"
        if self._is_asking:
            return "asking"
        return "pausing" if self._is_pausing else self._phase


async def _begin(robot: AsyncRobot) -> tuple[Sequence[float], bool]:
    """A program begins."""
    await robot.set_step_by_step(on=True)
    return robot.pose, robot.is_pen_down


class Runs:
    """The programs of one robot, one after the other.

    Args:
        lender: who has the robot.
        folder: where the programs' files are.

    Attributes:
        run: the last one, ``None`` before the first.
    """

    def __init__(self, lender: Lender, folder: Path | None) -> None:
        self._lender = lender
        self._folder = folder
        self._number = 0
        self.run: Run | None = None

    @property
    def is_running(self) -> bool:
        """Whether a program has the robot; not while it only says its last words."""
        run = self.run
        return run is not None and not (run.is_over or run.is_stopping)

    def state(self) -> dict[str, Any] | None:
        """What is to be seen of the last program; ``None`` before the first."""
        return self.run.state if self.run is not None else None

    def start(self, program: Program) -> Run:
        """Run a program, in the place of the one that ran before; what is left of that ends at once."""
        if self.run is not None:
            self.run.close()
        self._number += 1
        self.run = Run(program, self._number, self._lender, self._folder)
        return self.run

    def stop(self) -> None:
        """The robot was stopped: end the program. Never waits."""
        if self.run is not None:
            self.run.stop()

    def close(self) -> None:
        """End the program, and wait until it has."""
        if self.run is not None:
            self.run.close()
