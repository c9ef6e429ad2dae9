"""The robot's end of the wire, plainly, from the protocol's page."""

from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tests.soak.wire import Mark


MAGIC = 0xA3
HEADER, LONGEST = 3, 128
TIMEOUT_S = 0.1
TONES = ("off", "low", "high")


class Form(NamedTuple):
    """A message: its name, how its fields are packed, their names and ranges, and whether the first is a number."""

    name: str
    fields: str
    names: tuple[str, ...]
    ranges: tuple[tuple[float, float], ...]
    channel: str
    key: bool = False

    @property
    def size(self) -> int:
        return 1 + struct.calcsize(">" + self.fields)


ANY = (-math.inf, math.inf)
FORMS: dict[str, dict[int, Form]] = {
    "0.1": {
        0: Form(
            "set_servo_position", "BB", ("servo_id", "position_deg"), ((0, 1), (0, 180)), "servo", key=True
        ),
        1: Form("engine_forward", "BB", ("engine_id", "speed"), ((0, 1), (0, 255)), "engine", key=True),
        2: Form("engine_backward", "BB", ("engine_id", "speed"), ((0, 1), (0, 255)), "engine", key=True),
    },
    "telemetry": {
        0x00: Form(
            "set_servo_position", "BB", ("servo_id", "position_deg"), ((0, 0), (0, 180)), "servo", key=True
        ),
        0x10: Form(
            "set_wheel_speeds", "hh", ("left_mm_per_s", "right_mm_per_s"), ((-800, 800),) * 2, "wheels"
        ),
        0x11: Form("set_lamp", "?", ("on",), (ANY,), "lamp"),
        0x12: Form("beep", "BH", ("tone", "duration_ms"), ((0, 2), (0, 5000)), ""),
        0x13: Form("set_pid_gains", "ff", ("proportional", "integral"), ((0.0, 100.0),) * 2, ""),
    },
}


class Said(NamedTuple):
    """A message in a frame."""

    form: Form
    values: tuple[Any, ...]

    @property
    def channel(self) -> tuple[str, int]:
        """What it sets; with "" it sets nothing, but is a command."""
        return self.form.channel, self.values[0] if self.form.key else 0

    @property
    def text(self) -> str:
        """How the simulated robot tells of it."""
        values = [int(v) if isinstance(v, bool) else v for v in self.values]
        if self.form.name == "beep":
            values[0] = TONES[values[0]]
        return " ".join([self.form.name, *map("{}={}".format, self.form.names, values)])


def crc8(data: bytes) -> int:
    """CRC-8 with polynomial 07, bit by bit."""
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ 0x07) & 0xFF if crc & 0x80 else crc << 1
    return crc


def spell(payload: bytes, forms: dict[int, Form]) -> list[Said] | None:
    """The messages in a payload that are carried out; None: the frame is ignored (F3, F4)."""
    said, at = [], 0
    while at < len(payload):
        form = forms.get(payload[at])
        if form is None or at + form.size > len(payload):
            return None
        values = struct.unpack(">" + form.fields, payload[at + 1 : at + form.size])
        if all(low <= v <= high for v, (low, high) in zip(values, form.ranges, strict=True)):
            said.append(Said(form, values))
        at += form.size
    return said


class Reference:
    """The robot's end, plainly: bytes with their marks in, frames out (F5)."""

    def __init__(self) -> None:
        self._kept: list[tuple[int, Mark]] = []
        self._latest_s = math.inf

    def arrived(self, byte: int, mark: Mark, now: float) -> Iterator[list[tuple[int, Mark]]]:
        """The frames that a byte completes, those that a pause has set free first."""
        yield from self.waited(now)
        self._kept.append((byte, mark))
        self._latest_s = now
        yield from self._scan(ended=False)

    def waited(self, now: float) -> Iterator[list[tuple[int, Mark]]]:
        """A partial frame is given up after a pause."""
        if self._kept and now >= self._latest_s + TIMEOUT_S:
            yield from self._scan(ended=True)

    def _scan(self, *, ended: bool) -> Iterator[list[tuple[int, Mark]]]:
        kept = self._kept
        while kept:
            if kept[0][0] != MAGIC:
                del kept[0]
                continue
            if len(kept) >= HEADER:
                size = kept[2][0] + HEADER + 1
                if size > LONGEST:
                    del kept[0]
                    continue
                if len(kept) >= size:
                    if crc8(bytes(b for b, _ in kept[: size - 1])) != kept[size - 1][0]:
                        del kept[0]
                        continue
                    yield kept[:size]
                    del kept[:size]
                    continue
            if not ended:
                return
            del kept[0]


class Unit:
    """A frame that the host sent."""

    def __init__(self, number: int, first: int, data: bytes, said: list[Said]) -> None:
        self.number, self.first, self.data, self.said = number, first, data, said
        self.executed = False
