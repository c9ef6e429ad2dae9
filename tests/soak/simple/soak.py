"""The soak of the car: its model, and what must hold (decisions S1..S9).

The model of the robot's end is written anew from the protocol's page: it groups the bytes that arrive by seven and
spells them. So whatever the car does is compared with what the bytes say, and as every byte is known, with what the
host sent: a command as it was sent, a stop on the way back into step, or a command that a fault made, which this wire,
with no checksum, cannot notice.
"""

from __future__ import annotations

import re
from typing import Any, NamedTuple

from tests.soak.domains import FLAG, Whole, rule
from tests.soak.simple.model import CarModel
from tests.soak.simple.reference import LIGHTS
from tests.soak.timed import VALID
from tests.soak.wire import ViolationError
from turtlewire.errors import NoReplyError, PoseUncertainError
from turtlewire.turtle import Pose

# Places are told in whole millimetres.
BESIDE_MM = 3.0


class Troubles(NamedTuple):
    """What may make a reckoning wrong, counted."""

    uncatchable: int
    noticed: int
    stops: int
    disturbances: int
    links: int


class CarSoak(CarModel):
    """A car, its driver, and what must hold."""

    # ------------------------------------------------------------------ what must hold

    def before_step(self, name: str) -> None:
        self._from_s = self.now
        self._owes_notice = False
        self._before = self._troubles()
        # Still moving, or just told to stop: what is on its way belongs to what was before.
        self._was_moving = self.driver._is_driven or self._truth["drive"] != 0
        is_sure = not self._unsure.keys() & {"drive", "steer"}
        is_calm = self.now >= self.unrest_until_s and self.driver.link_state == "connected"
        self._was_sure = is_sure and is_calm and self._host.in_step
        self.new_ways()

    def _troubles(self) -> Troubles:
        report = self.report
        return Troubles(
            report.uncatchable.total(), report.noticed.total(), report.stops, self._disturbances, self._links
        )

    def check(self) -> None:
        if self._expected:
            raise ViolationError(f"the car did not carry out {self._expected[0]!r}")
        if self._state_of_robot() != self._truth:
            raise ViolationError(f"the car is {self._state_of_robot()}, but by its bytes {self._truth}")
        self._check_state()
        host = self._host
        if host.idle and host.in_step:
            # What nobody wants, or a stop has ended, stands still and stays so.
            for channel, value in ({"drive": 0, "steer": 0} | self._wanted).items():
                if self._truth[channel] != value and channel not in self._unsure:
                    raise ViolationError(f"{channel} is wanted to be {value}, but is {self._truth[channel]}")
        if self._owes_notice and not self.error and self.notes == 0 and self.driver.trouble is None:
            raise ViolationError("something went wrong while the car drove, and nobody was told")
        if isinstance(self.error, PoseUncertainError) and not self._is_still():
            raise ViolationError("an error says that the car was stopped, and it drives")
        if isinstance(self.error, NoReplyError) and host.in_step and not self._is_still():
            raise ViolationError("an error says that the car was stopped, and it drives")
        self._check_place()

    def _is_still(self) -> bool:
        is_still = self._truth["drive"] == 0
        return is_still or bool(self._unsure.keys() & {"drive"})

    def _check_place(self) -> None:
        """Where the car is by reckoning: exact where nothing went wrong, near where it was driven by hand."""
        now, before = self._troubles(), self._before
        if (
            isinstance(self.error, PoseUncertainError)
            and self._was_sure
            and not self._was_moving
            and now.uncatchable == before.uncatchable
        ):
            self._check_uncertain(str(self.error))
        if now != before or self.error or not self._was_sure:
            return
        off_mm, off_deg = self.off()
        by_hand = self._was_moving or self.driver._is_driven
        # Bytes are late, or a heartbeat is on the line before them.
        jitter_s = self.setup["delay_s"] + (0.008 if self.setup["watchdog"] else 0.0)
        most_mm = 60.0 if by_hand else 1.0 + 1000.0 * jitter_s
        most_deg = 8.0 if by_hand else 0.5 + 1000.0 * jitter_s
        if off_mm > most_mm or off_deg > most_deg:
            raise ViolationError(
                f"nothing went wrong, and the car is {off_mm:.2f} mm, {off_deg:.2f} degrees off"
            )

    def _check_uncertain(self, text: str) -> None:
        """An error says between which places the car stands."""
        numbers = [float(n) for n in re.findall(r"(?:x|y|heading) (-?\d+)", text)]
        first, last = Pose(*numbers[:3]), Pose(*numbers[3:])
        here, way_mm = self.ways.in_account(self.end.robot.pose), first.distance_to(*last[:2])
        bulge_mm = way_mm**2 / (8.0 * self.driver.turning_radius_mm)
        # The sum of the ways to both ends is what it is on the straight line between, and a little more beside it.
        beside_mm = here.distance_to(*first[:2]) + here.distance_to(*last[:2]) - way_mm
        if beside_mm > 2.0 * bulge_mm + BESIDE_MM:
            raise ViolationError(f"the car is at {here}, not between {first} and {last}")

    def is_at_rest(self) -> bool:
        return self._truth["drive"] == 0 and not self._host_will_move()

    def _host_will_move(self) -> bool:
        return False

    # ------------------------------------------------------------------ rules

    @rule(weight=8.0, pwm=Whole(-255, 255), valid_s=VALID)
    def motor(self, pwm: int, valid_s: float | None) -> None:
        self.do(self.driver.motor(pwm, valid_s=valid_s))
        self._returned("drive", pwm)

    @rule(weight=8.0, steering=Whole(-255, 255))
    def steer(self, steering: int) -> None:
        self.do(self.driver.steer(steering))
        self._returned("steer", steering)

    @rule(weight=5.0, bits=Whole(0, 15))
    def headlights(self, bits: int) -> None:
        lights = tuple(bool(bits >> n & 1) for n in range(4))
        self.do(self.driver.headlights(**dict(zip(LIGHTS, lights, strict=True))))
        self._returned("lights", lights)

    @rule(weight=1.0, on=FLAG)
    def lamp(self, on: bool) -> None:
        self.do(self.driver.lamp(on))
        self._returned("lights", (on,) * 4)

    def _returned(self, channel: str, value: Any) -> None:
        """A command that returns has been carried out, unless its time was up before."""
        may_be = (
            [value, 0] if channel != "lights" and self._from_s < self._valid_until <= self.now else [value]
        )
        if self._truth[channel] not in may_be and channel not in self._unsure:
            raise ViolationError(f"{channel} should be {value} now, but is {self._truth[channel]}")
