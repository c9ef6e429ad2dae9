"""Frame, the robot's end: what a firmware does with each byte that it receives.

Sans-IO: bytes in, messages to carry out, bytes out. Frames count whole or not at all (F3); a message that breaks its
restriction is not carried out, the others of its frame are (F4). In Serial Protocol 0.1 a robot says nothing; a
dialect may give it messages of its own (F11). The same rules run on the chip.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from turtlewire.protocols.frame.codec import INTER_BYTE_S, Frame, FrameDecoder, FrameEncoder, Statistics
from turtlewire.protocols.frame.dialect import FROM_ROBOT, TO_ROBOT

if TYPE_CHECKING:
    from turtlewire.protocols.frame.dialect import Dialect
    from turtlewire.protocols.frame.message import FrameMessage


class Robot:
    """The robot's end of the wire.

    Args:
        dialect: the messages, and how many servos, engines and so on this robot has.
        timeout_s: a partial frame is given up after a pause this long (F5).

    Attributes:
        heard: frames that counted, empty ones included: what feeds a watchdog (F7, section 4).
    """

    def __init__(self, dialect: Dialect, timeout_s: float = INTER_BYTE_S) -> None:
        self.dialect = dialect
        self.heard = 0
        self._decoder = FrameDecoder(dialect, TO_ROBOT, timeout_s)
        self._encoder = FrameEncoder(dialect, FROM_ROBOT)

    @property
    def statistics(self) -> Statistics:
        """What has come: frames, reasons to ignore, gaps in the sequence."""
        return self._decoder.statistics

    @property
    def pending(self) -> int:
        """How many bytes of a partial frame are kept: at most 127."""
        return self._decoder.pending

    def receive_data(self, data: bytes, now: float | None = None) -> list[FrameMessage]:
        """Take bytes; return the messages to carry out, in order.

        ``now`` is the time in seconds; without it a partial frame is never given up (F5).
        """
        messages: list[FrameMessage] = []
        for item in self._decoder.receive_data(data, now):
            if isinstance(item, Frame):
                self.heard += 1
                messages += item.messages
        return messages

    def next_timeout(self) -> float:
        """When to call ``receive_data`` with no bytes, if none come before; ``math.inf``: never."""
        return self._decoder.next_timeout()

    def send(self, *messages: FrameMessage) -> bytes:
        """The bytes of as few frames as these messages take (F9, F11); of none, an empty frame.

        Raises ``MessageError`` if a message does not go from robot to host, or has a field out of range.
        """
        return b"".join(self._encoder.encode(messages))
