"""A host and a robot of simple on a simulated line, in virtual time: deterministic, and as slow as a real one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from turtlewire.protocols.simple.events import Event, InStep
from turtlewire.protocols.simple.host import Host
from turtlewire.protocols.simple.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Callable

    from turtlewire.protocols.simple.messages import SimpleCommand

    Fault = Callable[[bytes], bytes]


def clean(data: bytes) -> bytes:
    return data


class Wire:
    """Carries bytes both ways, through ``to_robot`` and ``to_host``, which may damage them.

    ``work_s`` is how long the robot takes to answer. ``executed`` is what it carried out, ``sent`` what the host sent.
    ``limit`` of steps: whoever gets there hangs.
    """

    def __init__(self, host: Host, robot: Robot, *, baud: int = 9600, work_s: float = 0.004) -> None:
        self.host = host
        self.robot = robot
        self.now = 0.0
        self.work_s = work_s
        self.to_robot: Fault = clean
        self.to_host: Fault = clean
        self.executed: list[SimpleCommand] = []
        self.events: list[Event] = []
        self.sent: list[tuple[float, bytes]] = []
        self._byte_s = 10.0 / baud
        self._free_at = 0.0
        self._replies: list[tuple[float, bytes]] = []

    def step(self, until: float = math.inf) -> bool:
        """Let the next thing happen; False if nothing will before ``until``."""
        host = self.host
        data = host.urgent_to_send() + host.data_to_send(self.now)
        if data:
            self._transmit(data)
        arrival = self._replies[0][0] if self._replies else math.inf
        next_time = min(arrival, host.next_timeout())
        if next_time > until or next_time == math.inf:
            self.now = max(self.now, until) if until < math.inf else self.now
            return False
        self.now = max(self.now, next_time)
        if arrival <= self.now:
            self._take(host.receive_data(self._replies.pop(0)[1], self.now))
        if self.now >= host.next_timeout():
            self._take(host.timed_out(self.now))
        return True

    def run(self, until: float = math.inf, limit: int = 400) -> None:
        """Until nothing happens any more, or until a time."""
        for _ in range(limit):
            if not self.step(until):
                return
        raise AssertionError(f"no end after {limit} steps: {self.events[-5:]}")

    def _transmit(self, data: bytes) -> None:
        self.sent.append((self.now, data))
        self._free_at = max(self.now, self._free_at) + len(data) * self._byte_s
        reaction = self.robot.receive_data(self.to_robot(data))
        self.executed += reaction.actions
        reply = self.to_host(reaction.replies)
        if reply:
            self._replies.append((self._free_at + self.work_s + self._byte_s, reply))

    def _take(self, events: list[Event]) -> None:
        for event in events:
            if isinstance(event, InStep):
                # The promise of S7, at the moment when the host relies on it.
                assert self.robot.pending == b""
                assert (self.robot.drive, self.robot.steer) == (0, 0)
                assert (event.state.drive, event.state.steer) == (0, 0)
        self.events += events


def connected(host: Host | None = None, robot: Robot | None = None, **settings: float) -> Wire:
    """Host and robot in step, and what it took forgotten."""
    wire = Wire(host or Host(), robot or Robot(), **settings)  # type: ignore[arg-type]
    wire.host.connect(0.0)
    wire.run(until=1.0)
    assert wire.host.in_step
    wire.executed, wire.events, wire.sent = [], [], []
    return wire
