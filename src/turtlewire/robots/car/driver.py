"""A car over ``simple``: its own commands, by hand, and as a turtle (S5..S9)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol

from turtlewire.drive import checked
from turtlewire.errors import MessageError, NoReplyError, NotSupportedError, PoseUncertainError
from turtlewire.protocols.simple.events import Done, Event, GaveUp, InStep, LinkDead, OutOfStep
from turtlewire.protocols.simple.host import Host
from turtlewire.protocols.simple.messages import (
    EMERGENCY_STOP,
    LENGTH,
    DriveBackward,
    DriveForward,
    Headlights,
    SimpleCommand,
    SteerLeft,
    SteerRight,
    Stop,
)
from turtlewire.robots.calibration import FULL_PWM
from turtlewire.robots.car.motions import motions
from turtlewire.robots.car.settings import DEFAULTS, Settings, Statistics
from turtlewire.robots.car.turning import Turning
from turtlewire.robots.checks import check, check_hold, check_valid_s
from turtlewire.robots.timed.driver import AsyncTimedRobot
from turtlewire.trace import Paper

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.links.link import Link
    from turtlewire.robots.timed.reckoning import Motion

# Less is not worth a multi-point turn: the clocks of hosts leave about that much.
WORTH_DEG = 0.25
# A way back into step takes less than this, if the robot answers at all; at 9600 baud it is half a second.
PARTING_S = 1.5


class Road(Paper, Protocol):
    """The ground around a car that can be seen."""

    def follow(self, *, pen_down: bool | None) -> None:
        """From now on its way is drawn, as with a pen that is up or down; None: not at all."""


class AsyncCar(AsyncTimedRobot[Event]):
    """A car, driven asynchronously. ``turtlewire.connect_async`` makes one; it is an async context manager.

    Besides what ``AsyncTimedRobot`` says, methods raise ``NoReplyError`` when the car falls silent, or a command got
    lost too often, and ``PoseUncertainError`` when something got lost or damaged while the turtle drove (S8): the car
    has been stopped then, and the error says where it may be. Nothing resumes by itself.

    Args:
        link: to the car; the driver owns it from here on.
        settings: how to drive it.
        notify: told, in a sentence for people, what they should know and what is no error.
        paper: the ground around the car, where that can be seen (a simulated car): it shows where the turtle truly
            went. How the car manoeuvres in a multi-point turn is not shown, no more than any turn on the spot.
    """

    def __init__(
        self,
        link: Link,
        settings: Settings = DEFAULTS,
        notify: Callable[[str], None] = lambda _: None,
        paper: Road | None = None,
    ) -> None:
        self._settings = settings.checked()
        self._road = paper
        self._calibration = settings.calibration
        self._motions = motions(settings.calibration)
        self._straight = self._motions.straight
        self._turning = Turning(settings.calibration, settings.turn_space_mm)
        self._host = Host(
            baud=settings.baud,
            window=settings.window,
            reply_delay_s=settings.reply_delay_s,
            retries=settings.retries,
            boot_s=settings.boot_s,
            heartbeat_s=settings.heartbeat_s,
        )
        super().__init__(
            link,
            self._host,
            notify,
            paper,
            baud=settings.baud,
            stop_size=LENGTH,
            speed=settings.speed,
            tolerance_mm=settings.tolerance_mm,
            worth_deg=WORTH_DEG,
            settle_s=settings.calibration.settle_s,
            overrun_s=settings.calibration.overrun_s,
        )
        # What it was told last: PWM ahead or back, and steering, -255..255.
        self._motor = 0
        self._steer = 0
        # The command that began the motion, until the car has accepted it; and when something got lost.
        self._unconfirmed: SimpleCommand | None = None
        self._lost_at: float | None = None

    async def connect(self) -> None:
        """Get in step with the car, which stops it (S7); its place is home. Raises ``NoReplyError``."""
        self._session.start()
        try:
            self._host.connect(self.link.now())
            await self._get_ready()
            await self._restore()
        except BaseException:
            await self.let_go(self._last_bytes_s)
            raise
        self._reconnect(self._settings.reconnect_s)

    async def get_in_step(self) -> None:
        """The port is open again: stop the car (section 4), and get in step with it (S7)."""
        host, now = self._host, self.link.now()
        host.connect(now)
        host.emergency_stop(now)
        await self._session.until(lambda: host.in_step or host.dead)
        if host.dead:
            raise NoReplyError(f"the car at {self.link.url} does not answer")
        self._forget()
        self._found()

    async def _restore(self) -> None:
        if self._settings.pen_light:
            await self._move_pen(down=self.account.pen_down)

    # ------------------------------------------------------------------ the car's own commands

    async def motor(self, pwm: int, *, valid_s: float | None = None) -> None:
        """Drive ahead, or backwards when negative, until told otherwise; returns when the car has accepted it.

        Args:
            pwm: -255..255; 0 stands still and keeps the steering.
            valid_s: the car is stopped when no newer set-point has come for so long; None: it goes on.

        Raises ``MessageError`` for a number outside.
        """
        _check_pwm("pwm", pwm)
        if valid_s is not None:
            check_valid_s(valid_s)
        if not self._is_ready:
            await self._ready()
        self._drive(self._motions.motion(pwm, self._steer), lambda: self._submit_motor(pwm))
        self._expire(valid_s)
        await self._answered()

    async def steer(self, steering: int) -> None:
        """Turn the front wheels: -255 (full lock left) .. 255 (full lock right), until told otherwise.

        Returns when the car has accepted it. A ``valid_s`` given to ``motor`` or ``drive`` goes on counting. Raises
        ``MessageError`` for a number outside.
        """
        _check_pwm("steering", steering)
        if not self._is_ready:
            await self._ready()
        self._drive(self._motions.motion(self._motor, steering), lambda: self._submit_steer(steering))
        await self._answered()

    async def hold(self, pwm: int, steering: int, seconds: float, settle_s: float | None = None) -> None:
        """Turn the front wheels, drive for a time, and stand still again: the motion that calibration measures.

        Args:
            pwm: -255..255.
            steering: -255..255.
            seconds: above 0, at most 60, from when the car is told to drive to when it is told to stand still.
            settle_s: how long to wait after that, 0..60 seconds; None: as long as the calibration says.

        Afterwards the turtle is where the car is, by reckoning. Raises ``MessageError`` for a number outside.
        """
        _check_pwm("pwm", pwm)
        _check_pwm("steering", steering)
        check_hold(seconds, settle_s)
        await self._turtle_ready()
        await self._steer_to(steering)
        # What it coasts is a part of what is measured.
        held_s = seconds + self._calibration.overrun_s
        motion = self._motions.motion(pwm, steering)
        await self._hold(motion, held_s, lambda: self._submit_motor(pwm), settle_s=0.0)
        rest_s = self._calibration.settle_s if settle_s is None else settle_s
        await self._pause(self._session.arrived_at + rest_s - self.link.now())
        self.account.settle()

    async def turn_wheels(self, steering: int, seconds: float) -> None:
        """Turn the front wheels of the standing car, and wait, 0..60 seconds from when it is told.

        Raises ``MessageError`` for a number outside.
        """
        _check_pwm("steering", steering)
        check_hold(seconds or 1.0, seconds)
        await self._turtle_ready()
        arrived_at = await self._told(lambda: self._submit_steer(steering))
        await self._until(lambda: self._host.idle)
        await self._pause(arrived_at + seconds - self.link.now())

    async def headlights(
        self, *, left_upper: bool, left_lower: bool, right_upper: bool, right_lower: bool
    ) -> None:
        """Switch all four headlights; returns when the car has accepted it."""
        await self._ready()
        self._host.submit(Headlights(left_upper, left_lower, right_upper, right_lower))
        await self._until(lambda: self._host.idle)

    async def drive(self, speed: float, turn: float, *, valid_s: float | None = None) -> None:
        """Go on so until told otherwise: speed -1..1, steering -1 (left) .. 1 (right). See ``Drive.drive``."""
        checked("speed", speed)
        checked("turn", turn)
        check_valid_s(valid_s)
        await self._ready()
        pwm = int(math.copysign(self._calibration.curve(speed).portion(abs(speed)), speed))
        straight = self._straight
        steer = straight + round(turn * (FULL_PWM - straight if turn > 0.0 else FULL_PWM + straight))

        def submit() -> None:
            self._submit_steer(steer)
            self._submit_motor(pwm)

        self._drive(self._motions.motion(pwm, steer), submit)
        self._expire(valid_s)

    @property
    def features(self) -> frozenset[str]:
        """A car has headlights, which are the turtle's lamp, too."""
        return frozenset({"headlights", "lamp"})

    async def lamp(self, on: bool) -> None:
        """Switch all headlights on or off."""
        await self.headlights(left_upper=on, left_lower=on, right_upper=on, right_lower=on)

    # ------------------------------------------------------------------ what is known

    @property
    def turning_radius_mm(self) -> float:
        """The radius of the narrowest circle that the car can drive, of the middle of its rear axle."""
        return self._calibration.turning_radius_mm

    @property
    def statistics(self) -> Statistics:
        """Figures of this connection."""
        return Statistics(
            bytes_sent=self._session.bytes_sent,
            bytes_received=self._session.bytes_received,
            distance_mm=self.account.distance_mm,
            window_commands=self._settings.window,
            retries=self._host.resent,
            resynchronisations=self._host.resynchronisations,
            malformed_replies=self._host.malformed,
            unexpected_replies=self._host.unexpected,
            skipped_bytes=self._host.malformed,
            round_trip_median_s=self._host.round_trips.median_s,
            round_trip_max_s=self._host.round_trips.longest_s,
            reconnections=self._session.reconnections,
            seconds=self.link.now() - self.started,
        )

    # ------------------------------------------------------------------ as a turtle

    async def right(self, angle_deg: float) -> None:
        """Turn clockwise: by a multi-point turn that keeps the place, or with ``turn="arc"`` ahead in a circle."""
        if self._settings.turn == "spot":
            await super().right(angle_deg)
            return
        check("angle_deg", angle_deg)
        await self._turtle_ready()
        account = self.account
        account.turn(angle_deg)
        if account.owed_deg:
            steer = FULL_PWM if account.owed_deg > 0.0 else -FULL_PWM
            await self._drive_arc(1, steer, account.owed_deg, is_drawn=True)
        # Where the circle leads is where the turtle is: it cannot be made good on the spot.
        account.exact = account.robot._replace(heading_deg=account.exact.heading_deg)

    async def set_position(self, x_mm: float, y_mm: float) -> None:
        """Go straight to a point and keep the heading. Raises ``NotSupportedError`` with ``turn="arc"``."""
        self._need_spot("go to a point")
        await super().set_position(x_mm, y_mm)

    async def arc(self, angle_deg: float, radius_mm: float) -> None:
        """Draw a part of a circle around the turtle. Raises ``NotSupportedError`` with ``turn="arc"``."""
        self._need_spot("draw a circle around itself")
        await super().arc(angle_deg, radius_mm)

    def _need_spot(self, what: str) -> None:
        if self._settings.turn == "arc":
            raise NotSupportedError(
                f"a car that turns by driving in a circle (turn=arc) cannot {what}: its place changes as it turns. "
                "With turn=spot it can"
            )

    async def _turn_robot(self, angle_deg: float) -> None:
        if self._settings.turn == "arc":
            return  # the next turn makes it good
        # Each arc makes good what the one before was off by.
        owed = self.account.owed_deg
        for arc in self._turning.plan(angle_deg):
            owed -= arc.angle_deg
            turn = self.account.owed_deg - owed
            if turn * arc.angle_deg > 0.0:
                await self._drive_arc(arc.direction, arc.steer, turn, is_drawn=False)

    async def _drive_arc(self, direction: int, steer: int, angle_deg: float, *, is_drawn: bool) -> None:
        length = abs(math.radians(angle_deg) / self._calibration.curvature(steer))
        await self._steer_to(steer)
        motion, submit = self._moving(direction * length, steer)
        await self._hold(motion, abs(angle_deg / motion.turn_deg_per_s), submit, is_drawn=is_drawn)

    async def _hold(
        self,
        motion: Motion,
        seconds: float,
        submit: Callable[[], None],
        *,
        is_drawn: bool = True,
        settle_s: float | None = None,
    ) -> None:
        self._show(self.account.pen_down if is_drawn else None)
        await super()._hold(motion, seconds, submit, is_drawn=is_drawn, settle_s=settle_s)

    def _drive(self, motion: Motion, submit: Callable[[], None]) -> None:
        if self._road is not None:
            self._show(self.account.pen_down)
        super()._drive(motion, submit)

    def _show(self, pen_down: bool | None) -> None:
        """Have the way from now on drawn, where it can be seen."""
        if self._road is not None:
            self._road.follow(pen_down=pen_down)

    async def _move_robot(self, distance_mm: float) -> None:
        await self._steer_to(self._straight)
        motion, submit = self._moving(distance_mm, self._straight)
        await self._hold(motion, distance_mm / motion.speed_mm_per_s, submit)

    async def _steer_to(self, steer: int) -> None:
        """Turn the front wheels while the car stands, and give them the time that they take."""
        if steer == self._steer:
            return
        part = abs(steer - self._steer) / (2 * FULL_PWM)
        await self._told(lambda: self._submit_steer(steer))
        await self._until(lambda: self._host.idle)
        await self._pause(self._calibration.steer_s * part)

    def _moving(self, distance_mm: float, steer: int) -> tuple[Motion, Callable[[], None]]:
        """How to drive so far, backwards when negative: as fast as was set, or slower if it is not far."""
        curve = self._calibration.curve(distance_mm)
        pwm = curve.pwm(self._fitting(distance_mm, curve.full_mm_per_s))
        pwm = int(math.copysign(pwm, distance_mm))
        return self._motions.motion(pwm, steer), lambda: self._submit_motor(pwm)

    async def _move_pen(self, *, down: bool) -> None:
        if self._settings.pen_light:
            # Also before motion is allowed to go on.
            self._host.submit(
                Headlights(left_upper=False, left_lower=down, right_upper=False, right_lower=down)
            )
            await self._until(lambda: self._host.idle)

    # ------------------------------------------------------------------ set-points

    def _submit_motor(self, pwm: int) -> None:
        self._motor = pwm
        self._unconfirmed = DriveForward(pwm) if pwm >= 0 else DriveBackward(-pwm)
        self._host.submit(self._unconfirmed, tag=self._unconfirmed)

    def _submit_steer(self, steer: int) -> None:
        self._steer = steer
        self._host.submit(SteerRight(steer) if steer >= 0 else SteerLeft(-steer))

    def _halt(self) -> None:
        self._motor = 0
        self._host.submit(DriveForward(0))

    # ------------------------------------------------------------------ stopping, in step or not

    @property
    def _last_bytes_s(self) -> float:
        return len(EMERGENCY_STOP) * 10.0 / self._settings.baud

    def abandon(self) -> None:
        """Stop at once, ahead of everything; the turtle is where the car is now. Raises ``LinkError``."""
        self._forget()
        super().abandon()

    def _out_of_time(self, now: float) -> None:
        self._forget()
        super()._out_of_time(now)

    def _forget(self) -> None:
        """A stop ends drive and steering (S5)."""
        self._motor = self._steer = 0
        self._lost_at = None

    async def _part(self, last_bytes_s: float) -> None:
        """Section 4: ``S000000`` when in step, else S7 first; and if no reply comes, the bytes that stop any robot."""
        host = self._host
        self._stops += 1
        self._session.clear_alarm()
        self.account.end(self.link.now())
        try:
            host.submit(Stop())
            deadline = self.link.now() + PARTING_S
            await self._session.until(lambda: host.idle and (host.in_step or host.dead), deadline)
        finally:
            if not (host.idle and host.in_step):
                self.abandon()
                await self._session.until(lambda: False, self.link.now() + last_bytes_s)

    @property
    def _is_ready(self) -> bool:
        """Whether a command may go out at once: ``_ready`` has nothing to do, nor to raise."""
        return self._host.in_step and self.trouble is None and not self._closed and self._session.is_connected

    async def _get_ready(self) -> None:
        host = self._host
        if host.dead:
            host.emergency_stop(self.link.now())
        if not host.in_step:
            await self._until(lambda: host.in_step or host.dead)
        self._raise_trouble()

    def _on_event(self, event: Event) -> None:
        if isinstance(event, Done):
            if event.tag is self._unconfirmed:
                self._unconfirmed = None
        elif isinstance(event, OutOfStep):
            self._out_of_step(event)
        elif isinstance(event, InStep):
            self._in_step_again()
        elif isinstance(event, GaveUp):
            self._fail(
                f"{event.command} got lost on its way to the car at {self.link.url} again and again, and was given up; "
                f"the car: {event.state}"
            )
        elif isinstance(event, LinkDead) and self._lost is None:
            self._fail(
                f"the car at {self.link.url} cannot be talked to: {event.reason}. Whether it drives is not known. "
                f"Is it switched on, and is the baud rate {self._settings.baud} right?"
            )

    def _out_of_step(self, event: OutOfStep) -> None:
        """S8. A timed motion is over: the way back into step stops the car, and the motion must not be sent again."""
        now = self.link.now()
        if self._is_holding and self.account.is_moving:
            self._session.clear_alarm()
            self._lost_at = now
            self._host.submit(Stop())
        elif self._is_driven:
            self._notify(
                f"the car at {self.link.url} was stopped and set going again ({event.reason}): where it is, "
                "is less certain now"
            )

    def _in_step_again(self) -> None:
        """S7 is done: the car stands still."""
        if self._lost_at is None:
            return
        account, now = self.account, self.link.now()
        # Did the motion ever begin? Only its reply would have told. And did it end when it was told to?
        stopped_at = self._lost_at if self._ended_at is None else self._ended_at
        first = account.robot if self._unconfirmed is not None else account.at(stopped_at)
        last = account.at(now)
        account.end(now)
        middle = first._replace(x_mm=(first.x_mm + last.x_mm) / 2.0, y_mm=(first.y_mm + last.y_mm) / 2.0)
        account.place(middle._replace(heading_deg=last.heading_deg))
        self._motor = self._steer = 0
        self._lost_at = None
        self.trouble = PoseUncertainError(
            f"bytes got lost or damaged while the car at {self.link.url} drove. It was stopped, between "
            f"x {first.x_mm:.0f} mm, y {first.y_mm:.0f} mm, heading {first.heading_deg:.0f} degrees and "
            f"x {last.x_mm:.0f} mm, y {last.y_mm:.0f} mm, heading {last.heading_deg:.0f} degrees. "
            "Nothing was resumed"
        )

    def _fail(self, text: str) -> None:
        self.trouble = NoReplyError(text)
        self._session.clear_alarm()
        self._forget()
        self._is_driven = False
        self.account.end(self.link.now())
        self.account.settle()


def _check_pwm(name: str, value: object) -> None:
    if not isinstance(value, int) or not -FULL_PWM <= value <= FULL_PWM:
        raise MessageError(f"{name} is {value}, but must be a whole number from -{FULL_PWM} to {FULL_PWM}")
