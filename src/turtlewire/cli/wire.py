"""What the commands that look at a wire share: which protocol, what to read, and how far it is."""

from __future__ import annotations

import os
import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING

from turtlewire.cli import output
from turtlewire.errors import DataError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterable, Iterator, Sequence
    from typing import Self

    from rich.progress import Progress

    from turtlewire.capture import Header, Record
    from turtlewire.protocols.catalogue import Codec, Sender

PIECE_BYTES = 1 << 16
PROTOCOLS = ("simple", "frame", "walter")


def add_settings(parser: argparse.ArgumentParser) -> None:
    """The settings of the protocols."""
    group = parser.add_argument_group("settings of one protocol")
    group.add_argument("--mode", choices=["logo", "direct"], help="walter: what the stream begins in (logo)")
    group.add_argument("--dialect", metavar="NAME", help="frame: 0.1, 0.1-literal, telemetry or a file (0.1)")
    group.add_argument("--crc", metavar="NAME", help="frame: algorithm, as CRC-8/SMBUS (the dialect's)")
    group.add_argument(
        "--coverage", metavar="FROM", help="frame: magic, seq, size or payload (the dialect's)"
    )


def intermix(parser: argparse.ArgumentParser) -> None:
    """Let options stand anywhere: argparse takes an argument that may be missing for missing at the first option."""

    def parse(
        arguments: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        # The intermixed way takes the plain one twice.
        del vars(parser)["parse_known_args"]
        try:
            return parser.parse_known_intermixed_args(arguments, namespace)
        finally:
            vars(parser)["parse_known_args"] = parse

    vars(parser)["parse_known_args"] = parse


def codec(arguments: argparse.Namespace) -> Codec:
    """The protocol that was asked for. Raises ``UsageError`` or, for a dialect, ``DataError``."""
    from turtlewire.protocols import catalogue

    settings = {name: getattr(arguments, name) for name in catalogue.Settings._fields}
    return catalogue.codec(arguments.protocol, catalogue.Settings(**settings))


@contextmanager
def reading(name: str) -> Iterator[tuple[int, int | None]]:
    """Open a file, or for ``-`` the standard input: its descriptor, and its size if that is known.

    Raises ``DataError`` if it cannot be opened.
    """
    import stat

    if name == "-":
        yield 0, None
        return
    try:
        descriptor = os.open(name, os.O_RDONLY | getattr(os, "O_BINARY", 0))
    except OSError as error:
        raise DataError(f"cannot read {name}: {error.strerror or error}") from None
    try:
        status = os.fstat(descriptor)
        if stat.S_ISDIR(status.st_mode):
            raise DataError(f"cannot read {name}: it is a folder")
        yield descriptor, status.st_size if stat.S_ISREG(status.st_mode) else None
    finally:
        os.close(descriptor)


def pieces(descriptor: int, name: str) -> Iterator[bytes]:
    """What a descriptor gives, as it comes: nothing is waited for once there is something. Raises ``DataError``."""
    while True:
        try:
            piece = os.read(descriptor, PIECE_BYTES)
        except OSError as error:
            raise DataError(f"cannot read {name}: {error.strerror or error}") from None
        if not piece:
            return
        yield piece


def from_hexadecimal(pieces: Iterable[bytes], name: str) -> Iterator[bytes]:
    """The bytes that hexadecimal text means; blanks and line feeds may stand anywhere. Raises ``DataError``."""
    digit = b""
    for piece in pieces:
        text = digit + b"".join(piece.split())
        even = len(text) - len(text) % 2
        digit = text[even:]
        try:
            yield bytes.fromhex(text[:even].decode("latin-1"))
        except ValueError:
            raise DataError(f"{name} is not hexadecimal: write bytes as 46 00 C8 0D") from None
    if digit:
        raise DataError(f"{name} ends with half a byte, {digit.decode('latin-1')!r}")


class Stream:
    """What a wire carried, from a recording or from nothing but bytes; iterated once.

    Args:
        pieces: the file, as it comes.
        name: what errors call it.
        sender: who sent the bytes, where no recording says so.

    Attributes:
        header: of the recording, once the first record has come out; None of bytes.
        torn: what is torn of the recording, in words, when all has come out.
    """

    def __init__(self, pieces: Iterable[bytes], name: str, sender: Sender) -> None:
        self._pieces = pieces
        self._name = name
        self._sender = sender
        self.header: Header | None = None
        self.torn = ""

    def __iter__(self) -> Iterator[Record]:
        from turtlewire.capture import Chunk, Parser, is_capture

        parser: Parser | None = None
        beginning: bytes | None = b""
        for piece in self._pieces:
            data = piece
            if beginning is not None:
                beginning += piece
                is_recording = is_capture(beginning)
                if is_recording is None:
                    continue
                data, beginning = beginning, None
                parser = Parser(self._name) if is_recording else None
            if parser is None:
                yield Chunk(0, self._sender, data)
                continue
            records = parser.receive_data(data)
            self.header = parser.header
            yield from records
        if beginning:
            yield Chunk(0, self._sender, beginning)
        if parser is not None:
            records, self.torn = parser.close()
            self.header = parser.header
            yield from records


class Bar:
    """How far a file has been read, for somebody at a terminal; elsewhere it shows nothing, and ``write`` only writes.

    Args:
        size: of the file, if it is known.
    """

    def __init__(self, size: int | None) -> None:
        self._bar = self._make(size) if size and sys.stderr.isatty() else None
        self._is_shared = self._bar is not None and sys.stdout.isatty()

    def __enter__(self) -> Self:
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    def follow(self, pieces: Iterable[bytes]) -> Iterator[bytes]:
        """The same pieces; the bar goes on when each of them is done with."""
        for piece in pieces:
            yield piece
            if self._bar is not None:
                self._bar.advance(self._bar.task_ids[0], len(piece))

    def write(self, text: str) -> None:
        """Write to standard output, above the bar. Raises ``OutputError``."""
        if self._bar is not None and self._is_shared:
            self._bar.console.out(text, end="", highlight=False)
        else:
            output.write(text)

    @staticmethod
    def _make(size: int) -> Progress:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            DownloadColumn,
            Progress,
            TimeRemainingColumn,
            TransferSpeedColumn,
        )

        columns = (BarColumn(bar_width=24), DownloadColumn(), TransferSpeedColumn(), TimeRemainingColumn())
        console = Console(stderr=True, soft_wrap=True)
        progress = Progress(
            *columns, console=console, transient=True, redirect_stdout=False, redirect_stderr=False
        )
        progress.add_task("", total=size)
        return progress
