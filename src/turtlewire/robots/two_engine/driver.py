"""A two-engine robot over ``frame``: its own commands, by hand, and as a turtle whose pen is a servo (F9..F13)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, cast

from turtlewire.drive import checked
from turtlewire.errors import LimitReachedError, NotSupportedError, PoseUncertainError, UsageError
from turtlewire.protocols.frame.codec import FrameEncoder
from turtlewire.protocols.frame.host import Host, stop_bytes
from turtlewire.protocols.frame.message import FrameMessage
from turtlewire.robots.checks import check_hold, check_valid_s
from turtlewire.robots.timed.driver import AsyncTimedRobot
from turtlewire.robots.two_engine.odometry import Odometer, Travel
from turtlewire.robots.two_engine.settings import DEFAULTS, Settings, Statistics
from turtlewire.robots.two_engine.wheels import EngineWheels, Told, field_values, motion, wheels
from turtlewire.turtle import TONES

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.links.link import Link
    from turtlewire.robots.calibration import TwoEngineCalibration
    from turtlewire.robots.timed.reckoning import Motion
    from turtlewire.trace import Paper
    from turtlewire.turtle import Pose

# Less is not worth a turn.
WORTH_DEG = 0.05
# So often a robot that may be booting is told to stop.
BOOT_STOP_S = 0.5
SERVO, LAMP, BEEP = "set_servo_position", "set_lamp", "beep"
ODOMETRY, STATUS = "odometry", "status"
LONGEST_BEEP_MS = 5000


class AsyncTwoEngine(AsyncTimedRobot[FrameMessage]):
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

    def __init__(
        self,
        link: Link,
        settings: Settings = DEFAULTS,
        notify: Callable[[str], None] = lambda _: None,
        paper: Paper | None = None,
    ) -> None:
        self._settings = settings = settings.checked()
        self._calibration = settings.calibration
        assert settings.dialect is not None
        assert settings.baud is not None
        self._dialect, self._baud = settings.dialect, settings.baud
        self._types = {entry.message_type.name(): entry.message_type for entry in self._dialect.entries}
        self._wheels = wheels(self._dialect, self._calibration)
        self._pen_servo = self._checked_pen()
        self._host = Host(
            self._dialect, repeat_s=settings.repeat_s, heartbeat_s=settings.heartbeat_s, baud=self._baud
        )
        super().__init__(
            link,
            self._host,
            notify,
            paper,
            baud=self._baud,
            stop_size=len(FrameEncoder(self._dialect).encode(self._wheels.messages(Told()))[0]),
            speed=settings.speed,
            tolerance_mm=settings.tolerance_mm,
            worth_deg=WORTH_DEG,
            settle_s=self._calibration.settle_s,
            overrun_s=self._calibration.overrun_s,
        )
        self._stop_bytes = len(stop_bytes(FrameEncoder(self._dialect)))
        self._told_wheels = Told()
        self._odometer = Odometer(self._calibration.mm_per_tick)
        # The pose, and the travel by reckoning, when they were last compared with the ticks; and the motions since.
        self._compared = (self.account.robot, 0.0, 0.0)
        self._motions = 0
        self._blocked: str | None = None  # by what a bumper touches: "front" or "back"

    def _checked_pen(self) -> int | None:
        """The pen's servo, if the robot has any. Raises ``UsageError`` if it has servos, but not that one."""
        number, count = self._calibration.pen_servo, self._dialect.counts.get("servos", 0)
        if number is None or SERVO not in self._types or not count:
            return None
        if number >= count:
            raise UsageError(
                f"pen_servo is {number}, but this robot has {count} servos: numbers begin with 0"
            )
        return number

    async def connect(self) -> None:
        """Stop the robot, whatever it was in the middle of (F13), and lower its pen; its place is home."""
        self._session.start()
        try:
            await self._stop_while_booting()
            await self._restore()
        except BaseException:
            await self.let_go(self._last_bytes_s)
            raise
        self._reconnect(self._settings.reconnect_s)

    async def _stop_while_booting(self) -> None:
        """The port was just opened: F13, again and again until the robot is heard, or must have booted."""
        session, host, stop_s = self._session, self._host, self._last_bytes_s
        before, booted_at = host.statistics.frames, self.link.now() + self._settings.boot_s
        host.connect(self.link.now())
        while host.statistics.frames == before and self.link.now() < booted_at:
            again_at = min(booted_at, self.link.now() + BOOT_STOP_S)
            await session.until(lambda: host.statistics.frames > before, again_at)
            host.emergency_stop(self.link.now())
        session.flush()
        await session.until(lambda: False, self.link.now() + stop_s)

    def link_lost(self) -> str:
        """Where the robot may be now."""
        self._told_wheels = Told()
        return super().link_lost()

    async def get_in_step(self) -> None:
        """The port is open again: stop the robot, whatever it was in the middle of (F13)."""
        # It may have been reset: its ticks say nothing of what was before.
        self._odometer.forget()
        await self._stop_while_booting()
        self._found()
        self._compared = (self.account.robot, self.account.rolled_mm, self.account.rotated_deg)
        self._motions = 0

    async def _restore(self) -> None:
        await self._move_pen(down=self.account.pen_down)

    # ------------------------------------------------------------------ the robot's own commands

    async def send(self, *messages: FrameMessage, valid_s: float | None = None) -> None:
        """Send messages of the dialect, in one frame if they fit (F9); returns when they are on their way.

        ``valid_s``: the robot is stopped when no newer set-point of its wheels has come for so long; None: it goes on.

        Raises ``MessageError``, before any byte leaves, for a message of another dialect or a field out of range (F4).
        """
        check_valid_s(valid_s)
        for message in messages:
            self._dialect.check(message)
        await self._ready()
        told: Told | None = None
        for message in messages:
            told = self._wheels.after(told or self._told_wheels, message) or told
            self._note_pen(message)
        if told is None:
            self._host.send(*messages)
        else:
            self._steer(told, messages)
            self._expire(valid_s)
        await self._until(lambda: self._host.idle)

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
        def submit() -> None:
            self._host.send(*messages)
            self._told_wheels = told

        self._drive(self._wheels.motion(told), submit)
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

    def _made(self, name: str, what: str, **values: int) -> FrameMessage:
        if name not in self._types:
            raise NotSupportedError(f"the robot at {self.link.url} has no {what}: no {name} in its dialect")
        message: FrameMessage = cast("Any", self._types[name])(**values)
        self._dialect.check(message)
        return message

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
        if self._blocked and self._blocked == _way(planned):
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

    async def _hear_odometer(self) -> None:
        """After a motion: what the encoders say, if there are any."""
        if self._odometer.heard_at is not None:
            still_at = self.link.now()
            await self._until(
                lambda: (self._odometer.heard_at or 0.0) > still_at, still_at + self._settings.odometry_s
            )

    def _compare(self) -> None:
        """Put the reckoning right by the ticks that have just been reported."""
        account, track_mm = self.account, self._calibration.track_mm
        account.update(self.link.now())
        start, rolled_mm, rotated_deg = self._compared
        rolled_mm, rotated_deg = account.rolled_mm - rolled_mm, account.rotated_deg - rotated_deg
        half_mm = math.radians(rotated_deg) * track_mm / 2.0
        reckoned = Travel(rolled_mm + half_mm, rolled_mm - half_mm)
        travel = self._odometer.travelled(*reckoned)
        if travel != reckoned:
            if self._motions <= 1:
                account.place(motion(*travel, track_mm).after(start, 1.0))
            else:  # which of them it was, nobody knows
                off = (travel.left_mm - reckoned.left_mm, travel.right_mm - reckoned.right_mm)
                account.place(motion(*off, track_mm).after(account.robot, 1.0))
        self._compared = (account.robot, account.rolled_mm, account.rotated_deg)
        self._motions = 1 if account.is_moving else 0

    def _stand(self) -> Pose:
        """The turtle is where the robot is; there."""
        self.account.settle()
        return self.account.exact

    def _halt(self) -> None:
        self._told_wheels = Told()
        self._host.send(*self._wheels.messages(Told()))

    async def _move_pen(self, *, down: bool) -> None:
        if self._pen_servo is None:
            return
        for _ in range(self._settings.halts):
            await self._told(lambda: self._host.send(self._pen(down=down)))
        await self._pause(self._calibration.pen_s)

    def _pen(self, *, down: bool) -> FrameMessage:
        angle = self._calibration.pen_down_deg if down else self._calibration.pen_up_deg
        return self._made(SERVO, "servos", servo_id=self._pen_servo or 0, position_deg=angle)

    def _note_pen(self, message: FrameMessage) -> None:
        """Somebody may move the pen's servo by hand."""
        if message.name() != SERVO:
            return
        values, calibration = field_values(message), self._calibration
        if values["servo_id"] == self._pen_servo:
            angle = values["position_deg"]
            self.account.pen_down = abs(angle - calibration.pen_down_deg) < abs(
                angle - calibration.pen_up_deg
            )

    # ------------------------------------------------------------------ what comes from the robot

    def _on_event(self, event: FrameMessage) -> None:
        name = event.name()
        if name == ODOMETRY:
            values = field_values(event)
            ticks = (values["left_ticks"], values["right_ticks"])
            if not self._odometer.report(values["time_ms"], *ticks, self.link.now()):
                self._was_reset()
            if not self._is_holding:
                self._compare()
        elif name == STATUS:
            if not field_values(event)["bumper"]:
                self._blocked = None
            elif self._blocked is None and self.account.is_moving:
                self._bumped()

    def _was_reset(self) -> None:
        """It has forgotten what it was told, and where its pen was: it stands, and does not go on by itself."""
        account, url, now = self.account, self.link.url, self.link.now()
        if account.is_moving:
            first, last = account.robot, account.at(now)
            self._session.clear_alarm()
            self._out_of_time(now)
            middle = first._replace(x_mm=(first.x_mm + last.x_mm) / 2.0, y_mm=(first.y_mm + last.y_mm) / 2.0)
            account.place(middle._replace(heading_deg=last.heading_deg))
            self.trouble = PoseUncertainError(
                f"the robot at {url} was reset while it moved. It was stopped, between x {first.x_mm:.0f} mm, "
                f"y {first.y_mm:.0f} mm, heading {first.heading_deg:.0f} degrees and x {last.x_mm:.0f} mm, "
                f"y {last.y_mm:.0f} mm, heading {last.heading_deg:.0f} degrees. Nothing was resumed"
            )
        else:
            self._notify(f"the robot at {url} was reset; its pen is set as it was")
        self._compared, self._motions = (account.robot, account.rolled_mm, account.rotated_deg), 0
        if self._pen_servo is not None:
            self._host.send(self._pen(down=account.pen_down))

    def _bumped(self) -> None:
        """Something is in the way: stop, and tell whoever waits or comes next."""
        self._blocked = _way(self._wheels.motion(self._told_wheels)) or "front"
        self._session.clear_alarm()
        self._out_of_time(self.link.now())
        if self._odometer.heard_at is not None:
            self._compare()
        self.trouble = LimitReachedError(self._blocked, *self._stand())

    # ------------------------------------------------------------------ stopping, and what is known

    @property
    def _last_bytes_s(self) -> float:
        return self._stop_bytes * 10.0 / self._baud

    def abandon(self) -> None:
        """Stop at once, ahead of everything (F13); the turtle is where the robot is now. Raises ``LinkError``."""
        self._told_wheels = Told()
        super().abandon()

    def _out_of_time(self, now: float) -> None:
        self._told_wheels = Told()
        super()._out_of_time(now)

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


def _way(planned: Motion) -> str | None:
    """Which side goes first; None: the robot turns on the spot."""
    if abs(planned.speed_mm_per_s) < 1.0:
        return None
    return "front" if planned.speed_mm_per_s > 0.0 else "back"
