"""The wire between a driver and a simulated robot, whose every byte is known: what it was, and what became of it.

::

    driver -> Tap -> Mischief -> MemoryLink -> End -> simulated robot

``Tap`` numbers the bytes that the host sends, ``Mischief`` is a ``FaultyLink`` that says what it did to each, and
``End`` follows them until the robot has them, or the host has taken them back.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from typing import TYPE_CHECKING, Any, NamedTuple, SupportsIndex, overload

from turtlewire.links.faults import Faults, FaultyLink
from turtlewire.links.link import Link
from turtlewire.simulator.car import SimulatedCar
from turtlewire.simulator.frame_robot import SimulatedFrameRobot
from turtlewire.simulator.walter import SimulatedWalter

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

# So often a link is read without any time passing, and no more.
MOST_READS = 2000


class ViolationError(AssertionError):
    """Something happened that must not."""


class Mark(NamedTuple):
    """What a byte was when it set out: its number, -1 for one that never did; and what was done to it."""

    number: int
    fault: str = ""


class Marked(bytes):
    """Bytes that know what they were."""

    marks: tuple[Mark, ...]

    def __new__(cls, data: Iterable[int], marks: Iterable[Mark]) -> Marked:
        self = super().__new__(cls, data)
        self.marks = tuple(marks)
        return self

    @overload
    def __getitem__(self, key: SupportsIndex, /) -> int: ...
    @overload
    def __getitem__(self, key: slice, /) -> Marked: ...
    def __getitem__(self, key: Any, /) -> Any:
        part: Any = super().__getitem__(key)
        return Marked(part, self.marks[key]) if isinstance(key, slice) else part


def marks_of(data: bytes) -> tuple[Mark, ...]:
    """What the bytes of a wire were."""
    assert isinstance(data, Marked)
    return data.marks


class Mischief(FaultyLink):
    """A ``FaultyLink`` whose faults may change on the way, which can be told to damage one byte, and which tells all.

    Attributes:
        planned: what is to be done to a byte from now on, by direction and after how many bytes.
        done: how often each fault was done, by direction (``"robot"``, ``"host"``) and fault.
        hurt: the numbers of the host's bytes to which, or before which, something was done.
    """

    def __init__(self, link: Link, faults: Faults) -> None:
        super().__init__(link, faults)
        self.planned: dict[str, dict[int, str]] = {"robot": {}, "host": {}}
        self.done: Counter[tuple[str, str]] = Counter()
        self.hurt: set[int] = set()
        self._passed = {"robot": 0, "host": 0}

    @property
    def faults(self) -> Faults:
        """What goes wrong now."""
        return self._faults

    def change(self, **changes: Any) -> None:
        """From now on other things go wrong."""
        self._faults = self._faults._replace(**changes)

    def end_now(self, gone_s: float) -> None:
        """The link ends, and cannot be opened again for so long."""
        self.change(close_at_s=self.now() - self._started_s, gone_s=gone_s)

    def stall(self, seconds: float) -> None:
        """Nothing gets through for so long."""
        self._faults = self._faults._replace(stalls=((self.now() - self._started_s, seconds),))

    def plan(self, to: str, after: int, fault: str) -> None:
        """Do something to the byte that comes after so many."""
        self.planned[to][self._passed[to] + after] = fault

    @property
    def is_quiet(self) -> bool:
        """Whether nothing is held up in it."""
        return not (self._to_robot or self._to_host)

    @property
    def count(self) -> int:
        """How many bytes it did something to."""
        return sum(self.done.values())

    def _damaged(self, data: bytes, to: str) -> bytes:
        out = bytearray()
        marks: list[Mark] = []
        for byte, mark in zip(data, marks_of(data), strict=True):
            fault = self.planned[to].pop(self._passed[to], None)
            self._passed[to] += 1
            fate = self._fate(byte, to, fault)
            if to == "robot" and fate != [(byte, "")]:
                self.hurt.add(mark.number)
            for became, what in fate:
                out.append(became)
                marks.append(Mark(-1, what) if what == "added" else Mark(mark.number, what))
        return Marked(out, marks)

    def _fate(self, byte: int, to: str, fault: str | None) -> list[tuple[int, str]]:
        """What becomes of a byte: bytes, and what each of them is."""
        if fault is not None:
            self.done[to, fault] += 1
            return {
                "lose": [],
                "flip": [(byte ^ 1 << self._random.randrange(8), "flipped")],
                "add": [(self._random.randrange(256), "added"), (byte, "")],
                "duplicate": [(byte, ""), (byte, "doubled")],
            }[fault]
        before = (self.added, self.lost, self.flipped, self.duplicated)
        became = super()._damaged(bytes([byte]), to)
        after = (self.added, self.lost, self.flipped, self.duplicated)
        if before == after:
            return [(byte, "")]
        added, lost, flipped, doubled = (a - b for a, b in zip(after, before, strict=True))
        for name, count in (("add", added), ("lose", lost), ("flip", flipped), ("duplicate", doubled)):
            self.done[to, name] += count
        kinds = ["added"] * added + ["flipped" if flipped else ""] * (not lost) + ["doubled"] * doubled
        return list(zip(became, kinds, strict=True))


class Tap(Link):
    """The outermost link: numbers the bytes that are sent, and lets something happen at a time while the host waits.

    Attributes:
        sent: how many bytes have been sent, by those before it, too.
        on_write: told the number of the first byte, the bytes, and whether they are urgent, before they are sent.
        latest_s: until when the host may wait at most.
    """

    in_background = False

    def __init__(self, link: Link, sent: int) -> None:
        self.url = link.url
        self.sent = sent
        self.on_write: Callable[[int, bytes, bool], None] = lambda *_: None
        self.latest_s = math.inf
        self._link = link
        self._acts: list[tuple[float, Callable[[], None]]] = []
        self._reads = 0
        self._read_at = -math.inf

    def now(self) -> float:
        """Seconds of virtual time."""
        return self._link.now()

    def at(self, seconds_from_now: float, act: Callable[[], None]) -> None:
        """Let something happen at a time, if the host waits then."""
        self._acts = [(self.now() + seconds_from_now, act)]

    def forget_acts(self) -> bool:
        """What has not happened yet will not; whether there was anything."""
        acts, self._acts = self._acts, []
        return bool(acts)

    def write(self, data: bytes) -> None:
        """Send numbered bytes."""
        self._link.write(self._numbered(data, urgent=False))

    def write_urgent(self, data: bytes) -> None:
        """Send numbered bytes ahead of all others."""
        self._link.write_urgent(self._numbered(data, urgent=True))

    def _numbered(self, data: bytes, *, urgent: bool) -> Marked:
        first, self.sent = self.sent, self.sent + len(data)
        self.on_write(first, data, urgent)
        return Marked(data, map(Mark, range(first, self.sent)))

    async def read(self, until: float) -> bytes:
        """Wait, but not for ever."""
        now = self.now()
        self._reads = self._reads + 1 if now == self._read_at else 0
        self._read_at = now
        if self._reads > MOST_READS:
            raise ViolationError("the host hangs: it goes round and round, and no time passes")
        if now > self.latest_s:
            raise ViolationError(f"the host hangs: it waits beyond second {self.latest_s:.1f}")
        act_s = self._acts[0][0] if self._acts else math.inf
        data = await self._link.read(min(until, act_s)) if now < act_s else b""
        if not data and self.now() >= act_s:
            self._acts.pop()[1]()
        return data

    def wake(self) -> None:
        """Nothing waits here."""

    async def close(self) -> None:
        """Let go."""
        await self._link.close()

    async def reopen(self) -> None:
        """Open it again."""
        await self._link.reopen()

    async def sleep(self, until: float) -> None:
        """Let time pass, but not for ever."""
        if until > self.latest_s:
            raise ViolationError(f"the host hangs: it sleeps until second {until:.1f}")
        await self._link.sleep(until)


class WatchedCar(SimulatedCar):
    """A car that tells of each byte as it arrives."""

    arrive: Callable[[int], None] = staticmethod(lambda _: None)

    def _receive(self, byte: int) -> None:
        self.arrive(byte)
        super()._receive(byte)


class WatchedFrameRobot(SimulatedFrameRobot):
    """A two-engine robot that tells of each byte as it arrives."""

    arrive: Callable[[int], None] = staticmethod(lambda _: None)

    def _receive(self, byte: int) -> None:
        self.arrive(byte)
        super()._receive(byte)


class WatchedWalter(SimulatedWalter):
    """A WALTER that tells of each byte as it arrives, and of each command as it is carried out."""

    arrive: Callable[[int], None] = staticmethod(lambda _: None)
    carry_out: Callable[[Any], None] = staticmethod(lambda _: None)

    def _receive(self, byte: int) -> None:
        self.arrive(byte)
        super()._receive(byte)

    def _carry_out(self, command: Any) -> None:
        self.carry_out(command)
        super()._carry_out(command)

    def _act_at_once(self, message: Any) -> None:
        self.carry_out(message)
        super()._act_at_once(message)


AnyRobot = WatchedCar | WatchedFrameRobot | WatchedWalter


class End:
    """The far end of the wire: a robot that can be reset, and the bytes on their way to it.

    Attributes:
        robot: the one that is there.
        on_arrival: told each byte that the robot hears, and what it was.
        hurt: the numbers of the host's bytes that a robot that boots has not heard.
        on_open: called when the host has opened the port once more.
        mark_reply: says the number of the next byte that the robot has sent.
    """

    def __init__(self, robot: AnyRobot) -> None:
        self.on_arrival: Callable[[int, Mark], None] = lambda *_: None
        self.on_open: Callable[[], None] = lambda: None
        self.mark_reply: Callable[[int], int] = lambda _: -1
        self.hurt: set[int] = set()
        self._under_way: deque[Mark] = deque()
        self.robot = robot
        robot.arrive = self._arrived

    def _arrived(self, byte: int) -> None:
        mark = self._under_way.popleft()
        if self.robot.now >= self.robot._booted_s:
            self.on_arrival(byte, mark)
        else:
            self.hurt.add(mark.number)

    def reset(self) -> None:
        """The robot is reset: what was on the line is lost."""
        self.hurt |= {mark.number for mark in self._under_way}
        self._under_way.clear()
        self.robot.port_opened()

    @property
    def now(self) -> float:
        """Seconds since the robot was switched on."""
        return self.robot.now

    @property
    def is_quiet(self) -> bool:
        """Whether nothing is on its way to the robot."""
        return not self._under_way

    def write(self, data: bytes) -> None:
        """Bytes set out."""
        self._under_way += marks_of(data)
        self.robot.write(data)

    def awaits_host(self) -> bool:
        """Whether nothing will happen by itself."""
        return self.robot.awaits_host()

    def discard_output(self) -> None:
        """The host takes back what has not begun to go out."""
        before = self.robot.bytes_on_line
        self.robot.discard_output()
        for _ in range(before - self.robot.bytes_on_line):
            self._under_way.pop()

    def read(self, until: float) -> bytes:
        """Let time pass."""
        data = self.robot.read(until)
        return Marked(data, [Mark(self.mark_reply(byte)) for byte in data]) if data else b""

    def port_opened(self) -> None:
        """The host has opened the port once more."""
        self.on_open()
