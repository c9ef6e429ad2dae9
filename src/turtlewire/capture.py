"""Recordings of a wire: both directions, with times, as lines of JSON that anything can read.

The first line is the header, every other one a record (docs/wire-tools.md has the format for people)::

    {"format":"turtlewire-capture","version":1,"started":"2026-11-22T11:30:02.000000Z",...}
    {"t_ns":1500000,"from":"host","raw":"46 00 C8 0D"}
    {"t_ns":9000000,"note":"the host's end was unplugged"}

A file only ever grows by whole lines, so that whatever ends a recording leaves everything before it readable: the
last line may be torn, and is then reported. Reading and writing take constant memory.
"""

from __future__ import annotations

import os
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

import msgspec
from msgspec import Meta

from turtlewire.errors import DataError, OutputError

if TYPE_CHECKING:
    from pathlib import Path
    from typing import Self

    from turtlewire.protocols.catalogue import Sender

FORMAT = "turtlewire-capture"
VERSION = 1
# What every recording begins with, to the byte: this is how it is told from the bytes of a wire.
MAGIC = b'{"format":"' + FORMAT.encode() + b'"'
# Longer lines are none of a recording's.
MAX_LINE_BYTES = 1 << 20
# More bytes than this are written as several records of the same time.
MAX_RAW_BYTES = 1 << 12

Natural = Annotated[int, Meta(ge=0)]


class Chunk(NamedTuple):
    """Bytes that came at once: when (from the start of the recording), who sent them, and what."""

    t_ns: int
    sender: Sender
    raw: bytes


class Note(NamedTuple):
    """Something that happened on the way, in words."""

    t_ns: int
    text: str


Record = Chunk | Note


class Header(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What a recording is of.

    Attributes:
        started_unix_ns: when it began, in nanoseconds since 1970 UTC. Every record's time counts from here.
        started: the same for people, to the microsecond.
        protocol: what was spoken, as far as the one who recorded knew.
        baud: of the line.
        host, robot: the ports that the two were at.
    """

    format: str = ""
    version: int = 0
    started: str = ""
    started_unix_ns: int = 0
    protocol: str = ""
    baud: int = 0
    host: str = ""
    robot: str = ""

    @classmethod
    def of(cls, started_unix_ns: int, *, protocol: str, baud: int, host: str, robot: str) -> Header:
        """The header of a recording that begins now."""
        moment = datetime.fromtimestamp(started_unix_ns // 1_000_000_000, UTC)
        micros = started_unix_ns % 1_000_000_000 // 1000
        return cls(
            format=FORMAT,
            version=VERSION,
            started=f"{moment:%Y-%m-%dT%H:%M:%S}.{micros:06}Z",
            started_unix_ns=started_unix_ns,
            protocol=protocol,
            baud=baud,
            host=host,
            robot=robot,
        )


class _Line(msgspec.Struct, frozen=True):
    """A record as it stands in the file. Fields that this version does not know are passed over."""

    t_ns: Natural
    sender: Literal["host", "robot", ""] = msgspec.field(default="", name="from")
    raw: str | None = None
    note: str | None = None


_decode_header = msgspec.json.Decoder(Header).decode
_decode_line = msgspec.json.Decoder(_Line).decode


def is_capture(beginning: bytes) -> bool | None:
    """Whether bytes are the beginning of a recording; None if there are too few to tell."""
    if len(beginning) >= len(MAGIC):
        return beginning.startswith(MAGIC)
    return None if MAGIC.startswith(beginning) else False


def encode_header(header: Header) -> bytes:
    """The first line."""
    return msgspec.json.encode(header) + b"\n"


def encode_record(record: Record) -> bytes:
    """The line, or for many bytes the lines, of a record."""
    if isinstance(record, Note):
        return msgspec.json.encode({"t_ns": record.t_ns, "note": record.text}) + b"\n"
    lines = bytearray()
    for start in range(0, len(record.raw), MAX_RAW_BYTES):
        raw = record.raw[start : start + MAX_RAW_BYTES].hex(" ").upper()
        lines += b'{"t_ns":%d,"from":"%s","raw":"%s"}\n' % (
            record.t_ns,
            record.sender.encode(),
            raw.encode(),
        )
    return bytes(lines)


class Parser:
    """Reads a recording, in pieces of any size.

    Args:
        name: what errors call the recording.

    Attributes:
        header: None until the first line is complete.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._rest = b""
        self._line = 0
        self.header: Header | None = None

    def receive_data(self, data: bytes) -> list[Record]:
        """Take a piece of the file; return the records that it completes.

        Raises ``DataError`` naming the line for what is no recording, or one of a later version.
        """
        *lines, self._rest = (self._rest + data).split(b"\n")
        if len(self._rest) > MAX_LINE_BYTES:
            raise self._wrong(self._line + 1, f"is longer than {MAX_LINE_BYTES} bytes")
        records = []
        for line in lines:
            self._line += 1
            record = self._take(line)
            if record is not None:
                records.append(record)
        return records

    def close(self) -> tuple[list[Record], str]:
        """The file ends here: what its last line still gives, and in words what is torn, or ``""``."""
        if not self._rest:
            return [], ""
        try:
            # Only the line feed may be missing.
            record = self._take(self._rest)
        except DataError:
            return [], (
                f"{self._name}: line {self._line + 1}, the last one, is torn: the recording was cut off there, "
                f"and {len(self._rest)} bytes of the file mean nothing"
            )
        return [] if record is None else [record], ""

    def _take(self, line: bytes) -> Record | None:
        if self.header is None:
            self.header = self._header(line)
            return None
        try:
            entry = _decode_line(line)
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            raise self._wrong(self._line, f"is no record: {error}") from None
        if entry.note is not None:
            return Note(entry.t_ns, entry.note)
        if entry.raw is None:
            return None  # a kind of record that a later version may have
        if entry.sender == "":
            raise self._wrong(self._line, "does not say who sent its bytes: from must be host or robot")
        try:
            return Chunk(entry.t_ns, entry.sender, bytes.fromhex(entry.raw))
        except ValueError:
            raise self._wrong(self._line, "has a raw that is not hexadecimal") from None

    def _header(self, line: bytes) -> Header:
        try:
            header = _decode_header(line)
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            raise self._wrong(1, f"is no header: {error}") from None
        if header.format != FORMAT:
            raise self._wrong(1, f"has the format {header.format!r} instead of {FORMAT!r}")
        if header.version != VERSION:
            raise self._wrong(
                1, f"has version {header.version}, and this turtlewire reads {VERSION}: use a newer one"
            )
        return header

    def _wrong(self, line: int, what: str) -> DataError:
        return DataError(f"{self._name} is a damaged recording: line {line} {what}")


class Writer:
    """Writes a recording to a new file, record by record; each is in the file when ``write`` returns.

    Raises ``OutputError`` if the file cannot be made, or is there already: recordings cannot be made again.
    """

    def __init__(self, path: Path, header: Header) -> None:
        self._path = path
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND | getattr(os, "O_BINARY", 0)
        try:
            self._fd = os.open(path, flags, 0o666)
        except FileExistsError:
            raise OutputError(
                f"{path} is there already, and a recording overwrites nothing: choose another name"
            ) from None
        except OSError as error:
            raise OutputError(f"cannot record to {path}: {error.strerror or error}") from None
        try:
            self._put(encode_header(header))
        except OutputError:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def write(self, record: Record) -> None:
        """Add a record. Raises ``OutputError``."""
        self._put(encode_record(record))

    def _put(self, data: bytes) -> None:
        try:
            while data:
                data = data[os.write(self._fd, data) :]
        except OSError as error:
            raise OutputError(f"cannot record to {self._path}: {error.strerror or error}") from None

    def close(self) -> None:
        """Let go of the file."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1
