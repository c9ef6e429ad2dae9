"""Measuring a robot's calibration: what it does when it is told something, by tape, protractor and eye.

A procedure is a list of steps, each of which makes trials: the robot does something, a person measures it, and from
that follows what is tried next. ``guide`` goes through them; who measures is a ``Person``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from turtlewire.robots.calibrating.procedure import Choice, Person, Procedure, Progress, guide
from turtlewire.robots.calibrating.simulated_person import SimulatedPerson
from turtlewire.robots.calibrating.trials import (
    Answer,
    Finding,
    ImplausibleError,
    Outcome,
    Plan,
    Quantity,
    Question,
    Signal,
    Trial,
)

if TYPE_CHECKING:
    from turtlewire.robots.car import Settings as CarSettings
    from turtlewire.robots.two_engine import Settings as TwoEngineSettings
    from turtlewire.robots.walter import Settings as WalterSettings

__all__ = [
    "Answer",
    "Choice",
    "Finding",
    "ImplausibleError",
    "Outcome",
    "Person",
    "Plan",
    "Procedure",
    "Progress",
    "Quantity",
    "Question",
    "Signal",
    "SimulatedPerson",
    "Trial",
    "guide",
    "procedure",
    "steps",
]


def procedure(
    robot: Any, settings: CarSettings | TwoEngineSettings | WalterSettings, plan: Plan
) -> Procedure[Any]:
    """The procedure for a robot that is driven by these settings. Raises ``UsageError`` for a step that it has not."""
    from turtlewire.robots import car, walter
    from turtlewire.robots.calibrating.car import CarProcedure
    from turtlewire.robots.calibrating.two_engine import TwoEngineProcedure
    from turtlewire.robots.calibrating.walter import WalterProcedure

    if isinstance(settings, walter.Settings):
        return WalterProcedure(robot, settings, plan)
    if isinstance(settings, car.Settings):
        return CarProcedure(robot, settings.calibration, plan)
    return TwoEngineProcedure(robot, settings, plan)


def steps(protocol: str) -> dict[str, str]:
    """The steps of the robots that speak a protocol: what each of them measures, by name."""
    from turtlewire.robots.calibrating.car import CarProcedure
    from turtlewire.robots.calibrating.two_engine import TwoEngineProcedure
    from turtlewire.robots.calibrating.walter import WalterProcedure

    kinds: dict[str, type[Procedure[Any]]] = {
        "walter": WalterProcedure,
        "simple": CarProcedure,
        "frame": TwoEngineProcedure,
    }
    return kinds[protocol].STEPS
