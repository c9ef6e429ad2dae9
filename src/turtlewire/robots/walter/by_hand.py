"""WALTER driven by hand: direct control, where a key starts a motion and the next one ends it.

In direct control the robot moves or turns, one at a time. Keys overtake whatever has not left the computer, which
must be neither half of an emergency stop nor a key without its argument: they wait until the line is free, and only the
newest of those that wait are sent. Each burst begins with the key that leaves the pen as it is: should a key be left
without its argument all the same, that is what it gets.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from turtlewire.drive import checked
from turtlewire.errors import LinkClosedError, MessageError, UsageError
from turtlewire.protocols.walter.codec import Mode
from turtlewire.protocols.walter.messages import (
    DirectKey,
    LowerPen,
    RaisePen,
    SelectLogo,
    SetMoveSpeed,
    SetTurnSpeed,
    StartBackward,
    StartForward,
    StartLeft,
    StartRight,
    Stop,
)

if TYPE_CHECKING:
    from turtlewire.robots.walter.connection import Connection

FULL_SPEED = 255


class ByHand:
    """The direct control of one robot."""

    def __init__(self, wire: Connection) -> None:
        self._wire = wire
        self._newest = 0

    async def drive(self, speed: float, turn: float, valid_s: float | None) -> None:
        """See ``Drive.drive``: the robot does whichever of the two is more.

        Raises ``MessageError``, ``LinkError``, and ``LimitReachedError`` for a limit that has tripped meanwhile.
        """
        checked("speed", speed)
        checked("turn", turn)
        if valid_s is not None and not 0.0 < valid_s < math.inf:
            raise MessageError(f"valid_s is {valid_s}, but must be above 0 seconds, or None")
        await self.press(*_keys(speed, turn))
        if valid_s is None:
            self._wire.timed.clear_alarm()
        else:
            self._wire.timed.set_alarm(self._wire.link.now() + valid_s, self._out_of_time)

    async def press(self, *keys: DirectKey) -> None:
        """Press keys; takes the robot from a program that moves it, and out of Logo control.

        Raises ``UsageError`` for the key that leaves direct control: the next command of the turtle does that, and sees
        to it that host and robot agree where it is; and what ``drive`` raises.
        """
        wire, host = self._wire, self._wire.host
        for key in keys:
            key.check()
            if isinstance(key, SelectLogo):
                raise UsageError("the next command of the turtle changes to Logo control by itself")
        if wire.closed:
            raise LinkClosedError(f"the link to {wire.link.url} is closed: connect again")
        await wire.raise_event()
        self._newest += 1
        number = self._newest
        if host.mode is Mode.DIRECT:
            await wire.until(lambda: number != self._newest, wire.timed.free_at)
            if number != self._newest:
                return
        else:
            wire.halt()
            if not host.answers:
                wire.notify(
                    "the robot answers no queries: where it gets by hand is not known; its turtle goes on as if it had "
                    "not moved"
                )
        host.press(LowerPen() if wire.pen_down else RaisePen())
        for key in keys:
            host.press(key)
            if isinstance(key, LowerPen | RaisePen):
                wire.pen_down = isinstance(key, LowerPen)
        wire.session.flush()

    def _out_of_time(self, now: float) -> None:
        """The set-point's time is up, and no newer one has come."""
        if self._wire.host.mode is Mode.DIRECT:
            self._wire.host.emergency_stop(now)


def _keys(speed: float, turn: float) -> tuple[DirectKey, ...]:
    """What to press for a set-point."""
    if not speed and not turn:
        return (Stop(),)
    if abs(turn) > abs(speed):
        return SetTurnSpeed(_units(turn)), StartRight() if turn > 0.0 else StartLeft()
    return SetMoveSpeed(_units(speed)), StartForward() if speed > 0.0 else StartBackward()


def _units(part: float) -> int:
    return max(1, round(abs(part) * FULL_SPEED))
