"""simple, the robot's end: what a firmware does with each byte that it receives.

Sans-IO: bytes in, replies and actions out. The same rules run on the chip:

- After every seven bytes, and never earlier, exactly one reply: ``K`` if they were a valid command, ``F`` if not (S4).
- An invalid command changes nothing.
- Drive and steering are independent and hold their value until changed. ``S`` sets both to 0; headlights stay (S5).
- There is no time in it: a command that was begun waits for the rest of its seven bytes for ever (the source).
"""

from __future__ import annotations

from typing import NamedTuple

from turtlewire.protocols.message import Malformed
from turtlewire.protocols.simple.codec import CommandDecoder, encode
from turtlewire.protocols.simple.messages import Accepted, Headlights, Rejected, SimpleCommand, Stop

_ACCEPTED, _REJECTED = encode(Accepted()), encode(Rejected())


class Reaction(NamedTuple):
    """What received bytes lead to: replies to send, and valid commands to carry out, in order."""

    replies: bytes
    actions: list[SimpleCommand]


class Robot:
    """The robot's end of the wire.

    Args:
        extensions: commands beyond the source's that this robot knows (S10). They are answered and come as actions;
            what they set is the body's business. Raises ``UsageError`` if one of them does not fit.

    Attributes:
        drive: -255 (full speed backward) .. 255 (full speed forward), PWM.
        steer: -255 (full lock left) .. 255 (full lock right), PWM.
        lights: left upper, left lower, right upper, right lower.
        malformed: invalid commands, answered with ``F``.
        heard: valid commands: what feeds a watchdog (section 4), which is the body's business.
    """

    def __init__(self, extensions: tuple[type[SimpleCommand], ...] = ()) -> None:
        self._decoder = CommandDecoder(extensions)
        self.drive = 0
        self.steer = 0
        self.lights = (False, False, False, False)
        self.malformed = 0
        self.heard = 0

    @property
    def pending(self) -> bytes:
        """What has been received of an unfinished command: at most six bytes."""
        return self._decoder.pending

    def receive_data(self, data: bytes) -> Reaction:
        """Take bytes; return the replies to send and what to carry out now."""
        replies = b""
        actions: list[SimpleCommand] = []
        for item in self._decoder.receive_data(data):
            if isinstance(item, Malformed):
                self.malformed += 1
                replies += _REJECTED
                continue
            assert isinstance(item.message, SimpleCommand), "the decoder knows commands only"
            self.heard += 1
            self._carry_out(item.message)
            replies += _ACCEPTED
            actions.append(item.message)
        return Reaction(replies, actions)

    def stop(self) -> None:
        """Stop the motors, as ``S`` does: for a watchdog that nothing has fed."""
        self.drive = self.steer = 0

    def _carry_out(self, command: SimpleCommand) -> None:
        if isinstance(command, Stop):
            self.stop()
        elif isinstance(command, Headlights):
            a, b, c, d = command.values()
            self.lights = (bool(a), bool(b), bool(c), bool(d))
        elif command.CHANNEL == "drive":
            self.drive = command.SIGN * command.values()[0]
        elif command.CHANNEL == "steer":
            self.steer = command.SIGN * command.values()[0]
