from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from turtlewire.errors import ProgramError
from turtlewire.logo.errors import LogoError, Position

if TYPE_CHECKING:
    from .conftest import Session


def test_the_paragraph_for_people(session: Session) -> None:
    error = session.error("to spiral :n\n\tfoward :n\nend\nspiral 3")
    assert isinstance(error, ProgramError)
    assert error.text == "I don't know how to foward"
    assert (
        error.explain()
        == str(error)
        == (
            "test.logo, line 2, column 2: I don't know how to foward in spiral\n"
            "    \tfoward :n\n    \t^\nDid you mean forward?"
        )
    )


def test_a_variable_that_is_nearly_known(session: Session) -> None:
    error = session.error('make "length 3\nprint :lenght')
    assert str(error).endswith("Did you mean :length?")
    assert "Did you mean" not in str(session.error("print :zzz"))


def test_without_a_place() -> None:
    assert str(LogoError(21, "Oops")) == "Oops"
    assert str(LogoError(21, "Oops", hint="Do this.")) == "Oops\nDo this."
    assert str(LogoError(21, "Oops", Position("a", 1, 1, "x"))) == "a, line 1, column 1: Oops\n    x\n    ^"


def test_the_same_failure_twice(session: Session) -> None:
    program = 'repeat 2 [catch "error [f]]\nf'
    error = session.error("to f\nprint sum 1\nend\n" + program)
    assert (error.number, error.procedure) == (6, "f")
    assert error.position is not None
    assert (error.position.line, error.position.column) == (2, 7)


def test_a_place_from_an_outer_list(session: Session) -> None:
    error = session.error('print 1\nrun (list "first [])')
    assert error.position is not None
    assert (error.position.line, error.position.column) == (2, 1)


@pytest.mark.parametrize(
    ("program", "hint"),
    [
        ("fd", "fd takes 1 input."),
        ("print 3 +", "+ needs a value on each side of it."),
        ("print (pos 1)", "pos takes no inputs."),
        ("print setxy 1", "setxy takes 2 inputs."),
        ("to sq :s [:n 4] [:r]\nend\nsq", "sq takes 1 input; it is defined as: to sq :s [:n ...] [:r]"),
        ("to sq :s\nend\n(sq 1 2)", "sq takes 1 input; it is defined as: to sq :s"),
        ('fd "ten', "fd wants a number."),
        ("repeat 1.5 []", "repeat wants a whole number."),
        ("repeat -1 []", "repeat wants a whole number, 0 or more."),
        ("print uppercase [a]", "uppercase wants a word, and no list."),
        ("print firsts 3", "firsts wants a list in brackets."),
        ("if 5 [fd 1]", "if wants true or false, as a comparison outputs it."),
        ("setpos 3", "setpos wants a list of two numbers, as in [30 40]."),
        ("print first []", "first wants a word or list with something in it."),
        ("print item 5 [a b]", "item wants a place from 1 to 2."),
        ('print ascii "ab', "ascii wants a single letter."),
        ("print 1 / 0", "/ wants a number other than 0."),
        ("print sqrt -1", "sqrt wants a number for which there is a result, and not too large a one."),
        ("print power 10 400", "power wants a number for which there is a result, and not too large a one."),
        ("print bitand 1.5 1", "bitand wants a whole number."),
        ("setspeed 999", "setspeed wants a speed from 1 to 255."),
        ("wait -1", "wait wants a number of sixtieths of a second, 0 or more."),
        ("onlimit 3", "onlimit wants a list of instructions, or [] for none."),
        ("for 3 []", "for wants a list of a name, a start, an end and perhaps a step: [i 1 10 2]."),
        ("repeat 4 fd 10", "fd gives it none. Instructions for later stand in brackets: [ ]."),
        ("print fd 3", "print needs a value here, and fd gives it none."),
        ("3 + 4", "put one before it, such as PRINT, or take the value away."),
        ("output 3", "output ends the procedure that it stands in, and here none is running."),
        ("stop", "stop ends the procedure that it stands in, and here none is running."),
        ("iftrue []", "A TEST with a condition must come before it in the same procedure."),
        ("iffalse []", "A TEST with a condition must come before it in the same procedure."),
        ("print 3)", "This ) has no ( before it, or nothing between them."),
        ("print 3]", "This ] has no [ before it."),
        ("print (3 [4])", "Parentheses hold one value, or one procedure with all of its inputs."),
        ("to f\nend f", "END stands in a line of its own."),
        ("to sq (:n)\nend", "the instructions begin in the next line."),
        ("to :sq\nend", "to wants a name, without any sign before it or behind it."),
        ("print :x", 'Give it one first: make "x 5'),
        ("setpc 3", "its colour and size cannot be changed from a program."),
        ("if 1 = 1 then [fd 1]", 'IF needs no THEN: if :n > 3 [print "big]'),
        ("fd, 10", "Did you mean fd? Nothing but spaces stands between words."),
        ("print 'hi'", 'A word is written with one straight quote before it and none behind: "hi'),
        ("fd:x", "A space is missing after fd."),
        ("forwrd 10", "Did you mean forward?"),
        ("qqq", "a new procedure begins with TO qqq."),
    ],
)
def test_what_to_do_about_it(session: Session, program: str, hint: str) -> None:
    error = session.error(program)
    assert str(error).endswith(hint)
    assert error.text in str(error)
    assert error.position is not None
    assert error.position.marked() in str(error)
