from __future__ import annotations

import random
import sys
import threading
import tracemalloc
from typing import TYPE_CHECKING

import pytest

from turtlewire.errors import LimitReachedError, LinkClosedError
from turtlewire.logo import Interpreter, ScreenTurtle
from turtlewire.logo.room import RESERVE

if TYPE_CHECKING:
    from collections.abc import Callable

    from .conftest import Session

LIMIT = ("front", 1.0, 2.0, 3.0)


class BumpingTurtle(ScreenTurtle):
    """A turtle whose forward raises these errors, one after the other, and then works."""

    def __init__(self, *errors: BaseException) -> None:
        super().__init__()
        self.errors = list(errors)

    def forward(self, distance_mm: float) -> None:
        if distance_mm > 0 and self.errors:
            raise self.errors.pop(0)
        super().forward(distance_mm)


class TestDepth:
    def test_recursion_that_is_not_last_goes_deep(self, session: Session) -> None:
        program = "to d :n\nif :n = 0 [output 0]\noutput 1 + d :n - 1\nend\nprint d 12000"
        assert session.run(program) == "12000\n"

    @pytest.mark.parametrize(
        "body",
        [
            "if :n > 0 [f :n - 1]",
            "if :n = 0 [stop]\nf :n - 1",
            "ifelse :n = 0 [] [g :n - 1]",
            'run (list "f ":n "- 1)',
        ],
    )
    def test_last_calls_take_no_depth(
        self, session: Session, body: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("turtlewire.logo.calls.MAX_DEPTH", 100)
        body = body.replace("run (list", "if :n > 0 [run (list") + ("]" if "run (list" in body else "")
        session.run(f"to f :n\n{body}\nend\nto g :n\n{body}\nend\nf 2000")

    def test_outputs_of_last_calls_take_no_depth(
        self, session: Session, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("turtlewire.logo.calls.MAX_DEPTH", 100)
        program = (
            'to e :n\nif :n = 0 [output "true]\noutput o :n - 1\nend\n'
            'to o :n\nif :n = 0 [output "false]\noutput e :n - 1\nend\nprint e 2000'
        )
        assert session.run(program) == "true\n"

    def test_last_calls_take_no_memory(self, session: Session) -> None:
        session.run("to f :n\nif :n > 0 [f :n - 1]\nend\nf 10")
        tracemalloc.start()
        session.run("f 5000")
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak - RESERVE < 100_000

    @pytest.mark.parametrize(
        "body", ["output 1 + f", "repeat 1 [f]", "output map [f] [1 2]", 'catch "x [f] print 1']
    )
    def test_without_an_end_is_an_error(self, session: Session, body: str) -> None:
        error = session.error(f"to f\n{body}\nend\nprint f")
        assert error.number == 2
        assert error.position is not None
        assert "does it ever stop" in str(error)
        assert session.run("print 1") == "1\n"

    def test_depth_does_not_touch_the_c_stack(self, session: Session) -> None:
        program = "to d :n\nif :n = 0 [output 0]\nrepeat 1 [output 1 + d :n - 1]\nend\nprint d 5000"
        written: list[str] = []
        before = threading.stack_size(256 * 1024)
        thread = threading.Thread(target=lambda: written.append(session.run(program)))
        thread.start()
        threading.stack_size(before)
        thread.join()
        assert written == ["5000\n"]

    def test_nested_parentheses(self, session: Session) -> None:
        assert session.run("print " + "(" * 5000 + "1" + ")" * 5000) == "1\n"


class TestScope:
    def test_a_last_call_sees_its_callers_variables(self, session: Session) -> None:
        assert session.run("to f :x\ng\nend\nto g\nprint :x\nend\nf 3") == "3\n"

    def test_what_was_hidden_comes_back_after_last_calls(self, session: Session) -> None:
        program = 'make "x 1\nto f :x\nif :x > 0 [f :x - 1]\nend\nf 5\nprint :x'
        assert session.run(program) == "1\n"

    def test_and_after_errors(self, session: Session) -> None:
        session.error('make "x 1\nto f :x\nfoo\nend\nf 5')
        assert session.run("print :x") == "1\n"

    def test_a_last_call_that_outputs_to_nobody(self, session: Session) -> None:
        error = session.error("to f\noutput 3\nend\nto g\nf\nend\ng")
        assert (error.text, error.procedure) == ("You don't say what to do with 3", "g")

    def test_values_that_nothing_takes(self, session: Session) -> None:
        assert session.error("to f\n3\nprint 1\nend\nf").text == "You don't say what to do with 3"
        assert session.error("to f\nprint 1\n[a]\nend\nf").text == "You don't say what to do with [a]"
        assert session.error("repeat 2 [3 print 1]").text == "You don't say what to do with 3"

    def test_inputs_of_an_output_call(self, session: Session) -> None:
        program = "to f :x\noutput :x\nend\nto g\noutput f print 1\nend\nprint g"
        assert session.error(program).text == "print didn't output to f"

    def test_output_from_within_an_input(self, session: Session) -> None:
        assert session.run('to f\nprint if "true [output 3]\nend\nprint f') == "3\n"
        assert session.run("to h\nprint sum 1 run [stop]\nend\nh") == ""
        assert session.run("to k\nif [output 7] [print 1]\nend\nprint k") == "7\n"


class TestDefinitions:
    def test_defining_anew_while_it_runs(self, session: Session) -> None:
        program = 'to f\ndefine "g [[] [print 2]]\ng\nend\nto g\nprint 1\nend\ng f'
        assert session.run(program) == "1\n2\n"

    def test_fewer_or_more_inputs_than_when_the_call_was_parsed(self, session: Session) -> None:
        head = "to g :a\nend\n"
        assert session.error(head + 'run [define "g [[a b]] g 1]').text == "not enough inputs to g"
        assert session.error(head + 'run [define "g [[]] g 1]').text == "too many inputs to g"

    def test_a_bad_default(self, session: Session) -> None:
        assert session.error("to f [:x print 1 2]\nend\n(f)").number == 37

    def test_optional_inputs_and_rest(self, session: Session) -> None:
        program = "to f :a [:b :a + 1] [:c]\nshow (list :a :b :c)\nend\nf 1 (f 1 5) (f 1 5 6 7)"
        assert session.run(program) == "[1 2 []]\n[1 5 []]\n[1 5 [6 7]]\n"

    @pytest.mark.parametrize("title", ["f [:x 1] :y", "f [:r] :y", "f []", "f [:r] [:s]", "f [[x] 1]"])
    def test_bad_titles(self, session: Session, title: str) -> None:
        assert session.error(f"to {title}\nend").number == 4


class TestLimits:
    def test_without_a_handler_the_error_goes_out_with_its_place(
        self, make_session: Callable[..., Session]
    ) -> None:
        limit = LimitReachedError(*LIMIT)
        session = make_session(BumpingTurtle(limit))
        with pytest.raises(LimitReachedError) as caught:
            session.run("to f\nrt 90 fd 10\nend\nrepeat 2 [f]")
        assert caught.value is limit
        assert limit.__notes__ == ["in test.logo, line 2, fd:\n    rt 90 fd 10\n          ^"]

    def test_the_handler_runs_in_place_of_the_command(self, make_session: Callable[..., Session]) -> None:
        session = make_session(BumpingTurtle(LimitReachedError(*LIMIT)))
        assert (
            session.run("onlimit [print limitsensor bk 5]\nfd 10 print pos\nfd 3 print pos")
            == "front\n0 -5\n0 -2\n"
        )
        assert session.turtle.is_step_by_step
        session.run("onlimit []")
        assert not session.turtle.is_step_by_step

    def test_a_limit_within_the_handler_is_an_error(self, make_session: Callable[..., Session]) -> None:
        first, second = LimitReachedError(*LIMIT), LimitReachedError(*LIMIT)
        session = make_session(BumpingTurtle(first, second))
        with pytest.raises(LimitReachedError) as caught:
            session.run("onlimit [print 1 repeat 1 [fd 1]]\nrepeat 1 [fd 10]")
        assert caught.value is second
        assert len(second.__notes__) == 1
        assert session.interpreter.events.limit is not None

    def test_unless_the_handler_installs_another(self, make_session: Callable[..., Session]) -> None:
        session = make_session(BumpingTurtle(LimitReachedError(*LIMIT), LimitReachedError(*LIMIT)))
        assert (
            session.run('onlimit [onlimit [print "two] fd 1 print "one]\nfd 10\nprint "on')
            == "two\none\non\n"
        )
        assert session.interpreter.events.limit is not None

    def test_stop_in_the_handler_ends_the_interrupted_procedure(
        self, make_session: Callable[..., Session]
    ) -> None:
        session = make_session(BumpingTurtle(LimitReachedError(*LIMIT)))
        assert session.run("onlimit [stop]\nto f\nfd 1\nprint 1\nend\nf\nprint 2") == "2\n"

    def test_other_errors_of_the_robot_get_a_note_once(self, make_session: Callable[..., Session]) -> None:
        gone = LinkClosedError("unplugged")
        session = make_session(BumpingTurtle(gone))
        with pytest.raises(LinkClosedError):
            session.run('onlimit [print 1]\nrun (list "repeat 2 [forward 1])')
        assert gone.__notes__ == [
            'in test.logo, line 2, forward:\n    run (list "repeat 2 [forward 1])\n                         ^'
        ]

    def test_a_note_without_a_place(self, make_session: Callable[..., Session]) -> None:
        gone = LinkClosedError("unplugged")
        session = make_session(BumpingTurtle(gone))
        with pytest.raises(LinkClosedError):
            session.run('run (list "forward 1)')
        assert gone.__notes__ == ["in forward"]

    def test_a_key_passes_through_everything(self, make_session: Callable[..., Session]) -> None:
        session = make_session(BumpingTurtle(KeyboardInterrupt()))
        with pytest.raises(KeyboardInterrupt):
            session.run('onlimit [print 1]\nto f :x\ncatch "error [fd 1]\nend\nf 1')
        assert session.run('print namep "x') == "false\n"


class TestProgress:
    def test_it_grows_with_the_outermost_loops(self, session: Session) -> None:
        interpreter = session.interpreter
        assert interpreter.progress() is None
        seen: list[float | None] = []
        interpreter.write = lambda _: seen.append(interpreter.progress())
        interpreter.run("repeat 4 [print 1]\nfor [i 1 2] [print 2]\nto f\nprint 3\nfd 1\npu\nprint 4\nend\nf")
        assert seen == [0.0, 0.0625, 0.125, 0.1875, 0.25, 0.375, 0.75, 0.9375]
        assert interpreter.progress() == 1.0

    def test_it_never_goes_back(self, session: Session) -> None:
        interpreter = session.interpreter
        seen: list[float] = []
        interpreter.write = lambda _: seen.append(interpreter.progress() or 0.0)
        interpreter.run(
            'to f :n\nprint 1\nprint 2\nif :n > 0 [f :n - 1]\nend\nrepeat 3 [f 3]\nfor [i 1 3 0] [throw "toplevel]'
        )
        assert seen == sorted(seen)
        assert len(seen) == 24

    def test_deep_loops_are_not_watched(self, session: Session) -> None:
        assert session.run("repeat 1 [" * 8 + "for [i 1 2] [print :i]" + "]" * 8) == "1\n2\n"

    def test_an_error_that_is_caught_leaves_its_loops(self, session: Session) -> None:
        session.run('repeat 2 [catch "error [repeat 3 [foo]]] repeat 2 [catch "t [repeat 3 [throw "t]]]')
        assert session.interpreter.progress() == 1.0

    def test_position(self, session: Session) -> None:
        interpreter = session.interpreter
        assert interpreter.position is None
        seen = []
        interpreter.write = lambda _: seen.append(interpreter.position)
        interpreter.run("print 1\nrepeat 1 [print 2]", "p.logo")
        assert [(p.file, p.line, p.column) for p in seen if p is not None] == [
            ("p.logo", 1, 1),
            ("p.logo", 2, 11),
        ]


class TestInterpreter:
    def test_the_recursion_limit_is_put_back(
        self, session: Session, make_session: Callable[..., Session]
    ) -> None:
        before, limit = sys.getrecursionlimit(), 5_000
        seen: list[int] = []

        def run_another(_: str) -> None:
            make_session().run("print 1")
            seen.append(sys.getrecursionlimit())

        session.interpreter.write = run_another
        sys.setrecursionlimit(limit)
        try:
            session.run("print 1")
            assert seen[0] > 100_000
            assert sys.getrecursionlimit() == limit
        finally:
            sys.setrecursionlimit(before)

    @pytest.mark.parametrize("step", [0.0, -1.0, float("inf"), float("nan")])
    def test_a_step_has_a_size(self, step: float) -> None:
        with pytest.raises(ValueError, match="step_mm"):
            Interpreter(ScreenTurtle(), print, random.Random(0), step)

    def test_programs_share_the_workspace(self, session: Session) -> None:
        session.run('make "x 1\nto f\nprint :x\nend')
        assert session.run("f") == "1\n"

    def test_a_program_that_cannot_be_read_does_not_begin(self, session: Session) -> None:
        session.error("fd 10\nprint [1")
        assert session.turtle.pose.y_mm == 0.0
