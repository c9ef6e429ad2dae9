"""All robots of a console."""

from __future__ import annotations

import asyncio
import re
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.console.refusals import Refused
from turtlewire.console.station import Station

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from pathlib import Path

    from turtlewire.configuration import Target
    from turtlewire.console.sessions import Session

KINDS = {"walter": "walter", "simple": "car", "frame": "frame"}
# How often time passes for them.
TICK_S = 0.05


class Berth(NamedTuple):
    """A robot that is to be reached; ``pace`` is of a simulated one, see ``Station``."""

    target: Target
    pace: float


class Stations:
    """The robots, by name, in the order in which they were given.

    Args:
        berths: the robots.
        announce: told where a robot has to be, for a new pty.
        clock: seconds.
        folder: of the programs; None: they have none.
    """

    def __init__(
        self,
        berths: Iterable[Berth],
        announce: Callable[[str], None],
        clock: Callable[[], float],
        folder: Path | None = None,
    ) -> None:
        self._stations: dict[str, Station] = {}
        self._clock = clock
        self._ticking: asyncio.Task[None] | None = None
        for target, pace in berths:
            name = self._free(_name(target))
            self._stations[name] = Station(name, target, pace, announce, folder)

    def _free(self, name: str) -> str:
        number, free = 1, name
        while free in self._stations:
            number += 1
            free = f"{name}-{number}"
        return free

    def __iter__(self) -> Iterator[Station]:
        return iter(self._stations.values())

    def __getitem__(self, name: str) -> Station:
        """Raises ``Refused`` for a robot that there is not."""
        station = self._stations.get(name)
        if station is None:
            raise Refused(404, "no_robot", f"there is no robot {name!r}: {', '.join(self._stations)}")
        return station

    def open(self) -> None:
        """Begin to reach them."""
        for station in self:
            station.open()
        self._ticking = asyncio.create_task(self._tick(), name="turtlewire stations")

    async def _tick(self) -> None:
        while True:
            now = self._clock()
            for station in self:
                station.tick(now)
            await asyncio.sleep(TICK_S)

    def stop(self, by: Session | None, who: str) -> None:
        """Stop all of them."""
        for station in self:
            station.stop(by, who)

    def end(self) -> None:
        """Stop all of them for good, from any thread, or a signal's handler: the console ends."""
        for station in self:
            station.end()

    def leave(self, session: Session) -> None:
        """A session is over."""
        for station in self:
            station.leave(session, self._clock())

    async def close(self) -> None:
        """Stop all of them, and let go of them."""
        if self._ticking is not None:
            self._ticking.cancel()
        await asyncio.gather(*(station.close() for station in self))


def _name(target: Target) -> str:
    """Short, and fit for an address."""
    if target.is_simulated:
        return KINDS[target.protocol]
    if target.name != target.port and re.fullmatch(r"[\w-]+", target.name):
        return target.name
    port = target.port.split("?")[0].rstrip("/")
    return re.sub(r"[^A-Za-z0-9-]+", "-", port.split("//")[-1].removeprefix("/dev/")).strip("-") or "robot"
