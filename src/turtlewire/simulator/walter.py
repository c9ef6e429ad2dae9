"""A simulated WALTER: bytes in, bytes out, and in between a robot that takes its time.

Nothing ticks as long as it is alone in its world: every pose follows from the start of its motion (``body``).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import Mode, encode
from turtlewire.protocols.walter.robot import AtOnce, Robot
from turtlewire.simulator.body import Body, next_look_s
from turtlewire.simulator.chassis import Chassis
from turtlewire.simulator.drivetrain import Battery
from turtlewire.simulator.motion import Motion
from turtlewire.simulator.settings import FULL_SPEED, Action, Settings, Statistics
from turtlewire.simulator.walter_commands import Step, motions, reply, sensor
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from collections.abc import Iterator

    from turtlewire.simulator.world import Contact, Disc

__all__ = ["Action", "Settings", "SimulatedWalter", "Statistics"]


class SimulatedWalter(Body[Settings]):
    """One robot, its line and its time.

    Attributes:
        speed: linear speed, 0..255.
        turn_speed: turning speed, 0..255.
        horn: ``"off"``, ``"low"`` or ``"high"``.
        lamp: whether it is on.
        pen_is_down: whether the pen is on the ground (it follows its command by ``pen_s``).
    """

    def __init__(self, settings: Settings | None = None) -> None:
        settings = settings or Settings()
        super().__init__(settings)
        self.speed = self.turn_speed = settings.speed
        self.horn = "off"
        self.lamp = False
        self.pen_is_down = settings.pen_down
        self._end = Robot(settings.mode, settings.groups)
        self._chassis = Chassis(
            settings.radius_mm, settings.track_mm, settings.slip, settings.noise, settings.seed
        )
        self._battery = Battery(settings.sag, settings.battery_s)
        self._motion: Motion | None = None
        # When to look for other robots in the way next, while it moves among some.
        self._look_s = math.inf
        # The command (or key) that moves the robot, and what is left of it.
        self._doing: m.WalterMessage | None = None
        self._steps: Iterator[Step] | None = None
        self._pen_target = settings.pen_down
        self._pen_s = math.inf
        self._commands = self._refused = self._limits = 0
        self._distance_mm = self._turned_deg = self._rotated_deg = 0.0

    # What is to be seen of it

    @property
    def mode(self) -> Mode:
        """Logo control or direct control."""
        return self._end.mode

    @property
    def is_moving(self) -> bool:
        """Whether the wheels turn."""
        return self._motion is not None and self._motion.rate > 0.0

    @property
    def pose(self) -> Pose:
        """Where it truly is on the ground."""
        motion = self._motion
        return motion.true_pose(motion.progress(self.now)) if motion else self._true

    @property
    def odometer(self) -> Pose:
        """Where it is by what its wheels have turned: what it tells the host."""
        motion = self._motion
        return motion.odometer_pose(motion.progress(self.now)) if motion else self._odometer

    @property
    def rotated_deg(self) -> float:
        """How far it has turned on the spot since power-on, clockwise less counter-clockwise."""
        motion = self._motion
        if motion is None or not motion.turning:
            return self._rotated_deg
        return self._rotated_deg + self._turned_by(motion)

    def _turned_by(self, motion: Motion) -> float:
        turned = math.copysign(motion.progress(self.now), motion.amount)
        return turned * self.settings.turn_scale

    @property
    def statistics(self) -> Statistics:
        """What it has done since power-on, up to now."""
        distance_mm, turned_deg = self._distance_mm, self._turned_deg
        if self._motion is not None and self._motion.turning:
            turned_deg += self._motion.progress(self.now)
        elif self._motion is not None:
            distance_mm += self._motion.progress(self.now)
        return Statistics(
            self._commands,
            self._bytes_in,
            self._bytes_out,
            self._lost_bytes,
            self._end.malformed,
            self._end.overflowed,
            self._refused,
            self._limits,
            self._watchdog_stops,
            distance_mm,
            turned_deg,
        )

    def claims(self) -> tuple[Disc, ...]:
        """The ground that nobody else may enter now: where it is, and where it is about to be."""
        motion, here = self._motion, self.disc()
        if motion is None or self._look_s == math.inf:
            return (here,)
        there = motion.true_pose(motion.progress(self._look_s))
        return (here, here._replace(x_mm=there.x_mm, y_mm=there.y_mm))

    @property
    def _inks(self) -> bool:
        return self.pen_is_down

    def _undrawn(self) -> list[Pose]:
        return self._motion.undrawn(self._motion.progress(self.now)) if self._motion else []

    # Time

    def _next_s(self) -> float:
        at = min(self._pen_s, self._look_s)
        return self._motion.end_s if self._motion is not None and self._motion.end_s < at else at

    def _is_settled(self) -> bool:
        motion = self._motion
        if self._pen_s < math.inf or motion is None:
            return self._pen_s == math.inf
        return motion.end_s == math.inf or (motion.continues and motion.contact is None)

    def _act(self) -> bool:
        if self._pen_s <= self.now:
            self._pen_has_moved()
        elif self._motion is not None and self._motion.end_s <= self.now:
            self._motion_is_over(self._motion)
        elif self._motion is not None and self._look_s <= self.now:
            self._look_out(self._motion)
        else:
            return False
        return True

    def _understand(self, byte: int) -> bool:
        heard = self._end.heard
        for message in self._end.receive_data(bytes([byte])):
            self._commands += 1
            self._act_at_once(message)
        return self._end.heard > heard

    def _is_busy(self) -> bool:
        return self._doing is not None or self._end.queued > 0

    def _tell_of(self, what: str) -> None:
        if self.events is not None:
            self.events(Action(self.now, f"{what} {self._doing}"))

    # Motion

    def _start(self, turning: bool, amount: float) -> None:
        settings = self.settings
        scale = settings.turn_scale if turning else settings.distance_scale
        motion = Motion(
            self._chassis,
            settings.world,
            self._true,
            self._odometer,
            turning=turning,
            amount=amount,
            scale=scale,
        )
        self._motion = motion
        self._set_rate()
        self._look_out(motion)
        if motion.contact is not None and motion.is_refused:
            self._motion, self._look_s = None, math.inf
            self._refused += 1
            self._tell_of("refused")
            self._trip(motion.contact)

    def _look_out(self, motion: Motion) -> None:
        """See whether another robot is in the way that it goes until it looks again."""
        self._look_s = math.inf
        if not self.others or not motion.rate:
            return
        self._look_s = next_look_s(self.now)
        now, soon = motion.progress(self.now), motion.progress(self._look_s)
        here, there = motion.true_pose(now), motion.true_pose(soon)
        found = self._met_on(here, there)
        if found is not None:
            part, contact = found
            motion.stop_short(now + (soon - now) * part, contact)
            motion.set_rate(motion.rate, self.now)

    def _set_rate(self) -> None:
        """Let the motion under way follow the speed that is set now."""
        motion = self._motion
        if motion is None:
            return
        speed = self.turn_speed if motion.turning else self.speed
        settings = self.settings
        each = (
            settings.deg_per_s_per_unit / settings.turn_scale
            if motion.turning
            else settings.mm_per_s_per_unit / settings.distance_scale
        )
        motion.set_rate(speed * each * self._battery.draw(speed / FULL_SPEED, self.now), self.now)

    def _draw(self) -> None:
        super()._draw()
        if self._motion is not None:
            self._motion.mark_drawn(self._motion.progress(self.now))

    def _halt(self) -> None:
        """The motion under way, if any, ends where it is."""
        motion = self._motion
        if motion is None:
            return
        self._draw()
        progress = motion.progress(self.now)
        self._true, self._odometer = motion.true_pose(progress), motion.odometer_pose(progress)
        if motion.turning:
            self._turned_deg += progress
            self._rotated_deg += self._turned_by(motion)
        else:
            self._distance_mm += progress
        self._motion = None
        self._look_s = math.inf
        self._battery.draw(0.0, self.now)

    def _motion_is_over(self, motion: Motion) -> None:
        self._halt()
        if motion.contact is not None:
            self._tell_of("stopped")
            self._trip(motion.contact)
        elif motion.continues:
            self._start(motion.turning, motion.amount)

    def _trip(self, contact: Contact) -> None:
        """W13: stop, forget the queue, tell the host."""
        tripped = sensor(contact.bearing_deg - self._true.heading_deg)
        self._limits += 1
        self._doing = self._steps = None
        self._tell(f"limit {tripped}")
        self._send(self._end.limit_tripped(tripped))

    def _abandon(self) -> None:
        """Stop where it is and forget everything that was to come."""
        self._halt()
        if self._doing is not None:
            self._tell_of("stopped")
        self._doing = self._steps = None
        while self._end.next_command() is not None:
            pass

    def _reset(self) -> None:
        super()._reset()
        self._end = Robot(self.settings.mode, self.settings.groups)
        self.speed = self.turn_speed = self.settings.speed
        self.horn, self.lamp = "off", False

    def _set_pen(self, *, down: bool) -> None:
        if down != self._pen_target:
            self._pen_target = down
            self._pen_s = self.now + self.settings.pen_s

    def _pen_has_moved(self) -> None:
        self._draw()
        self._pen_s = math.inf
        self.pen_is_down = self._pen_target
        self._tell("pen down" if self.pen_is_down else "pen up")

    # Direct control

    def _act_at_once(self, message: AtOnce) -> None:
        match message:
            case m.SelectDirect() | m.Stop() | m.SelectLogo():
                self._abandon()
            case m.StartForward():
                self._drive(message, turning=False, amount=math.inf)
            case m.StartBackward():
                self._drive(message, turning=False, amount=-math.inf)
            case m.StartLeft():
                self._drive(message, turning=True, amount=-math.inf)
            case m.StartRight():
                self._drive(message, turning=True, amount=math.inf)
            case m.MoveFaster():
                self.speed = min(FULL_SPEED, self.speed + 1)
            case m.MoveSlower():
                self.speed = max(0, self.speed - 1)
            case m.TurnFaster():
                self.turn_speed = min(FULL_SPEED, self.turn_speed + 1)
            case m.TurnSlower():
                self.turn_speed = max(0, self.turn_speed - 1)
            case m.SetMoveSpeed():
                self.speed = message.speed
            case m.SetTurnSpeed():
                self.turn_speed = message.speed
            case m.RaisePen():
                self._set_pen(down=False)
            case m.LowerPen():
                self._set_pen(down=True)
        self._set_rate()
        if self._motion is not None:
            self._look_out(self._motion)

    def _drive(self, key: AtOnce, *, turning: bool, amount: float) -> None:
        self._abandon()
        self._doing = key
        self._tell_of("started")
        self._start(turning, amount)

    # Logo control

    def _go_on(self) -> None:
        """Carry out what waits, until something takes time (W9: in order, one after the other)."""
        while self._motion is None and self._pen_s == math.inf:
            if self._steps is not None:
                step = next(self._steps, None)
                if step is not None:
                    self._start(*step)
                    continue
                self._tell_of("ended")
                self._doing = self._steps = None
            command = self._end.next_command()
            if command is None:
                return
            self._commands += 1
            self._carry_out(command)

    def _carry_out(self, command: m.LogoCommand) -> None:
        match command:
            case m.SetSpeed():
                self.speed = self.turn_speed = command.speed
            case m.PenUp():
                self._set_pen(down=False)
            case m.PenDown():
                self._set_pen(down=True)
            case m.HornOff():
                self._set_horn("off")
            case m.HornLow():
                self._set_horn("low")
            case m.HornHigh():
                self._set_horn("high")
            case m.LampOn():
                self._set_lamp(on=True)
            case m.LampOff():
                self._set_lamp(on=False)
            case m.ResetLocation():
                self._odometer = Pose(0.0, 0.0, self._odometer.heading_deg)
            case _:
                answer = reply(command, self._odometer, pen_down=self._pen_target)
                if answer is not None:
                    self._send(encode(answer))
                    return
                self._doing = command
                self._steps = motions(command, lambda: self._odometer)
                self._tell_of("started")

    def _set_horn(self, tone: str) -> None:
        self.horn = tone
        self._tell(f"horn {tone}")

    def _set_lamp(self, *, on: bool) -> None:
        self.lamp = on
        self._tell("lamp on" if on else "lamp off")
