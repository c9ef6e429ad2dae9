"""The console's HTTP routes: what the page can do, for machines, too."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

from fastapi import APIRouter, Depends, Header, Query, Request, Response, WebSocket

from turtlewire.console import models, views
from turtlewire.console.console import Console
from turtlewire.console.pictures import KINDS
from turtlewire.console.refusals import Refused
from turtlewire.console.sessions import Session
from turtlewire.console.station import Station
from turtlewire.console.stream import Stream
from turtlewire.helm.path import MAX_POINTS
from turtlewire.helm.wishes import Action, Order

if TYPE_CHECKING:
    from starlette.requests import HTTPConnection

router = APIRouter(prefix="/api")
KEYS = {
    "move_faster": Action.MOVE_FASTER,
    "move_slower": Action.MOVE_SLOWER,
    "turn_faster": Action.TURN_FASTER,
    "turn_slower": Action.TURN_SLOWER,
    "raise_pen": Action.RAISE_PEN,
    "lower_pen": Action.LOWER_PEN,
}
SWITCHES = {"pen": Action.PEN, "lamp": Action.LAMP}
ORDERS = {"resume": Action.RESUME, "clean": Action.CLEAN}


def console_of(connection: HTTPConnection) -> Console:
    """The console that this is asked of."""
    console: Console = connection.app.state.console
    return console


def address_of(connection: HTTPConnection) -> str:
    """Where whoever asks is."""
    return connection.client.host if connection.client else "?"


def _console(request: Request) -> Console:
    return console_of(request)


ConsoleOf = Annotated[Console, Depends(_console)]


def _station(robot: str, console: ConsoleOf) -> Station:
    return console.stations[robot]


def _session(
    console: ConsoleOf,
    x_session: Annotated[str, Header(description="the secret of a session: see /api/sessions")] = "",
) -> Session:
    return console.sessions.find(x_session, console.now())


def _perhaps_session(console: ConsoleOf, x_session: Annotated[str, Header()] = "") -> Session | None:
    return console.sessions.find(x_session, console.now()) if x_session else None


StationOf = Annotated[Station, Depends(_station)]
SessionOf = Annotated[Session, Depends(_session)]
PerhapsSession = Annotated[Session | None, Depends(_perhaps_session)]


def _driver(console: ConsoleOf, station: StationOf, session: SessionOf) -> Session:
    station.wheel.need(session.id, console.now())
    station.wheel.active(session.id, console.now())
    return session


DriverOf = Annotated[Session, Depends(_driver)]

# ---------------------------------------------------------------------- sessions and robots


@router.post("/sessions", status_code=201)
def open_session(
    console: ConsoleOf, request: Request, new: models.NewSession | None = None
) -> models.SessionOpened:
    """Begin to use the console: whoever drives, runs programs or sends messages needs a session."""
    console.forget_unused()
    session = console.sessions.open(
        new.name if new else "", address_of(request), console.now(), has_page=False
    )
    return models.SessionOpened(session=session.secret, id=session.id, name=session.name)


@router.get("/robots")
async def robots(console: ConsoleOf) -> list[models.Robot]:
    """The robots of this console."""
    return [models.Robot(**robot) for robot in console.robots()]


@router.get("/robots/{robot}", response_model=models.State)
async def state(console: ConsoleOf, station: StationOf) -> Response:
    """A robot as it is now; the stream tells the same again and again."""
    now = console.now()
    told = views.state(station, console.sight(station).look(now), None, now)
    return Response(views.encoded(told), media_type="application/json")


@router.get("/robots/{robot}/path", response_model=models.PathPiece)
def path(station: StationOf, since: Annotated[int, Query(ge=0, le=2**53)] = 0) -> Response:
    """Where the robot has been, from an index on. Its last point may still move: ask for that again."""
    piece = station.path.since(since, MAX_POINTS)
    told = {"generation": piece.generation, "from": piece.start, "points": piece.points}
    return Response(views.encoded(told), media_type="application/json")


@router.get(
    "/robots/{robot}/picture.{kind}",
    response_class=Response,
    responses={200: {"content": {"image/svg+xml": {}, "image/png": {}}}},
)
async def picture(console: ConsoleOf, station: StationOf, kind: Literal["svg", "png"]) -> Response:
    """What the robot drew, as a picture."""
    content = await console.painter.paint(station, kind)
    name = f"attachment; filename={station.name}.{kind}"
    return Response(content, media_type=KINDS[kind], headers={"content-disposition": name})


# ---------------------------------------------------------------------- driving


@router.post("/stop")
async def stop_all(console: ConsoleOf, request: Request, session: PerhapsSession) -> models.Done:
    """Stop every robot, whoever drives. Needs no session; whose it is loses the wheel no less."""
    console.stations.stop(session, _who(request, session))
    return models.Done()


@router.post("/robots/{robot}/stop")
async def stop(station: StationOf, request: Request, session: PerhapsSession) -> models.Done:
    """Stop this robot, whoever drives, ahead of everything. Needs no session."""
    station.stop(session, _who(request, session))
    return models.Done()


def _who(request: Request, session: Session | None) -> str:
    return f"{session.name if session else 'somebody'} at {address_of(request)}"


@router.post("/robots/{robot}/wheel")
async def wheel(
    console: ConsoleOf, station: StationOf, session: SessionOf, action: models.WheelAction
) -> dict[str, Any]:
    """Take the wheel, ask for it, give or keep it, or release it; returns who drives now."""
    station.turn_wheel(session, action.action, action.to, console.now())
    return views.wheel_of(station, console.sessions, console.now())


@router.post("/robots/{robot}/commands", status_code=202)
async def command(
    console: ConsoleOf, station: StationOf, driver: DriverOf, command: models.Command
) -> models.Done:
    """Have the robot do something once; what becomes of it, the stream tells."""
    station.do(driver, _order(command), console.now())
    return models.Done()


def _order(command: models.Command) -> Order:
    value = command.value
    if command.command in SWITCHES and not isinstance(value, str):
        return Order(SWITCHES[command.command], None if value is None else int(value))
    if command.command in ORDERS and value is None:
        return Order(ORDERS[command.command])
    if command.command == "key" and value in KEYS:
        return Order(KEYS[str(value)])
    raise Refused(
        422,
        "value",
        f"{command.command} with the value {value!r} means nothing: pen and lamp take true, false or null, key takes "
        f"{', '.join(KEYS)}, the others none",
    )


# ---------------------------------------------------------------------- the stream


@router.websocket("/stream")
async def stream(socket: WebSocket) -> None:
    """One page: see ``stream``."""
    await socket.accept()
    try:
        served = Stream(console_of(socket), socket, address_of(socket))
    except Refused as refusal:
        await socket.close(1013, refusal.code)
        return
    await served.serve()
