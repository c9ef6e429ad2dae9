from __future__ import annotations

import math
from typing import Any, ClassVar

import pytest

from tests.unit.protocols.simple.wire import Wire, connected
from turtlewire.errors import MessageError, NoReplyError, UsageError
from turtlewire.protocols.message import Decoded, Field
from turtlewire.protocols.simple.codec import CommandDecoder, encode
from turtlewire.protocols.simple.events import (
    Done,
    GaveUp,
    InStep,
    LinkDead,
    OutOfStep,
    RobotState,
    Superseded,
)
from turtlewire.protocols.simple.host import Host
from turtlewire.protocols.simple.messages import (
    DriveBackward,
    DriveForward,
    Headlights,
    SimpleCommand,
    SteerLeft,
    SteerRight,
    Stop,
)
from turtlewire.protocols.simple.resynchronise import Line, Resynchronisation, Stage
from turtlewire.protocols.simple.robot import Robot


class Servos(SimpleCommand, frozen=True):
    LETTER: ClassVar[bytes] = b"V"
    CHANNEL: ClassVar[str] = "servos"
    FIELDS: ClassVar[tuple[Field, ...]] = (
        Field("left_deg", "u8", 0, 180, "degrees"),
        Field("right_deg", "u8", 0, 180, "degrees"),
    )
    left_deg: int
    right_deg: int


def kinds(wire: Wire) -> list[str]:
    return [type(event).__name__ for event in wire.events]


# ------------------------------------------------------------------------------------------------- settings, inputs


@pytest.mark.parametrize(
    "settings",
    [
        {"window": 0},
        {"window": 9},
        {"baud": 0},
        {"reply_delay_s": 0.0},
        {"heartbeat_s": 0.0},
        {"retries": -1},
        {"boot_s": -0.1},
    ],
)
def test_settings_that_mean_nothing(settings: dict[str, Any]) -> None:
    with pytest.raises(UsageError, match=next(iter(settings))):
        Host(**settings)


def test_the_ends_of_the_settings() -> None:
    Host(window=8, retries=0, boot_s=0, heartbeat_s=0.001)


def test_what_cannot_be_sent_is_refused_and_nothing_goes_out() -> None:
    wire = connected()
    with pytest.raises(MessageError, match="speed is 256"):
        wire.host.submit(DriveForward(256))
    with pytest.raises(UsageError, match="servos is an extension that this host was not told of"):
        wire.host.submit(Servos(1, 2))
    wire.run()
    assert wire.sent == []
    assert wire.host.idle


def test_a_letter_alone_does_not_make_an_extension_known() -> None:
    class Others(SimpleCommand, frozen=True):
        LETTER: ClassVar[bytes] = b"V"
        CHANNEL: ClassVar[str] = "others"

    host = Host(extensions=(Servos,))
    with pytest.raises(UsageError, match="others is an extension"):
        host.submit(Others())


def test_nothing_is_sent_before_connect_and_replies_are_ignored() -> None:
    host = Host()
    host.submit(DriveForward(1))
    assert host.data_to_send(0.0) == b""
    assert host.next_timeout() == math.inf
    assert host.receive_data(b"K", 0.0) == []
    assert host.timed_out(0.0) == []
    assert host.unexpected == 1
    assert not host.in_step


def test_what_was_wanted_before_connect_is_sent_after_it() -> None:
    host = Host()
    host.submit(DriveForward(5), "tag")
    wire = Wire(host, Robot())
    host.connect(0.0)
    assert not host.idle
    wire.run()
    assert wire.events == [InStep(RobotState(0, 0)), Done(DriveForward(5), "tag")]
    assert wire.robot.drive == 5
    assert host.idle


# ------------------------------------------------------------------------------------------------- tags and ends


def test_every_submission_comes_to_one_end() -> None:
    wire = connected()
    for n in range(50):
        wire.host.submit(DriveForward(n), n)
        wire.host.submit(SteerRight(n), 100 + n)
        if n % 7 == 0:
            wire.host.submit(Stop(), 200 + n)
        wire.run(until=wire.now + 0.003 * (n % 5))
    wire.run()
    tags = [event.tag for event in wire.events if isinstance(event, Done | Superseded)]
    assert sorted(map(str, tags)) == sorted(
        str(n + base) for base in (0, 100, 200) for n in range(50) if base < 200 or n % 7 == 0
    )


def test_one_under_way_is_done_though_another_is_wanted_by_then() -> None:
    wire = connected()
    wire.host.submit(DriveForward(1), "one")
    wire.step(until=wire.now)
    assert wire.host.under_way == (DriveForward(1),)
    wire.host.submit(DriveForward(2), "two")
    wire.run()
    assert wire.events == [Done(DriveForward(1), "one"), Done(DriveForward(2), "two")]


def test_stops_join_the_one_that_is_under_way() -> None:
    wire = connected()
    wire.host.submit(Stop(), "one")
    wire.step(until=wire.now)
    wire.host.submit(Stop(), "two")
    wire.run()
    assert wire.events == [Done(Stop(), "one"), Done(Stop(), "two")]
    assert wire.executed == [Stop()]


def test_a_stop_after_a_set_point_is_another_stop() -> None:
    wire = connected(Host(window=2))
    wire.host.submit(Stop(), "one")
    wire.step(until=wire.now)
    wire.host.submit(DriveForward(9))
    wire.step(until=wire.now)
    wire.host.submit(Stop(), "two")
    wire.run()
    assert wire.executed == [Stop(), DriveForward(9), Stop()]
    assert wire.robot.drive == 0


# ------------------------------------------------------------------------------------------------- S9


@pytest.mark.parametrize("window", range(1, 9))
def test_no_more_than_the_window_and_a_stop(window: int) -> None:
    wire = connected(Host(window=window))
    most = 0
    for n in range(200):
        wire.host.submit((DriveForward, SteerLeft, DriveBackward)[n % 3](n % 256))
        wire.step(until=wire.now)
        most = max(most, len(wire.host.under_way))
    assert most == window
    wire.host.submit(Stop())
    wire.step(until=wire.now)
    assert len(wire.host.under_way) == window + 1
    assert 7 * len(wire.host.under_way) <= 63  # what an Arduino's ring holds
    wire.host.submit(SteerLeft(1))
    wire.host.submit(Stop())
    wire.step(until=wire.now)
    assert len(wire.host.under_way) == window + 1


@pytest.mark.parametrize("work_s", [0.0005, 0.004, 0.020])
@pytest.mark.parametrize("window", [1, 2, 8])
def test_a_joystick_never_builds_a_backlog(window: int, work_s: float) -> None:
    """60 times a second drive, steering and, now and then, headlights, at 9600 baud for 20 s."""
    wire = connected(Host(window=window), work_s=work_s)
    start = wire.now
    submitted: dict[SimpleCommand, float] = {}
    oldest = 0.0
    for n in range(1200):
        wire.run(until=start + n / 60)
        wire.host.submit(DriveForward(n % 256))
        wire.host.submit(SteerLeft(n % 256))
        submitted[DriveForward(n % 256)] = submitted[SteerLeft(n % 256)] = wire.now
        if n % 10 == 0:
            wire.host.submit(Headlights(n // 10 % 2, 0, 0, 1))
        before = len(wire.sent)
        wire.step(until=wire.now)
        for sent_at, data in wire.sent[before:]:
            for item in CommandDecoder().receive_data(data):
                assert isinstance(item, Decoded)
                message = item.message
                assert isinstance(message, SimpleCommand)
                oldest = max(oldest, sent_at - submitted.get(message, sent_at))
    assert "OutOfStep" not in kinds(wire)
    # Never older than a turn of the three channels takes.
    assert oldest <= 3 * (0.0084 + work_s) + 1 / 60
    # A stop goes out at once, behind the bytes of the commands under way and nothing else.
    under_way = len(wire.host.under_way)
    wire.host.submit(Stop())
    sent = len(wire.sent)
    wire.step(until=wire.now)
    assert wire.sent[sent:] == [(wire.now, b"S000000")]
    assert under_way <= window
    wire.run()
    assert (wire.robot.drive, wire.robot.steer) == (0, 0)
    assert wire.executed[-1] in (Stop(), Headlights(1, 0, 0, 1), Headlights(0, 0, 0, 1))


def test_no_channel_starves_another() -> None:
    wire = connected()
    for n in range(300):
        wire.host.submit(DriveForward(n % 256))
        if n == 100:
            wire.host.submit(SteerRight(3))
            wire.host.submit(Headlights(0, 1, 0, 0))
        wire.run(until=wire.now + 0.002)
    after = wire.executed.index(SteerRight(3))
    assert wire.executed.index(Headlights(0, 1, 0, 0)) - after <= 2


# ------------------------------------------------------------------------------------------------- S8


class Deaf:
    """Loses the first byte of what begins with a letter, so many times."""

    def __init__(self, letter: bytes, times: float = math.inf) -> None:
        self.letter = letter
        self.times = times

    def __call__(self, data: bytes) -> bytes:
        if self.times and data.startswith(self.letter):
            self.times -= 1
            return data[1:]
        return data


@pytest.mark.parametrize("retries", [0, 1, 3])
def test_a_set_point_is_sent_again_a_bounded_number_of_times(retries: int) -> None:
    wire = connected(Host(retries=retries))
    wire.to_robot = Deaf(b"L")
    wire.host.submit(SteerLeft(10), "left")
    wire.host.submit(DriveForward(20), "forward")
    wire.run()
    assert [data for _, data in wire.sent].count(b"L010000") == retries + 1
    given_up = [event for event in wire.events if isinstance(event, GaveUp)]
    assert given_up == [GaveUp(SteerLeft(10), "left", RobotState(0, 0))]
    # The other one holds, in spite of the stops between.
    assert (wire.robot.drive, wire.robot.steer) == (20, 0)
    assert wire.host.state == RobotState(20, 0)
    assert [event.tag for event in wire.events if isinstance(event, Done)] == ["forward"]
    # The next one has as many tries again.
    wire.to_robot = lambda data: data
    wire.host.submit(SteerLeft(11), "again")
    wire.run()
    assert wire.events[-1] == Done(SteerLeft(11), "again")


def test_success_forgets_losses() -> None:
    wire = connected(Host(retries=1))
    for speed in range(5):
        wire.to_robot = Deaf(b"F", times=1)
        wire.host.submit(DriveForward(speed))
        wire.run()
        assert wire.robot.drive == speed
    assert kinds(wire) == ["OutOfStep", "InStep", "Done"] * 5


def test_a_replaced_set_point_that_got_lost_is_not_sent_again() -> None:
    wire = connected()
    wire.to_robot = lambda data: b""
    wire.host.submit(DriveForward(1), "one")
    wire.step(until=wire.now)
    wire.host.submit(DriveForward(2), "two")
    wire.to_robot = lambda data: data
    wire.run()
    assert wire.executed == [Stop(), Stop(), DriveForward(2)]
    assert kinds(wire) == ["OutOfStep", "Superseded", "InStep", "Done"]
    assert Superseded(DriveForward(1), "one") in wire.events


def test_a_stop_that_got_lost_is_done_when_in_step() -> None:
    wire = connected()
    wire.host.submit(DriveForward(100))
    wire.run()
    wire.to_robot = lambda data: data[:3]
    wire.host.submit(Stop(), "stop")
    wire.step(until=wire.now)
    wire.to_robot = lambda data: data
    wire.run()
    assert wire.events[-1] == Done(Stop(), "stop")
    assert wire.robot.drive == 0
    assert wire.host.idle


def test_lost_ones_are_sent_again_in_order() -> None:
    wire = connected(Host(window=2))
    wire.to_robot = lambda data: data[1:]
    wire.host.submit(SteerLeft(1))
    wire.host.submit(DriveForward(2))
    wire.host.submit(Headlights(1, 1, 1, 1))
    wire.step(until=wire.now)
    wire.to_robot = lambda data: data
    wire.run()
    sent = [data for _, data in wire.sent if len(data) > 1]
    assert sent == [b"L001000F002000", b"S000000", b"L001000F002000", b"H111100"]


def test_a_dead_link_forgets_what_was_wanted_and_says_so() -> None:
    wire = connected()
    wire.host.submit(DriveForward(100), "old")
    wire.run()
    wire.to_robot = lambda data: b""
    wire.host.submit(SteerLeft(1), "left")
    wire.host.submit(Headlights(1, 0, 0, 0), "lights")
    wire.run()
    assert kinds(wire)[-2:] == ["OutOfStep", "LinkDead"]
    dead = wire.events[-1]
    assert isinstance(dead, LinkDead)
    assert sorted(map(str, dead.unfinished)) == ["left", "lights"]
    assert wire.host.dead
    assert wire.host.idle
    assert wire.host.state == RobotState()
    with pytest.raises(NoReplyError, match="drive_forward was not sent: the robot does not answer"):
        wire.host.submit(DriveForward(1))
    assert wire.host.receive_data(b"K", wire.now) == []
    # A robot that comes back is not moved by it.
    wire.to_robot = lambda data: data
    wire.executed, wire.events = [], []
    wire.host.connect(wire.now)
    wire.run()
    assert wire.executed[-1] == Stop()
    assert set(wire.executed) == {Stop()}
    assert wire.events == [InStep(RobotState(0, 0))]


def test_a_stop_is_tried_even_on_a_dead_link() -> None:
    wire = connected()
    wire.host.submit(DriveForward(100))
    wire.run()
    wire.to_robot = lambda data: b""
    wire.host.submit(DriveForward(101))
    wire.run()
    assert wire.host.dead
    assert wire.robot.drive == 100
    wire.to_robot = lambda data: data
    wire.host.submit(Stop(), "stop")
    wire.run()
    assert wire.robot.drive == 0
    assert wire.events[-1] == Done(Stop(), "stop")


def test_a_robot_that_never_stops_answering_is_given_up() -> None:
    wire = connected()
    now = wire.now
    for _ in range(2000):
        now += 0.01
        if not wire.host.in_step or _ % 20 == 0:
            wire.events += wire.host.receive_data(b"K", now)
        while wire.host.next_timeout() <= now:
            wire.events += wire.host.timed_out(now)
            wire.host.data_to_send(now)
        wire.host.data_to_send(now)
        if wire.host.dead:
            break
    assert wire.host.dead
    assert isinstance(wire.events[-1], LinkDead)


def test_replies_too_many_in_a_row() -> None:
    wire = connected(Host(retries=2, boot_s=0))
    for n in range(3):
        assert wire.host.in_step
        wire.events = list(wire.host.receive_data(b"F", wire.now))
        if n < 2:
            assert wire.events == [OutOfStep("a reply too many", ())]
            wire.run()
    assert wire.events == [LinkDead("the robot answers more than it was asked, again and again", ())]


def test_replies_too_many_now_and_then() -> None:
    wire = connected(Host(retries=0))
    for _ in range(5):
        wire.run(until=wire.now + 1.5)
        wire.host.receive_data(b"F", wire.now)
        wire.run()
        assert wire.host.in_step


def test_reconnect_in_the_middle_of_a_command() -> None:
    wire = connected()
    wire.to_robot = lambda data: data[:4]
    wire.host.submit(DriveForward(100), "forward")
    wire.step(until=wire.now)
    wire.to_robot = lambda data: data
    wire.host.connect(wire.now)
    wire.run()
    assert wire.events[-1] == Done(DriveForward(100), "forward")
    assert kinds(wire) == ["InStep", "Done"]


# ------------------------------------------------------------------------------------------------- stop, heartbeat


@pytest.mark.parametrize("received", range(7))
def test_an_emergency_stop_needs_no_answer(received: int) -> None:
    wire = connected()
    wire.host.submit(DriveForward(100))
    wire.host.submit(Headlights(1, 1, 1, 1), "lights")
    wire.run()
    wire.robot.receive_data(b"F255000"[:received])  # what another program left
    wire.to_host = lambda reply: b""
    wire.host.submit(Headlights(0, 1, 0, 0), "under way")
    wire.step(until=wire.now)
    wire.host.submit(SteerLeft(9), "left")
    wire.host.submit(Stop(), "stop")
    wire.host.emergency_stop(wire.now)
    assert wire.host.urgent_to_send() == b"S" * 14
    assert wire.host.urgent_to_send() == b""
    wire.robot.receive_data(b"S" * 14)
    assert (wire.robot.drive, wire.robot.steer) == (0, 0)
    wire.to_host = lambda reply: reply
    wire.run()
    assert (wire.robot.drive, wire.robot.steer) == (0, 0)
    assert wire.robot.lights == (False, True, False, False)
    ends = {event.tag: type(event) for event in wire.events if isinstance(event, Done | Superseded)}
    assert ends == {None: Done, "lights": Done, "under way": Done, "left": Superseded, "stop": Done}


def test_an_emergency_stop_works_before_connect() -> None:
    robot = Robot()
    robot.drive = 255
    wire = Wire(Host(), robot)
    wire.host.emergency_stop(0.0)
    assert not wire.host.idle
    wire.run()
    assert robot.drive == 0
    assert kinds(wire) == ["InStep"]


def test_a_heartbeat_while_nothing_else_is_sent() -> None:
    wire = connected(Host(heartbeat_s=0.2))
    start = wire.now
    wire.run(until=start + 1.01)
    assert set(wire.executed) == {Stop()}
    assert 4 <= len(wire.executed) <= 5
    wire.host.submit(Headlights(1, 0, 0, 0))
    wire.run(until=start + 2.0)
    assert wire.executed[-1] == Stop()
    wire.host.submit(DriveForward(10))
    wire.host.submit(SteerLeft(20))
    wire.executed = []
    wire.run(until=start + 3.0)
    assert (
        wire.executed == [DriveForward(10), SteerLeft(20)] * 2 + [DriveForward(10)]
        or wire.executed
        == [
            DriveForward(10),
            SteerLeft(20),
        ]
        * 3
    )
    # Nothing is unknown meanwhile, and nothing is reported again.
    assert wire.host.state == RobotState(10, -20, (1, 0, 0, 0))
    assert kinds(wire) == ["Done"] * 3


def test_a_heartbeat_finds_a_dead_link() -> None:
    wire = connected(Host(heartbeat_s=0.2))
    wire.to_robot = lambda data: b""
    wire.run(until=wire.now + 3)
    assert kinds(wire) == ["OutOfStep", "LinkDead"]
    assert wire.host.next_timeout() == math.inf


def test_a_heartbeat_slower_than_the_line_never_spins() -> None:
    wire = connected(Host(heartbeat_s=0.001))
    wire.run(until=wire.now + 1, limit=400)
    assert len(wire.executed) > 50


# ------------------------------------------------------------------------------------------------- extensions, state


def test_an_extension_is_a_channel_like_any_other() -> None:
    wire = connected(Host(extensions=(Servos,)), Robot((Servos,)))
    wire.host.submit(DriveForward(1))
    wire.host.submit(Servos(90, 7), "servos")
    wire.host.submit(Servos(91, 8), "servos again")
    wire.host.submit(Stop())
    wire.run()
    assert wire.executed == [Stop(), Servos(91, 8)]
    assert Superseded(Servos(90, 7), "servos") in wire.events
    assert wire.host.state == RobotState(0, 0)
    assert [data for _, data in wire.sent] == [b"S000000", b"V091008"]


def test_what_is_known() -> None:
    state = RobotState()
    assert str(state) == "drive unknown, steering unknown, headlights unknown"
    for command in (DriveBackward(3), SteerRight(4), Headlights(*map(bool, (1, 0, 0, 1))), Servos(1, 1)):
        state = state.after(command)
    assert state == RobotState(-3, 4, (1, 0, 0, 1))
    assert str(state) == "drive -3, steering 4, headlights 1001"
    assert state.during(DriveBackward(3)) == state
    assert state.during(DriveForward(3)) == RobotState(None, 4, (1, 0, 0, 1))
    assert state.during(SteerLeft(4)) == RobotState(-3, None, (1, 0, 0, 1))
    assert state.during(Headlights(0, 0, 0, 0)) == RobotState(-3, 4)
    assert state.during(Stop()) == RobotState(None, None, (1, 0, 0, 1))
    assert state.after(Stop()) == RobotState(0, 0, (1, 0, 0, 1))


def test_with_a_window_only_the_last_value_under_way_is_known() -> None:
    host = Host(window=2, boot_s=0)
    wire = connected(host)
    host.submit(DriveForward(1))
    wire.step(until=wire.now)
    host.submit(DriveForward(2))
    host.data_to_send(wire.now)
    assert host.under_way == (DriveForward(1), DriveForward(2))
    assert host.state.drive is None
    host.receive_data(b"K", wire.now)
    assert host.state.drive is None
    host.receive_data(b"K", wire.now)
    assert host.state.drive == 2


def test_what_is_known_after_each_of_many_commands() -> None:
    wire = connected()
    for command, known in (
        (DriveForward(1), RobotState(1, 0)),
        (Headlights(0, 1, 0, 1), RobotState(1, 0, (0, 1, 0, 1))),
        (Stop(), RobotState(0, 0, (0, 1, 0, 1))),
        (DriveBackward(2), RobotState(-2, 0, (0, 1, 0, 1))),
        (SteerLeft(3), RobotState(-2, -3, (0, 1, 0, 1))),
        (Stop(), RobotState(0, 0, (0, 1, 0, 1))),
        (SteerRight(4), RobotState(0, 4, (0, 1, 0, 1))),
        (Headlights(0, 0, 0, 0), RobotState(0, 4, (0, 0, 0, 0))),
    ):
        wire.host.submit(command)
        wire.run()
        assert wire.host.state == known
    wire.host.emergency_stop(wire.now)
    assert wire.host.state == RobotState()
    wire.run()
    assert wire.host.state == RobotState(0, 0, (0, 0, 0, 0))  # the headlights are wanted still


def test_the_watchdog_is_the_bodys_business() -> None:
    robot = Robot()
    robot.receive_data(
        encode(DriveForward(9)) + encode(SteerLeft(9)) + encode(Headlights(1, 0, 0, 0)) + b"zzzzzzz"
    )
    assert (robot.heard, robot.malformed) == (3, 1)
    robot.stop()
    assert (robot.drive, robot.steer, robot.lights) == (0, 0, (True, False, False, False))


def test_a_reply_that_comes_just_before_the_first_probe_is_no_answer_to_it() -> None:
    way_back = Resynchronisation(Line(9600, 0.05), 0.0, retries=1)
    way_back.timed_out(1.0)
    way_back.replied(1.0, accepted=True)
    assert way_back.stage is Stage.QUIET  # once more from the start
    assert way_back.data_to_send(1.0) == b""


def test_attempts_that_fail_while_the_robot_boots_do_not_count() -> None:
    host = Host(retries=0, boot_s=1.0)
    wire = Wire(host, Robot())
    answers = [b"F", b"F", b"F", b"F"]
    wire.to_host = lambda reply: answers.pop() if answers and reply else reply
    host.connect(0.0)
    wire.run()
    assert kinds(wire) == ["InStep"]
