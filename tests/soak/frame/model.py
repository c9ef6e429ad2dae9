"""What the robot's host sends and what the robot makes of it: followed frame by frame."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, Any, ClassVar

from tests.soak.domains import FLAG, Domain, one_of
from tests.soak.frame.reference import (
    FORMS,
    HEADER,
    LONGEST,
    MAGIC,
    TIMEOUT_S,
    Reference,
    Said,
    Unit,
    crc8,
    spell,
)
from tests.soak.soak import Soak
from tests.soak.timed import TimedSoak
from tests.soak.wire import Mark, ViolationError, WatchedFrameRobot
from turtlewire.protocols.frame.dialect import shipped
from turtlewire.robots.two_engine import AsyncTwoEngine, Settings
from turtlewire.simulator.frame_robot import FrameRobotSettings

if TYPE_CHECKING:
    from tests.soak.wire import Tap
    from turtlewire.links.faults import Faults
    from turtlewire.protocols.frame.host import Host
    from turtlewire.protocols.frame.message import FrameMessage
    from turtlewire.simulator.settings import Action

REPEAT_S = 0.2
HEARTBEAT_S = 0.3
WATCHDOG_S = 1.0


class FrameModel(TimedSoak):
    """A two-engine robot, its driver, and the model of both."""

    NAME = "frame"
    SETUP: ClassVar[dict[str, Domain]] = Soak.SETUP | {
        "dialect": one_of("0.1", "0.1", "telemetry"),
        "watchdog": FLAG,
        "halts": one_of(1, 2, 2, 3),
        "delay_s": one_of(0.0, 0.0, 0.002),
        "split": one_of(0, 0, 1, 5),
    }

    def __init__(self, seed: int, faults: Faults, **setup: Any) -> None:
        self._forms = FORMS[setup["dialect"]]
        # All frames that were ever sent, by whichever link, and which of them each byte belongs to.
        self._units: list[Unit] = []
        self._unit_of: list[Unit] = []
        self._latest_of: dict[tuple[str, int], Unit] = {}
        self._latest_executed = -1
        super().__init__(seed, faults, **setup)

    # ------------------------------------------------------------------ both ends

    def new_robot(self) -> WatchedFrameRobot:
        robot = WatchedFrameRobot(
            FrameRobotSettings(
                dialect=shipped(self.setup["dialect"]),
                boot_s=self.setup["boot_s"],
                watchdog_s=WATCHDOG_S if self.setup["watchdog"] else None,
            )
        )
        robot.events = self._acted
        self._switch_on()
        return robot

    def _switch_on(self) -> None:
        """What the robot knows, and has heard, when it has been switched on."""
        self._reference = Reference()
        self._expected: deque[str] = deque()
        # Frames that have arrived whole: unit, how many bytes have followed, and when; and what may become another.
        self._whole: deque[list[Any]] = deque()
        self._run: list[Mark] = []
        self._arrived_s = -math.inf
        self._truth: dict[tuple[str, int], tuple[str, tuple[Any, ...]]] = {}
        # Channels that a false frame, the watchdog or a reset has changed last.
        self._falsified: set[tuple[str, int]] = set()

    def new_driver(self, link: Tap) -> AsyncTwoEngine:
        self.end.on_arrival = self._arrived
        self._faults = self._faults._replace(delay_s=self.setup["delay_s"], split=self.setup["split"])
        self.mischief.change(delay_s=self._faults.delay_s, split=self._faults.split)
        driver = AsyncTwoEngine(
            link,
            Settings(
                dialect=shipped(self.setup["dialect"]),
                boot_s=0.0,
                halts=self.setup["halts"],
                repeat_s=REPEAT_S,
                heartbeat_s=HEARTBEAT_S if self.setup["watchdog"] else None,
            ),
            self.notify,
        )
        link.on_write = self._sent
        # What the newest set-points are, and what has been handed over and not been sent: by channel, oldest first.
        self._newest: dict[tuple[str, int], Said] = {}
        self._unsent: dict[tuple[str, int], Said] = {}
        self._commands: deque[Said] = deque()
        self._next_seq: int | None = None
        self._damaged_s = self.now
        self._damage_seen = self.damage
        self._host: Host = driver._host
        host = vars(self._host)
        self._send, host["send"] = self._host.send, self._handed_over
        self._stop_host, host["emergency_stop"] = self._host.emergency_stop, self._stopped
        self._end_link, host["link_lost"] = self._host.link_lost, self._link_lost
        return driver

    def robot_was_reset(self) -> None:
        self._switch_on()
        self._falsified |= self._newest.keys()

    # ------------------------------------------------------------------ what the host sends

    def _handed_over(self, *messages: FrameMessage) -> None:
        self._send(*messages)
        for message in messages:
            type_, form = next((t, f) for t, f in self._forms.items() if f.name == message.name())
            del type_
            said = Said(form, tuple(message.values()))
            if form.channel:
                self._newest[said.channel] = said
                self._unsent.pop(said.channel, None)
                self._unsent[said.channel] = said
            else:
                self._commands.append(said)

    def _stopped(self, now: float) -> None:
        self._forget()
        self._stop_host(now)

    def _link_lost(self, now: float) -> list[FrameMessage]:
        self._forget()
        return self._end_link(now)

    def _forget(self) -> None:
        self._newest.clear()
        self._unsent.clear()
        self._commands.clear()

    def _sent(self, first: int, data: bytes, urgent: bool) -> None:
        """Every frame has the newest set-points, commands in order, or a stop; and the next number."""
        self._look_for_damage()
        at = 0
        while at < len(data):
            size = data[at + 2] + HEADER + 1
            frame = data[at : at + size]
            said = spell(frame[HEADER:-1], self._forms)
            if frame[0] != MAGIC or crc8(frame[:-1]) != frame[-1] or said is None:
                raise ViolationError(f"the host sent {frame!r}, which is no frame")
            unit = Unit(len(self._units), first + at, frame, said)
            self._units.append(unit)
            self._unit_of += [unit] * size
            self._latest_of |= {each.channel: unit for each in said}
            self.report.wire_commands += 1
            if not urgent:
                self._check_number(frame[1])
                self._check_newest(said)
            self._next_seq = (frame[1] + 1) % 256
            at += size
        if urgent:
            self._check_stop(data)

    def _look_for_damage(self) -> None:
        if self.damage != self._damage_seen or self.now < self.unrest_until_s:
            self._damage_seen, self._damaged_s = self.damage, self.now

    def _check_number(self, seq: int) -> None:
        if self._next_seq is not None and seq != self._next_seq:
            raise ViolationError(f"frame {seq} was sent, where {self._next_seq} was due")

    def _check_newest(self, said: list[Said]) -> None:
        for each in said:
            if not each.form.channel:
                if not self._commands or self._commands.popleft() != each:
                    raise ViolationError(f"{each.text} was sent, which is not the next command")
            elif self._newest.get(each.channel) != each:
                raise ViolationError(
                    f"{each.text} was sent, but the newest is {self._newest.get(each.channel)}"
                )
            else:
                self._unsent.pop(each.channel, None)

    def _check_stop(self, data: bytes) -> None:
        """F13: for 128 bytes and two frames more, all engines stand."""
        frames = self._units[self._unit_of[self.tap.sent - len(data)].number :]
        for unit in frames:
            if len(unit.said) != (2 if self.setup["dialect"] == "0.1" else 1):
                raise ViolationError(f"{unit.data!r} does not stop all engines")
            for each in unit.said:
                if each.form.channel not in ("engine", "wheels") or any(each.values[each.form.key :]):
                    raise ViolationError(f"{each.text} is no stop")
        if sum(len(unit.data) for unit in frames[:-2]) < LONGEST:
            raise ViolationError(f"{len(data)} bytes are not enough to stop any robot")

    # ------------------------------------------------------------------ what the robot makes of it

    def _arrived(self, byte: int, mark: Mark) -> None:
        if self._expected:
            raise ViolationError(f"the robot did not carry out {self._expected[0]!r}")
        now = self.now
        self._follow(mark, now)
        for frame in self._reference.arrived(byte, mark, now):
            self._complete(frame)
        for whole in self._whole:
            whole[1] += 1
        if self._whole and self._whole[0][1] >= LONGEST:
            raise ViolationError(
                f"{self._whole[0][0].data!r} has arrived, and is not carried out 127 bytes later"
            )

    def _follow(self, mark: Mark, now: float) -> None:
        """Does a frame arrive whole?"""
        run = self._run
        if now >= self._arrived_s + TIMEOUT_S or mark.fault or (run and mark.number != run[-1].number + 1):
            run.clear()
        self._arrived_s = now
        if mark.fault:
            return
        unit = self._unit_of[mark.number]
        if mark.number == unit.first:
            run.clear()
        elif not run:
            return
        run.append(mark)
        if len(run) == len(unit.data):
            self._whole.append([unit, 0, now])
            run.clear()

    def _complete(self, frame: list[tuple[int, Mark]]) -> None:
        raw, marks = bytes(b for b, _ in frame), [m for _, m in frame]
        said = spell(raw[HEADER:-1], self._forms)
        for each in said or ():
            self._expected.append(each.text)
            self._truth[each.channel] = (each.form.name, each.values)
            self._falsified.add(each.channel)
        unit = self._unit_of[marks[0].number] if marks[0].number >= 0 else None
        if unit and [Mark(unit.first + n) for n in range(len(unit.data))] == marks:
            if unit.executed or unit.number < self._latest_executed:
                raise ViolationError(f"{unit.data!r} was carried out twice, or too late")
            unit.executed = True
            self._latest_executed = unit.number
            self.report.executed += 1
            self._falsified -= {each.channel for each in said or ()}
            while self._whole and self._whole[0][0].number < unit.number:
                raise ViolationError(f"{self._whole[0][0].data!r} arrived, and was passed over")
            _, bytes_held, since_s = self._whole.popleft()
            if bytes_held:
                self._held_back(bytes_held, self.now - since_s)
            return
        self.uncatchable(self._what_happened(marks, said))
        numbers = {m.number for m in marks}
        for whole in list(self._whole):
            if numbers & set(range(whole[0].first, whole[0].first + len(whole[0].data))):
                self._whole.remove(whole)
                self.uncatchable("a whole frame swallowed by a false one")
        if self._run and numbers & {m.number for m in self._run}:
            self._run.clear()
            self.uncatchable("a whole frame swallowed by a false one")

    def _held_back(self, size: int, seconds: float) -> None:
        """F5: a false beginning holds good frames back, for a frame's worth of bytes or a pause."""
        report = self.report
        report.recoveries += 1
        report.noticed["frames held back by a false beginning"] += 1
        report.worst_bytes, report.worst_s = max(report.worst_bytes, size), max(report.worst_s, seconds)

    def _what_happened(self, marks: list[Mark], said: list[Said] | None) -> str:
        units = {self._unit_of[m.number].number for m in marks if m.number >= 0}
        made = "ignored" if said is None else "empty" if not said else "carried out"
        if len(units) == 1 and said == self._units[next(iter(units))].said:
            return "CRC collision: a damaged frame that says what was sent"
        return f"CRC collision: {'one frame damaged' if len(units) == 1 else 'made of several'}, {made}"

    def _acted(self, action: Action) -> None:
        if action.what in ("pen up", "pen down", "reset"):
            return
        if action.what == "watchdog":
            self._falsified |= self._truth.keys()
            self._stop_truth()
            self.report.noticed["watchdog stops"] += 1
            return
        for frame in self._reference.waited(self.now):
            self._complete(frame)
        if not self._expected or action.what != self._expected.popleft():
            raise ViolationError(f"the robot did {action.what!r}, which nobody told it")

    def _stop_truth(self) -> None:
        for channel in list(self._truth):
            if channel[0] in ("engine", "wheels"):
                del self._truth[channel]
