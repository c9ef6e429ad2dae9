from __future__ import annotations

from typing import TYPE_CHECKING

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
