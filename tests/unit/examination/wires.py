"""A simulated robot in virtual time at the end of a line whose two ends may have different rates."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from turtlewire.errors import LinkError
from turtlewire.examination.pump import carry_out
from turtlewire.links.memory import MemoryLink
from turtlewire.links.uart import ARDUINO, Receiver, image

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.examination.steps import Plan, Tell


class Line:
    """The far end of a memory link: a robot, heard and spoken to at the rate that the host has tuned to.

    Attributes:
        sent: all that the host has sent, in pieces: at which rate, and what.
        refused: rates that the port does not have.
    """

    def __init__(self, robot: Any, baud: int | None, receiver: Receiver = ARDUINO) -> None:
        self.robot = robot
        self.baud = baud
        self.host_baud: int | None = None
        self.receiver = receiver
        self.sent: list[tuple[int | None, bytes]] = []
        self.refused: set[int] = set()

    @property
    def now(self) -> float:
        return float(self.robot.now)

    def write(self, data: bytes) -> None:
        self.sent.append((self.host_baud, data))
        self.robot.write(self._image(data, self.baud, self.host_baud, self.receiver))

    def discard_output(self) -> None:
        self.robot.discard_output()

    def read(self, until: float) -> bytes:
        return self._image(self.robot.read(until), self.host_baud, self.baud, ARDUINO)

    def awaits_host(self) -> bool:
        return bool(self.robot.awaits_host())

    def port_opened(self) -> None:
        raise AssertionError("an examination opens a port once")

    async def tune(self, baud: int) -> None:
        if baud in self.refused:
            raise LinkError(f"no {baud}")
        self.host_baud = baud

    @staticmethod
    def _image(data: bytes, to: int | None, of: int | None, receiver: Receiver) -> bytes:
        return data if to is None or of is None else image(data, to / of, receiver)

    def examine(self, plan: Plan[Any], tell: Callable[[Tell], object] = lambda _: None) -> Any:
        """Carry a plan out; nothing suspends, so no event loop is needed."""
        run = carry_out(plan, MemoryLink(self), self.tune, tell)
        try:
            run.send(None)
        except StopIteration as end:
            return end.value
        raise AssertionError("it waits for something that is not virtual")


class Talker:
    """What says the same again and again, from some time on, whatever it is told; nothing, if it has nothing to say.

    Attributes:
        heard: what it was told.
    """

    def __init__(self, says: bytes = b"", every_s: float = 0.1, until_s: float = math.inf) -> None:
        self.now = 0.0
        self.heard = bytearray()
        self._says = says
        self._every_s = every_s
        self._next_s = every_s if says else math.inf
        self._until_s = until_s

    def write(self, data: bytes) -> None:
        self.heard += data

    def discard_output(self) -> None:
        pass

    def awaits_host(self) -> bool:
        return self._next_s > self._until_s

    def read(self, until: float) -> bytes:
        if self._next_s > min(until, self._until_s):
            self.now = max(self.now, until)
            return b""
        self.now, self._next_s = self._next_s, self._next_s + self._every_s
        return self._says


class Echo(Talker):
    """What sends back everything."""

    def write(self, data: bytes) -> None:
        super().write(data)
        self._says += data
        self._next_s = self.now

    def read(self, until: float) -> bytes:
        said, self._says, self._next_s = super().read(until), b"", math.inf
        return said
