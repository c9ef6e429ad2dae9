"""The robots of a fleet as columns of numbers: what they are like, and how they are now."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Self

import numpy as np
import numpy.typing as npt

from turtlewire.simulator.car import CarSettings
from turtlewire.simulator.frame_robot import FrameRobotSettings
from turtlewire.simulator.settings import FULL_SPEED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from turtlewire.simulator.scalar_fleet import AnySettings

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Index = npt.NDArray[np.intp]
CAR, FRAME, WALTER = 0, 1, 2


@dataclass
class Columns:
    """Arrays of equal length, one place for each robot."""

    def take(self, index: Index) -> Self:
        """Copies of what belongs to some of the robots."""
        return type(self)(**{f.name: getattr(self, f.name)[index] for f in fields(self)})

    def put(self, index: Index, part: Self) -> None:
        """Take over what has become of some of the robots."""
        for f in fields(self):
            getattr(self, f.name)[index] = getattr(part, f.name)


@dataclass
class Kinds(Columns):
    """What the robots are like: their settings."""

    kind: npt.NDArray[np.int8]
    radius_mm: Floats
    track_mm: Floats
    offset_mm: Floats
    wheelbase_mm: Floats
    dead: Floats
    mm_per_s: Floats  # for each unit of the first set-point
    second_per_unit: Floats  # of the second one: mm/s (frame), degrees/s (WALTER), degrees of lock (car)
    trim_deg: Floats
    steer_deg_per_s: Floats
    backward: Floats  # the part of the speed that it has backwards
    lag_s: Floats
    coast_s: Floats  # the lag when it is told to stand still
    sag: Floats
    battery_s: Floats
    slip: Floats
    noise_mm: Floats

    @classmethod
    def of(cls, robots: Sequence[AnySettings]) -> Self:
        """What robots with these settings are like."""
        rows = [_row(settings) for settings in robots]
        columns = {name: np.array([row[name] for row in rows], dtype=np.float64) for name in rows[0]}
        return cls(kind=columns.pop("kind").astype(np.int8), **columns)


def _row(settings: AnySettings) -> dict[str, float]:
    row: dict[str, float] = {
        "kind": WALTER,
        "radius_mm": settings.radius_mm,
        "track_mm": settings.track_mm,
        "offset_mm": settings.offset_mm,
        "wheelbase_mm": 1.0,
        "dead": 0.0,
        "trim_deg": 0.0,
        "steer_deg_per_s": np.inf,
        "backward": 1.0,
        "lag_s": 0.0,
        "coast_s": 0.0,
        "sag": settings.sag,
        "battery_s": settings.battery_s,
        "slip": settings.slip,
        "noise_mm": settings.noise,
    }
    if isinstance(settings, CarSettings):
        return row | {
            "kind": CAR,
            "wheelbase_mm": settings.wheelbase_mm,
            "dead": settings.dead_pwm,
            "mm_per_s": settings.mm_per_s_per_pwm,
            "second_per_unit": settings.max_lock_deg / FULL_SPEED,
            "trim_deg": settings.trim_deg,
            "steer_deg_per_s": settings.steer_deg_per_s,
            **_motors(settings),
        }
    if isinstance(settings, FrameRobotSettings):
        return row | {
            "kind": FRAME,
            "dead": settings.dead_pwm,
            "mm_per_s": settings.mm_per_s_per_pwm,
            "second_per_unit": settings.mm_per_s_per_pwm * settings.right_factor,
            **_motors(settings),
        }
    return row | {
        "mm_per_s": settings.mm_per_s_per_unit,
        "second_per_unit": settings.deg_per_s_per_unit,
    }


def _motors(settings: CarSettings | FrameRobotSettings) -> dict[str, float]:
    return {
        "backward": settings.backward_factor,
        "lag_s": settings.lag_s,
        "coast_s": settings.lag_s if settings.coast_s is None else settings.coast_s,
    }


@dataclass
class State(Columns):
    """How the robots are now."""

    x_mm: Floats
    y_mm: Floats
    heading_deg: Floats
    first: Floats  # set-points
    second: Floats
    left: Floats  # mm/s: the left engine, or a car's or a WALTER's way ahead
    right: Floats  # mm/s: the right engine, or a WALTER's rim
    steer_deg: Floats
    used_s: Floats
    grip_left: Floats
    grip_right: Floats
    free_mm: Floats
    bumped: Flags
