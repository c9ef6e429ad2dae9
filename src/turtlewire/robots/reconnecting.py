"""A link that was lost is opened again, and its robot stopped; motion goes on when somebody says so (section 4).

::

    connected --the link ends--> reconnecting --opened, robot booted, in step, stopped--> stopped --resume--> connected
                                  ^   |                                                     |
                                  |   +--no more time for it--> closed                      |
                                  +------------------the link ends again--------------------+

What was under way when the link ended is never sent again: relative moves must not be (W15), set-points only if
they are still wanted (S8), and nobody can know that.
"""

from __future__ import annotations

import contextlib
import math
from typing import TYPE_CHECKING, Literal, Protocol, TypeAlias

from turtlewire.errors import LinkClosedError, LinkError, LinkLostError, PortNotFoundError, TurtlewireError
from turtlewire.robots.session import ended

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable
    from typing import Any

    from turtlewire.robots.session import Session

LinkState: TypeAlias = Literal["connected", "reconnecting", "stopped", "closed"]

FIRST_PAUSE_S = 0.05
LONGEST_PAUSE_S = 1.0
# Whoever lets go of a robot that cannot be reached tries so long to stop it all the same.
LAST_TRY_S = 1.0


class Driver(Protocol):
    """What the driver of a robot does when its link is lost, and open again."""

    def link_lost(self) -> str:
        """Forget what was under way; neither wait nor raise. Returns where the robot may be: "was last at ..."."""

    async def get_in_step(self) -> None:
        """The port is open again: stop the robot, wait until it has booted, and be in step with it.

        Raises ``LinkError``, or another ``TurtlewireError`` if the robot cannot be talked to.
        """


class Reconnecting:
    """Opens the link of one session again.

    Args:
        session: whose link it is.
        driver: of the robot.
        reconnect_s: how long to go on trying, above 0.
        notify: told what people should know.

    Attributes:
        state: how the link is, unless it has ended.
        count: how often the robot was reached again.
        gave_up: whether it was tried for long enough, and in vain.
    """

    def __init__(
        self, session: Session[Any], driver: Driver, reconnect_s: float, notify: Callable[[str], None]
    ) -> None:
        self.state: LinkState = "connected"
        self.count = 0
        self.gave_up = False
        self._session = session
        self._driver = driver
        self._reconnect_s = reconnect_s
        self._notify = notify
        self._lost_s = self._deadline = -math.inf
        self._pause_s = 0.0
        self._reason = self._where = ""
        self._task: asyncio.Task[None] | None = None

    def __str__(self) -> str:
        """What somebody is told who waits, or wants something of the robot."""
        now = {
            "reconnecting": (
                "It may be moving until it is reached again, or its watchdog stops it. Nothing goes on by itself: "
                "reconnected() waits until it is reached and stopped, then resume() lets motion go on"
            ),
            "stopped": "It was reached again and stopped. Nothing goes on by itself: resume() lets motion go on",
        }.get(
            self.state,
            "It was reached again and stopped, and motion goes on: what was under way then does not",
        )
        return f"{self._reason} The robot {self._where}; where it is now is not certain. {now}"

    # ------------------------------------------------------------------ lost

    def lost(self, reason: str) -> None:
        """The link has ended."""
        now = self._session.link.now()
        where = self._driver.link_lost()
        if self.state != "reconnecting":
            self._lost_s, self._deadline, self._pause_s = now, now + self._reconnect_s, 0.0
            self._reason, self._where = reason if reason.endswith(("?", ".")) else f"{reason}.", where
            self.state = "reconnecting"
            self._notify(
                f"{self._reason} Trying to reach it again, for {self._reconnect_s:g} s; the robot {where}, and may be "
                "moving"
            )

    def _give_up(self, why: str, what: str = "") -> None:
        self.gave_up = True
        self._session.end(
            f"{self._reason} The robot {self._where}; it "
            f"{what or f'could not be reached again within {self._reconnect_s:g} s'} ({why}). "
            "If it still moves, switch it off; then connect again"
        )
        self._notify(self._session.ended)

    # ------------------------------------------------------------------ open again

    async def open_again(self) -> None:
        """In the background, by whoever serves the link: open it; getting in step goes on beside that."""
        import asyncio

        await self.cancel()
        if await self._open(math.inf):
            self._task = asyncio.create_task(self._get_in_step(), name="turtlewire reconnecting")

    async def open_here(self, until: float) -> None:
        """In virtual time, by whoever waits, until a time."""
        session = self._session
        while self.state == "reconnecting" and not session.ended and session.link.now() < until:
            if session.is_open or await self._open(until):
                await self._get_in_step()
        if self.gave_up:
            await session.link.close()

    async def cancel(self) -> None:
        """End what goes on beside serving the link."""
        task, self._task = self._task, None
        if task is not None:
            await ended(task)

    async def _open(self, until: float) -> bool:
        """Open the port, trying again and again; False when there is no more time."""
        session, link = self._session, self._session.link
        await link.close()
        why = "it ends again each time"
        while link.now() < self._deadline:
            await link.sleep(min(link.now() + self._pause_s, until, self._deadline))
            self._pause_s = min(max(FIRST_PAUSE_S, 2.0 * self._pause_s), LONGEST_PAUSE_S)
            try:
                await self._reopen(max(LAST_TRY_S, self._deadline - link.now()))
            except LinkClosedError as error:
                self._give_up(str(error), "cannot be reached again")
                return False
            except LinkError as error:
                why = str(error)
                if link.now() >= until:
                    return False
            else:
                session.opened_again()
                return session.is_open
        self._give_up(why)
        return False

    async def _get_in_step(self) -> None:
        """Stop the robot, and get in step with it, as often as there is time for."""
        session, link = self._session, self._session.link
        try:
            while True:
                try:
                    await self._driver.get_in_step()
                except LinkError:
                    return  # lost again, or over: who serves the link sees to it
                except TurtlewireError as error:
                    if link.now() >= self._deadline:
                        self._give_up(str(error))
                        return
                    await session.until(lambda: False, link.now() + self._pause_s)
                else:
                    break
        except LinkError:
            return
        except Exception as error:
            session.end(f"the link to {link.url} is not served any more: {error!r}")
            raise
        self.state = "stopped"
        self.count += 1
        session.notify()
        self._notify(
            f"the robot at {link.url} was reached again after {link.now() - self._lost_s:.1f} s, and stopped: "
            "nothing goes on by itself"
        )

    # ------------------------------------------------------------------ for whoever drives

    async def reached(self, timeout_s: float | None) -> None:
        """Wait until the robot was reached again. Raises ``LinkLostError`` in vain, ``LinkClosedError`` given up."""
        session = self._session
        until = math.inf if timeout_s is None else session.link.now() + timeout_s
        while self.state == "reconnecting" and not session.ended:
            if session.link.now() >= until:
                raise LinkLostError(
                    f"{self._reason} The robot {self._where}; it was not reached again within {timeout_s:g} s, and "
                    "trying goes on"
                )
            if session.link.in_background:
                await session.change(lambda: self.state != "reconnecting" or bool(session.ended), until)
            else:
                await self.open_here(until)

    async def last_try(self, emergency_stop: Callable[[float], bytes], last_bytes_s: float) -> None:
        """Whoever drives lets go of a robot that is not reached again yet: stop it, if that is possible at once."""
        session, link = self._session, self._session.link
        was_open = session.is_open
        session.end(f"the link to {link.url} is closed")
        await session.end_pumping()
        with contextlib.suppress(LinkError):
            if not was_open:
                await link.close()
                await self._reopen(LAST_TRY_S)
            link.write_urgent(emergency_stop(link.now()))
            await link.sleep(link.now() + last_bytes_s)

    async def _reopen(self, within_s: float) -> None:
        link = self._session.link
        if not link.in_background:
            await link.reopen()
            return
        import asyncio

        try:
            async with asyncio.timeout(within_s):
                await link.reopen()
        except TimeoutError:
            raise PortNotFoundError(f"nobody is at {link.url}") from None
