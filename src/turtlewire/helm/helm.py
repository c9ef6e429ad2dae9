"""Carries out what somebody wants who drives by hand, and tells what becomes of it.

The robot is driven in a thread of its own, which goes on when whoever shows it does not: whatever is wished ends in its
time, here and once more in the driver, by the time to live of its set-points.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections import deque
from typing import TYPE_CHECKING, Any

from turtlewire.errors import LinkClosedError, StoppedError, TurtlewireError
from turtlewire.helm.lease import Lease
from turtlewire.helm.notices import Notices
from turtlewire.helm.sight import Ear, Sight, title
from turtlewire.helm.view import Level, View
from turtlewire.helm.wishes import Action, Order, Wish, walter_key
from turtlewire.robots.runner import ThreadRunner
from turtlewire.robots.stops import on_behalf_of
from turtlewire.robots.walter import AsyncWalter

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Sequence

    from turtlewire.configuration import Target
    from turtlewire.connect import AsyncRobot
    from turtlewire.helm.path import Path
    from turtlewire.links.link import Link
    from turtlewire.trace import Obstacle
    from turtlewire.turtle import Pose

# A set-point lives so much longer in the driver than its wish, so that a gentle stop comes first.
MARGIN_S = 0.1
# A wish without an end is renewed by whoever is alive; its set-points live no longer than this.
LATCHED_S = 1.0
# The stop that ends a wish is sent once more: it may have got lost.
SURE_S = 0.15
# A robot that stands is asked where it is after so long (if it can tell), and now and then whether it is still there.
ASK_S, CHECK_S = 0.5, 5.0
# How often what is to be seen is looked at.
LOOK_S = 0.08
# How long the horn may take to fall silent on the way out.
SILENCE_S = 0.5


class Helm:
    """Drives one robot. Every method may be called from any thread, and none but ``connect`` and ``close`` waits.

    Args:
        target: the robot.
        pace: of a simulated one: seconds of its time for each second on the wall.
        announce: told where the robot has to be, for a new pty.
        between: given the link, in real time, returns the link to use instead.
        path: where the robot goes is added to this.
        look_s: how often what is to be seen is looked at, seconds.

    Attributes:
        view: what is to be seen of the robot, made anew again and again.
        failure: what has ended everything; None: nothing has.
        refused: the key press whose wish was ended by a stop or an error: it begins nothing any more.
        features: what else the robot has, see ``Drive.features``; obstacles, origin: see ``Sight``. Once connected.
    """

    def __init__(
        self,
        target: Target,
        *,
        pace: float,
        announce: Callable[[str], None],
        between: Callable[[Link], Link] = lambda link: link,
        path: Path | None = None,
        look_s: float = LOOK_S,
    ) -> None:
        self.title = title(target)
        self.view = View()
        self.failure: BaseException | None = None
        self.features: frozenset[str] = frozenset()
        self.obstacles: Sequence[Obstacle] = ()
        self.origin: Pose | None = None
        self._target = target
        self._pace = pace
        self._announce = announce
        self._between = between
        self._path = path
        self._look_s = look_s
        self._runner: ThreadRunner | None = None
        self._wish = Wish()
        self._orders: deque[Order] = deque()
        self.refused = 0
        self._notices = Notices()
        self._is_connected = False

    # ------------------------------------------------------------------ from whoever drives

    def connect(self) -> None:
        """Reach the robot. Raises what ``turtlewire.connect`` raises."""
        runner = self._runner = ThreadRunner()
        try:
            runner.run(self._by_itself(self._connect))
        except BaseException:
            self._runner = None
            runner.close()
            raise
        self._is_connected = True

    def close(self) -> None:
        """Stop the robot, and let go of it; give up reaching it, if that is still going on in another thread."""
        runner, self._runner = self._runner, None
        if runner is None:
            return
        try:
            if self._is_connected:
                self._is_connected = False
                runner.run(self._by_itself(self._close))
        finally:
            runner.close()

    def steer(self, wish: Wish) -> None:
        """Wish for something else, or for the same again."""
        self._soon(lambda: self._take(wish))

    def do(self, order: Order) -> None:
        """Have something done once."""
        self._soon(lambda: self._take(order))

    def stop(self) -> None:
        """Stop at once, ahead of everything."""
        self._soon(self._stop_now)

    def stop_and_wait(self, seconds: float) -> None:
        """Stop at once; come back when the stop has left the program, or after so long."""
        if not self._is_connected:
            return
        with contextlib.suppress(TimeoutError, RuntimeError):
            asyncio.run_coroutine_threadsafe(self._by_itself(self._stopped), self._loop).result(seconds)

    def tell_of(self, error: TurtlewireError) -> None:
        """Have people told what became of something that was done with the robot while it was lent."""
        self._soon(lambda: self._notices.tell_of(error))

    def note(self, text: str, level: Level = "note") -> None:
        """Have people told something."""
        self._soon(lambda: self._notices.tell(text, level))

    def lend(self) -> Lease:
        """Lend the robot, which stands: until the lease is closed, nothing is driven or asked by itself.

        Raises ``LinkClosedError`` while the robot is not reached.
        """
        if not self._is_connected:
            raise LinkClosedError(f"the {self.title} is not reached")
        lease = Lease(self._robot, self._hands, self._loop, self._taken_back)
        self._soon(lambda: self._lent(lease))
        return lease

    def _soon(self, act: Callable[[], object]) -> None:
        if self._is_connected:
            with contextlib.suppress(RuntimeError):  # it has just been closed
                self._loop.call_soon_threadsafe(act)

    # ------------------------------------------------------------------ in the robot's thread

    async def _by_itself(self, act: Callable[[], Coroutine[object, None, None]]) -> None:
        """Whatever is said to the robot from here, and from tasks begun here, one says: a stop of ours is known."""
        with on_behalf_of(self):
            await act()

    async def _connect(self) -> None:
        from turtlewire.connect import connect_async

        self._loop = asyncio.get_running_loop()
        self._wake = asyncio.Event()
        self._hands = asyncio.Lock()
        self._leases: set[Lease] = set()
        ear = Ear(self._target, self._pace, self._between)
        robot: AsyncRobot = await connect_async(
            self._target, notify=self._notices.warn, announce=self._announce, wrap=ear
        )
        self._robot = robot
        self._walter = robot if isinstance(robot, AsyncWalter) else None
        self._sight = Sight(robot, ear, is_seen=self._target.is_simulated, path=self._path)
        self._notices.elapsed_s = lambda: self._sight.elapsed_s
        self.features, self.obstacles = robot.features, self._sight.obstacles
        self.origin = self._sight.origin
        self._carried_out: Wish | None = None
        self._is_driven = False
        self._is_sure = True
        self._horn = False
        self._stood_s = self._checked_s = time.monotonic()
        self._asking: asyncio.Task[None] | None = None
        self._stopping: set[asyncio.Task[None]] = set()
        self._look()
        self._tasks = [self._serving(self._work(), "helm"), self._serving(self._keep_looking(), "view")]

    def _serving(self, coroutine: Any, name: str) -> asyncio.Task[None]:
        task: asyncio.Task[None] = asyncio.create_task(coroutine, name=f"turtlewire {name}")
        task.add_done_callback(self._ended)
        return task

    def _ended(self, task: asyncio.Task[None]) -> None:
        """Only what nobody has thought of ends one of these tasks."""
        if not task.cancelled() and task.exception() is not None:
            self.failure = self.failure or task.exception()
            self._stop_now()

    async def _close(self) -> None:
        await self._end(*self._tasks)
        await self._end_asking()
        try:
            if self._horn:
                with contextlib.suppress(TurtlewireError, TimeoutError):
                    await self._robot.stop()
                    async with asyncio.timeout(SILENCE_S):
                        await self._robot.horn("off")
                        if self._walter is not None:
                            await self._walter.finish()
        finally:
            await self._robot.close(finish=False)
            self._look()

    async def _end(self, *tasks: asyncio.Task[None]) -> None:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def _take(self, what: Wish | Order) -> None:
        """In the order in which things were said: a stop ends what was wished before it, and nothing later."""
        if isinstance(what, Wish):
            self._wish = what
        else:
            self._orders.append(what)
        self._wake.set()

    def _stop_now(self) -> None:
        self._wish = self._wish._replace(until=-math.inf)
        self.refused = self._wish.number
        self._orders.clear()
        for lease in self._leases:
            lease.end()
        task = asyncio.create_task(self._by_itself(self._stopped), name="turtlewire stop")
        self._stopping.add(task)
        task.add_done_callback(self._stopping.discard)

    async def _stopped(self) -> None:
        self._stands()
        self._is_sure = True
        with contextlib.suppress(TurtlewireError):  # who serves the robot hears of it, too
            await self._robot.stop()

    # ------------------------------------------------------------------ what is wished

    async def _work(self) -> None:
        while self.failure is None:
            wish = self._wish
            try:
                async with self._hands:
                    goes_on = await self._next(wish)
            except TurtlewireError as error:
                self._trouble(error, wish)
            else:
                if not goes_on:
                    await self._wait()

    async def _next(self, wish: Wish) -> bool:
        """Do what has to be done next; False: nothing has."""
        now = time.monotonic()
        moves = wish.moves and now < wish.until and wish.number != self.refused
        if self._is_driven and not moves:
            await self._robot.drive(0.0, 0.0)
            self._stands()
        elif self._leases:
            for lease in self._leases:
                lease.granted.set()
            return False
        elif self._orders:
            await self._end_asking()
            await self._carry_out(self._orders.popleft())
        elif wish.horn != self._horn and "horn" in self.features:
            await self._sound(on=wish.horn and now < wish.until)
        elif moves and wish is not self._carried_out:
            await self._end_asking()
            self._is_driven, self._carried_out = True, wish
            valid_s = min(wish.until - now, LATCHED_S) + MARGIN_S
            await self._robot.drive(wish.speed, wish.turn, valid_s=valid_s)
        elif not (self._is_driven or self._is_sure) and now >= self._stood_s + SURE_S:
            self._is_sure = True
            await self._halt_again()
        elif not self._is_driven and now >= self._check_due():
            self._checked_s = now
            await self._check()
        else:
            return False
        return True

    async def _wait(self) -> None:
        """Until something new comes, or something is due."""
        due = self._check_due()
        if self._leases:
            due = math.inf
        elif self._is_driven:
            due = self._wish.until
        elif not self._is_sure:
            due = self._stood_s + SURE_S
        timeout = None if due == math.inf else max(0.0, due - time.monotonic())
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(timeout):
                await self._wake.wait()
        self._wake.clear()

    def _stands(self) -> None:
        """The robot was told to stand."""
        self._is_driven = self._is_sure = False
        self._carried_out = None
        self._stood_s = time.monotonic()
        self._sight.is_told = False

    async def _halt_again(self) -> None:
        if self._walter is not None:
            await self._walter.stop()  # from whatever state a lost byte may have left it in (W8)
        else:
            await self._robot.drive(0.0, 0.0)

    # ------------------------------------------------------------------ while it is lent

    def _lent(self, lease: Lease) -> None:
        self._leases.add(lease)
        self._wish = self._wish._replace(until=-math.inf, horn=False)
        self.refused = self._wish.number
        self._wake.set()
        if self._asking is not None:
            self._asking.cancel()

    def _taken_back(self, lease: Lease) -> None:
        self._leases.discard(lease)
        self._stood_s = time.monotonic()
        self._is_sure = True
        self._wake.set()

    # ------------------------------------------------------------------ while it stands

    def _check_due(self) -> float:
        """When to see whether the robot is still there, and where."""
        if self._walter is not None and -math.inf < self._checked_s < self._stood_s:
            return self._stood_s + ASK_S
        return self._checked_s + CHECK_S

    async def _check(self) -> None:
        if self._walter is None:
            await self._robot.drive(0.0, 0.0)  # a set-point that is repeated: a car answers it
        elif "Q" in self._walter.groups:
            await self._end_asking()
            self._asking = asyncio.create_task(self._ask(self._walter), name="turtlewire asking")

    async def _ask(self, robot: AsyncWalter) -> None:
        """Where is the robot? A wish does not wait for that."""
        wish = self._wish
        try:
            self._sight.told(await robot.reported_pose())
        except TurtlewireError as error:
            self._trouble(error, wish)
            self._wake.set()

    async def _end_asking(self) -> None:
        task, self._asking = self._asking, None
        if task is not None:
            await self._end(task)

    # ------------------------------------------------------------------ orders

    async def _carry_out(self, order: Order) -> None:
        robot = self._robot
        match order.action:
            case Action.LAMP:
                is_on = not self._sight.lamp if order.value is None else bool(order.value)
                if self._has("lamp", "lights"):
                    await self._make_way()
                    await robot.lamp(is_on)
                    self._sight.lamp = is_on
            case Action.PEN:
                if self._has("pen", "pen"):
                    # The wheels stand meanwhile; whoever holds a key goes on wishing.
                    is_down = not robot.is_pen_down if order.value is None else bool(order.value)
                    await (robot.pen_down() if is_down else robot.pen_up())
            case Action.CLEAN:
                await robot.clean()
            case Action.RESUME:
                if robot.link_state == "stopped":
                    await robot.resume()
                    self._notices.tell("driving again")
            case _:
                await self._press(order)

    async def _press(self, order: Order) -> None:
        """WALTER's own keys. A speed that is set while it stands goes out with the key that starts it."""
        key = walter_key(order.action)
        moves_pen = order.action in (Action.RAISE_PEN, Action.LOWER_PEN)
        if self._walter is not None and key is not None and (moves_pen or self._is_driven):
            await self._walter.press(key)
            if not self._is_driven:
                self._stands()  # in direct control now
                self._is_sure = True

    async def _sound(self, *, on: bool) -> None:
        if on == self._horn:
            return
        await self._end_asking()
        await self._make_way()
        self._horn = self._sight.horn = on
        await self._robot.horn("low" if on else "off")

    async def _make_way(self) -> None:
        """For its lamp and its horn WALTER leaves direct control, and so stops; it goes on with the next key."""
        if self._walter is None:
            return
        if self._is_driven:
            await self._robot.drive(0.0, 0.0)
            self._stands()
            self.refused = self._wish.number
        self._is_sure = True  # one more stop would make it forget what it is to do

    def _has(self, feature: str, name: str) -> bool:
        if feature in self.features:
            return True
        self._notices.tell(f"this robot has no {name}")
        return False

    # ------------------------------------------------------------------ what people are told

    def _trouble(self, error: TurtlewireError, wish: Wish) -> None:
        """Whatever it is, the robot stands; what was wished meanwhile has to be wished for anew."""
        self._stands()
        if isinstance(error, StoppedError):  # by ourselves
            return
        self._is_sure = True
        self.refused = wish.number
        self._carried_out = None
        self._notices.tell_of(error)
        if isinstance(error, LinkClosedError):
            self.failure = error

    def _look(self) -> None:
        self.view = self._sight.look(self._notices.newest(), is_over=self.failure is not None)

    async def _keep_looking(self) -> None:
        while True:
            self._look()
            if self.view.link == "closed" and self.failure is None:
                self._checked_s = -math.inf  # which tells why
                self._wake.set()
            await asyncio.sleep(self._look_s)
