"""An emulated Arduino Uno: unmodified programs, cycle by cycle, with what goes in and out stamped."""

from __future__ import annotations

import ctypes
import os
import subprocess
from functools import cache
from pathlib import Path
from tempfile import gettempdir
from typing import TYPE_CHECKING, Any, NamedTuple, Self

if TYPE_CHECKING:
    from collections.abc import Sequence

SOURCE = Path(__file__).with_name("board.c")
CHIP, FREQUENCY_HZ = "atmega328p", 16_000_000
# The Uno's digital pins, then A0 to A5: the chip's port and bit.
PINS = [
    *(("D", bit) for bit in range(8)),
    *(("B", bit) for bit in range(6)),
    *(("C", bit) for bit in range(6)),
]
# By the port's letter and the bit, as the board reports them.
_NUMBERS = {ord(port) << 8 | bit: number for number, (port, bit) in enumerate(PINS)}
ROOM = 4096


class _Stamped(ctypes.Structure):
    _fields_ = [("cycle", ctypes.c_uint64), ("what", ctypes.c_uint32)]


class Sent(NamedTuple):
    """A byte that the chip sent: when its last bit was on the wire, in seconds."""

    time_s: float
    byte: int


class Edge(NamedTuple):
    """A pin that changed: when, in seconds, and to which level."""

    time_s: float
    level: int


class ChipError(Exception):
    """The program crashed, or touched memory that there is not."""


@cache
def _library() -> Any:
    from hashlib import sha256

    made = (
        Path(gettempdir())
        / f"turtlewire-board-{os.getuid()}-{sha256(SOURCE.read_bytes()).hexdigest()[:12]}.so"
    )
    if not made.exists():
        new = made.with_suffix(f".{os.getpid()}")
        flags = ["-O2", "-fPIC", "-shared", "-I/usr/include/simavr"]
        command = ["cc", *flags, str(SOURCE), "-o", str(new), "-lsimavr", "-lelf"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        new.replace(made)
    library = ctypes.CDLL(str(made))
    board, u64, size, real = ctypes.c_void_p, ctypes.c_uint64, ctypes.c_size_t, ctypes.c_double
    some = ctypes.POINTER(_Stamped)
    for name, result, arguments in (
        ("new", board, [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_uint32]),
        ("run", ctypes.c_int, [board, u64, size]),
        ("receive", None, [board, ctypes.c_char_p, size, u64, real, real]),
        ("reset", None, [board]),
        ("power_on", None, [board, ctypes.c_uint32]),
        ("flash", ctypes.POINTER(ctypes.c_uint8), [board]),
        ("free", None, [board]),
        ("sent", size, [board, size, some, size]),
        ("edges", size, [board, size, some, size]),
        ("cycle", u64, [board]),
        ("byte_cycles", real, [board]),
        ("overruns", u64, [board]),
        ("peek", ctypes.c_uint8, [board, ctypes.c_uint16]),
        ("press", None, [board, ctypes.c_char, ctypes.c_int, ctypes.c_int]),
        ("voltage", None, [board, ctypes.c_int, ctypes.c_uint32]),
        ("untouched", ctypes.c_uint32, [board]),
        ("complaints", ctypes.c_char_p, []),
        ("forgive", None, []),
    ):
        function = getattr(library, f"board_{name}")
        function.restype, function.argtypes = result, arguments
    return library


class Board:
    """One board. A context manager; time moves only in ``run`` and ``reply``.

    Args:
        program: the ELF file; None: the flash is erased.
        baud: at which the host sends; the chip has its own idea of the same rate.
    """

    def __init__(self, program: Path | None, baud: int) -> None:
        self.baud = baud
        self._library = _library()
        self._library.board_forgive()
        elf = None if program is None else os.fsencode(program)
        self._board = self._library.board_new(elf, CHIP.encode(), FREQUENCY_HZ)
        assert self._board, f"{program} is no program for the {CHIP}"
        self._items = (_Stamped * ROOM)()
        self._sent_seen = 0
        self._edges_seen = 0
        self._edges: dict[int, list[Edge]] = {pin: [] for pin in range(len(PINS))}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._library.board_free(self._board)

    # Time

    @property
    def now_s(self) -> float:
        """The time since power-on."""
        return float(self._library.board_cycle(self._board)) / FREQUENCY_HZ

    def run(self, seconds: float) -> None:
        """Let time pass. Raises ``ChipError``."""
        self._run(seconds, 0)

    def reply(self, count: int = 1, within_s: float = 1.0) -> bytes:
        """Run until so many more bytes were sent, or the time is over; return the bytes."""
        self._run(within_s, self._sent_seen + count)
        return bytes(sent.byte for sent in self.sent())

    def run_until_sent(self, seconds: float) -> None:
        """Let time pass, until the program has something more sent: it is on the wire a little later."""
        self._run(seconds, self._sent_seen + 1)

    def _run(self, seconds: float, wanted: int) -> None:
        until = self._library.board_cycle(self._board) + max(1, round(seconds * FREQUENCY_HZ))
        if not self._library.board_run(self._board, until, wanted):
            raise ChipError(self._library.board_complaints().decode(errors="replace"))

    def reset(self) -> None:
        """Press the reset button."""
        self._library.board_reset(self._board)

    def power_on(self, address: int = 0) -> None:
        """Switch power off and on; from then on a reset leads to this address, as fuses may say."""
        self._library.board_power_on(self._board, address)

    # The serial line

    def receive(self, data: bytes, *, gap_s: float = 0.0, after_s: float = 0.0) -> None:
        """The host's bytes go on the wire, behind those that are on it; with pauses between them, if wanted."""
        byte_cycles = FREQUENCY_HZ * 10.0 / self.baud
        start = self._library.board_cycle(self._board) + round(after_s * FREQUENCY_HZ)
        self._library.board_receive(self._board, data, len(data), start, byte_cycles, gap_s * FREQUENCY_HZ)

    def sent(self) -> list[Sent]:
        """What the chip has sent since the last call."""
        found = self._new(self._library.board_sent, self._sent_seen)
        self._sent_seen += len(found)
        return [Sent(cycle / FREQUENCY_HZ, what) for cycle, what in found]

    @property
    def overruns(self) -> int:
        """How many bytes were lost in the receiver, because the program did not fetch them in time."""
        return int(self._library.board_overruns(self._board))

    @property
    def rate(self) -> float:
        """Bits per second, as the program has set the chip."""
        return FREQUENCY_HZ * 10.0 / float(self._library.board_byte_cycles(self._board))

    # Pins

    def edges(self, pin: int) -> list[Edge]:
        """How a digital pin has changed, since power-on."""
        found = self._new(self._library.board_edges, self._edges_seen)
        self._edges_seen += len(found)
        for cycle, what in found:
            if (pin_edges := self._edges.get(_NUMBERS.get(what >> 8, -1))) is not None:
                pin_edges.append(Edge(cycle / FREQUENCY_HZ, what & 0xFF))
        return self._edges[pin]

    def level(self, pin: int) -> int:
        """The level of a digital pin now."""
        edges = self.edges(pin)
        return edges[-1].level if edges else 0

    def duty(self, pin: int, seconds: float) -> float:
        """The part of the coming time, 0..1, that a pin is high."""
        start_s, level = self.now_s, self.level(pin)
        known = len(self.edges(pin))
        self.run(seconds)
        high_s, since_s = 0.0, start_s
        for edge in self.edges(pin)[known:]:
            high_s += (edge.time_s - since_s) * level
            since_s, level = edge
        return (high_s + (self.now_s - since_s) * level) / (self.now_s - start_s)

    def pwm(self, pin: int) -> int:
        """What ``analogWrite`` has set for pin 5 or 6, 0..255: by the registers of timer 0, at once."""
        shift, value = {5: (5, 0x48), 6: (7, 0x47)}[pin]  # COM0B1 and OCR0B, COM0A1 and OCR0A
        return self.peek(value) if self.peek(0x44) >> shift & 1 else 255 * self.level(pin)

    def press(self, pin: int, level: int) -> None:
        """Something outside pulls a pin."""
        port, bit = PINS[pin]
        self._library.board_press(self._board, port.encode(), bit, level)

    def voltage(self, channel: int, volts: float) -> None:
        """What an analogue pin, A0 to A5, is at."""
        self._library.board_voltage(self._board, channel, round(volts * 1000.0))

    # Memory

    def peek(self, address: int) -> int:
        """A byte of RAM, or a register."""
        return int(self._library.board_peek(self._board, address))

    def flash(self, address: int, count: int) -> bytes:
        """What is in the flash."""
        return bytes(self._library.board_flash(self._board)[address : address + count])

    def burn(self, address: int, data: bytes) -> None:
        """Put bytes into the flash from outside, as a programmer does."""
        flash = self._library.board_flash(self._board)
        for at, byte in enumerate(data, address):
            flash[at] = byte

    @property
    def untouched_bytes(self) -> int:
        """How much RAM neither variables nor the stack have ever used."""
        return int(self._library.board_untouched(self._board))

    def _new(self, function: Any, seen: int) -> Sequence[tuple[int, int]]:
        items = self._items
        found: list[tuple[int, int]] = []
        while True:
            count = function(self._board, seen + len(found), items, ROOM)
            found += [(item.cycle, item.what) for item in items[:count]]
            if count < ROOM:
                return found
