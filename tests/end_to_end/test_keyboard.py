"""A program that asks whoever sits at the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .conftest import DEADLINE_S

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from .terminal import Terminal

PROGRAM = """print "begin
type [Your name? ]
make "name readword
fd 10
(print "Hello :name)
type [any key]
make "key readchar
print []
(print "key :key)
"""


def test_a_question_stands_alone_while_somebody_types(
    terminal: Callable[..., Terminal], tmp_path: Path
) -> None:
    (tmp_path / "ask.logo").write_text(PROGRAM, "utf-8")
    screen = terminal(80)
    with screen.run(["run", "ask.logo"], tmp_path) as program:
        screen.wait_for("Your name?")
        screen.wait_for_match(r"begin *\nYour name\? *\n *\n")  # and no bar below it
        screen.press("Ada\r")
        screen.wait_for("any key")
        screen.press("x")
        assert program.wait(DEADLINE_S) == 0
    lines = [line for line in screen.lines() if line]
    begin = lines.index("begin")
    assert lines[begin : begin + 5] == ["begin", "Your name?Ada", "Hello Ada", "any key", "key x"]
    assert sum("%" in line for line in lines) == 1  # the bar at its end


STEPPED = """to side :n
  fd :n rt 90
  print pos
end
step "side
side 10
print "between
unstep "side
side 20
"""


def test_stepping_waits_for_return_and_shows_what_is_typed_before_it(
    terminal: Callable[..., Terminal], tmp_path: Path
) -> None:
    (tmp_path / "step.logo").write_text(STEPPED, "utf-8")
    screen = terminal(80)
    with screen.run(["logo", "step.logo"], tmp_path) as program:
        screen.wait_for_match(r"\A\[fd :n rt 90\] >>> *\n *\n")
        screen.press('make "n :n + 1 repeat 2 [\r')
        screen.wait_for_match(r"\n> *\n *\n")
        screen.press('type "x] print :n\r')
        screen.wait_for("xx11")
        screen.press("\r")
        screen.wait_for("[print pos] >>>")
        assert "0 11" not in screen.shown
        screen.press("\r")
        assert program.wait(DEADLINE_S) == 0
    assert [line for line in screen.lines() if line] == [
        '[fd :n rt 90] >>> make "n :n + 1 repeat 2 [',
        '> type "x] print :n',
        "xx11",
        "[fd :n rt 90] >>>",
        "[print pos] >>>",
        "0 11",
        "between",
        "20 11",
    ]


def test_stepping_on_a_robot_has_the_line_for_itself(
    terminal: Callable[..., Terminal], tmp_path: Path
) -> None:
    (tmp_path / "step.logo").write_text(STEPPED, "utf-8")
    screen = terminal(80)
    with screen.run(["run", "step.logo"], tmp_path) as program:
        screen.wait_for_match(r"\n?\[fd :n rt 90\] >>> *\n *\n")  # and no bar below it
        screen.press("\r")
        screen.wait_for_match(r"\[print pos\] >>> *\n *\n")
        screen.press("co\r")
        assert program.wait(DEADLINE_S) == 0
    assert "20 10" in screen.lines()


def test_a_pause_in_a_script_asks(terminal: Callable[..., Terminal], tmp_path: Path) -> None:
    (tmp_path / "pause.logo").write_text("to f :n\nprint pause\nend\nf 3\n", "utf-8")
    screen = terminal(80)
    with screen.run(["logo", "pause.logo"], tmp_path) as program:
        screen.wait_for("f? ")
        screen.press("print :n\r")
        screen.wait_for("\n3 ")
        screen.press("co 5\r")
        assert program.wait(DEADLINE_S) == 0
    assert [line for line in screen.lines() if line][-2:] == ["f? co 5", "5"]
