"""A car over ``simple``: its own commands, by hand, and as a turtle (S5..S9)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from turtlewire.drive import checked
from turtlewire.errors import MessageError, NotSupportedError
from turtlewire.protocols.simple.messages import (
    DriveBackward,
    DriveForward,
    Headlights,
    SimpleCommand,
    SteerLeft,
    SteerRight,
    Stop,
)
from turtlewire.robots.calibration import FULL_PWM
from turtlewire.robots.car.line import CarLine
from turtlewire.robots.car.settings import Statistics
from turtlewire.robots.checks import check, check_hold, check_valid_s

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.protocols.message import AnyMessage
    from turtlewire.robots.timed.reckoning import Motion


class AsyncCar(CarLine):
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
        self._begin_by_hand()
        self._submit_motor(pwm)
        self._session.flush()
        self._driven(self._motions.motion(pwm, self._steer))
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
        self._begin_by_hand()
        self._submit_steer(steering)
        self._session.flush()
        self._driven(self._motions.motion(self._motor, steering))
        await self._answered()

    async def send(self, *messages: AnyMessage, valid_s: float | None = None) -> None:
        """Send commands; returns when the car has accepted all of them. See ``AsyncRobot.send``."""
        check_valid_s(valid_s)
        for message in [_sendable(message) for message in messages]:
            match message:
                case DriveForward(speed) | DriveBackward(speed):
                    await self.motor(message.SIGN * speed, valid_s=valid_s)
                case SteerLeft(lock) | SteerRight(lock):
                    await self.steer(message.SIGN * lock)
                case Stop():
                    await self.stop()
                    await self._get_ready()
                case _:
                    await self._ready()
                    self._host.submit(message)
                    await self._until(lambda: self._host.idle)

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
        self._begin_by_hand()
        self._submit_steer(steer)
        self._submit_motor(pwm)
        self._session.flush()
        self._driven(self._motions.motion(pwm, steer))
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

    def _begin_by_hand(self) -> None:
        if self._is_holding:
            self._take_wheel()
        if self._road is not None:
            self._show(self.account.pen_down)

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


def _sendable(message: AnyMessage) -> SimpleCommand:
    if not isinstance(message, SimpleCommand):
        raise MessageError(f"{message.name()} is what a car says, or no message of its protocol")
    return message.check()


def _check_pwm(name: str, value: object) -> None:
    if not isinstance(value, int) or not -FULL_PWM <= value <= FULL_PWM:
        raise MessageError(f"{name} is {value}, but must be a whole number from -{FULL_PWM} to {FULL_PWM}")
