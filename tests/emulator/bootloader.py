"""An emulated board with a real bootloader, behind a port: what opens the port resets it, as DTR does with a real one.

The port knows its rate: at another one than the chip's own, each side hears what a UART hears then. Between a host's
bytes the chip's time passes at a pace of one's own, so that a bootloader's patience of a second outlasts a busy
machine.
"""

from __future__ import annotations

import contextlib
import errno
import os
import pty
import select
import subprocess
import termios
import threading
import tty
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from turtlewire.links.uart import image

from .board import CHIP, FREQUENCY_HZ, Board, ChipError

if TYPE_CHECKING:
    from collections.abc import Callable

BOOTLOADERS = Path("/usr/share/arduino/hardware/arduino/avr/bootloaders")
SLICE_S = 0.001
# Of the wall's clock, while the host says nothing.
PATIENT = 0.2
# Rates that differ by no more understand each other.
RATE_TOLERANCE = 0.03
RATES = {getattr(termios, f"B{rate}"): rate for rate in (9600, 19200, 38400, 57600, 115200)}


class Piece(NamedTuple):
    """Bytes that belong together, and their place in the flash."""

    address: int
    data: bytes


def intel_hex(path: Path) -> list[Piece]:
    """What a .hex file says, joined where it can be; every checksum is looked at."""
    pieces: list[Piece] = []
    for line in path.read_text("ascii").split():
        record = bytes.fromhex(line.removeprefix(":"))
        assert sum(record) % 256 == 0, line
        count, address, kind = record[0], int.from_bytes(record[1:3], "big"), record[3]
        assert len(record) == count + 5, line
        if kind == 0:
            if pieces and pieces[-1].address + len(pieces[-1].data) == address:
                address, before = pieces.pop()
                pieces.append(Piece(address, before + record[4:-1]))
            else:
                pieces.append(Piece(address, record[4:-1]))
    return pieces


class Bootloader(NamedTuple):
    """A bootloader: its file, and where a reset leads to."""

    hex: Path
    start: int


def optiboot(folder: Path, signature: str = "1E950F") -> Bootloader:
    """The Uno's bootloader, built from the source in Arduino's core, with the options of its Makefile but for one.

    Debian ships it built too, but its compiler made 532 bytes of what has room for 512: the end lies beyond the flash.
    Without the flashes of the LED at the start it fits. ``signature``: as what chip it shows itself.
    """
    header = folder / "signature.h"
    lines = [
        f"#undef SIGNATURE_{n}\n#define SIGNATURE_{n} 0x{signature[2 * n : 2 * n + 2]}" for n in range(3)
    ]
    header.write_text("\n".join(["#include <avr/io.h>", *lines, ""]), "ascii")
    elf, made = folder / "optiboot.elf", folder / "optiboot.hex"
    flags = [
        "-Os",
        "-fno-inline-small-functions",
        "-fno-split-wide-types",
        "-mshort-calls",
        f"-mmcu={CHIP}",
        "-w",
    ]
    flags += [f"-DF_CPU={FREQUENCY_HZ}L", "-DLED_START_FLASHES=0", "-DBAUD_RATE=115200"]
    flags += ["-Wl,--section-start=.text=0x7e00,--section-start=.version=0x7ffe,--relax,--gc-sections"]
    source = BOOTLOADERS / "optiboot" / "optiboot.c"
    for command in (
        [
            "avr-gcc",
            *flags,
            "-include",
            str(header),
            "-nostartfiles",
            "-nostdlib",
            str(source),
            "-o",
            str(elf),
        ],
        ["avr-objcopy", "-j", ".text", "-j", ".version", "-O", "ihex", str(elf), str(made)],
    ):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    assert all(piece.address + len(piece.data) <= 0x8000 for piece in intel_hex(made))
    return Bootloader(made, 0x7E00)


# What Nanos came with until 2018, as Arduino's core ships it; it speaks at 57600.
ATMEGABOOT = Bootloader(BOOTLOADERS / "atmega" / "ATmegaBOOT_168_atmega328.hex", 0x7800)


class PluggedBoard:
    """A board at a port. A context manager; between ``plug`` and ``unplug`` it lives in a thread of its own.

    Args:
        bootloader: the only thing in its flash at first.
        port: what its port is called.

    Attributes:
        pace: of the chip's time while the host says nothing, in units of the wall's.
        unplug_when: looked at all the time; once it is true, power and port are gone.
        opened: how often a host has opened the port.
    """

    def __init__(self, bootloader: Bootloader, port: Path) -> None:
        self.port = port
        self.pace = PATIENT
        self.unplug_when: Callable[[], bool] = lambda: False
        self.opened = 0
        self.board = Board(None, 115200)
        self.error: ChipError | None = None
        self.bootloader = bootloader
        for piece in intel_hex(bootloader.hex):
            self.board.burn(*piece)
        self._near = -1
        self._thread: threading.Thread | None = None
        self._woken, self._wake = os.pipe()

    def __enter__(self) -> PluggedBoard:
        self.plug()
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()
        os.close(self._woken)
        os.close(self._wake)
        self.board.__exit__()

    def plug(self) -> None:
        """Power and a port."""
        self.board.power_on(self.bootloader.start)
        self._near, far = pty.openpty()
        tty.setraw(far)
        self.port.unlink(missing_ok=True)
        self.port.symlink_to(os.ttyname(far))
        os.close(far)
        self._thread = threading.Thread(target=self._live, daemon=True)
        self._thread.start()

    def unplug(self) -> None:
        """Neither of them; returns when it is so."""
        if self._thread is not None:
            os.write(self._wake, b"x")
            self.wait_until_unplugged()
            os.read(self._woken, 1)
        if self.error is not None:
            raise self.error

    def wait_until_unplugged(self) -> None:
        """Wait for what ``unplug_when`` waits for."""
        assert self._thread is not None
        self._thread.join()
        self._thread = None

    def _live(self) -> None:
        poll = select.poll()
        poll.register(self._near, select.POLLIN)
        poll.register(self._woken, select.POLLIN)
        is_open, line_free_s = False, 0.0
        try:
            while not self.unplug_when():
                is_idle = self.board.now_s >= line_free_s
                events = dict(poll.poll(SLICE_S / self.pace * 1000.0 if is_idle else 0))
                if self._woken in events:
                    break
                state = events.get(self._near, 0)
                was_open, is_open = is_open, not state & select.POLLHUP
                if is_open and not was_open:
                    self.opened += 1
                    self.board.reset()
                    self.board.run(SLICE_S)
                if state & select.POLLIN:
                    line_free_s = self._take(line_free_s)
                elif state:  # closed: this poll has not waited
                    select.select([self._woken], [], [], SLICE_S / self.pace)
                self.board.run(SLICE_S)
                self._give(is_open=is_open)
        except ChipError as error:
            self.error = error
        finally:
            self.port.unlink()
            os.close(self._near)

    def _take(self, line_free_s: float) -> float:
        """The host's bytes go on the wire; when it is free again."""
        try:
            data = os.read(self._near, 4096)
        except OSError as error:
            if error.errno != errno.EIO:
                raise
            return line_free_s
        host = self._host_rate()
        heard = data if self._agree(host) else image(data, self.board.rate / host)
        self.board.baud = host
        self.board.receive(heard)
        return max(line_free_s, self.board.now_s) + len(data) * 10.0 / host

    def _give(self, *, is_open: bool) -> None:
        """What the chip has sent reaches the host, if there is one."""
        data = bytes(sent.byte for sent in self.board.sent())
        if data and is_open:
            host = self._host_rate()
            heard = data if self._agree(host) else image(data, host / self.board.rate)
            with contextlib.suppress(OSError):  # closed meanwhile
                os.write(self._near, heard)

    def _host_rate(self) -> int:
        return RATES.get(termios.tcgetattr(self._near)[5], 115200)

    def _agree(self, host: int) -> bool:
        return abs(self.board.rate / host - 1.0) <= RATE_TOLERANCE
