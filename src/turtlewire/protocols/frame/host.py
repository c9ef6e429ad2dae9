"""Frame, the host's end: a state machine that decides which frames go out when, and what comes back.

Sans-IO: time is an argument (seconds, any clock that does not go back), bytes go in and out as values. The rules:

- There are no acknowledgements. Set-points are absolute, so the newest of a channel (an engine, a servo) wins: an
  older one that has not gone out is forgotten. What waits goes out together, in as few frames as it takes (F9), as
  soon as the line has carried what went before. Messages that are no set-points go out once each, in order.
- The latest set-points may be repeated at a steady rate (F6), and an empty frame sent where nothing else was, to
  feed a watchdog (F7).
- At connect, at an emergency stop and at exit a stop goes out that a robot hears whatever it was in the middle of
  (F13), ahead of everything; all set-points are forgotten.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from turtlewire.errors import UsageError
from turtlewire.protocols.frame.codec import INTER_BYTE_S, Frame, FrameDecoder, FrameEncoder, Statistics
from turtlewire.protocols.frame.dialect import FROM_ROBOT, TO_ROBOT
from turtlewire.protocols.frame.message import MAGIC, MAX_FRAME, MAX_PAYLOAD, FrameMessage

if TYPE_CHECKING:
    from turtlewire.protocols.frame.codec import Item
    from turtlewire.protocols.frame.dialect import Dialect

BITS_PER_BYTE = 10  # 8N1
# F13: so many units of stop frames more, when a frame's worth of bytes has gone.
STOPS_HEARD = 2


def stop_bytes(encoder: FrameEncoder) -> bytes:
    """A stop that is heard (F13): from any state of a receiver, all known engines end at 0.

    A receiver that was left in the middle of a frame takes up to 127 bytes as its rest: stops are repeated until 128
    bytes and then two more have gone. A dialect whose stops do not fit one frame repeats all of them.

    A receiver may come out of a foreign frame anywhere in these. So that it does not take something in them for the
    beginning of a long frame and waits, no stop has the number A3, and after a CRC that is A3 comes a number above
    124, which is no size. The receiver sees a gap in the sequence then, once in some 128 frames.
    """
    stops = encoder.dialect.stop_messages()
    out = bytearray()
    more = STOPS_HEARD
    while more:
        more -= len(out) >= MAX_FRAME
        for payload in encoder.payloads(stops):
            if encoder.seq == MAGIC:
                encoder.seq += 1
            frame = encoder.frame(payload)
            if frame[-1] == MAGIC:
                encoder.seq = max(encoder.seq, MAX_PAYLOAD + 1)
            out += frame
    return bytes(out)


class Host:
    """The host's end of the wire. Nothing goes out before ``connect``.

    Args:
        dialect: the messages and the robot's settings.
        repeat_s: send the latest set-points again at this interval (F6); None: never.
        heartbeat_s: send an empty frame whenever nothing else was sent for so long (F7); None: never.
        timeout_s: the inter-byte timeout of what comes from the robot (F5).
        baud: of the line, to know when it has carried what was sent; None: the dialect's.

    Attributes:
        connected: between ``connect`` and ``exit``.
        repeats: how often the latest set-points were sent again (F6).
    """

    def __init__(
        self,
        dialect: Dialect,
        *,
        repeat_s: float | None = None,
        heartbeat_s: float | None = None,
        timeout_s: float = INTER_BYTE_S,
        baud: int | None = None,
    ) -> None:
        for name, interval_s in (("repeat", repeat_s), ("heartbeat", heartbeat_s)):
            if interval_s is not None and not interval_s > 0:
                raise UsageError(f"the {name} interval must be more than 0 s, not {interval_s:g}")
        self.dialect = dialect
        self.connected = False
        self.repeats = 0
        self._repeat_s = math.inf if repeat_s is None else repeat_s
        self._heartbeat_s = math.inf if heartbeat_s is None else heartbeat_s
        self._byte_s = BITS_PER_BYTE / (baud or dialect.baud)
        self._encoder = FrameEncoder(dialect, TO_ROBOT)
        self._decoder = FrameDecoder(dialect, FROM_ROBOT, timeout_s)
        self._commands = 0
        # What waits, oldest first: a set-point by its channel and number, anything else by a number of its own.
        self._unsent: dict[tuple[str, float], bytes] = {}
        self._latest: dict[tuple[str, float], bytes] = {}
        self._urgent = b""
        self._last_sent = -math.inf
        self._last_repeat = -math.inf
        self._line_free = -math.inf

    # ------------------------------------------------------------------ what the host wants

    def send(self, *messages: FrameMessage) -> None:
        """Have messages sent; those of one call go out together where they fit one frame (F9).

        Raises ``MessageError`` for a field out of range (F4) or a message that does not go to robots, ``UsageError``
        while not connected: nothing is sent then.
        """
        if not self.connected:
            raise UsageError("the host is not connected: what it is told to send would be forgotten")
        packed = [(message, self._encoder.pack(message)) for message in messages]
        for message, data in packed:
            entry = self.dialect.entry(message)
            key = (entry.channel, float(getattr(message, entry.key)) if entry.key else 0.0)
            if entry.channel:
                self._latest[key] = data
            else:
                self._commands += 1
                key = ("", float(self._commands))
            self._unsent.pop(key, None)
            self._unsent[key] = data

    def connect(self, now: float) -> None:
        """Stop the robot, whatever it was in the middle of; from now on messages can be sent (F13)."""
        self.connected = True
        self.emergency_stop(now)

    def emergency_stop(self, now: float) -> None:
        """Have every known engine stop, ahead of everything; forget all set-points (F13)."""
        self._unsent.clear()
        self._latest.clear()
        self._urgent = stop_bytes(self._encoder)
        self._last_repeat = now
        self._sent(now, len(self._urgent))

    def exit(self, now: float) -> None:
        """Stop the robot; nothing more is sent until the next ``connect`` (F13)."""
        self.emergency_stop(now)
        self.connected = False

    def link_lost(self, now: float) -> list[FrameMessage]:  # noqa: ARG002 - as the hosts of all protocols
        """The link ended: forget everything; nothing is sent until the next ``connect``, not even a heartbeat."""
        self._unsent.clear()
        self._latest.clear()
        self._urgent = b""
        self.connected = False
        self._decoder.end()
        return []

    # ------------------------------------------------------------------ bytes out

    @property
    def unsent(self) -> int:
        """How many messages wait to be sent."""
        return len(self._unsent)

    @property
    def idle(self) -> bool:
        """Nothing waits to be sent."""
        return not (self._unsent or self._urgent)

    def urgent_to_send(self) -> bytes:
        """Bytes that overtake whatever has been handed to the operating system and has not left it."""
        data, self._urgent = self._urgent, b""
        return data

    def data_to_send(self, now: float) -> bytes:
        """The frame to send now, if any; call it again after every event and at ``next_timeout``."""
        if not self.connected or now < self._line_free:
            return b""
        if self._latest and now >= self._last_repeat + self._repeat_s:
            self._last_repeat = now
            self.repeats += 1
            self._unsent = {**self._latest, **self._unsent}
        if not self._unsent and now < self._last_sent + self._heartbeat_s:
            return b""
        payload = b""
        for key, data in list(self._unsent.items()):
            if len(payload) + len(data) > MAX_PAYLOAD:
                break
            payload += data
            del self._unsent[key]
        frame = self._encoder.frame(payload)
        self._sent(now, len(frame))
        return frame

    def _sent(self, now: float, size: int) -> None:
        self._last_sent = now
        self._line_free = now + size * self._byte_s

    # ------------------------------------------------------------------ bytes in

    @property
    def statistics(self) -> Statistics:
        """What has come from the robot: counted, with gaps in the sequence and every reason to ignore a frame."""
        return self._decoder.statistics

    def receive_data(self, data: bytes, now: float) -> list[FrameMessage]:
        """Take bytes from the robot; return its messages, in order (F11)."""
        return _messages(self._decoder.receive_data(data, now))

    # ------------------------------------------------------------------ time

    def next_timeout(self) -> float:
        """When ``timed_out`` wants to be called, if nothing happens before; ``math.inf``: never."""
        due = self._decoder.next_timeout()
        if not self.connected:
            return due
        wants = self._last_sent + self._heartbeat_s
        if self._latest:
            wants = min(wants, self._last_repeat + self._repeat_s)
        if self._unsent:
            wants = self._line_free
        return min(due, max(wants, self._line_free))

    def timed_out(self, now: float) -> list[FrameMessage]:
        """Act on the time; return messages that a false beginning had held back. Call ``data_to_send`` afterwards."""
        return self.receive_data(b"", now)


def _messages(items: list[Item]) -> list[FrameMessage]:
    return [message for item in items if isinstance(item, Frame) for message in item.messages]
