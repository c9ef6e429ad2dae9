"""The soak of WALTER: its model, and what must hold (decisions W1..W16).

Only queries are answered on this wire, and nothing has a checksum. The answer to a query shows that everything before
it was carried out; what got lost or damaged all the same shows in the pose, or nowhere. So: every command that the
robot carries out is one that was sent, in order, or exactly what damaged bytes spell, which is counted; whatever a
fence has confirmed was carried out, or had damage near it; and when ``finish`` returns, the robot is where the host
says.

The model of the robot's end is written anew from the protocol's page.
"""

from __future__ import annotations

from typing import Any

from tests.soak.domains import FLAG, Real, Whole, one_of, rule
from tests.soak.timed import ANGLE, DISTANCE, PLACE, UNIT, VALID
from tests.soak.walter.model import WalterModel
from tests.soak.wire import ViolationError
from turtlewire.errors import LimitReachedError, PoseUncertainError
from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import Mode
from turtlewire.turtle import wrapped

# Robots tell their pose in whole units and degrees.
TOLERANCE_MM, TOLERANCE_DEG = 1.6, 1.6


class WalterSoak(WalterModel):
    """A WALTER, its driver, and what must hold."""

    # ------------------------------------------------------------------ what must hold

    def before_step(self, name: str) -> None:
        self._answers_damaged = self._damage_to_host()
        self._sent_before = self.tap.sent
        # Whatever ended in the middle may have left it up.
        self._pen_wanted = self._pen_wanted if self._went_well else self.driver.is_pen_down
        self._went_well = False

    def _damage_to_host(self) -> int:
        return sum(count for (to, _), count in self.mischief.done.items() if to == "host")

    def check(self) -> None:
        self._went_well = self.error is None
        if self._at_once:
            raise ViolationError(f"the robot did not act on {self._at_once[0][0]}")
        if len(self._submitted) != self._host.unsent:
            raise ViolationError(
                f"{len(self._submitted)} commands wait, but the host has {self._host.unsent}"
            )
        if isinstance(self.error, LimitReachedError | PoseUncertainError):
            self.check_stands("an error says that the robot was stopped")
        elif self._wire.hand is None and self._host.mode is Mode.DIRECT:
            self.check_stands("the robot was stopped")

    def check_stands(self, why: str) -> None:
        """When all that was sent has arrived, the robot stands."""
        if not self._is_quiet or self.now < self.unrest_until_s or self.driver.link_state == "reconnecting":
            return
        if self.is_at_rest():
            return
        stop = next(unit for unit in reversed(self._units) if unit.spelled is None)
        made_to = self.uncatchable_s >= stop.sent_s
        if not made_to and not self._was_hurt(stop) and stop.disturbances == self._disturbances:
            raise ViolationError(f"{why}, and it moves")
        what = "what noise made of a byte moved it" if made_to else "the stop was damaged"
        self.uncatchable(f"the robot moves until its next command: {what}")

    def is_at_rest(self) -> bool:
        return not (self.end.robot.is_moving or self._queue)

    def _check_known(self) -> None:
        """The robot is where the host says, with its pen as it says; unless a damaged answer said so."""
        if not self._host.answers or self._sent_before == self.tap.sent:
            return  # reckoned only; or known since it was asked last
        robot: Any = self.end.robot
        where = self._wire.where
        wanted, truth = where.frame.to_robot(where.position.robot), robot.odometer
        off_mm, off_deg = truth.distance_to(*wanted[:2]), abs(wrapped(truth.heading_deg - wanted.heading_deg))
        if self._wire.pen_down != self._pen_wanted and where.trusts_pen:
            raise ViolationError(
                f"the pen should be {'down' if self._pen_wanted else 'up'}, and the driver forgot it"
            )
        is_right = off_mm <= TOLERANCE_MM and off_deg <= TOLERANCE_DEG
        has_pen = robot._pen_target == self._wire.pen_down or not where.trusts_pen
        if is_right and has_pen and self.is_at_rest():
            return
        if self._answers_damaged == self._damage_to_host():
            raise ViolationError(
                f"the robot is at {truth}, its pen {robot._pen_target}; the host says {wanted}, {self._wire.pen_down}"
            )
        self.uncatchable("the robot is elsewhere, and a damaged answer hid it")

    # ------------------------------------------------------------------ rules

    async def pause(self, seconds: float) -> None:
        await self._wire.until(lambda: False, self.now + seconds)

    @rule(weight=10.0, distance_mm=DISTANCE)
    def forward(self, distance_mm: float) -> None:
        self.do(self.driver.forward(distance_mm))

    @rule(weight=10.0, angle_deg=ANGLE)
    def right(self, angle_deg: float) -> None:
        self.do(self.driver.right(angle_deg))

    @rule(weight=4.0, x_mm=PLACE, y_mm=PLACE)
    def set_position(self, x_mm: float, y_mm: float) -> None:
        self.do(self.driver.set_position(x_mm, y_mm))

    @rule(weight=2.0, x_mm=PLACE)
    def set_x(self, x_mm: float) -> None:
        self.do(self.driver.set_x(x_mm))

    @rule(weight=2.0, y_mm=PLACE)
    def set_y(self, y_mm: float) -> None:
        self.do(self.driver.set_y(y_mm))

    @rule(weight=2.0, heading_deg=Real(0.0, 359.0))
    def set_heading(self, heading_deg: float) -> None:
        self.do(self.driver.set_heading(heading_deg))

    @rule(weight=1.0)
    def home(self) -> None:
        self.do(self.driver.home())

    @rule(weight=0.3, angle_deg=ANGLE, radius_mm=Real(1.0, 30.0))
    def arc(self, angle_deg: float, radius_mm: float) -> None:
        self.do(self.driver.arc(angle_deg, radius_mm))

    @rule(weight=5.0, down=FLAG)
    def pen(self, down: bool) -> None:
        self._pen_wanted = down
        self.do(self.driver.pen_down() if down else self.driver.pen_up())

    @rule(weight=2.0, speed=Whole(40, 255))
    def set_speed(self, speed: int) -> None:
        self.do(self.driver.set_speed(speed))

    @rule(weight=2.0, tone=one_of("off", "low", "high"))
    def horn(self, tone: str) -> None:
        self.do(self.driver.horn(tone))

    @rule(weight=2.0, on=FLAG)
    def lamp(self, on: bool) -> None:
        self.do(self.driver.lamp(on))

    @rule(weight=6.0)
    def finish(self) -> None:
        """Afterwards the host knows where the robot is."""
        self.do(self.driver.finish())
        self._check_known()

    @rule(weight=1.0, seconds=Real(0.0, 1.0))
    def wait(self, seconds: float) -> None:
        self.do(self.driver.wait(seconds))
        self._check_known()

    @rule(weight=1.0)
    def clear_screen(self) -> None:
        self.do(self.driver.clear_screen())
        self._check_known()

    @rule(weight=0.5, on=FLAG)
    def step_by_step(self, on: bool) -> None:
        self.do(self.driver.set_step_by_step(on))

    @rule(weight=2.0)
    def reported_pose(self) -> None:
        """What the robot says is where it is: an answer that was damaged is not believed."""
        pose = self.do(self.driver.reported_pose())
        truth = self._wire.where.frame.from_robot(self.end.robot.odometer)
        if (
            truth.distance_to(*pose[:2]) > TOLERANCE_MM
            or abs(wrapped(truth.heading_deg - pose[2])) > TOLERANCE_DEG
        ):
            raise ViolationError(f"the robot says that it is at {pose}, but it is at {truth}")

    @rule(weight=4.0, speed=UNIT, turn=UNIT, valid_s=VALID)
    def drive(self, speed: float, turn: float, valid_s: float | None) -> None:
        self.do(self.driver.drive(speed, turn, valid_s=valid_s))

    @rule(weight=1.0, speed=UNIT, turn=UNIT, every_s=one_of(0.005, 0.0167, 0.05))
    def joystick(self, speed: float, turn: float, every_s: float) -> None:
        """One after the other, faster than the wire may be."""
        for n in range(1, 11):
            self.do(self.driver.drive(speed * n / 10, turn * n / 10, valid_s=0.3))
            self._runner.run(self.pause(every_s))

    @rule(
        weight=2.0,
        key=one_of(m.MoveFaster(), m.TurnSlower(), m.RaisePen(), m.LowerPen(), m.StartLeft(), m.Stop()),
    )
    def press(self, key: m.DirectKey) -> None:
        self.do(self.driver.press(key))
        if isinstance(key, m.RaisePen | m.LowerPen):
            self._pen_wanted = isinstance(key, m.LowerPen)
