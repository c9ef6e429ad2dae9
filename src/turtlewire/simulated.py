"""What a ``sim:`` URL describes: a simulated robot, and the options that are its driver's."""

from __future__ import annotations

import contextlib
import math
from typing import TYPE_CHECKING, Any, NamedTuple

from turtlewire import configuration
from turtlewire.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.configuration import Target
    from turtlewire.simulator.settings import BodySettings
    from turtlewire.turtle import Pose

# What numbers among the settings of a simulated robot are annotated with, and read by.
NUMBERS: dict[str, Callable[[str], Any]] = {
    "int": int,
    "int | None": int,
    "float": float,
    "float | None": float,
    "bool": lambda text: configuration.YES_NO[text.lower()],
}
OTHERS = {
    "walter": ("arena", "start", "basic", "groups", "mode"),
    "simple": ("arena", "start"),
    "frame": ("arena", "start", "dialect"),
}


class Simulated(NamedTuple):
    """A simulated robot and what belongs to it.

    Attributes:
        robot: the robot, not yet connected to anything.
        pace: seconds of its time for each second on the wall; None: as fast as possible.
        target: what it was made of; those of the options that are its driver's are among the overrides now.
    """

    robot: Any
    pace: float | None
    target: Target


def simulated(target: Target) -> Simulated:
    """The robot that the target of a ``sim:`` URL describes.

    Raises ``UsageError`` or, for its arena or dialect, ``DataError``.
    """
    from dataclasses import fields

    name, protocol = target.name, target.protocol
    robot_type, settings_type = _simulated_types(protocol)
    numbers = {
        field.name: NUMBERS[str(field.type)] for field in fields(settings_type) if field.type in NUMBERS
    }
    values: dict[str, Any] = {}
    overrides: dict[str, Any] = {}
    pace: float | None = None
    for option, text in target.simulation.items():
        if option == "pace":
            pace = _pace(name, text)
        elif option in numbers:
            values[option] = _number(name, option, text, numbers[option])
        elif option in OTHERS[protocol]:
            values |= _other(name, option, text, overrides)
        elif option in configuration.SETTINGS[protocol]:
            overrides[option] = configuration.read_setting(protocol, option, text, repr(name))
        else:
            known = ["pace", "faults", *numbers, *OTHERS[protocol]]
            known += [setting for setting in configuration.SETTINGS[protocol] if setting not in known]
            raise UsageError(
                f"{name!r}: unknown option {option!r}; a simulated robot and its driver have {', '.join(known)}"
            )
    if "dialect" in values:
        values = {"baud": values["dialect"].baud, **values}
    return Simulated(
        robot_type(settings_type(**values)),
        pace,
        target._replace(overrides={**overrides, **target.overrides}),
    )


def _simulated_types(protocol: str) -> tuple[Callable[[Any], Any], type[BodySettings]]:
    if protocol == "walter":
        from turtlewire.simulator.walter import Settings, SimulatedWalter

        return SimulatedWalter, Settings
    if protocol == "simple":
        from turtlewire.simulator.car import CarSettings, SimulatedCar

        return SimulatedCar, CarSettings
    from turtlewire.simulator.frame_robot import FrameRobotSettings, SimulatedFrameRobot

    return SimulatedFrameRobot, FrameRobotSettings


def _pace(name: str, text: str) -> float | None:
    if text in ("max", "real"):
        return None if text == "max" else 1.0
    with contextlib.suppress(ValueError):
        if 0.0 < float(text) < math.inf:
            return float(text)
    raise UsageError(
        f"{name!r}: pace is {text!r}, but must be max, real, or a number above 0 (times real time)"
    )


def _start(name: str, text: str) -> Pose:
    from turtlewire.turtle import Pose

    try:
        return Pose(*map(float, text.split(",")))
    except (TypeError, ValueError):
        raise UsageError(
            f"{name!r}: start is {text!r}, but must be x,y or x,y,heading, in millimetres and degrees"
        ) from None


def _number(name: str, option: str, text: str, kind: Callable[[str], Any]) -> Any:
    try:
        return kind(text)
    except ValueError:
        raise UsageError(f"{name!r}: {option} is {text!r}, but must be a number") from None
    except KeyError:
        raise UsageError(f"{name!r}: {option} is {text!r}, but must be yes or no") from None


def _other(name: str, option: str, text: str, overrides: dict[str, Any]) -> dict[str, Any]:
    if option == "start":
        return {"start": _start(name, text)}
    if option == "mode":
        from turtlewire.protocols.walter.codec import Mode

        if text.upper() not in Mode.__members__:
            raise UsageError(f"{name!r}: mode is {text!r}, but must be logo or direct (W7)")
        return {"mode": Mode[text.upper()]}
    if option == "groups":
        return {"groups": frozenset(text.upper())}
    if option == "basic":
        return {"groups": frozenset()} if text not in ("0", "no", "false") else {}
    if option == "dialect":
        # Both ends speak it.
        overrides["dialect"] = configuration.read_setting("frame", option, text, "dialect")
        return {"dialect": overrides["dialect"]}
    from turtlewire.simulator.world import load_arena

    return {"world": load_arena(text)}
