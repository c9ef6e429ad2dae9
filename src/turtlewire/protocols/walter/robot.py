"""WALTER, the robot's end: what a firmware does with each byte that it receives.

Sans-IO: bytes in, bytes and actions out. What moves (motors, simulated wheels) asks for the next command when the
last one is done, and is told at once when something may not wait. The same rules run on the chip.

- Logo commands are carried out in order (W9): ``next_command`` hands them out; a query is answered when its turn comes.
- ``2`` RET acts when it arrives: the queue is abandoned, the current motion ends (W8), direct control begins.
- Direct keys act when they arrive. ``1`` stops direct motion: in Logo control nothing could.
- A limit event abandons the queue (W13).
"""

from __future__ import annotations

from collections import deque

from turtlewire.protocols.message import Malformed
from turtlewire.protocols.walter.codec import ALL_GROUPS, CommandDecoder, Mode, encode
from turtlewire.protocols.walter.messages import (
    QUEUE_COMMANDS,
    DirectKey,
    EmptyLine,
    LimitBack,
    LimitFront,
    LimitLeft,
    LimitRight,
    LogoCommand,
    RobotMessage,
    SelectDirect,
)

LIMITS: dict[str, type[RobotMessage]] = {
    "front": LimitFront,
    "back": LimitBack,
    "left": LimitLeft,
    "right": LimitRight,
}
AtOnce = SelectDirect | DirectKey


class Robot:
    """The robot's end of the wire.

    Attributes:
        malformed: ill-formed lines and bytes that are no key, dropped in silence (W6).
        overflowed: commands dropped because ``QUEUE_COMMANDS`` were waiting; none as long as the host keeps to W9.
        heard: messages understood, empty lines included: what feeds a watchdog (section 4).
    """

    def __init__(self, mode: Mode = Mode.LOGO, groups: frozenset[str] = ALL_GROUPS) -> None:
        self._decoder = CommandDecoder(mode, groups)
        self._queue: deque[LogoCommand] = deque()
        self.malformed = 0
        self.overflowed = 0
        self.heard = 0

    @property
    def mode(self) -> Mode:
        """Logo control or direct control."""
        return self._decoder.mode

    @property
    def queued(self) -> int:
        """How many Logo commands wait."""
        return len(self._queue)

    @property
    def pending(self) -> int:
        """How many bytes of an unfinished message have been taken."""
        return self._decoder.pending

    def receive_data(self, data: bytes) -> list[AtOnce]:
        """Take bytes; return what has to act now, in order. Logo commands go to the queue.

        For ``SelectDirect`` the current motion has to end; its queue is abandoned already.
        """
        at_once: list[AtOnce] = []
        for item in self._decoder.receive_data(data):
            if isinstance(item, Malformed):
                self.malformed += 1
                continue
            self.heard += 1
            message = item.message
            if isinstance(message, SelectDirect):
                self._queue.clear()
                at_once.append(message)
            elif isinstance(message, DirectKey):
                at_once.append(message)
            elif isinstance(message, LogoCommand) and not isinstance(message, EmptyLine):
                if len(self._queue) < QUEUE_COMMANDS:
                    self._queue.append(message)
                else:
                    self.overflowed += 1
        return at_once

    def next_command(self) -> LogoCommand | None:
        """The next Logo command to carry out, or None: call it when the last one is done."""
        return self._queue.popleft() if self._queue else None

    def limit_tripped(self, sensor: str) -> bytes:
        """A limit sensor tripped: abandon the queue; return the event to send (W13)."""
        self._queue.clear()
        return encode(LIMITS[sensor]())
