"""The one pump between a link and a host's state machine: bytes, timers, events.

Where the link lives in the background (a real port) bytes are taken as they come, and a task sees to the time, so that
events are seen and a watchdog is fed while the program thinks. Where it lives in virtual time, whoever waits
pumps: then nothing ever suspends, and asyncio is not even imported.

A session has one alarm: a set-point ends when its time is up, whoever is or is not waiting for that; a motion ends on
time though the program that began it was cancelled, and a joystick that fell silent stops its robot.

A link that ends is the end of the session, or the beginning of ``reconnecting``.
"""

from __future__ import annotations

import contextlib
import math
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

from turtlewire.errors import LinkClosedError, LinkError, LinkLostError

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable, Sequence

    from turtlewire.links.link import Link
    from turtlewire.robots.reconnecting import LinkState, Reconnecting
    from turtlewire.robots.waiter import Waiter

# The name of the task that serves a link: the last one to be ended.
PUMP = "turtlewire pump"

Event_co = TypeVar("Event_co", covariant=True)
EventT = TypeVar("EventT")


class _BrokenError(Exception):
    """Nothing can be sent or heard."""


async def ended(task: asyncio.Task[None]) -> None:
    """End a task, and wait for that. Raises what it raised, if that is not that it was ended."""
    import asyncio

    task.cancel()
    await asyncio.wait([task])  # awaiting the task itself could not tell its end from that of whoever waits
    if not task.cancelled():
        task.result()


class HostMachine(Protocol[Event_co]):
    """The host's end of a protocol, sans-IO."""

    @property
    def idle(self) -> bool:
        """Nothing to send now, nor to wait for but the time."""

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

    def link_lost(self, now: float) -> Sequence[Event_co]:
        """The link ended: forget all that was under way or to come. Nothing is sent before the next beginning."""


class Session(Generic[EventT]):
    """A link and a host's state machine at work.

    Every event of the machine is handed to ``on_event``, which must neither wait nor raise.

    Args:
        link: to the robot.
        host: the machine.
        on_event: told what happens.
        byte_s: how long a byte takes on the line, seconds.

    Attributes:
        sent_at: when the first bytes since ``mark`` were sent, on the link's clock; None: none have been yet.
        arrived_at: when the robot had all of them, if the line was free.
        free_at: when all bytes that were sent so far will have left.
        ended: why there is no link any more, for people; "" while there is one, or may be one again.
        losses: how often the link was lost.
        is_told: whether anybody has been told of the last loss, or of the end, by an error.
    """

    def __init__(
        self, link: Link, host: HostMachine[EventT], on_event: Callable[[EventT], None], byte_s: float
    ) -> None:
        self.link = link
        self.sent_at: float | None = None
        self.arrived_at = -math.inf
        self.free_at = -math.inf
        self.bytes_sent = 0
        self.bytes_received = 0
        self.ended = ""
        self.losses = 0
        self.is_told = True
        self._host = host
        self._on_event = on_event
        self._byte_s = byte_s
        self._alarm_at = math.inf
        self._act: Callable[[float], None] = lambda _: None
        self._is_broken = False  # lost or ended: nothing can be sent or heard
        self._reconnecting: Reconnecting | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._pump: asyncio.Task[None] | None = None
        self._waiter: type[Waiter] | None = None  # asyncio is imported only where it is needed
        # Who waits, and for what; and until when the pump sleeps.
        self._waiting: dict[Waiter, Callable[[], bool]] = {}
        self._sleeps_until = -math.inf

    def start(self) -> None:
        """Begin to pump; for a link in the background, from within its event loop."""
        if self.link.in_background:
            import asyncio

            from turtlewire.robots.waiter import Waiter

            self._waiter = Waiter
            self._loop = asyncio.get_running_loop()
            self._pump = asyncio.create_task(self._pump_forever(), name=PUMP)
            self.link.listen(self._received)

    def reconnect_by(self, reconnecting: Reconnecting) -> None:
        """From now on, open a link that ends again."""
        self._reconnecting = reconnecting

    @property
    def state(self) -> LinkState:
        """How the link is."""
        if self.ended:
            return "closed"
        return self._reconnecting.state if self._reconnecting is not None else "connected"

    @property
    def is_connected(self) -> bool:
        """Whether a robot at this link may be moved."""
        return not self._is_broken and (self._reconnecting is None or self._reconnecting.state == "connected")

    @property
    def is_over(self) -> bool:
        """Whether nothing moves over this link, for good or for now, and somebody has been told so."""
        return self.state != "connected" and self.is_told

    @property
    def reconnections(self) -> int:
        """How often the robot was reached again after the link was lost."""
        return self._reconnecting.count if self._reconnecting is not None else 0

    # ------------------------------------------------------------------ the alarm, and when what was sent

    def set_alarm(self, at: float, act: Callable[[float], None]) -> None:
        """Have ``act`` called once, with the time, as soon as it is ``at``; instead of any alarm set before."""
        self._alarm_at, self._act = at, act
        if at < self._sleeps_until:
            self.link.wake()

    def clear_alarm(self) -> None:
        """Forget the alarm."""
        self._alarm_at = math.inf

    def mark(self) -> None:
        """From now on, ``sent_at`` and ``arrived_at`` are about the next bytes that go out."""
        self.sent_at = None

    # ------------------------------------------------------------------ sending and waiting

    def flush(self) -> None:
        """Send what the machine wants sent; a stop even when nobody pumps any more. Raises ``LinkError``."""
        try:
            self._send()
        except _BrokenError:
            raise self.error() from None

    async def until(self, condition: Callable[[], bool], deadline: float = math.inf) -> bool:
        """Wait until a condition holds; False if a time came first.

        Raises ``LinkLostError`` if the link is lost meanwhile, ``LinkClosedError`` if there is none any more.
        """
        self.flush()
        return await self.wait(condition, deadline)

    async def wait(self, condition: Callable[[], bool], deadline: float = math.inf) -> bool:
        """``until`` for what has been sent already."""
        losses = self.losses
        # After a loss the machine is empty, and nothing that it says is about before.
        while losses == self.losses:
            if condition():
                return True
            if self._is_broken:
                break
            if deadline < math.inf and self.link.now() >= deadline:
                return False
            if self._loop is None:
                with contextlib.suppress(_BrokenError):
                    await self._step(deadline)
            elif await self.change(condition, deadline):
                return True
        raise self.error()

    async def change(self, condition: Callable[[], bool], deadline: float = math.inf) -> bool:
        """Wait until a condition has come to hold, until a time, or until the link has ended; where somebody pumps.

        False if the condition has not come to hold.
        """
        assert self._loop is not None
        assert self._waiter is not None
        waiter = self._waiter(self._loop)
        self._waiting[waiter] = condition
        alarm = None
        if deadline < math.inf:
            alarm = self._loop.call_later(max(0.0, deadline - self.link.now()), waiter.give_up)
        try:
            return await waiter
        finally:
            del self._waiting[waiter]
            if alarm is not None:
                alarm.cancel()

    def notify(self) -> None:
        """Something has happened: wake those who need not wait any longer."""
        for waiter, condition in tuple(self._waiting.items()):
            if self._is_broken:
                waiter.give_up()
            elif condition():
                waiter.wake()

    def check(self) -> None:
        """Before anything that moves the robot. Raises ``LinkLostError`` until that is allowed again, or for good."""
        if not self.is_connected:
            raise self.error()

    def error(self) -> LinkError:
        """Why nothing can be done, for whoever wants to."""
        self.is_told = True
        if self.ended or self._reconnecting is None:
            return LinkClosedError(self.ended)
        return LinkLostError(str(self._reconnecting))

    # ------------------------------------------------------------------ how it ends

    def end(self, reason: str) -> None:
        """There will be no link any more; whoever waits is told why."""
        if not self.ended:
            self.ended, self.is_told = reason, False
        self._is_broken = True
        self.notify()
        self.link.wake()

    async def close(self) -> None:
        """Stop pumping and let go of the link."""
        self.end(f"the link to {self.link.url} is closed")
        self.is_told = True
        try:
            await self.end_pumping()
        finally:
            await self.link.close()

    async def end_pumping(self) -> None:
        """Nobody serves the link any more, nor opens it again."""
        if self._reconnecting is not None:
            await self._reconnecting.cancel()
        if self._pump is not None:
            await ended(self._pump)

    def _broke(self, error: LinkClosedError) -> _BrokenError:
        """The link has ended, for good or not."""
        if self._is_broken:
            return _BrokenError()
        if self._reconnecting is None:
            self.end(str(error))
            return _BrokenError()
        self.losses += 1
        self._is_broken, self.is_told = True, False
        self.clear_alarm()
        self._reconnecting.lost(str(error))
        for event in self._host.link_lost(self.link.now()):
            self._on_event(event)
        self.notify()
        self.link.wake()
        return _BrokenError()

    async def reached(self, timeout_s: float | None) -> None:
        """Wait until a robot whose link was lost was reached again; see ``Reconnecting.reached``."""
        if self._reconnecting is not None:
            await self._reconnecting.reached(timeout_s)
        if self.ended:
            raise self.error()

    def resumed(self) -> None:
        """Motion may go on."""
        assert self._reconnecting is not None
        self._reconnecting.state = "connected"

    async def last_try(self, emergency_stop: Callable[[float], bytes], last_bytes_s: float) -> None:
        """Let go of a robot that is not reached yet: see ``Reconnecting.last_try``."""
        assert self._reconnecting is not None
        await self._reconnecting.last_try(emergency_stop, last_bytes_s)

    def opened_again(self) -> None:
        """The link is open again: it can be used."""
        self._is_broken = bool(self.ended)

    @property
    def is_open(self) -> bool:
        """Whether anything can be sent and heard."""
        return not self._is_broken

    # ------------------------------------------------------------------ pumping

    def _send(self) -> None:
        host, link = self._host, self.link
        now = link.now()
        try:
            urgent = host.urgent_to_send()
            if urgent:
                self.bytes_sent += len(urgent)
                self.free_at = max(self.free_at, now) + len(urgent) * self._byte_s
                link.write_urgent(urgent)
            if self._is_broken:
                raise _BrokenError
            data = host.data_to_send(now)
            if data:
                takes_s = len(data) * self._byte_s
                self.bytes_sent += len(data)
                self.free_at = max(self.free_at, now) + takes_s
                if self.sent_at is None:
                    self.sent_at, self.arrived_at = now, now + takes_s
                link.write(data)
        except LinkClosedError as error:
            raise self._broke(error) from None
        if host.next_timeout() < self._sleeps_until:
            link.wake()

    def _received(self, data: bytes) -> None:
        """Bytes came, by themselves."""
        if self._is_broken:
            return  # somebody else has seen it end: what came before does not count any more
        try:
            self._take(data)
            if not self._host.idle:
                self._send()
            elif self._host.next_timeout() < self._sleeps_until:
                self.link.wake()
        except _BrokenError:
            return  # whoever waits has been woken
        except BaseException:
            self.end(f"the link to {self.link.url} is not served any more")
            raise
        self.notify()  # at the very end: whoever waited goes on within

    def _take(self, data: bytes) -> None:
        self.bytes_received += len(data)
        for event in self._host.receive_data(data, self.link.now()):
            self._on_event(event)

    async def _step(self, deadline: float = math.inf) -> None:
        """Let one thing happen."""
        self._sleeps_until = min(deadline, self._alarm_at, self._host.next_timeout())
        try:
            data = await self.link.read(self._sleeps_until)
        except LinkClosedError as error:
            raise self._broke(error) from None
        finally:
            self._sleeps_until = -math.inf
        if self._is_broken:  # somebody else has seen it end: what came before does not count any more
            raise _BrokenError
        if data:
            self._take(data)
        now = self.link.now()
        if now >= self._alarm_at:
            self.clear_alarm()
            self._act(now)
        if now >= self._host.next_timeout():
            for event in self._host.timed_out(now):
                self._on_event(event)
        self._send()

    async def _pump_forever(self) -> None:
        try:
            while not self.ended:
                try:
                    await self._step()
                except _BrokenError:
                    if self._reconnecting is not None and not self.ended:
                        await self._reconnecting.open_again()
                self.notify()
            if self._reconnecting is not None and self._reconnecting.gave_up:
                await self.link.close()
        finally:
            # However it ends, nobody may go on waiting for it.
            self.end(f"the link to {self.link.url} is not served any more")
