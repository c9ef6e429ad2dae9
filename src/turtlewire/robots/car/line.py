"""What goes over the wire to a car, and what comes back: set-points, stops, and ways back into step (S7, S8)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from turtlewire.errors import NoReplyError, PoseUncertainError
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
from turtlewire.robots.car.motions import motions
from turtlewire.robots.car.settings import DEFAULTS, Settings
from turtlewire.robots.car.turning import Turning
from turtlewire.robots.paper import Paper
from turtlewire.robots.timed.driver import AsyncTimedRobot

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.links.link import Link

# Less is not worth a multi-point turn: the clocks of hosts leave about that much.
WORTH_DEG = 0.25
# A way back into step takes less than this, if the robot answers at all; at 9600 baud it is half a second.
PARTING_S = 1.5


class Road(Paper, Protocol):
    """The ground around a car that can be seen."""

    def follow(self, *, pen_down: bool | None) -> None:
        """From now on its way is drawn, as with a pen that is up or down; None: not at all."""


class CarLine(AsyncTimedRobot[Event]):
    """What of the driver of a car does not depend on where it is to go."""

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
