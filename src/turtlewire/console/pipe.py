"""What passes between the server and the process in which a program runs: JSON, one object a line, both ways.

The server says ``run`` or ``preview`` (the job, once, as the first line), and then ``reply`` (what became of a call),
``typed`` (a line from somebody's keyboard, null: nobody types any more), ``pause``, ``go`` (on: how), ``do``
(instructions, where it stands), ``breakpoints`` and ``stop``.
The process says ``began``, ``call`` (do this with the turtle), ``wrote``, ``at`` (where it is), ``asks`` (for a line),
``read`` (it has one), ``paused``, ``goes_on`` and ``ended``; ``previewed`` of a preview. It is not trusted: a program
may come from anybody.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from turtlewire import errors
from turtlewire.errors import LimitReachedError, RobotError, TurtlewireError
from turtlewire.logo import LogoError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import IO

    from turtlewire.logo import Position

# A line that is longer does not come from our worker.
LONGEST = 4_000_000
_KINDS: Mapping[str, type[TurtlewireError]] = {
    name: kind
    for name, kind in vars(errors).items()
    if isinstance(kind, type) and issubclass(kind, TurtlewireError) and kind is not LimitReachedError
}


def send(file: IO[bytes], message: Mapping[str, Any]) -> None:
    """Write a message. Raises ``OSError`` when nobody is at the other end, ``ValueError`` for a closed file."""
    file.write(json.dumps(message).encode("ascii") + b"\n")
    file.flush()


def receive(file: IO[bytes]) -> dict[str, Any] | None:
    """Wait for the next message; ``None`` at the end, or when it is none."""
    try:
        line = file.readline(LONGEST)
        message = json.loads(line) if line.endswith(b"\n") else None
    except (OSError, ValueError, RecursionError):
        return None
    return message if isinstance(message, dict) else None


def told(error: TurtlewireError) -> dict[str, Any]:
    """An error, for the other end."""
    message: dict[str, Any] = {"kind": type(error).__name__, "text": str(error)}
    if isinstance(error, LimitReachedError):
        message |= {
            "sensor": error.sensor, "x_mm": error.x_mm, "y_mm": error.y_mm, "heading_deg": error.heading_deg,
        }  # fmt: skip
    return message


def error_of(message: Mapping[str, Any]) -> TurtlewireError:
    """The error that the other end told of."""
    if message["kind"] == LimitReachedError.__name__:
        return LimitReachedError(message["sensor"], message["x_mm"], message["y_mm"], message["heading_deg"])
    return _KINDS.get(message["kind"], RobotError)(message["text"])


def failure(error: TurtlewireError, position: Position | None) -> dict[str, Any]:
    """What ended a program: what, and where. ``position`` is where the program was, if the error does not say."""
    if isinstance(error, LogoError):
        own = {
            "number": error.number,
            "text": error.text,
            "hint": error.advice(),
            "procedure": error.procedure,
        }
        return {"kind": "logo", **own, **place(error.position or position)}
    return {**told(error), **place(position)}


def place(position: Position | None) -> dict[str, Any]:
    """A place in a program, or none."""
    if position is None:
        return {"file": None, "line": None, "column": None}
    return {"file": position.file, "line": position.line, "column": position.column}
