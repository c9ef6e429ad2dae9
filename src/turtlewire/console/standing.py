"""A program that stands before a line, and somebody in a page who says how it goes on."""

from __future__ import annotations

import queue
from typing import TYPE_CHECKING, Any

from turtlewire.logo import Debugger, LogoError, Order, Reason
from turtlewire.logo.values import show

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from turtlewire.logo import Interpreter, Moment

# What is shown of a variable's value, at most.
LONGEST_VALUE = 200


class FrontEnd:
    """Has a program stop and go on as the server says.

    Args:
        logo: what runs the program.
        say: sends a message to the server, after what was written.
        name: of the program, for breakpoints.
        is_paused: whether it stands before its first line.
    """

    def __init__(
        self, logo: Interpreter, say: Callable[[Mapping[str, Any]], None], name: str, *, is_paused: bool
    ) -> None:
        self._logo = logo
        self._say = say
        self._name = name
        self._orders: queue.SimpleQueue[Order | str] = queue.SimpleQueue()
        self._wants_pause = False
        self._stands = False
        self._debugger = Debugger(self._stop_here, begins=Order.INTO if is_paused else Order.ON)
        logo.attach(self._debugger)

    def at(self) -> list[Any] | None:
        """File and line where the program is, the procedure that is running, and how deep; from any thread."""
        moment = self._debugger.moment
        if moment is None:
            return None
        position = moment.position
        file, line = (position.file, position.line) if position is not None else (None, None)
        return [file, line, moment.procedure, moment.depth]

    # ------------------------------------------------------------------ from the server, in the thread that listens

    def told(self, message: Mapping[str, Any]) -> None:
        """The server says: pause, go on, do something here, or stop before other lines."""
        if "pause" in message:
            self._wants_pause = True
            self._debugger.pause()
        elif "go" in message:
            self._wants_pause = False
            self._orders.put(Order(message["go"]))
        elif "do" in message:
            self._orders.put(message["do"])
        elif "breakpoints" in message:
            self.set_breakpoints(message["breakpoints"])

    def set_breakpoints(self, lines: list[int]) -> None:
        """Stop before these lines of the program."""
        self._debugger.breakpoints = frozenset((self._name, line) for line in lines)

    # ------------------------------------------------------------------ in the program's thread

    def before_motion(self) -> None:
        """The robot is about to do something: a pause does not wait for the end of a long line."""
        moment = self._debugger.moment
        if self._wants_pause and not self._stands and moment is not None:
            self._debugger.look(moment, Reason.PAUSE)

    def _stop_here(self, moment: Moment, reason: Reason) -> Order:
        """Tell that the program stands, and wait for an order. What is typed meanwhile is done here."""
        del moment
        self._wants_pause = False
        self._stands = True
        try:
            while not self._orders.empty():
                self._orders.get()  # given before it stood
            while True:
                self._say({"paused": reason.value, "at": self.at(), "variables": self._variables()})
                order = self._orders.get()
                if isinstance(order, Order):
                    self._say({"goes_on": True})
                    return order
                self._do(order)
        finally:
            self._stands = False

    def _do(self, text: str) -> None:
        try:
            self._debugger.run_here(self._logo, text)
        except LogoError as error:
            self._logo.write(f"{error}\n")

    def _variables(self) -> dict[str, str]:
        """The running procedure's own, as SHOW prints them."""
        own = self._debugger.own_variables(self._logo)
        return {name: show(value, depth=4, width=20)[:LONGEST_VALUE] for name, value in own.items()}
