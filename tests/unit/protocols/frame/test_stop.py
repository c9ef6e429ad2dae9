"""A stop that is heard (F13), from every state that a robot's receiver can be in.

A receiver that was left in the middle of a frame has its header and some of its payload. What it still lacks it
takes from the stop. All such states are run here, with payloads that would drive, that are full of magics, and of
false beginnings; and once more with the sequence number that makes the CRC of what is spliced together right: then
the foreign frame is consumed whole, as any receiver must, and the stop has to work with what is left.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING

import pytest

from turtlewire.protocols.checksums import algorithm
from turtlewire.protocols.frame.codec import Frame, FrameDecoder, FrameEncoder
from turtlewire.protocols.frame.dialect import TO_ROBOT, shipped
from turtlewire.protocols.frame.host import stop_bytes
from turtlewire.protocols.frame.messages import EngineDirectionUnknown, EngineForward

if TYPE_CHECKING:
    from turtlewire.protocols.frame.message import FrameMessage

CRC = algorithm("CRC-8/SMBUS").crc
ENGINES = 3


def ends_stopped(decoder: FrameDecoder, pending: bytes, stop: bytes) -> bool:
    """Whether all engines end at 0, when a receiver has had the pending bytes and then the stop.

    No time passes: nothing is given up. Whatever drives an engine must come from the frame that was begun before.
    """
    begun, *after = [item for item in decoder.receive_data(pending + stop) if isinstance(item, Frame)]
    for frame in after:
        assert STILL[decoder.dialect.name] == frame.messages
    assert not decoder.end()
    return len(after) >= 2 or begun.messages == STILL[decoder.dialect.name]


STILL: dict[str, tuple[FrameMessage, ...]] = {
    "0.1": tuple(EngineForward(engine, 0) for engine in range(ENGINES)),
    "0.1-literal": tuple(EngineDirectionUnknown(engine, 0) for engine in range(ENGINES)),
}
PAYLOADS = {
    "full speed": b"\x01\x00\xff\x02\x01\xff\x00\x00\x5a" * 14,
    "magics": b"\xa3" * 124,
    "false beginnings": b"\xa3\x00\x7c" * 42,
    "driving magics": b"\x01\x00\xa3\x02\xa3\x00" * 21,
}


@cache
def seq_for(behind: int) -> bytes:
    """CRC -> the sequence number that adds it to a frame with so many bytes behind that number."""
    inverse = bytearray(256)
    for seq in range(256):
        inverse[CRC(bytes([seq]) + bytes(behind))] = seq
    return bytes(inverse)


# Every size for the payload that has most to drive with; the others take turns, and have all sizes at night.
CASES = [
    ("0.1", "driving magics", range(125)),
    ("0.1", "full speed", range(0, 125, 4)),
    ("0.1", "magics", range(1, 125, 4)),
    ("0.1", "false beginnings", range(2, 125, 4)),
    ("0.1-literal", "driving magics", range(3, 125, 4)),
]
AT_NIGHT = [
    pytest.param(name, payload, range(125), marks=pytest.mark.nightly)
    for name in STILL
    for payload in PAYLOADS
]


@pytest.mark.parametrize(("name", "payload", "sizes"), [*CASES, *AT_NIGHT])
def test_from_every_state_of_a_receiver_all_engines_end_at_zero(
    name: str, payload: str, sizes: range
) -> None:
    dialect = shipped(name).configured(counts={"engines": ENGINES})
    stop = stop_bytes(FrameEncoder(dialect, TO_ROBOT))
    decoder = FrameDecoder(dialect)
    spliced = 0
    for size in sizes:
        frame = bytes([0xA3, 0x00, size]) + PAYLOADS[payload][:size]
        for pending in range(size + 4):
            assert ends_stopped(decoder, frame[:pending], stop), (size, pending)
            if pending < 2:
                continue
            # The same, with the CRC of what comes together right.
            whole = frame[:pending] + stop[: size + 4 - pending]
            seq = seq_for(size + 2)[CRC(whole)]
            begun = bytes([0xA3, seq]) + frame[2:pending]
            assert CRC(begun + whole[pending:]) == 0
            spliced += 1
            assert ends_stopped(decoder, begun, stop), (size, pending)
    assert spliced == sum(size + 2 for size in sizes)


@pytest.mark.parametrize(
    ("engines", "coverage"),
    [(1, "magic"), (1, "payload"), (2, "seq"), (2, "size"), (41, "magic"), (60, "payload"), (164, "magic")],
)
def test_from_anywhere_within_itself_a_stop_is_heard(engines: int, coverage: str) -> None:
    """Where a foreign frame ended, up to 127 bytes of the stop are gone; whatever number the host had come to."""
    dialect = shipped("0.1").configured(counts={"engines": engines}, coverage=coverage)
    for seq in range(0, 256, 3 if engines == 1 else 37):
        stop = stop_bytes(FrameEncoder(dialect, TO_ROBOT, seq))
        for gone in range(0, 128, 1 if 50 < seq < 64 and engines == 1 else 13):
            frames = [
                item for item in FrameDecoder(dialect).receive_data(stop[gone:]) if isinstance(item, Frame)
            ]
            stopped = {message.values() for frame in frames for message in frame.messages}
            assert stopped == {(engine, 0) for engine in range(engines)}, (seq, gone)


def test_a_stop_is_128_bytes_and_two_frames_more() -> None:
    for engines, size, frames in ((1, 7, 21), (2, 10, 15), (3, 13, 12), (41, 127, 4)):
        dialect = shipped("0.1").configured(counts={"engines": engines})
        encoder = FrameEncoder(dialect, TO_ROBOT)
        assert len(stop_bytes(encoder)) == size * frames
        assert encoder.seq == frames
        assert 128 <= size * (frames - 2) < 128 + size


def test_stops_that_fill_several_frames_are_all_repeated() -> None:
    dialect = shipped("0.1").configured(counts={"engines": 42})
    stop = stop_bytes(FrameEncoder(dialect, TO_ROBOT))
    assert len(stop) == (127 + 7) * 3


def test_no_stop_begins_a_long_frame_within_itself() -> None:
    dialect = shipped("0.1").configured(counts={"engines": 1})
    gaps = 0
    for seq in range(256):
        stop = stop_bytes(FrameEncoder(dialect, TO_ROBOT, seq))
        frames = [stop[n : n + 7] for n in range(0, len(stop), 7)]
        assert all(frame[1] != 0xA3 for frame in frames)
        for one, other in pairwise(frames):
            gaps += other[1] != (one[1] + 1) % 256
            assert one[-1] != 0xA3 or other[1] > 124
    assert gaps


def test_a_dialect_without_stops_sends_empty_frames() -> None:
    dialect = shipped("0.1").configured(counts={"engines": 0})
    stop = stop_bytes(FrameEncoder(dialect, TO_ROBOT))
    assert len(stop) == 4 * 34
    assert {
        item.messages for item in FrameDecoder(dialect).receive_data(stop) if isinstance(item, Frame)
    } == {()}
