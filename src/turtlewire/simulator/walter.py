"""A simulated WALTER: bytes in, bytes out, and in between a robot that takes its time (PROTOCOLS.md section 3).

Time is virtual and nothing ticks: the robot goes from one event to the next (a byte has arrived, a motion has ended),
and every pose follows from the start of its motion. Hence it is as fast as the processor, and the same settings and
the same bytes at the same times give the same result bit for bit, however the calls cut them up.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import Mode, encode
from turtlewire.protocols.walter.robot import AtOnce, Robot
from turtlewire.simulator.chassis import Chassis
from turtlewire.simulator.line import Line
from turtlewire.simulator.motion import Motion
from turtlewire.simulator.settings import FULL_SPEED, Action, Settings, Statistics
from turtlewire.simulator.walter_commands import Step, motions, reply, sensor
from turtlewire.trace import Trace
from turtlewire.turtle import HOME, Pose

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from turtlewire.simulator.world import Contact, Wall

__all__ = ["Action", "Settings", "SimulatedWalter", "Statistics"]


class SimulatedWalter:
    """One robot, its line and its time.

    Attributes:
        now: seconds of the robot's time since power-on.
        events: called with each ``Action``, or None.
        speed: linear speed, 0..255.
        turn_speed: turning speed, 0..255.
        horn: ``"off"``, ``"low"`` or ``"high"``.
        lamp: whether it is on.
        pen_is_down: whether the pen is on the ground (it follows its command by ``pen_s``).
    """

    def __init__(self, settings: Settings | None = None) -> None:
        self.settings = settings = settings or Settings()
        self.now = 0.0
        self.events: Callable[[Action], object] | None = None
        self.speed = self.turn_speed = settings.speed
        self.horn = "off"
        self.lamp = False
        self.pen_is_down = settings.pen_down
        self._end = Robot(settings.mode, settings.groups)
        self._chassis = Chassis(
            settings.radius_mm, settings.track_mm, settings.slip, settings.noise, settings.seed
        )
        self._from_host = Line(settings.baud)
        self._to_host = Line(settings.baud)
        self._true = (settings.start or settings.world.start).turned(0.0)  # its heading may be any number
        self._odometer = HOME
        self._trace = Trace(self._true)
        self._motion: Motion | None = None
        # The command (or key) that moves the robot, and what is left of it.
        self._doing: m.WalterMessage | None = None
        self._steps: Iterator[Step] | None = None
        self._pen_target = settings.pen_down
        self._pen_s = math.inf
        self._heard_s = 0.0
        self._commands = self._bytes_in = self._bytes_out = self._lost_bytes = 0
        self._refused = self._limits = self._watchdog_stops = 0
        self._distance_mm = self._turned_deg = 0.0

    # The line

    def write(self, data: bytes) -> None:
        """The host puts bytes on the line now; they arrive one by one, behind those still going out."""
        self._from_host.write(data, self.now)

    def discard_output(self) -> None:
        """The host drops its bytes that have not begun to go out."""
        self._from_host.discard(self.now)

    @property
    def bytes_on_line(self) -> int:
        """How many of the host's bytes have not arrived."""
        return len(self._from_host)

    def read(self, until: float) -> bytes:
        """Let time pass until something has arrived for the host, or until ``until``; return what has arrived.

        b"" when only time has passed. With ``until`` infinite, time stops where nothing will happen any more.
        """
        arrived = b""
        until = max(until, self.now)
        while (at := self.next_event()) <= until:
            if at == math.inf or (until == math.inf and self._drives_for_ever(at)):
                return arrived
            self.now = max(self.now, at)
            self._happen()
            data = self._to_host.read(self.now)
            if data:
                arrived += data
                until = self.now
        if not arrived:
            self.now = until
        return arrived

    def next_event(self) -> float:
        """When something happens next by itself, in seconds of the robot's time; infinite: nothing will."""
        at = min(self._from_host.next_s, self._to_host.next_s, self._pen_s)
        if self._motion is not None and self._motion.end_s < at:
            at = self._motion.end_s
        if self.settings.watchdog_s is not None:
            at = min(at, self._watchdog_at())
        return at

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
    def trace(self) -> Trace:
        """What the pen has truly drawn on the ground up to now; a trace of its own while the robot moves."""
        if not self._motion:
            return self._trace
        return self._motion.drawn(self._trace, self._motion.progress(self.now), pen_down=self.pen_is_down)

    @property
    def walls(self) -> Sequence[Wall]:
        """What stands around it."""
        return self.settings.world.walls

    def clear_trace(self) -> None:
        """A new sheet: forget what has been drawn up to now."""
        self._draw()
        self._trace.clear()

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

    # Time

    def _happen(self) -> None:
        """Let one thing happen that is due now. What ends, ends before a byte that arrives at the same time acts."""
        now = self.now
        if self._pen_s <= now:
            self._pen_has_moved()
        elif self._motion is not None and self._motion.end_s <= now:
            self._motion_is_over(self._motion)
        elif self._from_host.next_s <= now:
            self._receive(self._from_host.read_byte())
        elif self._watchdog_at() <= now:
            self._watchdog_stops += 1
            self._tell("watchdog")
            self._abandon()
        self._go_on()

    def _receive(self, byte: int) -> None:
        if self.now < self.settings.boot_s:
            self._lost_bytes += 1
            return
        self._bytes_in += 1
        heard = self._end.heard
        for message in self._end.receive_data(bytes([byte])):
            self._commands += 1
            self._act_at_once(message)
        if self._end.heard > heard:
            self._heard_s = self.now

    def _watchdog_at(self) -> float:
        """When the watchdog stops the robot unless something is heard (section 4)."""
        is_busy = self._doing is not None or self._end.queued
        if self.settings.watchdog_s is None or not is_busy:
            return math.inf
        return self._heard_s + self.settings.watchdog_s

    def _drives_for_ever(self, at: float) -> bool:
        """Whether all that happens is that an endless motion goes on into its next piece."""
        motion = self._motion
        return motion is not None and motion.continues and motion.contact is None and motion.end_s == at

    def _tell(self, what: str) -> None:
        if self.events is not None:
            self.events(Action(self.now, what))

    def _tell_of(self, what: str) -> None:
        if self.events is not None:
            self.events(Action(self.now, f"{what} {self._doing}"))

    def _send(self, data: bytes) -> None:
        self._bytes_out += len(data)
        self._to_host.write(data, self.now)

    # Motion

    def _start(self, turning: bool, amount: float) -> None:
        world = self.settings.world
        motion = Motion(self._chassis, world, self._true, self._odometer, turning=turning, amount=amount)
        if motion.contact is not None and motion.is_refused:
            self._refused += 1
            self._tell_of("refused")
            self._trip(motion.contact)
            return
        self._motion = motion
        self._set_rate()

    def _set_rate(self) -> None:
        """Let the motion under way follow the speed that is set now."""
        motion = self._motion
        if motion is None:
            return
        if motion.turning:
            motion.set_rate(self.turn_speed * self.settings.deg_per_s_per_unit, self.now)
        else:
            motion.set_rate(self.speed * self.settings.mm_per_s_per_unit, self.now)

    def _draw(self) -> None:
        if self._motion is not None:
            self._motion.draw(self._trace, self._motion.progress(self.now), pen_down=self.pen_is_down)

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
        else:
            self._distance_mm += progress
        self._motion = None

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
