"""simple, the host's end: what it knows of the robot, and what it reports."""

from __future__ import annotations

from typing import NamedTuple

from turtlewire.protocols.simple.messages import Headlights, SimpleCommand, Stop


class RobotState(NamedTuple):
    """What is known of the robot, by what it has accepted; None: not known.

    ``drive`` and ``steer`` are -255 .. 255 (PWM; forward and right are positive), ``lights`` the four bits of
    ``Headlights``.
    """

    drive: int | None = None
    steer: int | None = None
    lights: tuple[int, ...] | None = None

    def after(self, command: SimpleCommand) -> RobotState:
        """The state when the robot has carried out a command."""
        if isinstance(command, Stop):
            return self._replace(drive=0, steer=0)
        if isinstance(command, Headlights):
            return self._replace(lights=command.values())
        if command.CHANNEL == "drive":
            return self._replace(drive=command.SIGN * command.values()[0])
        if command.CHANNEL == "steer":
            return self._replace(steer=command.SIGN * command.values()[0])
        return self

    def during(self, command: SimpleCommand) -> RobotState:
        """The state while a command is under way: what it changes is not known until it is answered."""
        after = self.after(command)
        return RobotState(
            self.drive if self.drive == after.drive else None,
            self.steer if self.steer == after.steer else None,
            self.lights if self.lights == after.lights else None,
        )

    def __str__(self) -> str:
        lights = None if self.lights is None else "".join(map(str, map(int, self.lights)))
        known = {"drive": self.drive, "steering": self.steer, "headlights": lights}
        return ", ".join(f"{name} {'unknown' if value is None else value}" for name, value in known.items())


class Done(NamedTuple):
    """The robot has accepted a command; with the tag it was submitted with."""

    command: SimpleCommand
    tag: object


class Superseded(NamedTuple):
    """A set-point came to nothing: a newer one of its channel replaced it, or a stop cancelled it.

    It may have been carried out before, if it had been sent and its reply was lost.
    """

    command: SimpleCommand
    tag: object


class OutOfStep(NamedTuple):
    """Something was lost or damaged; S7 has begun. ``unknown`` are the commands whose fate is not known (S8)."""

    reason: str
    unknown: tuple[SimpleCommand, ...]


class InStep(NamedTuple):
    """Host and robot are in step, and the robot has stopped."""

    state: RobotState


class GaveUp(NamedTuple):
    """A set-point was lost too often, and is not sent again (S8)."""

    command: SimpleCommand
    tag: object
    state: RobotState


class LinkDead(NamedTuple):
    """S7 failed: what the robot does is not known. Nothing more is sent until ``connect``, a stop or an emergency stop.

    ``unfinished`` are the tags of everything that was submitted and not reported otherwise.
    """

    reason: str
    unfinished: tuple[object, ...]


Event = Done | Superseded | OutOfStep | InStep | GaveUp | LinkDead
