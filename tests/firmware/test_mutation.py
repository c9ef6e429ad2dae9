"""Mistakes in the core are noticed: a few of them here, all of them by ``make mutate``."""

from __future__ import annotations

import random

import pytest

from tools.mutation.core import FILES, Equivalent, Report, all_mutants, equivalents
from tools.mutation.operators import Mutant, lines, mutants
from tools.mutation.trial import Trials, Verdict

SAMPLE = 12


@pytest.mark.parametrize(
    ("code", "mutated"),
    [
        ("  if (count_ < LENGTH) {", {"  if (count_ <= LENGTH) {", "  if (count_ >= LENGTH) {"}),
        ("  ++count_;", {"  --count_;", "  "}),
        ("  return a && !b(c);", {"  return a || !b(c);", "  return a && b(c);"}),
        ("  x = y << 8U;", {"  x = y >> 8U;", "  x = y << 9U;", "  x = y << 7U;", "  "}),
        ("    case 'Q': return GROUP_Q;", {"    case 82: return GROUP_Q;"}),
        ("  return valid() ? A : B;", {"  return valid() ? B : A;"}),
        ("  return v >= 0.0F;", {"  return v > 0.0F;", "  return v < 0.0F;", "  return v >= 1.0F;"}),
        ("      case STOP: stop(); break;", {"      case STOP: break;", "      case STOP: stop();"}),
        ("  const uint8_t at = from;", set()),
        ("  uint8_t receive(uint8_t byte);", set()),
    ],
)
def test_what_may_become_of_a_line(code: str, mutated: set[str]) -> None:
    assert set(lines(code)) == mutated


def test_comments_and_directives_are_left_alone() -> None:
    assert mutants("f.h", "#include <a>\n// 1 + 1\nint x;\n  ++x;  // 1\n") == [
        Mutant("f.h", 4, "  ++x;", "  --x;"),
        Mutant("f.h", 4, "  ++x;", "  "),
    ]


@pytest.fixture(scope="module")
def trials(tmp_path_factory: pytest.TempPathFactory) -> Trials:
    return Trials(tmp_path_factory.mktemp("mutation"))


def test_a_sample_is_noticed(trials: Trials) -> None:
    listed = equivalents()
    every = [each for each in all_mutants() if not any(entry.matches(each) for entry in listed)]
    sample = random.Random(7).sample(every, SAMPLE)
    assert [each for each in sample if trials.try_out(each) is Verdict.SURVIVED] == []


def test_a_mutant_that_changes_nothing_survives_and_one_that_is_wrong_cpp_is_never_born(
    trials: Trials,
) -> None:
    original = next(each.original for each in all_mutants() if "++count_;" in each.original)
    line = next(
        each.line for each in all_mutants() if each.original == original and each.file == "simple.cpp"
    )
    assert trials.try_out(Mutant("simple.cpp", line, original, "  count_++;")) is Verdict.SURVIVED
    assert trials.try_out(Mutant("simple.cpp", line, original, "  count_+;")) is Verdict.STILLBORN
    assert trials.try_out(Mutant("simple.cpp", line, original, "  for (;;) {}")) is Verdict.KILLED


def test_the_list_of_those_that_change_nothing_is_up_to_date() -> None:
    every = all_mutants()
    for entry in equivalents():
        assert entry.file in FILES
        assert entry.reason
        for mutated in entry.mutated:
            assert any(entry._replace(mutated=(mutated,)).matches(each) for each in every), (entry, mutated)


def test_the_report() -> None:
    same = Mutant("a.h", 1, "  x = 1;", "  x = 2;")
    other = same._replace(line=2, original="  y = 1;", mutated="")
    listed = [Equivalent("a.h", "x = 1;", ("x = 2;",), "nobody reads it")]
    report = Report({same: Verdict.SURVIVED, other: Verdict.KILLED}, listed)
    assert report.is_good()
    assert report.data()["score"] == 1
    assert "2 mutants: 0 do not compile, 1 change nothing, 1 are noticed, 0 are not" in report.text()
    report = Report({same: Verdict.KILLED, other: Verdict.SURVIVED}, listed)
    assert not report.is_good()
    assert report.survivors() == [other]
    assert report.wrongly_listed() == [same]
    assert "a.h:2: y = 1;  ->  (deleted)" in report.text()
