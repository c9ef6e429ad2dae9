"""The messages of Serial Protocol 0.1. Generated from spec/protocols/frame*.toml by `make generate`.

Do not edit.
"""

from __future__ import annotations

from typing import ClassVar

from turtlewire.protocols.frame.message import FrameMessage
from turtlewire.protocols.message import Field


class SetServoPosition(FrameMessage, frozen=True, gc=False):
    """Move a servo to an absolute position."""

    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("servo_id", "u8", 0, 255, "servo number"),
        Field("position_deg", "u8", 0, 180, "degrees"),
    )
    servo_id: int
    position_deg: int


class EngineForward(FrameMessage, frozen=True, gc=False):
    """Turn an engine on with a speed; 0 stops it."""

    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("engine_id", "u8", 0, 255, "engine number"),
        Field("speed", "u8", 0, 255, "0 still, 255 full speed"),
    )
    engine_id: int
    speed: int


class EngineBackward(FrameMessage, frozen=True, gc=False):
    """Turn an engine on in the opposite direction with a speed; 0 stops it."""

    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("engine_id", "u8", 0, 255, "engine number"),
        Field("speed", "u8", 0, 255, "0 still, 255 full speed"),
    )
    engine_id: int
    speed: int


class EngineDirectionUnknown(FrameMessage, frozen=True, gc=False):
    """An engine's speed, direction unknown: forward and backward have the same type."""

    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("engine_id", "u8", 0, 255, "engine number"),
        Field("speed", "u8", 0, 255, "0 still, 255 full speed"),
    )
    engine_id: int
    speed: int


MESSAGES: tuple[type[FrameMessage], ...] = (
    SetServoPosition,
    EngineForward,
    EngineBackward,
    EngineDirectionUnknown,
)
