"""TELL, ASK, EACH and WHO: several turtles, one program."""

from __future__ import annotations

import random

import pytest

from turtlewire.errors import LimitReachedError, LinkClosedError
from turtlewire.logo import Interpreter, LogoError, ScreenTurtle
from turtlewire.logo.turtles import Team, Turtles
from turtlewire.turtle import Pose


class Herd:
    """Two turtles on screens, and what their programs print."""

    def __init__(self, *turtles: ScreenTurtle) -> None:
        self.elsie, self.rosa = turtles or (ScreenTurtle(), ScreenTurtle())
        self.written: list[str] = []
        self.interpreter = Interpreter(
            {"Elsie": self.elsie, "rosa": self.rosa}, self.written.append, random.Random(0)
        )

    def run(self, program: str) -> str:
        self.written.clear()
        self.interpreter.run(program, "herd.logo")
        return "".join(self.written)

    @property
    def strokes(self) -> tuple[int, int]:
        return len(self.elsie.trace.strokes), len(self.rosa.trace.strokes)

    @property
    def heights(self) -> tuple[float, float]:
        return self.elsie.pose.y_mm, self.rosa.pose.y_mm


@pytest.fixture
def herd() -> Herd:
    return Herd()


def test_the_first_is_told_at_first(herd: Herd) -> None:
    assert herd.run("print who fd 10") == "Elsie\n"
    assert herd.heights == (10, 0)


def test_tell_one(herd: Herd) -> None:
    assert herd.run('tell "ROSA fd 10 print who print ycor') == "rosa\n10\n"
    assert herd.heights == (0, 10)


def test_tell_several_and_ask_the_first(herd: Herd) -> None:
    herd.rosa.forward(5)
    assert herd.run('tell [rosa elsie rosa] fd 10 show who print ycor tell "elsie') == "[rosa Elsie]\n15\n"
    assert herd.heights == (10, 15)


def test_ask_in_between(herd: Herd) -> None:
    assert herd.run('ask "rosa [fd 7 rt 90] fd 1 print ask "rosa [ycor] print who') == "7\nElsie\n"
    assert herd.heights == (1, 7)


def test_ask_several(herd: Herd) -> None:
    herd.run("ask [elsie rosa] [fd 3]")
    assert herd.heights == (3, 3)


def test_each(herd: Herd) -> None:
    assert herd.run("tell [elsie rosa] each [print who fd repcount + 3] show who") == (
        "Elsie\nrosa\n[Elsie rosa]\n"
    )
    assert herd.heights == (2, 2)


def test_output_and_stop_from_within(herd: Herd) -> None:
    program = """
        to asking
          ask "rosa [output who]
        end
        to eaching
          each [if equalp who "rosa [output "found]]
          output "no
        end
        to stopping
          each [stop]
          print "not
        end
        print asking print who
        tell [elsie rosa] print eaching stopping show who
    """
    assert herd.run(program) == "rosa\nElsie\nfound\n[Elsie rosa]\n"


def test_an_error_leaves_those_told_who_were(herd: Herd) -> None:
    assert (
        herd.run('catch "error [ask "rosa [print :x]] catch "error [each [first []]] print who') == "Elsie\n"
    )


@pytest.mark.parametrize(
    ("program", "text"),
    [
        ('tell "bella', "tell doesn't like bella as input"),
        ("tell []", "tell doesn't like [] as input"),
        ("tell [rosa [elsie]]", "tell doesn't like [elsie] as input"),
        ('ask "bella [fd 1]', "ask doesn't like bella as input"),
        ('ask "rosa', "not enough inputs to ask"),
        ('print ask "rosa [fd 1]', "ask didn't output to print"),
        ('ask "rosa [5]', "You don't say what to do with 5"),
        ("each [5]", "You don't say what to do with 5"),
    ],
)
def test_errors(herd: Herd, program: str, text: str) -> None:
    with pytest.raises(LogoError) as caught:
        herd.run(program)
    assert caught.value.text == text
    if "like" in text and "bella" in text:
        assert "Elsie, rosa" in str(caught.value)


def test_a_turtle_alone_has_a_name() -> None:
    written: list[str] = []
    Interpreter(ScreenTurtle(), written.append, random.Random(0)).run(
        'print who ask "turtle [fd 1] print pos'
    )
    assert "".join(written) == "turtle\n0 1\n"


def test_names_differ_and_there_is_one() -> None:
    with pytest.raises(ValueError, match="different names"):
        Turtles({"a": ScreenTurtle(), "A": ScreenTurtle()})
    with pytest.raises(ValueError, match="at least one"):
        Turtles({})
    with pytest.raises(ValueError, match="at least one"):
        Team([])


def test_every_command_reaches_every_member(herd: Herd) -> None:
    herd.run(
        "tell [elsie rosa] fd 10 bk 4 rt 90 lt 30 setxy 1 2 setx 3 sety 4 seth 45 arc 90 5 setspeed 7 hornhi eyeson pu"
    )
    for each in (herd.elsie, herd.rosa):
        assert each.pose == Pose(3, 4, 45)
        assert (each.speed, each.tone, each.is_lamp_on, each.is_pen_down) == (7, "high", True, False)
        assert each.trace.strokes


def test_they_wait_together_and_wipe_the_screen(herd: Herd) -> None:
    herd.run("tell [rosa elsie] fd 5 pu pd wait 60")
    assert (herd.rosa.elapsed_s, herd.elsie.elapsed_s) == (1, 0)  # one clock is enough
    assert herd.elsie.is_pen_down
    assert herd.strokes == (1, 1)
    herd.run("clean")
    assert (herd.strokes, herd.heights) == ((0, 0), (5, 5))
    herd.run("home")
    assert (herd.strokes, herd.heights) == ((1, 1), (0, 0))
    herd.run("fd 2 cs")
    assert (herd.strokes, herd.heights) == ((0, 0), (0, 0))


def test_before_they_wait_the_motion_of_all_ends() -> None:
    class BusyTurtle(ScreenTurtle):
        finished = 0

        def finish(self) -> None:
            self.finished += 1

    first, second = BusyTurtle(), BusyTurtle()
    Team([first, second]).wait(1)
    assert (first.finished, second.finished, first.elapsed_s) == (1, 1, 1)


class BumpingTurtle(ScreenTurtle):
    """A turtle whose first motions bump into something."""

    def __init__(self, *sensors: str) -> None:
        super().__init__()
        self.sensors = list(sensors)

    def forward(self, distance_mm: float) -> None:
        if self.sensors:
            raise LimitReachedError(self.sensors.pop(0), 0, 0, 0)
        super().forward(distance_mm)


def test_who_reached_the_limit_handles_it_alone() -> None:
    herd = Herd(ScreenTurtle(), BumpingTurtle("left"))
    program = "onlimit [print list who limitsensor bk 3]\ntell [elsie rosa]\nfd 10 show who"
    assert herd.run(program) == "rosa left\n[Elsie rosa]\n"
    assert [each.is_step_by_step for each in (herd.elsie, herd.rosa)] == [True, True]
    assert herd.heights == (10, -3)


def test_several_reach_a_limit_at_once() -> None:
    herd = Herd(BumpingTurtle("front"), BumpingTurtle("back"))
    assert (
        herd.run("onlimit [print list who limitsensor]\ntell [elsie rosa]\nfd 10")
        == "Elsie front\nrosa back\n"
    )


def test_a_limit_without_a_handler_names_who_reached_it() -> None:
    herd = Herd(BumpingTurtle("front"), BumpingTurtle("back"))
    with pytest.raises(LimitReachedError) as caught:
        herd.run("tell [elsie rosa]\nfd 10")
    assert caught.value.sensor == "front"
    assert "It happened to Elsie and rosa." in caught.value.__notes__


class UnreachableTurtle(ScreenTurtle):
    def __init__(self) -> None:
        super().__init__()
        self.stops = 0

    def stop(self) -> None:
        self.stops += 1
        raise LinkClosedError("gone")


def test_all_are_stopped_even_if_one_cannot_be() -> None:
    first, second = UnreachableTurtle(), UnreachableTurtle()
    with pytest.raises(LinkClosedError):
        Team([first, second]).stop()
    assert (first.stops, second.stops) == (1, 1)
