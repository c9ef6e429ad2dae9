"""Calibrating a WALTER: its speeds, and what it makes of a millimetre and of a degree."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

from turtlewire.robots.calibrating import arithmetic
from turtlewire.robots.calibrating.arithmetic import Timed
from turtlewire.robots.calibrating.procedure import (
    KNOWN,
    LEAST_S,
    MOST_S,
    REST_S,
    UNKNOWN,
    Procedure,
    short_and_long,
)
from turtlewire.robots.calibrating.trials import Plan, Quantity, Question

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from turtlewire.robots.calibrating.procedure import Trials
    from turtlewire.robots.walter import Settings, Walter

# Speeds are measured at this many units: slow enough to be stopped by hand, fast enough to be exact.
UNITS = 100
SHORT_PART, LONG_PART = 0.2, 0.8
# Turns on the spot: so many degrees, a short one and a long one.
SHORT_DEG, LONG_DEG = 360.0, 1440.0
TURN_DEG = 1080.0


class WalterProcedure(Procedure["Walter"]):
    """The steps of a WALTER's calibration."""

    STEPS: ClassVar[dict[str, str]] = {
        "speed": "how fast it drives for each unit of speed",
        "turn_rate": "how fast it turns for each unit of speed",
        "distance": "how far it drives when it is told a distance",
        "angle": "how far it turns when it is told an angle",
    }

    def __init__(self, robot: Walter, settings: Settings, plan: Plan) -> None:
        super().__init__(robot, plan)
        self.settings = settings

    def lines(self) -> Mapping[str, Any]:
        """What was found, as lines of the robot's table in ``robots.toml``."""
        found = {name: getattr(self.settings, name) for name, found in self.found.items() if found.values}
        return {"calibration": found} if found else {}

    def _keep(self) -> Callable[[], None]:
        found, settings = super()._keep(), self.settings

        def restore() -> None:
            found()
            self.settings = settings

        return restore

    def _settle(self, name: str, unit: str, values: list[float]) -> None:
        present = getattr(self.settings, name)
        self._find(name, unit, present, values)
        self.settings = self.settings._replace(**{name: self._changed(name, present)})

    def _measure_speed(self) -> Trials[None]:
        space = self.plan.space_mm
        rates = yield from self._rates(
            "mm_per_s_per_unit", SHORT_PART * space, LONG_PART * space, Quantity.DISTANCE
        )
        self._settle("mm_per_s_per_unit", "mm/s", rates)

    def _measure_turn_rate(self) -> Trials[None]:
        rates = yield from self._rates("deg_per_s_per_unit", SHORT_DEG, LONG_DEG, Quantity.TURNED)
        self._settle("deg_per_s_per_unit", "degrees/s", rates)

    def _rates(self, name: str, short: float, long: float, quantity: Quantity) -> Trials[list[float]]:
        """The rate for each unit, by a short and a long motion each; it is driven by hand, for a time (W14)."""
        rate, found = getattr(self.settings, name), []
        seconds = _seconds(short / (rate * UNITS))
        first = yield from self._timed(seconds, rate * UNITS * seconds, quantity, is_known=False)
        if first is None:
            return []
        rate = first / seconds / UNITS  # what follows is planned by that
        for _ in range(self.plan.repeats):
            timed: list[Timed] = []
            for seconds in short_and_long(short / (rate * UNITS), long / (rate * UNITS)):
                measured = yield from self._timed(seconds, rate * UNITS * seconds, quantity, is_known=True)
                if measured is None:
                    break
                timed.append(Timed(seconds, measured))
            if len(timed) == 2:
                found.append(arithmetic.rate_and_overrun(*timed)[0] / UNITS)
        return found

    def _timed(
        self, seconds: float, expected: float, quantity: Quantity, *, is_known: bool
    ) -> Trials[float | None]:
        turning = quantity is Quantity.TURNED
        text = (
            "How far did it turn, clockwise? A whole turn is 360 degrees."
            if turning
            else "How far did it go ahead?"
        )
        space = max(300.0, expected * (1.3 if is_known else 3.0)) / 1000.0
        outcome = yield self._trial(
            f"It {'turns to the right' if turning else 'drives ahead'} with speed {UNITS} for {seconds:g} s: about "
            f"{expected:.0f} {'degrees' if turning else 'mm'}.",
            "Mark where it looks."
            if turning
            else f"Put it on the start line, with {space:.1f} m free before it.",
            lambda _: self._held(seconds, turning=turning),
            _plausible(Question(text=text, quantity=quantity), expected, KNOWN if is_known else UNKNOWN),
        )
        return _number(outcome.answers[0])

    def _held(self, seconds: float, *, turning: bool) -> None:
        self.robot.hold(UNITS, seconds, turning=turning)
        self.robot.wait(REST_S)

    def _measure_distance(self) -> Trials[None]:
        told, present = LONG_PART * self.plan.space_mm, self.settings.distance_scale
        found = []
        for _ in range(self.plan.repeats):
            outcome = yield self._trial(
                f"It is told to drive {told:.0f} mm.",
                f"Put it on the start line, with {told * 1.3 / 1000.0:.1f} m free before it.",
                lambda _: self._moved(told),
                _plausible(
                    Question(text="How far did it go ahead?", quantity=Quantity.DISTANCE), told, KNOWN
                ),
            )
            measured = _number(outcome.answers[0])
            if measured is not None:
                found.append(present * measured / told)
        self._settle("distance_scale", "", found)

    def _moved(self, distance_mm: float) -> None:
        self.robot.forward(distance_mm)
        self.robot.finish()
        self.robot.wait(REST_S)

    def _measure_angle(self) -> Trials[None]:
        present = self.settings.turn_scale
        found = []
        for number in range(self.plan.repeats):
            told = TURN_DEG if number % 2 == 0 else -TURN_DEG
            measured = yield from self._angle(told)
            if measured is not None:
                found.append(present * measured / told)
        self._settle("turn_scale", "", found)

    def _angle(self, told: float) -> Trials[float | None]:
        question = Question(
            text="How far did it turn? A whole turn is 360 degrees; to the left: minus.",
            quantity=Quantity.TURNED,
        )
        outcome = yield self._trial(
            f"It is told to turn {abs(told):.0f} degrees to the {'right' if told > 0 else 'left'}, on the spot: "
            "three whole turns.",
            "Mark where it looks.",
            lambda _: self._turned(told),
            _plausible(question, told, KNOWN),
        )
        return _number(outcome.answers[0])

    def _turned(self, angle_deg: float) -> None:
        self.robot.right(angle_deg)
        self.robot.finish()
        self.robot.wait(REST_S)


def _seconds(seconds: float) -> float:
    return round(min(MOST_S, max(LEAST_S, seconds)), 2)


def _plausible(question: Question, expected: float, factors: tuple[float, float]) -> Question:
    low, high = sorted(expected * factor for factor in factors)
    return replace(question, low=low, high=high, why="by what is known of it")


def _number(answer: object) -> float | None:
    return float(answer) if isinstance(answer, float | int) else None
