"""What every link to a robot is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from turtlewire.errors import LinkClosedError

if TYPE_CHECKING:
    from collections.abc import Callable


class Link(ABC):
    """A way to carry bytes to and from one robot, opened exclusively, with a clock.

    Attributes:
        url: what it was opened by, for messages to people.
        in_background: whether time passes by itself, and bytes come in while nobody asks (a real port). Where it does
            not (a simulated robot in virtual time), ``read`` is what lets time pass, and it never suspends.
    """

    url: str
    in_background: bool

    @abstractmethod
    def now(self) -> float:
        """Seconds on this link's clock: monotonic, from any origin."""

    @abstractmethod
    def write(self, data: bytes) -> None:
        """Hand over bytes to send. Never blocks. Raises ``LinkClosedError`` when the link has ended."""

    @abstractmethod
    def write_urgent(self, data: bytes) -> None:
        """Send bytes ahead of everything that has not left this computer: that is thrown away.

        Raises ``LinkClosedError`` when the link has ended.
        """

    @abstractmethod
    async def read(self, until: float) -> bytes:
        """Wait for bytes from the robot, for ``wake``, or until a time; ``b""`` when none came.

        Raises ``LinkClosedError`` when the link has ended and all that came has been read.
        """

    def listen(self, receive: Callable[[bytes], None]) -> bool:  # noqa: ARG002 - for those that can
        """From now on hand over bytes as they come; ``read`` then waits for time, for ``wake``, or for the link's end.

        Returns False, and does nothing, where a link cannot do that: its bytes are read.
        """
        return False

    @abstractmethod
    def wake(self) -> None:
        """End a ``read`` that waits: there is an earlier time to wait for, or something else to be done."""

    @abstractmethod
    async def close(self) -> None:
        """Send what has been handed over, as far as that takes no longer than a second, and let go of the port."""

    # ------------------------------------------------------------------ after it has ended

    async def reopen(self) -> None:
        """Open the same port again, after ``close``: nothing that came or was to go before counts any more.

        What lies around a link (faults, a recording) goes on over it. Raises ``LinkError`` when the port cannot be had
        now, ``LinkClosedError`` when it never can again, as for links that do not know how.
        """
        raise LinkClosedError(f"the link to {self.url} cannot be opened again: connect anew")

    async def sleep(self, until: float) -> None:
        """Let time pass while the link is closed, or while nothing that comes counts."""
        import asyncio

        await asyncio.sleep(max(0.0, until - self.now()))
