"""A robot at the other end of a link, driven by set-points: held for a time, ended by a stop, reckoned all along."""

from __future__ import annotations

import contextlib
import math
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

from turtlewire.errors import LinkClosedError, LinkError, LinkLostError, StoppedError
from turtlewire.robots.reconnecting import Reconnecting
from turtlewire.robots.session import HostMachine, Session
from turtlewire.robots.stops import Stops
from turtlewire.robots.timed.reckoning import STILL, Motion, Reckoning

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from turtlewire.errors import TurtlewireError
    from turtlewire.links.link import Link
    from turtlewire.turtle import Pose

EventT = TypeVar("EventT")
EventT_co = TypeVar("EventT_co", covariant=True)
BITS_PER_BYTE = 10  # 8N1


class SetPointHost(HostMachine[EventT_co], Protocol[EventT_co]):
    """The host's end of a protocol of set-points."""

    @property
    def idle(self) -> bool:
        """Nothing to send, and everything that is answered at all is answered."""

    def emergency_stop(self, now: float) -> None:
        """Stop the robot from any state, ahead of everything."""


class TimedMotions(ABC, Generic[EventT]):
    """What the drivers of such robots share.

    Attributes:
        link: to the robot.
        account: where it is.
        started: when the connection was made, on the link's clock.
        trouble: what an event has told, to be raised by whoever waits, or by the next command.
    """

    def __init__(
        self,
        link: Link,
        host: SetPointHost[EventT],
        notify: Callable[[str], None],
        *,
        baud: int,
        stop_size: int,
        settle_s: float,
        overrun_s: float,
    ) -> None:
        self.link = link
        self.account = Reckoning()
        self.started = link.now()
        self.trouble: TurtlewireError | None = None
        self._machine = host
        self._session: Session[EventT] = Session(link, host, self._on_event, BITS_PER_BYTE / baud)
        self._notify = notify
        # Bytes, and time: a robot has heard a set-point, or a stop, when it has arrived.
        self._arrival_s = stop_size * BITS_PER_BYTE / baud
        self._settle_s = settle_s
        self._overrun_s = overrun_s
        self._stops = 0
        self._stops_told = Stops()
        self._is_holding = False
        self._ended_at: float | None = None  # when the motion that is held should have ended
        self._is_driven = False
        self._closed = False
        # Where the robot was when the link was lost, how it moved, and since when; until it is reached again.
        self._lost: tuple[Pose, Motion, float] | None = None

    # ------------------------------------------------------------------ what each robot does its own way

    @abstractmethod
    def _on_event(self, event: EventT) -> None:
        """Something came from the robot, or did not come in time; must neither wait nor raise."""

    @abstractmethod
    def _halt(self) -> None:
        """Submit what lets the robot stand still; it stays as it is otherwise."""

    async def _get_ready(self) -> None:
        """Before every command: see to it that the robot takes commands."""

    @abstractmethod
    async def get_in_step(self) -> None:
        """The port is open again: stop the robot, wait until it has booted, be in step with it.

        Raises ``NoReplyError`` if it cannot be talked to.
        """

    @abstractmethod
    async def _restore(self) -> None:
        """Before motion goes on after that: what a robot that was reset may have forgotten, such as its pen."""

    # ------------------------------------------------------------------ a link that is lost

    def _reconnect(self, reconnect_s: float) -> None:
        """From now on, open the link again when it is lost; 0 seconds: never."""
        if reconnect_s:
            self._session.reconnect_by(Reconnecting(self._session, self, reconnect_s, self._notify))

    def link_lost(self) -> str:
        """Where the robot may be now. It goes on as it did, until it is reached again or its watchdog acts."""
        account, now = self.account, self.link.now()
        motion = account.motion_under_way
        account.end(now)
        account.settle()
        self._is_driven = False
        self.trouble = None
        if self._lost is None:
            self._lost = (account.robot, motion, now)
        x_mm, y_mm, heading_deg = self._lost[0]
        does = "was driving" if self._lost[1] != STILL else "stood"
        return f"{does}, at x {x_mm:.0f} mm, y {y_mm:.0f} mm, heading {heading_deg:.0f} degrees by reckoning"

    def _found(self) -> None:
        """It was reached again, and stopped: somewhere between where it was then and where that would have led."""
        assert self._lost is not None
        self.trouble = None
        first, motion, since = self._lost
        last = motion.after(first, self.link.now() - since)
        middle = first._replace(x_mm=(first.x_mm + last.x_mm) / 2.0, y_mm=(first.y_mm + last.y_mm) / 2.0)
        if motion != STILL:
            self.account.place(middle._replace(heading_deg=last.heading_deg))
        self.account.settle()
        self._lost = None

    async def resume(self) -> None:
        """Let motion go on after the link was lost and the robot was reached again; nothing to do otherwise.

        The turtle is where the robot is by reckoning, which is not certain. No set-point of before is sent again (S8).
        Raises ``LinkLostError`` while the robot is not reached yet.
        """
        if not self._closed and self._session.state == "stopped":
            await self._get_ready()
            await self._restore()
            self._session.resumed()
        self._check()

    # ------------------------------------------------------------------ stopping

    def abandon(self) -> None:
        """Stop at once, ahead of everything; the turtle is where the robot is now. Raises ``LinkError``."""
        self._stops += 1
        now = self.link.now()
        self._session.clear_alarm()
        self._is_driven = False
        self.account.end(now + self._arrival_s)
        self.account.settle()
        self._machine.emergency_stop(now)
        self._session.flush()

    def _out_of_time(self, now: float) -> None:
        """The set-point's time is up, and no newer one has come."""
        self._is_driven = False
        self.account.end(now + self._arrival_s)
        self.account.settle()
        self._machine.emergency_stop(now)

    @property
    def is_over(self) -> bool:
        """Whether there is nothing left to wait for: it is closed, or the link was lost, and people have been told."""
        return self._closed or self._session.is_over

    async def let_go(self, last_bytes_s: float) -> None:
        """Stop the robot, if it can be reached, let the last bytes go out, and close the link."""
        if self._closed:
            return
        self._closed = True
        try:
            if self._session.state != "reconnecting":
                with contextlib.suppress(LinkError):
                    await self._part(last_bytes_s)
            if self._session.state == "reconnecting":
                await self._session.last_try(self._emergency_stop, last_bytes_s)
        finally:
            await self._session.close()

    def _emergency_stop(self, now: float) -> bytes:
        self._machine.emergency_stop(now)
        return self._machine.urgent_to_send()

    async def _part(self, last_bytes_s: float) -> None:
        self.abandon()
        await self._session.until(lambda: False, self.link.now() + last_bytes_s)

    # ------------------------------------------------------------------ waiting

    async def _ready(self) -> None:
        """Before every command. Raises what an event has told meanwhile, and what ``_get_ready`` raises."""
        self._check()
        if self.trouble is not None:
            self._raise_trouble()
        await self._get_ready()

    def _check(self) -> None:
        if self._closed:
            raise LinkClosedError(f"the link to {self.link.url} is closed: connect again")
        self._session.check()

    def _raise_trouble(self) -> None:
        trouble, self.trouble = self.trouble, None
        if trouble is not None:
            self.account.settle()
            raise trouble

    async def _until(self, condition: Callable[[], bool], deadline: float = math.inf) -> None:
        """Wait; and raise what comes meanwhile: a stop, an error."""
        stops = self._stops
        await self._session.until(
            lambda: condition() or self.trouble is not None or stops != self._stops, deadline
        )
        self._raise_interruption(stops)

    async def _answered(self) -> None:
        """Wait until all that was sent is answered, as far as it is at all. Raises what ``_until`` raises."""
        stops, machine = self._stops, self._machine
        await self._session.wait(lambda: machine.idle or self.trouble is not None or stops != self._stops)
        self._raise_interruption(stops)

    def _raise_interruption(self, stops: int) -> None:
        if stops != self._stops:
            self._stops_told.known()
            raise StoppedError(
                "the robot was stopped, or driven by hand: what it was doing, and what was waiting, is abandoned"
            )
        if self.trouble is not None:
            self._raise_trouble()

    async def _pause(self, seconds: float) -> None:
        if seconds > 0.0:
            await self._until(lambda: False, self.link.now() + seconds)

    # ------------------------------------------------------------------ motions

    async def _told(self, submit: Callable[[], None]) -> float:
        """Submit something, and wait until it goes out; when it will have arrived."""
        await self._until(lambda: self._machine.idle)
        self._session.mark()
        submit()
        await self._until(lambda: self._session.sent_at is not None)
        return self._session.arrived_at

    async def _hold(
        self,
        motion: Motion,
        seconds: float,
        submit: Callable[[], None],
        *,
        is_drawn: bool = True,
        settle_s: float | None = None,
    ) -> None:
        """Let the robot move so for so long, and stand still again; reckon where that has brought it.

        ``settle_s``: how long to wait until it stands; None: as long as the calibration says.

        However it ends, the robot does not go on. Raises what ``_until`` raises.
        """
        # What it coasts belongs to the motion: it is told to stop so much earlier.
        held_s = max(0.0, seconds - self._overrun_s)

        def end(now: float) -> None:
            self._session.mark()
            self._halt()
            self._ended_at = now + self._arrival_s

        with self._holding():
            self.account.begin(motion, await self._told(submit), is_drawn=is_drawn)
            # What ends it takes as long on the line as what began it.
            assert self._session.sent_at is not None
            self._session.set_alarm(self._session.sent_at + held_s, end)
            await self._until(lambda: self._ended_at is not None and self._machine.idle)
            self.account.end(self._session.arrived_at + self._overrun_s)
            await self._pause(self._settle_s if settle_s is None else settle_s)

    @contextlib.contextmanager
    def _holding(self) -> Iterator[None]:
        """A program of the turtle moves the robot, or lets it stand; however that ends, the robot does not go on."""
        self._is_holding, self._ended_at = True, None
        try:
            yield
        except (StoppedError, LinkLostError):
            raise  # by somebody who has seen to it, and may be driving by hand already
        except BaseException:
            with contextlib.suppress(LinkError):
                self.abandon()
            raise
        finally:
            self._is_holding = False

    # ------------------------------------------------------------------ by hand

    def _take_wheel(self) -> None:
        """Take the robot away from a program that moves it (``_is_holding``)."""
        self._stops += 1
        self._session.clear_alarm()

    def _driven(self, motion: Motion) -> None:
        """A set-point by hand is on its way: the robot moves so until told otherwise."""
        self.account.begin(motion, self.link.now() + self._arrival_s)
        self._is_driven = True  # where the turtle is, is settled when it takes over

    def _expire(self, valid_s: float | None) -> None:
        """Have what was just told end after so long, unless something newer comes; None: it goes on."""
        if valid_s is None:
            self._session.clear_alarm()
        else:
            self._session.set_alarm(self.link.now() + valid_s, self._out_of_time)

    async def _take_over(self) -> None:
        """Before a motion of the turtle: whoever drove by hand does not any more; it starts where that ended."""
        if not self._is_driven:
            return
        self._session.clear_alarm()
        self._is_driven = False
        with self._holding():
            self._ended_at = await self._told(self._halt)
            await self._until(lambda: self._machine.idle)
            self.account.end(self._ended_at)
            await self._pause(self._settle_s)
        self.account.settle()
