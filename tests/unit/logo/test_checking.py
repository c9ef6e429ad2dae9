"""What is found in a program without running it, where, and what is left in peace."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from turtlewire.logo.checking import check

ROOT = Path(__file__).resolve().parents[3]
# A program may have these and run.
HARMLESS = {"unused input", "unused local", "unreachable"}


def found(program: str) -> list[tuple[int, int, str, str]]:
    return [(*each.position[1:3], each.kind, each.message) for each in check(program, "test.logo")]


@pytest.mark.parametrize(
    ("program", "line", "column", "kind", "message"),
    [
        ("fd 10\n  forwrd 20", 2, 3, "unknown procedure", "I don't know how to forwrd"),
        ("print (sum 1 (frist [2]))", 1, 15, "unknown procedure", "I don't know how to frist"),
        ("repeat 4 [\n  if 1 = 2 [fdd 3]\n]", 2, 13, "unknown procedure", "I don't know how to fdd"),
        ("foreach [1 2] [prnt ?]", 1, 16, "unknown procedure", "I don't know how to prnt"),
        ("print map [squar ?] [1 2]", 1, 12, "unknown procedure", "I don't know how to squar"),
        ("f\nto f\nend", 1, 1, "unknown procedure", "I don't know how to f"),
        ("print :lenght", 1, 7, "no value", "lenght is never given a value"),
        ("to f :side\nfd :sid\nprint :side\nend", 2, 4, "no value", "sid is never given a value"),
        ("setxy 10", 1, 1, "inputs", "not enough inputs to setxy"),
        ("to f :a :b\nprint :a + :b\nend\nrepeat 2 [f 1]", 4, 11, "inputs", "not enough inputs to f"),
        ("print (first [1] [2])", 1, 8, "inputs", "too many inputs to first"),
        ("print 3 +", 1, 9, "inputs", "not enough inputs to +"),
        ("fd 10 20", 1, 7, "unused value", "You don't say what to do with 20"),
        ("to f :x\nprint 1\n:x\nend", 3, 1, "unused value", "You don't say what to do with :x"),
        ("repeat 2 [3 + 4]", 1, 13, "unused value", "You don't say what to do with what + outputs"),
        ("to f :a :b\nprint :a\nend", 1, 9, "unused input", "f never uses its input b"),
        ("to f [:a 5] [:rest]\nprint :a\nend", 1, 13, "unused input", "f never uses its input rest"),
        ('to f\nlocalmake "x 5\nend', 2, 11, "unused local", "f never uses its local x"),
        ('to f\nlocal "x\nmake "x 5\nend', 2, 7, "unused local", "f never uses its local x"),
        ("to f\nprint 1\nstop\nprint 2\nend", 4, 1, "unreachable", "stop comes before this: it is never run"),
        ("to f\nrepeat 3 [op 1 fd 2]\nend", 2, 16, "unreachable", "op comes before this: it is never run"),
        ("to f :n\nifelse :n = 1 [op 1] [stop]\nfd 2\nend", 3, 1, "unreachable", "ifelse comes before this"),
        ("if 1 = 1 [3 print 4]", 1, 11, "unused value", "You don't say what to do with 3"),
        ("print (map [[x y] forwrd :x] [1] [2])", 1, 19, "unknown procedure", "I don't know how to forwrd"),
        ("foreach [1 2] [[x] print :z]", 1, 26, "no value", "z is never given a value"),
        ("stop", 1, 1, "syntax", "Can only use stop inside a procedure"),
        ("print [", 1, 7, "syntax", "']' not found"),
        ("to f\nfd 1", 1, 1, "syntax", "END not found for f"),
        ("to print :x\nend", 1, 4, "syntax", "print is already defined"),
        ("to 5\nend", 1, 4, "syntax", "to doesn't like 5 as input"),
        ("print (1 + 2))", 1, 14, "syntax", "unexpected ')'"),
    ],
)
def test_what_is_found_and_where(program: str, line: int, column: int, kind: str, message: str) -> None:
    (one,) = found(program)
    assert one[:3] == (line, column, kind)
    assert one[3].startswith(message)


def test_hints() -> None:
    findings = check('make "length 5\nprint :lenght\nforwrd 10\nf\nto f\nend', "test.logo")
    assert [each.hint for each in findings] == [
        "Did you mean :length?",
        "Did you mean forward?",
        "It is defined later, in line 5: it must come before it is used.",
    ]
    assert findings[0].explain() == (
        "test.logo, line 2, column 7: lenght is never given a value\n"
        "    print :lenght\n          ^\nDid you mean :length?"
    )


@pytest.mark.parametrize(
    "program",
    [
        # Dynamic scope: the caller's variables.
        "to f :x\ng\nend\nto g\nprint :x\nend\nf 3",
        'to f\nlocalmake "x 5\ng\nend\nto g\nprint thing "x\nend\nf',
        # Lists that may be run, by somebody.
        "to f :x\nprint run [:x]\nend\nto twice :list\nrun :list run :list\nend\ntwice [fd 1]",
        "to f :x\nh [print :x]\nend\nto h :list\nrun :list\nend",
        'make "data [forwrd :backwrd (]\nprint :data',
        # Names that are made while it runs.
        'define "f [[x] [print :x]]\nf 3\nprint f f f 4 5',
        'to maker :name\ndefine :name [[] [fd 1]]\nend\nmaker "g\ng',
        'load "other.logo\nsomething 1 2 3 :elsewhere',
        'make word "a "b 5\nprint :ab',
        'copydef "ahead "forward\nahead 10',
        "to f :a\nprint :a\nend\nf 1\nto f :a :b\nprint :a + :b\nend\nf 1 2",
        # Getters and setters, loops, templates, special variables.
        'make "size 5\nprint size\nsetsize 6\nprint :size',
        "to f :x\nprint x\nend",
        "for [i 1 3] [print :i]",
        'foreach [1 2] [[n] [local "m] [print :n]]',
        "print (map [[x y] :x * :y] [1 2] [3 4])",
        'to f :n\nlocal [a b]\nmake "a :n\nmake "b :a\nprint :b\nend',
        "print :commandline",
        'to f\nlocalmake "caseignoredp "false\nprint "a = "A\nend',
        'catch "error [forwrd 10]\nprint error',
        'make "redefp "true\nto print :x\ntype :x\nend',
        # What only looks like left over, or unreachable.
        "print if 1 = 1 [3] [4]",
        "print run [3]",
        "to f :n\nif :n = 1 [stop]\nprint :n\nif :n = 2 [output 3] [print 4]\nend",
        'to f\ngoto "there\ntag "there\nprint 1\nend',
        'to f :n\nif :n [output 1]\noutput 2\nend\nprint f "true',
    ],
)
def test_what_cannot_be_known_is_not_reported(program: str) -> None:
    assert found(program) == []


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.logo")), ids=lambda path: path.stem)
def test_the_examples_are_clean(path: Path) -> None:
    assert check(path.read_text("utf-8"), path.name) == []


def test_no_false_alarms_on_programs_that_run() -> None:
    programs = findings = 0
    for path in sorted((ROOT / "tests" / "vectors" / "logo").glob("*.json")):
        for case in json.loads(path.read_text("utf-8"))["cases"]:
            expected = case["ours"] if "differs" in case else case
            # A program may want an error.
            if expected["error"] is None and '"error' not in case["program"].lower():
                programs += 1
                alarms = [
                    each for each in check(case["program"] + "\n", case["id"]) if each.kind not in HARMLESS
                ]
                assert alarms == []
            elif expected["error"] is not None:
                findings += bool(check(case["program"] + "\n", case["id"]))
    assert programs > 900
    assert findings > 200


@pytest.mark.parametrize(("opened", "closed"), [("repeat 2 [", "]"), ("(", ")")])
def test_what_is_nested_too_deep_is_told(opened: str, closed: str) -> None:
    (finding,) = check(f"{opened * 20_000} 1 {closed * 20_000}", "deep.logo")
    assert (finding.position.line, finding.kind) == (1, "syntax")
    assert "too deep" in finding.message
