"""Values that change, and a workspace that is looked at: what the vectors cannot hold."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from pathlib import Path

    from .conftest import Session


def test_values_that_hold_themselves_can_be_printed(session: Session) -> None:
    assert session.run('make "a {x y} .setitem 1 :a :a show :a') == "{{...} y}\n"
    assert session.run('make "a {x y} .setitem 1 :a (list :a :a) show :a') == "{[{...} {...}] y}\n"
    assert session.run('make "l [x y] .setfirst :l :l show :l print :l') == "[[...] y]\n[...] y\n"


def test_the_rest_of_a_list_may_not_lead_back_to_it(session: Session) -> None:
    error = session.error('make "l [a b c]\n.setbf bf :l :l')
    assert error.text == ".setbf doesn't like [a b c] as input"
    assert "lead back" in error.hint
    assert session.run("show :l") == "[a b c]\n"


def test_a_list_that_was_changed_runs_as_it_is_now_whenever_its_program_is_parsed_again(
    session: Session,
) -> None:
    program = """to f
  localmake "l [print 1]
  run :l
  .setfirst bf :l 2
  run :l
end
f
f
to g
end
f
"""
    assert session.run(program) == "1\n2\n2\n2\n2\n2\n"


def test_a_changed_list_is_not_taken_for_what_was_read_though_nobody_ran_it_in_between(
    session: Session,
) -> None:
    program = """to f
  localmake "l [print 1]
  localmake "m [print 2]
  run :l
  run :m
  .setfirst butfirst :l 7
  .setbf butfirst :m [print 3]
end
f
f
"""
    assert session.run(program) == "1\n2\n7\n2\n3\n"


def test_the_members_of_a_changed_list_run_as_they_were_read(session: Session) -> None:
    program = 'make "l [[print 1] [print 2]]\n.setfirst :l [print 3]\nforeach :l [run ?]\n.setbf :l []\nrun first :l'
    assert session.run(program) == "3\n2\n3\n"


def test_circles_of_arrays_are_found_however_deep(session: Session) -> None:
    program = 'make "a array 1 make "b :a repeat 5000 [make "c array 1 setitem 1 :b :c make "b :c]\n'
    assert session.error(program + "setitem 1 :b :a").text.startswith("setitem doesn't like {{{")
    assert session.run("setitem 1 :b [done] show :b") == "{[done]}\n"


@pytest.mark.parametrize("program", ["array 10000001", "mdarray [10000 10000]", "mdarray [0 1e9]"])
def test_arrays_have_an_end(session: Session, program: str) -> None:
    assert "doesn't like" in session.error(f"show {program}").text


def test_an_array_has_no_end_where_it_began(session: Session) -> None:
    error = session.error("print 1\nshow {a b\n")
    assert (error.number, error.text) == (10, "'}' not found")
    assert error.position is not None
    assert (error.position.line, error.position.column) == (2, 6)
    assert session.error("to f\nshow {a\nend\nf").number == 33


@pytest.mark.parametrize(
    ("text", "wanted"), [("{a ]", "wants a }"), ("[a }", "wants a ]"), ("}", "no { before")]
)
def test_brackets_that_do_not_match(session: Session, text: str, wanted: str) -> None:
    assert wanted in session.error(f"show {text}").hint


def test_what_is_saved_can_be_loaded_whatever_is_in_it(
    session: Session, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    session.run(
        'make "a "|x (y] ;z~ \\| \\\\ {w}| make "b (list "|a b| "c\\ d word "a char 10 "|:q| "|| [] {1 |[|}@-2)'
        ' make "c "a\\(\\;b make "|odd name| "é make word "e char 123 7 pprop "|a b| "|c d| "|(|'
    )
    before = session.run('show :a show :b show :c show names show plist "|a b|')
    session.run('save "f')
    session.run('erall load "f')
    assert session.run('show :a show :b show :c show names show plist "|a b|') == before


@pytest.mark.parametrize(
    "line",
    [
        'print "|a b|',
        "print a| |b+3",
        'print "a\\ b',
        "show [|a\\\\b\\|c| x]",
        ":|odd name|",
        'print "x|(|\\)',
    ],
)
def test_a_line_of_a_program_is_printed_as_it_can_be_read(session: Session, line: str) -> None:
    assert session.run(f'define "f [[] [{line}]]\npo "f') == f"to f\n{line}\nend\n\n"


def test_what_is_erased_is_not_buried_any_longer(session: Session) -> None:
    session.run('to f\nend\nbury "f erase "f')
    assert session.run("show buried") == session.run("bury [[] [x]] unbury [[] [x]] show buried")
    assert session.run("to f\nend\nshow procedures") == "[f]\n"


def test_catching_what_a_traced_procedure_throws_puts_the_tracing_right(session: Session) -> None:
    program = """to f :n
  if :n = 0 [throw "out]
  f :n - 1
end
trace "f
catch "out [f 2]
f 0
"""
    session.error(program)
    assert "".join(session.written) == "( f 2 )\n ( f 1 )\n  ( f 0 )\n( f 0 )\n"
    assert session.run('catch "out [f 0]') == "( f 0 )\n"


def test_a_procedure_that_is_not_traced_calls_itself_without_an_end(session: Session) -> None:
    program = (
        'to count.down :n\nif :n = 0 [stop]\ncount.down :n - 1\nend\nto f\nend\ntrace "f\ncount.down 50000 f'
    )
    assert session.run(program) == "( f )\nf stops\n"


@pytest.mark.parametrize(
    ("program", "printed"),
    [
        ('help "fd', "fd takes 1 input. The same: forward.\n"),
        ('help "print', "print takes 1 input. Between parentheses: 0 to any number. The same: pr.\n"),
        ('help "setxy', "setxy takes 2 inputs.\n"),
        ('to f :x\n  ; doubles\nop 2 * :x\n; end\nend\nhelp "f', "to f :x\n  ; doubles\n"),
        ('to f :x\nend\nhelp "f', "to f :x\n"),
    ],
)
def test_help(session: Session, program: str, printed: str) -> None:
    assert session.run(program) == printed


def test_help_lists_everything(session: Session) -> None:
    names = session.run("to zzz\nend\n(help)").split()
    assert {"forward", "readlist", "zzz"} <= set(names)
    assert names == sorted(names)


def test_what_the_parser_calls_itself_keeps_its_meaning(session: Session) -> None:
    session.run('make "redefp "true')
    for name in ("+", "minus", "make", "<="):
        assert session.error(f'erase "{name}').number == 22
        assert session.error(f'define "{name} [[a b] [output 1]]').number == 22


def test_a_primitive_gets_its_meaning_back(session: Session) -> None:
    session.run('make "redefp "true copydef "first.was "first\ndefine "first [[x] [output "mine]]')
    assert session.run("show first [a b]") == "mine\n"
    session.run('copydef "first "first.was')
    assert session.run("show first [a b]") == "a\n"
    session.run('erase "first')
    assert session.error("show first [a b]").text == "I don't know how to first"


def test_standout_and_print_keep_to_the_same_limits(session: Session) -> None:
    session.run('make "printwidthlimit 2')
    assert session.run("show standout [a b c]") == "a b ...\n"
    assert session.run('show (list "abcdefghijk 3)') == "[abcdefghij... 3]\n"


def test_nodes_remember_the_most(session: Session) -> None:
    used, most = session.run("print nodes").split()
    assert int(used) <= int(most)
    again = session.run("gc print nodes").split()
    assert int(again[1]) >= int(most)
