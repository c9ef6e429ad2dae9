"""What a program would do, found out in a process of its own: it may go on for ever, or take all memory there is."""

from __future__ import annotations

import base64
import contextlib
import pickle
import signal
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any

from turtlewire.console import pipe
from turtlewire.console.refusals import Refused
from turtlewire.console.workers import Worker
from turtlewire.errors import DataError, TurtlewireError
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from types import FrameType

    from turtlewire.configuration import Target
    from turtlewire.preview import Preview
    from turtlewire.trace import Stroke

# A program that takes longer than this to look at, seconds, is not looked at to its end.
LONGEST_S = 6.0
# And if that does not end it, nor anything else, its process is ended: seconds on the wall.
PATIENCE_S = 20.0
# What is shown of a drawing, points.
MOST_POINTS = 20_000
# So many previews at a time, whoever wants them; so many others wait, and what is more is refused.
_AT_A_TIME = threading.Semaphore(2)
_WAITING = threading.Semaphore(10)


def preview_there(
    target: Target, source: str, name: str, start: Pose, folder: Path | None, longest_s: float = LONGEST_S
) -> dict[str, Any]:
    """What a program would do, ready for JSON. Waits for it, ``PATIENCE_S`` at most when it is its turn.

    Args:
        target: the robot that it is meant for.
        source: the program.
        name: its file name.
        start: where the robot stands, as the turtle sees it.
        folder: where the program's files are; ``None``: it has none.
        longest_s: after so many seconds it is not looked at any further.

    Raises ``DataError`` when it cannot be found out, ``Refused`` when too many want to know.
    """
    if not _WAITING.acquire(blocking=False):
        raise Refused(429, "busy", "too many previews are asked for at a time: try again in a moment")
    try:
        with _AT_A_TIME:
            return _asked(target, source, name, start, folder, longest_s)
    finally:
        _WAITING.release()


def _asked(
    target: Target, source: str, name: str, start: Pose, folder: Path | None, longest_s: float
) -> dict[str, Any]:
    """What a process says."""
    job = {
        "target": base64.b64encode(pickle.dumps(target)).decode("ascii"),
        "source": source, "name": name, "start": start, "folder": str(folder) if folder is not None else None,
        "longest_s": longest_s,
    }  # fmt: skip
    worker = Worker()
    timer = threading.Timer(PATIENCE_S, worker.kill)
    timer.daemon = True
    timer.start()
    try:
        with contextlib.suppress(OSError):
            pipe.send(worker.stdin, {"preview": job, "folder": job["folder"]})
        message = pipe.receive(worker.stdout)
    finally:
        timer.cancel()
        worker.end()
    found = message.get("previewed") if message is not None else None
    if not isinstance(found, dict):
        raise DataError(
            "the program could not be looked at: it goes on without an end, or takes too much memory"
        )
    if "refused" in found:
        raise DataError(str(found["refused"]))
    return found


def preview_here(job: dict[str, Any]) -> dict[str, Any]:
    """What the program of a job would do: in the worker."""
    from turtlewire.console.confined import ConfinedStreams
    from turtlewire.preview import TooLongError, preview

    def enough(number: int, frame: FrameType | None) -> None:
        del number, frame
        raise TooLongError

    signal.signal(signal.SIGALRM, enough)
    signal.setitimer(signal.ITIMER_REAL, job["longest_s"], 2.0)  # again: once it may be lost
    folder = Path(job["folder"]) if job["folder"] is not None else None
    try:
        found = preview(
            pickle.loads(base64.b64decode(job["target"])),
            job["source"],
            job["name"],
            start=Pose(*job["start"]),
            files=lambda logo: ConfinedStreams(logo, folder),
        )
    except TurtlewireError as error:
        return {"refused": str(error)}
    except MemoryError:
        return {"refused": "the program needs more memory than it may have"}
    signal.setitimer(signal.ITIMER_REAL, 0)
    return _as_json(found)


def _as_json(found: Preview) -> dict[str, Any]:
    return {
        "drawing": found.drawing and found.drawing._asdict(),
        "way": found.way._asdict(),
        "path_mm": found.path_mm,
        "pen_down_mm": found.pen_down_mm,
        "seconds": found.seconds,
        "is_whole": found.is_whole,
        "stays_in_arena": found.touch is None if found.has_arena else None,
        "touch": found.touch and found.touch._asdict(),
        "asks": list(found.asks),
        "error": pipe.failure(found.error, found.position) if found.error is not None else None,
        "strokes": _drawn(list(found.strokes)),
    }


def _drawn(strokes: list[Stroke]) -> list[dict[str, Any]]:
    """The lines; of a very long drawing, not every corner."""
    total = sum(len(stroke.points) for stroke in strokes)
    step = max(1, -(-total // MOST_POINTS))
    shown = [
        {
            "pen": stroke.pen_down,
            "points": [
                (round(x, 2), round(y, 2))
                for index, (x, y) in enumerate(stroke.points)
                if index % step == 0 or index + 1 == len(stroke.points)
            ],
        }
        for stroke in strokes
    ]
    return shown[:MOST_POINTS]
