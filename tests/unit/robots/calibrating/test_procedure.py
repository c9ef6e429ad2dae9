"""How a calibration goes: forwards, back, again, skipped; how it looks for a threshold and a time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from turtlewire.errors import UsageError
from turtlewire.robots.calibrating import (
    Choice,
    Outcome,
    Plan,
    Quantity,
    Question,
    SimulatedPerson,
    Trial,
    guide,
)
from turtlewire.robots.calibrating.procedure import LONGEST_S, TIME_S, Procedure, Progress

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from tests.unit.robots.calibrating.conftest import MakeBench
    from turtlewire.robots.calibrating.procedure import Trials

MOVED = Question(text="Did it?", quantity=Quantity.MOVED)


class Three(Procedure[None]):
    """Three trials; what comes of one is in the next."""

    STEPS = {"first": "two of them", "second": "one"}  # noqa: RUF012 - as its base class has it

    def lines(self) -> Mapping[str, Any]:
        return {}

    def _measure_first(self) -> Trials[None]:
        one = yield self._trial("one", "", lambda _: "reading", MOVED)
        two = yield self._trial(f"after {one.answers[0]}", "", lambda _: one.reading, MOVED)
        self._find("first", "", None, [f"{one} {two}"])

    def _measure_second(self) -> Trials[None]:
        three = yield self._trial("three", "", None, MOVED, MOVED)
        self._find("second", "", None, [str(three.answers)])


class Instead(NamedTuple):
    """What is wanted instead of a trial."""

    choice: Choice


class Script:
    """A person who does what stands in a list, and notes what was wanted."""

    def __init__(self, answers: list[Any]) -> None:
        self._answers = [*answers]
        self.seen: list[str] = []

    def begin(self, trial: Trial) -> Choice | None:
        self.seen.append(f"{trial.step}: {trial.does}")
        instead = isinstance(self._answers[0], Instead)
        return self._answers.pop(0).choice if instead else None

    def perform(self, act: Callable[..., object]) -> object:
        self.seen.append("acts")
        return act(lambda: None)

    def answer(self, question: Question) -> Any:
        return self._answers.pop(0)


def made(*steps: str) -> Progress:
    return Progress(lambda: Three(None, Plan(steps=frozenset(steps) or None)))


def test_trial_after_trial() -> None:
    person, progress = Script([True, False, True, None]), made()
    guide(progress, person)
    assert person.seen == ["first: one", "acts", "first: after True", "acts", "second: three"]
    assert progress.trial is None
    assert progress.procedure.found["second"].values == ("(True, None)",)
    assert "reading='reading'" in str(progress.procedure.found["first"].values)


def test_again_and_back() -> None:
    back = Instead(Choice.BACK)
    person = Script([True, Choice.REPEAT, True, back, False, True, Choice.BACK, True, True, True])
    progress = made()
    guide(progress, person)
    does = [line for line in person.seen if line != "acts"]
    assert does == [
        "first: one",
        "first: after True",
        "first: after True",  # repeated
        "second: three",
        "first: after True",  # back
        "second: three",
        "first: after True",  # back once more
        "second: three",
    ]
    # What was before is not done again.
    assert person.seen.count("acts") == 5
    assert "answers=(True,)" in str(progress.procedure.found["first"].values)


def test_back_from_the_first_is_the_first() -> None:
    person = Script([Instead(Choice.BACK), Choice.BACK, True, Choice.QUIT])
    progress = made()
    guide(progress, person)
    assert person.seen.count("first: one") == 3
    assert progress.trial is not None
    assert progress.procedure.found == {}


def test_what_is_skipped_is_not_done() -> None:
    person, progress = Script([Instead(Choice.SKIP), None, Instead(Choice.SKIP)]), made()
    guide(progress, person)
    assert person.seen.count("acts") == 1
    assert progress.procedure.found["second"].values == ("(None, None)",)


def test_only_some_steps() -> None:
    person, progress = Script([True, True]), made("second")
    guide(progress, person)
    assert person.seen == ["second: three"]
    with pytest.raises(UsageError, match="no step third; this robot has first, second"):
        made("third")


class Search(Procedure[None]):
    """Looks for something, and counts its questions."""

    STEPS = {"threshold": "", "time": ""}  # noqa: RUF012

    def __init__(self, low: int, high: int, guess: float, skip_at: int = -1) -> None:
        super().__init__(None, Plan())
        self.low, self.high, self.guess, self.asked, self.result = low, high, guess, 0, -1.0
        self._skip_at = skip_at

    def lines(self) -> Mapping[str, Any]:
        return {}

    def run(self, trials: Trials[Any], yes: Callable[[str], bool]) -> Any:
        trial = next(trials)
        while True:
            self.asked += 1
            answer = None if self.asked == self._skip_at else yes(trial.does)
            try:
                trial = trials.send(Outcome((answer,)))
            except StopIteration as end:
                return end.value

    def threshold(self, true: int) -> int | None:
        def ask(at: int) -> Trials[bool | None]:
            assert self.low < at < self.high
            return (yield from self._yes(self._trial(str(at), "", None, MOVED)))

        trials = self._threshold(self.low, self.high, self.guess, ask)
        found: int | None = self.run(trials, lambda text: int(text) >= true)
        return found

    def time(self, true_s: float) -> float | None:
        trials = self._time(self.guess, lambda at: self._trial(str(at), "", None, MOVED))
        found: float | None = self.run(trials, lambda text: float(text) < true_s)
        return found


@given(st.integers(0, 200), st.integers(2, 255), st.floats(-50.0, 300.0), st.data())
def test_thresholds(low: int, span: int, guess: float, data: st.DataObject) -> None:
    true = data.draw(st.integers(low + 1, low + span))
    search = Search(low, low + span, guess)
    assert search.threshold(true) == true
    assert search.asked <= 16


def test_a_good_guess_is_quick() -> None:
    search = Search(0, 200, 41.0)
    assert search.threshold(41) == 41
    assert search.asked == 2
    search = Search(0, 200, 41.0)
    assert search.threshold(52) == 52
    assert search.asked <= 8


@given(st.floats(0.0, 5.0), st.floats(0.0, 3.0))
def test_times(true_s: float, guess: float) -> None:
    search = Search(0, 1, guess)
    found = search.time(true_s)
    assert found is not None
    if true_s >= LONGEST_S:
        assert found == LONGEST_S
    else:
        # Rounded up, or to what is nearest where it is found at once.
        assert -1e-9 <= found - true_s <= TIME_S + 1e-9 or found == TIME_S
    assert search.asked <= 18


def test_looking_for_something_may_be_given_up() -> None:
    assert Search(0, 200, 41.0, skip_at=2).threshold(90) is None
    assert Search(0, 1, 0.5, skip_at=2).time(2.0) is None


@pytest.mark.parametrize("url", ["sim:simple", "sim:frame", "sim:frame?dialect=telemetry", "sim:walter"])
def test_one_can_go_back_from_anywhere(bench: MakeBench, url: str) -> None:
    """Every trial is gone back from once; what comes of it all is the same."""
    made_bench = bench(url)
    straight = made_bench.calibrated()
    progress = made_bench.progress()

    class Wavering(SimulatedPerson):
        """Goes back from each trial when it comes for the first time."""

        seen = 0

        def begin(self, trial: Trial) -> Choice | None:
            super().begin(trial)
            self.seen += 1
            return Choice.BACK if self.seen % 3 == 2 else None

    person = Wavering(made_bench.body)
    guide(progress, person)
    assert person.seen > 20
    assert list(progress.procedure.found) == list(straight.found)
    for name, finding in progress.procedure.found.items():
        new, old = finding.new, straight.found[name].new
        assert new == pytest.approx(old, rel=0.01, abs=0.02) if isinstance(new, float) else new == old


@pytest.mark.parametrize("url", ["sim:simple", "sim:frame", "sim:frame?dialect=telemetry", "sim:walter"])
@pytest.mark.parametrize("after", [0, 1, 5, 13, 30])
def test_skipped_from_somewhere_on_nothing_is_made_up(bench: MakeBench, url: str, after: int) -> None:
    made_bench = bench(url)
    progress = made_bench.progress()
    seen = 0

    class Tired(SimulatedPerson):
        """Skips all that comes later."""

        def begin(self, trial: Trial) -> Choice | None:
            nonlocal seen
            seen += 1
            return Choice.SKIP if seen > after else None

    guide(progress, Tired(made_bench.body))
    assert progress.trial is None
    if not after:
        assert not any(finding.values for finding in progress.procedure.found.values())
    # The simulated robots are as by default, so whatever was measured is that.
    for finding in progress.procedure.found.values():
        if (
            isinstance(finding.new, float)
            and isinstance(finding.old, float)
            and not finding.name.endswith("_s")
        ):
            assert finding.new == pytest.approx(finding.old, rel=0.01, abs=0.01)
