"""What the vectors cannot hold: robots' primitives, and inputs that UCBLogo has no word for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.errors import MessageError
from turtlewire.logo import ScreenTurtle

if TYPE_CHECKING:
    from collections.abc import Callable

    from .conftest import Session


def test_horn_lamp_speed_and_waiting(session: Session) -> None:
    turtle: Any = session.turtle
    session.run("hornlo")
    assert turtle.tone == "low"
    session.run("hornhi eyeson setspeed 1")
    assert (turtle.tone, turtle.is_lamp_on, turtle.speed) == ("high", True, 1)
    session.run("hornoff eyesoff setspeed 255 wait 30 wait 60")
    assert (turtle.tone, turtle.is_lamp_on, turtle.speed, turtle.elapsed_s) == ("off", False, 255, 1.5)


@pytest.mark.parametrize(
    "program",
    [
        "setspeed 0",
        "setspeed 256",
        "setspeed 1.5",
        "wait -1",
        "onlimit 3",
        "fd 1e308",
        "setpos [1e308 0]",
        "setpos [0 1e308]",
        "power 1e200 2",
        "fd 1e308 * 10",
        "rt 1e308 * 10",
        "rt (1e308 * 10) - (1e308 * 10)",
        "setpos list 0 1e308 * 10",
        "wait 1e308 * 10",
        "repeat 1e308 * 10 []",
        "exp 1000",
        "tan 90",
        "rseq 1 2 -1",
        "ashift 1 65",
        "form 1 1001 2",
        "form 1 2 101",
        "(random 5 3)",
        "(?)",
        "? ",
        "firsts 3",
        "(map [?] [1] [1 2])",
        'print map [list ? ?] "ab',
        'reduce "sum []',
        "char 55296",
        "char 1114112",
        'pop "s',
        'fput [a] "b',
        'lput [a] "b',
        'vbarredp "ab',
        'define "f []',
        'define "f [a]',
        'define "f [[] a]',
        "int [1]",
        "repeat -1 []",
    ],
)
def test_inputs_that_are_not_liked(make_session: Callable[..., Session], program: str) -> None:
    session = make_session(step_mm=10.0)
    session.run('make "s [] make "word "abc')
    assert "doesn't like" in session.error(program).text


def test_a_message_error_of_the_turtle_gets_its_place(make_session: Callable[..., Session]) -> None:
    class Mute(ScreenTurtle):
        def horn(self, tone: str) -> None:
            raise MessageError("no such tone")

    session = make_session(Mute())
    with pytest.raises(MessageError) as caught:
        session.run("hornhi")
    assert caught.value.__notes__ == ["in test.logo, line 1, hornhi:\n    hornhi\n    ^"]


def test_steps_are_scaled(make_session: Callable[..., Session]) -> None:
    session = make_session(step_mm=2.5)
    assert (
        session.run("fd 10 print ycor print distance [0 0] setxy 4 0 print pos arc 360 1 print pos")
        == "10\n10\n4 0\n4 0\n"
    )
    assert session.turtle.pose.x_mm == 10.0
    assert (
        session.run("print (distance 4 3) print (towards 5 0) setx 1 sety 1 bk 1 print pos") == "3\n90\n1 0\n"
    )


@pytest.mark.parametrize(
    ("program", "output"),
    [
        ("print tan 45 print tan 135 print tan 0 print abs -3", "1\n-1\n0\n3\n"),
        ("print pi print (radarctan 0 1) print bitnot 5", "3.14159265358979\n1.5707963267949\n-6\n"),
        ("print (bitand) print (bitor 1 2) print (bitxor 3 1)", "-1\n3\n2\n"),
        ("print form 3.14159 8 2 print form 3 0 0", "    3.14\n3\n"),
        (
            'print (random 3 3) print random 0 rerandom make "a random 1000 rerandom print :a = random 1000',
            "3\n0\ntrue\n",
        ),
        ("print lessp pick [1 2 3] 4", "true\n"),
        ("print gensym print gensym", "g1\ng2\n"),
        (
            'print arrayp 3 print backslashedp "|(|  print vbarredp "|(| print backslashedp "a',
            "false\ntrue\ntrue\nfalse\n",
        ),
        (
            'print combine "a "b print remove "b "abc print remdup "abab show remdup [a b a]',
            "ab\nac\nab\n[b a]\n",
        ),
        ('show parse "|a b| show runparse "|:a+b| show runparse ["c]', '[a b]\n[:a+b]\n["c]\n'),
        (
            'make "caseignoredp "false print "a = "A print beforep "B "a print memberp "a [A]',
            "false\ntrue\nfalse\n",
        ),
        ("show find [? > 1] [1 2 3] show find [? > 9] [1]", "2\n[]\n"),
        ('show map "uppercase "abc show filter [? = "a] "aba', "ABC\naa\n"),
        ("show (map [?1 + ?2] [1 2] [3 4]) show invoke [?] 5", "[4 6]\n5\n"),
        ("to f\nforeach [1 2] [if ? = 2 [output ?]]\nend\nprint f", "2\n"),
        (
            'apply [[x] print :x] [3] print namep "x make "x 1 apply [[x] make "x 2] [3] print :x',
            "3\nfalse\n1\n",
        ),
        ('to f :a\nprint :a\nend\napply "f [1] apply "if [true [print 2]]', "1\n2\n"),
        (
            'to f :a [:b 1] [:c]\nend\nshow text "f show arity "f show arity "print',
            "[[a [b 1] [c]]]\n[1 1 -1]\n[0 1 -1]\n",
        ),
        ('make "q [] queue "q 1 queue "q 2 print dequeue "q show :q', "1\n[2]\n"),
        ('to f\nend\nto g\nend\nerase [f g] print procedurep "f', "false\n"),
        ('make "a 1 make "b 2 ern [a b] print namep "b', "false\n"),
        ('to f\napply "output [3]\nend\nprint f', "3\n"),
        ('make "x 3 print (x) print round 7', "3\n7\n"),
        ('global "a (global "b [c d]) print namep "a local [x y]', "false\n"),
        ('print (word "a 1) print ascii char 228 print 1 bye print 2', "a1\n228\n1\n"),
        ("to f\n.maybeoutput 3\nend\nprint f", "3\n"),
        ('to f\ncatch "error [output 4]\nend\nprint f print last bf [1 2]', "4\n2\n"),
        ('to f\nlocal [a] localmake "a 1 ignore :a stop\nend\nf print iseq 2 4', "2 3 4\n"),
        ('catch "error [run (list "first [])]\nshow bl error', "[7 first doesn't like [] as input []]\n"),
        ('make "n 1 for [i [:n] 2 :n] [type :i]', "12"),
        ('for [i 2 1] [make "i 0] print namep "i', "false\n"),
        ("repeat 1 [show bl [a]] print ifelse (1 = 1) [1] [2]", "[]\n1\n"),
    ],
)
def test_outputs(session: Session, program: str, output: str) -> None:
    assert session.run(program) == output


@pytest.mark.parametrize(
    ("program", "text"),
    [
        ("print map [print ?] [1]", "print didn't output to map"),
        ('print map "pr [1]', "pr didn't output to map"),
        ('apply "foo []', "I don't know how to foo"),
        ('apply "sin []', "not enough inputs to sin"),
        ('apply "sin [1 2]', "too many inputs to sin"),
        ('show text "print', "print is a primitive"),
        ('print arity "foo', "I don't know how to foo"),
        ("to f\nprint runresult [stop]\nend\nf", "Can't use OUTPUT or STOP inside RUNRESULT"),
        ("repeat 1 [to x]", "can't use TO inside a procedure"),
        ('(throw "error [my message])', "my message"),
        ('throw "error', 'Throw "Error'),
        ("iffalse []", "iffalse without TEST"),
        ("while [] [print 1]", "[] didn't output to while"),
        ("for [i [] 2] []", "for doesn't like [] as input"),
        ("(foo)", "I don't know how to foo"),
        ("(foo + 1)", "I don't know how to foo"),
        ("setfoo 3", "I don't know how to setfoo"),
        ('catch "error [throw "x]', "Can't find catch tag for x"),
        ('catch "x [foo]', "I don't know how to foo"),
        ("print ||", "I don't know how to ||"),
        ("print (", "too many ('s"),
        ("run [(print 1]", "too many ('s"),
        ("to 3\nend", "to doesn't like 3 as input"),
        ("to\nend", "not enough inputs to to"),
    ],
)
def test_errors(session: Session, program: str, text: str) -> None:
    error = session.error(program)
    assert error.text == text
    assert error.position is not None


def test_the_rest_is_known_in_templates_only(session: Session) -> None:
    assert session.error("print ?rest").text == "?rest doesn't like 1 as input"
    assert session.error("foreach [a] [show (?rest 2)]").text == "?rest doesn't like 2 as input"
    assert session.run("foreach [a b] [foreach [c] [] print #]") == "1\n2\n"
    assert session.error("foreach [a b] [print first 1 / 0]").number == 4
    assert session.run("print #") == "-1\n"


@pytest.mark.parametrize("operation", ["int", "round"])
def test_no_whole_number_is_infinite(session: Session, operation: str) -> None:
    assert session.error(f"print {operation} 1e200 * 1e200").text == f"{operation} doesn't like inf as input"
    assert session.run(f"print {operation} -2.75 * 2") == ("-5\n" if operation == "int" else "-6\n")
