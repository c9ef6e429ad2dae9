"""simple: getting host and robot back in step (S7), as a state machine of its own.

Nothing on this wire marks where a command begins, so one byte too many or too few shifts everything after it. The way
back: ``S``, one byte at a time, each given longer than the round trip to be answered. Whatever the robot has taken
of an unfinished command, seven bytes make a reply come, and the reply shows that the robot stands between commands.
An ``S`` where a digit must be makes the unfinished command invalid; where anything will do it completes it,
so a whole stop follows, and its ``K`` shows that the robot has stopped and both ends are in step.

::

    QUIET --the line is quiet--> PROBE --any reply--> CONFIRM --K--> IN_STEP
      ^                            |                     |
      |                            +--14 times silence---|---------> DEAD
      +-------------F, silence, or a reply before its time, too often -> DEAD
"""

from __future__ import annotations

import math
from enum import Enum

from turtlewire.protocols.simple.codec import encode
from turtlewire.protocols.simple.messages import LENGTH, PROBE, Stop

# Seven make any robot answer, were nothing lost; seven more, in case something was.
MAX_PROBES = 2 * LENGTH
# A line that never falls quiet is not waited for any longer than this.
QUIET_LIMIT_S = 1.0


class Line:
    """When bytes that were handed over have left, and how long to wait for what they bring back.

    Args:
        baud: of the line, to know how long bytes take.
        reply_delay_s: how long after its last byte has arrived a reply may be on its way: the firmware's own work and
            the delay of the adapter. A reply that takes longer may be taken for another.
    """

    def __init__(self, baud: int, reply_delay_s: float) -> None:
        self._byte_s = 10.0 / baud
        self._reply_s = self._byte_s + reply_delay_s
        self._free_at = -math.inf
        self._active_at = -math.inf

    def touch(self, now: float) -> None:
        """Something came in, or the line was opened: it is not quiet."""
        self._active_at = now

    def sent(self, data: bytes, now: float) -> float:
        """Bytes are handed over now. Returns the time by which the reply to them must be there."""
        self._free_at = max(self._free_at, now) + len(data) * self._byte_s
        return self._free_at + self._reply_s

    def reply_due(self, start: float) -> float:
        """By when the robot must have answered what it has completely received at ``start``."""
        return start + self._reply_s

    def quiet_at(self) -> float:
        """From when on nothing that was sent so far can be answered any more."""
        return self.reply_due(max(self._free_at, self._active_at))


class Stage(Enum):
    """Where the way back into step has got to."""

    QUIET = "waiting until the line is quiet"
    PROBE = "sending S by S until the robot answers"
    CONFIRM = "sending a whole stop"
    IN_STEP = "in step, stopped"
    DEAD = "given up"


class Resynchronisation:
    """One way back into step: S7.

    Args:
        line: the line's timing.
        now: the time, in seconds.
        retries: how often to begin again when something goes wrong on the way.
        boot_until: until when the robot may be booting: what is tried before then does not count.

    Attributes:
        stage: where it has got to; ``IN_STEP`` and ``DEAD`` are ends.
        spent: bytes sent so far: at most 14 if nothing goes wrong on the way.
        failure: why it was given up.
    """

    def __init__(self, line: Line, now: float, *, retries: int, boot_until: float = -math.inf) -> None:
        self._line = line
        self._retries = retries
        self._boot_until = boot_until
        self._rounds = 0
        self.spent = 0
        self.failure = ""
        self._wait(now)

    def _wait(self, now: float) -> None:
        self.stage = Stage.QUIET
        self._began = now
        self._probes = 0
        self._send_next(b"")

    def _send_next(self, data: bytes) -> None:
        self._out = data
        self._due = math.inf

    def data_to_send(self, now: float) -> bytes:
        """Bytes to send now."""
        data, self._out = self._out, b""
        if data:
            self._probes += 1
            self.spent += len(data)
            self._due = self._line.sent(data, now)
        return data

    def replied(self, now: float, *, accepted: bool) -> None:
        """The robot answered ``K`` or ``F``."""
        if self.stage is Stage.PROBE and self._probes:
            self.stage = Stage.CONFIRM
            self._send_next(encode(Stop()))
        elif self.stage is Stage.CONFIRM and accepted and not self._out:
            self.stage = Stage.IN_STEP
        elif self.stage is not Stage.QUIET:
            # An answer to nothing that was sent yet, or F to a stop: bytes still get lost or added.
            self._again(now)

    def _again(self, now: float) -> None:
        if self._began >= self._boot_until:
            self._rounds += 1
        if self._rounds > self._retries:
            self.stage = Stage.DEAD
            self.failure = f"the robot answers, but {self._rounds} attempts to get in step with it failed"
        else:
            self._wait(now)

    def next_timeout(self) -> float:
        """When ``timed_out`` wants to be called, if nothing happens before."""
        if self.stage is Stage.QUIET:
            return min(self._line.quiet_at(), self._began + QUIET_LIMIT_S)
        return self._due

    def timed_out(self, now: float) -> None:
        """Act on the time. Call ``data_to_send`` afterwards."""
        if now < self.next_timeout():
            return
        if self.stage is Stage.CONFIRM:
            self._again(now)
        elif self.stage is Stage.QUIET:
            self.stage = Stage.PROBE
            self._send_next(PROBE)
        elif self._probes < MAX_PROBES:
            self._send_next(PROBE)
        elif self._began < self._boot_until:
            self._began = now
            self._probes = 0
            self._send_next(PROBE)
        else:
            self.stage = Stage.DEAD
            self.failure = f"the robot does not answer: {MAX_PROBES} bytes brought no reply"
