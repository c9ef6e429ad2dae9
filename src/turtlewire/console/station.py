"""One robot of the console: reached again and again, driven by whoever has its wheel, stopped by anybody."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
from typing import TYPE_CHECKING, Any, TypeVar

from turtlewire.console.faulting import Faulting
from turtlewire.console.refusals import Refused
from turtlewire.console.runs import Runs
from turtlewire.console.sending import Sending
from turtlewire.console.setpoints import LIFE_S, Grips
from turtlewire.console.traffic import Traffic
from turtlewire.console.wheel import Wheel
from turtlewire.errors import TurtlewireError
from turtlewire.helm.helm import Helm
from turtlewire.helm.path import Path
from turtlewire.helm.sight import title
from turtlewire.helm.view import View
from turtlewire.helm.wishes import Action, Order, Wish

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Sequence
    from pathlib import Path as FilePath

    from turtlewire.configuration import Target
    from turtlewire.connect import AsyncRobot
    from turtlewire.console.sessions import Session
    from turtlewire.console.setpoints import SetPoint
    from turtlewire.helm.lease import Lease
    from turtlewire.links.link import Link
    from turtlewire.trace import Obstacle

T = TypeVar("T")
log = logging.getLogger("turtlewire.console")
# A robot that cannot be reached is tried again after so long.
AGAIN_S = 3.0
# How often to see whether it is still there.
LOOK_S = 0.2
# How often the robot is looked at.
SHOW_S = 0.05
UNREACHED = View(link="unreachable")
CONNECTING = View(link="connecting")


class Station:
    """A robot, its wheel and its path. To be used from the event loop of the server.

    Args:
        name: in addresses, and for people.
        target: the robot.
        pace: of a simulated one: seconds of its time for each second on the wall.
        announce: told where the robot has to be, for a new pty.
        folder: of its programs; None: they have none.

    Attributes:
        wheel: who drives.
        path: where it has been.
        traffic: what passes on its wire; faulting: what goes wrong there; sending: messages that somebody writes.
        program: what runs on it.
        error: why it is not reached; "": it is, or nobody knows yet.
        watchers: how many pages show it.
        is_changed: told when something about it changed that is no matter of its view.
    """

    def __init__(
        self,
        name: str,
        target: Target,
        pace: float,
        announce: Callable[[str], None],
        folder: FilePath | None = None,
    ) -> None:
        self.name = name
        self.target = target
        self.title = title(target)
        self.wheel = Wheel()
        self.path = Path()
        self.traffic = Traffic(target)
        self.faulting = Faulting(target, pace)
        self.sending = Sending(self)
        self.program = Runs(self, folder)
        self.error = ""
        self.watchers = 0
        self._pace = pace
        self._announce = announce
        self._grips = Grips()
        self._helm: Helm | None = None
        self._reaching: asyncio.Task[None] | None = None
        self._is_over = False

    # ------------------------------------------------------------------ reaching it

    def open(self) -> None:
        """Begin to reach it, and to go on doing so."""
        self._reaching = asyncio.create_task(self._keep_reaching(), name=f"turtlewire reach {self.name}")

    async def _keep_reaching(self) -> None:
        while True:
            target = self.target._replace(faults=None) if self.faulting.is_possible else self.target
            helm = Helm(
                target,
                pace=self._pace,
                announce=self._announce,
                between=self._between,
                path=self.path,
                look_s=SHOW_S,
            )
            try:
                await self._reach(helm)
            except TurtlewireError as error:
                if str(error) != self.error:
                    log.warning("%s: %s", self.name, error)
                self.error = str(error)
                await asyncio.sleep(AGAIN_S)

    def _between(self, link: Link) -> Link:
        return self.traffic.listen(self.faulting.over(link))

    async def _reach(self, helm: Helm) -> None:
        """Reach it, and stay with it until it is lost for good. Raises ``TurtlewireError``."""
        try:
            await asyncio.to_thread(helm.connect)
            self.error = ""
            self._helm = helm
            log.info("%s: reached", self.name)
            while helm.failure is None:  # noqa: ASYNC110 (the helm lives in another thread)
                await asyncio.sleep(LOOK_S)
        finally:
            self._helm = None
            # Not interrupted by anything: it stops the robot.
            await asyncio.shield(asyncio.to_thread(self._let_go_of, helm))
        if isinstance(helm.failure, TurtlewireError):
            raise helm.failure
        log.error("%s: a mistake of ours: %r", self.name, helm.failure)

    def _let_go_of(self, helm: Helm) -> None:
        helm.stop()
        try:
            self.program.close()
        finally:
            helm.close()

    async def close(self) -> None:
        """Stop it, and let go of it."""
        task, self._reaching = self._reaching, None
        if task is not None:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)

    # ------------------------------------------------------------------ what is known

    @property
    def is_reached(self) -> bool:
        """Whether there is anything to drive."""
        return self._helm is not None

    @property
    def view(self) -> View:
        """What is to be seen of it."""
        if self._helm is not None:
            return self._helm.view
        return UNREACHED if self.error else CONNECTING

    @property
    def obstacles(self) -> Sequence[Obstacle]:
        """What stands around it, as far as is known."""
        return self._helm.obstacles if self._helm is not None else ()

    @property
    def about(self) -> dict[str, Any]:
        """What does not change from moment to moment."""
        helm = self._helm
        return {
            "name": self.name,
            "title": self.title,
            "protocol": self.target.protocol,
            "simulated": self.target.is_simulated,
            "reached": self.is_reached,
            "error": self.error or None,
            "features": sorted(helm.features) if helm else [],
            "obstacles": [list(obstacle) for obstacle in self.obstacles],
            "origin": helm.origin._asdict() if helm and helm.origin else None,
            "combines": self.target.protocol != "walter",
            "steers": self.target.protocol == "simple",
        }

    def refused(self, session: Session) -> int | None:
        """The newest grip of this session that a stop or an error has ended."""
        self._notice_refusal()
        return self._grips.ended(session.id)

    def tick(self, now: float) -> None:
        """Time has passed."""
        before = self.wheel.driver
        self.wheel.tick(now)
        self._after_change(before)

    # ------------------------------------------------------------------ driving

    def drive(self, session: Session, point: SetPoint, now: float) -> None:
        """Go on so for a moment. Raises ``Refused``."""
        helm = self._reached()
        if self.program.is_running:
            raise Refused(409, "program_runs", "a program has this robot: stop it, or wait until it ends")
        if self._grips.is_new(session.id, point.grip):
            self.wheel.press(session.id, now)
        self.wheel.need(session.id, now)
        self._notice_refusal()
        if not self._grips.hold(session.id, point.grip, now):
            raise Refused(409, "ended", "a stop or an error has ended this grip: let go, and press anew")
        self.sending.give_way()
        self.wheel.active(session.id, now)
        helm.steer(Wish(point.speed, point.turn, point.horn, now + LIFE_S, self._grips.number))

    def release(self, session: Session) -> None:
        """Let go: a gentle stop, if this session is who drives."""
        if self.wheel.driver == session.id:
            self._let_go()

    def stop(self, by: Session | None, who: str) -> None:
        """Stop it, whoever says so, ahead of everything; the wheel is free, and only a new grip drives again."""
        if self._helm is not None:
            self._helm.stop()
        self.program.stop()
        self._grips.end()
        self.wheel.stopped(by.id if by else None)
        log.info("%s: stopped by %s", self.name, who)

    def halt(self) -> None:
        """Stop the robot and nothing else, from any thread; never waits."""
        helm = self._helm
        if helm is not None:
            helm.stop()

    def end(self) -> None:
        """The console ends: stop the robot, and have nobody drive it any more; from any thread."""
        self._is_over = True
        self.halt()

    def hid(self, session: Session) -> None:
        """Its page is not seen any more: nobody drives blindly."""
        if self.wheel.driver == session.id:
            self._halt()

    def leave(self, session: Session, now: float) -> None:
        """A session is over: if it drove, the robot stands."""
        before = self.wheel.driver
        self.wheel.leave(session.id, now)
        self._after_change(before)
        self._grips.leave(session.id)

    def turn_wheel(self, session: Session, action: str, to: int | None, now: float) -> None:
        """Take, ask, give, keep or release the wheel. Raises ``Refused``."""
        before = self.wheel.driver
        match action:
            case "take":
                self.wheel.take(session.id, now)
            case "ask":
                self.wheel.ask(session.id, now)
            case "give":
                self.wheel.give(session.id, to, now)
            case "keep":
                self.wheel.keep(session.id, to, now)
            case _:
                self.wheel.release(session.id, now)
        self._after_change(before)

    def _after_change(self, before: int | None) -> None:
        """The wheel may have passed on: what its last driver wished for ends."""
        if before is not None and before != self.wheel.driver:
            self._halt()

    def _halt(self) -> None:
        """Nobody drives by hand now; what else the robot does (a program) goes on."""
        self._grips.end()
        self._let_go()
        self.sending.halt()

    def _let_go(self) -> None:
        if self._helm is not None:
            self._helm.steer(Wish(until=-math.inf, number=self._grips.number))

    def _notice_refusal(self) -> None:
        if self._helm is not None and 0 < self._grips.number <= self._helm.refused:
            self._grips.end()

    # ------------------------------------------------------------------ what is done once

    def do(self, session: Session, order: Order, now: float) -> None:
        """Have something done once. Raises ``Refused``."""
        if self.program.is_running and order.action is not Action.RESUME:
            raise Refused(409, "program_runs", "a program has this robot: stop it, or wait until it ends")
        self.wheel.active(session.id, now)
        self._reached().do(order)

    def borrow(self) -> Lease:
        """The robot, for a program: see ``Helm.lend``; from any thread. Raises ``Refused`` while it is not reached."""
        helm = self._reached()
        with contextlib.suppress(TurtlewireError):
            return helm.lend()
        raise self._not_reached()

    async def lend(self, work: Callable[[AsyncRobot], Coroutine[object, None, T]]) -> T:
        """Have one thing done with the robot. Raises ``Refused``, ``StoppedError`` and what the work raises."""
        lease = self.borrow()
        try:
            return await asyncio.wrap_future(lease.call(work))
        finally:
            lease.close()

    def tell_of(self, error: TurtlewireError) -> None:
        """Have people told what became of something that was done with the robot while it was lent."""
        if self._helm is not None:
            self._helm.tell_of(error)

    def _reached(self) -> Helm:
        if self._is_over:
            raise Refused(409, "over", "the console is ending: nothing is driven any more")
        if self._helm is None:
            raise self._not_reached()
        return self._helm

    def _not_reached(self) -> Refused:
        return Refused(
            409,
            "not_reached",
            f"{self.name} is not reached" + (f": {self.error}" if self.error else " yet"),
        )
