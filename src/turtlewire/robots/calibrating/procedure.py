"""A calibration as it goes: trial after trial, forwards and back; who measures is somebody else's business."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Generator
from enum import Enum, auto
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Protocol, TypeVar

from turtlewire.errors import DataError, UsageError
from turtlewire.robots.calibrating.arithmetic import rounded
from turtlewire.robots.calibrating.trials import Finding, Outcome, Trial

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from turtlewire.robots.calibrating.trials import Answer, Plan, Question, Signal

T = TypeVar("T")
RobotT = TypeVar("RobotT")
# What makes trials, is sent what came of each, and ends with what it has found out.
Trials = Generator[Trial, Outcome, T]

# After a motion, so long nobody measures: the robot comes to rest.
REST_S = 1.0
# A drive takes no less and no more than this: a clock is not exact, and nobody wants to wait.
LEAST_S, MOST_S = 0.2, 8.0
# A short drive is no longer than this part of a long one.
SHORTER = 0.4
# A robot of which nothing is known yet is first driven so far, as a part of the space: it may be three times as fast.
FIRST_PART = 0.25
# How much an answer may differ from what was expected: by these factors while nothing is known, while only other
# motions are, and when the same was measured before.
UNKNOWN = (0.2, 5.0)
LIKELY = (0.4, 2.5)
KNOWN = (0.75, 1.33)
# Times are found out to this, in seconds; none is longer than that.
TIME_S = 0.01
LONGEST_S = 2.56


class Choice(Enum):
    """What a person wants instead of going on."""

    SKIP = auto()
    REPEAT = auto()
    BACK = auto()
    QUIT = auto()


class Procedure(ABC, Generic[RobotT]):
    """The steps of one robot's calibration.

    Args:
        robot: to be calibrated.
        plan: how to go about it.

    Attributes:
        STEPS: what there is, by name, in order.
        found: what was measured so far, by name.
    """

    STEPS: ClassVar[dict[str, str]] = {}

    def __init__(self, robot: RobotT, plan: Plan) -> None:
        unknown = (plan.steps or frozenset()) - set(self.STEPS)
        if unknown:
            raise UsageError(
                f"there is no step {', '.join(sorted(unknown))}; this robot has {', '.join(self.STEPS)}"
            )
        self.robot = robot
        self.plan = plan
        self.found: dict[str, Finding] = {}
        self._step = ""

    def trials(self) -> Trials[None]:
        """All trials of all steps that are planned."""
        for name in self.STEPS:
            if self.plan.steps is None or name in self.plan.steps:
                self._step = name
                restore = self._keep()
                try:
                    yield from getattr(self, f"_measure_{name}")()
                except (DataError, ArithmeticError) as error:
                    restore()
                    why = error if isinstance(error, DataError) else "the numbers contradict one another"
                    text = f"What was measured in this step makes no robot, and is left out: {why}"
                    yield self._trial(text, "", None)

    def _keep(self) -> Callable[[], None]:
        """What takes back whatever is found from now on."""
        found = dict(self.found)

        def restore() -> None:
            self.found = found

        return restore

    @abstractmethod
    def lines(self) -> Mapping[str, Any]:
        """What was found, as lines of the robot's table in ``robots.toml``; None: there is to be no such line."""

    # ------------------------------------------------------------------ for the steps

    def _trial(
        self, does: str, needs: str, act: Callable[[Signal], object] | None, *questions: Question
    ) -> Trial:
        return Trial(step=self._step, does=does, needs=needs, act=act, questions=questions)

    def _find(self, name: str, unit: str, old: float | str | None, values: Iterable[float | str]) -> None:
        self.found[name] = Finding(name, unit, old, tuple(values))

    def _changed(self, name: str, present: Any) -> Any:
        """The value that was found, rounded to what is known of it; the present one if it was not measured."""
        finding = self.found.get(name)
        if finding is None or finding.new is None:
            return present
        return rounded(finding.new) if isinstance(finding.new, float) else finding.new

    def _time(self, present_s: float, trial: Callable[[float], Trial]) -> Trials[float | None]:
        """How long something takes, by trying: was it still moving when the bell rang, so many seconds after?

        First at the present value, then twice as late until it is over, then half way between. None: skipped.
        """
        still, over = 0, 0  # in hundredths, as far as known
        longest = round(LONGEST_S / TIME_S)
        at = min(longest, max(1, round(present_s / TIME_S)))
        while True:
            moves = (yield trial(at * TIME_S)).answers[0]
            if moves is None:
                return None
            still, over = (at, over) if moves else (still, at)
            if not over and at >= longest:
                return LONGEST_S
            if over and over - still <= 1:
                return over * TIME_S
            at = (still + over) // 2 if over else min(longest, 2 * at)

    def _threshold(
        self, low: int, high: int, guess: float, ask: Callable[[int], Trials[bool | None]]
    ) -> Trials[int | None]:
        """The lowest whole number at which the answer is yes: it is no at ``low``, and yes at ``high``.

        It is looked for around a guess: further and further from it, until it has been passed; then half way between.
        None: skipped.
        """
        at, stride, strides, last = min(high - 1, max(low + 1, round(guess))), 1, True, None
        while high - low > 1:
            answer = yield from ask(at)
            if answer is None:
                return None
            low, high = (low, at) if answer else (at, high)
            strides, last = strides and last in (None, answer), answer
            at, stride = at - stride if answer else at + stride, 2 * stride
            if not strides or not low < at < high:
                at = (low + high) // 2
        return high

    def _yes(self, trial: Trial) -> Trials[bool | None]:
        """The answer to the only question of a trial, which is yes or no; None: skipped."""
        answer = (yield trial).answers[0]
        return None if answer is None else bool(answer)


def numbers(answers: Sequence[Answer]) -> list[float] | None:
    """Answers that are numbers; None if any of them was skipped."""
    found = [float(answer) for answer in answers if isinstance(answer, float | int)]
    return found if len(found) == len(answers) else None


def short_and_long(short_s: float, long_s: float) -> tuple[float, float]:
    """Two durations, each within what is sensible, that differ enough to tell a rate by."""
    long_s = round(min(MOST_S, max(LEAST_S, long_s)), 2)
    return round(min(max(LEAST_S / 2.0, short_s), SHORTER * long_s), 2), long_s


class Person(Protocol):
    """Whoever measures."""

    def begin(self, trial: Trial) -> Choice | None:
        """Tell what comes; None: go ahead, else ``SKIP``, ``BACK`` or ``QUIT``."""

    def perform(self, act: Callable[[Signal], object]) -> object | Choice:
        """Let the robot do it, and return what it returns; ``REPEAT`` if the robot was stopped meanwhile."""

    def answer(self, question: Question) -> Answer | Choice:
        """The answer; None: skipped. ``REPEAT`` the whole trial, ``BACK`` or ``QUIT``."""


class Progress:
    """How far a procedure is: it goes on with what comes of each trial, and back by doing all before anew, unseen.

    Args:
        make: makes a new procedure; with the same outcomes it has the same trials.

    Attributes:
        procedure: the one under way.
        trial: the present trial; None: it is over.
    """

    def __init__(self, make: Callable[[], Procedure[Any]]) -> None:
        self._make = make
        self._outcomes: list[Outcome] = []
        self._restart()

    def _restart(self) -> None:
        self.procedure = self._make()
        self._trials = self.procedure.trials()
        self.trial: Trial | None = next(self._trials, None)
        for outcome in self._outcomes:
            self._send(outcome)

    def _send(self, outcome: Outcome) -> None:
        try:
            self.trial = self._trials.send(outcome)
        except StopIteration:
            self.trial = None

    def record(self, outcome: Outcome) -> None:
        """This came of the present trial: on to the next."""
        self._outcomes.append(outcome)
        self._send(outcome)

    def back(self) -> bool:
        """Back to the trial before; False: there is none."""
        if not self._outcomes:
            return False
        self._outcomes.pop()
        self._restart()
        return True


def guide(progress: Progress, person: Person) -> None:
    """Have a person measure trial after trial, to the end, or until there is enough."""
    while progress.trial is not None:
        outcome = _made(progress.trial, person)
        if outcome is Choice.QUIT:
            return
        if isinstance(outcome, Choice):
            progress.back()
        else:
            progress.record(outcome)


def _made(trial: Trial, person: Person) -> Outcome | Choice:
    """What came of a trial, made as often as the person wants; ``BACK`` or ``QUIT`` if that is wanted instead."""
    while True:
        choice = person.begin(trial)
        if choice is Choice.SKIP:
            return Outcome((None,) * len(trial.questions))
        if choice is not None:
            return choice
        reading = person.perform(trial.act) if trial.act is not None else None
        if reading is Choice.REPEAT:
            continue
        answers: list[Answer] = []
        for question in trial.questions:
            answer = person.answer(question)
            if answer is Choice.REPEAT:
                break
            if isinstance(answer, Choice):
                return answer
            answers.append(answer)
        else:
            return Outcome(tuple(answers), reading)
