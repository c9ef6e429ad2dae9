"""PAUSE and CONTINUE, with somebody to ask and without; ERRACT, which asks what to do about an error."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from .conftest import Session


class Typist:
    """Types these lines at each prompt, and notes the prompts."""

    def __init__(self, session: Session, *lines: str) -> None:
        self.lines = list(lines)
        self.prompts: list[str] = []
        session.interpreter.ask = self

    def __call__(self, prompt: str) -> str | None:
        self.prompts.append(prompt)
        return self.lines.pop(0) if self.lines else None


BOX = 'to box :side\nlocalmake "area :side * :side\nprint pause\nprint :area\nend\n'


def test_the_locals_are_there_and_can_be_changed(session: Session) -> None:
    typist = Typist(session, "print :area", 'make "area 1', "continue :side + 1")
    assert session.run(BOX + "box 3") == "Pausing...\n9\n4\n1\n"
    assert typist.prompts == ["box? "] * 3


def test_without_a_value_it_is_a_command(session: Session) -> None:
    for ending in ("continue", "co", "(continue)", "(co)"):
        Typist(session, "print 2", ending)
        assert session.run("to f\nprint 1\npause\nprint 3\nend\nf") == "1\nPausing...\n2\n3\n"
    Typist(session, "co")
    assert session.error(BOX + "box 3").text == "pause didn't output to print"


def test_at_top_level(session: Session) -> None:
    typist = Typist(session, "print repcount", "co")
    assert session.run("repeat 1 [pause] print 2") == "Pausing...\n1\n2\n"
    assert typist.prompts == ["? ", "? "]


def test_an_error_is_told_and_the_pause_goes_on(session: Session) -> None:
    Typist(session, "print :nix", '(throw "error [no good])', "5", "fd", "co 5")
    told = session.run(BOX + "box 3")
    for text in (
        "nix has no value in box",
        "no good",
        "You don't say what to do with 5",
        "not enough inputs to fd",
    ):
        assert text in told
    assert told.endswith("5\n9\n")


def test_an_error_deep_within_leaves_the_variables_of_the_pause(session: Session) -> None:
    Typist(session, "to g :area\nprint :area\nprint :nix\nend\ng 7", "co :area")
    assert session.run(BOX + "box 3").startswith(
        "Pausing...\n7\npause, line 3, column 7: nix has no value in g\n"
    )
    assert session.written[-2:] == ["9\n", "9\n"]


def test_stop_and_output_end_the_procedure(session: Session) -> None:
    Typist(session, "stop")
    assert session.run("to f\npause\nprint 1\nend\nf print 2") == "Pausing...\n2\n"
    Typist(session, "output 7")
    assert session.run("to f\npause\nprint 1\nend\nprint f") == "Pausing...\n7\n"


def test_throw_and_the_end_of_what_is_typed(session: Session) -> None:
    Typist(session, 'throw "out')
    assert session.run('catch "out [pause print 1] print 2') == "Pausing...\n2\n"
    Typist(session, 'throw "toplevel')
    assert session.run("pause print 1\nprint 2") == "Pausing...\n"
    Typist(session)
    assert session.run("pause print 1\nprint 2") == "Pausing...\n"


def test_a_pause_within_a_pause(session: Session) -> None:
    typist = Typist(session, "box 2", "co 5", "co 6")
    assert session.run(BOX + "box 3") == "Pausing...\nPausing...\n5\n4\n6\n9\n"
    assert typist.prompts == ["box? "] * 3


def test_without_anybody_to_ask(session: Session) -> None:
    error = session.error(BOX + "box 3")
    assert (error.number, error.procedure) == (16, "box")
    assert "needs someone to ask" in error.text
    assert "leave PAUSE out" in str(error)


@pytest.mark.parametrize("program", ["continue", "co 5", "(co)"])
def test_continue_without_a_pause(session: Session, program: str) -> None:
    assert session.error(program).number == 14


class TestErract:
    def test_a_pause_on_errors_shows_them(self, session: Session) -> None:
        typist = Typist(session, "print :n", "co 10")
        told = session.run('make "erract [pause]\nto f :n\nprint :n + :nix\nend\nf 1')
        assert told.startswith("test.logo, line 3, column 12: nix has no value in f\n")
        assert told.endswith("Pausing...\n1\n11\n")
        assert typist.prompts == ["f? ", "f? "]

    def test_without_a_value_the_error_is_one(self, session: Session) -> None:
        Typist(session, "co")
        assert session.error('make "erract [pause]\nprint :nix').number == 11

    def test_an_error_in_it_is_an_error(self, session: Session) -> None:
        assert session.error('make "erract [print :other 5]\nprint :nix').text == "other has no value"

    def test_a_value_in_the_place_of_what_is_missing(self, session: Session) -> None:
        program = 'make "erract [6]\nto f :n\noutput :n * 2\nend\n'
        assert session.run(program + "print nix") == "6\n"
        assert session.run(program + "print f :nix") == "12\n"
        assert session.run(program + "print first [] print sum 1 [a]") == "6\n7\n"
        assert session.run(program + "print sum print 3 4") == "3\n10\n"

    def test_it_is_asked_again_for_the_next_error(self, session: Session) -> None:
        assert session.run('make "n 0 make "erract [make "n :n + 1 :n]\nrepeat 3 [print :nix]') == "1\n2\n3\n"

    def test_the_same_bad_value_does_not_go_on_for_ever(self, session: Session) -> None:
        assert session.run('make "erract [[]]\nprint first []\nprint 2') == "Erract loop\n"

    def test_some_errors_have_no_other_value(self, session: Session) -> None:
        assert session.error('make "erract [6]\nprint item 5 [a]').number == 4
        assert session.error('make "erract [6]\nfd').number == 6

    def test_the_more_local_takes_precedence(self, session: Session) -> None:
        program = 'make "erract [6]\ncatch "error [print :nix]\nshow item 1 error print :nix'
        assert session.run(program) == "11\n6\n"
        assert session.run('catch "error [make "erract [7] print :nix]') == "7\n"
