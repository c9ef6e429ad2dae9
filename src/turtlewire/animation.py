"""When each line of a drawing is drawn: what makes a picture of it move, as CSS without any script.

The turtle goes its way at an even speed. Whoever has asked for less motion, and whatever knows no CSS animation, sees
the finished picture: everything that moves stands within the media query, and the picture below it is whole.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

    from turtlewire.trace import Stroke, Trace

# How fast the turtle is, mm/s, and how long a picture moves at most and at least, seconds.
MM_PER_S = 100.0
LONGEST_S = 20.0
SHORTEST_S = 1.0

LINES = """\
@media (prefers-reduced-motion: no-preference) {
  .ink { stroke-dasharray: 1 2; animation: draw var(--d) linear var(--t) both, appear 1ms linear var(--t) both }
  .way { animation: appear 1ms linear var(--t) both }
}
@keyframes draw { from { stroke-dashoffset: 1 } to { stroke-dashoffset: 0 } }
@keyframes go { from { offset-distance: 0% } to { offset-distance: 100% } }
@keyframes appear { from { opacity: 0 } to { opacity: 1 } }
@keyframes vanish { from { opacity: 1 } to { opacity: 0 } }
"""
# While it moves, the turtle looks where it goes.
TURTLE = """\
@media (prefers-reduced-motion: no-preference) {
  .MOVING { visibility: visible; offset-path: path("WAY"); offset-rotate: auto 90deg;
    animation: go TOTALs linear both, vanish 1ms linear TOTALs both }
  .ARRIVED { animation: appear 1ms linear TOTALs both }
}
"""


class Moment(NamedTuple):
    """When a stroke is drawn: seconds from the beginning."""

    begins_s: float
    lasts_s: float

    def style(self) -> str:
        """What the style sheet has to know of it."""
        return f"--t:{_seconds(self.begins_s)}s;--d:{_seconds(self.lasts_s)}s"


def length_mm(stroke: Stroke) -> float:
    """How long a stroke is."""
    return math.fsum(math.dist(a, b) for a, b in zip(stroke.points, stroke.points[1:], strict=False))


def duration_s(trace: Trace) -> float:
    """How long the turtle takes for all of it, at an even speed; within the limits of what people wait for."""
    way_mm = math.fsum(length_mm(stroke) for stroke in trace.strokes)
    return max(SHORTEST_S, min(LONGEST_S, way_mm / MM_PER_S))


def moments(strokes: Sequence[Stroke], total_s: float) -> list[Moment]:
    """When each stroke is drawn, one after the other, if all of them take so many seconds."""
    lengths = [length_mm(stroke) for stroke in strokes]
    way_mm = math.fsum(lengths) or 1.0
    found: list[Moment] = []
    done_mm = 0.0
    for length in lengths:
        found.append(Moment(done_mm / way_mm * total_s, length / way_mm * total_s))
        done_mm += length
    return found


def turtle(way: str, total_s: float, moving: str, arrived: str) -> str:
    """The style sheet of one turtle.

    Args:
        way: its whole way, as SVG's path data.
        total_s: how long it takes.
        moving: the class of its picture on the way.
        arrived: the class of its picture at the end.
    """
    pieces = {"MOVING": moving, "ARRIVED": arrived, "WAY": way, "TOTAL": _seconds(total_s)}
    text = TURTLE
    for name, piece in pieces.items():
        text = text.replace(name, piece)
    return text


def _seconds(time_s: float) -> str:
    return f"{round(time_s, 3):g}"
