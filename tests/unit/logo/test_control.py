"""Control structures where the oracle cannot see: depth, places, state that is put back."""

from __future__ import annotations

import random
import sys
from typing import TYPE_CHECKING

import pytest

from turtlewire.logo import Interpreter, ScreenTurtle

if TYPE_CHECKING:
    from .conftest import Session


class DepthGauge(ScreenTurtle):
    """A turtle that knows how deep within Python its commands come."""

    def __init__(self) -> None:
        super().__init__()
        self.depths: list[int] = []

    def forward(self, distance_mm: float) -> None:
        frame, depth = sys._getframe(), 0
        while frame.f_back is not None:
            frame, depth = frame.f_back, depth + 1
        self.depths.append(depth)
        super().forward(distance_mm)


LAST_CALLS = {
    "macro": """
        .macro again :n :list
        if :n = 0 [output []]
        output sentence :list (list "again :n - 1 :list)
        end
        again 500 [fd 1]
        """,
    "goto": """
        to f
        make "i 0
        tag "next
        make "i :i + 1 fd 1
        if :i < 500 [goto "next]
        end
        f
        """,
    ".maybeoutput": """
        to f :n
        fd 1
        if :n = 1 [output "done]
        .maybeoutput f :n - 1
        end
        print f 500
        """,
    "cond": """
        to f :n
        fd 1
        cond [[[:n = 1] stop] [else f :n - 1]]
        end
        f 500
        """,
    "case": """
        to f :n
        fd 1
        case :n [[[1] stop] [else f :n - 1]]
        end
        f 500
        """,
}


def depths(program: str, *, compiles: bool) -> list[int]:
    """How deep within Python each FD of a program was."""
    turtle = DepthGauge()
    Interpreter(turtle, lambda _: None, random.Random(0), compiles=compiles).run(program)
    return turtle.depths


@pytest.mark.parametrize("program", LAST_CALLS.values(), ids=LAST_CALLS)
@pytest.mark.parametrize("compiles", [True, False], ids=["compiled", "evaluated"])
def test_the_last_call_takes_no_depth(program: str, *, compiles: bool) -> None:
    found = depths(program, compiles=compiles)
    assert len(found) == 500
    assert max(found) - min(found) < 15


def test_nor_does_one_in_a_list_that_was_computed() -> None:
    program = 'to f :n\nfd 1\nrun (list "g :n - 1)\nend\nto g :n\nif :n > 0 [f :n]\nend\nf 500'
    found = depths(program, compiles=False)
    assert len(found) == 500
    assert max(found) - min(found) < 15


def test_the_place_of_a_complaint_is_the_callers(session: Session) -> None:
    half = 'to half :n\nif :n = 0 [(throw "error [no half of 0])]\noutput :n / 2\nend\n'
    program = half + "to f\n\nprint 1 + half 0\nend\nf"
    error = session.error(program)
    assert (error.procedure, error.text) == ("f", "no half of 0")
    assert error.position is not None
    assert (error.position.line, error.position.column) == (7, 11)


def test_the_instruction_of_a_list_that_was_computed(session: Session) -> None:
    program = 'define "f [[x] [print :x] [print run list "sum :x]]\ncatch "error [f 3] show error'
    assert session.run(program) == '3\n[6 not enough inputs to sum f [print run list "sum :x]]\n'


def test_the_instruction_of_a_line_that_was_computed() -> None:
    program = 'make "line list "print "first define "f (list [] [print 1] (lput [] :line))\ncatch "error [f] show error'
    written: list[str] = []
    Interpreter(ScreenTurtle(), written.append, random.Random(0), compiles=False).run(program)
    assert "".join(written) == "1\n[7 first doesn't like [] as input f [print first []]]\n"


def test_goto_within_a_line_whose_words_are_defined_later(session: Session) -> None:
    program = (
        'to f\nmake "i 0\ndefine "later [[] [make "i :i + 1]] later tag "again later print :i\n'
        'if :i < 4 [goto "again]\nend\nf'
    )
    assert session.run(program) == "2\n3\n4\n"


def test_the_instruction_of_an_error_behind_such_a_tag(session: Session) -> None:
    program = (
        'to f\ndefine "later [[] [make "i 1]] later tag "again make "i :i + 1\nif :i < 3 [goto "again]\n'
        'print :nix\nend\ncatch "error [f] show last error'
    )
    assert session.run(program) == "[print :nix]\n"


def test_nested_templates_put_back_what_was_before(session: Session) -> None:
    program = 'foreach [a b] [catch "error [foreach [x y] [foreach [1 2] [first []]]] type (list ? # ?rest)]\nprint "'
    assert session.run(program) == "a 1 [b]b 2 []\n"
    assert (session.interpreter.slots, session.interpreter.iteration) == ([], None)


def test_a_lambda_puts_back_its_names_after_an_error(session: Session) -> None:
    assert (
        session.run('make "x 1 catch "error [apply [[x y] first :y] [2 []]] print :x print namep "y')
        == "1\nfalse\n"
    )


@pytest.mark.parametrize("compiles", [True, False])
def test_redefining_a_macro_as_a_procedure_and_back(compiles: bool) -> None:
    written: list[str] = []
    logo = Interpreter(ScreenTurtle(), written.append, random.Random(0), compiles=compiles)
    logo.run(
        "to f\nm\nend\n.macro m\noutput [print 1]\nend\nf\nto m\nprint 2\nend\nf\n.macro m\noutput [print 3]\nend\nf"
    )
    assert "".join(written) == "1\n2\n3\n"


def test_what_the_library_is_called_can_be_a_programs_own(session: Session) -> None:
    program = 'to remove :x\nprint list "mine :x\nend\nremove 5\nerase "remove\nshow remove 5 [4 5]'
    assert session.run(program) == "mine 5\n[4]\n"


def test_variables_that_are_there_from_the_beginning(session: Session) -> None:
    assert session.run("print (list :caseignoredp :logoversion :logoplatform) show names") == (
        "true 6.2 Unix-nographics\n[[] []]\n"
    )
