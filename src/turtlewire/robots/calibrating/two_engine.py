"""Calibrating a two-engine robot: engines, the distance between its wheels, its pen, its encoders."""

from __future__ import annotations

import math
from statistics import fmean
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from turtlewire.robots.calibrating import arithmetic
from turtlewire.robots.calibrating.arithmetic import Timed, Way, rounded
from turtlewire.robots.calibrating.driving import (
    LONG_PART,
    LOOK_S,
    PARTS,
    SAME_PART,
    DrivenProcedure,
)
from turtlewire.robots.calibrating.engines import EngineSteps
from turtlewire.robots.calibrating.pen import PenSteps
from turtlewire.robots.calibrating.procedure import LEAST_S, MOST_S, REST_S, numbers
from turtlewire.robots.calibrating.trials import Plan, Quantity, Question
from turtlewire.robots.calibration import FULL_PWM, SpeedCurve, TwoEngineCalibration

if TYPE_CHECKING:
    from turtlewire.robots.calibrating.procedure import Trials
    from turtlewire.robots.calibrating.trials import Signal
    from turtlewire.robots.two_engine import Settings, TwoEngine

# It turns on the spot by about so much: whole turns are easy to count, and the angle is exact.
TURN_DEG = 1080.0
# What it may turn instead, before it is known.
TURN_FACTORS = (0.3, 4.0)
WHICH = ("none", "left", "right", "both")
SIDES = ("left", "right")


class Drive(NamedTuple):
    """A drive straight on: how long, the way, and the ticks of the wheels' encoders meanwhile, if there are any."""

    seconds: float
    way: Way
    ticks: tuple[int, int] | None


class TwoEngineProcedure(DrivenProcedure["TwoEngine"], EngineSteps, PenSteps):
    """The steps of a two-engine robot's calibration.

    Where its dialect speaks of mm/s, the robot keeps its speeds by itself: then what is told are mm/s, and of its
    curves only the full speed is measured.
    """

    STEPS: ClassVar[dict[str, str]] = {
        "engines": "which engine turns which wheel, and which way",
        "dead_band": "which PWM just does not turn a wheel",
        "speed": "how fast each wheel turns ahead, and how it starts and stops",
        "backward": "how fast each wheel turns back",
        "track": "how far its wheels are apart",
        "rest": "how long it takes to stand still",
        "pen": "which servo moves the pen, where it is up and down, how long it takes",
        "ticks": "how far a wheel goes for a tick of its encoder",
    }

    calibration: TwoEngineCalibration

    def __init__(self, robot: TwoEngine, settings: Settings, plan: Plan) -> None:
        super().__init__(robot, settings.calibration, plan)
        dialect = settings.checked().dialect
        assert dialect is not None
        names = {entry.message_type.name(): entry.message_type for entry in dialect.entries}
        self.servos = dialect.counts.get("servos", 0) if "set_servo_position" in names else 0
        self.engines = dialect.counts.get("engines", 0) if "engine_forward" in names else 0
        self._most = FULL_PWM
        if not self.engines:
            self._most = min(int(field.high) for field in names["set_wheel_speeds"].FIELDS)
        self._old = settings.calibration
        # What was driven, by what was told, ahead above 0; and turned on the spot.
        self._drives: dict[int, list[Drive]] = {}
        self._dead: dict[tuple[str, int], int] = {}

    def _speed_at(self, pwm: int) -> float:
        if not self.engines:
            return min(float(abs(pwm)), self.calibration.full_mm_per_s)
        left, right = self.calibration.left_curve(pwm), self.calibration.right_curve(pwm)
        return (left.speed_mm_per_s(abs(pwm)) + right.speed_mm_per_s(abs(pwm))) / 2.0

    def _portion(self, part: float) -> int:
        if not self.engines:
            return round(part * min(self._most, self.calibration.full_mm_per_s))
        return max(curve.portion(part) for curve in (self.calibration.left, self.calibration.right))

    def _held(self, pwm: int, seconds: float, settle_s: float | None = None) -> None:
        self._turn_wheels(pwm, pwm, seconds, settle_s)

    def _turn_wheels(self, left: int, right: int, seconds: float, settle_s: float | None = None) -> None:
        self.robot.recalibrate(self.calibration)
        self.robot.hold(left, right, seconds, settle_s)
        if settle_s is None:
            self._rest()

    def _rest(self) -> None:
        self.robot.wait(REST_S)

    # ------------------------------------------------------------------ speed

    def _get_to_know(self, direction: int = 1) -> Trials[None]:
        """How fast it is, about: what follows is planned by that."""
        pwm = direction * self._strength(PARTS[0])
        if not self._is_known(pwm):
            yield from self._straight_on(pwm, self._seconds(pwm, LONG_PART))
            self._drives.pop(pwm, None)  # too short to count

    def _measure_speed(self) -> Trials[None]:
        yield from self._get_to_know()
        if not self.engines:
            yield from self._full_speed()
            return
        for part in PARTS:
            yield from self._driven(self._strength(part), twice=part == PARTS[0])
        self._solve()

    def _measure_backward(self) -> Trials[None]:
        if not self.engines or not self.robot.goes_backward:
            return
        yield from self._get_to_know(-1)
        for part in PARTS:
            yield from self._driven(-self._strength(part))
        self._solve()
        if self.calibration.left_backward or self.calibration.right_backward:
            yield from self._dead_band(-1)

    def _full_speed(self) -> Trials[None]:
        """Told more than it can, it drives as fast as it can."""
        yield from self._driven(self._most, twice=True)
        speeds = [self._wheels(drive) for drive in self._drives.get(self._most, ())]
        for number, side in enumerate(SIDES if speeds else ()):
            old: SpeedCurve = getattr(self._old, side)
            values = [speed[number] for speed in speeds]
            self._find(f"{side}: full speed", "mm/s", old.full_mm_per_s, values)
            slope = rounded(fmean(values) / (FULL_PWM - old.dead_pwm))
            self._set(**{side: SpeedCurve(dead_pwm=old.dead_pwm, mm_per_s_per_pwm=slope)})

    def _driven(self, pwm: int, *, twice: bool = False) -> Trials[None]:
        """Drive, as often as is planned; a short and a long drive each are to tell what starting and stopping do."""
        overruns: list[float] = []
        for _ in range(self.plan.repeats):
            timed: list[Timed] = []
            for seconds in self._durations(pwm) if twice else [self._seconds(pwm, LONG_PART)]:
                way = yield from self._straight_on(pwm, seconds)
                if way is None:
                    break
                timed.append(Timed(seconds, abs(way.length_mm)))
            if len(timed) == 2:
                overruns.append(arithmetic.rate_and_overrun(*timed)[1])
        if twice:
            self._find_overrun(overruns)

    def _straight_on(self, pwm: int, seconds: float) -> Trials[Way | None]:
        """Both wheels are told the same; None: skipped."""
        far, aside = _questions(pwm, self._expected(pwm, seconds))

        def act(_: Signal) -> tuple[int, int] | None:
            before = self.robot.ticks
            self._held(pwm, seconds)
            after = self.robot.ticks
            return None if before is None or after is None else (after[0] - before[0], after[1] - before[1])

        outcome = yield self._drive(pwm, seconds, far, aside, act=act)
        found = numbers(outcome.answers)
        if found is None:
            return None
        way = arithmetic.way(math.copysign(found[0], pwm), found[1], backwards=pwm < 0)
        self._learn(pwm, seconds, abs(way.length_mm))
        ticks: Any = outcome.reading
        self._drives.setdefault(pwm, []).append(Drive(seconds, way, ticks))
        return way

    def _wheels(self, drive: Drive) -> arithmetic.Wheels:
        seconds = drive.seconds + self.calibration.overrun_s
        return arithmetic.wheels(drive.way, seconds, self.calibration.track_mm)

    def _solve(self) -> None:
        """The curves of the wheels, from all that was measured, as far as the wheels are known to be apart."""
        for direction in (1, -1) if self.engines else ():
            pwms = sorted((pwm for pwm in self._drives if pwm * direction > 0), key=abs)
            for number, side in enumerate(SIDES):
                points = []
                for pwm in pwms:
                    values = [abs(self._wheels(drive)[number]) for drive in self._drives[pwm]]
                    way = "" if direction > 0 else " back"
                    old = getattr(self._old, f"{side}_curve")(direction).speed_mm_per_s(abs(pwm))
                    self._find(f"{side}{way} at PWM {abs(pwm)}", "mm/s", old, values)
                    points.append((abs(pwm), rounded(fmean(values))))
                self._set_curve(side, direction, points)

    def _set_curve(self, side: str, direction: int, points: list[tuple[int, float]]) -> None:
        """Where only speeds or only a dead band were measured, the other stays."""
        curve: SpeedCurve = getattr(self.calibration, f"{side}_curve")(direction)
        ahead: SpeedCurve = getattr(self.calibration, side)
        dead = self._dead.get((side, direction))
        if not points and dead is not None:
            curve = arithmetic.with_dead_band(curve, dead)
        elif points:
            if dead is None:
                dead = (
                    round(arithmetic.dead_band(points[0], points[1])) if len(points) > 1 else curve.dead_pwm
                )
            curve = arithmetic.speed_curve(max(0, min(dead, points[0][0] - 1)), points)
        if direction > 0:
            self._set(**{side: curve})
        elif points:
            is_same = all(abs(speed / ahead.speed_mm_per_s(pwm) - 1.0) <= SAME_PART for pwm, speed in points)
            self._set(**{_name(side, direction): None if is_same else curve})

    # ------------------------------------------------------------------ the dead band

    def _measure_dead_band(self) -> Trials[None]:
        if self.engines:
            yield from self._dead_band(1)

    def _dead_band(self, direction: int) -> Trials[None]:
        seen: dict[int, str] = {}
        for side in SIDES:
            found = yield from self._least(side, direction, seen)
            old = getattr(self._old, f"{side}_curve")(direction).dead_pwm
            name = f"{_name(side, direction)}.dead_pwm"
            self._find(name, "PWM", old, [] if found is None else [found - 1])
            if found is not None:
                self._dead[side, direction] = found - 1
        self._solve()

    def _least(self, side: str, direction: int, seen: dict[int, str]) -> Trials[int | None]:
        """The least PWM that turns a wheel."""
        guess = getattr(self.calibration, f"{side}_curve")(direction).dead_pwm + 1
        return (
            yield from self._threshold(
                0, FULL_PWM, guess, lambda pwm: self._turns(side, direction * pwm, seen)
            )
        )

    def _turns(self, side: str, pwm: int, seen: dict[int, str]) -> Trials[bool | None]:
        """Whether a wheel turns at a PWM. Both are tried at the same time."""
        if pwm not in seen:
            way = "ahead" if pwm > 0 else "back"
            answer = (
                yield self._trial(
                    f"Both wheels try to turn {way} at PWM {abs(pwm)} for {LOOK_S:g} s: a little, or not at all.",
                    f"It may stand where it is, with {self._space(pwm, self._expected(pwm, LOOK_S))} free around it. "
                    "Watch its wheels.",
                    lambda _: self._held(pwm, LOOK_S),
                    Question(text="Which wheels turned?", quantity=Quantity.WHEELS, choices=WHICH),
                )
            ).answers[0]
            if answer is None:
                return None
            seen[pwm] = str(answer)
        return seen[pwm] in (side, "both")

    # ------------------------------------------------------------------ the track

    def _measure_track(self) -> Trials[None]:
        if not self.robot.goes_backward:
            return
        present, told, values = self.calibration.track_mm, self._strength(PARTS[0]), []
        for number in range(self.plan.repeats):
            sign = 1 if number % 2 == 0 else -1
            rate = yield from self._turned(sign * told)
            if rate is not None:
                values.append(self._track(sign, told, rate))
        self._find("track_mm", "mm", present, values)
        self._set(track_mm=self._changed("track_mm", present))
        self._solve()

    def _turned(self, told: int) -> Trials[float | None]:
        """How fast it turns on the spot, in radians a second, clockwise; None: skipped."""
        calibration, side = self.calibration, "right" if told > 0 else "left"
        rate = math.degrees(2.0 * self._speed(told) / calibration.track_mm)
        seconds = round(min(MOST_S, max(LEAST_S, TURN_DEG / rate)), 2)
        expected = math.copysign(rate * (seconds + calibration.overrun_s), told)
        low, high = sorted(expected * factor for factor in TURN_FACTORS)
        outcome = yield self._trial(
            f"It turns to the {side} on the spot for {seconds:g} s: by about {abs(expected):.0f} degrees.",
            "Mark where it looks, with 0.3 m free around it. Count whole turns.",
            lambda _: self._turn_wheels(told, -told, seconds),
            Question(
                text="How far did it turn? A whole turn is 360 degrees; to the left: minus.",
                quantity=Quantity.TURNED,
                low=low,
                high=high,
                why="by what is known of it so far",
            ),
        )
        found = numbers(outcome.answers)
        return None if found is None else math.radians(found[0]) / (seconds + calibration.overrun_s)

    def _track(self, sign: int, told: int, rate: float) -> float:
        """From a turn, and how the wheels drive straight on, both ways, when they are told the same."""
        ahead, back = self._per_second(told), self._per_second(-told)
        if ahead is None or back is None:
            left, right = self.calibration.left_curve(sign), self.calibration.right_curve(-sign)
            speeds = [left.speed_mm_per_s(told), right.speed_mm_per_s(told)]
            return (sum(speeds) if self.engines else 2.0 * told) / abs(rate)
        # A turn to the left is one to the right, seen in a mirror.
        ahead, back = (way._replace(turned_rad=sign * way.turned_rad) for way in (ahead, back))
        return arithmetic.track(abs(rate), (ahead, 1.0), (back, 1.0))

    def _per_second(self, pwm: int) -> Way | None:
        """What was driven, in a second; None: nothing was."""
        drives = self._drives.get(pwm, [])
        seconds = [drive.seconds + self.calibration.overrun_s for drive in drives]
        if not drives:
            return None
        length = fmean(drive.way.length_mm / s for drive, s in zip(drives, seconds, strict=True))
        return Way(length, fmean(drive.way.turned_rad / s for drive, s in zip(drives, seconds, strict=True)))

    # ------------------------------------------------------------------ ticks

    def _measure_ticks(self) -> Trials[None]:
        if self.robot.ticks is None:
            return
        if not any(drive.ticks for drives in self._drives.values() for drive in drives):
            yield from self._driven(self._strength(PARTS[0]))
        values = []
        for drive in (drive for drives in self._drives.values() for drive in drives):
            if drive.ticks and any(drive.ticks):
                travel = arithmetic.wheels(drive.way, 1.0, self.calibration.track_mm)
                values.append(sum(map(abs, travel)) / sum(map(abs, drive.ticks)))
        present = self.calibration.mm_per_tick
        self._find("mm_per_tick", "mm", present, values)
        self._set(mm_per_tick=self._changed("mm_per_tick", present))


def _name(side: str, direction: int) -> str:
    """What the calibration calls the curve of a wheel."""
    return side if direction > 0 else f"{side}_backward"


def _questions(pwm: int, expected_mm: float) -> tuple[Question, Question]:
    way = "ahead" if pwm > 0 else "back"
    return (
        Question(
            text=f"How far did it go {way}, along the line in which it looked at the start?",
            quantity=Quantity.AHEAD if pwm > 0 else Quantity.BACK,
        ),
        Question(
            text="How far did it get to the right of that line? To the left: minus.",
            quantity=Quantity.ASIDE,
            low=-1.5 * expected_mm,
            high=1.5 * expected_mm,
            why="for so long a drive",
        ),
    )
