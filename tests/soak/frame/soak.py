"""The soak of the two-engine robot: its model, and what must hold (decisions F1..F13).

Nothing on this wire is answered: what gets lost is lost, and the newest set-points are repeated. So it is followed
frame by frame. One that arrives whole is carried out, in order, unless a false frame that the CRC does not reveal
swallowed it; whatever else is carried out is exactly what a false frame spells, and counted.

The model of the robot's end is written anew from the protocol's page, with a CRC of its own, bit by bit.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tests.soak.domains import FLAG, Whole, one_of, rule
from tests.soak.frame.model import REPEAT_S, FrameModel
from tests.soak.frame.reference import TIMEOUT_S, TONES
from tests.soak.timed import VALID
from tests.soak.wire import ViolationError
from turtlewire.errors import MessageError, PoseUncertainError
from turtlewire.protocols.frame.dialect import shipped

if TYPE_CHECKING:
    from turtlewire.protocols.frame.message import FrameMessage

# After so long without faults, all set-points have been repeated.
SETTLED_S = 3 * REPEAT_S + 0.1


class FrameSoak(FrameModel):
    """A two-engine robot, its driver, and what must hold."""

    # ------------------------------------------------------------------ what must hold

    def _wheels(self) -> tuple[float, ...]:
        """What the wheels should do, by what was carried out."""
        return self._wheels_of(self._truth)

    def _wheels_of(self, state: dict[tuple[str, int], tuple[str, tuple[Any, ...]]]) -> tuple[float, ...]:
        if self.setup["dialect"] == "telemetry":
            return state.get(("wheels", 0), ("", (0, 0)))[1]
        speeds = []
        for number in (0, 1):
            name, values = state.get(("engine", number), ("", (0, 0)))
            speeds.append(-values[1] if name == "engine_backward" else values[1])
        return tuple(speeds)

    def before_step(self, name: str) -> None:
        self._rested, self._from_s = name == "rest", self.now
        self._look_for_damage()
        self._troubles_before = self._troubles()
        open_units = [unit.number for unit in self._latest_of.values() if not unit.executed]
        self._first_unit = min(open_units, default=len(self._units))
        self._was_moving = self.driver._is_driven or any(self._wheels())
        self._was_calm = self.driver.link_state == "connected" and self.now >= self.unrest_until_s
        self.new_ways()

    def _troubles(self) -> tuple[int, ...]:
        """What may make a reckoning wrong, or right again, counted."""
        report, corrections = self.report, self.driver.statistics.corrections
        return (
            self.damage,
            report.stops,
            self._links,
            report.uncatchable.total(),
            report.recoveries,
            corrections,
        )

    def check(self) -> None:
        self._look_for_damage()
        for frame in self._reference.waited(self.now):
            raise ViolationError(f"{frame} should have been carried out after a pause")
        if self._expected:
            raise ViolationError(f"the robot did not carry out {self._expected[0]!r}")
        robot: Any = self.end.robot
        if tuple(robot.engines) != self._wheels():
            raise ViolationError(f"the engines are {robot.engines}, but by the bytes {self._wheels()}")
        if self._whole and self.now >= self._arrived_s + TIMEOUT_S:
            raise ViolationError(f"{self._whole[0][0].data!r} arrived, and was not carried out after a pause")
        if self._host.idle and (self._unsent or self._commands):
            raise ViolationError(f"{[*self._unsent.values(), *self._commands]} was never sent")
        if isinstance(self.error, PoseUncertainError) and self._is_quiet and any(self._wheels()):
            raise ViolationError("an error says that the robot was stopped, and it drives")
        self._check_told()
        self._check_place()

    def _check_told(self) -> None:
        """What the driver says of the wheels is what it has told them; and the robot has it, if no frame got lost."""
        if not self._host.idle or self.driver.link_state != "connected":
            return
        told = tuple(self.driver._told_wheels)
        if told != self._wheels_of({ch: (s.form.name, s.values) for ch, s in self._newest.items()}):
            raise ViolationError(
                f"the driver says that the wheels are {told}, but it told them {self._newest}"
            )
        for channel, said in self._newest.items():
            sent = self._latest_of[channel]
            is_settled = self._rested and self._damaged_s < self._from_s < self.now - SETTLED_S
            is_known = (sent.executed or is_settled) and channel not in self._falsified
            if is_known and self._truth.get(channel) != (said.form.name, said.values):
                raise ViolationError(f"{said.text} was said, but it is {self._truth.get(channel)}")

    def _check_place(self) -> None:
        if self._troubles_before != self._troubles() or self.error or not self._was_calm:
            return
        if self._falsified & {("engine", 0), ("engine", 1), ("wheels", 0)}:
            return
        if not all(unit.executed for unit in self._units[self._first_unit :]):
            return
        off_mm, off_deg = self.off()
        by_hand = self._was_moving or self.driver._is_driven
        jitter_s = self.setup["delay_s"]
        most_mm = 20.0 if by_hand else 1.0 + 1000.0 * jitter_s
        most_deg = 20.0 if by_hand else 1.0 + 500.0 * jitter_s
        if off_mm > most_mm or off_deg > most_deg:
            raise ViolationError(
                f"nothing went wrong, and the robot is {off_mm:.2f} mm, {off_deg:.2f} degrees off"
            )

    def is_at_rest(self) -> bool:
        return not any(self._wheels())

    # ------------------------------------------------------------------ rules

    @rule(weight=8.0, number=Whole(0, 1), speed=Whole(-255, 255), valid_s=VALID)
    def engine(self, number: int, speed: int, valid_s: float | None) -> None:
        if self.setup["dialect"] == "0.1":
            self.do(self.driver.engine(number, speed, valid_s=valid_s))
        else:
            self.do(self.driver.send(self._made("set_wheel_speeds", speed, -speed * number), valid_s=valid_s))

    @rule(weight=6.0, number=Whole(0, 2), position_deg=Whole(0, 181))
    def servo(self, number: int, position_deg: int) -> None:
        """What the robot does not have, or cannot do, is refused before any byte leaves (F4)."""
        sent = self.tap.sent
        try:
            self.do(self.driver.set_servo(number, position_deg))
        except MessageError:
            if sent != self.tap.sent:
                raise ViolationError("something refused was sent all the same") from None
        else:
            if number >= (2 if self.setup["dialect"] == "0.1" else 1) or position_deg > 180:
                raise ViolationError(f"servo {number} to {position_deg} degrees was not refused")

    @rule(weight=4.0, on=FLAG, tone=one_of(*TONES))
    def signals(self, on: bool, tone: str) -> None:
        """A lamp and a horn, if there are any; in one frame."""
        if self.setup["dialect"] == "0.1":
            self.do(self.driver.set_servo(1, 90 * on))
        else:
            messages = (self._made("set_lamp", on), self._made("beep", TONES.index(tone), 100))
            self.do(self.driver.send(*messages))

    @rule(weight=0.5, count=Whole(1, 60))
    def many(self, count: int) -> None:
        """More than one frame can carry, where there are commands that are no set-points; each goes out once."""
        if self.setup["dialect"] == "0.1":
            self.do(self.driver.drive(0.0, 0.0))
        else:
            self.do(self.driver.send(*(self._made("beep", n % 3, n) for n in range(count))))

    def _made(self, name: str, *values: float) -> FrameMessage:
        entries = shipped(self.setup["dialect"]).entries
        made: Any = next(e.message_type for e in entries if e.message_type.name() == name)
        message: FrameMessage = made(*values)
        return message
