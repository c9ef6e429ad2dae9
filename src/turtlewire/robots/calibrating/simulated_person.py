"""Who measures a simulated robot: nobody has a tape that long, but what it truly does can be seen."""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, Any, NamedTuple

from turtlewire.errors import DataError, LimitReachedError, PoseUncertainError
from turtlewire.robots.calibrating.procedure import Choice
from turtlewire.robots.calibrating.trials import Quantity
from turtlewire.turtle import Pose, direction

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.robots.calibrating.trials import Answer, Question, Signal, Trial

# What moves less than this, nobody sees move.
VISIBLE_MM = 0.5
VISIBLE_DEG = 0.5
# Trials that a bad line or a wall has spoilt; after so many, something is wrong.
MOST_FAILURES = 20


class Sight(NamedTuple):
    """What can be seen of a robot at a time."""

    pose: Pose
    rotated_deg: float
    wheels_mm: tuple[float, float]
    parts_deg: tuple[float, ...]
    pen_is_down: bool


class SimulatedPerson:
    """Measures a simulated robot.

    Args:
        body: the robot.
        noise: the standard deviation of what is measured: mm, and degrees.
        seed: of the noise.
        tell: told what is asked and what is answered.
    """

    def __init__(
        self, body: Any, noise: float = 0.0, seed: int = 0, tell: Callable[[str], None] = lambda _: None
    ) -> None:
        self._body = body
        self._noise = noise
        self._random = random.Random(seed)
        self._tell = tell
        self._before = self._rung = self._after = self._see()
        self._heard: list[str] = []
        self._failures = 0

    def _see(self) -> Sight:
        body = self._body
        servos = getattr(body, "servos_deg", ()) or (getattr(body, "wheels_deg", 0.0),)
        wheels = getattr(body, "wheels_mm", (0.0, 0.0))
        pen = bool(getattr(body, "pen_is_down", False))
        return Sight(body.pose, body.rotated_deg, (wheels[0], wheels[1]), servos, pen)

    def begin(self, trial: Trial) -> Choice | None:
        """Nobody is tired of it."""
        self._tell(f"{trial.step}: {trial.does}")
        return None

    def perform(self, act: Callable[[Signal], object]) -> object:
        """Watch what it does, and what it is at when the bell rings."""
        self._before = self._rung = self._see()
        self._heard.clear()
        others = self._body.events

        def listen(action: Any) -> None:
            self._heard.append(action.what)
            if others is not None:
                others(action)

        self._body.events = listen
        try:
            reading = act(self._ring)
        except (PoseUncertainError, LimitReachedError) as error:
            self._failures += 1
            if self._failures > MOST_FAILURES:
                raise
            self._tell(f"  this does not count: {error}")
            return Choice.REPEAT
        finally:
            self._body.events = others
        self._after = self._see()
        return reading

    def _ring(self) -> None:
        self._rung = self._see()

    def answer(self, question: Question) -> Answer:
        """By what was seen. Raises ``DataError`` for what cannot be."""
        found = self._measured(question.quantity)
        if isinstance(found, float) and self._noise:
            found += self._random.gauss(0.0, self._noise)
        if isinstance(found, float) and not question.low <= found <= question.high:
            raise DataError(
                f"the simulated robot is too far from how it is driven: {question.text} {found:.1f} {question.unit}, "
                f"where {question.low:.0f} to {question.high:.0f} would be plausible. Measure all steps, in order"
            )
        self._tell(
            f"  {question.text} {f'{found:.1f}' if isinstance(found, float) else found} {question.unit}"
        )
        return found

    def _measured(self, quantity: Quantity) -> float | bool | str:
        before, after = self._before, self._after
        x, y = after.pose.x_mm - before.pose.x_mm, after.pose.y_mm - before.pose.y_mm
        dx, dy = direction(before.pose.heading_deg)
        match quantity:
            case Quantity.DISTANCE:
                return math.hypot(x, y)
            case Quantity.AHEAD:
                return x * dx + y * dy
            case Quantity.BACK:
                return -(x * dx + y * dy)
            case Quantity.ASIDE:
                return x * dy - y * dx
            case Quantity.TURNED:
                return self._turned()
            case Quantity.WHEELBASE:
                return float(self._body.settings.wheelbase_mm)
            case Quantity.MOVED:
                return math.hypot(x, y) > VISIBLE_MM
            case Quantity.PEN_TOUCHES:
                return after.pen_is_down
            case _:
                return self._watched(quantity)

    def _turned(self) -> float:
        """Whole turns are counted, as the wheels tell them; the rest is measured."""
        before, after = self._before, self._after
        rest = after.pose.heading_deg - before.pose.heading_deg
        return rest + 360.0 * round((after.rotated_deg - before.rotated_deg - rest) / 360.0)

    def _watched(self, quantity: Quantity) -> bool | str:
        before, rung, after = self._before, self._rung, self._after
        if quantity is Quantity.STILL_MOVING:
            gone_mm = rung.pose.distance_to(*after.pose[:2])
            turned = zip(rung.parts_deg, after.parts_deg, strict=True)
            return gone_mm > VISIBLE_MM or any(abs(a - b) > VISIBLE_DEG for a, b in turned)
        if quantity is Quantity.PEN_MOVED:
            return any(f"servo_id={self._body.settings.pen_servo} " in what for what in self._heard)
        left, right = (b - a for a, b in zip(before.wheels_mm, after.wheels_mm, strict=True))
        turned_names = [name for name, mm in (("left", left), ("right", right)) if abs(mm) > VISIBLE_MM]
        if quantity is Quantity.WHEELS:
            return "both" if len(turned_names) == 2 else "".join(turned_names) or "none"
        if not turned_names:
            return "none"
        back = (left if turned_names[0] == "left" else right) < 0.0
        return f"{turned_names[0]}{' back' if back else ''}"
