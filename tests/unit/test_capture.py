from __future__ import annotations

import errno
import json
import os
import struct
import tracemalloc
from typing import TYPE_CHECKING

import pytest

from turtlewire.capture import (
    MAGIC,
    MAX_LINE_BYTES,
    MAX_RAW_BYTES,
    Chunk,
    Header,
    Note,
    Parser,
    Record,
    Writer,
    encode_header,
    encode_record,
    is_capture,
)
from turtlewire.errors import DataError, OutputError

if TYPE_CHECKING:
    from pathlib import Path

STARTED_NS = 1_795_348_288_564_844_828
HEADER = Header.of(STARTED_NS, protocol="walter", baud=9600, host="pty", robot="/dev/ttyUSB0")
RECORDS: list[Record] = [
    Chunk(0, "host", b"F\0\xc8\r"),
    Note(1_000, 'the host has "left"'),
    Chunk(2_000_000_000, "robot", bytes(range(256))),
]
FILE = encode_header(HEADER) + b"".join(map(encode_record, RECORDS))


def parsed(data: bytes, size: int = 1 << 20) -> tuple[Parser, list[Record], str]:
    parser = Parser("wire.jsonl")
    records = [
        r for start in range(0, len(data), size) for r in parser.receive_data(data[start : start + size])
    ]
    rest, torn = parser.close()
    return parser, records + rest, torn


def test_a_recording_is_lines_of_json_that_anything_can_read() -> None:
    header, *records = [json.loads(line) for line in FILE.splitlines()]
    assert header == {
        "format": "turtlewire-capture",
        "version": 1,
        "started": "2026-11-22T11:51:28.564844Z",
        "started_unix_ns": STARTED_NS,
        "protocol": "walter",
        "baud": 9600,
        "host": "pty",
        "robot": "/dev/ttyUSB0",
    }
    assert records[:2] == [
        {"t_ns": 0, "from": "host", "raw": "46 00 C8 0D"},
        {"t_ns": 1000, "note": 'the host has "left"'},
    ]


@pytest.mark.parametrize("size", [1, 2, 7, 1000])
def test_what_is_written_is_read_in_pieces_of_any_size(size: int) -> None:
    parser, records, torn = parsed(FILE, size)
    assert (parser.header, records, torn) == (HEADER, RECORDS, "")


def test_a_recording_that_ends_anywhere_is_read_up_to_there() -> None:
    for end in range(len(FILE)):
        parser, records, torn = parsed(FILE[:end])
        assert records == RECORDS[: len(records)]
        whole = FILE[:end].count(b"\n")
        # A line that lacks nothing but its line feed counts.
        is_torn = FILE[:end].rpartition(b"\n")[2] not in (b"", *FILE.splitlines())
        assert len(records) + (parser.header is not None) == whole + (
            not is_torn and not FILE[:end].endswith(b"\n") and end > 0
        )
        assert bool(torn) == is_torn
        if torn:
            assert f"wire.jsonl: line {whole + 1}, the last one, is torn" in torn


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (b"nonsense", "line 2 is no record"),
        (b"\xff", "line 2 is no record"),
        (b"{}", "line 2 is no record.*t_ns"),
        (b'{"t_ns":-1,"from":"host","raw":"46"}', "line 2 is no record"),
        (b'{"t_ns":"1","from":"host","raw":"46"}', "line 2 is no record"),
        (b'{"t_ns":1,"from":"dog","raw":"46"}', "line 2 is no record"),
        (b'{"t_ns":1,"raw":"46"}', "line 2 does not say who"),
        (b'{"t_ns":1,"from":"host","raw":"4"}', "line 2 has a raw that is not hexadecimal"),
        (b'{"t_ns":1,"from":"host","raw":"zz"}', "line 2 has a raw that is not hexadecimal"),
    ],
)
def test_a_damaged_line_in_the_middle_is_named(line: bytes, words: str) -> None:
    with pytest.raises(DataError, match=f"^wire.jsonl is a damaged recording: {words}"):
        parsed(encode_header(HEADER) + line + b"\n" + encode_record(RECORDS[0]))


@pytest.mark.parametrize(
    ("header", "words"),
    [
        (b"[]", "line 1 is no header"),
        (b"\xff{", "line 1 is no header"),
        (b'{"format":"something"}', "line 1 has the format 'something' instead of 'turtlewire-capture'"),
        (b'{"format":"turtlewire-capture","version":2}', "line 1 has version 2, and this turtlewire reads 1"),
    ],
)
def test_a_header_that_is_none(header: bytes, words: str) -> None:
    with pytest.raises(DataError, match=words):
        parsed(header + b"\n")


def test_what_a_later_version_may_add_is_passed_over() -> None:
    more = b'{"t_ns":3,"from":"robot","temperature":20}\n{"t_ns":4,"from":"robot","raw":"4B","rssi":-3}\n'
    _, records, torn = parsed(encode_header(HEADER) + more)
    assert (records, torn) == ([Chunk(4, "robot", b"K")], "")


def _feed(parser: Parser, pieces: list[bytes]) -> None:
    for piece in pieces:
        parser.receive_data(piece)


def test_a_line_without_end_is_not_kept() -> None:
    parser = Parser("wire.jsonl")
    parser.receive_data(encode_header(HEADER))
    with pytest.raises(DataError, match=f"line 2 is longer than {MAX_LINE_BYTES} bytes"):
        _feed(parser, [b" " * 1000] * (MAX_LINE_BYTES // 1000 + 2))


def test_many_bytes_become_several_records() -> None:
    data = bytes(MAX_RAW_BYTES + 1)
    _, records, _ = parsed(encode_header(HEADER) + encode_record(Chunk(7, "host", data)))
    assert records == [Chunk(7, "host", data[:-1]), Chunk(7, "host", data[-1:])]


def test_a_recording_is_told_from_other_bytes_as_soon_as_possible() -> None:
    for size in range(len(MAGIC)):
        assert is_capture(MAGIC[:size]) is None
        assert is_capture(MAGIC[:size] + b"?") is False
    assert is_capture(FILE) is True


def test_every_record_is_in_the_file_at_once(tmp_path: Path) -> None:
    path = tmp_path / "wire.jsonl"
    with Writer(path, HEADER) as writer:
        for count, record in enumerate(RECORDS, 1):
            writer.write(record)
            assert parsed(path.read_bytes())[1] == RECORDS[:count]
    assert path.read_bytes() == FILE
    writer.close()


def test_a_recording_overwrites_nothing(tmp_path: Path) -> None:
    path = tmp_path / "wire.jsonl"
    path.write_text("precious")
    with pytest.raises(OutputError, match=r"is there already, and a recording overwrites nothing"):
        Writer(path, HEADER)
    assert path.read_text() == "precious"
    with pytest.raises(OutputError, match=r"cannot record to .*No such file"):
        Writer(tmp_path / "nowhere" / "wire.jsonl", HEADER)


def test_a_full_disk_is_said_and_leaves_what_was_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "wire.jsonl"
    write = os.write

    def half(descriptor: int, data: bytes) -> int:
        """Some of it goes in, then the disk is full."""
        if len(data) < 20:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(descriptor, data[: len(data) // 2])

    with Writer(path, HEADER) as writer:
        writer.write(RECORDS[0])
        monkeypatch.setattr(os, "write", half)
        with pytest.raises(OutputError, match="No space left"):
            writer.write(RECORDS[2])
    monkeypatch.undo()
    _, records, torn = parsed(path.read_bytes())
    assert records == RECORDS[:1]
    assert torn
    monkeypatch.setattr(os, "write", half)
    with pytest.raises(OutputError, match="No space left"):
        Writer(tmp_path / "new.jsonl", Header(format="x"))


def test_reading_takes_constant_memory() -> None:
    parser = Parser("wire.jsonl")
    parser.receive_data(encode_header(HEADER))
    piece = b"".join(encode_record(Chunk(n, "host", bytes(50))) for n in range(400))
    parser.receive_data(piece)
    tracemalloc.start()
    try:
        for _ in range(100):
            parser.receive_data(piece)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 6 * len(piece)


def test_it_is_a_small_step_to_pcap() -> None:
    """Each record has all that a packet needs: the time since 1970, the direction and the bytes."""
    packets = struct.pack("<IHHiIII", 0xA1B23C4D, 2, 4, 0, 0, 65535, 147)
    parser, records, _ = parsed(FILE)
    assert parser.header is not None
    for record in records:
        if isinstance(record, Chunk):
            seconds, ns = divmod(parser.header.started_unix_ns + record.t_ns, 1_000_000_000)
            raw = bytes([record.sender == "robot"]) + record.raw
            packets += struct.pack("<IIII", seconds, ns, len(raw), len(raw)) + raw
    assert packets[24:45].hex() == "40d7026b1cd9aa210500000005000000004600c80d"
