"""``turtlewire run --preview``: what a program would do, told before a robot moves."""

from __future__ import annotations

import argparse
import json
import sys
from typing import TYPE_CHECKING, Any

from turtlewire.cli import output
from turtlewire.cli.progress import duration
from turtlewire.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from turtlewire.configuration import Target
    from turtlewire.preview import Extent, Preview

ASK, ONLY = "ask", "only"


def add_options(parser: argparse.ArgumentParser) -> None:
    """``--preview``, ``--preview=only`` and ``--arena``."""
    parser.add_argument(
        "--preview",
        action="store_const",
        const=ASK,
        help="first say how large and long the drawing is and what it takes, then ask whether to run it; "
        "--preview=only asks nothing, and runs nothing",
    )
    # An option of its own: --preview with a value would take the program for it.
    parser.add_argument(
        f"--preview={ONLY}", dest="preview", action="store_const", const=ONLY, help=argparse.SUPPRESS
    )
    parser.add_argument(
        "--arena",
        metavar="FILE",
        help="with --preview: what stands around the robot, as the simulator has it",
    )


def check_options(arguments: argparse.Namespace) -> None:
    """Raises ``UsageError`` for options that mean nothing together."""
    if arguments.arena is not None and arguments.preview is None:
        raise UsageError("--arena is for --preview; a simulated robot's is in its URL: sim:walter?arena=FILE")
    if arguments.picture and (arguments.preview == ONLY or (arguments.preview and arguments.json)):
        raise UsageError(
            "--picture is for what a robot draws, and here none does: `turtlewire logo` draws without one"
        )
    if arguments.preview == ASK and not arguments.json:
        if arguments.program == "-":
            raise UsageError(
                "the program comes from the standard input, and so cannot the answer: --preview=only"
            )
        if not (sys.stdin.isatty() and sys.stderr.isatty()):
            raise UsageError("there is no terminal to ask whether to run it: --preview=only runs nothing")


def go_on(arguments: argparse.Namespace, targets: Mapping[str, Target], source: str, name: str) -> int | None:
    """Tell what the program would do. The exit code, or None to run it."""
    from turtlewire.preview import preview_all

    found = preview_all(
        targets, source, name, seed=arguments.seed, step_mm=arguments.step_mm, arena=arguments.arena
    )
    error = next(iter(found.values())).error  # each has the same
    code = error.exit_code if error is not None else 0
    if arguments.json:
        output.write(json.dumps(_all(found, targets, name, code)) + "\n")
        return code
    tell = output.write if arguments.preview == ONLY else output.tell
    lines = [line for each, one in found.items() for line in _lines(one, targets[each], name, each)]
    tell("\n".join(lines) + ("\n" if arguments.preview == ONLY else ""))
    if error is not None:
        output.tell(f"turtlewire: {error}")
    if arguments.preview == ONLY:
        return code
    sys.stderr.write("Run it? [y/N] ")
    sys.stderr.flush()
    if sys.stdin.readline().strip().lower() in ("y", "yes"):
        return None
    output.tell("not run")
    return 0


def _all(found: Mapping[str, Preview], targets: Mapping[str, Target], name: str, code: int) -> dict[str, Any]:
    """Everything: of one robot as it is, of several by their names."""
    first = next(iter(found.values()))
    told = {
        "outcome": "error" if first.error is not None else "previewed",
        "exit_code": code,
        "program": name,
        "is_whole": first.is_whole,
        "error": first.error
        and {
            "type": type(first.error).__name__,
            "message": str(first.error),
            "position": first.position
            and {"file": first.position.file, "line": first.position.line, "column": first.position.column},
        },
    }
    robots = {each: _as_json(one, targets[each]) for each, one in found.items()}
    return told | (robots.popitem()[1] if len(robots) == 1 else {"robots": robots})


def _as_json(found: Preview, target: Target) -> dict[str, Any]:
    return {
        "robot": target.name,
        "drawing": found.drawing and found.drawing._asdict(),
        "way": found.way._asdict(),
        "path_mm": found.path_mm,
        "pen_down_mm": found.pen_down_mm,
        "seconds": found.seconds,
        "stays_in_arena": found.touch is None if found.has_arena else None,
        "touch": found.touch and found.touch._asdict(),
        "is_estimate": bool(found.asks),
        "asks": list(found.asks),
    }


def _lines(found: Preview, target: Target, name: str, called: str) -> Iterator[str]:
    more = "" if found.is_whole else "more than "
    which = target.name if called in (target.name, target.protocol) else f"{called} ({target.name})"
    yield f"{name} on {which}:"
    yield f"  drawing    {_extent(found.drawing) if found.drawing else 'nothing'}"
    yield f"  way        {_extent(found.way)}"
    yield f"  path       {more}{found.path_mm / 1000:.2f} m, {found.pen_down_mm / 1000:.2f} m of it with the pen down"
    yield f"  takes      {more}{duration(found.seconds)} of the robot's time"
    yield f"  arena      {_arena(found)}"
    if found.asks:
        yield f"  estimate   the program {' and '.join(found.asks)}: it may be otherwise each time"
    if not found.is_whole:
        yield "  unfinished the program goes on for longer; it was not looked at to its end"
    if found.error is not None and found.position is not None:
        yield f"  ends       with an error, in line {found.position.line}"


def _extent(extent: Extent) -> str:
    left, right, bottom, top = (round(each) + 0 for each in extent)
    return f"{right - left} x {top - bottom} mm: x {left} to {right}, y {bottom} to {top}"


def _arena(found: Preview) -> str:
    if not found.has_arena:
        return "not known; --arena FILE names one"
    if found.touch is None:
        return "stays clear of everything"
    line = f", in line {found.touch.line}" if found.touch.line is not None else ""
    return f"meets something at x {found.touch.x_mm:.0f}, y {found.touch.y_mm:.0f}{line}"
