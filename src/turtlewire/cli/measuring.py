"""A person at a terminal measures a robot: what is told, what is asked, and a key that stops it at once."""

from __future__ import annotations

import contextlib
import os
import select
import sys
import threading
from typing import TYPE_CHECKING, Any

from turtlewire.cli import output
from turtlewire.cli.signals import Interrupted
from turtlewire.errors import (
    DataError,
    LimitReachedError,
    LinkLostError,
    PoseUncertainError,
    StoppedError,
    TurtlewireError,
)
from turtlewire.robots.calibrating import Choice, ImplausibleError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from turtlewire.connect import Robot
    from turtlewire.robots.calibrating import Answer, Question, Signal, Trial

HELP = """\
Before each drive you are told what the robot will do and how much space it needs. While it moves, {keys}.
Then you are asked what it did: type a number (mm and degrees; 12.5 cm will do, too), or
  Enter  to keep the present value     r  to repeat the drive     b  to go back     q  to stop here
"""
KEYS = "any key stops it, and so does Ctrl-C"
NO_KEYS = "Ctrl-C stops it, and ends this"
GO = "  Enter: go   s: skip   b: back   q: stop here > "
CHOICES = {"s": Choice.SKIP, "b": Choice.BACK, "q": Choice.QUIT}
ANSWERS = {"r": Choice.REPEAT, "b": Choice.BACK, "q": Choice.QUIT}
# How long to wait for a robot whose link was lost.
RECONNECT_S = 60.0


class TerminalPerson:
    """Whoever sits there.

    Args:
        robot: what is measured; it is stopped by any key.
        steps: what each step measures.
        in_background: whether it moves while this program does something else: not in virtual time.
    """

    def __init__(self, robot: Robot, steps: Mapping[str, str], *, in_background: bool) -> None:
        self._robot = robot
        self._steps = steps
        self._is_watched = in_background and _can_watch()
        self._step = ""
        output.tell(HELP.format(keys=KEYS if self._is_watched else NO_KEYS))

    def begin(self, trial: Trial) -> Choice | None:
        """Tell what the robot will do, and wait for the word."""
        if trial.step != self._step:
            self._step = trial.step
            number = list(self._steps).index(trial.step) + 1
            output.tell(f"\n{number}. {trial.step}: {self._steps[trial.step]}")
        output.tell(f"\n  {trial.does}{' ' if trial.needs else ''}{trial.needs}")
        if trial.act is None and trial.questions:
            return None
        while (text := _line(GO)) not in CHOICES:
            if not text:
                return None
            output.tell("  press Enter alone, or one of s, b and q before it")
        return CHOICES[text]

    def answer(self, question: Question) -> Answer | Choice:
        """Ask until it makes sense; a number that is not plausible counts when it is given again."""
        unlikely: float | None = None
        while True:
            text = _line(f"  {question.text} [{question.hint}] > ")
            if not text:
                return None
            if text in ANSWERS and text not in question.choices:
                return ANSWERS[text]
            try:
                return question.read(text)
            except ImplausibleError as error:
                if error.value is not None and error.value == unlikely:
                    return unlikely
                unlikely = error.value
                again = (
                    ""
                    if unlikely is None
                    else ". Measure again; give it once more if it is so, or r to repeat"
                )
                output.tell(f"  {error}{again}")

    # ------------------------------------------------------------------ while the robot moves

    def perform(self, act: Callable[[Signal], object]) -> object:
        """Let the robot do it, and stop it as soon as somebody presses a key."""
        try:
            return self._watched(act) if self._is_watched else act(_ring)
        except LinkLostError as error:
            return self._reach_again(error)
        except (PoseUncertainError, LimitReachedError) as error:
            output.tell(f"  this does not count: {error}")
            return Choice.REPEAT

    def _watched(self, act: Callable[[Signal], object]) -> object:
        work = _Work(act)
        with _keys():
            output.tell("  it moves: any key stops it")
            work.start()
            try:
                is_stopped = work.is_interrupted_by(sys.stdin.fileno())
            finally:
                # However this ends, the robot does not go on.
                if not work.is_over:
                    with contextlib.suppress(TurtlewireError):
                        self._robot.stop()
                work.join()
        if is_stopped:
            output.tell("  stopped: this does not count")
            return Choice.REPEAT
        return work.result()

    def _reach_again(self, error: LinkLostError) -> Choice:
        """What was measured so far is not lost with the link."""
        output.tell(f"  {error}")
        if (
            not sys.stdin.isatty()
            or _line("  Enter: go on when it is plugged in again   q: give up > ") == "q"
        ):
            raise error
        self._robot.reconnected(RECONNECT_S)
        self._robot.resume()
        return Choice.REPEAT


class _Work:
    """What a robot does, in a thread of its own; somebody else watches the keys meanwhile."""

    def __init__(self, act: Callable[[Signal], object]) -> None:
        self._act = act
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._end, self._ended = os.pipe()
        self._result: object = None
        self._error: BaseException | None = None

    @property
    def is_over(self) -> bool:
        return not self._thread.is_alive()

    def start(self) -> None:
        self._thread.start()

    def _run(self) -> None:
        try:
            self._result = self._act(_ring)
        except BaseException as error:  # noqa: BLE001 - ``result`` raises it, where somebody can see to it
            self._error = error
        finally:
            os.write(self._ended, b"x")

    def is_interrupted_by(self, keys: int) -> bool:
        """Wait until it is over; True: a key was pressed before. Raises ``Interrupted`` if the terminal is gone."""
        ready, _, _ = select.select([keys, self._end], [], [])
        if self._end in ready:
            return False
        if not os.read(keys, 64):
            raise Interrupted("the terminal is gone")
        return True

    def join(self) -> None:
        self._thread.join()
        os.close(self._end)
        os.close(self._ended)

    def result(self) -> object:
        if isinstance(self._error, StoppedError):
            return Choice.REPEAT
        if self._error is not None:
            raise self._error
        return self._result


def _can_watch() -> bool:
    """Whether keys can be seen as they are pressed."""
    try:
        import termios  # noqa: F401 - Windows has none
    except ImportError:
        return False
    return sys.stdin.isatty()


@contextlib.contextmanager
def _keys() -> Iterator[None]:
    """Keys are seen as they are pressed, not shown, and what was typed before or too late counts for nothing."""
    import termios
    import tty

    fd = sys.stdin.fileno()
    before: list[Any] = termios.tcgetattr(fd)
    try:
        tty.setcbreak(fd)
        termios.tcflush(fd, termios.TCIFLUSH)
        yield
    finally:
        with contextlib.suppress(termios.error):  # the terminal is gone
            termios.tcsetattr(fd, termios.TCSAFLUSH, before)


def _ring() -> None:
    """The moment has come."""
    output.tell("\a  NOW!")


def _line(prompt: str) -> str:
    """What somebody types. Raises ``DataError`` when nobody does any more."""
    print(prompt, end="", file=sys.stderr, flush=True)
    text = sys.stdin.readline() if sys.stdin else ""
    if not text:
        raise DataError("nobody answers any more: the input has ended before the calibration was done")
    return text.strip().lower()
