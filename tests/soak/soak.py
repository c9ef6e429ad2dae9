"""What every soak does: one thing after the other with a driver and its robot, checked against a model after each."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import Counter, deque
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from tests.soak.domains import FLAG, Domain, Real, one_of, rule
from tests.soak.report import Report
from tests.soak.wire import AnyRobot, End, Mischief, Tap, ViolationError
from turtlewire.errors import LinkClosedError, LinkLostError, NoReplyError, TurtlewireError
from turtlewire.links.memory import MemoryLink
from turtlewire.robots.runner import InlineRunner

if TYPE_CHECKING:
    from collections.abc import Coroutine

    from turtlewire.links.faults import Faults

T = TypeVar("T")
# No command takes longer than this, whatever happens to its bytes: all distances and angles here are small.
LONGEST_STEP_S = 400.0
# So often a connection is tried again. The way back into step fails now and then, if every tenth byte gets lost.
CONNECT_ATTEMPTS = 40
# How much of what led there is told of a violation.
STORY_STEPS = 12
STORY_LETTERS = 90


class Soak(ABC):
    """One robot, its driver, the wire between, and what must hold.

    Args:
        seed: of chance on the wire.
        faults: what goes wrong there.
        setup: settings, each of its domain in ``SETUP``.

    Attributes:
        report: what has been seen so far.
        error: what the last step raised; notes: how many things people were told in it.
        hurt: the numbers of the bytes that have not arrived as they were sent.
    """

    SETUP: ClassVar[dict[str, Domain]] = {"resets_when_opened": FLAG, "boot_s": one_of(0.02, 0.3, 1.0)}
    # The protocol's own name for it.
    NAME: ClassVar[str]

    def __init__(self, seed: int, faults: Faults, **setup: Any) -> None:
        self.report = Report(self.NAME)
        self.report.lives = 1
        self.setup = setup
        self.error: TurtlewireError | None = None
        self.notes = 0
        self._seed, self._faults = seed, faults
        self._story: deque[str] = deque(maxlen=STORY_STEPS)
        self._runner = InlineRunner()
        self._stop_after_s = math.inf
        self._stop_when_told = False
        # What went wrong on the wire besides bytes, counted.
        self._disturbances = 0
        # Until when the wire or the robot is held up.
        self.unrest_until_s = 0.0
        # When something last happened that nobody could notice.
        self.uncatchable_s = -math.inf
        self.end = End(self.new_robot())
        self.end.on_open = self._opened_again
        self._without_host(self.setup["boot_s"])
        self.hurt = self.end.hurt
        self._links = 0
        self._bytes_sent = 0
        self._counted: Counter[tuple[str, str]] = Counter()
        self._connect()

    # ------------------------------------------------------------------ what each robot does its own way

    driver: Any

    @abstractmethod
    def new_robot(self) -> AnyRobot:
        """A robot that has just been switched on."""

    @abstractmethod
    def new_driver(self, link: Tap) -> Any:
        """A driver for it, and a model that begins anew."""

    @abstractmethod
    def robot_was_reset(self) -> None:
        """The robot was switched off and on: it knows nothing any more."""

    @abstractmethod
    def before_step(self, name: str) -> None:
        """Remember what the check afterwards compares with."""

    @abstractmethod
    def check(self) -> None:
        """What must hold after each step."""

    @abstractmethod
    def is_at_rest(self) -> bool:
        """Whether the robot neither moves nor will."""

    def check_stands(self, why: str) -> None:
        """The robot was stopped, and stands."""
        if not self.is_at_rest():
            raise ViolationError(f"{why}, but it moves")

    # ------------------------------------------------------------------ the wire

    def _connect(self) -> None:
        for attempt in range(CONNECT_ATTEMPTS):
            self._count_faults()
            self._links += 1
            faults = self._faults._replace(seed=self._seed + self._links, close_at_s=math.inf)
            self.mischief = Mischief(MemoryLink(self.end), faults)
            self.mischief.hurt = self.hurt
            self.tap = Tap(self.mischief, self._bytes_sent)
            self.driver = self.new_driver(self.tap)
            self.tap.latest_s = self.now + LONGEST_STEP_S
            try:
                self._runner.run(self.driver.connect())
                return
            except NoReplyError:
                if attempt == CONNECT_ATTEMPTS - 1:
                    raise
                self.report.errors["NoReplyError at connect"] += 1

    def _count_faults(self) -> None:
        """Faults are counted by link; keep them."""
        if self._links:
            self._disturbances += self.mischief.count
            self._counted += self.mischief.done
            self._bytes_sent = self.report.bytes_to_robot = self.tap.sent

    @property
    def damage(self) -> int:
        """How many things have gone wrong on the wire since the beginning."""
        return self._disturbances + self.mischief.count

    @property
    def _is_quiet(self) -> bool:
        """Whether nothing is on its way to the robot."""
        return self.end.is_quiet and self.mischief.is_quiet

    @property
    def now(self) -> float:
        """Virtual seconds."""
        return self.end.now

    # ------------------------------------------------------------------ steps

    def step(self, name: str, **inputs: Any) -> None:
        """Do something, whatever comes of it, and check what must hold."""
        told = ", ".join(f"{key}={value!r}" for key, value in inputs.items())
        self._story.append(f"{self.now:.4f} s  {name}({told})")
        self.report.steps += 1
        self.error = None
        self.notes = 0
        self.tap.latest_s = self.now + LONGEST_STEP_S
        if self._stop_after_s < math.inf and name not in ("stop_during", "rest"):
            self.tap.at(self._stop_after_s, self._stop_now)
            self._stop_after_s = math.inf
        try:
            self.before_step(name)
            try:
                getattr(self, name)(**inputs)
            except TurtlewireError as error:
                self.error = error
                self.report.errors[type(error).__name__] += 1
                self._story.append(
                    f"{self.now:.4f} s    {type(error).__name__}: {str(error)[:STORY_LETTERS]}"
                )
            self.tap.forget_acts()
            self.check()
        except ViolationError as violation:
            raise ViolationError(f"{violation}\n{self._told()}") from violation
        except RuntimeError as error:
            raise ViolationError(f"the host hangs: {error}\n{self._told()}") from error
        if isinstance(self.error, LinkClosedError):
            self._connect()

    def _told(self) -> str:
        return "\n".join([f"{self.NAME}, seed {self._seed}, {self.setup}", *self._story])

    def do(self, coroutine: Coroutine[object, None, T]) -> T:
        """Run one command of the driver."""
        self.report.commands += 1
        return self._runner.run(coroutine)

    def _stop_now(self) -> None:
        """``stop``, from within: somebody else's task, or a callback."""
        self.report.stops += 1
        try:
            self._runner.run(self.driver.stop())
        except TurtlewireError as error:
            self.report.errors[type(error).__name__] += 1

    def notify(self, text: str) -> None:
        """What the driver tells people."""
        self.notes += 1
        self.report.notices += 1
        self._story.append(f"{self.now:.4f} s    told: {text[:STORY_LETTERS]}")
        if self._stop_when_told:
            self._stop_when_told = False
            self._stop_now()

    def uncatchable(self, kind: str) -> None:
        """Something that this wire cannot notice: counted."""
        self.report.uncatchable[kind] += 1
        self.uncatchable_s = self.now
        self._story.append(f"{self.now:.4f} s    uncatchable: {kind}")

    def finish_life(self) -> Report:
        """Let go of the robot; whatever the noise, it is stopped then. Returns the report."""
        self.step("let_go", finish=True)
        self._count_faults()
        self._links = 0
        self.report.faults = Counter({f"{to}: {fault}": n for (to, fault), n in self._counted.items()})
        self.report.virtual_s = self.now
        return self.report

    # ------------------------------------------------------------------ rules that all robots have

    @rule(weight=3.0)
    def stop(self) -> None:
        """Stop, between two commands."""
        self.report.stops += 1
        self.do(self.driver.stop())

    @rule(weight=3.0, after_s=Real(0.0, 0.5), seconds=Real(1.0, 3.0))
    def drive_stop_and_watch(self, after_s: float, seconds: float) -> None:
        """Stop what drives by hand, and see that it stands, and stays so."""
        self.do(self.driver.drive(0.8, 0.1))
        self._runner.run(self.pause(after_s))
        self.report.stops += 1
        self.do(self.driver.stop())
        self._runner.run(self.pause(seconds))
        if self._is_quiet and self.now > self.unrest_until_s + seconds:
            self.check_stands("it was stopped")

    @rule(weight=3.0, after_s=Real(0.0, 2.0))
    def stop_during(self, after_s: float) -> None:
        """Stop, in the middle of the next command that lasts so long."""
        self._stop_after_s = after_s

    @rule(weight=0.3)
    def stop_when_told(self) -> None:
        """Stop from the callback that is told something next."""
        self._stop_when_told = True

    @rule(weight=3.0, seconds=Real(0.0, 3.0))
    def rest(self, seconds: float) -> None:
        """Let the host do what it does by itself for a while."""
        self._runner.run(self.pause(seconds))

    async def pause(self, seconds: float) -> None:
        """Let the host do what it does by itself."""
        await self.driver._pause(seconds)

    @rule(weight=1.0, finish=FLAG)
    def let_go(self, finish: bool) -> None:
        """Let go of the robot, whose time goes on without a host; then come back."""
        damage = self.damage
        try:
            self.do(self.driver.close(finish=finish))
        finally:
            self._without_host(2.0)
            if not self.is_at_rest():
                if damage == self.damage and self.now > self.unrest_until_s + 2.0:
                    raise ViolationError("the robot was let go of, and drives on")
                self.uncatchable("the stop at parting was damaged, or held up")
                self._without_host(60.0)
            self._connect()

    def _without_host(self, seconds: float) -> None:
        until = self.now + seconds
        while self.now < until:
            self.end.read(until)

    @rule(weight=0.4, gone_s=one_of(0.0, 0.02, 0.5, 4.0, 60.0))
    def lose_link(self, gone_s: float) -> None:
        """The link ends, for longer than anybody tries now and then; something notices it."""
        self.mischief.end_now(gone_s)
        self._disturbances += 1
        self.report.links_lost += 1
        self._runner.run(self.pause(0.01))

    @rule(weight=2.0)
    def come_back(self) -> None:
        """Wait for a link that was lost; nothing moves then, until somebody says so."""
        driver = self.driver
        if driver.link_state == "connected":
            return
        before = driver.statistics.reconnections
        self.do(driver.reconnected())
        self.report.reconnections += driver.statistics.reconnections - before
        self.check_stands("the robot was reached again and stopped")
        try:
            self.do(driver.forward(50.0))
        except LinkLostError:
            pass
        else:
            raise ViolationError("motion goes on after a lost link, and nobody has said so")
        self._runner.run(self.pause(0.3))
        self.check_stands("the robot was reached again and stopped")
        self.do(driver.resume())
        if driver.link_state != "connected":
            raise ViolationError(f"after resume() the link is {driver.link_state}")

    @rule(weight=0.3)
    def reset(self) -> None:
        """Somebody presses the robot's reset button."""
        self._disturbances += 1
        self.unrest_until_s = max(self.unrest_until_s, self.now + self.setup["boot_s"])
        self.report.resets += 1
        self.end.reset()
        self.robot_was_reset()

    def _opened_again(self) -> None:
        """Opening the port resets most robots (section 4)."""
        if self.setup["resets_when_opened"]:
            self.reset()

    @rule(weight=0.5, seconds=one_of(0.005, 0.02, 0.1, 0.7))
    def stall(self, seconds: float) -> None:
        """Nothing gets through for a while."""
        self._disturbances += 1
        self.unrest_until_s = max(self.unrest_until_s, self.now + seconds)
        self.report.stalls += 1
        self.mischief.stall(seconds)

    @rule(
        weight=1.0,
        to=one_of("robot", "host"),
        after=one_of(*range(20)),
        fault=one_of("lose", "flip", "add", "duplicate"),
    )
    def one_fault(self, to: str, after: int, fault: str) -> None:
        """Something happens to one byte."""
        self.mischief.plan(to, after, fault)

    @rule(weight=0.0, rate=one_of(0.0, 0.002, 0.01, 0.03))
    def noise(self, rate: float) -> None:
        """From now on, bytes fare better, or worse."""
        self.mischief.change(lose=rate / 3, add=rate / 3, flip=rate / 3)
        self._faults = self.mischief.faults._replace(stalls=())
