"""What a page says over its stream, and the parts of what it is told: JSON, read strictly."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

import msgspec
from msgspec import Meta

Fraction = Annotated[float, Meta(ge=-1.0, le=1.0)]
Count = Annotated[int, Meta(ge=0, le=2**53)]
Name = Annotated[str, Meta(max_length=200)]


class Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Something that a page says."""


class Watch(Message, tag="watch", frozen=True):
    """Tell me of this robot from now on."""

    robot: Name


class Drive(Message, tag="drive", frozen=True):
    """A set-point: see ``setpoints.SetPoint``."""

    robot: Name
    number: Count
    grip: Count
    speed: Fraction
    turn: Fraction
    stamp: float
    age_ms: Annotated[float, Meta(ge=0.0)]
    horn: bool = False


class Release(Message, tag="release", frozen=True):
    """Nothing is held any more."""

    robot: Name


class Stop(Message, tag="stop", frozen=True):
    """Stop this robot, or all."""

    robot: Name | None = None


class TurnWheel(Message, tag="wheel", frozen=True):
    """About a robot's wheel: see ``wheel``."""

    robot: Name
    action: Literal["take", "ask", "give", "keep", "release"]
    to: Count | None = None


class Traffic(Message, tag="traffic", frozen=True):
    """Tell me what passes on the wires of the robots that I watch, or do not."""

    on: bool


class Visible(Message, tag="visible", frozen=True):
    """Whether the page is seen."""

    visible: bool


class Rename(Message, tag="name", frozen=True):
    """Call me so."""

    name: Name


FromPage: TypeAlias = Watch | Drive | Release | Stop | TurnWheel | Traffic | Visible | Rename
decoder: msgspec.json.Decoder[FromPage] = msgspec.json.Decoder(FromPage)
encoder = msgspec.json.Encoder()


def raw(value: Any) -> msgspec.Raw:
    """A part of a message that several are told."""
    return msgspec.Raw(encoder.encode(value))
