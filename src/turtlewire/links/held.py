"""A serial port kept from other programs, without using it: while another program works at it on our behalf."""

from __future__ import annotations

import os
from contextlib import contextmanager
from typing import TYPE_CHECKING

from turtlewire.links.port import Port
from turtlewire.links.stream import explained

if TYPE_CHECKING:
    from collections.abc import Iterator


@contextmanager
def held(path: str) -> Iterator[int | None]:
    """Have a serial port held: every program that locks ports, as turtlewire does, finds it busy.

    Gives the file number, for seeing whether the device is still there; None on Windows, where the port cannot be held,
    as nobody else could use it then. Opening it resets most Arduinos.

    Raises ``PortNotFoundError``, ``PortBusyError`` or ``LinkError``.
    """
    try:
        import fcntl
    except ImportError:  # Windows
        yield None
        return
    try:
        fileno = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError as error:
        raise explained(path, Port("serial", path=path), error) from error
    try:
        try:
            os.ttyname(fileno)  # raises ENOTTY for what is none
            fcntl.flock(fileno, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise explained(path, Port("serial", path=path), error) from error
        yield fileno
    finally:
        os.close(fileno)
