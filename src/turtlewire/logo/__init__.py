"""Logo: reader, syntax, evaluator; knows robots only as a Turtle."""

from __future__ import annotations

from turtlewire.logo.debugging import Debugger, Moment, Order, Reason
from turtlewire.logo.errors import LogoError, Position
from turtlewire.logo.evaluator import Interpreter
from turtlewire.logo.screen import ScreenTurtle

__all__ = ["Debugger", "Interpreter", "LogoError", "Moment", "Order", "Position", "Reason", "ScreenTurtle"]
