"""What somebody wants of a robot: a wish, which holds for a time, and orders, which are carried out once."""

from __future__ import annotations

import math
from enum import Enum, auto
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from turtlewire.protocols.walter.messages import DirectKey


class Action(Enum):
    """What a key does that is not held."""

    STOP = auto()
    QUIT = auto()
    RESUME = auto()
    FASTER = auto()
    SLOWER = auto()
    LAMP = auto()
    PEN = auto()
    CLEAN = auto()
    RAISE_PEN = auto()
    LOWER_PEN = auto()
    # WALTER has two speeds, each with keys of its own.
    MOVE_FASTER = auto()
    MOVE_SLOWER = auto()
    TURN_FASTER = auto()
    TURN_SLOWER = auto()
    ASK_MOVE_SPEED = auto()
    ASK_TURN_SPEED = auto()


class Wish(NamedTuple):
    """What the robot is to do as long as nothing else is wished.

    Attributes:
        speed, turn: -1..1, as ``Drive.drive`` takes them.
        horn: whether it sounds.
        until: when it ends, seconds; infinite: latched.
        number: of the key press that it is of. A wish that was ended by a stop or an error has its number, too.
    """

    speed: float = 0.0
    turn: float = 0.0
    horn: bool = False
    until: float = -math.inf
    number: int = 0

    @property
    def moves(self) -> bool:
        """Whether the robot is to move."""
        return bool(self.speed or self.turn)


class Order(NamedTuple):
    """Something to do once.

    Attributes:
        value: a speed, for those of the speeds; 1 or 0 for the pen down or up and the lamp on or off. None: the other
            way round than it is.
    """

    action: Action
    value: int | None = None


def walter_key(action: Action) -> DirectKey | None:
    """What WALTER is sent for one of its own keys; None: it is not one of those."""
    from turtlewire.protocols.walter import messages

    return {
        Action.RAISE_PEN: messages.RaisePen(),
        Action.LOWER_PEN: messages.LowerPen(),
        Action.MOVE_FASTER: messages.MoveFaster(),
        Action.MOVE_SLOWER: messages.MoveSlower(),
        Action.TURN_FASTER: messages.TurnFaster(),
        Action.TURN_SLOWER: messages.TurnSlower(),
    }.get(action)
