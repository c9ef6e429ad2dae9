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


EVEN_AND_ODD = """\
to even :n
  if :n = 0 [output "true]
  output odd :n - 1
end
to odd :n
  if :n = 0 [output "false]
  output even :n - 1
end
"""


def test_a_procedure_that_leads_back_stands_where_it_is_called(session: Session) -> None:
    session.run(EVEN_AND_ODD)
    assert python(session, "even") == (
        "def q_even(n_):\n    while True:\n        if n_ == 0:\n            return 'true'\n        n_ = n_ - 1\n"
        "        if n_ == 0:\n            return 'false'\n        n_ = n_ - 1\n        continue\np_even = q_even"
    )


def test_an_error_where_another_procedure_stands_is_that_ones(session: Session) -> None:
    error = session.error(EVEN_AND_ODD.replace('[output "false]', "[output first []]") + "print even 5")
    assert (error.text, error.procedure) == ("first doesn't like [] as input", "odd")
    assert error.position is not None
    assert error.position.line == 6


def test_what_is_traced_stands_nowhere_else(session: Session) -> None:
    assert session.run(f'{EVEN_AND_ODD}trace "odd print even 2').splitlines() == [
        "( odd 1 )", 'odd outputs "true', "true",
    ]  # fmt: skip


def test_a_line_keeps_global_variables_in_locals_and_gives_them_back(session: Session) -> None:
    count = 'repeat 3 [make "i :i + 1 make "s word :s :i if :i > :last [ignore first []]]'
    assert session.run(f'make "i 0 make "s " make "last 5\n{count}\nshow :i show :s') == "3\n123\n"
    session.error(f'make "i 4 make "s "x\n{count}')
    assert session.run("show :i show :s") == "6\nx56\n"
    assert session.error(f'ern "i\n{count}').text == "i has no value"
    assert session.run('make "i 1.5\nrepeat 2 [make "i :i + 1]\nshow :i') == "3.5\n"
    assert session.error('make "i "a\nrepeat 2 [make "i :i + 1]').text == "+ doesn't like a as input"


def test_a_variable_that_is_called_for_is_no_local(session: Session) -> None:
    program = 'to seen\noutput :i\nend\nmake "i 0\nrepeat 3 [make "i :i + 1 type seen]\nprint :i'
    assert session.run(program) == "1233\n"
    assert session.run('repeat 2 [make "caseignoredp "false print "a = "A]') == "false\nfalse\n"
    assert session.run('make "i 1\nrepeat 1 [run [make "i :i + 1 print :i] print :i]') == "2\n2\n"


def test_whole_numbers_stay_exact_or_become_floats_as_ever(session: Session) -> None:
    assert session.run('make "i 4503599627370495\nrepeat 3 [make "i :i + 1 print :i * 4]').split() == [
        "1.8014398509482e+16"] * 3  # fmt: skip
    assert (
        session.run('make "i -3\nrepeat 4 [make "i :i + 1 type remainder :i 2 type modulo :i 2]\n')
        == "00-110011"
    )


@pytest.mark.parametrize(
    ("x", "y", "product"), [(0, 2.5, "0"), (0, -2.5, "-0"), (-2.5, 0, "-0"), (3, 4, "12")]
)
def test_a_product_has_its_sign(session: Session, x: float, y: float, product: str) -> None:
    assert session.run(f"to f :x :y\noutput :x * :y\nend\nprint f {x} {y}") == f"{product}\n"


@pytest.mark.parametrize(
    ("call", "result"),
    [
        ("f 2 {a b c}", "b"),
        ("f 0 (array 3 0)", "[]"),
        ("f 2 [a b c]", "b"),
        ("f 1.0 [a b c]", "a"),
        ("f 2 \"x5", "5"),
    ],
)  # fmt: skip
def test_items_of_all_sorts(session: Session, call: str, result: str) -> None:
    assert session.run(f"to f :i :x\noutput item :i :x\nend\nshow {call}") == f"{result}\n"


@pytest.mark.parametrize(
    ("call", "text"),
    [
        ("f 4 {a b c}", "item doesn't like 4 as input"),
        ("f -1 {a b c}", "item doesn't like -1 as input"),
        ("f 1.5 {a b c}", "item doesn't like 1.5 as input"),
        ("f 4 [a b c]", "item doesn't like 4 as input"),
        ("g 3 {a b} 1", "setitem doesn't like 3 as input"),
        ("g 0 {a b} 1", "setitem doesn't like 0 as input"),
        ('g "x {a b} 1', "setitem doesn't like x as input"),
        ("g 1 [a b] 1", "setitem doesn't like [a b] as input"),
        ("g 1 :own :own", "setitem doesn't like {[] []} as input"),
    ],
)
def test_items_that_are_not_there(session: Session, call: str, text: str) -> None:
    session.run('to f :i :x\noutput item :i :x\nend\nmake "own (array 2)')
    session.run("to g :i :x :y\nsetitem :i :x :y\noutput :x\nend")
    assert session.error(f"show {call}").text == text


def test_words_are_alike_as_ever(session: Session) -> None:
    session.run('to f :x\noutput list :x = "Kay :x = "rather.long\nend')
    assert session.run('show f "kAY show f "Rather.LONG show f "\N{KELVIN SIGN}ay show f [kay] show f 7') == (
        "[true false]\n[false true]\n[true false]\n[false false]\n[false false]\n"
    )
    assert session.run('make "caseignoredp "false show f "kay show f "Kay') == "[false false]\n[true false]\n"


def test_an_operation_without_a_value_in_an_ifelse_is_the_ifelses_fault(session: Session) -> None:
    error = session.error("to r\nend\nto f\noutput sum ifelse 1 = 1 [r] [2] 5\nend\nprint f")
    assert error.text == "ifelse didn't output to sum"


def test_an_error_tells_of_the_variable_as_it_was(session: Session) -> None:
    inner = "to inner :n\nseen\noutput :n + 1\nend\nto seen\nignore :n\nend\n"
    assert session.error(f'{inner}make "n 5\nprint inner [x]').text == "+ doesn't like [x] as input"
