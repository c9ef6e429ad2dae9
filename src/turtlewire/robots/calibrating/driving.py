"""What calibrating the robots has in common that are driven by time: for how long, how far, and until it rests."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import msgspec

from turtlewire.robots.calibrating.procedure import (
    FIRST_PART,
    KNOWN,
    LEAST_S,
    LIKELY,
    MOST_S,
    UNKNOWN,
    Procedure,
    RobotT,
    short_and_long,
)
from turtlewire.robots.calibrating.trials import Quantity, Question
from turtlewire.robots.calibration import CarCalibration, TwoEngineCalibration, lines

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from turtlewire.robots.calibrating.procedure import Trials
    from turtlewire.robots.calibrating.trials import Plan, Signal, Trial

# The strengths at which speed is measured, as parts of the driving range; at the first, a short and a long drive.
PARTS = (0.5, 1.0, 0.25)
SHORT_PART, LONG_PART = 0.25, 0.75
# So long it is looked whether a PWM moves it.
LOOK_S = 1.0
# No plan is made for a robot that is slower.
LEAST_MM_PER_S = 1.0
# No calibration has more; what seems to be is something else.
MOST_OVERRUN_S = 1.0
# What goes both ways as fast as this, as a part of it, needs no values of its own for the way back.
SAME_PART = 0.02
# A bell that rings while it still moves: it is driven so far before.
ROLL_PART = 0.3
ARC_PART = 0.3


class DrivenProcedure(Procedure[RobotT]):
    """The steps of a robot that is driven by PWM, for a time.

    Attributes:
        calibration: as far as it is known.
    """

    calibration: CarCalibration | TwoEngineCalibration

    def __init__(self, robot: RobotT, calibration: CarCalibration | TwoEngineCalibration, plan: Plan) -> None:
        super().__init__(robot, plan)
        self.calibration = calibration
        self._strengths: dict[float, int] = {}
        # How fast it was the last time, by PWM, ahead above 0.
        self._measured: dict[int, float] = {}

    def lines(self) -> Mapping[str, Any]:
        """What was found, as lines of the robot's table in ``robots.toml``."""
        return {"calibration": lines(self.calibration)} if self.found else {}

    def _keep(self) -> Callable[[], None]:
        found, calibration = super()._keep(), self.calibration

        def restore() -> None:
            found()
            self.calibration = calibration

        return restore

    def _set(self, **values: Any) -> None:
        self.calibration = msgspec.structs.replace(self.calibration, **values)

    @abstractmethod
    def _speed_at(self, pwm: int) -> float:
        """How fast it is at a PWM of -255..255 by its calibration: mm/s, 0 or above."""

    @abstractmethod
    def _held(self, pwm: int, seconds: float, settle_s: float | None = None) -> None:
        """Drive straight on, as far as is known what that is."""

    @abstractmethod
    def _rest(self) -> None:
        """Let it come to rest."""

    def _learn(self, pwm: int, seconds: float, driven_mm: float) -> None:
        """It has driven so far: what follows is planned by that."""
        self._measured[pwm] = driven_mm / (seconds + self.calibration.overrun_s)

    def _is_known(self, pwm: int) -> bool:
        """Whether anything was measured in that direction."""
        return any(other * pwm > 0 for other in self._measured)

    def _speed(self, pwm: int) -> float:
        """How fast it is, as far as is known: by the nearest PWM that was measured, that way if any was."""
        speed = self._speed_at(pwm)
        others = [other for other in self._measured if self._speed_at(other)]
        if others:
            nearest = min(others, key=lambda other: (other * pwm < 0, abs(other - pwm)))
            speed *= self._measured[nearest] / self._speed_at(nearest)
        return max(LEAST_MM_PER_S, speed)

    def _expected(self, pwm: int, seconds: float) -> float:
        """How far it should get."""
        return self._speed(pwm) * (seconds + self.calibration.overrun_s)

    def _seconds(self, pwm: int, part: float) -> float:
        """How long to drive for a part of the space."""
        if not self._is_known(pwm):
            part = min(part, FIRST_PART)
        seconds = part * self.plan.space_mm / self._speed(pwm) - self.calibration.overrun_s
        return round(min(MOST_S, max(LEAST_S, seconds)), 2)

    def _durations(self, pwm: int) -> tuple[float, float]:
        """A short drive and a long one."""
        return short_and_long(self._seconds(pwm, SHORT_PART), self._seconds(pwm, LONG_PART))

    def _plausible(self, question: Question, pwm: int, expected_mm: float) -> Question:
        """The question, with the answers that are plausible, by what is known so far."""
        if pwm in self._measured:
            factors, why = KNOWN, "by what was measured before"
        elif self._is_known(pwm):
            factors, why = LIKELY, "by what is known of it so far"
        else:
            factors, why = UNKNOWN, "or its motors are off"
        # What goes ahead in an arc gets less far ahead.
        low = factors[0] if question.quantity is Quantity.DISTANCE else ARC_PART * factors[0]
        return replace(question, low=expected_mm * low, high=expected_mm * factors[1], why=why)

    def _space(self, pwm: int, expected_mm: float) -> str:
        """How much space a drive needs, for people."""
        margin = 1.3 if self._is_known(pwm) else 3.0
        return f"{max(0.3, math.ceil(expected_mm * margin / 100.0) / 10.0):.1f} m"

    def _drive(
        self, pwm: int, seconds: float, *questions: Question, act: Callable[[Signal], object] | None = None
    ) -> Trial:
        """Drive from the start line; the first question is how far."""
        way, side = ("ahead", "before") if pwm > 0 else ("back", "behind")
        expected = self._expected(pwm, seconds)
        return self._trial(
            f"It drives {way} at PWM {abs(pwm)} for {seconds:g} s: about {expected:.0f} mm.",
            f"Put it on the start line, with {self._space(pwm, expected)} free {side} it.",
            act or (lambda _: self._held(pwm, seconds)),
            self._plausible(questions[0], pwm, expected),
            *questions[1:],
        )

    # ------------------------------------------------------------------ rest

    def _measure_rest(self) -> Trials[None]:
        """How long it takes to stand still."""
        pwm = self._strength(PARTS[0])
        seconds = self._seconds(pwm, ROLL_PART)
        expected = self._expected(pwm, seconds)

        def trial(at: float) -> Trial:
            def act(signal: Signal) -> None:
                self._held(pwm, seconds, settle_s=at)
                signal()
                self._rest()

            return self._trial(
                f"It drives ahead for {seconds:g} s, about {expected:.0f} mm, and stops. "
                f"{at:.2f} s after that a bell rings.",
                f"Put it on the start line, with {self._space(pwm, expected)} free before it, and watch its wheels.",
                act,
                Question(text="Did it still roll when the bell rang?", quantity=Quantity.STILL_MOVING),
            )

        present = self.calibration.settle_s
        found = yield from self._time(present, trial)
        self._find("settle_s", "s", present, [] if found is None else [found])
        self._set(settle_s=self._changed("settle_s", present))

    def _strength(self, part: float) -> int:
        """The PWM for a part of the driving range; once used, it stays, whatever is found out meanwhile."""
        return self._strengths.setdefault(part, self._portion(part))

    @abstractmethod
    def _portion(self, part: float) -> int:
        """The PWM for a part of the driving range, as far as that is known."""

    def _find_overrun(self, overruns: list[float]) -> None:
        present = self.calibration.overrun_s
        overruns = [round(overrun, 4) for overrun in overruns if abs(overrun) <= MOST_OVERRUN_S]
        self._find("overrun_s", "s", present, overruns)
        self._set(overrun_s=self._changed("overrun_s", present))
        if overruns:
            self._set(overrun_s=round(self.calibration.overrun_s, 3))
