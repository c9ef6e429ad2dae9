"""What is compiled and what is not; that programs keep their meaning when they change themselves, or go deep."""

from __future__ import annotations

import signal
from typing import TYPE_CHECKING

import pytest

from turtlewire.errors import LimitReachedError
from turtlewire.logo import LogoError, ScreenTurtle
from turtlewire.logo.procedures import UserProcedure

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.unit.logo.conftest import Session


def python(session: Session, name: str) -> str | None:
    """What a procedure becomes."""
    procedure = session.interpreter.procedures[name]
    assert isinstance(procedure, UserProcedure)
    return session.interpreter.compiler.source(procedure)


def test_a_procedure_becomes_a_function_that_can_be_read(session: Session) -> None:
    session.run("to fib :n\nif :n < 2 [output :n]\noutput (fib :n - 1) + (fib :n - 2)\nend")
    assert python(session, "fib") == (
        "def q_fib(n_):\n    if n_ < 2:\n        return n_\n"
        "    return (t1 := p_fib(n_ - 1)) + +(t2 := p_fib(n_ - 2))\np_fib = q_fib"
    )


def test_a_call_in_the_last_place_is_a_jump(session: Session) -> None:
    session.run("to add :n :sum\nif :n = 0 [output :sum]\noutput add :n - 1 :sum + :n\nend")
    source = python(session, "add")
    assert source is not None
    assert "while True:" in source
    assert "n_, sum_ = (n_ - 1, sum_ + +n_)" in source


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("run :x", "computed"),
        ("apply :x [1]", "evaluator"),
        ("make :x 1", "computed"),
        ("show map :x [1 2]", "computed"),
        ("print repcount", "REPEAT"),
        ("iftrue [print 1]", "TEST"),
        ("catch :x [print 1]", "evaluator"),
        ("nowhere 1", "understood"),
        ('if :x [local "y]', "local"),
    ],
)
def test_what_is_left_to_the_evaluator(session: Session, body: str, why: str) -> None:
    session.run(f"to f :x\n{body}\nend")
    assert python(session, "f") is None
    procedure = session.interpreter.procedures["f"]
    assert isinstance(procedure, UserProcedure)
    assert why in session.interpreter.compiler.refusal(procedure)


def test_a_variable_that_a_callee_sees_is_seen(session: Session) -> None:
    inner = 'to inner\nprint :n\nmake "n :n + 1\nend\n'
    assert (
        session.run(f'to outer :n\ninner\nprint :n\nend\n{inner}make "n 100\nouter 5 print :n')
        == "5\n6\n100\n"
    )
    source = python(session, "outer")
    assert source is not None
    assert "V['n'] = n_" in source


def test_a_variable_that_a_list_sees_is_seen(session: Session) -> None:
    program = 'to outer :n\ndo [print :n]\nend\nto do :list\nrun :list\nend\nmake "n 100\nouter 5'
    assert session.run(program) == "5\n"


@pytest.mark.parametrize("depth", [200_000, 200_001])
def test_procedures_that_end_in_one_another_need_no_stack(session: Session, depth: int) -> None:
    even = 'to even :n\nif :n = 0 [output "true]\noutput odd :n - 1\nend\n'
    odd = 'to odd :n\nif :n = 0 [output "false]\noutput even :n - 1\nend\n'
    assert session.run(f"{even}{odd}print even {depth}") == ("true\n" if depth % 2 == 0 else "false\n")


def test_commands_that_end_in_one_another_need_no_stack(session: Session) -> None:
    tick = 'to tick :n\nif :n = 0 [print "done stop]\ntock :n - 1\nend\n'
    tock = 'to tock :n\nif :n = 0 [print "done stop]\ntick :n - 1\nend\n'
    assert session.run(f"{tick}{tock}tick 300001") == "done\n"


def test_a_million_deep(session: Session) -> None:
    assert (
        session.run("to depth :n\nif :n = 0 [output 0]\noutput 1 + depth :n - 1\nend\nprint depth 1000000")
        == "1000000\n"
    )


def test_a_command_that_outputs_late_is_an_error(session: Session) -> None:
    program = "to f :n\nif :n = 0 [output 7]\nf :n - 1\nend\nf 3"
    error = session.error(program)
    assert (error.number, error.text, error.procedure) == (30, "You don't say what to do with 7", "f")


def test_an_operation_that_falls_silent_late_is_an_error(session: Session) -> None:
    error = session.error("to f :n\nif :n = 0 [stop]\noutput f :n - 1\nend\nprint f 3")
    assert (error.number, error.text) == (5, "f didn't output to output")


def test_a_procedure_may_be_defined_anew_while_others_run(session: Session) -> None:
    program = (
        'to f\noutput 1\nend\nto change\ndefine "f [[] [output 2]]\nend\n'
        'to g\nprint f\nchange\nprint f\nend\ng\nerase "f\n'
    )
    assert session.run(program) == "1\n2\n"
    assert session.error("g").text == "I don't know how to f"


def test_what_is_traced_is_seen_and_then_not(session: Session) -> None:
    session.run("to f :n\noutput :n * 2\nend\nto g\nprint f 4\nend\ng")
    traced = session.run('trace "f g')
    assert "f 4" in traced
    assert session.run('untrace "f g') == "8\n"


@pytest.mark.parametrize(
    ("program", "line", "column", "text"),
    [
        ("to f :x\n  print 1\n  print :x + first []\nend\nf 3", 3, 14, "first doesn't like [] as input"),
        ("to f :x\n  print 2 * (:x - 1)\nend\nf [a]", 2, 17, "- doesn't like [a] as input"),
        ("to f :x\n  local \"y\n  print :y\nend\nf 3", 3, 9, "y has no value"),
        ("to f :x\n  print :z\nend\nf 3", 2, 9, "z has no value"),
        ("to f :x\n  repeat :x [print 1]\nend\nf \"a", 2, 3, "repeat doesn't like a as input"),
        ("repeat 2 [fd sum 1 \"a]", 1, 14, "sum doesn't like a as input"),
        ("to f\nend\nto g\n  print 1 + f\nend\ng", 4, 13, "f didn't output to +"),
        ("to f\n  if 3 [print 1]\nend\nf", 2, 3, "if doesn't like 3 as input"),
    ],
)  # fmt: skip
def test_errors_say_where(session: Session, program: str, line: int, column: int, text: str) -> None:
    error = session.error(program)
    assert error.text == text
    assert error.position is not None
    assert (error.position.line, error.position.column) == (line, column)


def test_all_inputs_of_and_are_evaluated(session: Session) -> None:
    noisy = 'to noisy :x\nprint :x\noutput "false\nend\n'
    assert session.run(
        f"{noisy}to f\nif and noisy 1 noisy 2 [print 3]\nif or noisy 4 1 = 1 [print 5]\nend\nf"
    ) == ("1\n2\n4\n5\n")
    assert session.error("if and [1 = 2] 3 [] if or 1 = 2 3 []").text == "or doesn't like 3 as input"


class Wall(ScreenTurtle):
    """A turtle that meets a wall at each step."""

    def forward(self, distance_mm: float) -> None:
        super().forward(distance_mm)
        raise LimitReachedError("front", 0.0, self.pose.y_mm, 0.0)


def test_a_limit_within_a_compiled_procedure_is_handled(make_session: Callable[..., Session]) -> None:
    session = make_session(Wall())
    program = 'to f\nrepeat 3 [fd 1 print "on]\nend\n'
    assert session.run(f'{program}onlimit [type "! ] f') == "!on\n!on\n!on\n"
    assert session.run('onlimit [stop] f print "after') == "after\n"
    with pytest.raises(LimitReachedError) as caught:
        session.run("onlimit [] f")
    assert "in test.logo, line 2, fd" in caught.value.__notes__[0]


def test_nothing_is_compiled_for_a_program_that_puts_values_in_the_place_of_errors(session: Session) -> None:
    program = 'to f :x\noutput 1 + :x\nend\nmake "erract [7]\nprint f "a'
    assert session.run(program) == "8\n"


@pytest.mark.parametrize("loop", ["repeat 1e9 []", "forever []", "f", 'while [1 = 1] [make "x 1]'])
def test_an_interrupt_anywhere_in_a_loop_says_where_it_was(session: Session, loop: str) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    session.run("to f\nf\nend")
    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        session.interpreter.write = lambda _: signal.setitimer(signal.ITIMER_REAL, 0.002)
        for _ in range(20):  # each at another place
            with pytest.raises(KeyboardInterrupt):
                session.interpreter.run(f"print 1 {loop}", "loop.logo")
            assert session.interpreter.position is not None
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_without_the_compiler_it_is_the_same(make_session: Callable[..., Session]) -> None:
    session = make_session()
    session.interpreter.compiler.switch_off()
    assert session.run("to f :n\noutput :n * 2\nend\nrepeat 2 [print f repcount]") == "2\n4\n"
    procedure = session.interpreter.procedures["f"]
    assert isinstance(procedure, UserProcedure)
    assert procedure.function is None
    with pytest.raises(LogoError):
        session.run("repeat 1 [print f]")
