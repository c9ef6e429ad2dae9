"""ONSTOP: what a program does when a stop has ended it; in a world without motion, and not for long."""

from __future__ import annotations

from turtlewire.errors import TurtlewireError
from turtlewire.logo.errors import LogoError, out_of_space, stack_overflow
from turtlewire.logo.evaluator import Interpreter
from turtlewire.logo.events import stopped
from turtlewire.logo.procedures import COMMAND, ThrowError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from turtlewire.logo.procedures import Result
    from turtlewire.logo.syntax import Code

MOST_LISTS = 10_000  # that the handler may run: who stopped the program wants control back


class _Speaker(Interpreter):
    """The interpreter that was stopped, with its whole workspace, but for a limited number of lists."""

    def __init__(self, logo: Interpreter) -> None:
        self.__dict__ = logo.__dict__
        self.lists_left = MOST_LISTS

    def run_code(self, code: Code, how: int, level: list[int] | None = None) -> Result:
        """As ``Interpreter.run_code``; raises ``LogoError`` when it has gone on for too long."""
        self.lists_left -= 1
        if self.lists_left < 0:
            raise LogoError(
                16, "Stopped", hint="ONSTOP is for a few last instructions, and this went on and on."
            )
        return super().run_code(code, how, level)


def speak(logo: Interpreter) -> None:
    """Stop all turtles, and run the ONSTOP list once, if there is one. What goes wrong in it is written."""
    handler, logo.events.stop = logo.events.stop, None
    if handler is None:
        return
    speaker = _Speaker(logo)
    from turtlewire.logo.compiler import Compiler

    turtles, turtle, compiler = logo.turtles, logo.turtle, logo.compiler
    logo.turtles = stopped(turtles)
    logo.turtle = logo.turtles.as_one(turtles.told)
    logo.events.limit = None
    logo.reset()
    debugger, logo.debugger = logo.debugger, None  # somebody has stopped it, and looks no longer
    logo.compiler = Compiler(speaker, is_used=False)  # nobody counts what compiled functions do
    logo.compiler.forget()
    try:
        speaker.run_list(handler, COMMAND)
    except ThrowError:
        pass  # it ended early
    except (LogoError, TurtlewireError) as error:
        logo.write(f"{error}\n")
    except RecursionError:
        logo.write(f"{stack_overflow()}\n")
    except MemoryError:
        logo.write(f"{out_of_space()}\n")
    finally:
        logo.turtles, logo.turtle, logo.compiler = turtles, turtle, compiler
        logo.debugger = debugger
        compiler.forget()
