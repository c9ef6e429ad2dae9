"""One page's WebSocket: what it wants in, what there is to be seen out.

A page that reads slowly is told the newest, never a backlog: the next message is made when the last one has gone out.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
from typing import TYPE_CHECKING, Any

import msgspec
from starlette.websockets import WebSocket, WebSocketDisconnect

from turtlewire.console import messages, views
from turtlewire.console.rates import Bucket
from turtlewire.console.refusals import Refused
from turtlewire.console.setpoints import SetPoint, SetPoints

if TYPE_CHECKING:
    from collections.abc import Iterator

    from turtlewire.console.console import Console
    from turtlewire.console.station import Station

log = logging.getLogger("turtlewire.console")
# At most so often is a page told anything, and at least so often one that drives: a new stamp.
TELL_S, STAMP_S = 0.05, 0.1
# A message is no longer than this; so many may come in a second, after a pause at once.
MAX_CHARACTERS = 4096
RATE_PER_S, AT_ONCE = 120.0, 240.0
# After so many messages that were too many, or none at all, the stream ends.
PATIENCE = 500
# Points of a path in one message.
MAX_POINTS = 2000
# Lines of traffic in one message.
MAX_LINES = 200
WHY = {
    "order": "a set-point came after a later one",
    "clock": "a set-point says that it was made before its stamp, or of a stamp that was never sent",
    "late": "a set-point was more than 300 ms old: it was dropped, and is not replayed",
}


class _Watched:
    """What a page has been told of one robot."""

    def __init__(self, station: Station) -> None:
        self.station = station
        self.revision = -1
        self.refused: int | None = None
        self.generation = -1
        self.points = 0
        self.changes = -1
        self.told_s = self.heard_s = -math.inf
        self.line = station.traffic.count


class Stream:
    """Serves one page.

    Args:
        console: what it is a page of.
        socket: accepted.
        address: where the page is.
    """

    def __init__(self, console: Console, socket: WebSocket, address: str) -> None:
        self._console = console
        self._socket = socket
        self._session = console.sessions.open("", address, console.now(), has_page=True)
        self._set_points = SetPoints()
        self._bucket = Bucket(RATE_PER_S, AT_ONCE)
        self._dropped = 0
        self._watched: dict[str, _Watched] = {}
        self._robots: list[dict[str, Any]] = []
        self._refusals: dict[tuple[str, str, int], dict[str, Any]] = {}
        self._told: set[tuple[str, str, int]] = set()
        self._wake = asyncio.Event()
        self._hears_traffic = False

    async def serve(self) -> None:
        """Until the page goes away; then it drives nothing any more."""
        teller = asyncio.create_task(self._keep_telling(), name="turtlewire stream")
        try:
            await self._hear()
        except (WebSocketDisconnect, RuntimeError):
            pass
        finally:
            for watched in self._watched.values():
                watched.station.watchers -= 1
            self._console.leave(self._session)
            teller.cancel()
            await asyncio.gather(teller, return_exceptions=True)

    # ------------------------------------------------------------------ heard

    async def _hear(self) -> None:
        while self._dropped < PATIENCE:
            text = await self._socket.receive_text()
            now = self._console.now()
            try:
                message = self._read(text)
                if not (self._bucket.take(now) or isinstance(message, messages.Stop | messages.Release)):
                    raise Refused(429, "rate", f"more than {RATE_PER_S:.0f} messages a second")
                self._do(message, now)
            except Refused as refusal:
                self._dropped += 1
                self._refuse("message", refusal)
        log.warning("refused %s: too many messages, or none at all", self._who)
        await self._socket.close(1008, "too many messages")

    @staticmethod
    def _read(text: str) -> messages.FromPage:
        if len(text) > MAX_CHARACTERS:
            raise Refused(413, "long", f"a message is at most {MAX_CHARACTERS} characters long")
        try:
            return messages.decoder.decode(text)
        except (msgspec.DecodeError, UnicodeError) as error:
            raise Refused(400, "message", f"this is no message of the stream: {error}") from None

    def _do(self, message: messages.FromPage, now: float) -> None:
        session, stations = self._session, self._console.stations
        match message:
            case messages.Drive():
                self._drive(message, now)
            case messages.Release(robot=robot):
                stations[robot].release(session)
            case messages.Stop(robot=None):
                stations.stop(session, self._who)
            case messages.Stop(robot=str(robot)):
                stations[robot].stop(session, self._who)
            case messages.TurnWheel(robot=robot, action=action, to=to):
                try:
                    stations[robot].turn_wheel(session, action, to, now)
                except Refused as refusal:
                    self._refuse("wheel", refusal, robot=robot)
            case messages.Watch(robot=robot):
                if robot not in self._watched:
                    self._watched[robot] = _Watched(stations[robot])
                    stations[robot].watchers += 1
            case messages.Visible(visible=False):
                for station in stations:
                    station.hid(session)
            case messages.Traffic(on=on):
                self._hear_traffic(on=on)
            case messages.Rename(name=name):
                self._console.sessions.rename(session, name)
            case _:
                pass
        self._wake.set()

    def _hear_traffic(self, *, on: bool) -> None:
        """From now on; what passed before, the page fetches."""
        if on and not self._hears_traffic:
            for watched in self._watched.values():
                watched.line = watched.station.traffic.count
        self._hears_traffic = on

    def _drive(self, message: messages.Drive, now: float) -> None:
        point = SetPoint(
            message.number,
            message.grip,
            message.speed,
            message.turn,
            message.horn,
            message.stamp,
            message.age_ms / 1000.0,
        )
        try:
            why = self._set_points.take(point, now)
            if why:
                raise Refused(409, why, WHY[why])
            self._console.stations[message.robot].drive(self._session, point, now)
        except Refused as refusal:
            self._refuse("drive", refusal, robot=message.robot, grip=message.grip)

    @property
    def _who(self) -> str:
        return f"{self._session.name} at {self._session.address}"

    def _refuse(self, what: str, refusal: Refused, *, robot: str | None = None, grip: int = -1) -> None:
        """Tell it, and the log, once for each grip."""
        about = (what, refusal.code, grip)
        if what != "drive" or about not in self._told:
            self._told = {each for each in self._told if each[2] == grip} | {about}
            log.info("refused %s: %s: %s", self._who, what, refusal.text)
            self._refusals[about] = {
                "type": "refused",
                "what": what,
                "robot": robot,
                "grip": grip if grip >= 0 else None,
                "code": refusal.code,
                "text": refusal.text,
            }
        self._wake.set()

    # ------------------------------------------------------------------ told

    async def _keep_telling(self) -> None:
        console, session = self._console, self._session
        self._robots = console.robots()
        await self._tell(
            {
                "type": "welcome",
                "session": session.secret,
                "id": session.id,
                "name": session.name,
                "stamp": console.now(),
                "robots": self._robots,
            }
        )
        while True:
            for message in self._news():
                await self._tell(message)
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(TELL_S):
                    await self._wake.wait()
            self._wake.clear()

    async def _tell(self, message: dict[str, Any]) -> None:
        if "stamp" in message:
            message["stamp"] = self._console.now()
        await self._socket.send_text(messages.encoder.encode(message).decode())

    def _news(self) -> Iterator[dict[str, Any]]:
        """What there is to tell now; each is made when the one before has gone out."""
        refusals = list(self._refusals.values())
        self._refusals.clear()
        yield from refusals
        robots = self._console.robots()
        if robots is not self._robots:
            self._robots = robots
            yield {"type": "robots", "robots": robots}
        for watched in list(self._watched.values()):
            message = self._state(watched, self._console.now())
            if message is not None:
                yield message
            if self._hears_traffic:
                yield from self._traffic(watched, self._console.now())

    def _state(self, watched: _Watched, now: float) -> dict[str, Any] | None:
        station = watched.station
        if now - watched.told_s < TELL_S:
            return None
        parts = self._console.sight(station).look(now)
        refused = station.refused(self._session)
        path = self._path(watched)
        drives = station.wheel.driver == self._session.id
        if (
            parts.revision == watched.revision
            and refused == watched.refused
            and path is None
            and not (drives and now - watched.told_s >= STAMP_S)
        ):
            return None
        watched.revision, watched.refused, watched.told_s = parts.revision, refused, now
        message = views.state(station, parts, self._session, now)
        if path is not None:
            message["path"] = path
        return message

    @staticmethod
    def _traffic(watched: _Watched, now: float) -> Iterator[dict[str, Any]]:
        """The newest that passed on a robot's wire, if anything has; what does not fit is counted."""
        if now - watched.heard_s < TELL_S:
            return
        lines, lost = watched.station.traffic.newest(watched.line, MAX_LINES)
        if lines:
            watched.heard_s, watched.line = now, lines[-1].number + 1
            yield {
                "type": "traffic",
                "robot": watched.station.name,
                "from": lines[0].number,
                "lines": [line.as_json() for line in lines],
                "lost": lost,
            }

    @staticmethod
    def _path(watched: _Watched) -> dict[str, Any] | None:
        """What is new of the path. Of a new generation only its name: the page fetches it."""
        path = watched.station.path
        changes = path.changes
        if changes == watched.changes:
            return None
        if path.generation != watched.generation:
            watched.generation, watched.points = path.generation, path.settled
            return {"generation": path.generation, "from": watched.points, "points": []}
        piece = path.since(watched.points, MAX_POINTS)
        if len(piece.points) < MAX_POINTS:
            watched.changes = changes
            watched.points = max(watched.points, min(path.settled, piece.start + len(piece.points)))
        else:
            watched.points = piece.start + len(piece.points) - 1
        return {"generation": piece.generation, "from": piece.start, "points": piece.points}
