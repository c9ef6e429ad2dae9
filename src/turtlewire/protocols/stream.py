"""One direction of a wire, decoded so that no byte of it vanishes."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from turtlewire.protocols.message import AnyMessage, Decoded, Malformed

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

# Bytes that belong to nothing are reported in pieces of this many: they may never end.
SKIPPED_BYTES = 64


class Skipped(NamedTuple):
    """Bytes that belong to no message, where in the stream they began, and what they are."""

    offset: int
    raw: bytes
    reason: str


Received = Decoded[AnyMessage] | Malformed
Item = Received | Skipped


class Source(NamedTuple):
    """A protocol's own decoder, as ``Decoder`` uses it.

    Attributes:
        receive: takes bytes and the time in seconds at which they came; gives what they completed.
        pending: how many bytes it has taken of an unfinished message.
        between: what the bytes are that it passes over in silence.
        end: gives what stands in the unfinished message's bytes when no more come.
    """

    receive: Callable[[bytes, float], Sequence[Received]]
    pending: Callable[[], int]
    between: str = ""
    end: Callable[[], Sequence[Received]] = tuple


class Decoder:
    """Decodes one direction; every byte is in exactly one item, in order.

    What the protocol's own decoder passes over becomes ``Skipped``; where it looks for a message again within bytes
    that it has called malformed, each item has only the bytes before the next one. The items are the same for every
    chunking. Less than a message and ``SKIPPED_BYTES`` are kept.

    Attributes:
        offset: where in the stream the first byte stands that is in no item yet.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._kept = b""
        self.offset = 0

    @property
    def kept(self) -> bytes:
        """The bytes that are in no item yet."""
        return self._kept

    def receive_data(self, data: bytes, now: float = 0.0) -> list[Item]:
        """Take bytes that came at a time, in seconds; return what they completed, in order.

        ``b""`` only lets time pass: a protocol may give up a message that does not go on.
        """
        received = self._source.receive(data, now)
        buffer = self._kept + data
        # Behind this stands the beginning of a message, which is not ready for any item.
        done = len(buffer) - self._source.pending()
        items, at = self._tiled(received, buffer, done)
        while done - at >= SKIPPED_BYTES:
            at = self._skip(buffer, at, at + SKIPPED_BYTES, items)
        self._keep(buffer, at)
        return items

    def finish(self) -> list[Item]:
        """The stream ends here: what is left of it."""
        buffer = self._kept
        unfinished = self._source.pending()
        received = self._source.end()
        done = len(buffer) if received else len(buffer) - unfinished
        items, at = self._tiled(received, buffer, done)
        at = self._skip(buffer, at, done, items)
        if at < len(buffer):
            items.append(Malformed(self.offset + at, buffer[at:], "the stream ends within a message"))
        self._keep(buffer, len(buffer))
        return items

    def _tiled(self, received: Sequence[Received], buffer: bytes, done: int) -> tuple[list[Item], int]:
        """What was received side by side with what stands between; and where in the buffer it ends."""
        items: list[Item] = []
        at = 0
        for number, item in enumerate(received, 1):
            start = item.offset - self.offset
            self._skip(buffer, at, start, items)
            at = start + len(item.raw)
            if isinstance(item, Malformed):
                following = received[number].offset - self.offset if number < len(received) else done
                if following < at:
                    at = following
                    item = Malformed(item.offset, buffer[start:at], item.reason)  # noqa: PLW2901 - its share
            items.append(item)
        return items, at

    def _skip(self, buffer: bytes, at: int, end: int, items: list[Item]) -> int:
        for start in range(at, end, SKIPPED_BYTES):
            raw = buffer[start : min(start + SKIPPED_BYTES, end)]
            items.append(Skipped(self.offset + start, raw, self._source.between))
        return end

    def _keep(self, buffer: bytes, at: int) -> None:
        self._kept = buffer[at:]
        self.offset += at
