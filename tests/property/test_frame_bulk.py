"""The bulk decoder says what the streaming decoder says, on every input."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.property.test_frame import dialects, directions, streams
from turtlewire.protocols.checksums import CATALOGUE, Coverage
from turtlewire.protocols.frame import bulk, bulk_frames
from turtlewire.protocols.frame.bulk import COUNTS, INCONSISTENT, UNKNOWN_TYPE
from turtlewire.protocols.frame.codec import Frame, FrameDecoder, frame_bytes
from turtlewire.protocols.frame.dialect import TO_ROBOT, Dialect, shipped

if TYPE_CHECKING:
    from collections.abc import Iterator

Rows = list[tuple[int, int, str, list[str]]]


def streamed(data: bytes, dialect: Dialect, direction: str) -> Rows:
    """Frames: offset, number, what becomes of it, messages (refused ones in brackets), all as text."""
    decoder = FrameDecoder(dialect, direction)
    rows: Rows = []
    for item in decoder.receive_data(data) + decoder.end():
        if isinstance(item, Frame):
            texts = [f"{m!r}" for m in item.messages] + [f"({m!r})" for m in item.refused]
            rows.append((item.offset, item.seq, str(COUNTS), sorted(texts)))
        elif "unknown type" in item.reason or "cut short" in item.reason:
            why = UNKNOWN_TYPE if "unknown type" in item.reason else INCONSISTENT
            rows.append((item.offset, item.raw[1], str(why), []))
    return rows


def in_bulk(data: bytes, dialect: Dialect, direction: str) -> Rows:
    capture = bulk.decode(data, dialect, direction)
    texts: list[list[str]] = [[] for _ in capture.offset]
    for message_type, found in capture.messages.items():
        columns: list[list[Any]] = [column.tolist() for column in found.fields.values()]
        assert list(found.fields) == [field.name for field in message_type.FIELDS]
        for n, frame in enumerate(found.frame.tolist()):
            text = repr(message_type(*(column[n] for column in columns)))
            texts[frame].append(f"({text})" if found.refused[n] else text)
            end = capture.offset[frame] + 3 + capture.size[frame]
            assert capture.offset[frame] + 3 <= found.offset[n] < end
        assert (np.diff(found.offset) > 0).all()
    columns = [capture.offset.tolist(), capture.seq.tolist(), capture.ignored.tolist()]
    return [
        (offset, seq, str(ignored), sorted(text))
        for offset, seq, ignored, text in zip(*columns, texts, strict=True)
    ]


@contextmanager
def blocks(near: int, block: int) -> Iterator[None]:
    """So that short streams are long ones."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bulk_frames, "NEAR", near)
        patch.setattr(bulk_frames, "BLOCK", block)
        yield


@settings(deadline=None, max_examples=300)
@given(st.data(), dialects, directions, st.sampled_from([16, 64, 300]), st.sampled_from([1, 2, 16]))
def test_bulk_and_streaming_agree(
    data: st.DataObject, dialect: Dialect, direction: str, near: int, times: int
) -> None:
    stream = data.draw(streams(dialect, direction))
    with blocks(near, near * times):
        assert in_bulk(stream, dialect, direction) == streamed(stream, dialect, direction)


@settings(deadline=None)
@given(st.binary(max_size=600).map(lambda data: data.replace(b"\x01", b"\xa3\x01\x02")), dialects, directions)
def test_they_agree_on_any_bytes(stream: bytes, dialect: Dialect, direction: str) -> None:
    with blocks(64, 128):
        assert in_bulk(stream, dialect, direction) == streamed(stream, dialect, direction)


@pytest.mark.parametrize("coverage", Coverage)
@pytest.mark.parametrize("crc", CATALOGUE)
def test_every_algorithm_and_coverage_over_the_ends_of_blocks(crc: str, coverage: Coverage) -> None:
    dialect = shipped("0.1").configured(crc=crc, coverage=coverage.value)
    payloads = [
        b"",
        b"\x01\x00\xa3",
        b"\x02\x01\x05" * 41,
        b"\x00\x00\xff\x01\x01\x01",
        b"\xa3\x00\x00",
        b"\x01\x07",
    ]
    stream = b"".join(frame_bytes(dialect, n, payloads[n % 6]) + b"\xa3\x01" * (n % 3) for n in range(40))
    with blocks(64, 64):
        found = in_bulk(stream, dialect, TO_ROBOT)
    assert found == streamed(stream, dialect, TO_ROBOT)
    assert len(found) >= 30
    assert {row[2] for row in found} == {"0", "1", "2"}


def test_a_capture_longer_than_a_block_with_damage() -> None:
    dialect = shipped("0.1")
    stream = bytearray()
    while len(stream) < 2 * bulk_frames.BLOCK + 1000:
        n = len(stream)
        stream += frame_bytes(dialect, n % 256, bytes((n % 3, n % 2, n % 181)) * (n % 5))
    for place in range(0, len(stream), 997):
        stream[place] ^= 0xA3
    assert in_bulk(bytes(stream), dialect, TO_ROBOT) == streamed(bytes(stream), dialect, TO_ROBOT)


def test_a_size_above_124_is_none_whatever_the_crc() -> None:
    dialect = shipped("0.1")
    for size in (124, 125, 252, 255):
        stream = b"".join(frame_bytes(dialect, n, b"\x01" * size) for n in range(20))
        for block in (64, 600, 1 << 14):
            with blocks(block, block):
                assert len(in_bulk(stream, dialect, TO_ROBOT)) == (20 if size == 124 else 0)


def test_frames_that_begin_within_frames() -> None:
    """What begins within a frame that is taken is none; what begins within one that is not, may be."""
    dialect = shipped("0.1")
    within = frame_bytes(dialect, 7, b"\x01\x00\x05") + frame_bytes(dialect, 8, b"")
    nested = frame_bytes(dialect, 1, b"\x01\x00" + within)
    outer = frame_bytes(dialect, 2, b"\x01\x00\xa3\x00\x05")
    # begins in outer's payload, ends behind it, and has a frame within that is one because outer is
    across = outer[-4:] + frame_bytes(dialect, 3, b"")
    across += bytes([dialect.checksum.algorithm.crc(across)])
    assert dialect.checksum.fits(across)
    assert (across[0], across[2], len(across)) == (0xA3, 5, 9)
    last = frame_bytes(dialect, 4, b"\x02\x01\x09")
    stream = nested + outer + across[4:] + last
    found = in_bulk(stream, dialect, TO_ROBOT)
    assert found == streamed(stream, dialect, TO_ROBOT)
    for block in range(1, len(stream)):
        with blocks(block, block):
            assert in_bulk(stream, dialect, TO_ROBOT) == found
    assert [row[1] for row in found] == [1, 2, 3, 4]
    alone = in_bulk(stream[1:], dialect, TO_ROBOT)
    assert alone == streamed(stream[1:], dialect, TO_ROBOT)
    assert [row[1] for row in alone] == [7, 8, 2, 3, 4]
