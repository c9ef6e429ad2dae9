"""The keys of each robot. A key is what it types, in lower case, or its name: ``up``, ``space``, ``escape``."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from turtlewire.dashboard.holding import Axis
from turtlewire.helm.wishes import Action

if TYPE_CHECKING:
    from collections.abc import Mapping


class Help(NamedTuple):
    """A few keys, and what they do.

    Attributes:
        feature: of the robot, that there must be; "": none.
    """

    keys: str
    what: str
    feature: str = ""


class Layout(NamedTuple):
    """The keys of one kind of robot.

    Attributes:
        moves: keys that drive while they are held.
        actions: keys that do something once.
        help: what people are told, in order.
        combines: whether it drives and turns at the same time.
        has_two_speeds: one to move with, and one to turn with.
    """

    moves: Mapping[str, tuple[Axis, int]]
    actions: Mapping[str, Action]
    help: tuple[Help, ...]
    combines: bool = True
    has_two_speeds: bool = False


HORN = "h"
ARROWS = {
    "up": (Axis.SPEED, 1),
    "down": (Axis.SPEED, -1),
    "left": (Axis.TURN, -1),
    "right": (Axis.TURN, 1),
}
SHARED = {
    "space": Action.STOP,
    "escape": Action.STOP,
    "q": Action.QUIT,
    "r": Action.RESUME,
    "l": Action.LAMP,
    "+": Action.FASTER,
    "=": Action.FASTER,  # the same key on many keyboards
    "-": Action.SLOWER,
}
STOP_HELP = Help("Space", "stop")
SHARED_HELP = (
    Help("1-9 + -", "speed"),
    Help("L", "lights", "lamp"),
    Help("H", "horn", "horn"),
    Help("Q", "quit"),
)
WASD = Layout(
    moves={
        **ARROWS,
        "w": ARROWS["up"],
        "s": ARROWS["down"],
        "a": ARROWS["left"],
        "d": ARROWS["right"],
    },
    actions={**SHARED, "p": Action.PEN},
    help=(Help("W A S D or arrows", "drive"), STOP_HELP, Help("P", "pen", "pen"), *SHARED_HELP),
)
# Its own keys of direct control (section 3 of its protocol), and arrows for those who do not know them.
WALTER = Layout(
    moves={
        **ARROWS,
        "a": ARROWS["up"],
        "z": ARROWS["down"],
        ",": ARROWS["left"],
        ".": ARROWS["right"],
    },
    actions={
        **SHARED,
        "s": Action.RAISE_PEN,
        "x": Action.LOWER_PEN,
        "d": Action.MOVE_FASTER,
        "c": Action.MOVE_SLOWER,
        "f": Action.TURN_FASTER,
        "v": Action.TURN_SLOWER,
        "g": Action.ASK_MOVE_SPEED,
        "b": Action.ASK_TURN_SPEED,
    },
    help=(
        Help("A Z , . or arrows", "drive"),
        STOP_HELP,
        Help("S X", "pen up, down"),
        Help("D C", "speed"),
        Help("F V", "of turns"),
        Help("G B", "type them"),
        *SHARED_HELP,
    ),
    combines=False,
    has_two_speeds=True,
)


def layout(protocol: str) -> Layout:
    """The keys of the robot that speaks a protocol."""
    return WALTER if protocol == "walter" else WASD
