"""What a turtle of steppers and a servo has done, from its pins alone: steps, the way on the ground, what it drew."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.simulator.chassis import Wheels, drive
from turtlewire.trace import Trace

if TYPE_CHECKING:
    from collections.abc import Iterator

    from turtlewire.turtle import Pose

    from .board import Board

LEFT_STEP, RIGHT_STEP, LEFT_AHEAD, RIGHT_AHEAD, SERVO = 2, 3, 4, 5, 9
STEPS_PER_MM, TRACK_MM = 16.0, 140.0
# Between a servo's pulses for the pen up and down, as the sketches have them: 1.0 and 1.6 ms.
PEN_DOWN_S = 1.3e-3


class Step(NamedTuple):
    """A step of both motors: when, and which way each goes."""

    time_s: float
    left: int
    right: int


class Run(NamedTuple):
    """So many steps one after another, both motors' ways the same, and the pen."""

    count: int
    left: int
    right: int
    pen_down: bool


def steps(board: Board) -> list[Step]:
    """All steps since power-on."""
    ways = [
        [(edge.time_s, 1 if edge.level else -1) for edge in board.edges(p)] for p in (LEFT_AHEAD, RIGHT_AHEAD)
    ]
    left, right = ([e.time_s for e in board.edges(pin) if e.level] for pin in (LEFT_STEP, RIGHT_STEP))
    assert len(left) == len(right)
    return [Step(time_s, *now) for time_s, now in _at(left, ways, -1)]


def _at(
    times: list[float], changes: list[list[tuple[float, int]]], first: int
) -> Iterator[tuple[float, list[int]]]:
    """What holds at each of these times, of things that change at times of their own."""
    now, seen = [first] * len(changes), [0] * len(changes)
    for time_s in times:
        for each, some in enumerate(changes):
            while seen[each] < len(some) and some[seen[each]][0] <= time_s:
                now[each] = some[seen[each]][1]
                seen[each] += 1
        yield time_s, list(now)


def pen(board: Board) -> list[tuple[float, int]]:
    """Where each of the servo's pulses puts the pen: when, and 1 for down."""
    return [
        (low.time_s, int(low.time_s - high.time_s > PEN_DOWN_S))
        for high, low in pairwise(board.edges(SERVO))
        if high.level
    ]


def runs(board: Board) -> list[Run]:
    """All steps since power-on, those of a kind together."""
    made = steps(board)
    found: list[Run] = []
    for step, (_, (down,)) in zip(made, _at([step.time_s for step in made], [pen(board)], 0), strict=True):
        kind = (step.left, step.right, bool(down))
        if found and found[-1][1:] == kind:
            found[-1] = Run(found[-1].count + 1, *kind)
        else:
            found.append(Run(1, *kind))
    return found


def drawing(board: Board) -> Trace:
    """What the pen has drawn, and where the wheels have brought the robot."""
    trace = Trace()
    for run in runs(board):
        mm = run.count / STEPS_PER_MM
        trace.move(
            drive(trace.pose, Wheels(mm * run.left, mm * run.right), TRACK_MM), pen_down=run.pen_down
        )
    return trace


def pose(board: Board) -> Pose:
    """Where the wheels have brought the robot."""
    return drawing(board).pose
