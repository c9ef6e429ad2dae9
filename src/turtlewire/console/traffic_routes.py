"""The console's routes for what passes on the wires: seen, saved, sent, and damaged on purpose."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

from fastapi import APIRouter, Query, Response
from pydantic import BaseModel, Field

from turtlewire.console.faulting import MAX_DELAY_S, MAX_SPLIT, MAX_STALL_S, MAX_UNPLUG_S
from turtlewire.console.models import Model
from turtlewire.console.refusals import Refused
from turtlewire.console.routes import DriverOf, StationOf  # noqa: TC001 (FastAPI looks at them)
from turtlewire.console.sending import sendable
from turtlewire.errors import (
    LimitReachedError,
    LinkError,
    MessageError,
    NotSupportedError,
    StoppedError,
    TurtlewireError,
    UsageError,
)
from turtlewire.links.faults import Faults
from turtlewire.protocols import forms
from turtlewire.protocols.catalogue import SENDERS, Packet
from turtlewire.protocols.frame.message import FrameMessage

if TYPE_CHECKING:
    from turtlewire.console.station import Station
    from turtlewire.console.traffic import Traffic
    from turtlewire.protocols.message import AnyField, AnyMessage

router = APIRouter(prefix="/api/robots/{robot}", tags=["traffic"])
MAX_LINES = 1000
Rate = Annotated[
    float, Field(0.0, ge=0.0, le=1.0, allow_inf_nan=False, description="of each byte: how often")
]
# Codes of errors that the page has words for; whatever else there is, the robot told.
CODES: tuple[tuple[type[TurtlewireError], str], ...] = (
    (StoppedError, "stopped"),
    (LimitReachedError, "limit"),
    (NotSupportedError, "not_supported"),
    (MessageError, "bad_message"),
    (UsageError, "bad_message"),
    (LinkError, "link"),
)


class Line(BaseModel):
    """A message, an error, skipped bytes, or a note about the link."""

    number: int
    time_s: float = Field(description="since the console was started")
    sender: Literal["host", "robot"] | None = Field(alias="from")
    offset: int = Field(description="where in all that this one has sent its first byte stands")
    raw: str = Field(description="its bytes, in hexadecimal")
    kind: Literal["message", "error", "skipped", "note"]
    text: str
    names: list[str] = Field(description="of the messages that it consists of")


class TrafficPiece(BaseModel):
    """Some lines in a row; ``lost`` were there before them, and are not kept any more."""

    lines: list[Line]
    lost: int
    following: int = Field(description="what to ask for next, as ``since``")


class FieldOf(BaseModel):
    """A field of a message: low <= value <= high, or one of the names."""

    name: str
    low: float
    high: float
    unit: str
    choices: list[str]


class MessageOf(BaseModel):
    """A message that the robot understands."""

    name: str
    about: str
    fields: list[FieldOf]


class Text(Model):
    """A message by its text form, as ``turtlewire encode`` reads it."""

    text: str = Field(min_length=1, max_length=2000, examples=["forward distance_half_mm=200"])


class Bytes(BaseModel):
    """What a text form means, and its bytes; those of a frame as if its number were 0."""

    text: str
    raw: str


class Problem(BaseModel):
    """What is wrong with a text form, and where: from a character to behind another; null: all of it."""

    code: str
    text: str
    start: int | None = None
    end: int | None = None


class Checked(BaseModel):
    """What a text form means, or what is wrong with it."""

    bytes: Bytes | None = None
    problem: Problem | None = None


class FaultsOf(Model):
    """What goes wrong on the way to a simulated robot; without any, nothing does."""

    lose: Rate
    add: Rate
    flip: Rate
    duplicate: Rate
    delay_s: float = Field(0.0, ge=0.0, le=MAX_DELAY_S, allow_inf_nan=False, description="at most so late")
    split: int = Field(
        0, ge=0, le=MAX_SPLIT, description="bytes come in pieces of at most so many; 0: as they are"
    )
    to: Literal["", "robot", "host"] = Field("", description="the only direction with faults; empty: both")


class FaultsNow(FaultsOf):
    """What goes wrong now, and what it has done so far."""

    on: bool
    stalled_s: int
    unplugged_s: int
    lost: int
    added: int
    flipped: int
    duplicated: int


class Stall(Model):
    """For how long nothing gets through, of the robot's time."""

    seconds: float = Field(gt=0.0, le=MAX_STALL_S, allow_inf_nan=False)


class Unplug(Model):
    """For how long the link is gone, of the robot's time."""

    seconds: float = Field(gt=0.0, le=MAX_UNPLUG_S, allow_inf_nan=False)


# ---------------------------------------------------------------------- traffic


@router.get("/traffic")
def traffic(
    station: StationOf,
    since: Annotated[int, Query(ge=0, le=2**53, description="the number of the first line")] = 0,
    limit: Annotated[int, Query(ge=1, le=MAX_LINES)] = 200,
    newest: Annotated[
        bool, Query(description="of more than the limit, the newest rather than the oldest")
    ] = False,
) -> TrafficPiece:
    """What passed on the wire, both directions, decoded: from a number on, the oldest first."""
    piece = station.traffic.newest(since, limit) if newest else station.traffic.read(since, limit)
    lines = [Line(**line.as_json()) for line in piece.lines]
    return TrafficPiece(lines=lines, lost=piece.lost, following=piece.following or since)


@router.get("/traffic/recording", response_class=Response)
def recording(station: StationOf) -> Response:
    """All that is kept, as a recording that ``turtlewire decode`` reads."""
    return Response(
        station.traffic.recording(),
        media_type="application/jsonl",
        headers={"Content-Disposition": 'attachment; filename="recording.jsonl"'},
    )


# ---------------------------------------------------------------------- messages


@router.get("/messages")
def messages(station: StationOf) -> list[MessageOf]:
    """The messages that this robot understands."""
    return [_about(each) for each in station.traffic.codec.types("host")]


def _about(message_type: type[AnyMessage]) -> MessageOf:
    return MessageOf(
        name=message_type.name(),
        about=" ".join((message_type.__doc__ or "").split()),
        fields=[_field(field) for field in message_type.FIELDS],
    )


def _field(field: AnyField) -> FieldOf:
    choices = [name for name, _ in getattr(field, "choices", ())]
    return FieldOf(name=field.name, low=field.low, high=field.high, unit=field.unit, choices=choices)


@router.post("/messages/check")
def check(station: StationOf, message: Text) -> Checked:
    """What a text form means, for whoever is writing it. Nothing is sent."""
    try:
        return Checked(bytes=_bytes(station.traffic, _read(station, message.text)))
    except Refused as error:
        return Checked(problem=Problem(code=error.code, text=error.text, **(error.details or {})))


@router.post("/messages")
async def send(station: StationOf, driver: DriverOf, message: Text) -> Bytes:
    """Have the driver send a message as it is; of a query, the answer has come when this is answered.

    Of a message that is wrong, ``details`` of the refusal has the place (``start``, ``end``). What goes on until told
    otherwise ends after two seconds, if nothing newer was sent.
    """
    del driver
    if station.program.is_running:
        raise Refused(409, "program_runs", "a program is running: stop it first, then send messages")
    read = _read(station, message.text)
    sent = _bytes(station.traffic, read)
    try:
        await station.sending.send(sendable(read))
    except TurtlewireError as error:
        raise _refusal(error) from error
    return sent


def _read(station: Station, text: str) -> AnyMessage:
    codec = station.traffic.codec
    try:
        message = codec.parse(text)
        for each in sendable(message):
            if type(each) not in codec.types(SENDERS[0]):
                raise MessageError(f"{each.name()} is what a robot says, not what it is told")
    except TurtlewireError as error:
        raise _refusal(error) from None
    return message


def _bytes(traffic: Traffic, message: AnyMessage) -> Bytes:
    numbered = message
    if isinstance(message, Packet | FrameMessage):
        numbered = Packet(0, sendable(message))
    try:
        return Bytes(text=str(message), raw=forms.hexadecimal(traffic.codec.encode(numbered)))
    except TurtlewireError as error:
        raise _refusal(error) from None


def _refusal(error: TurtlewireError) -> Refused:
    if isinstance(error, Refused):
        return error
    code = next((code for kind, code in CODES if isinstance(error, kind)), "robot")
    details: dict[str, Any] | None = None
    if isinstance(error, MessageError) and error.place is not None:
        details = {"start": error.place[0], "end": error.place[1]}
    return Refused(422 if code == "bad_message" else 409, code, str(error), details)


# ---------------------------------------------------------------------- faults


@router.get("/faults")
def faults(station: StationOf) -> FaultsNow | None:
    """What goes wrong on the way to this robot, on purpose; null: it is a real one."""
    state = station.faulting.state()
    return None if state is None else FaultsNow(**state)


@router.put("/faults")
async def set_faults(station: StationOf, driver: DriverOf, faults: FaultsOf) -> FaultsNow:
    """From now on, have these faults, and no others."""
    del driver
    _need_simulated(station)
    station.faulting.set(Faults(**faults.model_dump()))
    return _now(station)


@router.post("/faults/stall")
async def stall(station: StationOf, driver: DriverOf, stall: Stall) -> FaultsNow:
    """Let nothing through for some seconds; then all of it comes."""
    del driver
    _need_simulated(station)
    if not station.faulting.stall(stall.seconds):
        raise _no_link(station)
    return _now(station)


@router.post("/faults/unplug")
async def unplug(station: StationOf, driver: DriverOf, unplug: Unplug) -> FaultsNow:
    """Pull the plug, and put it back after some seconds."""
    del driver
    _need_simulated(station)
    if not station.faulting.unplug(unplug.seconds):
        raise _no_link(station)
    return _now(station)


def _now(station: Station) -> FaultsNow:
    return FaultsNow(**(station.faulting.state() or {}))


def _need_simulated(station: Station) -> None:
    if not station.faulting.is_possible:
        raise Refused(
            409,
            "not_simulated",
            f"{station.name} is a real robot: only simulated ones have faults on purpose",
        )


def _no_link(station: Station) -> Refused:
    return Refused(409, "not_reached", f"{station.name} is not reached yet: there is nothing to hold back")
