"""The kernel for thousands of robots: what ``scalar_fleet`` does for one, in NumPy for all at once.

The formulas are those of ``drivetrain``, ``chassis``, ``leg`` and ``world``; property tests hold the two equal. A grid
knows which obstacles can matter where, and each robot how far it is free to go: only the few that are about to meet
something are checked against it. Needs NumPy; nothing else in the simulator does.
"""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from turtlewire.simulator.body import LOOK_S
from turtlewire.simulator.drivetrain import SETTLED_MM_PER_S
from turtlewire.simulator.fleet_columns import CAR, FRAME, WALTER, Flags, Floats, Index, Kinds, State
from turtlewire.simulator.fleet_obstacles import Obstacles
from turtlewire.simulator.scalar_fleet import MAX_PIECES, STEPS_PER_GRIP, world_of
from turtlewire.simulator.settings import FULL_SPEED
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from collections.abc import Sequence

    from turtlewire.simulator.scalar_fleet import AnySettings


class ArrayFleet:
    """A fleet in NumPy; see ``scalar_fleet``.

    Raises ``UsageError`` if the robots are not all in the same world.

    Attributes:
        x_mm, y_mm, heading_deg: where the robots are: arrays, one place for each robot.
        bumped: which robots press into something, or (a WALTER) were stopped by it.
    """

    def __init__(self, robots: Sequence[AnySettings]) -> None:
        world = world_of(robots)
        self._kinds = Kinds.of(robots)
        poses = np.array([settings.first_pose for settings in robots], dtype=np.float64)
        count = len(robots)
        columns: dict[str, Any] = {f.name: np.zeros(count) for f in fields(State)}
        self._state = State(
            **columns
            | {
                "x_mm": poses[:, 0].copy(),
                "y_mm": poses[:, 1].copy(),
                "heading_deg": poses[:, 2].copy(),
                "steer_deg": self._kinds.trim_deg.copy(),
                "grip_left": np.ones(count),
                "grip_right": np.ones(count),
                "bumped": np.zeros(count, dtype=np.bool_),
            }
        )
        self._obstacles = Obstacles(world, float(self._kinds.radius_mm.max()), self._longest_step_mm())
        self._slips = bool(self._kinds.slip.any())
        self._is_noisy = bool(self._kinds.noise_mm.any())
        self._sags = bool(self._kinds.sag.any())
        # The wheels' speeds, as long as all motors and servos do what they were told to.
        self._steady: tuple[Floats, Floats] | None = None
        self._random = np.random.default_rng([settings.seed for settings in robots])
        self._steps = 0

    def _longest_step_mm(self) -> float:
        kinds = self._kinds
        ahead = FULL_SPEED * np.maximum(
            kinds.mm_per_s, np.where(kinds.kind == FRAME, kinds.second_per_unit, 0.0)
        )
        tangent = np.tan(
            np.radians(kinds.trim_deg + np.where(kinds.kind == CAR, kinds.second_per_unit, 0.0) * FULL_SPEED)
        )
        ahead *= 1.0 + np.where(
            kinds.kind == CAR, np.abs(tangent) * kinds.offset_mm / kinds.wheelbase_mm, 0.0
        )
        spread = 6.0 * kinds.noise_mm * np.sqrt(ahead * LOOK_S / 1000.0)
        return float((ahead * LOOK_S + spread).max())

    @property
    def time_s(self) -> float:
        """Seconds since power-on."""
        return self._steps * LOOK_S

    @property
    def x_mm(self) -> Floats:
        """Where the robots are."""
        return self._state.x_mm

    @property
    def y_mm(self) -> Floats:
        """Where the robots are."""
        return self._state.y_mm

    @property
    def heading_deg(self) -> Floats:
        """Where the robots look, 0..360, clockwise, 0 = +Y."""
        return self._state.heading_deg

    @property
    def bumped(self) -> Flags:
        """Which robots press into something, or (a WALTER) were stopped by it."""
        return self._state.bumped

    def set_points(self, first: Sequence[float] | Floats, second: Sequence[float] | Floats) -> None:
        """What each robot is told from now on, -255..255 (beyond, it is cut). One value for each robot."""
        self._state.first[:] = np.clip(first, -FULL_SPEED, FULL_SPEED)
        self._state.second[:] = np.clip(second, -FULL_SPEED, FULL_SPEED)
        self._steady = None

    def poses(self) -> list[Pose]:
        """Where the robots truly are on the ground."""
        state = self._state
        rows = zip(state.x_mm.tolist(), state.y_mm.tolist(), state.heading_deg.tolist(), strict=True)
        return [Pose(*row) for row in rows]

    def bumpers(self) -> list[bool]:
        """Which robots press into something, or (a WALTER) were stopped by it."""
        return [bool(bumped) for bumped in self._state.bumped]

    def step(self, steps: int = 1) -> None:
        """Let ``steps`` times 10 ms pass."""
        for _ in range(steps):
            if self._slips and self._steps % STEPS_PER_GRIP == 0:
                self._new_grip()
            left_s = self._whole_step()
            for _ in range(MAX_PIECES - 1):
                index = np.flatnonzero(left_s)
                if not index.size:
                    break
                part, kinds, seconds = self._state.take(index), self._kinds.take(index), left_s[index]
                targets = _targets(kinds, part)
                before = part.left.copy(), part.right.copy(), part.steer_deg.copy()
                done_s = self._roll(kinds, part, _wheels(kinds, part, targets, seconds), seconds)
                _advance(kinds, part, before, targets, done_s)
                left_s[index] = self._over(kinds, part, seconds, done_s)
                self._state.put(index, part)
            self._steps += 1

    def _whole_step(self) -> Floats:
        """One leg for all; what is left of the step for those that have met something."""
        kinds, state = self._kinds, self._state
        seconds = np.full(len(kinds.kind), LOOK_S)
        if self._steady is not None:
            done_s = self._roll(kinds, state, self._steady, seconds)
            return self._over(kinds, state, seconds, done_s)
        before = state.left.copy(), state.right.copy(), state.steer_deg.copy()
        targets = _targets(kinds, state)
        wheels = _wheels(kinds, state, targets, seconds)
        done_s = self._roll(kinds, state, wheels, seconds)
        _advance(kinds, state, before, targets, done_s)
        if not self._sags and all(map(np.array_equal, before, targets)):
            self._steady = wheels
        return self._over(kinds, state, seconds, done_s)

    def _new_grip(self) -> None:
        slip, random = self._kinds.slip, self._random
        self._state.grip_left = 1.0 - slip * random.random(slip.shape)
        self._state.grip_right = 1.0 - slip * random.random(slip.shape)

    def _roll(self, kinds: Kinds, state: State, wheels: tuple[Floats, Floats], seconds: Floats) -> Floats:
        """One leg at these speeds, until something is met; how long it lasts."""
        left, right = wheels
        if self._is_noisy:
            left, right = (self._noisy(kinds, speed * seconds) / seconds for speed in wheels)
        if self._slips:
            left, right = left * state.grip_left, right * state.grip_right
        x, y, heading, way_mm = _end(kinds, state, left * seconds, right * seconds)
        near = np.flatnonzero((way_mm > state.free_mm) & (way_mm > 0.0))
        state.free_mm -= way_mm
        state.bumped &= (left == 0.0) & (right == 0.0)
        done_s = seconds
        if near.size and not self._obstacles.are_none:
            done_s = seconds.copy()
            self._meet(kinds, state, near, (x, y, heading), (left, right), seconds, done_s)
        state.x_mm[:], state.y_mm[:], state.heading_deg[:] = x, y, heading
        return done_s

    def _over(self, kinds: Kinds, state: State, seconds: Floats, done_s: Floats) -> Floats:
        """A leg is over; what is left of its time. A WALTER that met something has stopped (W13)."""
        left_s = np.where(done_s < seconds, seconds - done_s, 0.0)
        stopped = state.bumped & (kinds.kind == WALTER) & ((state.first != 0.0) | (state.second != 0.0))
        if stopped.any():
            self._steady = None
            for column in (state.first, state.second, state.left, state.right, left_s):
                column[stopped] = 0.0
        return left_s

    def _noisy(self, kinds: Kinds, wanted: Floats) -> Floats:
        spread = kinds.noise_mm * np.sqrt(np.abs(wanted) / 1000.0)
        turned = wanted + spread * self._random.standard_normal(wanted.shape)
        return np.where(turned * wanted > 0.0, turned, 0.0)

    def _meet(
        self,
        kinds: Kinds,
        state: State,
        near: Index,
        end: tuple[Floats, Floats, Floats],
        wheels: tuple[Floats, Floats],
        seconds: Floats,
        done_s: Floats,
    ) -> None:
        """Let those that may meet something end where they do; ``end`` and ``done_s`` become what is true."""
        x, y, heading = end
        offset, radius, here_deg = kinds.offset_mm[near], kinds.radius_mm[near], state.heading_deg[near]
        here_x, here_y = _ahead(state.x_mm[near], state.y_mm[near], here_deg, offset)
        there_x, there_y = _ahead(x[near], y[near], heading[near], offset)
        far, free_mm = self._obstacles.meet(here_x, here_y, there_x, there_y, radius)
        way_mm = np.hypot(there_x - here_x, there_y - here_y)
        state.free_mm[near] = free_mm - way_mm
        met = np.flatnonzero(far < np.inf)
        if not met.size:
            return
        who, far, way_mm = near[met], far[met], way_mm[met]
        held = far == 0.0
        part = np.where(held, 1.0, far / way_mm)
        turned = np.degrees((wheels[0][who] - wheels[1][who]) * seconds[who] / kinds.track_mm[who])
        can_turn = ~held | (kinds.kind[who] != CAR)
        now_deg = (here_deg[met] + np.where(can_turn, turned * part, 0.0)) % 360.0
        go = np.where(held, 0.0, part)
        middle_x = here_x[met] + (there_x - here_x)[met] * go
        middle_y = here_y[met] + (there_y - here_y)[met] * go
        # A WALTER that is held refuses to move at all.
        now_deg = np.where(held & (kinds.kind[who] == WALTER), here_deg[met], now_deg)
        x[who], y[who] = _ahead(middle_x, middle_y, now_deg, -offset[met])
        heading[who] = now_deg
        done_s[who] = seconds[who] * part
        state.bumped[who] = True
        state.free_mm[who] = 0.0


def _ahead(x: Floats, y: Floats, heading_deg: Floats, distance_mm: Floats) -> tuple[Floats, Floats]:
    angle = np.radians(heading_deg)
    return x + distance_mm * np.sin(angle), y + distance_mm * np.cos(angle)


def _targets(kinds: Kinds, state: State) -> tuple[Floats, Floats, Floats]:
    """What the left and right motors and the steering go for (``Drivetrain.aim``)."""
    strength = 1.0 - kinds.sag * np.minimum(1.0, state.used_s / kinds.battery_s)
    first, second = (
        np.copysign(np.maximum(0.0, np.abs(value) - kinds.dead), value)
        * np.where(value < 0.0, kinds.backward, 1.0)
        for value in (state.first, state.second)
    )
    is_car, is_walter = kinds.kind == CAR, kinds.kind == WALTER
    left = first * kinds.mm_per_s * strength
    right = np.where(is_car, 0.0, second * kinds.second_per_unit * strength)
    right = np.where(is_walter, np.radians(right) * kinds.track_mm / 2.0, right)
    steer = np.where(is_car, kinds.trim_deg + state.second * kinds.second_per_unit, 0.0)
    return left, right, steer


def _wheels(
    kinds: Kinds, state: State, targets: tuple[Floats, Floats, Floats], seconds: Floats
) -> tuple[Floats, Floats]:
    """The mean speeds of the wheels in the coming time (``Drivetrain.mean``)."""
    first, second = (
        target + (speed - target) * _lagging(_lag_s(kinds, target), seconds)
        for target, speed in zip(targets, (state.left, state.right), strict=False)
    )
    to_go = targets[2] - state.steer_deg
    turning = np.minimum(seconds, np.abs(to_go) / kinds.steer_deg_per_s)
    at_end = state.steer_deg + np.copysign(np.where(to_go == 0.0, 0.0, _slew(kinds, turning)), to_go)
    at_end = np.where(turning < seconds, targets[2], at_end)
    steer = ((state.steer_deg + at_end) / 2.0 * turning + targets[2] * (seconds - turning)) / seconds
    half = np.tan(np.radians(steer)) * kinds.track_mm / kinds.wheelbase_mm / 2.0
    is_car, is_walter = kinds.kind == CAR, kinds.kind == WALTER
    left = np.where(is_car, first * (1.0 + half), np.where(is_walter, first + second, first))
    right = np.where(is_car, first * (1.0 - half), np.where(is_walter, first - second, second))
    return left, right


def _lag_s(kinds: Kinds, target: Floats) -> Floats:
    return np.where(target == 0.0, kinds.coast_s, kinds.lag_s)


def _lagging(lag_s: Floats, seconds: Floats) -> Floats:
    """The mean part of a change of speed that is yet to come, in the coming time."""
    lags = lag_s > 0.0
    return np.where(lags, -np.expm1(-seconds / np.where(lags, lag_s, 1.0)) * lag_s / seconds, 0.0)


def _slew(kinds: Kinds, seconds: Floats) -> Floats:
    rate = kinds.steer_deg_per_s
    return np.where(rate < np.inf, np.where(rate < np.inf, rate, 0.0) * seconds, 0.0)


def _advance(
    kinds: Kinds,
    state: State,
    before: tuple[Floats, Floats, Floats],
    targets: tuple[Floats, Floats, Floats],
    seconds: Floats,
) -> None:
    """Time has passed for motors, steering and battery (``Drivetrain.advance``)."""
    for column, was, target in zip((state.left, state.right), before, targets, strict=False):
        lag_s = _lag_s(kinds, target)
        lags = lag_s > 0.0
        stays = np.where(lags, np.exp(-seconds / np.where(lags, lag_s, 1.0)), 0.0)
        speed = target + (was - target) * stays
        column[:] = np.where(np.abs(speed - target) < SETTLED_MM_PER_S, target, speed)
    to_go = targets[2] - before[2]
    there = np.abs(to_go) <= kinds.steer_deg_per_s * seconds
    state.steer_deg[:] = np.where(there, targets[2], before[2] + np.copysign(_slew(kinds, seconds), to_go))
    first, second = np.abs(state.first), np.abs(state.second)
    power = np.where(
        kinds.kind == FRAME, (first + second) / 2.0, np.where(kinds.kind == CAR, first, first + second)
    )
    state.used_s += np.minimum(1.0, power / FULL_SPEED) * seconds


def _end(kinds: Kinds, state: State, left: Floats, right: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Where so much travel of the wheels leads (``chassis.drive``), and how far the disc gets at most."""
    middle, half = (left + right) / 2.0, (left - right) / kinds.track_mm / 2.0
    turns = half != 0.0
    chord = middle * np.where(turns, np.sin(half) / np.where(turns, half, 1.0), 1.0)
    angle = np.radians(state.heading_deg) + half
    heading = (state.heading_deg + np.degrees(2.0 * half)) % 360.0
    way_mm = np.abs(middle) + kinds.offset_mm * np.abs(2.0 * half)
    return state.x_mm + chord * np.sin(angle), state.y_mm + chord * np.cos(angle), heading, way_mm
