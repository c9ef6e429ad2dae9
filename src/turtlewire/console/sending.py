"""Messages that somebody writes: sent as they are, and somebody is responsible for what they set going."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Protocol

from turtlewire.errors import StoppedError, TurtlewireError, UsageError
from turtlewire.protocols.catalogue import Packet
from turtlewire.protocols.walter.messages import Back, Forward, Left, LogoCommand, Right

if TYPE_CHECKING:
    from collections.abc import Sequence

    from turtlewire.helm.lease import Lease
    from turtlewire.protocols.message import AnyMessage

# What goes on until told otherwise ends after so long, if nothing newer was sent.
LIFE_S = 2.0
# What ends by itself, and takes its time.
MOVES = (Forward, Back, Left, Right)


class Lender(Protocol):
    """Who has the robot: a ``Station``."""

    def borrow(self) -> Lease:
        """The robot, standing. Raises ``Refused`` while it is not reached."""

    def halt(self) -> None:
        """Stop the robot, ahead of everything; whoever has borrowed it has no more say."""

    def tell_of(self, error: TurtlewireError) -> None:
        """Have people told what became of it."""


class Sending:
    """The messages of one robot. To be used from the event loop of the server.

    A motion that a message begins (``forward``) goes on until it is done, as one of a program does, and what it sets
    going (``drive_forward``) for ``LIFE_S``. Meanwhile the robot is lent; a newer message, whoever drives by hand, and
    the end of the session that sent it overtake that.

    Args:
        lender: who has the robot.
    """

    def __init__(self, lender: Lender) -> None:
        self._lender = lender
        self._lease: Lease | None = None
        self._following: asyncio.Task[None] | None = None
        self._under_way = 0

    async def send(self, messages: Sequence[AnyMessage]) -> None:
        """Send messages, in one frame where the protocol has such; returns when they are on their way.

        Of a query, the answer has come then. Raises ``Refused``, ``StoppedError``, and what ``AsyncRobot.send`` raises.
        """
        self._end_following()
        lease = self._lease
        if lease is None or lease.stopped:
            lease = self._lease = self._lender.borrow()
        self._under_way += 1
        try:
            await asyncio.wrap_future(lease.call(lambda robot: robot.send(*messages, valid_s=LIFE_S)))
        finally:
            self._under_way -= 1
            if lease is not self._lease:
                lease.close()
            elif not self._under_way:
                self._following = asyncio.create_task(self._follow(lease, messages), name="turtlewire sent")

    def give_way(self) -> None:
        """Somebody drives by hand: that ends what was sent, and begins at once."""
        self._end_following()
        lease, self._lease = self._lease, None
        if lease is not None:
            lease.close()

    def halt(self) -> None:
        """Who sent it is gone: the robot stops, if anything may still be going on."""
        if self._lease is not None:
            self._lender.halt()
            self.give_way()

    async def _follow(self, lease: Lease, messages: Sequence[AnyMessage]) -> None:
        """Until what was sent is done."""
        try:
            if any(isinstance(message, MOVES) for message in messages):
                await asyncio.wrap_future(lease.call(lambda robot: robot.finish()))
            elif not all(isinstance(message, LogoCommand) for message in messages):
                await asyncio.sleep(LIFE_S)
        except StoppedError:
            pass
        except TurtlewireError as error:
            self._lender.tell_of(error)
        if lease is self._lease:
            self._lease = None
            lease.close()

    def _end_following(self) -> None:
        task, self._following = self._following, None
        if task is not None:
            task.cancel()


def sendable(message: AnyMessage) -> tuple[AnyMessage, ...]:
    """What is to be sent for a message that was read. Raises ``UsageError`` for what only the driver decides."""
    if not isinstance(message, Packet):
        return (message,)
    if message.seq is not None:
        raise UsageError("the driver numbers its frames itself: leave the number out")
    if message.refused or not message.messages:
        raise UsageError("there is nothing to send in this frame")
    return message.messages
