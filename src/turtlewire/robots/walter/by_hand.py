"""WALTER driven by hand: direct control, where a key starts a motion and the next one ends it.

In direct control the robot moves or turns, one at a time. Keys overtake whatever has not left the computer, which
must be neither half of an emergency stop nor a key without its argument: they wait until the line is free, and only the
newest of those that wait are sent. Each burst begins with the key that leaves the pen as it is: should a key be left
without its argument all the same, that is what it gets.

The protocol has no questions in direct control: where the robot gets is reckoned from the keys.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.drive import checked
from turtlewire.errors import MessageError, UsageError
from turtlewire.protocols.walter.codec import Mode
from turtlewire.protocols.walter.messages import (
    EMERGENCY_STOP,
    DirectKey,
    LowerPen,
    MoveFaster,
    MoveSlower,
    RaisePen,
    SelectLogo,
    SetMoveSpeed,
    SetTurnSpeed,
    StartBackward,
    StartForward,
    StartLeft,
    StartRight,
    Stop,
    TurnFaster,
    TurnSlower,
)
from turtlewire.robots.checks import check_hold, check_valid_s
from turtlewire.robots.timed.reckoning import STILL, Motion, Reckoning

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.robots.walter.connection import Connection
    from turtlewire.turtle import Pose

FULL_SPEED = 255
# What the keys that start something start: ahead and to the right, in units of speed.
STARTS: dict[type[DirectKey], tuple[int, int]] = {
    StartForward: (1, 0),
    StartBackward: (-1, 0),
    StartRight: (0, 1),
    StartLeft: (0, -1),
}


class Account(Reckoning):
    """What a robot does that is driven by hand, as far as its keys tell.

    Args:
        pose, pen_down: where it was when that began.
        speed: what both of its speeds were set to (W14).

    Attributes:
        started: the key that started the motion under way; None: it stands.
    """

    def __init__(self, pose: Pose, speed: int, *, pen_down: bool) -> None:
        super().__init__()
        self.trace.pose = pose
        self.place(pose)
        self.pen_down = pen_down
        self.started: type[DirectKey] | None = None
        self.move_speed = self.turn_speed = speed

    def end(self, now: float) -> None:
        """The robot stands still from now on."""
        super().end(now)
        self.started = None

    def note(self, key: DirectKey) -> None:
        """A key was pressed. ``begin`` the ``motion`` when it arrives."""
        match key:
            case SetMoveSpeed():
                self.move_speed = key.speed
            case SetTurnSpeed():
                self.turn_speed = key.speed
            case MoveFaster() | MoveSlower():
                self.move_speed = _saturated(self.move_speed + (1 if isinstance(key, MoveFaster) else -1))
            case TurnFaster() | TurnSlower():
                self.turn_speed = _saturated(self.turn_speed + (1 if isinstance(key, TurnFaster) else -1))
            case Stop():
                self.started = None
            case _ if type(key) in STARTS:
                self.started = type(key)

    def motion(self, mm_per_s_per_unit: float, deg_per_s_per_unit: float) -> Motion:
        """What the robot does, as it was told last."""
        if self.started is None:
            return STILL
        ahead, right = STARTS[self.started]
        return Motion(
            ahead * self.move_speed * mm_per_s_per_unit, right * self.turn_speed * deg_per_s_per_unit
        )


class ByHand:
    """The direct control of one robot."""

    def __init__(self, wire: Connection) -> None:
        self._wire = wire
        self._newest = 0

    async def drive(self, speed: float, turn: float, valid_s: float | None) -> None:
        """See ``Drive.drive``: the robot does whichever of the two is more.

        What it does already is not started again, it only lives longer; nor does a new speed interrupt it.

        Raises ``MessageError``, ``LinkError``, and ``LimitReachedError`` for a limit that has tripped meanwhile.
        """
        checked("speed", speed)
        checked("turn", turn)
        check_valid_s(valid_s)
        await self._send(lambda: self._missing(_keys(speed, turn)))
        if valid_s is None:
            self._wire.session.clear_alarm()
        else:
            self._wire.session.set_alarm(self._wire.link.now() + valid_s, self._out_of_time)

    async def hold(self, speed: int, seconds: float, *, turning: bool) -> None:
        """Drive or turn with a speed for a time; see ``AsyncWalter.hold``."""
        check_hold(seconds, None)
        if not 1 <= abs(speed) <= FULL_SPEED:
            raise MessageError(f"speed is {speed}, but must be from 1 to {FULL_SPEED}, or so far below 0")
        wire = self._wire
        part = speed / FULL_SPEED
        wire.check()
        # Keys would take back what has not left yet, and begin the sooner.
        await wire.until(lambda: False, wire.session.free_at)
        await self.press(*(_keys(0.0, part) if turning else _keys(part, 0.0)))
        # The emergency stop acts with its last byte, as does the key that starts.
        stop_s = len(EMERGENCY_STOP) * 10.0 / wire.settings.baud
        ends_at = wire.session.free_at + seconds
        wire.session.set_alarm(ends_at - stop_s, self._out_of_time)
        await wire.until(lambda: False, ends_at)

    def _missing(self, keys: tuple[DirectKey, ...]) -> tuple[DirectKey, ...]:
        """Those of the keys of a set-point that change something. A stop may have got lost: it is never left out."""
        hand = self._wire.hand
        if hand is None or hand.started is None or type(keys[-1]) is not hand.started:
            return keys
        is_new = keys[0] not in (SetMoveSpeed(hand.move_speed), SetTurnSpeed(hand.turn_speed))
        return keys[:1] if is_new else ()

    async def press(self, *keys: DirectKey, valid_s: float | None = None) -> None:
        """Press keys; takes the robot from a program that moves it, and out of Logo control.

        ``valid_s``: what goes on then is stopped when no set-point has come for so long; None: that stays as it is.

        Raises ``UsageError`` for the key that leaves direct control: the next command of the turtle does that, and sees
        to it that host and robot agree where it is; and what ``drive`` raises.
        """
        for key in keys:
            key.check()
            if isinstance(key, SelectLogo):
                raise UsageError("the next command of the turtle changes to Logo control by itself")
        await self._send(lambda: keys)
        if valid_s is not None:
            self._wire.session.set_alarm(self._wire.link.now() + valid_s, self._out_of_time)

    async def _send(self, choose: Callable[[], tuple[DirectKey, ...]]) -> None:
        """Press what is chosen when its time has come, unless something newer has come by then."""
        wire, host = self._wire, self._wire.host
        wire.check()
        await wire.raise_event()
        self._newest += 1
        number = self._newest
        if host.mode is Mode.DIRECT:
            # A stop may go out meanwhile, and make it longer.
            while wire.link.now() < wire.session.free_at:
                await wire.until(lambda: number != self._newest, wire.session.free_at)
                if number != self._newest:
                    return
        else:
            wire.halt()
            if not host.answers:
                wire.tell("the robot answers no queries: where it gets by hand is reckoned, and not known")
        hand = wire.hand
        if hand is None:
            hand = wire.hand = Account(wire.whereabouts(), wire.speed, pen_down=wire.pen_down)
        keys = choose()
        if not keys:
            return
        host.press(LowerPen() if wire.pen_down else RaisePen())
        for key in keys:
            host.press(key)
            hand.note(key)
            if isinstance(key, LowerPen | RaisePen):
                wire.pen_down = isinstance(key, LowerPen)
        wire.session.flush()
        settings = wire.settings
        hand.begin(hand.motion(settings.mm_per_s_per_unit, settings.deg_per_s_per_unit), wire.session.free_at)
        hand.pen_down = wire.pen_down

    def _out_of_time(self, now: float) -> None:
        """The set-point's time is up, and no newer one has come."""
        if self._wire.host.mode is Mode.DIRECT:
            self._wire.end_hand(now)
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


def _saturated(units: int) -> int:
    return max(0, min(FULL_SPEED, units))
