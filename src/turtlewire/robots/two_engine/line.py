"""What goes over the wire to a two-engine robot, and what comes back: stops, its pen, odometry, bumpers (F9..F13)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, cast

from turtlewire.errors import LimitReachedError, NotSupportedError, PoseUncertainError, UsageError
from turtlewire.protocols.frame.codec import FrameEncoder
from turtlewire.protocols.frame.host import Host, stop_bytes
from turtlewire.protocols.frame.message import FrameMessage
from turtlewire.robots.timed.driver import AsyncTimedRobot
from turtlewire.robots.two_engine.odometry import Odometer, Travel
from turtlewire.robots.two_engine.settings import DEFAULTS, Settings
from turtlewire.robots.two_engine.wheels import Told, field_values, motion, wheels

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.links.link import Link
    from turtlewire.robots.paper import Paper
    from turtlewire.robots.timed.reckoning import Motion
    from turtlewire.turtle import Pose

# Less is not worth a turn.
WORTH_DEG = 0.05
# So often a robot that may be booting is told to stop.
BOOT_STOP_S = 0.5
SERVO = "set_servo_position"
ODOMETRY, STATUS = "odometry", "status"


class TwoEngineLine(AsyncTimedRobot[FrameMessage]):
    """What of the driver of a two-engine robot does not depend on where it is to go."""

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

    def _made(self, name: str, what: str, **values: int) -> FrameMessage:
        if name not in self._types:
            raise NotSupportedError(f"the robot at {self.link.url} has no {what}: no {name} in its dialect")
        message: FrameMessage = cast("Any", self._types[name])(**values)
        self._dialect.check(message)
        return message

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
        if self._pen_servo is not None and self._session.is_connected:  # else ``resume`` sees to it
            self._host.send(self._pen(down=account.pen_down))

    def _bumped(self) -> None:
        """Something is in the way: stop, and tell whoever waits or comes next."""
        self._blocked = way(self._wheels.motion(self._told_wheels)) or "front"
        self._session.clear_alarm()
        self._out_of_time(self.link.now())
        if self._odometer.heard_at is not None:
            self._compare()
        self.trouble = LimitReachedError(self._blocked, *self._stand())

    # ------------------------------------------------------------------ stopping

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


def way(planned: Motion) -> str | None:
    """Which side goes first; None: the robot turns on the spot."""
    if abs(planned.speed_mm_per_s) < 1.0:
        return None
    return "front" if planned.speed_mm_per_s > 0.0 else "back"
