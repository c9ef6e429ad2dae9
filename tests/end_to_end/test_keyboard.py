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
