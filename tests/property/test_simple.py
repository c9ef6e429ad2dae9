"""What holds for all bytes, all chunkings, and all ways in which a line can fail."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from tests.unit.protocols.simple.wire import Wire, clean
from turtlewire.protocols.message import Decoded, Malformed, parse
from turtlewire.protocols.simple.codec import CommandDecoder, ReplyDecoder, encode
from turtlewire.protocols.simple.events import Done, GaveUp, InStep, LinkDead, OutOfStep, Superseded
from turtlewire.protocols.simple.host import Host
from turtlewire.protocols.simple.messages import (
    COMMANDS,
    EMERGENCY_STOP,
    MESSAGES,
    SimpleCommand,
    Stop,
)
from turtlewire.protocols.simple.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Callable

TELLING = b"0123456789FBLRSHK"
any_byte = st.sampled_from(TELLING) | st.integers(0, 255)
any_bytes = st.lists(any_byte, max_size=100).map(bytes)


@st.composite
def commands(draw: st.DrawFn) -> SimpleCommand:
    command_type = draw(st.sampled_from(COMMANDS))
    return command_type(*(draw(st.integers(field.low, field.high)) for field in command_type.FIELDS))


streams = st.lists(any_bytes | commands().map(encode), max_size=20).map(b"".join)


def cut(data: bytes, points: list[int]) -> list[bytes]:
    ends = [0, *sorted(min(point, len(data)) for point in points), len(data)]
    return [data[start:end] for start, end in pairwise(ends)]


@settings(deadline=None)
@given(st.sampled_from((CommandDecoder, ReplyDecoder)), streams, st.lists(st.integers(0, 300), max_size=12))
def test_every_chunking_gives_the_same_items_and_no_byte_is_forgotten(
    new_decoder: Callable[[], CommandDecoder | ReplyDecoder], data: bytes, points: list[int]
) -> None:
    whole, chunked = new_decoder(), new_decoder()
    items = whole.receive_data(data)
    assert [item for chunk in cut(data, points) for item in chunked.receive_data(chunk)] == items
    pending = whole.pending if isinstance(whole, CommandDecoder) else b""
    assert b"".join(item.raw for item in items) + pending == data
    assert [item.offset for item in items] == [n * len(item.raw) for n, item in enumerate(items)]
    for item in items:
        assert isinstance(item, Malformed) or (
            len(encode(item.message)) == len(item.raw) and encode(item.message)[:1] == item.raw[:1]
        )


@given(commands())
def test_there_and_back(command: SimpleCommand) -> None:
    assert CommandDecoder().receive_data(encode(command)) == [Decoded(0, encode(command), command)]
    assert parse(str(command), MESSAGES) == command


@given(streams)
def test_a_robot_answers_every_seven_bytes_and_stops_after_fourteen_s(data: bytes) -> None:
    robot = Robot()
    reaction = robot.receive_data(data)
    assert len(reaction.replies) == len(data) // 7
    assert len(reaction.actions) == reaction.replies.count(b"K") == robot.heard
    assert -255 <= robot.drive <= 255
    assert -255 <= robot.steer <= 255
    robot.receive_data(EMERGENCY_STOP)
    assert (robot.drive, robot.steer) == (0, 0)


# ---------------------------------------------------------------------------------------- host, robot, and faults


def damage(data: bytes, kind: str, at: int, byte: int) -> bytes:
    at %= len(data) + (kind == "add")
    if kind == "lose":
        return data[:at] + data[at + 1 :]
    if kind == "change":
        return data[:at] + bytes([byte]) + data[at + 1 :]
    return data[:at] + bytes([byte]) + data[at:]


class HostAndRobot(RuleBasedStateMachine):
    """Faults in what is sent and answered while in step; the way back is left alone, so its promises must hold.

    ``Wire`` checks at every ``InStep`` that the robot stands between commands, stopped.
    """

    def __init__(self) -> None:
        super().__init__()
        self.faults = 0
        self.aliens = 0
        self.checked = 0
        self.submitted = 0
        self.sent: set[SimpleCommand] = {Stop()}
        self.wire = Wire(Host(), Robot())

    @initialize(window=st.integers(1, 8), work_s=st.sampled_from((0.0, 0.004, 0.03)))
    def connect(self, window: int, work_s: float) -> None:
        self.wire = Wire(Host(window=window, heartbeat_s=0.3), Robot(), work_s=work_s)
        self.wire.host.connect(0.0)
        self.settle()

    def settle(self) -> None:
        """Nothing takes longer than this, whatever happened: no hang."""
        self.wire.to_robot = self.wire.to_host = clean
        until = self.wire.now + 4 * (0.5 + 14 * 0.06)
        self.wire.run(until=until, limit=2000)

    @rule(command=commands(), pause=st.sampled_from((0.0, 0.002, 0.01, 0.1, 0.5)))
    def submit(self, command: SimpleCommand, pause: float) -> None:
        self.sent.add(command)
        self.wire.host.submit(command, self.submitted)
        self.submitted += 1
        self.wire.run(until=self.wire.now + pause)

    @precondition(lambda self: self.wire.host.in_step)
    @rule(
        command=commands(),
        kind=st.sampled_from(("lose", "change", "add")),
        at=st.integers(0, 20),
        byte=any_byte,
        reply=st.booleans(),
    )
    def fault(self, command: SimpleCommand, kind: str, at: int, byte: int, reply: bool) -> None:
        """The next bytes that are sent (or answered) are damaged, once, unless the way back has begun by then."""
        armed = [True]

        def once(data: bytes) -> bytes:
            if not armed or not data or not self.wire.host.in_step:
                return data
            armed.clear()
            self.faults += 1
            return damage(data, kind, at, byte)

        if reply:
            self.wire.to_host = once
        else:
            self.wire.to_robot = once
        self.submit(command, 0.0)

    @rule()
    def emergency_stop(self) -> None:
        self.wire.host.emergency_stop(self.wire.now)
        self.settle()
        assert self.wire.host.in_step

    @rule()
    def wait(self) -> None:
        self.settle()
        assert self.wire.host.in_step
        assert self.wire.robot.pending == b""
        # Heartbeats have repaired what no reply could tell: the motors do what the host thinks that they do.
        assert (self.wire.host.state.drive, self.wire.host.state.steer) == (
            self.wire.robot.drive,
            self.wire.robot.steer,
        )

    @invariant()
    def nothing_is_carried_out_that_was_not_sent(self) -> None:
        for command in self.wire.executed[self.checked :]:
            if command not in self.sent:
                self.aliens += 1
        self.checked = len(self.wire.executed)
        # A fault makes one other command of one, at most.
        assert self.aliens <= self.faults

    @invariant()
    def never_dead_and_never_too_long(self) -> None:
        assert not self.wire.host.dead
        assert self.wire.host.spent <= 14

    def teardown(self) -> None:
        self.wait()
        ends = [e for e in self.wire.events if isinstance(e, Done | Superseded | GaveUp)]
        tags = [event.tag for event in ends if event.tag is not None]
        assert sorted(tags, key=str) == sorted(set(tags), key=str), "two ends"
        assert set(tags) == set(range(self.submitted)), "no end"


TestHostAndRobot = HostAndRobot.TestCase
TestHostAndRobot.settings = settings(max_examples=60, stateful_step_count=25, deadline=None)


@settings(deadline=None, max_examples=60)
@given(
    st.integers(1, 8),
    st.lists(
        st.tuples(
            commands(),
            st.booleans(),
            st.sampled_from(("lose", "change", "add", "none")),
            st.integers(0, 20),
            any_byte,
        ),
        max_size=40,
    ),
    st.integers(0, 6),
)
def test_whatever_happens_on_the_line_it_heals_or_is_said_to_be_dead(
    window: int, plan: list[tuple[SimpleCommand, bool, str, int, int]], left: int
) -> None:
    """Faults anywhere, also on the way back, with any window: no hang, and in the end both agree."""
    robot = Robot()
    robot.receive_data(b"B255000"[:left])
    wire = Wire(Host(window=window, heartbeat_s=0.2), robot)
    faults = [(reply, kind, at, byte) for _, reply, kind, at, byte in plan]

    def to_robot(data: bytes) -> bytes:
        if faults and not faults[-1][0]:
            _, kind, at, byte = faults.pop()
            return data if kind == "none" else damage(data, kind, at, byte)
        return data

    def to_host(data: bytes) -> bytes:
        if faults and faults[-1][0] and data:
            _, kind, at, byte = faults.pop()
            return data if kind == "none" else damage(data, kind, at, byte)
        return data

    wire.to_robot, wire.to_host = to_robot, to_host
    # The wire's own check at InStep holds only where the way back is left alone.
    take = wire.events.extend
    wire._take = take  # type: ignore[method-assign,assignment]
    wire.host.connect(0.0)
    for command, *_ in plan:
        if not wire.host.dead:
            wire.host.submit(command)
        wire.run(until=wire.now + 0.02)
    faults.clear()
    wire.run(until=wire.now + 20, limit=2000)
    if wire.host.dead:
        assert isinstance(wire.events[-1], LinkDead)
        wire.host.connect(wire.now)
        wire.run(until=wire.now + 20, limit=2000)
    assert wire.host.in_step
    assert robot.pending == b""
    assert (wire.host.state.drive, wire.host.state.steer) == (robot.drive, robot.steer)
    steps = [type(e) for e in wire.events if isinstance(e, OutOfStep | InStep | LinkDead)]
    # Nobody is in step twice, or out of it twice, without the other between.
    assert all(one != other for one, other in pairwise(steps))
