"""What the tests of Logo run programs with."""

from __future__ import annotations

import random
from typing import TYPE_CHECKING

import pytest

from turtlewire.logo import Interpreter, LogoError, ScreenTurtle

if TYPE_CHECKING:
    from collections.abc import Callable


class Session:
    """An interpreter with a screen turtle, and what its programs print."""

    def __init__(self, turtle: ScreenTurtle | None = None, step_mm: float = 1.0) -> None:
        self.turtle = turtle or ScreenTurtle()
        self.written: list[str] = []
        self.interpreter = Interpreter(self.turtle, self.written.append, random.Random(0), step_mm)

    def run(self, program: str) -> str:
        """What the program prints."""
        self.written.clear()
        self.interpreter.run(program, "test.logo")
        return "".join(self.written)

    def error(self, program: str) -> LogoError:
        """The error that ends the program."""
        with pytest.raises(LogoError) as caught:
            self.run(program)
        return caught.value


@pytest.fixture
def session() -> Session:
    return Session()


@pytest.fixture
def make_session() -> Callable[..., Session]:
    return Session
