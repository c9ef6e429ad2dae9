"""Which port a text means, and what can be said when it cannot be opened."""

from __future__ import annotations

import re
from typing import NamedTuple
from urllib.parse import parse_qsl, urlsplit

from turtlewire.errors import UsageError

FORMS = "a device (/dev/ttyUSB0, COM3), serial:///dev/ttyUSB0?baud=9600, socket://host:port or pty"


class Port(NamedTuple):
    """A parsed port: ``kind`` is serial, socket or pty."""

    kind: str
    path: str = ""
    host: str = ""
    number: int = 0
    baud: int | None = None

    @classmethod
    def parse(cls, text: str) -> Port:
        """Read a port as people write it. Raises ``UsageError`` saying what is wrong and which forms there are."""
        if text in ("pty", "pty:"):
            return cls("pty")
        if "://" not in text:
            if re.fullmatch(r"COM\d+", text, re.IGNORECASE) or text.startswith(("/", "\\\\.\\")):
                return cls("serial", path=text)
            raise UsageError(f"{text!r} is no port: write {FORMS}")
        try:
            url = urlsplit(text)
            options = dict(parse_qsl(url.query, keep_blank_values=True))
        except ValueError as error:
            raise UsageError(f"{text!r} is no port ({error}): write {FORMS}") from None
        if url.scheme == "serial":
            return cls._serial(text, url.netloc + url.path, options)
        if url.scheme == "socket":
            return cls._socket(text, options)
        raise UsageError(f"{text!r}: there is no {url.scheme!r} port: write {FORMS}")

    @classmethod
    def _serial(cls, text: str, path: str, options: dict[str, str]) -> Port:
        baud = options.pop("baud", None)
        if options:
            raise UsageError(f"{text!r}: unknown option {next(iter(options))!r}; a serial port has baud")
        if not path:
            raise UsageError(f"{text!r} names no device: write serial:///dev/ttyUSB0 or serial://COM3")
        if baud is not None and not (baud.isascii() and baud.isdigit() and 50 <= int(baud) <= 4_000_000):
            raise UsageError(f"{text!r}: baud is {baud!r}, but must be a whole number from 50 to 4000000")
        return cls("serial", path=path, baud=int(baud) if baud else None)

    @classmethod
    def _socket(cls, text: str, options: dict[str, str]) -> Port:
        if options:
            raise UsageError(f"{text!r}: unknown option {next(iter(options))!r}; a socket has none")
        url = urlsplit(text)
        try:
            number = url.port
        except ValueError:
            number = None
        if not url.hostname or number is None or url.path not in ("", "/"):
            raise UsageError(f"{text!r} must be socket://host:port with a port number from 0 to 65535")
        return cls("socket", host=url.hostname, number=number)
