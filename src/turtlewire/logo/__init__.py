"""Logo: reader, syntax, evaluator; knows robots only as a Turtle.

Each name is loaded when it is first used: a program that runs has no use for most of them.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.debugging import Debugger, Moment, Order, Reason
    from turtlewire.logo.errors import LogoError, Position
    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.screen import ScreenTurtle

__all__ = ["Debugger", "Interpreter", "LogoError", "Moment", "Order", "Position", "Reason", "ScreenTurtle"]

if not TYPE_CHECKING:
    _MODULES = {
        "Debugger": "debugging",
        "Interpreter": "evaluator",
        "LogoError": "errors",
        "Moment": "debugging",
        "Order": "debugging",
        "Position": "errors",
        "Reason": "debugging",
        "ScreenTurtle": "screen",
    }

    def __getattr__(name):
        if name not in _MODULES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        module = __import__(f"{__name__}.{_MODULES[name]}", fromlist=[name])
        globals()[name] = getattr(module, name)
        return globals()[name]
