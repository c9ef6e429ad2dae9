"""Frames: messages to bytes and back, streaming.

There is no byte stuffing, so A3 may stand anywhere (F5). After a size above 124, a wrong CRC or a timeout the
decoder looks for the next A3 after the failed one, among the bytes that it already has: no frame is lost to a false
beginning. A frame whose CRC is right is consumed whole, even when it is ignored (F3). It takes any bytes in any
chunking, gives the same items for every chunking, and keeps less than one frame.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

import msgspec

from turtlewire.protocols.frame.dialect import FROM_ROBOT, TO_ROBOT
from turtlewire.protocols.frame.layout import keeps, layouts
from turtlewire.protocols.frame.message import HEADER, MAGIC, MAX_PAYLOAD, OVERHEAD, FrameMessage
from turtlewire.protocols.frame.runs import Lookout, Run
from turtlewire.protocols.message import Malformed

if TYPE_CHECKING:
    from collections.abc import Iterable

    from turtlewire.protocols.frame.dialect import Dialect

INTER_BYTE_S = 0.1  # F5
_MAGIC_BYTE = bytes([MAGIC])

Order = Literal["", "gap", "repeat", "restart"]
_IN_ORDER: Order = ""


class Frame(msgspec.Struct, frozen=True, gc=False):
    """A frame that was received whole and whose messages are all known.

    Attributes:
        offset: where in the stream its magic byte stands.
        raw: its bytes, magic to CRC.
        messages: what to carry out, in order. None at all: a heartbeat (F7).
        refused: messages that break their restriction (F4): counted, not carried out.
        order: how its sequence number follows the one before (F6): "" as it should, or it is the first; "repeat" the
            same number again; "restart" 0 where another was due; "gap" any other.
        lost: with a gap, how many frames are missing, modulo 256.
    """

    offset: int
    raw: bytes
    messages: tuple[FrameMessage, ...]
    refused: tuple[FrameMessage, ...] = ()
    order: Order = ""
    lost: int = 0

    @property
    def seq(self) -> int:
        """The sequence number."""
        return self.raw[1]


Item = Frame | Malformed


class Statistics(msgspec.Struct):
    """What a decoder has seen. The reasons for which a frame is ignored are counted separately (F3).

    Attributes:
        frames: frames that count; messages: of these, carried out.
        oversized: size above 124; wrong_crc; incomplete: given up after the inter-byte timeout (F5).
        unknown_type, inconsistent: the CRC was right, but a type is unknown, or a message is cut short.
        refused: messages that broke their restriction, by name (F4).
        skipped_bytes: that belong to no frame.
        gaps, lost: gaps in the sequence, and the frames missing there; repeats; restarts (F6).
    """

    frames: int = 0
    messages: int = 0
    oversized: int = 0
    wrong_crc: int = 0
    incomplete: int = 0
    unknown_type: int = 0
    inconsistent: int = 0
    refused: dict[str, int] = msgspec.field(default_factory=dict)
    skipped_bytes: int = 0
    gaps: int = 0
    lost: int = 0
    repeats: int = 0
    restarts: int = 0


# ------------------------------------------------------------------------------------------------- to bytes


def frame_bytes(dialect: Dialect, seq: int, payload: bytes) -> bytes:
    """One frame around a payload of at most 124 bytes."""
    checksum = dialect.checksum
    body = bytes((MAGIC, seq, len(payload))) + payload
    return body + bytes((checksum.algorithm.crc(body[checksum.coverage.first :]),))


class FrameEncoder:
    """Messages to frames, counting the sequence number: it starts at 0 and wraps after 255 (F6).

    Args:
        dialect: the messages and the settings.
        direction: which way the messages go.
    """

    def __init__(self, dialect: Dialect, direction: str = TO_ROBOT, seq: int = 0) -> None:
        self.dialect = dialect
        self.direction = direction
        self.seq = seq

    def pack(self, message: FrameMessage) -> bytes:
        """The bytes of one message within a frame.

        Raises ``MessageError`` if the dialect has no such message this way, or a field is out of range (F4).
        """
        return self.dialect.pack(message, self.direction)

    def payloads(self, messages: Iterable[FrameMessage]) -> list[bytes]:
        """What as few frames as it takes would carry, in order (F9). Of no messages: one empty payload.

        Raises ``MessageError`` as ``pack`` does.
        """
        payloads = [b""]
        for packed in [self.pack(message) for message in messages]:
            if len(payloads[-1]) + len(packed) > MAX_PAYLOAD:
                payloads.append(b"")
            payloads[-1] += packed
        return payloads

    def encode(self, messages: Iterable[FrameMessage] = ()) -> list[bytes]:
        """As few frames as it takes, in order, each of at most 124 bytes (F9). Of none: one empty frame (F7).

        Raises ``MessageError`` as ``pack`` does: then no frame is made and no number used.
        """
        return [self.frame(payload) for payload in self.payloads(messages)]

    def frame(self, payload: bytes) -> bytes:
        """The next frame, around messages that ``pack`` has packed: at most 124 bytes."""
        frame = frame_bytes(self.dialect, self.seq, payload)
        self.seq = (self.seq + 1) % 256
        return frame


# ----------------------------------------------------------------------------------------------- from bytes


class FrameDecoder:
    """Bytes to frames.

    Args:
        dialect: the messages and the settings.
        direction: which way the messages come: TO_ROBOT for a robot's end, FROM_ROBOT for a host's.
        timeout_s: a partial frame is given up after a pause this long (F5).

    Attributes:
        statistics: counts of everything.
    """

    def __init__(self, dialect: Dialect, direction: str = TO_ROBOT, timeout_s: float = INTER_BYTE_S) -> None:
        self.dialect = dialect
        self.statistics = Statistics()
        self._layouts = layouts(dialect, direction)
        self._crc = dialect.checksum.algorithm.crc
        self._residue = dialect.checksum.algorithm.residue
        self._first = dialect.checksum.coverage.first
        self._timeout_s = timeout_s
        self._partial = b""
        self._offset = 0  # of the first byte of the partial frame
        self._last_byte = math.inf
        self._due = -1  # the next sequence number, or -1 before the first frame
        self._lookout = Lookout(self._layouts, dialect.checksum)

    @property
    def pending(self) -> int:
        """How many bytes of a partial frame are kept: at most 127."""
        return len(self._partial)

    def next_timeout(self) -> float:
        """When the partial frame is to be given up, if nothing comes before; ``math.inf``: there is none."""
        return self._last_byte + self._timeout_s if self._partial else math.inf

    def receive_data(self, data: bytes, now: float | None = None) -> list[Item]:
        """Take bytes; return what they completed, in order.

        ``now`` is the time in seconds of any clock that does not go back; call this with no bytes at ``next_timeout``.
        Without it no partial frame is ever given up.
        """
        items: list[Item] = []
        if now is not None:
            if now >= self.next_timeout():
                self._scan(self._partial, items, ended=True)
            if data:
                self._last_byte = now
        self._scan(self._partial + data, items, ended=False)
        return items

    def end(self) -> list[Item]:
        """No more bytes come: give up what is incomplete; return the frames that stood within it."""
        items: list[Item] = []
        self._scan(self._partial, items, ended=True)
        return items

    def _scan(self, buffer: bytes, items: list[Item], *, ended: bool) -> None:
        at, end = 0, len(buffer)
        while (at := self._frames(buffer, at, items)) < end:
            begin = at
            if buffer[at] != MAGIC:
                at = buffer.find(_MAGIC_BYTE, at) % (end + 1)  # the end, if there is none
            elif malformed := self._malformed(buffer, at, ended=ended):
                items.append(malformed)
                at += 1
            else:
                break
            self.statistics.skipped_bytes += at - begin
        self._offset += at
        self._partial = buffer[at:]

    def _malformed(self, buffer: bytes, at: int, *, ended: bool) -> Malformed | None:
        """What is wrong with the frame that the magic byte at ``at`` seems to begin; None: its rest may come."""
        stats, offset, end = self.statistics, self._offset + at, len(buffer)
        size = buffer[at + 2] if at + 2 < end else 0
        stop = at + size + OVERHEAD
        if size > MAX_PAYLOAD:
            stats.oversized += 1
            return Malformed(offset, buffer[at : at + HEADER], f"size {size} is above {MAX_PAYLOAD}")
        if stop <= end:
            stats.wrong_crc += 1
            right = self._crc(buffer[at + self._first : stop - 1])
            return Malformed(
                offset, buffer[at:stop], f"CRC is {buffer[stop - 1]:02X}, but must be {right:02X}"
            )
        if ended:
            stats.incomplete += 1
            return Malformed(offset, buffer[at:], f"incomplete: {end - at} bytes and no more")
        return None

    def _frames(self, buffer: bytes, at: int, items: list[Item]) -> int:
        """Take the frames with a right CRC that follow one another from ``at`` on; return where the last one ends."""
        crc, first, residue, lookout = self._crc, self._first, self._residue, self._lookout
        base, last = self._offset, len(buffer) - HEADER
        while at <= last and buffer[at] == MAGIC:
            size = buffer[at + 2]
            stop = at + size + OVERHEAD
            if size > MAX_PAYLOAD or stop > last + HEADER:
                break
            if lookout.wait:
                lookout.wait -= 1
            elif run := lookout.run(buffer, at, stop - at, self._due):
                at += self._take(run, base + at, items)
                continue
            raw = buffer[at:stop]
            if crc(raw[first:] if first else raw) != residue:
                break
            items.append(self._frame(base + at, raw))
            at = stop
        return at

    def _sequence(self, seq: int) -> tuple[Order, int]:
        """How a frame's number follows, counted (F6)."""
        due, stats = self._due, self.statistics
        self._due = (seq + 1) & 255
        if seq == due or due < 0:
            return "", 0
        if self._due == due:
            stats.repeats += 1
            return "repeat", 0
        if seq == 0:
            stats.restarts += 1
            return "restart", 0
        lost = (seq - due) & 255
        stats.gaps += 1
        stats.lost += lost
        return "gap", lost

    def _frame(self, offset: int, raw: bytes) -> Item:
        """What stands in a frame whose CRC is right: all or nothing (F3)."""
        seq = raw[1]
        order, lost = _IN_ORDER, 0
        if seq == self._due:
            self._due = (seq + 1) & 255
        else:
            order, lost = self._sequence(seq)
        table = self._layouts
        messages: tuple[FrameMessage, ...] = ()
        refused: tuple[FrameMessage, ...] = ()
        at, end = HEADER, len(raw) - 1
        while at < end:
            layout = table[raw[at]]
            if layout is None:
                self.statistics.unknown_type += 1
                return Malformed(offset, raw, f"unknown type {raw[at]:02X} at byte {at}")
            message_type, _, size, unpack_from, limits, _ = layout
            if at + size > end:
                self.statistics.inconsistent += 1
                what = f"{message_type.name()} at byte {at} is cut short: {end - at} of {size} bytes"
                return Malformed(offset, raw, what)
            values = unpack_from(raw, at + 1)
            if limits and not keeps(limits, values):
                refused += (message_type(*values),)
            else:
                messages += (message_type(*values),)
            at += size
        stats = self.statistics
        stats.frames += 1
        stats.messages += len(messages)
        if not refused and not order:
            return Frame(offset, raw, messages)
        for message in refused:
            name = message.name()
            stats.refused[name] = stats.refused.get(name, 0) + 1
        return Frame(offset, raw, messages, refused, order, lost)

    def _take(self, run: Run, offset: int, items: list[Item]) -> int:
        """Take the frames of a run; return how many bytes they are."""
        raws, messages, each = run
        count, size, stats = len(raws), len(raws[0]), self.statistics
        items += map(Frame, range(offset, offset + count * size, size), raws, messages)
        stats.frames += count
        stats.messages += count * each
        self._due = (self._due + count) & 255
        return count * size


__all__ = [
    "FROM_ROBOT",
    "INTER_BYTE_S",
    "TO_ROBOT",
    "Frame",
    "FrameDecoder",
    "FrameEncoder",
    "Item",
    "Statistics",
    "frame_bytes",
]
