"""Calibrating a pen that a servo lifts: which servo, at which angles, and how long it takes."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Any

from turtlewire.robots.calibrating.procedure import Procedure
from turtlewire.robots.calibrating.trials import Quantity, Question
from turtlewire.robots.calibration import MAX_SERVO_DEG, NONE, TwoEngineCalibration

if TYPE_CHECKING:
    from turtlewire.robots.calibrating.procedure import Trials
    from turtlewire.robots.calibrating.trials import Signal, Trial
    from turtlewire.robots.two_engine import TwoEngine  # noqa: F401 - a forward reference

# So far beyond the angle at which the pen just touches, or just does not, it is pressed or lifted.
MARGIN_DEG = 15
# In such strides it is looked for where nobody knows.
STRIDE_DEG = 10
# A servo gets so long to turn.
SERVO_S = 1.0


class PenSteps(Procedure["TwoEngine"]):
    """The step of a pen.

    Attributes:
        servos: how many servos the robot has.
    """

    calibration: TwoEngineCalibration
    servos: int

    @abstractmethod
    def _set(self, **values: Any) -> None:
        """Change values of the calibration."""

    def _measure_pen(self) -> Trials[None]:
        present = self.calibration
        number = yield from self._pen_servo()
        if number is None:
            return
        self._find("pen_servo", "", _shown(present.pen_servo), [_shown(number if number >= 0 else None)])
        self._set(pen_servo=number if number >= 0 else None)
        if number < 0:
            return
        angles = yield from self._pen_angles(number)
        if angles is not None:
            down, up = angles
            self._find("pen_down_deg", "degrees", present.pen_down_deg, [down])
            self._find("pen_up_deg", "degrees", present.pen_up_deg, [up])
            self._set(pen_down_deg=down, pen_up_deg=up)
        seconds = yield from self._time(present.pen_s, lambda at: self._timed(number, at))
        self._find("pen_s", "s", present.pen_s, [] if seconds is None else [seconds])
        self._set(pen_s=self._changed("pen_s", present.pen_s))

    def _pen_servo(self) -> Trials[int | None]:
        """Which servo it is; -1: none, None: skipped."""
        present = self.calibration.pen_servo
        numbers = [n for n in range(self.servos) if n != present]
        for number in numbers if present is None else [present, *numbers]:
            moved = yield from self._yes(self._moves(number))
            if moved is None:
                return None
            if moved:
                return number
        return -1

    def _moves(self, number: int) -> Trial:
        one, other = self.calibration.pen_up_deg, self.calibration.pen_down_deg

        def act(_: Signal) -> None:
            for angle in (one, other, one):
                self._turn(number, angle)

        return self._trial(
            f"Servo {number} turns to {one}, {other} and {one} degrees.",
            "Put it on paper.",
            act,
            Question(text="Did the pen move up or down?", quantity=Quantity.PEN_MOVED),
        )

    def _turn(self, number: int, angle_deg: int) -> None:
        self.robot.set_servo(number, angle_deg)
        self.robot.wait(SERVO_S)

    def _touches(self, number: int, angle_deg: int) -> Trials[bool | None]:
        trial = self._trial(
            f"The pen's servo turns to {angle_deg} degrees.",
            "Keep it on paper, and look closely.",
            lambda _: self._turn(number, angle_deg),
            Question(text="Does the pen touch the paper?", quantity=Quantity.PEN_TOUCHES),
        )
        return (yield from self._yes(trial))

    def _pen_angles(self, number: int) -> Trials[tuple[int, int] | None]:
        """Down and up; None: skipped, or it touches everywhere or nowhere."""
        found = yield from self._sides(number)
        if found is None:
            return None
        touching, free = found
        sign = 1 if touching > free else -1

        def ask(steps: int) -> Trials[bool | None]:
            return (yield from self._touches(number, free + sign * steps))

        steps = yield from self._threshold(0, abs(touching - free), abs(touching - free) / 2.0, ask)
        if steps is None:
            return None
        first = free + sign * steps
        down = min(MAX_SERVO_DEG, max(0, first + sign * (MARGIN_DEG - 1)))
        return down, min(MAX_SERVO_DEG, max(0, first - sign * MARGIN_DEG))

    def _sides(self, number: int) -> Trials[tuple[int, int] | None]:
        """An angle at which it touches, and one at which it does not: near the present ones, if they are neither."""
        seen: dict[bool, int] = {}
        down, up = self.calibration.pen_down_deg, self.calibration.pen_up_deg
        sign = -1 if down < up else 1
        beyond = [*range(down, -1, -STRIDE_DEG), *range(down, MAX_SERVO_DEG + 1, STRIDE_DEG)]
        beyond.sort(key=lambda angle: ((angle - down) * sign < 0, abs(angle - down)))
        for angle in [down, up, *beyond]:
            touches = yield from self._touches(number, angle)
            if touches is None:
                return None
            seen[touches] = angle
            if len(seen) == 2:
                return seen[True], seen[False]
        return None

    def _timed(self, number: int, at: float) -> Trial:
        up, down = self.calibration.pen_up_deg, self.calibration.pen_down_deg

        def act(signal: Signal) -> None:
            self._turn(number, up)
            self.robot.set_servo(number, down)
            self.robot.wait(at)
            signal()
            self.robot.wait(SERVO_S)

        return self._trial(
            f"The pen goes up; then down. {at:.2f} s after that a bell rings.",
            "Watch the pen.",
            act,
            Question(text="Did it still move when the bell rang?", quantity=Quantity.STILL_MOVING),
        )


def _shown(number: int | None) -> str:
    return NONE if number is None else str(number)
