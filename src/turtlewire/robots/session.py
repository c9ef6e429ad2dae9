"""The one pump between a link and a host's state machine: bytes, timers, events.

Where the link lives in the background (a real port) a task pumps all the time, so that events are seen and a
watchdog is fed while the program thinks. Where it lives in virtual time, whoever waits pumps: then nothing ever
suspends, and asyncio is not even imported.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

from turtlewire.errors import LinkClosedError, TurtlewireError

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable, Sequence

    from turtlewire.links.link import Link

# The name of the task that serves a link: the last one to be ended.
PUMP = "turtlewire pump"

Event_co = TypeVar("Event_co", covariant=True)
EventT = TypeVar("EventT")


class HostMachine(Protocol[Event_co]):
    """The host's end of a protocol, sans-IO."""

    def urgent_to_send(self) -> bytes:
        """Bytes that overtake everything."""

    def data_to_send(self, now: float) -> bytes:
        """Bytes to send now."""

    def receive_data(self, data: bytes, now: float) -> Sequence[Event_co]:
        """Take bytes from the robot."""

    def next_timeout(self) -> float:
        """When to call ``timed_out``."""

    def timed_out(self, now: float) -> Sequence[Event_co]:
        """Act on the time."""


class Session(Generic[EventT]):
    """A link and a host's state machine at work.

    Every event of the machine is handed to ``on_event``, which must neither wait nor raise.
    """

    def __init__(self, link: Link, host: HostMachine[EventT], on_event: Callable[[EventT], None]) -> None:
        self.link = link
        self.bytes_sent = 0
        self.bytes_received = 0
        self._host = host
        self._on_event = on_event
        self._failure: TurtlewireError | None = None
        self._pump: asyncio.Task[None] | None = None
        self._changed: asyncio.Event | None = None

    def start(self) -> None:
        """Begin to pump; for a link in the background, from within its event loop."""
        if self.link.in_background:
            import asyncio

            self._changed = asyncio.Event()
            self._pump = asyncio.create_task(self._pump_forever(), name=PUMP)

    @property
    def failed(self) -> bool:
        """Whether the link has ended."""
        return self._failure is not None

    def flush(self) -> None:
        """Send what the machine wants sent; a stop even when nobody pumps any more. Raises ``LinkClosedError``."""
        try:
            urgent = self._host.urgent_to_send()
            if urgent:
                self.bytes_sent += len(urgent)
                self.link.write_urgent(urgent)
            if self._failure is not None:
                raise self._failure
            data = self._host.data_to_send(self.link.now())
            if data:
                self.bytes_sent += len(data)
                self.link.write(data)
        except LinkClosedError as error:
            self._failure = error
            raise
        self.link.wake()

    async def until(self, condition: Callable[[], bool], deadline: float = math.inf) -> bool:
        """Wait until a condition holds; False if a time came first. Raises ``LinkClosedError``."""
        self.flush()
        while not condition():
            if self._failure is not None:
                raise self._failure
            if self.link.now() >= deadline:
                return False
            if self._changed is None:
                await self._step(deadline)
            else:
                await self._change(deadline)
        return True

    async def close(self) -> None:
        """Stop pumping and let go of the link."""
        self._failure = self._failure or LinkClosedError(f"the link to {self.link.url} is closed")
        if self._pump is not None:
            import asyncio
            import contextlib

            self._pump.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._pump
        await self.link.close()

    async def _step(self, deadline: float = math.inf) -> None:
        """Let one thing happen."""
        try:
            data = await self.link.read(min(deadline, self._host.next_timeout()))
        except LinkClosedError as error:
            self._failure = error
            raise
        now = self.link.now()
        if data:
            self.bytes_received += len(data)
            for event in self._host.receive_data(data, now):
                self._on_event(event)
        if now >= self._host.next_timeout():
            for event in self._host.timed_out(now):
                self._on_event(event)
        self.flush()

    async def _pump_forever(self) -> None:
        import contextlib

        assert self._changed is not None
        try:
            with contextlib.suppress(LinkClosedError):  # kept as the failure that every waiter raises
                while True:
                    await self._step()
                    self._notify()
        finally:
            # However it ends, nobody may go on waiting for it.
            self._failure = self._failure or LinkClosedError(
                f"the link to {self.link.url} is not served any more"
            )
            self._notify()

    def _notify(self) -> None:
        import asyncio

        assert self._changed is not None
        self._changed.set()
        self._changed = asyncio.Event()

    async def _change(self, deadline: float) -> None:
        """Wait until the pump has let something happen."""
        import asyncio
        import contextlib

        assert self._changed is not None
        timeout = None if deadline == math.inf else max(0.0, deadline - self.link.now())
        with contextlib.suppress(TimeoutError):
            # Not wait_for, which in Python 3.11 can swallow a cancellation.
            async with asyncio.timeout(timeout):
                await self._changed.wait()
