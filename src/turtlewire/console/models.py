"""What is said over HTTP; the stream's messages are those of ``messages``."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, JsonValue, StrictBool, StrictStr

Millimetres = float


class Model(BaseModel):
    """Nothing but what it says."""

    model_config = ConfigDict(extra="forbid")


class Refusal(BaseModel):
    """Something was not done: why, for machines and for people."""

    code: str
    text: str
    details: JsonValue = None


class NewSession(Model):
    """Somebody begins to use the console."""

    name: str = Field("", max_length=200, description="what others are shown")


class SessionOpened(BaseModel):
    """A session: its secret is sent as ``X-Session`` from then on."""

    session: str
    id: int
    name: str


class Robot(BaseModel):
    """A robot, and what does not change from moment to moment."""

    name: str
    title: str
    protocol: Literal["walter", "simple", "frame"]
    simulated: bool
    reached: bool
    error: str | None
    features: list[str]
    obstacles: list[list[Millimetres]] = Field(
        description="walls (x1, y1, x2, y2) and round things (x, y, radius)"
    )
    origin: dict[str, float] | None = Field(
        description="where on the ground its coordinates begin, and which way they look; null: nobody knows"
    )
    combines: bool = Field(description="it drives and turns at the same time")
    steers: bool = Field(description="it turns by its front wheels")


class State(BaseModel):
    """A robot at one moment; see the stream's message ``state``."""

    stamp: float
    robot: str
    view: dict[str, Any]
    wheel: dict[str, Any]
    program: dict[str, Any] | None = None
    faults: dict[str, Any] | None = None


class PathPiece(BaseModel):
    """A part of a robot's path: its points replace everything from the index ``from`` on."""

    generation: int
    start: int = Field(serialization_alias="from")
    points: list[Annotated[list[float], Field(min_length=3, max_length=3)]] = Field(
        description="x, y, and 1 where the pen was down on the way there"
    )


class WheelAction(Model):
    """What somebody does about a robot's wheel; ``to`` is the ``id`` of who asks, of all who ask the first."""

    action: Literal["take", "ask", "give", "keep", "release"]
    to: int | None = Field(None, ge=0, le=2**53)


class Command(Model):
    """Something that a robot does once; a value of null: the other way round than it is."""

    command: Literal["pen", "lamp", "resume", "clean", "key"]
    value: StrictBool | StrictStr | None = None


class Done(BaseModel):
    """It was done, or is about to be."""

    ok: Literal[True] = True
