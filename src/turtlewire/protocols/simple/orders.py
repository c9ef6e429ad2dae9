"""simple, the host's end: commands as they were submitted, wanted, sent and accepted."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import msgspec

from turtlewire.protocols.simple.events import RobotState

if TYPE_CHECKING:
    from collections.abc import Iterable

    from turtlewire.protocols.simple.messages import SimpleCommand


class Order(msgspec.Struct, eq=False):
    """A command as it was submitted, and its bytes. ``told``: its end has been reported."""

    command: SimpleCommand
    data: bytes
    tag: object
    told: bool = False


class Channel:
    """What one channel is wanted to be, and when it was sent last."""

    __slots__ = ("sent_at", "wanted")

    def __init__(self) -> None:
        self.wanted: Order | None = None
        self.sent_at = -math.inf


def longest_ago(channels: dict[str, Channel]) -> str:
    """The set-point that moves the robot and was sent longest ago, so that each is repeated in turn; "": none does."""
    moving = [(c.sent_at, name) for name, c in channels.items() if c.wanted and c.wanted.command.STOPPED]
    return min(moving, default=(0.0, ""))[1]


class Flight(msgspec.Struct, eq=False):
    """A command that has been sent and not been answered, the orders that it carries out; when, and when it must be."""

    command: SimpleCommand
    orders: list[Order]
    due: float
    sent_at: float


class Knowledge:
    """What is known of the robot, worked out only when somebody asks: that is seldom, and commands are many."""

    __slots__ = ("_before", "_last")

    def __init__(self) -> None:
        self._before = RobotState()
        self._last: dict[str, SimpleCommand] = {}  # accepted since then, by channel; a stop has none

    def begin(self, state: RobotState) -> None:
        """Know this, and nothing else."""
        self._before = state
        self._last.clear()

    def accepted(self, command: SimpleCommand) -> None:
        """The robot has carried out a command."""
        if not command.CHANNEL:
            # What a stop ended is known by it. It comes before any set-point that is kept later.
            self._last = {name: last for name, last in self._last.items() if not last.STOPPED}
        self._last[command.CHANNEL] = command

    def state(self, flights: Iterable[Flight]) -> RobotState:
        """What is known while these are under way."""
        state = self._before
        for command in self._last.values():
            state = state.after(command)
        for flight in flights:
            state = state.during(flight.command)
        return state
