"""The car's end of the wire, plainly, from the protocol's page; and what a soak calls by name."""

from __future__ import annotations

from typing import Any

from tests.soak.domains import FLAG, Domain, one_of
from tests.soak.wire import Mark

BAUD = 9600
BYTE_S = 10.0 / BAUD
LENGTH = 7
WHOLE_STOP = b"S000000"
REPLY_DELAY_S = 0.05
RETRIES = 3
CHANNELS = {"F": "drive", "B": "drive", "L": "steer", "R": "steer", "H": "lights"}
VERBS = {
    "F": "drive_forward speed",
    "B": "drive_backward speed",
    "L": "steer_left lock",
    "R": "steer_right lock",
}
SETUP: dict[str, Domain] = {
    "window": one_of(1, 1, 1, 2, 4, 8),
    "watchdog": FLAG,
    "turn": one_of("spot", "spot", "arc"),
    "pen_light": FLAG,
    "delay_s": one_of(0.0, 0.0, 0.004),
    "split": one_of(0, 0, 1, 3),
}
LIGHTS = ("left_upper", "left_lower", "right_upper", "right_lower")


def spell(raw: bytes) -> tuple[str, Any] | None:
    """What seven bytes say: the channel, and what it is set to; None: nothing (S1..S5)."""
    letter, digits = chr(raw[0]), raw[1:]
    if letter == "S":
        return "stop", 0
    if letter == "H":
        bits = digits[:4]
        return ("lights", tuple(b != 0x30 for b in bits)) if all(0x30 <= b <= 0x39 for b in bits) else None
    if letter not in CHANNELS or not all(0x30 <= b <= 0x39 for b in digits[:3]):
        return None
    value = (digits[0] - 48) * 100 + (digits[1] - 48) * 10 + digits[2] - 48
    if value > 255:
        return None
    return CHANNELS[letter], -value if letter in "BL" else value


def said(raw: bytes) -> str:
    """How the simulated car tells of a command."""
    letter, digits = chr(raw[0]), raw[1:]
    if letter == "S":
        return "stop"
    if letter == "H":
        bits = (f"{name}={int(b != 0x30)}" for name, b in zip(LIGHTS, digits[:4], strict=True))
        return " ".join(["headlights", *bits])
    return f"{VERBS[letter]}={int(digits[:3])}"


class Unit:
    """Bytes that the host sent together: a command, or a part of the way back into step.

    Attributes:
        kind: ``"command"``, ``"emergency"`` or ``"way back"``.
        executed: whether the car has carried it out as it was sent; twisted: or something else that was made of it.
    """

    def __init__(self, number: int, first: int, data: bytes, kind: str) -> None:
        self.number, self.first, self.data, self.kind = number, first, data, kind
        self.spelled = spell(data) if kind == "command" else None
        self.executed = self.twisted = False

    def is_whole(self, marks: list[Mark]) -> bool:
        """Whether these are all of its bytes, as they were sent, and nothing else."""
        return marks == [Mark(self.first + n) for n in range(len(self.data))]

    def is_begun(self, marks: list[Mark], others: list[str], spelled: tuple[str, Any]) -> bool:
        """Whether these begin with its first bytes, and are completed, to what it says, by bytes of no other command.

        ``others`` are the kinds of what the other bytes belong to.
        """
        own = len(marks) - len(others)
        return (
            own > 0
            and marks[:own] == [Mark(self.first + n) for n in range(own)]
            and "command" not in others
            and spelled == self.spelled
        )


class Doubts(dict[str, int]):
    """Channels of which the host may be wrong, by something that it cannot notice; and which unit ends that."""

    def doubt(self, channel: str, until: int = 0) -> None:
        """The host may be wrong of this, until the car carries out that unit or a later one."""
        for each in ("drive", "steer") if channel == "stop" else (channel,):
            self[each] = max(until, self.get(each, 0))

    def sure(self, channel: str, unit: Unit) -> None:
        """The car has carried this out as it was sent."""
        for each in ("drive", "steer") if channel == "stop" else (channel,):
            if self.get(each, 0) <= unit.number:
                self.pop(each, None)


def what_happened(marks: list[Mark], units: list[Unit]) -> str:
    """What faults made of the bytes of these."""
    faults = {m.fault for m in marks} - {""}
    if len(units) == 1 and faults == {"flipped"}:
        return "a letter changed" if marks[0].fault else "a digit changed"
    kinds = {unit.kind for unit in units}
    if "added" in faults or "doubled" in faults:
        return "a byte added" if len(kinds) == 1 else "a byte added on the way back"
    if kinds == {"command"}:
        return "spliced of two commands, a byte lost"
    return "spliced with a stop, a byte lost"


def way_back_limits(window: int, *, is_calm: bool) -> tuple[int, float]:
    """How many bytes, and seconds, a way back into step may take: S7; with faults on it, every attempt again."""
    each_s = BYTE_S + BYTE_S + REPLY_DELAY_S
    if is_calm:
        # First what is under way has to end; then byte by byte, and the stop.
        return 14, (LENGTH * window + 14) * BYTE_S + REPLY_DELAY_S + (LENGTH + 2) * each_s + 0.02
    quiet_s = 1.0
    return (RETRIES + 1) * 21, (RETRIES + 1) * (quiet_s + 15 * each_s + LENGTH * BYTE_S + REPLY_DELAY_S)
