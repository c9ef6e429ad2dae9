"""What WALTER's host sends, what the robot makes of it, and what its answers confirm: followed byte by byte."""

from __future__ import annotations

from collections import deque
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar

from tests.soak.domains import FLAG, MOSTLY, RARELY, Domain, one_of
from tests.soak.soak import Soak
from tests.soak.walter.reference import (
    ATTENTION,
    EMERGENCY,
    MOTIONS,
    QUEUE,
    Reference,
    Spelled,
    Unit,
)
from tests.soak.wire import Mark, ViolationError, WatchedWalter
from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import encode
from turtlewire.protocols.walter.host import FenceLost, Limit, Silent
from turtlewire.robots.walter import AsyncWalter, Settings
from turtlewire.simulator.settings import Settings as RobotSettings
from turtlewire.simulator.world import Wall, World

if TYPE_CHECKING:
    from tests.soak.wire import Tap
    from turtlewire.links.faults import Faults
    from turtlewire.protocols.walter.host import Event, Host
    from turtlewire.robots.walter.connection import Connection
    from turtlewire.simulator.settings import Action

HEARTBEAT_S, WATCHDOG_S = 0.5, 2.0
FENCES = (b"QH", b"QX", b"QY", b"QP")
# A line that lost its end swallows the next one; one whose arguments hold a CR may end there: so near must damage be.
NEAR_BYTES = 40
ROOM_MM = 230.0


class WalterModel(Soak):
    """A WALTER, its driver, and the model of both."""

    NAME = "walter"
    SETUP: ClassVar[dict[str, Domain]] = Soak.SETUP | {
        "groups": one_of("CQHE", "CQHE", "CQHE", "Q", "QHE", ""),
        "watchdog": FLAG,
        "walls": RARELY,
        "gentle": MOSTLY,
        "max_unfenced": one_of(48, 48, 30, 16),
        "delay_s": one_of(0.0, 0.0, 0.01),
        "split": one_of(0, 0, 1, 3),
    }

    def __init__(self, seed: int, faults: Faults, **setup: Any) -> None:
        self._groups = setup["groups"]
        # All that was ever sent, by whichever link, and which part of it each byte belongs to.
        self._units: list[Unit] = []
        self._unit_of: list[Unit] = []
        self._latest_executed = -1
        # What the robot has accepted and not begun, and what it has to act on at once.
        self._queue: deque[tuple[Spelled, list[Mark]]] = deque()
        self._at_once: deque[tuple[Spelled, list[Mark]]] = deque()
        self._reference = Reference(self._groups)
        super().__init__(seed, faults, **setup)

    # ------------------------------------------------------------------ both ends

    def new_robot(self) -> WatchedWalter:
        room = ROOM_MM
        corners = ((-room, -room), (room, -room), (room, room), (-room, room), (-room, -room))
        walls = tuple(Wall(*a, *b) for a, b in pairwise(corners))
        robot = WatchedWalter(
            RobotSettings(
                groups=frozenset(self._groups),
                boot_s=self.setup["boot_s"],
                watchdog_s=WATCHDOG_S if self.setup["watchdog"] else None,
                world=World(walls if self.setup["walls"] else ()),
            )
        )
        robot.events = self._acted
        robot.carry_out = self._carried_out
        return robot

    def new_driver(self, link: Tap) -> AsyncWalter:
        self.end.on_arrival = self._arrived
        self._faults = self._faults._replace(delay_s=self.setup["delay_s"], split=self.setup["split"])
        self.mischief.change(delay_s=self._faults.delay_s, split=self._faults.split)
        driver = AsyncWalter(
            link,
            Settings(
                boot_s=0.5,
                gentle=self.setup["gentle"],
                max_unfenced=self.setup["max_unfenced"],
                heartbeat_s=HEARTBEAT_S if self.setup["watchdog"] else None,
            ),
            self.notify,
        )
        link.on_write = self._sent
        self._wire: Connection = driver._wire
        self._host: Host = self._wire.host
        self._submitted: deque[Spelled] = deque()
        self._flights: deque[Unit] = deque()
        self._pen_wanted = self._went_well = True
        host = vars(self._host)
        self._submit, host["submit"] = self._host.submit, self._handed_over
        self._receive, host["receive_data"] = self._host.receive_data, self._received
        self._time_out, host["timed_out"] = self._host.timed_out, self._timed_out
        self._forget_host, host["_forget"] = self._host._forget, self._forgotten
        wire = vars(self._wire)
        for name in ("_reconcile", "_attend"):
            wire[name] = self._measured(getattr(self._wire, name))
        return driver

    def robot_was_reset(self) -> None:
        self._queue.clear()
        self._at_once.clear()
        self._reference = Reference(self._groups)

    def _measured(self, way_back: Any) -> Any:
        """What it takes to bring everything in order."""

        async def measured(*args: Any, **options: Any) -> None:
            began_s, sent, damage = self.now, self.tap.sent, self.damage
            try:
                await way_back(*args, **options)
            finally:
                size, seconds = self.tap.sent - sent, self.now - began_s
                report = self.report
                report.recoveries += 1
                report.worst_bytes = max(report.worst_bytes, size)
                report.worst_s = max(report.worst_s, seconds)
                if damage == self.damage and began_s >= self.unrest_until_s:
                    report.calm_worst_bytes = max(report.calm_worst_bytes, size)
                    report.calm_worst_s = max(report.calm_worst_s, seconds)

        return measured

    # ------------------------------------------------------------------ what the host sends

    def _handed_over(self, command: m.LogoCommand, duration_s: float = 0.0, tag: object = None) -> None:
        self._submit(command, duration_s, tag)
        self._submitted.append(_spelled(command))

    def _forgotten(self, now: float) -> None:
        self._submitted.clear()
        self._flights.clear()
        self._forget_host(now)

    def _sent(self, first: int, data: bytes, urgent: bool) -> None:
        """What was submitted, in order, with fences between; attention, stops and keys ahead of it."""
        at = 0
        while urgent and data.startswith(EMERGENCY, at):
            start = ATTENTION if data.startswith(ATTENTION, at) else EMERGENCY
            self._add_unit(first + at, start, None)
            at += len(start)
        plain = Reference("CQHE")
        plain.is_direct = urgent
        began = at
        for n in range(at, len(data)):
            done = plain.arrived(data[n], Mark(n))
            if done is not None:
                unit = self._add_unit(first + began, data[began : n + 1], done[0])
                began = n + 1
                if not urgent:
                    self._check_order(unit)
        if began != len(data):
            raise ViolationError(f"the host sent {data!r}, which ends in the middle")

    def _add_unit(self, first: int, data: bytes, spelled: Spelled | None) -> Unit:
        unit = Unit(len(self._units), first, data, spelled)
        unit.disturbances, unit.sent_s = self._disturbances, self.now
        self._units.append(unit)
        self._unit_of += [unit] * len(data)
        self.report.wire_commands += bool(spelled and spelled.letters)
        return unit

    def _check_order(self, unit: Unit) -> None:
        said = unit.spelled
        assert said is not None
        if not said.letters:
            return  # a heartbeat
        if self._submitted and self._submitted[0] == said:
            self._submitted.popleft()
        elif said.letters not in FENCES:
            raise ViolationError(f"{said} was sent, which is not next: {[str(s) for s in self._submitted]}")
        self._flights.append(unit)
        under_way = sum(len(each.data) for each in self._flights)
        if self._host.answers and under_way > self.setup["max_unfenced"]:
            raise ViolationError(f"{under_way} bytes are under way without an answer")

    # ------------------------------------------------------------------ what the robot makes of it

    def _arrived(self, byte: int, mark: Mark) -> None:
        if self._at_once:
            raise ViolationError(f"the robot did not act on {self._at_once[0][0]}")
        done = self._reference.arrived(byte, mark)
        if done is None or not done[0].letters:
            return
        said, _ = done
        if said.is_key:
            self._at_once.append(done)
        elif said.letters == b"2":
            self._queue.clear()
            self._at_once.append(done)
        elif len(self._queue) < QUEUE:
            self._queue.append(done)
        else:
            self._overflows(done[1])

    def _overflows(self, marks: list[Mark]) -> None:
        """The host never has more under way than the queue holds: only faults fill it.

        They cut commands in two, and make a robot that answers nothing slower than its host thinks.
        """
        last = max(mark.number for mark in marks)
        under_way = range(last - self.setup["max_unfenced"] - NEAR_BYTES, last + 1)
        if self.hurt.isdisjoint(under_way) and (self._host.answers or not self.hurt):
            raise ViolationError("the robot's queue is full, and nothing went wrong")
        self.uncatchable("the queue was full of what faults had made")

    def _carried_out(self, message: m.WalterMessage) -> None:
        said = _spelled(message)
        queue = self._at_once if said.is_key or said.letters == b"2" else self._queue
        if not queue or queue[0][0] != said:
            raise ViolationError(
                f"the robot carries out {said}, and next is {queue[0][0] if queue else 'nothing'}"
            )
        _, marks = queue.popleft()
        if said.is_key:
            self._queue.clear()
        numbers = [mark.number for mark in marks]
        units = {self._unit_of[n].number for n in numbers if n >= 0}
        if len(units) == 1 and self._is_sent(self._units[next(iter(units))], marks, said):
            return
        if (
            said.letters in (b"2", b" ", b"1")
            and all(self._units[n].spelled is None for n in units)
            and units
        ):
            return  # what is left of stops stops
        self.uncatchable(self._what_happened(marks, said, sorted(units)))

    def _is_sent(self, unit: Unit, marks: list[Mark], said: Spelled) -> bool:
        """Whether this is what was sent, all of it and nothing else."""
        if any(mark.fault for mark in marks):
            return False
        if unit.spelled is None:
            return said.letters in (b"2", b" ", b"1")  # attention, or a stop
        if marks != [Mark(unit.first + n) for n in range(len(unit.data))]:
            return False
        if unit.executed or unit.number < self._latest_executed:
            raise ViolationError(f"{unit.spelled} was carried out twice, or too late")
        unit.executed = True
        self._latest_executed = unit.number
        self.report.executed += 1
        return True

    def _what_happened(self, marks: list[Mark], said: Spelled, units: list[int]) -> str:
        faults = {mark.fault for mark in marks} - {""}
        kind = (
            "query"
            if said.letters.startswith(b"Q")
            else "motion"
            if said.letters in MOTIONS
            else "other command"
        )
        kind = "key" if said.is_key else kind
        if len(units) == 1 and self._units[units[0]].spelled == said:
            return f"a damaged {kind} that says what was sent"
        if len(units) == 1 and faults == {"flipped"}:
            was = self._units[units[0]].spelled
            same = was is not None and was.letters == said.letters
            return f"{'an argument' if same else 'a letter'} changed: a {kind}"
        return f"made of pieces: a {kind}"

    def _acted(self, action: Action) -> None:
        if action.what.startswith("limit"):
            self._queue.clear()
            self._disturbances += 1
            self.report.noticed["limits"] += 1
            if not self.setup["walls"]:
                raise ViolationError("there is no wall")
        elif action.what == "watchdog":
            self._queue.clear()
            self._disturbances += 1
            self.report.noticed["watchdog stops"] += 1

    # ------------------------------------------------------------------ what comes back

    def _received(self, data: bytes, now: float) -> list[Event]:
        events: list[Event] = []
        for byte in data:
            before = len(self._host.unconfirmed)
            each = self._receive(bytes([byte]), now)
            after = len(self._host.unconfirmed)
            self._observe(each, before - after)
            events += each
        return events

    def _timed_out(self, now: float) -> list[Event]:
        before = len(self._host.unconfirmed)
        events = self._time_out(now)
        self._observe(events, before - len(self._host.unconfirmed))
        return events

    def _observe(self, events: list[Event], ended: int) -> None:
        is_lost = False
        for event in events:
            if isinstance(event, FenceLost):
                is_lost = True
                self.report.noticed["answers lost"] += 1
            elif isinstance(event, Silent):
                self.report.noticed["silence"] += 1
            elif isinstance(event, Limit):
                self.report.noticed["limits heard of"] += 1
        for _ in range(min(ended, len(self._flights))):
            unit = self._flights.popleft()
            if not is_lost and self._host.answers:
                self._confirmed(unit)

    def _confirmed(self, unit: Unit) -> None:
        """A fence was answered: what was sent before it was carried out, or damaged."""
        assert unit.spelled is not None
        if unit.executed or unit.spelled.letters not in self._reference.lines:
            return  # or the robot has no such command, which shows in its pose (W10)
        if unit.spelled.letters == b"QH" and (self._wire._attending or self._wire._closed):
            # The answer to an earlier one, which the attention has overtaken: all that counts is asked anew.
            self.report.noticed["answers that were late"] += 1
            return
        if not self._was_hurt(unit) and unit.disturbances == self._disturbances:
            raise ViolationError(f"{unit.spelled} is taken for done, but was never carried out")
        kind = unit.spelled.letters
        if kind not in MOTIONS and kind not in (b"PU", b"PD") and not kind.startswith(b"Q"):
            self.uncatchable("horn, lamp or speed lost, and taken for done")

    def _was_hurt(self, unit: Unit) -> bool:
        """Whether something was done to it, or so near before it that it was swallowed."""
        return not self.hurt.isdisjoint(range(unit.first - NEAR_BYTES, unit.first + len(unit.data)))


def _spelled(message: m.WalterMessage) -> Spelled:
    """What a message says, as the model spells it."""
    data, letters = encode(message), message.LETTERS
    if isinstance(message, m.DirectKey):
        return Spelled(letters, data[len(letters) :], is_key=True)
    return Spelled(letters, data[len(letters) : -1], is_key=False)
