"""The robot's end of the wire, plainly, from the protocol's page."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from tests.soak.wire import Mark

CR, LF = 0x0D, 0x0A
ATTENTION, EMERGENCY = b"\0\0\0\0\0\r2\r 1\r", b"\0\0\0\0\0\r2\r "
QUEUE = 16
# How many bytes of arguments follow the letters of a line, and a key of direct control.
BASIC = {b"2": 0, b"F": 2, b"B": 2, b"V": 1, b"L": 2, b"R": 2, b"PU": 0, b"PD": 0}
GROUPS = {
    "C": {b"CR": 0, b"C0": 0, b"CH": 2, b"CL": 4, b"CX": 2, b"CY": 2},
    "Q": {b"QT": 4, b"QH": 0, b"QL": 0, b"QX": 0, b"QY": 0, b"QP": 0},
    "H": {b"H0": 0, b"HL": 0, b"HH": 0},
    "E": {b"E1": 0, b"E0": 0},
}
KEYS = dict.fromkeys((b" ", b"1", b"A", b"Z", b"D", b"C", b"F", b"V", b"S", b"X", b",", b"."), 0)
KEYS |= {b"G": 1, b"B": 1}
MOTIONS = (b"F", b"B", b"L", b"R", b"CR", b"C0", b"CH", b"CL", b"CX", b"CY")


class Spelled(NamedTuple):
    """What a line, or a key, says."""

    letters: bytes
    arguments: bytes
    is_key: bool

    def __str__(self) -> str:
        return f"{self.letters.decode()} {self.arguments.hex()}".strip() or "an empty line"


class Reference:
    """The robot's end, plainly: bytes with their marks in, lines and keys out (W1, W2, W6)."""

    def __init__(self, groups: str) -> None:
        self.lines = BASIC.copy()
        for group in groups:
            self.lines |= GROUPS[group]
        self._raw: list[tuple[int, Mark]] = []
        self._wanted = -1  # bytes that are still to come, RET included; -1: letters
        self._drops = False
        self._may_skip = False
        self.is_direct = False

    def arrived(self, byte: int, mark: Mark) -> tuple[Spelled, list[Mark]] | None:
        """What a byte completes, if anything that means something."""
        if self._may_skip:
            self._may_skip = False
            if byte == LF:
                return None
        self._raw.append((byte, mark))
        return self._key(byte) if self.is_direct else self._line(byte)

    def _line(self, byte: int) -> tuple[Spelled, list[Mark]] | None:
        raw = bytes(b for b, _ in self._raw)
        if self._drops:
            if byte == CR:
                self._end()
            return None
        if self._wanted < 0:
            letters = raw.upper()
            if raw == b"\r":
                return self._done(b"")
            if letters in self.lines:
                self._wanted = self.lines[letters] + 1
            elif not any(known.startswith(letters) for known in self.lines):
                self._drops = True
                if byte == CR:
                    self._end()
            return None
        self._wanted -= 1
        if self._wanted:
            return None
        letters = next(raw[:n].upper() for n in (1, 2) if raw[:n].upper() in self.lines)
        if byte != CR:
            self._drops = True
            return None
        return self._done(letters)

    def _key(self, byte: int) -> tuple[Spelled, list[Mark]] | None:
        raw = bytes(b for b, _ in self._raw)
        letter = raw[:1].upper()
        if letter in KEYS:
            return self._done(letter) if len(raw) == 1 + KEYS[letter] else None
        if byte == CR:
            return self._done(b"")
        self._forget()
        return None

    def _end(self) -> None:
        """The RET of a line that is dropped."""
        self._forget()
        self._may_skip = True

    def _forget(self) -> None:
        self._raw, self._wanted, self._drops = [], -1, False

    def _done(self, letters: bytes) -> tuple[Spelled, list[Mark]]:
        raw, marks = bytes(b for b, _ in self._raw), [mark for _, mark in self._raw]
        is_key = self.is_direct and bool(letters)
        arguments = raw[len(letters) :] if is_key else raw[len(letters) : -1]
        self._forget()
        self._may_skip = not is_key
        if letters == b"2" and not is_key:
            self.is_direct = True
        elif letters == b"1" and is_key:
            self.is_direct = False
        return Spelled(letters, arguments, is_key), marks


class Unit:
    """A line, a key, or a whole attention or emergency stop that the host sent."""

    def __init__(self, number: int, first: int, data: bytes, spelled: Spelled | None) -> None:
        self.number, self.first, self.data, self.spelled = number, first, data, spelled
        self.executed = False
        # What else had gone wrong when it was sent, counted; and when that was.
        self.disturbances, self.sent_s = 0, 0.0
