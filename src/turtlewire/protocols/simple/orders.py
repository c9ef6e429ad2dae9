"""simple, the host's end: commands as they were submitted, wanted and sent."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from turtlewire.protocols.simple.messages import SimpleCommand


class Order:
    """A command as it was submitted. ``told``: its end has been reported."""

    __slots__ = ("command", "tag", "told")

    def __init__(self, command: SimpleCommand, tag: object) -> None:
        self.command = command
        self.tag = tag
        self.told = False


class Channel:
    """What one channel is wanted to be, how often that got lost, and when it was sent last."""

    __slots__ = ("losses", "sent_at", "wanted")

    def __init__(self) -> None:
        self.wanted: Order | None = None
        self.losses = 0
        self.sent_at = -math.inf


class Flight(NamedTuple):
    """A command that has been sent and not been answered, and the orders that it carries out."""

    command: SimpleCommand
    orders: list[Order]
    due: float
