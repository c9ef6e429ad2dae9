"""A two-engine robot over ``frame``: its own commands, by hand, and as a turtle whose pen is a servo (F9..F13)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from turtlewire.drive import checked
from turtlewire.errors import LimitReachedError, MessageError, NotSupportedError, UsageError
from turtlewire.protocols.frame.dialect import TO_ROBOT
from turtlewire.protocols.frame.message import FrameMessage
from turtlewire.robots.checks import check_hold, check_valid_s
from turtlewire.robots.two_engine.line import SERVO, TwoEngineLine, way
from turtlewire.robots.two_engine.settings import Statistics
from turtlewire.robots.two_engine.wheels import EngineWheels, Told, wheels
from turtlewire.turtle import TONES

if TYPE_CHECKING:
    from turtlewire.protocols.message import AnyMessage
    from turtlewire.robots.calibration import TwoEngineCalibration

LAMP, BEEP = "set_lamp", "beep"
LONGEST_BEEP_MS = 5000


class AsyncTwoEngine(TwoEngineLine):
    """A two-engine robot, driven asynchronously. ``turtlewire.connect_async`` makes one; an async context manager.

    Nothing that is sent is answered: a frame that gets lost is not noticed, except by the odometry of a dialect that
    has it. Besides what ``AsyncTimedRobot`` says, methods raise ``LimitReachedError`` when a dialect with a bumper
    tells that it was touched, and ``PoseUncertainError`` when one with odometry tells that the robot was reset while it
    moved; the robot has been stopped then.

    Args:
        link: to the robot; the driver owns it from here on.
        settings: how to drive it.
        notify: told, in a sentence for people, what they should know and what is no error.
        paper: what the robot draws on, where that can be seen (a simulated robot); None: it is reckoned.
    """

    # ------------------------------------------------------------------ the robot's own commands

    async def send(self, *messages: AnyMessage, valid_s: float | None = None) -> None:
        """Send messages of the dialect, in one frame if they fit (F9); returns when they are on their way.

        ``valid_s``: the robot is stopped when no newer set-point of its wheels has come for so long; None: it goes on.

        Raises ``MessageError``, before any byte leaves, for a message of another dialect or a field out of range (F4).
        """
        check_valid_s(valid_s)
        checked = [self._sendable(message) for message in messages]
        await self._ready()
        told: Told | None = None
        for message in checked:
            told = self._wheels.after(told or self._told_wheels, message) or told
            self._note_pen(message)
        if told is None:
            self._host.send(*checked)
        else:
            self._steer(told, tuple(checked))
            self._expire(valid_s)
        await self._until(lambda: self._host.idle)

    def _sendable(self, message: AnyMessage) -> FrameMessage:
        if not isinstance(message, FrameMessage):
            raise MessageError(f"{message.name()} is no message of the dialect {self._dialect.name}")
        if not self._dialect.check(message).goes(TO_ROBOT):
            raise MessageError(f"{message.name()} is what a robot says, not what it is told")
        return message

    async def engine(self, number: int, speed: int, *, valid_s: float | None = None) -> None:
        """Turn one engine, until told otherwise: -255 (full speed backward) .. 255 (full speed forward).

        Raises ``MessageError`` for a number outside, ``NotSupportedError`` for a dialect without engines, and for
        backward where the robot cannot tell it from forward (F1).
        """
        if not isinstance(self._wheels, EngineWheels):
            raise NotSupportedError(f"the dialect {self._dialect.name} has no engines, but speeds of wheels")
        await self.send(self._wheels.engine(number, speed), valid_s=valid_s)

    async def hold(self, left: int, right: int, seconds: float, settle_s: float | None = None) -> None:
        """Turn the wheels for a time, and stand still again: the motion that calibration measures.

        Args:
            left: -255..255, ahead above 0; in a dialect that speaks of mm/s, that.
            right: the same.
            seconds: above 0, at most 60, from when the robot is told to move to when it is told to stand still.
            settle_s: how long to wait after that, 0..60 seconds; None: as long as the calibration says.

        Afterwards the turtle is where the robot is, by reckoning. Raises ``MessageError`` for a number outside, and
        ``NotSupportedError`` for backward where the robot cannot tell it from forward (F1).
        """
        check_hold(seconds, settle_s)
        told = Told(left, right)
        for message in self._wheels.messages(told):
            self._dialect.check(message)
        await self._turtle_ready()
        # What it coasts is a part of what is measured.
        await self._move(told, seconds + self._calibration.overrun_s, settle_s)
        if settle_s is None:
            await self._hear_odometer()
        self.account.settle()

    async def recalibrate(self, calibration: TwoEngineCalibration) -> None:
        """From now on, drive by another calibration. The robot is to stand still.

        Raises ``UsageError`` for one that this robot, or its dialect, cannot have.
        """
        await self._turtle_ready()
        before = self._calibration
        try:
            self._calibration = calibration
            self._wheels, self._pen_servo = wheels(self._dialect, calibration), self._checked_pen()
        except UsageError:
            self._calibration = before
            raise
        self._odometer.mm_per_tick = calibration.mm_per_tick
        self._settle_s, self._overrun_s = calibration.settle_s, calibration.overrun_s

    async def set_servo(self, number: int, position_deg: int) -> None:
        """Move a servo to 0..180 degrees.

        Raises ``MessageError`` for a number outside, ``NotSupportedError`` for a dialect without servos.
        """
        await self.send(self._made(SERVO, "servos", servo_id=number, position_deg=position_deg))

    async def drive(self, speed: float, turn: float, *, valid_s: float | None = None) -> None:
        """Go on so until told otherwise: speed -1..1, turn -1 (left) .. 1 (right, on the spot). See ``Drive.drive``."""
        checked("speed", speed)
        checked("turn", turn)
        check_valid_s(valid_s)
        await self._ready()
        left, right = speed + turn, speed - turn
        # Their ratio is the curve that is wanted: it is kept where one of them is more than there is.
        most = max(1.0, abs(left), abs(right))
        told = self._wheels.portion(left / most, right / most)
        self._steer(told, tuple(self._wheels.messages(told)))
        self._expire(valid_s)

    @property
    def ticks(self) -> tuple[int, int] | None:
        """The ticks of the encoders, left and right, since the first report; None: the robot reports none."""
        return None if self._odometer.heard_at is None else self._odometer.ticks

    @property
    def goes_backward(self) -> bool:
        """Whether it can be told to (F1)."""
        try:
            self._wheels.messages(Told(-1, -1))
        except NotSupportedError:
            return False
        return True

    def _steer(self, told: Told, messages: tuple[FrameMessage, ...]) -> None:
        motion = self._wheels.motion(told)
        if self._is_holding:
            self._take_wheel()
        self._host.send(*messages)
        self._told_wheels = told
        self._session.flush()
        self._driven(motion)
        self._motions += 1

    @property
    def features(self) -> frozenset[str]:
        """What the dialect has messages for, and the calibration a pen."""
        found = {name for name, what in (("lamp", LAMP), ("horn", BEEP)) if what in self._types}
        if SERVO in self._types and self._dialect.counts.get("servos", 0):
            found.add("servos")
        if self._pen_servo is not None:
            found.add("pen")
        return frozenset(found)

    async def lamp(self, on: bool) -> None:
        """Switch the lamp. Raises ``NotSupportedError`` for a dialect without one."""
        await self.send(self._made(LAMP, "lamp", on=on))

    async def horn(self, tone: str) -> None:
        """Sound the horn for as long as it can, or until ``"off"``. Raises ``NotSupportedError`` without one."""
        if tone not in TONES or BEEP not in self._types:
            await super().horn(tone)
        await self.send(
            self._made(
                BEEP, "horn", tone=TONES.index(tone), duration_ms=LONGEST_BEEP_MS if tone != "off" else 0
            )
        )

    # ------------------------------------------------------------------ as a turtle

    async def right(self, angle_deg: float) -> None:
        """Turn clockwise on the spot. Raises ``NotSupportedError`` where engines have no backward (F1)."""
        self._wheels.messages(Told(1, -1))
        await super().right(angle_deg)

    async def _turn_robot(self, angle_deg: float) -> None:
        track_mm = self._calibration.track_mm
        rim_mm = math.radians(abs(angle_deg)) * track_mm / 2.0
        rim = math.copysign(self._fitting(rim_mm, self._wheels.full_mm_per_s), angle_deg)
        told = self._wheels.nearest(rim, -rim)
        await self._move(told, angle_deg / self._wheels.motion(told).turn_deg_per_s)
        await self._hear_odometer()

    async def _move_robot(self, distance_mm: float) -> None:
        speed = math.copysign(self._fitting(distance_mm, self._wheels.full_mm_per_s), distance_mm)
        told = self._wheels.nearest(speed, speed)
        await self._move(told, distance_mm / self._wheels.motion(told).speed_mm_per_s)
        await self._hear_odometer()

    async def _move(self, told: Told, seconds: float, settle_s: float | None = None) -> None:
        messages, planned = self._wheels.messages(told), self._wheels.motion(told)
        if self._blocked and self._blocked == way(planned):
            raise LimitReachedError(self._blocked, *self._stand())

        def submit() -> None:
            self._told_wheels = told
            self._host.send(*messages)

        self._motions += 1
        await self._hold(planned, seconds, submit, settle_s=settle_s and 0.0)
        still_at = self._session.arrived_at
        for _ in range(self._settings.halts - 1):
            await self._told(self._halt)
        if settle_s is not None:
            await self._pause(still_at + settle_s - self.link.now())

    # ------------------------------------------------------------------ what is known

    @property
    def statistics(self) -> Statistics:
        """Figures of this connection."""
        seen = self._host.statistics
        return Statistics(
            bytes_sent=self._session.bytes_sent,
            bytes_received=self._session.bytes_received,
            distance_mm=self.account.distance_mm,
            repeats=self._host.repeats,
            frames_received=seen.frames,
            frames_ignored=seen.oversized
            + seen.wrong_crc
            + seen.incomplete
            + seen.unknown_type
            + seen.inconsistent,
            frames_lost=seen.lost,
            resynchronisations=seen.oversized + seen.wrong_crc + seen.incomplete,
            skipped_bytes=seen.skipped_bytes,
            corrections=self._odometer.corrections,
            reconnections=self._session.reconnections,
            seconds=self.link.now() - self.started,
        )
