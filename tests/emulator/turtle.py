"""What a turtle of steppers and a servo has done, from its pins alone: steps, the way on the ground, what it drew."""

from __future__ import annotations

import math
from bisect import bisect_left
from itertools import groupby, pairwise
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.simulator.chassis import Wheels, drive
from turtlewire.trace import Trace

if TYPE_CHECKING:
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

    steps: int
    left: int
    right: int
    pen_down: bool


def steps(board: Board) -> list[Step]:
    """All steps since power-on."""
    left, right = ([e.time_s for e in board.edges(pin) if e.level] for pin in (LEFT_STEP, RIGHT_STEP))
    assert len(left) - len(right) in (0, 1)  # both make their steps together, the left one a moment before
    left = left[: len(right)]
    ways = [
        _at(left, [(edge.time_s, 2 * edge.level - 1) for edge in board.edges(pin)], -1)
        for pin in (LEFT_AHEAD, RIGHT_AHEAD)
    ]
    return [Step(*step) for step in zip(left, *ways, strict=True)]


def _at(times: list[float], changes: list[tuple[float, int]], first: int) -> list[int]:
    """What holds at each of these times, of something that changes at times of its own."""
    found: list[int] = []
    for until_s, after in [*changes, (math.inf, first)]:
        found += [first] * (bisect_left(times, until_s) - len(found))
        first = after
    return found


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
    downs = _at([step.time_s for step in made], pen(board), 0)
    kinds = groupby((step.left, step.right, down) for step, down in zip(made, downs, strict=True))
    return [Run(sum(1 for _ in some), left, right, bool(down)) for (left, right, down), some in kinds]


def drawing(board: Board) -> Trace:
    """What the pen has drawn, and where the wheels have brought the robot."""
    trace = Trace()
    for run in runs(board):
        mm = run.steps / STEPS_PER_MM
        trace.move(drive(trace.pose, Wheels(mm * run.left, mm * run.right), TRACK_MM), pen_down=run.pen_down)
    return trace


def pose(board: Board) -> Pose:
    """Where the wheels have brought the robot."""
    return drawing(board).pose
