"""What all messages of all dialects have in common, and the numbers of a frame (section 1 of the source)."""

from __future__ import annotations

from turtlewire.protocols.message import AnyMessage

MAGIC = 0xA3
MAX_PAYLOAD = 124
# magic, seq, size; and the CRC behind the payload
HEADER = 3
OVERHEAD = HEADER + 1
MAX_FRAME = MAX_PAYLOAD + OVERHEAD


class FrameMessage(AnyMessage, frozen=True, gc=False):
    """A message of any dialect of frame. Its type byte is the dialect's to know: settings may change it (F1)."""
