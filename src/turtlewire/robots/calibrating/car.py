"""Calibrating a car: how fast its motor makes it, what circles its steering drives, how long both take."""

from __future__ import annotations

import math
from statistics import fmean
from typing import TYPE_CHECKING, ClassVar

from turtlewire.robots.calibrating import arithmetic
from turtlewire.robots.calibrating.arithmetic import Timed, rounded
from turtlewire.robots.calibrating.driving import (
    LONG_PART,
    LOOK_S,
    PARTS,
    SAME_PART,
    DrivenProcedure,
)
from turtlewire.robots.calibrating.procedure import REST_S, numbers
from turtlewire.robots.calibrating.trials import Plan, Quantity, Question
from turtlewire.robots.calibration import FULL_PWM, CarCalibration

if TYPE_CHECKING:
    from turtlewire.robots.calibrating.procedure import Trials
    from turtlewire.robots.calibrating.trials import Signal, Trial
    from turtlewire.robots.car import Car

# Steering is measured at these.
STEERINGS = (0, FULL_PWM, -FULL_PWM, FULL_PWM // 2, -(FULL_PWM // 2))
STEERING_PART = 0.3
# A circle is driven for no more than this: what is beyond is the more easily measured wrong.
MOST_TURN_RAD = 2.5
# Before a drive, the front wheels get the time that they take, and this.
MORE_S = 0.5


class CarProcedure(DrivenProcedure["Car"]):
    """The steps of a car's calibration."""

    STEPS: ClassVar[dict[str, str]] = {
        "dead_band": "which PWM just does not move it",
        "steering": "what circles it drives, and which steering goes straight",
        "speed": "how fast it drives ahead, and how it starts and stops",
        "backward": "how fast it drives back",
        "steering_time": "how long its front wheels take from one lock to the other",
        "rest": "how long it takes to stand still",
    }

    calibration: CarCalibration

    def __init__(self, robot: Car, calibration: CarCalibration, plan: Plan) -> None:
        super().__init__(robot, calibration, plan)
        self._old = calibration
        # What was measured: mm/s by PWM, ahead above 0; and the dead band, ahead (1) and back (-1).
        self._points: dict[int, float] = {}
        self._dead: dict[int, int] = {}

    def _speed_at(self, pwm: int) -> float:
        return self.calibration.curve(pwm).speed_mm_per_s(abs(pwm))

    def _portion(self, part: float) -> int:
        return self.calibration.forward.portion(part)

    def _held(self, pwm: int, seconds: float, settle_s: float | None = None) -> None:
        self._steered(pwm, self.calibration.straight, seconds, settle_s)

    def _steered(self, pwm: int, steering: int, seconds: float, settle_s: float | None = None) -> None:
        self.robot.turn_wheels(steering, self.calibration.steer_s + MORE_S)
        self.robot.hold(pwm, steering, seconds, settle_s)
        if settle_s is None:
            self._rest()

    def _rest(self) -> None:
        self.robot.wait(REST_S)

    # ------------------------------------------------------------------ speed

    def _get_to_know(self, direction: int = 1) -> Trials[None]:
        """How fast it is, about: what follows is planned by that."""
        pwm = direction * self._strength(PARTS[0])
        if not self._is_known(pwm):
            yield from self._distance(pwm, self._seconds(pwm, LONG_PART))

    def _measure_speed(self) -> Trials[None]:
        yield from self._get_to_know()
        yield from self._speeds(1)

    def _measure_backward(self) -> Trials[None]:
        yield from self._get_to_know(-1)
        yield from self._speeds(-1)
        if self.calibration.backward is not None:
            yield from self._dead_band(-1)

    def _speeds(self, direction: int) -> Trials[None]:
        old = self._old.curve(direction)
        for pwm in [direction * self._strength(part) for part in PARTS]:
            if pwm == self._strength(PARTS[0]):
                speeds = yield from self._first_speeds(pwm)
            else:
                speeds = yield from self._more_speeds(pwm)
            self._find(f"{_name(direction)} at PWM {abs(pwm)}", "mm/s", old.speed_mm_per_s(abs(pwm)), speeds)
            if speeds:
                self._points[pwm] = rounded(fmean(speeds))
        self._set_curve(direction)

    def _first_speeds(self, pwm: int) -> Trials[list[float]]:
        """By a short and a long drive each, which also tell what starting and stopping make of a drive."""
        speeds, overruns = [], []
        for _ in range(self.plan.repeats):
            timed: list[Timed] = []
            for seconds in self._durations(pwm):
                driven = yield from self._distance(pwm, seconds)
                if driven is None:
                    break
                timed.append(Timed(seconds, driven))
            if len(timed) == 2:
                speed, overrun = arithmetic.rate_and_overrun(*timed)
                speeds.append(speed)
                overruns.append(overrun)
        self._find_overrun(overruns)
        return speeds

    def _more_speeds(self, pwm: int) -> Trials[list[float]]:
        speeds = []
        for _ in range(self.plan.repeats):
            seconds = self._seconds(pwm, LONG_PART)
            driven = yield from self._distance(pwm, seconds)
            if driven is not None:
                speeds.append(driven / (seconds + self.calibration.overrun_s))
        return speeds

    def _distance(self, pwm: int, seconds: float) -> Trials[float | None]:
        """How far it gets; None: skipped."""
        way = "ahead" if pwm > 0 else "back"
        question = Question(text=f"How far did it go {way}?", quantity=Quantity.DISTANCE)
        found = numbers((yield self._drive(pwm, seconds, question)).answers)
        if found is None:
            return None
        self._learn(pwm, seconds, found[0])
        return found[0]

    def _set_curve(self, direction: int) -> None:
        """From what was measured: speeds, and the dead band; where only one of them was, the other stays."""
        points = sorted((abs(pwm), speed) for pwm, speed in self._points.items() if pwm * direction > 0)
        curve, ahead = self.calibration.curve(direction), self.calibration.forward
        dead = self._dead.get(direction)
        if not points and dead is not None:
            curve = arithmetic.with_dead_band(curve, dead)
        elif points:
            if dead is None:
                dead = (
                    round(arithmetic.dead_band(points[0], points[1])) if len(points) > 1 else curve.dead_pwm
                )
            curve = arithmetic.speed_curve(max(0, min(dead, points[0][0] - 1)), points)
        if direction > 0:
            self._set(forward=curve)
        elif points:
            is_same = all(abs(v / ahead.speed_mm_per_s(pwm) - 1.0) <= SAME_PART for pwm, v in points)
            self._set(backward=None if is_same else curve)

    # ------------------------------------------------------------------ the dead band

    def _measure_dead_band(self) -> Trials[None]:
        yield from self._dead_band(1)

    def _dead_band(self, direction: int) -> Trials[None]:
        old = self._old.curve(direction).dead_pwm
        guess = self.calibration.curve(direction).dead_pwm + 1
        found = yield from self._threshold(
            0, FULL_PWM, guess, lambda pwm: self._yes(self._move(direction * pwm))
        )
        self._find(f"{_name(direction)}.dead_pwm", "PWM", old, [] if found is None else [found - 1])
        if found is not None:
            self._dead[direction] = found - 1
            self._set_curve(direction)

    def _move(self, pwm: int) -> Trial:
        return self._trial(
            f"It tries to drive {'ahead' if pwm > 0 else 'back'} at PWM {abs(pwm)} for {LOOK_S:g} s: a little, or "
            "not at all.",
            f"It may stand where it is, with {self._space(pwm, self._expected(pwm, LOOK_S))} free around it.",
            lambda _: self._held(pwm, LOOK_S),
            Question(text="Did it move?", quantity=Quantity.MOVED),
        )

    # ------------------------------------------------------------------ steering

    def _measure_steering(self) -> Trials[None]:
        old = self.calibration
        ruler = Question(
            text="How far is it from the rear axle to the front axle?",
            quantity=Quantity.WHEELBASE,
            low=20.0,
            high=2000.0,
            why="or it is no car for a table",
        )
        yield from self._get_to_know()
        trial = self._trial("It stands. Take a ruler.", "", None, ruler)
        measured = numbers((yield trial).answers)
        self._find("wheelbase_mm", "mm", old.wheelbase_mm, measured or [])
        wheelbase = self._changed("wheelbase_mm", old.wheelbase_mm)
        points: dict[int, list[float]] = {}
        for steer in STEERINGS:
            for _ in range(self.plan.repeats):
                curvature = yield from self._curvature(steer)
                if curvature is not None:
                    points.setdefault(steer, []).append(curvature)
        if FULL_PWM not in points or -FULL_PWM not in points:
            self._set(wheelbase_mm=wheelbase)
            return
        rows = zip(*points.values(), strict=False)
        models = [arithmetic.steering(wheelbase, list(zip(points, row, strict=True))) for row in rows]
        averages = [(steer, fmean(values)) for steer, values in sorted(points.items())]
        model = arithmetic.steering(wheelbase, averages)
        self._find("lock_deg", "degrees", old.lock_deg, [one.lock_deg for one in models])
        self._find("trim_deg", "degrees", old.trim_deg, [one.trim_deg for one in models])
        table: tuple[tuple[int, float], ...] = ()
        if model.off > arithmetic.MODEL_PART:
            table = tuple((steer, rounded(1.0 / curvature)) for steer, curvature in averages if curvature)
        self._set(
            wheelbase_mm=wheelbase,
            lock_deg=rounded(model.lock_deg),
            trim_deg=round(model.trim_deg, 3),
            steering=table,
        )

    def _curvature(self, steer: int) -> Trials[float | None]:
        """1 / radius of the circle that it drives; None: skipped."""
        pwm, space = self._strength(STEERING_PART), self.plan.space_mm
        curvature = self.calibration.curvature(steer)
        length = min(0.9 * space, MOST_TURN_RAD / abs(curvature) if curvature else math.inf)
        seconds = self._seconds(pwm, length / space)
        expected = self._expected(pwm, seconds)
        side = "straight ahead" if not steer else "to the right" if steer > 0 else "to the left"
        questions = (
            Question(
                text="How far ahead of its start does it stand? Behind: minus.", quantity=Quantity.AHEAD
            ),
            Question(text="How far to the right of its start? Left: minus.", quantity=Quantity.ASIDE),
        )
        limits = (-1.2 * expected, 1.2 * expected)
        aside = limits if not steer else (0.0, limits[1]) if steer > 0 else (limits[0], 0.0)
        trial = self._trial(
            f"It steers {steer:+d} and drives {side} at PWM {pwm} for {seconds:g} s: about {expected:.0f} mm.",
            f"Put it on the start line, looking straight ahead, with {self._space(pwm, expected)} free before it "
            "and to the side. The middle of its rear axle is what counts.",
            lambda _: self._steered(pwm, steer, seconds),
            _within(questions[0], limits),
            _within(questions[1], aside),
        )
        found = numbers((yield trial).answers)
        return None if found is None else arithmetic.way(*found).curvature

    def _measure_steering_time(self) -> Trials[None]:
        def trial(at: float) -> Trial:
            def act(signal: Signal) -> None:
                self.robot.turn_wheels(-FULL_PWM, self.calibration.steer_s + 2.0)
                self.robot.turn_wheels(FULL_PWM, at)
                signal()
                self._rest()

            return self._trial(
                f"It stands, and turns its front wheels all the way to the left; then all the way to the right. "
                f"{at:.2f} s after that a bell rings.",
                "Watch its front wheels.",
                act,
                Question(
                    text="Did they still turn when the bell rang?",
                    quantity=Quantity.STILL_MOVING,
                ),
            )

        present = self.calibration.steer_s
        found = yield from self._time(present, trial)
        self._find("steer_s", "s", present, [] if found is None else [found])
        self._set(steer_s=self._changed("steer_s", present))


def _name(direction: int) -> str:
    """What the calibration calls the curve of a direction."""
    return "forward" if direction > 0 else "backward"


def _within(question: Question, limits: tuple[float, float]) -> Question:
    return Question(
        text=question.text,
        quantity=question.quantity,
        low=limits[0],
        high=limits[1],
        why="for so long a drive, or the side is wrong",
    )
