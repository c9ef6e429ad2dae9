"""Calibrating which engine turns which wheel, and which way."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Any

import msgspec

from turtlewire.robots.calibrating.procedure import REST_S, Procedure
from turtlewire.robots.calibrating.trials import Quantity, Question

if TYPE_CHECKING:
    from turtlewire.robots.calibrating.procedure import Trials
    from turtlewire.robots.calibrating.trials import Signal, Trial
    from turtlewire.robots.calibration import TwoEngineCalibration
    from turtlewire.robots.two_engine import TwoEngine  # noqa: F401 - a forward reference

# An engine is tried for so long, with this part of its driving range.
ENGINE_S, ENGINE_PART = 0.6, 0.5
WAYS = ("left", "left back", "right", "right back", "none")


class EngineSteps(Procedure["TwoEngine"]):
    """The step of the engines.

    Attributes:
        engines: how many engines the robot has; 0: it keeps its speeds by itself.
    """

    calibration: TwoEngineCalibration
    engines: int
    _old: TwoEngineCalibration

    @abstractmethod
    def _set(self, **values: Any) -> None:
        """Change values of the calibration."""

    def _measure_engines(self) -> Trials[None]:
        """Each engine is tried alone; the first ones that turn a wheel each are those of the wheels."""
        found: dict[str, tuple[int, bool]] = {}
        present = [self.calibration.left_engine, self.calibration.right_engine]
        others = [number for number in range(self.engines) if number not in present]
        for number in [*present, *others] if self.engines else ():
            answer = (yield self._engine(number)).answers[0]
            if isinstance(answer, str) and answer != "none":
                side, _, back = answer.partition(" ")
                found.setdefault(side, (number, bool(back)))
            if len(found) == 2:
                break
        if len(found) < 2:
            return
        for side, (number, is_reversed) in found.items():
            self._find(f"{side}_engine", "", getattr(self._old, f"{side}_engine"), [str(number)])
            was = str(getattr(self._old, f"{side}_reversed")).lower()
            self._find(f"{side}_reversed", "", was, [str(is_reversed).lower()])
        self._set(
            **{f"{side}_engine": number for side, (number, _) in found.items()},
            **{f"{side}_reversed": is_reversed for side, (_, is_reversed) in found.items()},
        )

    def _engine(self, number: int) -> Trial:
        def act(_: Signal) -> None:
            alone = msgspec.structs.replace(
                self.calibration,
                left_engine=number,
                right_engine=0 if number else 1,
                left_reversed=False,
                right_reversed=False,
            )
            self.robot.recalibrate(alone)
            self.robot.hold(self.calibration.left.portion(ENGINE_PART), 0, ENGINE_S)
            self.robot.wait(REST_S)

        return self._trial(
            f"Engine {number} turns forward for {ENGINE_S:g} s.",
            "It may stand where it is, with 0.3 m free around it. Watch its wheels.",
            act,
            Question(
                text="Which wheel turned, and did it turn back?", quantity=Quantity.WHEEL_WAY, choices=WAYS
            ),
        )
