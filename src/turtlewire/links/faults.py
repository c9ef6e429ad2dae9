"""A link with faults, so that everybody can see what noise does: bytes lost, added, flipped, doubled, late, cut up.

By rate and by schedule, deterministic by seed. Wraps any link; the driver does not know. Somebody who watches can
change all that while the link is open, hold everything back, or pull the plug.
"""

from __future__ import annotations

import heapq
import math
import random
from typing import NamedTuple

from turtlewire.errors import LinkClosedError, PortNotFoundError, UsageError
from turtlewire.links.link import Link

RATES = ("lose", "add", "flip", "duplicate")
FORM = (
    "NAME:VALUE,... of "
    + ", ".join(f"{name}:RATE" for name in RATES)
    + (", delay:SECONDS, split:BYTES, stall:AT+SECONDS, close:AT+SECONDS, seed:NUMBER, to:robot|host")
)


class Faults(NamedTuple):
    """What goes wrong on a link.

    Attributes:
        lose, add, flip, duplicate: how often, for each byte, 0..1: it vanishes, a random one comes before it, one of
            its bits is turned over, it comes twice.
        delay_s: each write and each read is up to so late, seconds; their order is kept.
        split: bytes come in pieces of at most so many; 0: as they are.
        stalls: (at, for) in seconds since the link was opened: nothing gets through, then all of it.
        close_at_s: when the link ends, seconds since it was opened.
        seed: of chance.
        to: ``"robot"`` or ``"host"``: the only direction with faults; empty: both.
        gone_s: for how long a link that ended cannot be opened again, seconds.
    """

    lose: float = 0.0
    add: float = 0.0
    flip: float = 0.0
    duplicate: float = 0.0
    delay_s: float = 0.0
    split: int = 0
    stalls: tuple[tuple[float, float], ...] = ()
    close_at_s: float = math.inf
    seed: int = 0
    to: str = ""
    gone_s: float = 0.0

    @classmethod
    def parse(cls, text: str) -> Faults:
        """Read ``lose:0.01,flip:0.001,stall:5+2,close:30,seed:7``. Raises ``UsageError``."""
        faults = cls()
        for part in filter(None, text.split(",")):
            name, colon, value = part.strip().partition(":")
            try:
                if not colon:
                    raise ValueError
                faults = faults._with(name, value)
            except ValueError:
                raise UsageError(f"faults {text!r}: {part!r} means nothing; write {FORM}") from None
        return faults

    def _with(self, name: str, value: str) -> Faults:
        if name in RATES:
            return Faults(**(self._asdict() | {name: _within(float(value), 1.0)}))
        if name == "delay":
            return self._replace(delay_s=_within(float(value), 3600.0))
        if name == "split":
            return self._replace(split=int(_within(int(value), 1 << 20)))
        if name == "stall":
            at, _, length = value.partition("+")
            return self._replace(stalls=(*self.stalls, (_within(float(at)), _within(float(length)))))
        if name == "close":
            at, _, length = value.partition("+")
            return self._replace(close_at_s=_within(float(at)), gone_s=_within(float(length or 0.0)))
        if name == "seed":
            return self._replace(seed=int(value))
        if name == "to" and value in ("robot", "host"):
            return self._replace(to=value)
        raise ValueError(name)


def _within(value: float, most: float = 1e9) -> float:
    if not 0.0 <= value <= most:
        raise ValueError(value)
    return value


class FaultyLink(Link):
    """A link that has ``faults``. All methods are for the thread that reads it.

    Attributes:
        within: the link that has them.
        lost, added, flipped, duplicated: how many bytes it did that to, in both directions.
    """

    def __init__(self, link: Link, faults: Faults) -> None:
        self.url = link.url
        self.in_background = link.in_background
        self.lost = self.added = self.flipped = self.duplicated = 0
        self.within = self._link = link
        self._faults = faults
        self._random = random.Random(faults.seed)
        self._started_s = link.now()
        self._closes_s, self._gone_s = self._started_s + faults.close_at_s, faults.gone_s
        self._number = 0
        # (when, number, bytes), earliest first.
        self._to_robot: list[tuple[float, int, bytes]] = []
        self._to_host: list[tuple[float, int, bytes]] = []
        self._latest = {"robot": -math.inf, "host": -math.inf}
        # Until when nothing of what is due gets through: somebody stalls it.
        self._held = {"robot": -math.inf, "host": -math.inf}

    def now(self) -> float:
        """Seconds on the clock of the link within."""
        return self._link.now()

    # ------------------------------------------------------------------ for whoever watches

    @property
    def faults(self) -> Faults:
        """What goes wrong at the moment, by rate and by schedule."""
        return self._faults

    def adjust(self, faults: Faults) -> None:
        """From now on other things go wrong.

        What is late already stays late, so that the order is kept. Chance goes on, unless the seed is another one; the
        times of a schedule count from when the link was opened. A ``stall`` and an ``unplug`` under way go on.
        """
        before, self._faults = self._faults, faults
        if faults.seed != before.seed:
            self._random = random.Random(faults.seed)
        if (faults.close_at_s, faults.gone_s) != (before.close_at_s, before.gone_s):
            self._closes_s, self._gone_s = self._started_s + faults.close_at_s, faults.gone_s
        self._link.wake()

    def stall(self, seconds: float) -> None:
        """For so long nothing gets through, not even what is late already; then all of it."""
        for to in self._held:
            if self._faults.to in ("", to):
                self._held[to] = max(self._held[to], self.now() + seconds)
        self._link.wake()

    def unplug(self, seconds: float) -> None:
        """The link ends now, and cannot be opened again for so long."""
        self._closes_s, self._gone_s = self.now(), seconds
        self._link.wake()

    # ------------------------------------------------------------------ as a link

    def write(self, data: bytes) -> None:
        """Send bytes, or what becomes of them."""
        self._check_open()
        self._put(self._to_robot, data, "robot")
        self._deliver()
        self._see_to_it()

    def write_urgent(self, data: bytes) -> None:
        """What has not got through yet is taken back; the bytes themselves suffer like any others."""
        self._check_open()
        self._to_robot.clear()
        damaged = self._damaged(data, "robot")
        at = max(self._due("robot", keep_order=False), self._held["robot"])
        self._latest["robot"] = at  # nothing that follows overtakes it
        if at <= self.now():
            self._link.write_urgent(damaged)
        else:
            self._push(self._to_robot, at, damaged)
            self._see_to_it()

    def _see_to_it(self) -> None:
        """Whoever reads hands over what is late: it must not sleep longer than that."""
        if self._to_robot:
            self._link.wake()

    async def read(self, until: float) -> bytes:
        """Wait for bytes, or what became of them."""
        while True:
            self._check_open()
            self._deliver()
            data = self._pop_for_host()
            if data or self.now() >= until:
                return data
            wait = min(until, self._next_due(), self._closes_s)
            data = await self._link.read(wait)
            if data:
                self._put(self._to_host, data, "host")
            elif self.in_background and self.now() < wait:
                return b""  # woken

    def wake(self) -> None:
        """End a read that waits."""
        self._link.wake()

    async def close(self) -> None:
        """Close the link within; what is late is lost."""
        self._to_robot.clear()
        self._to_host.clear()
        await self._link.close()

    async def reopen(self) -> None:
        """Open the link within again, if it is not to be gone yet; the faults go on as if nothing had happened."""
        if self._closes_s <= self.now() < self._closes_s + self._gone_s:
            raise PortNotFoundError(f"there is no port {self.url} now: a fault that was asked for")
        await self._link.reopen()
        self._latest = {"robot": -math.inf, "host": -math.inf}
        if self._closes_s <= self.now():
            self._closes_s = math.inf  # it ends once

    async def sleep(self, until: float) -> None:
        """As the link within; what is late gets through meanwhile."""
        while self.now() < until:
            await self._link.sleep(min(until, self._next_for("robot", self._to_robot)))
            self._deliver()

    def _check_open(self) -> None:
        if self.now() >= self._closes_s:
            raise LinkClosedError(f"the link to {self.url} ended: a fault that was asked for")

    def _put(self, queue: list[tuple[float, int, bytes]], data: bytes, to: str) -> None:
        damaged = self._damaged(data, to)
        size = self._faults.split or len(damaged) or 1
        for start in range(0, len(damaged), size):
            self._push(queue, self._due(to), damaged[start : start + size])

    def _push(self, queue: list[tuple[float, int, bytes]], at: float, data: bytes) -> None:
        self._number += 1
        heapq.heappush(queue, (at, self._number, data))

    def _due(self, to: str, *, keep_order: bool = True) -> float:
        """When bytes that set out now get through."""
        at = self.now()
        if self._faults.to in ("", to):
            at += self._random.uniform(0.0, self._faults.delay_s)
            for start_s, length_s in self._faults.stalls:
                if start_s <= at - self._started_s < start_s + length_s:
                    at = self._started_s + start_s + length_s
        if keep_order:
            at = self._latest[to] = max(at, self._latest[to])
        return at

    def _damaged(self, data: bytes, to: str) -> bytes:
        faults, chance = self._faults, self._random.random
        if self._faults.to not in ("", to):
            return data
        out = bytearray()
        for byte in data:
            if faults.add and chance() < faults.add:
                self.added += 1
                out.append(self._random.randrange(256))
            if faults.lose and chance() < faults.lose:
                self.lost += 1
                continue
            if faults.flip and chance() < faults.flip:
                self.flipped += 1
                byte ^= 1 << self._random.randrange(8)  # noqa: PLW2901 - this is what happens to it
            out.append(byte)
            if faults.duplicate and chance() < faults.duplicate:
                self.duplicated += 1
                out.append(byte)
        return bytes(out)

    def _deliver(self) -> None:
        """Hand over what is due to the robot."""
        while self._next_for("robot", self._to_robot) <= self.now():
            self._link.write(heapq.heappop(self._to_robot)[2])

    def _pop_for_host(self) -> bytes:
        """The next piece that is due to the host."""
        if self._next_for("host", self._to_host) <= self.now():
            return heapq.heappop(self._to_host)[2]
        return b""

    def _next_due(self) -> float:
        return min(self._next_for("robot", self._to_robot), self._next_for("host", self._to_host))

    def _next_for(self, to: str, queue: list[tuple[float, int, bytes]]) -> float:
        """When something of what is on its way there gets through; ``math.inf``: nothing is on its way."""
        return max(queue[0][0], self._held[to]) if queue else math.inf
