"""How programs are laid out; that their meaning stays is also in tests/property."""

from __future__ import annotations

import json
import random
from pathlib import Path

import pytest

from turtlewire.logo import Interpreter, LogoError, ScreenTurtle
from turtlewire.logo.formatting import formatted
from turtlewire.logo.unfinished import is_unfinished

ROOT = Path(__file__).resolve().parents[3]
BEFORE = """\
#!/usr/bin/env -S turtlewire logo
; spirals


to Spiral   :side ; gets larger
if :side>200 [stop]   ; then
    FD :side*2-1   RT 360/:corners ; each
repeat 2 [ if :side=3 [
print [a+b  c]
]  ]
   ; alone
print (sum :a
:b  -3)
make "x  {1  2}@0
end
print 3 -2 print 3-2 print ( -(4+1) )
print "over~
load
print "a ~
"b
type |two  words
and a line|
"""
AFTER = """\
#!/usr/bin/env -S turtlewire logo
; spirals


to Spiral :side   ; gets larger
  if :side > 200 [stop] ; then
  FD :side * 2 - 1 RT 360 / :corners ; each
  repeat 2 [if :side = 3 [
    print [a+b c]
  ]]
  ; alone
  print (sum :a
    :b -3)
  make "x {1 2}@0
end
print 3 -2 print 3 - 2 print (-(4 + 1))
print "over~
load
print "a ~
  "b
type |two  words
and a line|
"""


def test_layout() -> None:
    assert formatted(BEFORE) == AFTER


def test_twice_changes_nothing() -> None:
    assert formatted(AFTER) == AFTER


def test_words_in_lists_begin_and_end_no_procedure() -> None:
    text = "print [\n  to\n  end\n  to f\n]\nto f\n  print [to\n    be]\n  print 1 ~\n    end\nend\n"
    assert formatted(text.replace("  ", "")) == text


def test_a_tilde_that_is_a_word() -> None:
    assert formatted("print   :x ~  \nprint   2\n") == "print :x ~ \nprint 2\n"


def test_what_cannot_be_read_is_an_error() -> None:
    with pytest.raises(LogoError, match="not found"):
        formatted("print [", "wrong.logo")


def outcome(program: str) -> object:
    written: list[str] = []
    try:
        Interpreter(ScreenTurtle(), written.append, random.Random(0)).run(program, "case.logo")
    except LogoError as error:
        return written, error.number, error.text, error.procedure
    return written


# What shows a program as it is written, or where in it something is.
SHOWN = ("po", "text", "edit", "error", "save", "trace")


def test_laid_out_programs_do_what_they_did(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # for the files that programs write
    compared = 0
    for path in sorted((ROOT / "tests" / "vectors" / "logo").glob("*.json")):
        for case in json.loads(path.read_text("utf-8"))["cases"]:
            program = case["program"] + "\n"
            try:
                laid_out = formatted(program)
            except LogoError:
                continue
            if laid_out == program or any(word in program.lower() for word in SHOWN):
                continue
            compared += 1
            assert outcome(laid_out) == outcome(program), case["id"]
    assert compared > 200


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.logo")), ids=lambda path: path.stem)
def test_the_examples_are_laid_out(path: Path) -> None:
    text = path.read_text("utf-8")
    assert formatted(text) == text


@pytest.mark.parametrize(
    ("text", "is_open"),
    [
        ("", False),
        ("fd 10", False),
        ("to f", True),
        ("to f\nfd 10", True),
        ("to f\nfd 10\nend", False),
        ("repeat 4 [fd 10", True),
        ("repeat 4 [fd 10\nrt 90]", False),
        ("print (sum 1", True),
        ("print |a", True),
        ("print {1 2", True),
        ("print 1 ~", True),
        ("print ]", False),
        ("print [ ]]", False),
        ("to f\nrepeat 4 [\nend", False),
    ],
)
def test_unfinished(text: str, is_open: bool) -> None:
    assert is_unfinished(text) is is_open
