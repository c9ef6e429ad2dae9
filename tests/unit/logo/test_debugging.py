"""STEP at a keyboard, and the debugger that a program may be given: what stops where, and what is told of it."""

from __future__ import annotations

import io
import queue
import random
import threading
from typing import TYPE_CHECKING

import pytest

from turtlewire.errors import StoppedError
from turtlewire.logo import Debugger, Interpreter, LogoError, Moment, Order, Reason, ScreenTurtle
from turtlewire.logo.keyboard import Keyboard

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from .conftest import Session

STEPPED = """\
to inner :x
  print :x * 2 repeat 2 [type "a]
  if :x > 2 [print "big
    print "bigger]
  output :x + 1
end
to outer :n
  make "r inner :n

  print (list :n ~
    :r) ; a comment
  if :n > 2 [outer :n - 1]
end
"""
ALONE = "Nobody types: stepping goes on without waiting.\n"


def types(session: Session, text: str) -> None:
    """Somebody types this."""
    session.interpreter.streams.keyboard = Keyboard(io.StringIO(text).readline)


class TestStep:
    """Which lines are shown, and when, is what UCBLogo did under Xvfb when the RETURN key was pressed."""

    def test_each_line_of_a_stepped_procedure(self, session: Session) -> None:
        types(session, "\n" * 20)
        assert session.run(STEPPED + "step [outer inner] outer 3") == (
            '[make "r inner :n] >>> [print :x * 2 repeat 2 [type "a]] >>> 6\n'
            'aa[if :x > 2 [print "big print "bigger]] >>> big\nbigger\n[output :x + 1] >>> '
            "[print (list :n :r)] >>> 3 4\n[if :n > 2 [outer :n - 1]] >>> "
            '[make "r inner :n] >>> [print :x * 2 repeat 2 [type "a]] >>> 4\n'
            'aa[if :x > 2 [print "big print "bigger]] >>> [output :x + 1] >>> '
            "[print (list :n :r)] >>> 2 3\n[if :n > 2 [outer :n - 1]] >>> "
        )
        assert session.run("unstep [outer] outer 2") == (
            '[print :x * 2 repeat 2 [type "a]] >>> 4\n'
            'aa[if :x > 2 [print "big print "bigger]] >>> [output :x + 1] >>> 2 3\n'
        )
        assert session.run('unstep "inner outer 2') == "4\naa2 3\n"
        assert session.interpreter.debugger is None

    def test_it_waits_before_the_line_runs(self, session: Session) -> None:
        seen: list[str] = []

        def read_line() -> str:
            seen.append("".join(session.written))
            return "\n"

        session.interpreter.streams.keyboard = Keyboard(read_line)
        session.run('to f\nprint 1\nprint 2\nend\nstep "f f')
        assert seen == ["[print 1] >>> ", "[print 1] >>> 1\n[print 2] >>> "]

    def test_macros_and_what_a_program_has_defined(self, session: Session) -> None:
        types(session, "\n" * 9)
        assert session.run('.macro m\noutput [print 5]\nend\nstep "m m') == "[output [print 5]] >>> 5\n"
        program = 'define "d [[a] [print :a] [] [print "x]] step "d d 7'
        assert session.run(program) == '[print :a] >>> 7\n[print "x] >>> x\n'

    def test_goto_does_not_begin_the_line_of_its_tag(self, session: Session) -> None:
        types(session, "\n" * 9)
        program = 'to f\ngoto "there\nprint 0\ntag "there print 1\nprint 2\nend\nstep "f f'
        assert session.run(program) == '[goto "there] >>> 1\n[print 2] >>> 2\n'
        program = 'to g\ntag "here print 3\nend\nstep "g g'
        assert session.run(program) == '[tag "here print 3] >>> 3\n'

    def test_lines_are_shown_on_the_screen_wherever_the_program_writes(self, session: Session) -> None:
        types(session, "\n")
        program = (
            'to f\nprint 1\nend\nmake "b [text 100] openwrite :b setwrite :b step "f f setwrite [] close :b'
        )
        assert session.run(program + " show :text") == "[print 1] >>> 1\n\n"

    def test_what_is_typed_before_return_runs_there(self, session: Session) -> None:
        types(session, 'print :n\nprint repeat 2 [\nfd 1]\nmake "n 7\nprint :nix\n\n')
        told = session.run('to f :n\nprint :n\nend\nstep "f f 3')
        assert told.startswith("[print :n] >>> 3\n[print :n] >>> > ")
        assert "repeat didn't output to print in f" in told
        assert "nix has no value in f" in told
        assert told.endswith("[print :n] >>> 7\n")
        assert session.turtle.pose.y_mm == pytest.approx(2.0)

    def test_continue_ends_the_stepping_of_this_run(self, session: Session) -> None:
        types(session, "\nco\n" + "\n" * 5)
        program = 'to f\nprint 1\nprint 2\nprint 3\nend\nstep "f f f'
        assert session.run(program) == "[print 1] >>> 1\n[print 2] >>> 2\n3\n1\n2\n3\n"
        assert session.run("f").startswith("[print 1] >>> 1\n[print 2] >>> 2\n")

    @pytest.mark.parametrize(
        ("typed", "printed"), [("stop", "9\n"), ('throw "toplevel', ""), ('throw "out', "8\n9\n")]
    )
    def test_it_can_end_the_procedure_or_more(self, session: Session, typed: str, printed: str) -> None:
        types(session, typed + "\n")
        program = 'to f\nprint 1\nprint 2\nend\nstep "f catch "out [f] if :x [print 8] print 9\n'
        told = session.run('make "x equalp "t "' + ("t" if "out" in typed else "f") + "\n" + program)
        assert told == "[print 1] >>> " + printed
        types(session, "output 6\n")
        assert session.run("print f") == "[print 1] >>> 6\n"

    def test_at_the_end_of_what_is_typed_it_goes_on_and_says_so_once(self, session: Session) -> None:
        types(session, "\n")
        program = 'to f\nprint 1\nprint 2\nprint 3\nend\nstep "f f'
        told = f"[print 1] >>> 1\n[print 2] >>> \n{ALONE}2\n[print 3] >>> \n3\n"
        assert session.run(program) == told

    def test_where_nobody_can_type_nothing_is_read(
        self, session: Session, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("sys.stdin", io.StringIO("data\nmore\n"))
        told = session.run('to f\nprint 1\nprint 2\nend\nstep "f f print readword f')
        assert told == (
            f"[print 1] >>> \n{ALONE}1\n[print 2] >>> \n2\ndata\n[print 1] >>> \n1\n[print 2] >>> \n2\n"
        )

    def test_the_prompt_asks_where_there_is_one(self, session: Session) -> None:
        asked: list[str] = []

        def ask(prompt: str) -> str:
            asked.append(prompt)
            return ""

        session.interpreter.ask = ask
        assert session.run('to f\nprint 1\nend\nstep "f f') == "1\n"
        assert asked == ["[print 1] >>> "]

    def test_others_are_compiled_as_before(self, session: Session) -> None:
        types(session, "\n" * 9)
        program = 'to f :n\noutput g :n\nend\nto g :n\noutput :n + 1\nend\nstep "f print f 1'
        assert session.run(program) == "[output g :n] >>> 2\n"
        procedure = session.interpreter.procedures["g"]
        assert getattr(procedure, "function", None) is not None

    def test_stepped_variables_tell_when_they_are_hidden(self, session: Session) -> None:
        """As UCBLogo told it, its two spaces included; but that there FOREACH is a procedure, too."""
        program = """\
step [[] [x y z]]
to h :x [:y 3] [:z] 3
output :x
end
to k
local "y
op (h 1) + 1
end
to l :a
local [z q x]
localmake "y 2
k2 :a
end
to k2 :x
end
"""
        called = "{} shadowed by local in procedure call"
        hidden = "".join([called.format(name) + "\n" for name in "xyz"])
        assert session.run(program + "print (h 3 4)") == hidden + "3\n"
        in_k = "".join([called.format(name) + "  in k\n[op (h 1) + 1]\n" for name in "xyz"])
        assert session.run("print k") == called.format("y") + '  in k\n[local "y]\n' + in_k + "2\n"
        assert session.run("l 3") == (
            called.format("z") + "  in l\n[local [z q x]]\n" + called.format("x") + "  in l\n[local [z q x]]\n"
            + called.format("y") + '  in l\n[localmake "y 2]\n' + called.format("x") + "  in l\n[k2 :a]\n"
        )  # fmt: skip
        assert session.run('local "x make "x 3 repeat 1 [print :x]') == "3\n"
        assert session.run("foreach [1] [[x] print :x]") == called.format("x") + "\n1\n"
        assert session.run("for [x 1 2] [print :x]") == called.format("x") + "\n1\n2\n"
        assert session.run("unstep [[] [x]] foreach [1] [[x] print :x]") == "1\n"


def test_pause_asks_a_keyboard(session: Session) -> None:
    types(session, "print :n\nprint [\n1]\nco 5\n")
    assert session.run("to f :n\nprint pause\nend\nf 3") == "Pausing...\nf? 3\nf? > 1\nf? 5\n"


LOOKED_AT = """\
to tri :n
  if :n = 0 [stop]
  repeat 2 [
    fd 3
    rt 90
  ]
  tri :n - 1
end
repeat 2 [fd 50 rt 90]
if 1 = 1 [
  print 1
  print 2
]
tri 1
print "end
"""


class Front:
    """Gives these orders, one at each stop, and the last of them from then on; notes where they were given."""

    def __init__(self, session: Session, *orders: Order, begins: Order = Order.INTO) -> None:
        self.orders = list(orders)
        self.stops: list[tuple[Moment, Reason]] = []
        self.debugger = Debugger(self, begins)
        session.interpreter.attach(self.debugger)

    def __call__(self, moment: Moment, reason: Reason) -> Order:
        assert (self.debugger.moment, self.debugger.reason) == (moment, reason)
        self.stops.append((moment, reason))
        return self.orders.pop(0) if len(self.orders) > 1 else self.orders[0]

    @property
    def lines(self) -> list[int]:
        return [moment.position.line for moment, _ in self.stops if moment.position is not None]


class TestOrders:
    def test_into_stops_before_each_line(self, session: Session) -> None:
        front = Front(session, Order.INTO)
        assert session.run(LOOKED_AT) == "1\n2\nend\n"
        round_of_tri = [2, 3, 4, 5, 4, 5, 7]
        assert front.lines == [9, 9, 9, 10, 11, 12, 14, *round_of_tri, 2, 2, 15]
        moments = [moment for moment, _ in front.stops]
        assert {reason for _, reason in front.stops} == {Reason.STEP}
        first, round_1, round_2 = moments[:3]
        assert first.position is not None
        assert first.position.file == "test.logo"
        assert (first.procedure, first.depth, first.text) == ("", 0, "repeat 2 [fd 50 rt 90]")
        assert [each.position and each.position.column for each in (first, round_1, round_2)] == [1, 11, 11]
        assert (moments[7].procedure, moments[7].depth, moments[7].text) == ("tri", 1, "if :n = 0 [stop]")

    def test_over_stays_where_it_is(self, session: Session) -> None:
        front = Front(session, Order.OVER)
        assert session.run(LOOKED_AT) == "1\n2\nend\n"
        assert front.lines == [9, 10, 14, 15]
        # Into TRI, over its lines; what takes its place at its end is not stopped in.
        front = Front(session, *[Order.OVER] * 2, Order.INTO, Order.OVER)
        session.run(LOOKED_AT)
        assert front.lines == [9, 10, 14, 2, 3, 7, 15]
        # Within the REPEAT it stays there until that ends.
        front = Front(session, *[Order.OVER] * 2, *[Order.INTO] * 3, Order.OVER)
        session.run(LOOKED_AT)
        assert front.lines == [9, 10, 14, 2, 3, 4, 5, 4, 5, 7, 15]

    def test_over_the_last_line_of_a_list_that_is_the_last_instruction(self, session: Session) -> None:
        program = "to f :n\nif :n > 0 [\nfd 1\nf :n - 1\n]\nend\nf 2\nprint 1"
        front = Front(session, Order.INTO, Order.OVER)
        session.run(program)
        assert front.lines == [7, 2, 8]  # the list belongs to line 2
        front = Front(session, Order.INTO, Order.INTO, Order.INTO, Order.OVER)
        session.run(program)
        assert front.lines == [7, 2, 3, 4, 8]

    def test_out_ends_the_procedure(self, session: Session) -> None:
        program = "to f\ng\nprint 1\nend\nto g\nrepeat 2 [\nfd 1\n]\nprint 2\nend\nf\nprint 3"
        front = Front(session, *[Order.INTO] * 3, Order.OUT)
        assert session.run(program) == "2\n1\n3\n"
        assert front.lines == [11, 2, 6, 7, 3, 12]

    def test_on_goes_to_the_end_and_the_next_program_begins_as_it_should(self, session: Session) -> None:
        front = Front(session, Order.ON)
        assert session.run(LOOKED_AT) == "1\n2\nend\n"
        assert front.lines == [9]
        session.run(LOOKED_AT)
        assert front.lines == [9, 9]
        front = Front(session, Order.INTO, begins=Order.ON)
        session.run(LOOKED_AT)
        assert front.lines == []

    def test_end_ends_it(self, session: Session) -> None:
        front = Front(session, Order.INTO, Order.END)
        with pytest.raises(StoppedError, match="the program was stopped"):
            session.run("print 1\nprint 2")
        assert session.written == ["1\n"]
        assert front.lines == [1, 2]
        assert front.debugger.reason is None

    def test_what_the_front_end_raises_ends_the_program_too(self, session: Session) -> None:
        def on_stop(_moment: Moment, _reason: Reason) -> Order:
            raise StoppedError("nobody looks any longer")

        session.interpreter.attach(Debugger(on_stop, Order.INTO))
        with pytest.raises(StoppedError, match="nobody looks"):
            session.run("print 1")
        session.interpreter.attach(None)
        assert session.run("print 1") == "1\n"

    def test_nothing_of_onstop_is_looked_at(self, session: Session) -> None:
        front = Front(session, Order.INTO, Order.END)
        with pytest.raises(StoppedError):
            session.run("onstop [print 7\nprint 8]\nprint 2")
        assert session.written == ["7\n", "8\n"]
        assert front.lines == [1, 3]

    def test_an_error_leaves_no_level_behind(self, session: Session) -> None:
        program = 'to f\nrepeat 2 [\nprint :nix\n]\nend\ncatch "error [\nf\n]\nprint 1'
        front = Front(session, *[Order.INTO] * 4, Order.OVER)
        assert session.run(program) == "1\n"
        assert front.lines == [6, 7, 2, 3, 9]

    def test_lists_in_the_place_of_lists_are_no_deeper(self, session: Session) -> None:
        depths: set[int] = set()

        def on_stop(_moment: Moment, _reason: Reason) -> Order:
            depths.add(len(debugger._lines))
            return Order.INTO

        debugger = Debugger(on_stop, Order.INTO)
        session.interpreter.attach(debugger)
        program = '.macro again :n\nif :n = 0 [output [print 7]]\noutput (list "again :n - 1)\nend\nagain 50'
        assert session.run(program) == "7\n"
        assert max(depths) < 6

    def test_what_no_file_contains(self, session: Session) -> None:
        front = Front(session, Order.INTO)
        session.run('define "f (list [] (list "print 1) (list "print 2))\nf')
        f = [moment for moment, _ in front.stops if moment.procedure == "f"]
        assert [(moment.position, moment.text) for moment in f] == [(None, "[print 1]"), (None, "[print 2]")]

    def test_two_lines_of_a_procedure_in_one_line_of_the_file(self, session: Session) -> None:
        front = Front(session, Order.INTO)
        session.run('define "f [[] [print 1 print 2] [print 3]]\nf')
        columns = [moment.position.column for moment, _ in front.stops[2:] if moment.position is not None]
        assert columns == [16, 34]

    def test_a_word_that_is_known_only_when_it_runs_is_one_stop(self, session: Session) -> None:
        front = Front(session, Order.INTO)
        session.run('define "f [[]] f\nprint 2')
        assert front.lines == [1, 2]


class TestBreakpoints:
    def test_each_time_the_line_begins(self, session: Session) -> None:
        front = Front(session, Order.ON, begins=Order.ON)
        front.debugger.breakpoints = frozenset({("test.logo", 5), ("test.logo", 9), ("other.logo", 10)})
        assert session.run(LOOKED_AT) == "1\n2\nend\n"
        assert front.lines == [9, 5, 5]
        assert {reason for _, reason in front.stops} == {Reason.BREAKPOINT}

    def test_each_time_a_procedure_comes_by(self, session: Session) -> None:
        front = Front(session, Order.ON, begins=Order.ON)
        front.debugger.breakpoints = frozenset({("test.logo", 2)})
        assert session.run("to f :n\nif :n > 0 [f :n - 1] print :n\nend\nf 2") == "0\n1\n2\n"
        assert front.lines == [2, 2, 2]

    def test_in_a_file_that_is_loaded(
        self, session: Session, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.chdir(tmp_path)
        (tmp_path / "part.logo").write_text("to f\nprint 1\nend\nprint 2\n")
        front = Front(session, Order.ON, begins=Order.ON)
        front.debugger.breakpoints = frozenset({("part.logo", 2), ("part.logo", 4)})
        assert session.run('load "part.logo\nf') == "2\n1\n"
        assert front.lines == [4, 2]

    def test_over_and_out_stop_at_them(self, session: Session) -> None:
        front = Front(session, Order.OVER)
        front.debugger.breakpoints = frozenset({("test.logo", 7)})
        session.run(LOOKED_AT)
        assert front.lines == [9, 10, 14, 7, 15]

    def test_step_stops_at_the_front_end(self, session: Session) -> None:
        front = Front(session, Order.ON, begins=Order.ON)
        assert session.run('to f\nprint 1\nprint 2\nend\nstep "f f unstep "f f') == "1\n2\n1\n2\n"
        assert front.lines == [2, 3]
        assert session.interpreter.debugger is front.debugger

    def test_pause_stops_at_the_front_end(self, session: Session) -> None:
        front = Front(session, Order.ON, begins=Order.ON)
        assert session.run("print 1\npause\nprint 2") == "1\n2\n"
        assert front.stops[0][1] is Reason.PAUSE
        assert front.lines == [2]


class TestWhileItStands:
    def test_instructions_run_there_and_variables_are_seen(self, session: Session) -> None:
        own: list[object] = []

        def on_stop(moment: Moment, _reason: Reason) -> Order:
            if moment.procedure != "f":
                return Order.INTO
            own.append(debugger.own_variables(session.interpreter))
            debugger.run_here(session.interpreter, 'print list :n :m\nmake "n 5\nrepeat 2 [fd 1]')
            with pytest.raises(LogoError, match="nix has no value in f"):
                debugger.run_here(session.interpreter, "print :nix")
            return Order.ON

        debugger = Debugger(on_stop, Order.INTO)
        session.interpreter.attach(debugger)
        assert session.run('make "m 1\nto f :n\nprint :n\nend\nf 2 print :m') == "2 1\n5\n1\n"
        assert own == [{"n": 2}]
        assert session.turtle.pose.y_mm == pytest.approx(2.0)

    def test_it_can_end_the_procedure(self, session: Session) -> None:
        def on_stop(moment: Moment, _reason: Reason) -> Order:
            if moment.procedure == "f":
                debugger.run_here(session.interpreter, "output 7")
            return Order.INTO

        debugger = Debugger(on_stop, Order.INTO)
        session.interpreter.attach(debugger)
        assert session.run("to f\noutput 1\nend\nprint f") == "7\n"


class Elsewhere:
    """A program in a thread, whose front end is here."""

    def __init__(self, program: str, begins: Order = Order.ON) -> None:
        self.written: list[str] = []
        self.logo = Interpreter(ScreenTurtle(), self.written.append, random.Random(0))
        self.debugger = Debugger(self._stopped, begins)
        self.logo.attach(self.debugger)
        self._moments: queue.Queue[tuple[Moment, Reason]] = queue.Queue()
        self._orders: queue.Queue[Order] = queue.Queue()
        self.raised: list[BaseException] = []
        self.thread = threading.Thread(target=self._run, args=(program,), daemon=True)
        self.thread.start()

    def _run(self, program: str) -> None:
        try:
            self.logo.run(program, "test.logo")
        except (LogoError, StoppedError) as error:
            self.raised.append(error)

    def _stopped(self, moment: Moment, reason: Reason) -> Order:
        self._moments.put((moment, reason))
        return self._orders.get(timeout=20)

    def stop_there(self) -> tuple[Moment, Reason]:
        return self._moments.get(timeout=20)

    def go(self, order: Order) -> None:
        self._orders.put(order)

    def ended(self) -> BaseException | None:
        self.thread.join(timeout=20)
        assert not self.thread.is_alive()
        return self.raised[0] if self.raised else None


@pytest.fixture
def endless() -> Iterator[list[Elsewhere]]:
    running: list[Elsewhere] = []
    yield running
    for each in running:
        each.debugger.stop()
        each.go(Order.END)


class TestFromAnotherThread:
    def test_pause_look_and_go_on(self, endless: list[Elsewhere]) -> None:
        program = Elsewhere('make "n 0\nforever [\nmake "n :n + 1\nif :n < 0 [print 1]\n]')
        endless.append(program)
        program.debugger.pause()
        moment, reason = program.stop_there()
        assert reason is Reason.PAUSE
        assert program.debugger.moment == moment
        program.go(Order.INTO)
        again, reason = program.stop_there()
        assert reason is Reason.STEP
        assert again != moment
        program.debugger.breakpoints = frozenset({("test.logo", 4)})
        program.go(Order.ON)
        where, reason = program.stop_there()
        assert reason is Reason.BREAKPOINT
        assert where.position is not None
        assert where.position.line == 4
        program.go(Order.END)
        assert isinstance(program.ended(), StoppedError)

    @pytest.mark.parametrize(
        "tight",
        [
            "forever []",
            "forever [print 1]",
            'while ["true] []',
            'do.until [] ["false]',
            "to f\nf\nend\nf",
            "to f :n\noutput f :n\nend\nprint f 1",
            "forever [ignore map [? * 2] [1 2 3]]",
        ],
    )
    def test_stop_ends_a_tight_loop(self, endless: list[Elsewhere], tight: str) -> None:
        program = Elsewhere(tight, Order.INTO)
        endless.append(program)
        program.stop_there()
        program.go(Order.ON)
        program.debugger.stop()
        assert isinstance(program.ended(), StoppedError)

    def test_where_it_is_now(self, endless: list[Elsewhere]) -> None:
        program = Elsewhere("to f\nforever [\nignore 1\n]\nend\nf", Order.ON)
        endless.append(program)
        while True:
            moment = program.debugger.moment
            if moment is not None and moment.position is not None and moment.position.line == 3:
                break
        assert (moment.procedure, moment.depth, moment.text) == ("f", 1, "ignore 1")


@pytest.mark.parametrize("order", [Order.ON, Order.INTO, Order.OVER])
def test_programs_mean_the_same_while_they_are_looked_at(session: Session, order: Order) -> None:
    program = LOOKED_AT + STEPPED + 'outer 4\nprint map [? * 2] [1 2 3]\ncatch "x [repeat 3 [throw "x]]\n'
    plain = session.run(program)
    front = Front(session, order, begins=order)
    assert session.run(program) == plain
    assert not front.debugger._lines
    assert not front.debugger._bodies
