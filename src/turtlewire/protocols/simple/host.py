"""simple, the host's end: a state machine that decides which bytes go out when, and what replies mean.

Sans-IO: time is an argument (seconds, any monotonic clock), bytes go in and out as values. The rules:

- Nothing is sent before ``connect``, which gets in step with the robot (S7) and leaves it stopped.
- A set-point belongs to a channel: drive, steer, lights, or one of an extension. One that has not gone out yet is
  replaced by the next one of its channel (S9), which keeps its place: no channel starves another, nothing piles up.
- At most ``window`` commands are under way; replies belong to them in order. A stop goes out next, beyond the
  window, and cancels the set-points of what it stops; headlights stay wanted, for a stop leaves them as they are.
- Silence, ``F``, or a reply too many means out of step or damaged (S8): S7, which stops the robot. Then whatever is
  still wanted is sent again; a set-point that got lost more than ``retries`` times is given up.
- ``emergency_stop`` does not wait for anything: 14 times ``S`` in one write stop a robot in any state (section 4).
"""

from __future__ import annotations

import math
from collections import defaultdict, deque

from turtlewire.errors import NoReplyError, UsageError
from turtlewire.protocols.round_trips import RoundTrips
from turtlewire.protocols.simple.codec import encode, layouts
from turtlewire.protocols.simple.events import (
    Done,
    Event,
    GaveUp,
    InStep,
    LinkDead,
    OutOfStep,
    RobotState,
    Superseded,
)
from turtlewire.protocols.simple.messages import (
    BAUD,
    EMERGENCY_STOP,
    MAX_WINDOW,
    Accepted,
    Rejected,
    SimpleCommand,
    Stop,
)
from turtlewire.protocols.simple.orders import Channel, Flight, Knowledge, Order, longest_ago
from turtlewire.protocols.simple.resynchronise import Line, Resynchronisation, Stage

# Replies too many are forgotten when the robot has been in step for so long.
SETTLED_S = 1.0
_ACCEPTED, _REJECTED = Accepted.LETTER[0], Rejected.LETTER[0]
_STOP = encode(Stop())


class Host:
    """The host's end of the wire.

    Args:
        baud: of the line, to know how long bytes take (S6).
        window: how many commands may be under way, 1 to 8 (S9).
        reply_delay_s: how long a reply may take, beyond its bytes' own time: the firmware's work and the delay of the
            adapter (S7).
        retries: how often a set-point that got lost is sent again (S8), and how often S7 begins again.
        boot_s: for how long after ``connect`` the robot may be booting: what is tried then does not count. 0 where
            opening the port does not reset it.
        heartbeat_s: repeat a current set-point (or a stop) when nothing was sent for so long, to feed a watchdog;
            None: never.
        extensions: commands beyond the source's (S10).

    Raises ``UsageError`` for settings that mean nothing.

    Attributes:
        in_step: whether the robot takes commands; dead: whether it was given up.
        resynchronisations: how often the way back into step was taken; spent: bytes that the last one took.
        resent: how many set-points were given back to be sent again, their fate not being known (S8).
        malformed: bytes that are no reply; unexpected: replies to nothing that was sent. Both are ignored otherwise.
        round_trips: how long the replies to commands took.
    """

    def __init__(
        self,
        *,
        baud: int = BAUD,
        window: int = 1,
        reply_delay_s: float = 0.05,
        retries: int = 3,
        boot_s: float = 2.5,
        heartbeat_s: float | None = None,
        extensions: tuple[type[SimpleCommand], ...] = (),
    ) -> None:
        if not 1 <= window <= MAX_WINDOW:
            raise UsageError(f"window is {window}, but must be 1 to {MAX_WINDOW} commands")
        if min(baud, reply_delay_s, math.inf if heartbeat_s is None else heartbeat_s) <= 0:
            raise UsageError("baud, reply_delay_s and heartbeat_s must be greater than 0")
        if min(retries, boot_s) < 0:
            raise UsageError("retries and boot_s must not be less than 0")
        self._known = frozenset(layout.command_type for layout in layouts(extensions).values())
        self._line = Line(baud, reply_delay_s)
        self._window = window
        self._retries = retries
        self._boot_s = boot_s
        self._heartbeat_s = heartbeat_s
        self._channels: dict[str, Channel] = defaultdict(Channel)
        self._losses: dict[str, int] = {}  # how often what is wanted of a channel got lost
        self._unsent: dict[str, None] = {}  # channels to send, in order
        self._stops: list[Order] = []
        self._flights: deque[Flight] = deque()
        self._due = math.inf
        self._lost: list[Order] = []  # given up when the way back is done
        self._way_back: Resynchronisation | None = None
        self._boot_until = -math.inf
        self._in_step_since = -math.inf
        self._surplus = 0
        self._last_sent = -math.inf
        self._urgent = b""
        self._events: list[Event] = []
        self._knowledge = Knowledge()
        self.in_step = False
        self.dead = False
        self.resynchronisations = 0
        self.spent = 0
        self.resent = 0
        self.malformed = 0
        self.unexpected = 0
        self.round_trips = RoundTrips()

    # ------------------------------------------------------------------ what the host wants

    def connect(self, now: float) -> None:
        """The link was opened: get in step (S7), with patience while the robot boots. Set-points wait until then."""
        self._boot_until = now + self._boot_s
        self._line.touch(now)
        self._resynchronise(now)

    def submit(self, command: SimpleCommand, tag: object = None) -> None:
        """Have a set-point or a stop sent, as soon as its turn and the window allow; a stop goes next.

        ``tag`` comes back with ``Done``, ``Superseded``, ``GaveUp`` or ``LinkDead``. Raises ``MessageError`` if a field
        is out of range, ``UsageError`` for an extension that the host was not told of, ``NoReplyError`` for a set-point
        after ``LinkDead``: nothing is sent then. A stop is always taken.
        """
        if type(command) not in self._known:
            raise UsageError(f"{command.name()} is an extension that this host was not told of")
        order = Order(command, encode(command), tag)
        if not command.CHANNEL:
            self._stop(order)
        elif self.dead:
            raise NoReplyError(f"{command.name()} was not sent: the robot does not answer. Connect again")
        else:
            channel = self._channels[command.CHANNEL]
            if channel.wanted is not None and not channel.wanted.told:
                self._drop(channel)
            channel.wanted = order
            self._unsent[command.CHANNEL] = None  # one that is there keeps its place

    def _stop(self, order: Order) -> None:
        self._cancel()
        if self._flights and isinstance(self._flights[-1].command, Stop):
            self._flights[-1].orders.append(order)  # nothing was sent after it
        else:
            self._stops.append(order)

    def _cancel(self) -> None:
        """A stop: what it ends is not wanted any more."""
        for name, channel in self._channels.items():
            if channel.wanted is not None and channel.wanted.command.STOPPED:
                self._drop(channel)
                self._unsent.pop(name, None)

    def _drop(self, channel: Channel) -> None:
        """Forget what is wanted of a channel. If it is under way, its reply will tell what became of it."""
        order, channel.wanted = channel.wanted, None
        if order and not any(order in flight.orders for flight in self._flights):
            self._supersede(order)

    def _supersede(self, order: Order) -> None:
        if not order.told:
            order.told = True
            self._events.append(Superseded(order.command, order.tag))

    def emergency_stop(self, now: float) -> None:
        """Stop the robot whatever state it or the line is in, ahead of everything, and get in step again.

        The 14 bytes stop it even if nothing can be sent or received after them (section 4).
        """
        self._cancel()
        self._urgent = EMERGENCY_STOP
        self._line.sent(EMERGENCY_STOP, now)
        self._resynchronise(now)

    def link_lost(self, now: float) -> list[Event]:  # noqa: ARG002 - as the hosts of all protocols
        """The link ended: forget everything. What was under way is unknown (S8), and nothing is sent again."""
        self._give_back()
        self._die("the link ended")
        self._urgent = b""
        return self._take_events()

    # ------------------------------------------------------------------ what is under way

    @property
    def idle(self) -> bool:
        """Nothing to send, and everything that was sent is answered."""
        return not (
            self._flights or self._unsent or self._stops or self._way_back or self._events or self._urgent
        )

    @property
    def under_way(self) -> tuple[SimpleCommand, ...]:
        """The commands that have been sent and not been answered: at most ``window``, and a stop."""
        return tuple(flight.command for flight in self._flights)

    @property
    def state(self) -> RobotState:
        """What is known of the robot now."""
        return self._knowledge.state(self._flights)

    # ------------------------------------------------------------------ bytes out

    def urgent_to_send(self) -> bytes:
        """Bytes that overtake whatever has been handed to the operating system and has not left it."""
        data, self._urgent = self._urgent, b""
        return data

    def data_to_send(self, now: float) -> bytes:
        """Bytes to send now; call it again after every event and at ``next_timeout``."""
        if not (self._unsent or self._stops or self._way_back or self._heartbeat_s):
            return b""
        if self.dead and self._stops:
            self._resynchronise(now)
        if self._way_back is not None:
            return self._way_back.data_to_send(now)
        if not self.in_step:
            return b""
        out = b""
        if self._stops:
            out = self._send(Stop(), _STOP, self._stops, now)
            self._stops = []
        elif self._heartbeat_s is not None and not self._unsent and now >= self._heartbeat_at():
            oldest = longest_ago(self._channels)
            if oldest:
                self._unsent[oldest] = None
            else:
                out = self._send(Stop(), _STOP, [], now)
        while self._unsent and len(self._flights) < self._window:
            name = next(iter(self._unsent))
            del self._unsent[name]
            channel = self._channels[name]
            order = channel.wanted
            assert order is not None, "what is not wanted is not sent"
            channel.sent_at = now
            out += self._send(order.command, order.data, [order], now)
        return out

    def _send(self, command: SimpleCommand, data: bytes, orders: list[Order], now: float) -> bytes:
        due = self._line.sent(data, now)
        if not self._flights:
            self._due = due
        self._flights.append(Flight(command, orders, due, now))
        self._last_sent = now
        return data

    def _heartbeat_at(self) -> float:
        if self._heartbeat_s is None or not self.in_step or self._flights:
            return math.inf
        return self._last_sent + self._heartbeat_s

    # ------------------------------------------------------------------ bytes in

    def receive_data(self, data: bytes, now: float) -> list[Event]:
        """Take bytes from the robot; return what they mean, in order."""
        if data:
            self._line.touch(now)
        for byte in data:
            if byte == _ACCEPTED and self._flights:
                self._accepted(self._flights.popleft(), now)
            elif byte in (_ACCEPTED, _REJECTED):
                self._replied(now, accepted=byte == _ACCEPTED)
            else:
                self.malformed += 1
        return self._take_events()

    def _replied(self, now: float, *, accepted: bool) -> None:
        if self._way_back is not None:
            self._way_back.replied(now, accepted=accepted)
            self._settle(now)
        elif self._flights:
            self._out_of_step("a valid command was rejected", now)
        else:
            self.unexpected += 1
            if self.in_step:
                self._too_many(now)

    def _accepted(self, flight: Flight, now: float) -> None:
        self.round_trips.add(now - flight.sent_at)
        for order in flight.orders:
            if not order.told:
                order.told = True
                self._events.append(Done(order.command, order.tag))
            name = order.command.CHANNEL
            if name in self._losses and self._channels[name].wanted is order:
                del self._losses[name]
        self._knowledge.accepted(flight.command)
        # The robot turns to the next command when it has answered this one.
        self._due = max(self._flights[0].due, self._line.reply_due(now)) if self._flights else math.inf

    def _too_many(self, now: float) -> None:
        self._surplus = self._surplus + 1 if now < self._in_step_since + SETTLED_S else 0
        if self._surplus > self._retries:
            self._die("the robot answers more than it was asked, again and again")
        else:
            self._out_of_step("a reply too many", now)

    def _out_of_step(self, reason: str, now: float) -> None:
        """S8: what is under way is unknown. Wanted set-points are sent again when the way back is done."""
        self._events.append(OutOfStep(reason, self.under_way))
        for flight in self._flights:
            for name, channel in self._channels.items():
                if channel.wanted is not None and channel.wanted in flight.orders:
                    self._count_loss(name, channel.wanted)
        self._resynchronise(now)

    def _count_loss(self, name: str, order: Order) -> None:
        self._losses[name] = self._losses.get(name, 0) + 1
        if self._losses[name] > self._retries:
            self._lost.append(order)
            self._channels[name].wanted = None
            del self._losses[name]

    def _give_back(self) -> int:
        """Everything under way: what is still wanted (how many) will be sent, a stop the way back carries out."""
        flights, self._flights = self._flights, deque()
        self._due = math.inf
        again: dict[str, None] = {}
        for flight in flights:
            for order in flight.orders:
                channel = self._channels.get(order.command.CHANNEL)
                if channel is None:
                    self._stops.append(order)
                elif channel.wanted is order:
                    again.setdefault(order.command.CHANNEL)
                elif order not in self._lost:
                    self._supersede(order)
        self._unsent = again | self._unsent  # in the order in which they were wanted
        return len(again)

    # ------------------------------------------------------------------ in step or not

    def _resynchronise(self, now: float) -> None:
        self.resent += self._give_back()
        # Not even what was accepted is certain: a byte too many is noticed one or two commands later.
        self._knowledge.begin(RobotState())
        self.in_step = self.dead = False
        self.resynchronisations += 1
        self._way_back = Resynchronisation(
            self._line, now, retries=self._retries, boot_until=self._boot_until
        )

    def _settle(self, now: float) -> None:
        """See whether the way back has come to an end."""
        assert self._way_back is not None
        self.spent = self._way_back.spent
        if self._way_back.stage is Stage.DEAD:
            self._die(self._way_back.failure)
        elif self._way_back.stage is Stage.IN_STEP:
            self._way_back = None
            self.in_step = True
            self._in_step_since = self._last_sent = now
            self._knowledge.begin(RobotState(drive=0, steer=0))
            self._events.append(InStep(self.state))
            for order in self._stops:
                self._events.append(Done(order.command, order.tag))
            for order in self._lost:
                self._events.append(GaveUp(order.command, order.tag, self.state))
            self._stops, self._lost = [], []
            for name, channel in self._channels.items():
                if channel.wanted is not None:
                    self._unsent.setdefault(name)

    def _die(self, reason: str) -> None:
        wanted = [channel.wanted for channel in self._channels.values() if channel.wanted is not None]
        unfinished = [order.tag for order in (*self._stops, *wanted, *self._lost) if not order.told]
        self._events.append(LinkDead(reason, tuple(unfinished)))
        self._way_back = None
        self.in_step, self.dead = False, True
        self._knowledge.begin(RobotState())
        # A set-point from before must not move a robot that comes back.
        self._channels.clear()
        self._losses.clear()
        self._unsent, self._stops, self._lost = {}, [], []

    # ------------------------------------------------------------------ time

    def next_timeout(self) -> float:
        """When ``timed_out`` wants to be called, if nothing happens before; ``math.inf``: never."""
        if self._events:
            return -math.inf
        if self._way_back is not None:
            return self._way_back.next_timeout()
        return self._due if self._heartbeat_s is None else min(self._due, self._heartbeat_at())

    def timed_out(self, now: float) -> list[Event]:
        """Act on the time. Call ``data_to_send`` afterwards."""
        if self._way_back is not None:
            self._way_back.timed_out(now)
            self._settle(now)
        elif self._flights and now >= self._due:
            self._out_of_step("no reply", now)
        return self._take_events()

    def _take_events(self) -> list[Event]:
        events, self._events = self._events, []
        return events
