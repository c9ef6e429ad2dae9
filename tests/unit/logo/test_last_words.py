"""ONSTOP: once, after the stop, without motion, and not for ever."""

from __future__ import annotations

import random

import pytest

from turtlewire.errors import LinkClosedError, StoppedError
from turtlewire.logo import Interpreter, ScreenTurtle
from turtlewire.logo.last_words import MOST_LISTS


class StoppingTurtle(ScreenTurtle):
    """A turtle that is stopped on its way, by whoever raises this."""

    def __init__(self, stop: BaseException) -> None:
        super().__init__()
        self.error = stop
        self.log: list[str] = []

    def forward(self, distance_mm: float) -> None:
        self.log.append(f"forward {distance_mm:g}")
        if distance_mm == 13:
            raise self.error
        super().forward(distance_mm)

    def stop(self) -> None:
        self.log.append("stop")

    def horn(self, tone: str) -> None:
        self.log.append(f"horn {tone}")
        super().horn(tone)


def last_words(program: str, stop: BaseException | None = None) -> tuple[str, StoppingTurtle]:
    """What a program that goes forward by 13 prints, and its turtle."""
    turtle = StoppingTurtle(stop or KeyboardInterrupt())
    written: list[str] = []
    interpreter = Interpreter(turtle, written.append, random.Random(0))
    with pytest.raises(type(turtle.error)) as caught:
        interpreter.run(program, "stop.logo")
    assert caught.value is turtle.error
    return "".join(written), turtle


@pytest.mark.parametrize("stop", [KeyboardInterrupt(), StoppedError("by the emergency stop")])
def test_it_runs_after_the_robot_was_stopped(stop: BaseException) -> None:
    written, turtle = last_words('onstop [hornhi print "bye]\nfd 1\nfd 13 print "not', stop)
    assert written == "bye\n"
    assert turtle.log == ["forward 1", "forward 13", "stop", "horn high"]


def test_nothing_moves() -> None:
    written, turtle = last_words('onstop [print pos fd 5 print "not]\nfd 1 fd 13')
    assert written.startswith("0 1\n")
    assert "nothing that ONSTOP runs moves it" in written
    assert "not" not in written.split()
    assert turtle.log == ["forward 1", "forward 13", "stop"]


@pytest.mark.parametrize(
    "motion",
    ["bk 1", "rt 1", "lt 1", "setxy 1 1", "setpos [0 0]", "setx 1", "sety 1", "seth 1", "home", "arc 90 1", "pu", "pd",
     "clean", "cs", "setspeed 3", "onlimit [fd 1]", 'tell "turtle fd 1', 'ask "turtle [fd 1]', "each [fd 1]"],
)  # fmt: skip
def test_no_motion_of_any_kind(motion: str) -> None:
    written, turtle = last_words(f"onstop [{motion} print 1]\nfd 13")
    assert "nothing that ONSTOP runs moves it" in written
    assert turtle.log == ["forward 13", "stop"]


def test_questions_lamp_and_short_waits() -> None:
    written, turtle = last_words("onstop [eyeson wait 60 print pendownp wait 61 print 1]\nfd 13")
    assert written.startswith("true\n")
    assert "may wait for 2 s in all" in written
    assert turtle.is_lamp_on
    assert turtle.elapsed_s == 1


def test_it_ends_where_the_program_was_deep_within() -> None:
    program = (
        'to f :n\nlocalmake "x :n\nif :n = 0 [fd 13]\nf :n - 1\nend\nmake "x "out\nonstop [print :x]\nf 5'
    )
    assert last_words(program)[0] == "out\n"


@pytest.mark.parametrize("loop", ["forever []", "while [1 = 1] []", "f", 'forever [catch "error [f]]'])
def test_it_does_not_go_on_for_ever(loop: str) -> None:
    written, _ = last_words(f"to f\nf\nend\nonstop [{loop}]\nfd 13")
    assert "Stopped" in written
    assert MOST_LISTS == 10_000


def test_who_was_told_is_told() -> None:
    written: list[str] = []
    turtles = {"elsie": ScreenTurtle(), "rosa": StoppingTurtle(KeyboardInterrupt())}
    logo = Interpreter(turtles, written.append, random.Random(0))
    with pytest.raises(KeyboardInterrupt):
        logo.run('onstop [print who each [print pos]]\nfd 2 tell "rosa\nfd 1 fd 13')
    assert written == ["rosa\n", "0 1\n"]


def test_an_error_in_it_is_told() -> None:
    assert "x has no value" in last_words("onstop [print :x]\nfd 13")[0]


def test_throw_and_bye_end_it() -> None:
    assert last_words('onstop [print 1 throw "toplevel print 2]\nfd 13')[0] == "1\n"
    assert last_words("onstop [print 1 bye print 2]\nfd 13")[0] == "1\n"


def test_it_can_be_taken_back() -> None:
    written, turtle = last_words("onstop [print 1]\nonstop []\nfd 13")
    assert (written, turtle.log) == ("", ["forward 13"])


def test_it_runs_once() -> None:
    turtle = StoppingTurtle(KeyboardInterrupt())
    written: list[str] = []
    interpreter = Interpreter(turtle, written.append, random.Random(0))
    for program in ("onstop [print 1]\nfd 13", "fd 13"):
        with pytest.raises(KeyboardInterrupt):
            interpreter.run(program)
    assert written == ["1\n"]
    interpreter.run("fd 2")
    assert turtle.pose.y_mm == 2


def test_not_after_an_error_nor_at_the_end() -> None:
    written: list[str] = []
    interpreter = Interpreter(ScreenTurtle(), written.append, random.Random(0))
    interpreter.run("onstop [print 1]")
    assert written == []


def test_a_robot_that_cannot_be_stopped_does_not_keep_it() -> None:
    class Unreachable(StoppingTurtle):
        def stop(self) -> None:
            raise LinkClosedError("gone")

    turtle = Unreachable(KeyboardInterrupt())
    written: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        Interpreter(turtle, written.append, random.Random(0)).run("onstop [print 1]\nfd 13")
    assert written == ["1\n"]
