"""The link ends: each host's end forgets what was under way, says so, and sends nothing before it begins anew."""

from __future__ import annotations

import math
from typing import Any

import pytest

from turtlewire.errors import NoReplyError, UsageError
from turtlewire.protocols.frame.dialect import shipped
from turtlewire.protocols.frame.host import Host as FrameHost
from turtlewire.protocols.frame.robot import Robot as FrameRobot
from turtlewire.protocols.simple import messages as simple
from turtlewire.protocols.simple.events import Done, Event, InStep, LinkDead, RobotState, Superseded
from turtlewire.protocols.simple.host import Host as SimpleHost
from turtlewire.protocols.simple.robot import Robot as SimpleRobot
from turtlewire.protocols.walter import messages as walter
from turtlewire.protocols.walter.host import Host as WalterHost
from turtlewire.protocols.walter.host import LinkLost


def sent(host: Any, now: float) -> bytes:
    data: bytes = host.urgent_to_send() + host.data_to_send(now)
    return data


def stays_silent(host: Any, now: float) -> None:
    """Whatever time it gets to be."""
    for seconds in (0.0, 0.1, 1.0, 10.0, 1e3, 1e6):
        assert sent(host, now + seconds) == b""
        for _ in host.timed_out(now + seconds):
            raise AssertionError
    assert host.next_timeout() == math.inf


# ---------------------------------------------------------------- walter


def test_w15_walter_tells_what_was_under_way_and_what_was_not_sent() -> None:
    host = WalterHost(heartbeat_s=0.5)
    host.attention(0.0)
    for number in range(20):
        host.submit(walter.Forward(100), 1.0, tag=number)
    assert sent(host, 0.0).count(b"F\0\x64\r") < 20
    under_way = tuple(tag for tag in host.unconfirmed if tag is not None)
    assert 0 < len(under_way) < 20
    host.receive_data(b"QH\0", 0.1)  # half an answer
    (event,) = host.link_lost(0.2)
    assert isinstance(event, LinkLost)
    assert tuple(tag for tag in event.unfinished if tag is not None) == tuple(range(20))
    assert tuple(tag for tag in host.abandoned if tag is not None) == under_way
    assert host.idle
    stays_silent(host, 0.2)


def test_walter_begins_anew_with_an_attention() -> None:
    host = WalterHost()
    host.attention(0.0)
    host.submit(walter.Forward(100), 1.0, tag="move")
    sent(host, 0.0)
    host.emergency_stop(0.1)  # it never goes out
    host.link_lost(0.2)
    assert host.urgent_to_send() == b""
    host.attention(5.0)
    host.submit(walter.QueryHeading(), tag="heading")
    assert sent(host, 5.0) == walter.ATTENTION + b"QH\r"
    # What is left of an answer from before is none.
    (event,) = host.receive_data(b"QH\0\x05\r", 5.1)
    assert event == (walter.QueryHeading(), walter.HeadingReply(5), "heading")
    assert host.abandoned == ("move",)
    assert host.interrupted is not None
    tag, part = host.interrupted
    assert tag == "move"
    assert part == pytest.approx(0.1, abs=0.02)


def test_walter_keeps_what_was_abandoned_until_somebody_has_seen_to_it() -> None:
    host = WalterHost()
    host.attention(0.0)
    host.submit(walter.Forward(100), 1.0, tag="move")
    sent(host, 0.0)
    for now in (0.1, 0.2):
        host.attention(now)
        host.submit(walter.QueryHeading(), tag=now)
        sent(host, now)
    host.link_lost(0.3)
    assert host.abandoned == ("move", 0.1, 0.2)
    assert host.interrupted is not None
    assert host.interrupted[0] == "move"


# ---------------------------------------------------------------- simple


def in_step(host: SimpleHost) -> None:
    robot, now = SimpleRobot(), 0.0
    host.connect(now)
    events: list[Event] = []
    while not host.in_step:
        replies, _ = robot.receive_data(sent(host, now))
        events += host.receive_data(replies, now)
        if not replies:
            now = host.next_timeout()
            events += host.timed_out(now)
        assert now < 10.0
    assert [type(event) for event in events] == [InStep]


def test_s8_simple_tells_what_was_under_way_and_wants_nothing_any_more() -> None:
    host = SimpleHost(window=2, heartbeat_s=0.5)
    in_step(host)
    host.submit(simple.DriveForward(100), tag="drive")
    host.submit(simple.SteerLeft(9), tag="steer")
    host.submit(simple.Headlights(1, 1, 1, 1), tag="lights")
    assert sent(host, 20.0) == b"F100000L009000"
    host.submit(simple.DriveForward(120), tag="faster")  # replaces what is under way
    events = host.link_lost(20.1)
    assert Superseded(simple.DriveForward(100), "drive") in events
    (dead,) = [event for event in events if isinstance(event, LinkDead)]
    assert set(dead.unfinished) == {"steer", "lights", "faster"}
    assert host.under_way == ()
    assert host.state == RobotState()
    stays_silent(host, 20.1)
    with pytest.raises(NoReplyError):
        host.submit(simple.DriveForward(1))
    host.connect(30.0)
    assert not host.in_step


def test_simple_forgets_a_stop_that_never_went_out() -> None:
    host = SimpleHost()
    in_step(host)
    host.submit(simple.Stop(), tag="stop")
    host.emergency_stop(20.0)
    (dead,) = host.link_lost(20.1)
    assert isinstance(dead, LinkDead)
    assert dead.unfinished == ("stop",)
    assert host.urgent_to_send() == b""
    stays_silent(host, 20.1)
    assert not any(isinstance(event, Done) for event in host.timed_out(30.0))
    assert host.resent == 0


# ---------------------------------------------------------------- frame


def test_frame_repeats_nothing_any_more() -> None:
    host = FrameHost(shipped("telemetry"), repeat_s=0.2, heartbeat_s=0.1)
    host.connect(0.0)
    sent(host, 0.0)
    kinds = {entry.message_type.name(): entry.message_type for entry in host.dialect.entries}
    speeds: Any = kinds["set_wheel_speeds"]
    host.send(speeds(100, 100))
    assert sent(host, 1.0)
    host.send(speeds(120, 120))
    host.emergency_stop(1.1)
    whole = FrameRobot(shipped("telemetry")).send(kinds["status"](*[0] * len(kinds["status"].FIELDS)))
    assert host.receive_data(whole[:5], 1.2) == []  # the rest never comes
    assert host.link_lost(1.3) == []
    assert host.idle
    assert not host.connected
    stays_silent(host, 1.3)
    with pytest.raises(UsageError):
        host.send(speeds(1, 1))
    assert [m.name() for m in host.receive_data(whole, 5.0)] == ["status"]
    host.connect(6.0)
    assert host.urgent_to_send()
    assert b"\x00\x64\x00\x64" not in sent(host, 10.0)
