"""What the car's host sends, what the car makes of it, and what comes back: followed byte by byte."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, Any, ClassVar

from tests.soak.simple.reference import (
    BAUD,
    LENGTH,
    REPLY_DELAY_S,
    RETRIES,
    SETUP,
    WHOLE_STOP,
    Doubts,
    Unit,
    said,
    spell,
    way_back_limits,
    what_happened,
)
from tests.soak.soak import Soak
from tests.soak.timed import TimedSoak
from tests.soak.wire import Mark, ViolationError, WatchedCar, marks_of
from turtlewire.protocols.simple.codec import encode
from turtlewire.protocols.simple.events import GaveUp, InStep, LinkDead, OutOfStep
from turtlewire.robots.car import AsyncCar, Settings
from turtlewire.simulator.car import CarSettings

if TYPE_CHECKING:
    from tests.soak.domains import Domain
    from tests.soak.wire import Tap
    from turtlewire.links.faults import Faults
    from turtlewire.protocols.simple.events import Event
    from turtlewire.protocols.simple.host import Host
    from turtlewire.protocols.simple.messages import SimpleCommand
    from turtlewire.simulator.settings import Action

HEARTBEAT_S = 0.3
# A byte too many is noticed when two more commands have been answered, at the latest.
UNNOTICED_COMMANDS = 2


class CarModel(TimedSoak):
    """A car, its driver, and the model of both."""

    NAME = "simple"
    SETUP: ClassVar[dict[str, Domain]] = Soak.SETUP | SETUP

    def __init__(self, seed: int, faults: Faults, **setup: Any) -> None:
        # All bytes and commands that were ever sent, by whichever link.
        self._units: list[Unit] = []
        self._unit_of: list[Unit] = []
        self._latest_executed = -1
        self._groups: list[set[int]] = []
        # What has arrived of a command; which replies are due; and what the car is about to do.
        self._group: list[tuple[int, Mark]] = []
        self._answering: deque[tuple[int, int]] = deque()
        self._expected: deque[str] = deque()
        super().__init__(seed, faults, **setup)

    # ------------------------------------------------------------------ both ends

    def new_robot(self) -> WatchedCar:
        settings = CarSettings(
            baud=BAUD,
            boot_s=self.setup["boot_s"],
            steer_deg_per_s=math.inf,
            watchdog_s=1.0 if self.setup["watchdog"] else None,
        )
        robot = WatchedCar(settings)
        robot.events = self._acted
        return robot

    def new_driver(self, link: Tap) -> AsyncCar:
        self.end.on_arrival = self._arrived
        self.end.mark_reply = self._mark_reply
        self._faults = self._faults._replace(delay_s=self.setup["delay_s"], split=self.setup["split"])
        self.mischief.change(delay_s=self._faults.delay_s, split=self._faults.split)
        driver = AsyncCar(
            link,
            Settings(
                window=self.setup["window"],
                turn=self.setup["turn"],
                pen_light=self.setup["pen_light"],
                reply_delay_s=REPLY_DELAY_S,
                retries=RETRIES,
                boot_s=0.0,
                heartbeat_s=HEARTBEAT_S if self.setup["watchdog"] else None,
            ),
            self.notify,
        )
        link.on_write = self._sent
        self._flights: deque[Unit] = deque()
        self._truth: dict[str, Any] = self._state_of_robot()
        self._unsure = Doubts(dict.fromkeys(self._truth, 0))
        self._wanted: dict[str, Any] = {}
        self._way_back_from: tuple[float, int] = (self.now, self._damage_now)
        self._damage_in_step = -1
        self._unread = self._latest_reply = 0
        self._misaligned = (0, 0)
        self._owes_notice = False
        self._valid_until = math.inf
        self._expire, vars(driver)["_expire"] = driver._expire, self._expired
        self._host: Host = driver._host
        host = vars(self._host)
        self._receive, host["receive_data"] = self._host.receive_data, self._received
        self._time_out, host["timed_out"] = self._host.timed_out, self._timed_out
        self._submit, host["submit"] = self._host.submit, self._submitted
        self._stop_host, host["emergency_stop"] = self._host.emergency_stop, self._stopped
        self._begin, host["connect"] = self._host.connect, self._connected
        self._end_link, host["link_lost"] = self._host.link_lost, self._link_lost
        return driver

    def _expired(self, valid_s: float | None) -> None:
        self._valid_until = math.inf if valid_s is None else self.now + valid_s
        self._expire(valid_s)

    def robot_was_reset(self) -> None:
        self._group.clear()
        self._answering.clear()
        for channel, value in self._state_of_robot().items():
            if value != self._truth[channel]:
                self._truth[channel] = value
                self._unsure.doubt(channel)

    def _state_of_robot(self) -> dict[str, Any]:
        robot: Any = self.end.robot
        return {"drive": robot.drive, "steer": robot.steer, "lights": robot.lights}

    # ------------------------------------------------------------------ what the host sends

    def _sent(self, first: int, data: bytes, urgent: bool) -> None:
        """Every byte that leaves is a wanted set-point, a stop, or a part of the way back into step."""
        if urgent:
            if data != b"S" * 14:
                raise ViolationError(f"{data!r} is no emergency stop")
            self._add_unit(first, data, "emergency")
        elif not self._host.in_step:
            if data not in (b"S", WHOLE_STOP):
                raise ViolationError(f"{data!r} sent while not in step")
            self._add_unit(first, data, "way back")
        else:
            for at in range(0, len(data), LENGTH):
                unit = self._add_unit(first + at, data[at : at + LENGTH], "command")
                self._check_wanted(unit)
                self._flights.append(unit)
                # A stop goes out beyond the window (S9).
                if len(self._flights) > self.setup["window"] + sum(
                    u.data == WHOLE_STOP for u in self._flights
                ):
                    raise ViolationError(f"{len(self._flights)} commands are under way")
                self.report.wire_commands += 1

    def _add_unit(self, first: int, data: bytes, kind: str) -> Unit:
        unit = Unit(len(self._units), first, data, kind)
        self._units.append(unit)
        self._unit_of += [unit] * len(data)
        return unit

    def _check_wanted(self, unit: Unit) -> None:
        if unit.spelled is None:
            raise ViolationError(f"the host sent {unit.data!r}, which is no command")
        channel, value = unit.spelled
        if channel != "stop" and self._wanted.get(channel) != value:
            raise ViolationError(f"the host sent {unit.data!r}, but wanted is {self._wanted.get(channel)}")

    def _submitted(self, command: SimpleCommand, tag: object = None) -> None:
        self._submit(command, tag)
        channel, value = spell(encode(command)) or ("", 0)
        if channel == "stop":
            self._forget_wanted()
        else:
            self._wanted[channel] = value

    def _stopped(self, now: float) -> None:
        self._forget_wanted()
        self._way_back_begins()
        self._stop_host(now)
        self._flights.clear()

    def _connected(self, now: float) -> None:
        self._way_back_begins()
        self._begin(now)
        self._flights.clear()

    def _link_lost(self, now: float) -> list[Event]:
        self._wanted.clear()
        self._flights.clear()
        return self._end_link(now)

    def _forget_wanted(self) -> None:
        for channel in ("drive", "steer"):
            self._wanted.pop(channel, None)

    # ------------------------------------------------------------------ what the robot makes of it

    def _arrived(self, byte: int, mark: Mark) -> None:
        if self._expected:
            raise ViolationError(f"the car did not carry out {self._expected[0]!r}")
        self._group.append((byte, mark))
        if len(self._group) == LENGTH:
            group, self._group = self._group, []
            self._complete(bytes(b for b, _ in group), [m for _, m in group])
        if self._group and mark.fault == "" and self._host.in_step:
            unit = self._unit_of[mark.number]
            if unit.kind == "command" and mark.number == unit.first + LENGTH - 1:
                self._count_misaligned()

    def _count_misaligned(self) -> None:
        """A command has ended, and the car waits for more: it is out of step, and the host does not know."""
        count, damage = self._misaligned
        count = count + 1 if damage == self.damage else 1
        if count > UNNOTICED_COMMANDS + self.setup["window"]:
            raise ViolationError(f"{count} commands in a row came out of step, and the host does not notice")
        self._misaligned = (count, self.damage)

    def _complete(self, raw: bytes, marks: list[Mark]) -> None:
        spelled = spell(raw)
        units = {self._unit_of[m.number].number for m in marks if m.number >= 0}
        self._answering.append((len(self._groups), ord("K" if spelled else "F")))
        self._groups.append(units)
        if spelled:
            self._expected.append(said(raw))
            self._execute(raw, marks, spelled, [self._units[n] for n in sorted(units)])
        elif len(units) == 1 and self._units[min(units)].is_whole(marks):
            raise ViolationError(f"the host sent {raw!r}, which means nothing")

    def _execute(self, raw: bytes, marks: list[Mark], spelled: tuple[str, Any], units: list[Unit]) -> None:
        channel, value = spelled
        self._truth.update({"drive": 0, "steer": 0} if channel == "stop" else {channel: value})
        known = [unit for unit in units if unit.kind != "command"]
        begun = next((unit for unit in units if unit.kind == "command"), None)
        others = [
            each.kind for m in marks if m.number >= 0 and (each := self._unit_of[m.number]) is not begun
        ]
        if len(units) == 1 and begun and begun.is_whole(marks):
            self._in_order(begun)
            self.report.executed += 1
            self._misaligned = (0, self.damage)
            self._unsure.sure(channel, begun)
        elif len(known) == len(units) and all(m.fault == "" for m in marks) and raw[:1] == b"S":
            self._unsure.sure(channel, known[0])  # on the way back
            if self._host.in_step:
                self.uncatchable("a stop of the way back that came too late")
                self._unsure.doubt(channel)
        elif begun and known and begun.is_begun(marks, others, spelled):
            self._in_order(
                begun
            )  # the way back completes what was cut off, where anything will do, and stops it
            self._unsure.sure(channel, begun)
        else:
            self.uncatchable(what_happened(marks, units))
            self._unsure.doubt(channel)
            for unit in units:
                unit.twisted = True
                if unit.spelled and unit.spelled[0] != channel:
                    self._unsure.doubt(unit.spelled[0])

    def _in_order(self, unit: Unit) -> None:
        if unit.executed or unit.number < self._latest_executed:
            raise ViolationError(f"{unit.data!r} was carried out twice, or too late")
        unit.executed = True
        self._latest_executed = unit.number

    def _acted(self, action: Action) -> None:
        if action.what == "reset":
            return
        if action.what == "watchdog":
            self._truth.update(drive=0, steer=0)
            self._unsure.doubt("stop")
            self.report.noticed["watchdog stops"] += 1
            if not self.setup["watchdog"]:
                raise ViolationError("there is no watchdog")
        elif not self._expected or action.what != self._expected.popleft():
            raise ViolationError(f"the car did {action.what!r}, which nobody told it")

    # ------------------------------------------------------------------ what comes back

    def _mark_reply(self, byte: int) -> int:
        number, expected = self._answering.popleft()
        if byte != expected:
            raise ViolationError(f"the car answers {chr(byte)} where {chr(expected)} is right")
        return number

    def _received(self, data: bytes, now: float) -> list[Event]:
        events: list[Event] = []
        marks = marks_of(data) if data else ()
        self._unread = len(data)
        for byte, mark in zip(data, marks, strict=True):
            self._unread -= 1
            self._latest_reply = byte
            before = len(self._host.under_way) if self._host.in_step else 0
            each = self._receive(bytes([byte]), now)
            after = len(self._host.under_way)
            if byte == 0x4B and before and after == before - 1:
                self._acknowledged(self._flights.popleft(), mark)
            elif after < before:
                self._flights.clear()
            self._observe(each)
            events += each
        self._check_state()
        return events

    def _timed_out(self, now: float) -> list[Event]:
        events = self._time_out(now)
        self._observe(events)
        self._check_state()
        return events

    def _check_state(self) -> None:
        """What the host says of the robot is right, or it does not say it, or it cannot know."""
        state = self._host.state
        for channel, known in (("drive", state.drive), ("steer", state.steer), ("lights", state.lights)):
            if known is not None and known != self._truth[channel] and channel not in self._unsure:
                raise ViolationError(
                    f"the host says that {channel} is {known}, but it is {self._truth[channel]}"
                )

    def _acknowledged(self, unit: Unit, mark: Mark) -> None:
        """K means: carried out, by now. Or a fault made it."""
        if unit.executed or unit.twisted:
            return
        if self.damage == self._damage_in_step:
            raise ViolationError(f"{unit.data!r} was acknowledged, but never carried out")
        self.uncatchable(
            "acknowledged by a byte that was added" if mark.fault else "acknowledged by another's reply"
        )
        if unit.spelled:
            self._unsure.doubt(unit.spelled[0], unit.number)

    def _observe(self, events: list[Event]) -> None:
        for event in events:
            if isinstance(event, OutOfStep):
                self._owes_notice |= self.driver.account.is_moving
                if self.driver._is_holding and self.driver.account.is_moving:
                    self._forget_wanted()  # a motion that was timed is never sent again
                self._flights.clear()
                self.report.noticed[event.reason] += 1
                if self.damage == self._damage_in_step:
                    raise ViolationError(f"nothing went wrong, but: {event.reason}")
                self._way_back_begins()
            elif isinstance(event, InStep):
                if self._latest_reply != ord("K"):
                    raise ViolationError(
                        "in step, as the host says, and the last that the car has said is not K"
                    )
                self._in_step_again()
            elif isinstance(event, GaveUp):
                self._wanted.pop((spell(encode(event.command)) or ("", 0))[0], None)
                self.report.noticed["given up"] += 1
            elif isinstance(event, LinkDead):
                self._flights.clear()
                self._wanted.clear()
                self._way_back_ends(event.reason)
                self.report.noticed["link dead"] += 1
                if self.damage == self._damage_in_step:
                    raise ViolationError(f"nothing went wrong, but: {event.reason}")

    def _way_back_begins(self) -> None:
        self._misaligned = (0, self.damage)
        self._way_back_from = (self.now, self._damage_now)

    @property
    def _damage_now(self) -> int:
        """``damage``; -1, which it never is again, while the wire or the car is held up."""
        return self.damage if self.now >= self.unrest_until_s else -1

    def _way_back_ends(self, how: str) -> tuple[float, int]:
        began_s, damage = self._way_back_from
        seconds, spent, is_calm = self.now - began_s, self._host.spent, self.damage == damage
        report = self.report
        report.recoveries += 1
        report.worst_s, report.worst_bytes = max(report.worst_s, seconds), max(report.worst_bytes, spent)
        if is_calm:
            report.calm_worst_s = max(report.calm_worst_s, seconds)
            report.calm_worst_bytes = max(report.calm_worst_bytes, spent)
        most_bytes, most_s = way_back_limits(self.setup["window"], is_calm=is_calm)
        if spent > most_bytes or seconds > most_s:
            raise ViolationError(
                f"{how} after {spent} bytes and {seconds:.3f} s, {'in calm' if is_calm else 'in noise'}"
            )
        return self._way_back_from

    def _in_step_again(self) -> None:
        _, damage = self._way_back_ends("in step")
        is_right = not self._group and self._truth["drive"] == self._truth["steer"] == 0
        is_quiet = not (self._answering or self._unread) and self._is_quiet
        if is_right and is_quiet:
            self._damage_in_step = self._damage_now
            return
        if damage == self.damage:
            raise ViolationError(
                f"in step, as the host says, but {self._group} is pending, or something is under way; {self._truth}"
            )
        self.uncatchable("in step by mistake: faults on the way back")
        self._damage_in_step = -1  # and it may be noticed any time
        if not is_right:
            self._unsure.doubt("stop")
