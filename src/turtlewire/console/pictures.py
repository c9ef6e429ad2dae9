"""Pictures of what robots drew, to be saved from the page."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Literal

from turtlewire import picture
from turtlewire.console.refusals import Refused
from turtlewire.errors import OutputError
from turtlewire.trace import Trace

if TYPE_CHECKING:
    from turtlewire.console.station import Station

KINDS = {"svg": "image/svg+xml", "png": "image/png"}


class Painter:
    """Makes one picture at a time, in a thread, so that nobody who drives waits for it."""

    def __init__(self) -> None:
        self._one = asyncio.Semaphore(1)

    async def paint(self, station: Station, kind: Literal["svg", "png"]) -> bytes:
        """The picture of a robot's path. Raises ``Refused`` for a drawing without a finite size."""
        async with self._one:
            try:
                return await asyncio.to_thread(_painted, station, kind)
            except OutputError as error:
                raise Refused(409, "no_picture", str(error)) from None


def _painted(station: Station, kind: Literal["svg", "png"]) -> bytes:
    trace = Trace()
    for number, (x, y, pen_down) in enumerate(station.path.since(0).points):
        pose = station.view.pose._replace(x_mm=x, y_mm=y)
        if number:
            trace.move(pose, pen_down=bool(pen_down))
        else:
            trace.start = trace.pose = pose
    trace.pose = station.view.pose
    text = picture.svg(trace, title=station.title, obstacles=station.obstacles)
    return picture.png(text) if kind == "png" else text.encode()
