"""WALTER, the host's end: a state machine that decides which bytes go out when, and what answers mean.

Sans-IO: time is an argument (seconds, any monotonic clock), bytes go in and out as values. The rules:

- Commands go out in order while at most ``max_unfenced`` bytes are unfenced (W9): sent, and not yet known to be carried
  out. The answer to a query shows that everything before it is done, so queries are sent as fences, rotating
  through QH, QX, QY, QP: a late answer cannot pass for the next one.
- An answer that is overdue is asked for again by the next fence, and once more. If one of these is answered and the
  first is not, the first was lost: ``FenceLost``, and where the robot is has to be asked (W15). If nothing is
  answered: ``Silent``.
- A robot that answers no queries (``answers = False``) gets one command at a time, paced by the time it takes (W9).
- A limit event makes the emergency stop go out at once (W13), ahead of everything.
- ``attention`` (W7) and ``emergency_stop`` (W8) overtake and forget everything that has not gone out.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from turtlewire.protocols.message import Malformed
from turtlewire.protocols.round_trips import RoundTrips
from turtlewire.protocols.walter.codec import Mode, ReplyDecoder, encode
from turtlewire.protocols.walter.messages import (
    ATTENTION,
    BAUD,
    EMERGENCY_STOP,
    MAX_UNFENCED_BYTES,
    REPLIES,
    DirectKey,
    EmptyLine,
    LogoCommand,
    QueryHeading,
    QueryPen,
    QueryX,
    QueryY,
    RobotMessage,
    SelectLogo,
)
from turtlewire.protocols.walter.robot import LIMITS

FENCES: tuple[type[LogoCommand], ...] = (QueryHeading, QueryX, QueryY, QueryPen)
FENCE_BYTES = 3
# A fence after so many bytes: often enough that the window never runs empty, seldom enough to cost little.
FENCE_EVERY_BYTES = 12
# An answer is overdue when it takes this many times what the calibration says, and a second.
PATIENCE = 2.0
GRACE_S = 1.0
# How often an overdue answer is asked for again. Once is not enough: where the end of a line got lost, the robot takes
# the next line for its end.
MAX_PROBES = 2
# A stop, or an attention that nobody answers, may be damaged on its way, and nobody would notice: so it is sent more
# than once. To a robot that has stopped, another one is nothing. The first of them still fits its receive ring (W9).
STOPS_HEARD = 3
# After a pause this long the rest of a cut-off reply no longer comes.
INTER_BYTE_S = 0.25


class Done(NamedTuple):
    """A command is known to be carried out; with the tag it was submitted with."""

    command: LogoCommand
    tag: object


class Answer(NamedTuple):
    """The robot answered a query."""

    query: LogoCommand
    reply: RobotMessage
    tag: object


class Limit(NamedTuple):
    """A limit sensor tripped; the emergency stop is on its way already (W13)."""

    sensor: str


class FenceLost(NamedTuple):
    """A query went unanswered though a later one was answered: something was lost on the wire (W15).

    ``uncertain`` are the tags of the commands before the later one: what became of them is not known.
    """

    uncertain: tuple[object, ...]


class Silent(NamedTuple):
    """The robot answers no query any more."""


class LinkLost(NamedTuple):
    """The link ended. ``unfinished`` are the tags of all commands not known to be carried out, in order.

    Those that had been sent are ``abandoned``, too: they may have been carried out (W15). None is sent again.
    """

    unfinished: tuple[object, ...]


Event = Done | Answer | Limit | FenceLost | Silent | LinkLost


class _Flight(NamedTuple):
    """A command that has been sent and is not known to be carried out."""

    command: LogoCommand
    size: int
    takes_s: float
    tag: object
    sent_at: float  # nan: other things were under way


class Host:
    """The host's end of the wire.

    Args:
        baud: of the line, to know how long bytes take.
        max_unfenced: bytes, at least 16 (W9).
        heartbeat_s: send an empty line whenever nothing else was sent for so long, to feed a watchdog; None: never.

    Attributes:
        answers: whether the robot answers queries. While False, commands are paced by their duration.
        mode: what the robot takes bytes for, as far as the host has told it; None before the first attention.
        interrupted: the tag of the first command that an attention, stop or lost link found unconfirmed, and (for a
            robot that is paced, where only one is under way) the part of it that was done by then, 0..1, by the clock.
        abandoned: the tags of all commands that these found unconfirmed, in order; whoever sees to them clears both.
        attentions: how often the robot's attention was sought (W7); retries: how often an overdue answer was asked for
            again.
        malformed: ill-formed replies; skipped_bytes: of them; unexpected: replies to nothing that was asked. All are
            ignored.
        round_trips: how long answers took, of queries sent while nothing else was under way.
    """

    def __init__(
        self,
        *,
        baud: int = BAUD,
        max_unfenced: int = MAX_UNFENCED_BYTES,
        heartbeat_s: float | None = None,
    ) -> None:
        self._byte_s = 10.0 / baud
        self._max_unfenced = max_unfenced
        self._heartbeat_s = heartbeat_s
        self._decoder = ReplyDecoder()
        self._queue: deque[tuple[LogoCommand, float, object]] = deque()
        self._flights: deque[_Flight] = deque()
        self._urgent = b""
        self._unfenced = 0
        self._since_fence = 0
        self._fence_wanted = False
        self._probe_wanted = False
        self._next_fence = 0
        self._busy_until = -math.inf
        self._answer_due = math.inf
        self._probes = 0
        self._last_sent = -math.inf
        self._last_received = -math.inf
        self.answers = True
        self.interrupted: tuple[object, float] | None = None
        self.abandoned: tuple[object, ...] = ()
        self.mode: Mode | None = None
        self.commands_sent = 0
        self.fences_sent = 0
        self.fences_lost = 0
        self.attentions = 0
        self.retries = 0
        self.malformed = 0
        self.skipped_bytes = 0
        self.unexpected = 0
        self.round_trips = RoundTrips()

    # ------------------------------------------------------------------ what the host wants

    def submit(self, command: LogoCommand, duration_s: float = 0.0, tag: object = None) -> None:
        """Have a Logo command sent as soon as its turn and the window allow.

        ``duration_s`` is how long the robot should take for it. ``tag`` comes back with ``Done`` or ``Answer``.
        Raises ``MessageError`` if a field is out of range: nothing is sent then.
        """
        command.check()
        self._queue.append((command, duration_s, tag))

    def fence(self) -> None:
        """Have everything submitted so far confirmed by an answer."""
        self._fence_wanted = True

    def press(self, key: DirectKey) -> None:
        """Send a key of direct control at once. It is the caller's to be in direct control."""
        self._urgent += encode(key)
        if isinstance(key, SelectLogo):
            self.mode = Mode.LOGO

    def attention(self, now: float) -> None:
        """W7: from any state to: stopped, nothing queued, Logo control."""
        self._forget(now)
        self.attentions += 1
        self._urgent = ATTENTION
        if not self.answers:
            # In Logo control, 1 RET RET is an ill-formed line and an empty one: no harm.
            again = encode(SelectLogo()) + 2 * encode(EmptyLine())
            self._urgent = EMERGENCY_STOP * (STOPS_HEARD - 1) + ATTENTION + again
        self.mode = Mode.LOGO

    def emergency_stop(self, now: float) -> None:
        """W8: from any state to: stopped, direct control. Goes out before anything else."""
        self._forget(now)
        self._urgent = EMERGENCY_STOP * STOPS_HEARD
        self.mode = Mode.DIRECT

    def link_lost(self, now: float) -> list[Event]:
        """The link ended: forget everything. Nothing is sent before the next attention, not even a heartbeat."""
        unfinished = (*self.unconfirmed, *(tag for _, _, tag in self._queue))
        self._forget(now)
        self._decoder.reset()
        self._urgent = b""
        self.mode = None
        return [LinkLost(unfinished)]

    def _forget(self, now: float) -> None:
        if self._flights:
            first = self._flights[0]
            left = max(0.0, self._busy_until - now)
            self.abandoned += tuple(flight.tag for flight in self._flights)
            self.interrupted = self.interrupted or (first.tag, 1.0 - min(1.0, left / first.takes_s))
        self._queue.clear()
        self._flights.clear()
        self._unfenced = self._since_fence = self._probes = 0
        self._fence_wanted = self._probe_wanted = False
        self._busy_until = -math.inf
        self._answer_due = math.inf

    # ------------------------------------------------------------------ what is under way

    @property
    def unsent(self) -> int:
        """Commands that have not gone out yet."""
        return len(self._queue)

    @property
    def unfenced_bytes(self) -> int:
        """Bytes sent and not yet known to be carried out: at most ``max_unfenced`` (W9)."""
        return self._unfenced

    @property
    def unconfirmed(self) -> tuple[object, ...]:
        """The tags of commands sent and not yet known to be carried out, in order."""
        return tuple(flight.tag for flight in self._flights)

    @property
    def idle(self) -> bool:
        """Nothing to send, and everything that was sent is known to be carried out."""
        return not (self._queue or self._flights or self._urgent)

    # ------------------------------------------------------------------ bytes out

    def urgent_to_send(self) -> bytes:
        """Bytes that overtake whatever has been handed to the operating system and has not left it."""
        data, self._urgent = self._urgent, b""
        return data

    def data_to_send(self, now: float) -> bytes:
        """Bytes to send now; call it again after every event and at ``next_timeout``."""
        if self.mode is not Mode.LOGO:
            return self._heartbeat(now)
        out = self._fenced(now) if self.answers else self._paced(now)
        if out:
            self._last_sent = now
            return out
        return self._heartbeat(now)

    def _heartbeat(self, now: float) -> bytes:
        if self._heartbeat_s is None or self.mode is None or now < self._last_sent + self._heartbeat_s:
            return b""
        self._last_sent = now
        return encode(EmptyLine())

    def _fenced(self, now: float) -> bytes:
        out = b""
        if self._probe_wanted:
            self._probe_wanted = False
            out = self._send_fence(now)
        limit = self._max_unfenced - MAX_PROBES * FENCE_BYTES  # which stay free for asking again
        while self._queue:
            command, duration_s, tag = self._queue[0]
            is_query = type(command) in REPLIES
            size = len(encode(command))
            if self._unfenced + size + (0 if is_query else FENCE_BYTES) > limit:
                return out + self._fence_if_open(now)
            self._queue.popleft()
            out += self._send(command, duration_s, tag, now)
            if self._since_fence >= FENCE_EVERY_BYTES:
                out += self._fence_if_open(now)
        if self._fence_wanted:
            out += self._fence_if_open(now)
            self._fence_wanted = False
        return out

    def _fence_if_open(self, now: float) -> bytes:
        """A fence, if something was sent after the last query."""
        return self._send_fence(now) if self._since_fence else b""

    def _send_fence(self, now: float) -> bytes:
        query = FENCES[self._next_fence]()
        self._next_fence = (self._next_fence + 1) % len(FENCES)
        self.fences_sent += 1
        return self._send(query, 0.0, None, now)

    def _send(self, command: LogoCommand, duration_s: float, tag: object, now: float) -> bytes:
        data = encode(command)
        self.commands_sent += 1
        takes_s = len(data) * self._byte_s + duration_s
        self._flights.append(_Flight(command, len(data), takes_s, tag, math.nan if self._flights else now))
        self._unfenced += len(data)
        self._since_fence += len(data)
        self._busy_until = now + takes_s
        if type(command) in REPLIES:
            self._since_fence = 0
            if self._answer_due == math.inf:
                self._answer_due = self._due(now)
        return data

    def _due(self, now: float) -> float:
        """When the answer to the first query under way is overdue."""
        takes_s = 0.0
        for flight in self._flights:
            takes_s += flight.takes_s
            if type(flight.command) in REPLIES:
                return now + PATIENCE * takes_s + GRACE_S
        return math.inf

    def _paced(self, now: float) -> bytes:
        if self._flights or not self._queue:
            return b""
        return self._send(*self._queue.popleft(), now)

    # ------------------------------------------------------------------ bytes in

    def receive_data(self, data: bytes, now: float) -> list[Event]:
        """Take bytes from the robot; return what they mean, in order."""
        if now - self._last_received > INTER_BYTE_S:
            self._decoder.reset()
        self._last_received = now
        events: list[Event] = []
        for item in self._decoder.receive_data(data):
            if isinstance(item, Malformed):
                self.malformed += 1
                self.skipped_bytes += len(item.raw)
            elif isinstance(item.message, RobotMessage):
                events += self._received(item.message, now)
        return events

    def _received(self, message: RobotMessage, now: float) -> list[Event]:
        for sensor, limit_type in LIMITS.items():
            if isinstance(message, limit_type):
                self.emergency_stop(now)
                return [Limit(sensor)]
        index = self._asked(message)
        if index is None:
            self.unexpected += 1
            return []
        return self._answered(index, message, now)

    def _asked(self, message: RobotMessage) -> int | None:
        """The first query under way that this is the reply to."""
        for index, flight in enumerate(self._flights):
            if REPLIES.get(type(flight.command)) is type(message):
                return index
        return None

    def _answered(self, index: int, reply: RobotMessage, now: float) -> list[Event]:
        before = [self._flights.popleft() for _ in range(index)]
        flight = self._flights.popleft()
        if not math.isnan(flight.sent_at):
            self.round_trips.add(now - flight.sent_at)
        self._unfenced -= flight.size + sum(f.size for f in before)
        lost = sum(type(f.command) in REPLIES for f in before)
        events: list[Event] = [Done(f.command, f.tag) for f in before]
        if lost:
            # Where a query got lost, commands may have got lost too: none of these is confirmed (W15).
            self.fences_lost += lost
            events = [FenceLost(tuple(f.tag for f in before))]
        events.append(Answer(flight.command, reply, flight.tag))
        self._probes = 0
        self._answer_due = self._due(now)
        return events

    # ------------------------------------------------------------------ time

    def next_timeout(self) -> float:
        """When ``timed_out`` wants to be called, if nothing happens before; ``math.inf``: never."""
        due = math.inf
        if self.mode is not None and self._heartbeat_s is not None:
            due = self._last_sent + self._heartbeat_s
        if self.answers:
            return min(due, self._answer_due)
        return min(due, self._busy_until) if self._flights else due

    def timed_out(self, now: float) -> list[Event]:
        """Act on the time. Call ``data_to_send`` afterwards."""
        if not self.answers:
            if self._flights and now >= self._busy_until:
                flight = self._flights.popleft()
                self._unfenced -= flight.size
                self._since_fence = 0
                return [Done(flight.command, flight.tag)]
            return []
        if now < self._answer_due:
            return []
        if self._probes == MAX_PROBES:
            self._forget(now)
            return [Silent()]
        self._probes += 1
        self.retries += 1
        self._probe_wanted = True
        # The first query may be what was lost: then the next answer comes after all that is under way.
        self._answer_due = now + PATIENCE * sum(flight.takes_s for flight in self._flights) + GRACE_S
        return []
