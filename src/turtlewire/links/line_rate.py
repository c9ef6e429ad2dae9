"""Which rate a terminal is set to: a serial port, or either end of a pseudo-terminal."""

from __future__ import annotations

import struct

# Linux: `struct termios2` of asm-generic/termbits.h, which most machines have, has the rates as numbers.
_TCGETS2 = 0x802C542A
_TERMIOS2 = struct.Struct("4I B 19s 2I")


def baud_of(descriptor: int) -> int | None:
    """The rate in bits per second; None where that cannot be told (no terminal; Windows).

    Of a pseudo-terminal, both ends tell what was set at the end that a program has opened as its port.
    """
    try:
        import fcntl
        import termios
    except ImportError:  # Windows
        return None
    try:
        *_, rate = _TERMIOS2.unpack(fcntl.ioctl(descriptor, _TCGETS2, bytes(_TERMIOS2.size)))
        return int(rate) or None
    except OSError:
        pass
    try:
        constant = termios.tcgetattr(descriptor)[5]
    except (OSError, termios.error):
        return None
    names = (name for name in dir(termios) if name.startswith("B") and name[1:].isdigit())
    return next((int(name[1:]) for name in names if getattr(termios, name) == constant), None) or None
