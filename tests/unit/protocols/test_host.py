"""WALTER's host as a state machine: which bytes go out when, and what answers mean (decisions W7..W15)."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from turtlewire.errors import MessageError
from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import Mode, encode
from turtlewire.protocols.walter.host import (
    FENCE_BYTES,
    FENCES,
    GRACE_S,
    MAX_PROBES,
    Answer,
    Done,
    Event,
    FenceLost,
    Host,
    Limit,
    Silent,
)
from turtlewire.protocols.walter.robot import Robot

QH, QX, QY, QP = (encode(fence()) for fence in FENCES)
HEADING = encode(m.HeadingReply(90))
X, Y = encode(m.XReply(-3)), encode(m.YReply(4))
PEN = encode(m.PenReply(1))
FD = encode(m.Forward(200))
STOPS = 3 * m.EMERGENCY_STOP


def ready(**settings: float) -> Host:
    """A host that has the robot's attention."""
    host = Host(**settings)  # type: ignore[arg-type] # whatever the test sets
    host.attention(0.0)
    assert host.urgent_to_send() == m.ATTENTION
    return host


def mode_of(host: Host) -> Mode | None:
    """As it is by now."""
    return host.mode


def after_timeout(host: Host) -> list[Event]:
    """Let the next timeout come."""
    return host.timed_out(host.next_timeout())


# ---------------------------------------------------------------- attention, stop (W7, W8)


def test_nothing_but_a_stop_goes_out_before_the_first_attention() -> None:
    host = Host(heartbeat_s=1.0)
    host.submit(m.Forward(1))
    assert host.mode is None
    assert host.data_to_send(100.0) == b""
    assert host.next_timeout() == math.inf
    host.emergency_stop(0.0)
    assert host.urgent_to_send() == STOPS


def test_w7_attention_is_sent_once_and_forgets_what_waits() -> None:
    host = Host()
    host.submit(m.Forward(1))
    host.attention(0.0)
    assert not host.idle
    assert (host.urgent_to_send(), host.urgent_to_send()) == (m.ATTENTION, b"")
    assert host.mode is Mode.LOGO
    assert (host.idle, host.data_to_send(0.0)) == (True, b"")


def test_w8_a_stop_forgets_everything_and_nothing_follows_it() -> None:
    host = ready()
    for _ in range(40):
        host.submit(m.Forward(200))
    host.fence()
    assert host.data_to_send(0.0)
    host.emergency_stop(0.5)
    assert host.urgent_to_send() == STOPS
    assert host.mode is Mode.DIRECT
    assert (host.unsent, host.unfenced_bytes, len(host.unconfirmed)) == (0, 0, 0)
    host.submit(m.Forward(200))
    assert host.data_to_send(1.0) == b""
    assert host.next_timeout() == math.inf


@pytest.mark.parametrize("at", range(2 * len(m.EMERGENCY_STOP)))
@pytest.mark.parametrize("lost", [1, 9])
def test_w8_a_stop_is_heard_though_bytes_of_it_get_lost(at: int, lost: int) -> None:
    """One of those that follow is whole, whatever the robot was in the middle of."""
    host = ready()
    host.emergency_stop(0.0)
    data = host.urgent_to_send()
    for before in (b"F\0\x0d\rB\0", b"CL\0\0", b"2\rAG", b"2\r"):
        robot = Robot()
        robot.receive_data(before)
        acted = robot.receive_data(data[:at] + data[at + lost :])
        assert robot.mode is Mode.DIRECT
        assert robot.queued == 0
        assert acted[-1] == m.Stop()


@pytest.mark.parametrize("lost", range(2 * 9 + 11 + 3))
def test_w7_an_attention_that_nobody_answers_is_heard_though_a_byte_of_it_gets_lost(lost: int) -> None:
    host = ready()
    host.answers = False
    host.attention(0.0)
    data = host.urgent_to_send()
    assert len(data) == 2 * 9 + 11 + 3
    robot = Robot()
    robot.receive_data(b"F\0\x0d\rB\0")
    acted = robot.receive_data(data[:lost] + data[lost + 1 :])
    assert robot.queued == 0
    assert m.Stop() in acted
    robot.receive_data(b"F\0\x0d\r")
    assert (robot.mode, robot.queued) == (Mode.LOGO, 1)


def test_w7_attention_replaces_a_stop_that_has_not_gone_out() -> None:
    host = ready()
    host.emergency_stop(0.0)
    host.attention(0.0)
    assert host.urgent_to_send() == m.ATTENTION


def test_keys_of_direct_control_go_out_at_once() -> None:
    host = ready()
    host.emergency_stop(0.0)
    host.press(m.SetMoveSpeed(7))
    host.press(m.StartForward())
    assert host.mode == Mode.DIRECT
    host.press(m.SelectLogo())
    assert host.urgent_to_send() == STOPS + b"G\x07A1"
    assert mode_of(host) is Mode.LOGO


def test_a_command_out_of_range_is_refused_before_any_byte() -> None:
    host = ready()
    with pytest.raises(MessageError, match="distance_half_mm"):
        host.submit(m.Forward(65536))
    assert (host.unsent, host.data_to_send(0.0)) == (0, b"")


# ---------------------------------------------------------------- fences (W9)


def test_w9_a_fence_is_sent_when_wanted_and_rotates() -> None:
    host = ready()
    for query, reply in zip((QH, QX, QY, QP, QH), (HEADING, X, Y, PEN, HEADING), strict=True):
        host.submit(m.Forward(200), tag="move")
        host.fence()
        assert host.data_to_send(0.0) == FD + query
        done, answer = host.receive_data(reply, 0.0)
        assert done == Done(m.Forward(200), "move")
        assert isinstance(answer, Answer)
        assert answer.tag is None
        assert host.idle
    assert (host.fences_sent, host.fences_lost, host.commands_sent) == (5, 0, 10)


def test_w9_a_fence_with_nothing_before_it_is_not_sent() -> None:
    host = ready()
    host.fence()
    assert host.data_to_send(0.0) == b""
    assert host.next_timeout() == math.inf


def test_w9_without_being_wanted_a_fence_follows_after_twelve_bytes() -> None:
    host = ready()
    for _ in range(3):
        host.submit(m.Forward(200))
    assert host.data_to_send(0.0) == FD * 3 + QH
    host.submit(m.Forward(200))
    assert host.data_to_send(0.0) == FD  # its fence has time
    assert host.unconfirmed == (None,) * 5


def test_w9_a_query_of_its_own_is_a_fence() -> None:
    host = ready()
    host.submit(m.Forward(200), tag=1)
    host.submit(m.QueryLocation(), tag=2)
    host.fence()
    assert host.data_to_send(0.0) == FD + encode(m.QueryLocation())
    events = host.receive_data(encode(m.LocationReply(1, -2)), 0.0)
    assert events == [
        Done(m.Forward(200), 1),
        Answer(m.QueryLocation(), m.LocationReply(1, -2), 2),
    ]


def test_w9_the_window_closes_before_48_bytes_and_opens_with_an_answer() -> None:
    host = ready()
    for _ in range(40):
        host.submit(m.Forward(200))
    sent = host.data_to_send(0.0)
    assert 48 - MAX_PROBES * FENCE_BYTES - len(FD) - FENCE_BYTES < len(sent) <= 48 - MAX_PROBES * FENCE_BYTES
    assert sent.endswith(QY)  # nothing would be heard if the last bytes were no fence
    assert host.data_to_send(0.0) == b""
    host.receive_data(HEADING, 0.1)
    assert host.data_to_send(0.1).startswith(FD)


commands = st.one_of(
    st.builds(m.Forward, st.integers(0, 65535)),
    st.builds(m.GoTo, st.integers(-32768, 32767), st.integers(-32768, 32767)),
    st.sampled_from([m.PenUp(), m.PenDown(), m.QueryLocation(), m.QueryTowards(1, 2), m.GoHome()]),
)


@given(
    st.lists(commands, max_size=60),
    st.sampled_from([16, 17, 24, 48, 200]),
    st.lists(st.sampled_from(["answer", "lose", "wait"]), max_size=80),
)
def test_w9_never_more_than_the_window_is_unfenced(
    program: list[m.LogoCommand], window: int, happenings: list[str]
) -> None:
    host = ready(max_unfenced=window)
    for command in program:
        host.submit(command)
    host.fence()
    now = 0.0
    for what in [*happenings, *["answer"] * 300]:
        sent = host.data_to_send(now)
        assert 0 <= host.unfenced_bytes <= window
        assert len(sent) <= window
        queries = [f.command for f in host._flights if type(f.command) in m.REPLIES]
        if not queries:
            break
        if what == "wait":
            now = host.next_timeout()
            if Silent() in host.timed_out(now):
                assert host.idle
                return
        else:
            query = queries[0] if what == "answer" else queries[-1]
            host.receive_data(encode(reply_to(query)), now)
    assert host.idle
    assert host.unfenced_bytes == 0


def reply_to(query: m.LogoCommand) -> m.RobotMessage:
    """Some answer to a query."""
    reply = m.REPLIES[type(query)]
    return reply(*[0] * len(reply.FIELDS))


# ---------------------------------------------------------------- overdue answers (W15)


def test_w15_an_overdue_answer_is_asked_for_again_by_the_next_fence() -> None:
    host = ready()
    host.submit(m.Forward(200), duration_s=1.0, tag=1)
    host.fence()
    host.data_to_send(0.0)
    takes_s = 1.0 + 7 * 10.0 / 9600
    assert host.next_timeout() == pytest.approx(2.0 * takes_s + GRACE_S)
    assert host.timed_out(host.next_timeout() - 0.001) == []
    assert host.data_to_send(2.9) == b""
    assert after_timeout(host) == []
    assert host.data_to_send(3.1) == QX
    # The first answer was only late: nothing is lost.
    done, answer = host.receive_data(HEADING, 3.2)
    assert done == Done(m.Forward(200), 1)
    assert answer == Answer(m.QueryHeading(), m.HeadingReply(90), None)
    assert host.receive_data(X, 3.3) == [Answer(m.QueryX(), m.XReply(-3), None)]
    assert host.fences_lost == 0
    assert host.idle


def test_w15_after_a_probe_the_answer_may_take_as_long_as_all_that_is_under_way() -> None:
    host = ready()
    host.submit(m.QueryLocation())
    host.submit(m.Forward(200), duration_s=100.0)
    host.fence()
    host.data_to_send(0.0)
    assert host.next_timeout() < 2.0
    now = host.next_timeout()
    host.timed_out(now)
    host.data_to_send(now)
    assert host.next_timeout() > 200.0


def test_w15_when_a_later_answer_comes_what_was_before_is_uncertain() -> None:
    host = ready()
    host.submit(m.Forward(200), tag=1)
    host.fence()
    host.data_to_send(0.0)
    after_timeout(host)
    host.submit(m.Back(200), tag=2)
    assert host.data_to_send(3.0) == QX + encode(m.Back(200))
    events = host.receive_data(X, 3.0)
    assert events == [FenceLost((1, None)), Answer(m.QueryX(), m.XReply(-3), None)]
    assert (host.fences_lost, host.unconfirmed) == (1, (2,))
    host.fence()
    assert host.data_to_send(3.0) == QY
    assert host.receive_data(Y, 3.0)[0] == Done(m.Back(200), 2)


def test_w15_a_robot_that_answers_no_probe_is_silent() -> None:
    host = ready()
    host.submit(m.Forward(200), tag=1)
    host.fence()
    assert host.data_to_send(0.0) == FD + QH
    for probe in (QX, QY):
        assert after_timeout(host) == []
        assert host.data_to_send(host._busy_until) == probe
    assert after_timeout(host) == [Silent()]
    assert host.idle
    assert host.next_timeout() == math.inf
    assert host.timed_out(1e9) == []


def test_w15_an_answer_makes_the_robot_heard_again() -> None:
    host = ready()
    for _ in range(5):
        host.submit(m.Forward(200))
        host.fence()
        host.data_to_send(0.0)
        assert after_timeout(host) == []
        host.data_to_send(0.0)
        host.receive_data(encode(reply_to(host._flights[1].command)), 0.0)
        host.receive_data(encode(reply_to(host._flights[0].command)), 0.0)
        assert host.idle


def test_answers_to_nothing_that_was_asked_are_counted_and_ignored() -> None:
    host = ready()
    host.submit(m.Forward(200))
    host.fence()
    host.data_to_send(0.0)
    assert host.receive_data(X + encode(m.TowardsReply(1)), 0.0) == []
    assert host.receive_data(b"garbage\r" + b"\r", 0.0) == []
    assert (host.unexpected, host.malformed) == (2, 1)
    assert len(host.receive_data(HEADING, 0.0)) == 2


def test_the_rest_of_a_cut_off_reply_does_not_spoil_the_next() -> None:
    host = ready()
    host.submit(m.QueryHeading())
    host.data_to_send(0.0)
    assert host.receive_data(HEADING[:3], 0.0) == []
    assert len(host.receive_data(HEADING, 0.3)) == 1


def test_a_reply_may_come_in_pieces() -> None:
    host = ready()
    host.submit(m.QueryHeading())
    host.data_to_send(0.0)
    for i, byte in enumerate(HEADING[:-1]):
        assert host.receive_data(bytes([byte]), 0.2 * i) == []
    assert len(host.receive_data(HEADING[-1:], 0.8)) == 1


@pytest.mark.parametrize(
    ("event", "sensor"), [(b"LF\r", "front"), (b"LB\r", "back"), (b"ll\r", "left"), (b"LR\r\n", "right")]
)
def test_w13_a_limit_event_makes_the_stop_go_out_ahead_of_everything(event: bytes, sensor: str) -> None:
    host = ready()
    for _ in range(40):
        host.submit(m.Forward(200))
    host.data_to_send(0.0)
    assert host.receive_data(event, 0.1) == [Limit(sensor)]
    assert host.urgent_to_send() == STOPS
    assert host.data_to_send(0.1) == b""
    assert host.unsent == 0


# ---------------------------------------------------------------- a robot that answers nothing (W9, W10)


def test_w9_a_robot_that_answers_nothing_gets_one_command_at_a_time() -> None:
    host = ready()
    host.answers = False
    host.submit(m.Forward(200), duration_s=1.0, tag=1)
    host.submit(m.Back(100), duration_s=0.5, tag=2)
    host.fence()
    assert host.data_to_send(0.0) == FD
    assert host.data_to_send(0.5) == b""
    over = 1.0 + 4 * 10.0 / 9600
    assert host.next_timeout() == pytest.approx(over)
    assert host.timed_out(0.9) == []
    assert host.timed_out(host.next_timeout()) == [Done(m.Forward(200), 1)]
    assert host.unfenced_bytes == 0
    assert host.data_to_send(over) == encode(m.Back(100))
    assert not host.idle
    assert after_timeout(host) == [Done(m.Back(100), 2)]
    assert host.next_timeout() == math.inf
    assert host.timed_out(9.0) == []
    assert host.idle


def test_a_stop_tells_which_command_it_interrupted_and_how_far_it_was() -> None:
    host = ready()
    host.answers = False
    host.submit(m.Forward(200), duration_s=10.0, tag="move")
    host.data_to_send(0.0)
    host.emergency_stop(2.5)
    assert host.interrupted is not None
    tag, part = host.interrupted
    assert tag == "move"
    assert part == pytest.approx(0.25, abs=0.001)
    host.attention(9.0)  # interrupts nothing: what is known stays
    assert host.interrupted == (tag, part)


def test_a_command_that_should_be_over_was_interrupted_at_its_end() -> None:
    host = ready()
    host.answers = False
    host.submit(m.Forward(200), duration_s=1.0, tag="move")
    host.data_to_send(0.0)
    host.emergency_stop(5.0)
    assert host.interrupted == ("move", 1.0)


# ---------------------------------------------------------------- heartbeat (section 4)


def test_a_heartbeat_is_an_empty_line_whenever_nothing_else_was_sent() -> None:
    host = ready(heartbeat_s=1.0)
    assert host.data_to_send(0.0) == b"\r"
    assert host.next_timeout() == 1.0
    assert host.data_to_send(0.9) == b""
    assert host.data_to_send(1.0) == b"\r"
    host.submit(m.Forward(200), duration_s=50.0)
    assert host.data_to_send(1.5) == FD
    assert host.data_to_send(2.4) == b""
    assert host.next_timeout() == 2.5
    assert host.timed_out(2.5) == []
    assert host.data_to_send(2.5) == b"\r"
    assert host.unfenced_bytes == len(FD)


def test_a_heartbeat_goes_on_in_direct_control_and_for_a_robot_that_answers_nothing() -> None:
    host = ready(heartbeat_s=1.0)
    host.emergency_stop(0.0)
    assert host.data_to_send(5.0) == b"\r"
    host.attention(5.0)
    host.answers = False
    host.submit(m.Forward(200), duration_s=50.0)
    assert host.data_to_send(6.0) == FD
    assert host.next_timeout() == 7.0
    assert host.data_to_send(7.0) == b"\r"


def test_a_slow_line_gives_answers_more_time() -> None:
    slow, fast = ready(baud=300), ready(baud=115200)
    for host in (slow, fast):
        host.submit(m.QueryHeading())
        host.data_to_send(0.0)
    assert slow.next_timeout() == pytest.approx(2 * 3 * 10 / 300 + GRACE_S)
    assert fast.next_timeout() == pytest.approx(2 * 3 * 10 / 115200 + GRACE_S)
