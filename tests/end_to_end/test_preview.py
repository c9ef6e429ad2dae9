"""``turtlewire run --preview`` on a real terminal: it asks, and nothing moves before the answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from .conftest import DEADLINE_S, Cli

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from .terminal import Terminal


@pytest.mark.parametrize(("answer", "moves"), [("y\r", True), ("n\r", False), ("\r", False), ("\x04", False)])
def test_the_question(
    terminal: Callable[..., Terminal], cli: Cli, tmp_path: Path, answer: str, moves: bool
) -> None:
    robot = cli.simulate("--listen", "pty")
    cli.program("FD 30")
    screen = terminal(90)
    process = screen.run(
        ["run", "--preview", "program.logo", "--port", robot.url, "--set", "boot_s=0"], tmp_path
    )
    try:
        screen.wait_for("Run it? [y/N]")
        assert "path       0.03 m, 0.03 m of it with the pen down" in screen.shown
        assert robot.actions == []
        screen.press(answer)
        assert process.wait(DEADLINE_S) == 0
        screen.wait_for("done" if moves else "not run")
        assert any(action.startswith("started forward") for action in robot.actions) is moves
    finally:
        process.kill()
        process.wait()
