"""A driver and a simulated robot over a wire that is read and damaged (decisions W7..W15)."""

from __future__ import annotations

import itertools
import random
from typing import TYPE_CHECKING, Any

import pytest

from turtlewire.errors import (
    LimitReachedError,
    LinkClosedError,
    NoReplyError,
    PoseUncertainError,
    StoppedError,
    TurtlewireError,
)
from turtlewire.protocols.message import Malformed
from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import CommandDecoder, encode
from turtlewire.simulator.world import Wall, World
from turtlewire.turtle import Pose

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.unit.robots.conftest import Bench, MakeBench, Wire
    from turtlewire.simulator.walter import SimulatedWalter
    from turtlewire.turtle import Turtle

    Settle = Callable[[SimulatedWalter, float], Pose]

STOP, ATTENTION = m.EMERGENCY_STOP, m.ATTENTION
SUBSETS = [frozenset(s) for n in range(5) for s in itertools.combinations("CQHE", n)]


def commands(data: bytes) -> list[m.WalterMessage]:
    """The well-formed commands in what was sent."""
    return [item.message for item in CommandDecoder().receive_data(data) if not isinstance(item, Malformed)]


def draw(turtle: Turtle) -> None:
    """A bit of everything that moves."""
    turtle.forward(40.3)
    turtle.right(77.7)
    turtle.forward(-25.2)
    turtle.pen_up()
    turtle.set_position(30.0, -20.25)
    turtle.pen_down()
    turtle.set_x(55.5)
    turtle.set_y(11)
    turtle.set_heading(13)
    turtle.forward(20)
    turtle.arc(90, 15)
    turtle.home()
    turtle.back(5)
    turtle.left(30)


class Damage:
    """Changes chosen occurrences of something on its way: ``{1: b""}`` loses the second one."""

    def __init__(self, what: bytes, becomes: dict[int, bytes]) -> None:
        self._what, self._becomes = what, becomes
        self._seen = 0

    def __call__(self, data: bytes) -> bytes:
        if self._what in data:
            data = data.replace(self._what, self._becomes.get(self._seen, self._what), 1)
            self._seen += 1
        return data


class Replies:
    """What the host hears, answer by answer."""

    def __init__(self, change: Callable[[bytes], bytes]) -> None:
        self._change, self._held = change, b""

    def __call__(self, data: bytes) -> bytes:
        self._held += data
        lengths = {b"H": 5, b"X": 5, b"Y": 5, b"P": 4, b"L": 7}
        size = lengths.get(self._held[1:2], 2) if self._held[:1] == b"Q" else len(self._held)
        if len(self._held) < size:
            return b""
        whole, self._held = self._held, b""
        return self._change(whole)


# ---------------------------------------------------------------- connecting (W7, W10)


def test_w7_the_first_bytes_are_attention_and_then_a_query(bench: MakeBench) -> None:
    made = bench()
    assert made.wire.bytes_sent.startswith(ATTENTION + encode(m.QueryHeading()))
    assert made.turtle.groups == frozenset("CQHE")
    assert made.turtle.pose == Pose()
    made.turtle.finish()
    assert made.robot.pen_is_down
    assert made.robot.speed == 100
    assert made.notes == []


@pytest.mark.parametrize("groups", SUBSETS, ids=lambda groups: "".join(sorted(groups)) or "none")
def test_w10_every_robot_draws_the_same_picture(bench: MakeBench, groups: frozenset[str]) -> None:
    full = bench()
    draw(full.turtle)
    full.turtle.finish()
    known = bench({"groups": groups}, groups=groups)
    learned = bench({"groups": groups})
    for made in (known, learned):
        draw(made.turtle)
        made.turtle.finish()
        assert made.turtle.pose == pytest.approx(full.turtle.pose)
        assert made.error_mm < 1.0
        for stroke, wanted in zip(made.strokes(), full.strokes(), strict=True):
            for end, other in ((stroke[0], wanted[0]), (stroke[-1], wanted[-1])):
                assert end == pytest.approx(other, abs=1.0)
        assert made.robot.statistics.overflowed == 0
    assert ("C" in learned.turtle.groups) == ({"C", "Q"} <= groups)
    assert ("Q" in learned.turtle.groups) == ("Q" in groups)
    assert bool(learned.notes) == ("Q" not in groups)


def test_w10_home_is_c_0_and_then_c_h_0(bench: MakeBench) -> None:
    made = bench(groups=frozenset("CQHE"))
    made.turtle.forward(50)
    made.wire.forget()
    made.turtle.home()
    made.turtle.finish()
    sent = [c for c in commands(made.wire.bytes_sent) if type(c) not in m.REPLIES]
    assert sent == [m.GoHome(), m.TurnTo(0)]
    assert made.turtle.statistics.corrections == 0


def test_w10_absolute_moves_use_the_shortest_command(bench: MakeBench) -> None:
    made = bench(groups=frozenset("CQ"))
    made.wire.forget()
    made.turtle.set_position(20, 30)
    made.turtle.set_x(40)
    made.turtle.set_y(50)
    made.turtle.set_heading(90)
    made.turtle.set_heading(90)
    made.turtle.set_position(40, 50.1)  # less than a unit away: nothing is sent
    sent = [c for c in commands(made.wire.bytes_sent) if type(c) not in m.REPLIES]
    assert sent == [m.GoTo(40, 60), m.GoToX(80), m.GoToY(100), m.TurnTo(90)]


def test_w10_whether_c_is_there_is_asked_once(bench: MakeBench) -> None:
    made = bench({"groups": frozenset("Q")})
    made.turtle.set_position(20, 30)
    assert made.turtle.groups == frozenset("QHE")
    made.wire.forget()
    made.turtle.set_position(40, 30)
    assert not [c for c in commands(made.wire.bytes_sent) if isinstance(c, m.GoTo | m.GoToX | m.GoToY)]


def test_w10_a_c_move_that_ends_elsewhere_is_believed(bench: MakeBench) -> None:
    # The robot stops on its way to the first place: C is there, and the rest is driven.
    made = bench(prepare=lambda wire: setattr(wire, "to_robot", Damage(b"CL\x00\x28", {0: b"CL\x00\x20"})))
    made.turtle.set_position(20, 30)
    made.turtle.finish()
    assert "C" in made.turtle.groups
    assert made.robot.pose[:2] == pytest.approx((20.0, 30.0), abs=0.5)


def test_w5_beyond_16_bits_neither_c_nor_fences_are_trusted(bench: MakeBench) -> None:
    made = bench(groups=frozenset("CQ"), speed=255)
    made.wire.forget()
    made.turtle.set_position(17000, 20000)
    made.turtle.forward(70000)
    made.turtle.finish()
    sent = commands(made.wire.bytes_sent)
    assert not [c for c in sent if isinstance(c, m.GoTo | m.GoToX | m.GoToY)]
    assert made.error_mm <= 0.5 + 75000 * 0.00873
    assert made.turtle.statistics.corrections == 0
    made.turtle.home()
    made.turtle.finish()
    assert made.error_mm <= 1.0


def test_w10_a_robot_with_an_odometer_elsewhere_starts_at_home(bench: MakeBench) -> None:
    def drive_first(wire: Wire) -> None:
        wire.robot.write(b"R\x00\x5a\rF\x00\xc8\r")
        wire.robot.read(30.0)

    made = bench({"baud": None}, prepare=drive_first)
    made.turtle.forward(50)
    made.turtle.home()
    made.turtle.finish()
    assert made.turtle.pose == Pose()
    assert made.robot.pose == Pose(100.0, 0.0, 90.0)
    assert made.turtle.reported_pose() == Pose()


def mute(_: bytes) -> bytes:
    """A robot that is not heard."""
    return b""


def test_w10_a_robot_that_never_answers_is_run_as_a_basic_one(bench: MakeBench) -> None:
    made = bench(prepare=lambda wire: setattr(wire, "to_host", mute))
    assert made.turtle.groups == frozenset()
    assert "answers no queries" in made.notes[0]
    draw(made.turtle)
    made.turtle.finish()
    assert made.error_mm < 1.0
    made.wire.forget()
    assert made.turtle.statistics.fences == 0


def test_w10_replies_may_be_required(bench: MakeBench) -> None:
    with pytest.raises(NoReplyError, match="does not answer"):
        bench({"groups": frozenset()}, require_replies=True)


def test_a_robot_that_answers_rubbish_is_refused(bench: MakeBench) -> None:
    with pytest.raises(NoReplyError, match="does not speak WALTER's protocol"):
        bench(prepare=lambda wire: setattr(wire, "to_host", lambda data: b"?" * len(data) + b"\r"))


def test_a_failed_connection_is_closed_with_a_stop(bench: MakeBench) -> None:
    wires: list[Wire] = []
    with pytest.raises(NoReplyError):
        bench({"groups": frozenset()}, prepare=wires.append, require_replies=True)
    assert wires[0].bytes_sent.endswith(STOP)


def test_a_robot_that_boots_for_two_seconds_is_found(bench: MakeBench) -> None:
    made = bench({"boot_s": 2.0})
    assert made.turtle.groups == frozenset("CQHE")
    assert made.robot.statistics.lost_bytes > 0
    assert 2.0 < made.robot.now < 2.6
    made.turtle.forward(10)
    made.turtle.finish()
    assert made.error_mm < 0.1


def test_one_lost_answer_does_not_make_a_robot_silent_after_a_stop(bench: MakeBench) -> None:
    made = bench(boot_s=0.0)
    made.turtle.stop()
    made.wire.to_host = Replies(Damage(b"QH", {0: b"Q?", 1: b""}))
    made.turtle.forward(10)
    made.turtle.finish()
    assert made.error_mm < 0.1


# ---------------------------------------------------------------- splitting, window (W5, W8, W9, W12)


def test_w8_gentle_moves_have_no_0d_or_0a(bench: MakeBench) -> None:
    made = bench(max_unfenced=64, speed=255)
    other = bench(gentle=False)
    for value in (5, 6.5, 13 * 128, 10 * 128 + 5):
        for one in (made, other):
            one.wire.forget()
            one.turtle.forward(value)
        assert len([c for c in commands(made.wire.bytes_sent) if isinstance(c, m.Forward)]) == 2
        assert [c for c in commands(other.wire.bytes_sent) if isinstance(c, m.Forward)] == [
            m.Forward(int(value * 2))
        ]
    for angle in (10, -13, 266):
        made.wire.forget()
        made.turtle.right(angle)
        assert len([c for c in commands(made.wire.bytes_sent) if isinstance(c, m.Right | m.Left)]) == 2
    made.wire.forget()
    made.turtle.set_heading(10)  # C H 10 would not be gentle
    made.turtle.finish()
    assert not [c for c in commands(made.wire.bytes_sent) if isinstance(c, m.TurnTo)]
    assert made.error_mm < 2.0


def test_w12_what_is_negative_is_the_opposite_and_nothing_is_nothing(bench: MakeBench) -> None:
    made = bench()
    made.wire.forget()
    made.turtle.forward(-10.5)
    made.turtle.back(-4)
    made.turtle.right(-5)
    made.turtle.left(-6)
    made.turtle.forward(0)
    made.turtle.right(0)
    sent = [c for c in commands(made.wire.bytes_sent) if type(c) not in m.REPLIES]
    assert sent == [m.Back(21), m.Forward(8), m.Left(5), m.Right(6)]


@pytest.mark.parametrize("window", [16, 24, 48])
def test_w9_the_window_is_used_and_never_exceeded(bench: MakeBench, window: int) -> None:
    made = bench(max_unfenced=window)
    for _ in range(50):
        made.turtle.forward(3)
        made.turtle.right(11)
    made.turtle.finish()
    assert window - 6 - 6 <= made.wire.largest <= window
    assert made.robot.statistics.overflowed == 0


def test_step_by_step_each_motion_ends_before_the_next(bench: MakeBench) -> None:
    made = bench()
    made.turtle.set_step_by_step(True)
    for _ in range(3):
        made.turtle.forward(30)
        assert not made.robot.is_moving
    made.turtle.set_step_by_step(False)
    made.turtle.forward(30)
    assert made.robot.is_moving or made.robot.bytes_on_line


# ---------------------------------------------------------------- limits (W13)

ROOM = World((Wall(-300, 200, 300, 200), Wall(-300, -200, 300, -200)))


@pytest.mark.parametrize(
    ("heading", "distance", "sensor"), [(0, 500, "front"), (0, -500, "back"), (180, 500, "front")]
)
def test_w13_a_limit_is_an_error_with_sensor_and_pose(
    bench: MakeBench, heading: int, distance: int, sensor: str
) -> None:
    made = bench({"world": ROOM})
    made.turtle.set_heading(heading)
    made.turtle.set_speed(200)
    made.turtle.pen_up()
    made.turtle.forward(distance)
    made.wire.forget()

    def go_on() -> None:
        for _ in range(9):
            made.turtle.right(90)
            made.turtle.forward(10)
        made.turtle.finish()

    with pytest.raises(LimitReachedError) as caught:
        go_on()
    error = caught.value
    assert error.sensor == sensor
    assert (error.x_mm, error.y_mm, error.heading_deg) == tuple(made.turtle.pose)
    assert made.error_mm <= 0.5
    assert made.robot.pose.x_mm == pytest.approx(0.0, abs=1e-6)  # nothing sent ahead was run
    assert abs(made.robot.pose.y_mm) == pytest.approx(110.0)
    # Ahead of everything: the stop is the first that went out after the event; then attention.
    sent = made.wire.bytes_sent
    assert sent.index(STOP) < sent.index(ATTENTION)
    assert made.wire.discards >= 1
    assert sent[sent.index(ATTENTION) :].endswith(encode(m.SetSpeed(200)) + encode(m.PenUp()))
    made.turtle.finish()
    assert (made.robot.speed, made.robot.pen_is_down) == (200, False)
    # Towards the sensor again: refused again. Away: it goes.
    made.turtle.forward(distance / 10)
    with pytest.raises(LimitReachedError):
        made.turtle.finish()
    made.turtle.forward(-distance / 10)
    made.turtle.finish()
    assert made.error_mm <= 0.5


@pytest.mark.parametrize("sensor", ["left", "right"])
def test_w13_sensors_at_the_side(bench: MakeBench, sensor: str) -> None:
    made = bench()
    made.turtle.forward(100)
    made.wire.to_host = Damage(b"Q", {0: b"L" + sensor[0].upper().encode() + b"\rQ"})
    with pytest.raises(LimitReachedError, match=sensor):
        made.turtle.finish()
    assert made.error_mm <= 0.5


def test_w13_a_basic_robot_is_where_it_is_reckoned(bench: MakeBench) -> None:
    made = bench({"world": ROOM, "groups": frozenset()})
    made.turtle.forward(500)
    with pytest.raises(LimitReachedError, match="front"):
        made.turtle.finish()
    assert made.turtle.pose.y_mm == pytest.approx(110, abs=3.0)
    assert "by reckoning only" in made.notes[-1]
    made.turtle.back(50)
    made.turtle.finish()
    assert made.error_mm < 3.0


def test_w13_a_sensor_that_is_held_and_tells_so_again_and_again(bench: MakeBench) -> None:
    made = bench()
    made.turtle.forward(100)
    held = iter([True] * 4)
    made.wire.to_host = lambda data: b"LF\r" + data if data[:1] == b"Q" and next(held, False) else data
    with pytest.raises(LimitReachedError):
        made.turtle.finish()
    made.turtle.back(10)
    made.turtle.finish()
    assert made.error_mm <= 0.5


def test_w13_a_sensor_that_never_lets_go_is_no_hang(bench: MakeBench) -> None:
    made = bench()
    made.turtle.forward(100)
    made.wire.to_host = lambda data: b"LF\r" + data
    with pytest.raises(NoReplyError):
        made.turtle.finish()


# ---------------------------------------------------------------- stop (W8)


def test_w8_after_a_stop_nothing_follows_until_the_next_command(bench: MakeBench, settle: Settle) -> None:
    made = bench()
    for _ in range(20):
        made.turtle.forward(50)
    made.wire.forget()
    discards = made.wire.discards
    made.turtle.stop()
    assert made.wire.bytes_sent == STOP * 3
    assert made.wire.discards == discards + 1
    rest = settle(made.robot, 20.0)
    assert made.wire.bytes_sent == STOP * 3
    made.turtle.forward(10)
    assert made.wire.bytes_sent.startswith(STOP * 3 + ATTENTION)
    made.turtle.finish()
    assert made.error_mm <= 0.5
    assert made.robot.pose.distance_to(*rest[:2]) == pytest.approx(10.0)
    assert made.robot.statistics.distance_mm < 1000


def test_w8_a_stop_takes_back_what_has_not_gone_out(bench: MakeBench) -> None:
    made = bench({"baud": 300}, baud=300)
    made.turtle.forward(50)
    waiting = made.robot.bytes_on_line
    made.turtle.stop()
    assert waiting >= 4
    assert made.robot.bytes_on_line <= 3 * len(STOP) + 1


def test_a_stop_while_somebody_waits(bench: MakeBench) -> None:
    made = bench()
    end = made.robot.now + 0.5

    def stop_meanwhile(data: bytes) -> bytes:
        nonlocal end
        if made.robot.now > end:
            end = 1e9
            made.turtle.stop()
        return data

    made.turtle.forward(10)
    made.wire.to_host = stop_meanwhile

    def go_on() -> None:
        for _ in range(50):
            made.turtle.forward(10)

    with pytest.raises(StoppedError):
        go_on()
    made.turtle.forward(1)
    made.turtle.finish()
    assert made.error_mm <= 0.5


def test_a_stop_while_the_robot_is_attended_to_is_the_last_word(bench: MakeBench) -> None:
    made = bench()
    made.turtle.stop()
    made.wire.forget()

    def stop_now(data: bytes) -> bytes:
        made.wire.to_host = bytes
        made.turtle.stop()
        return data

    made.wire.to_host = stop_now
    with pytest.raises(StoppedError):
        made.turtle.forward(10)
    assert made.wire.bytes_sent.endswith(STOP)


def test_a_basic_robot_that_was_stopped_is_reckoned(bench: MakeBench, settle: Settle) -> None:
    made = bench({"groups": frozenset()})
    made.turtle.forward(100)
    settle(made.robot, 0.5)
    made.turtle.stop()
    settle(made.robot, 1.0)
    made.turtle.right(90)
    assert made.turtle.pose.y_mm == pytest.approx(made.robot.pose.y_mm, abs=3.0)
    made.turtle.stop()
    made.turtle.forward(0)  # stopped with nothing to interrupt, too
    made.turtle.finish()
    assert made.error_mm < 3.0


# ---------------------------------------------------------------- lost and damaged (W15)


def settled(made: Bench) -> tuple[float, int]:
    """Finish; the true error in mm, and how far the robot drove, in whole mm."""
    made.turtle.finish()
    return made.error_mm, round(made.robot.statistics.distance_mm)


def test_w15_a_lost_answer_repeats_nothing(bench: MakeBench) -> None:
    made = bench()
    made.wire.to_host = Replies(Damage(b"Q", {0: b"", 2: b""}))
    for _ in range(6):
        made.turtle.forward(20)
    error, driven = settled(made)
    assert error < 1e-6
    assert driven == 120
    assert "its pose shows that every motion was done" in made.notes[0]
    assert made.turtle.statistics.fences_lost >= 1


def test_w15_a_lost_move_is_made_again_because_the_pose_shows_it(bench: MakeBench) -> None:
    made = bench()
    made.wire.to_robot = Damage(encode(m.Forward(40)), {1: b""})
    for _ in range(3):
        made.turtle.forward(20)
        made.turtle.right(90)
    error, _ = settled(made)
    assert error < 1.0
    assert made.turtle.statistics.corrections >= 1


def test_w15_moves_and_their_fence_are_lost(bench: MakeBench) -> None:
    made = bench()
    made.wire.forget()
    made.wire.to_robot = Damage(encode(m.Back(40)), {0: b"", 1: b""})
    made.turtle.forward(30)
    made.turtle.back(20)
    made.wire.to_host = Replies(Damage(b"QH", {0: b""}))
    made.turtle.right(90)
    made.turtle.forward(40)
    error, driven = settled(made)
    assert error < 1.0
    assert driven <= 30 + 20 + 40 + 10


def test_w15_commands_that_are_known_to_be_lost_are_sent_again(bench: MakeBench) -> None:
    made = bench()
    made.turtle.finish()
    made.turtle.pen_up()
    made.turtle.finish()
    cut = {"on": True}
    made.wire.to_robot = lambda data: b"" if cut["on"] else data
    made.turtle.forward(20)
    made.turtle.pen_down()
    made.turtle.right(90)
    made.turtle.forward(20)
    sent = len(made.wire.sent)
    original = made.wire.write

    def write(data: bytes) -> None:
        cut["on"] = len(made.wire.sent) < sent + 1
        original(data)

    made.wire.write = write  # type: ignore[method-assign] # the line is mended after the next bytes
    error, driven = settled(made)
    assert error < 0.5
    assert driven == 40
    assert "commands got lost on the way; the pose shows which, they are sent again" in made.notes[0]
    (stroke,) = made.strokes()
    assert stroke[-1] == pytest.approx((20.0, 20.0), abs=0.1)
    assert stroke[0] == pytest.approx((0.0, 20.0), abs=0.1)


def test_w15_a_damaged_argument_shows_in_the_pose(bench: MakeBench) -> None:
    made = bench()
    made.wire.to_robot = Damage(encode(m.Forward(41)), {0: encode(m.Forward(41 + 128))})
    made.turtle.forward(20.5)
    error, _ = settled(made)
    assert error < 0.5
    assert "64.0 mm from where it should be" in made.notes[0]


@pytest.mark.parametrize("damaged", [b"QL", b"QH", b"QX", b"QY"])
def test_w15_a_damaged_answer_is_not_believed(bench: MakeBench, damaged: bytes) -> None:
    made = bench()

    def flip(data: bytes) -> bytes:
        if data[:2] != damaged:
            return data
        made.wire.to_host = bytes
        return data[:3] + bytes([data[3] ^ 0x40]) + data[4:]

    made.turtle.forward(60)
    made.turtle.right(45)
    made.wire.to_host = Replies(flip)
    made.turtle.finish()
    made.wire.to_host = Replies(flip)
    assert made.turtle.reported_pose() == pytest.approx((0.0, 60.0, 45.0))
    error, driven = settled(made)
    assert (error < 0.5, driven) == (True, 60)


def test_w15_a_robot_whose_pen_answers_are_wrong_is_not_asked_for_ever(bench: MakeBench) -> None:
    made = bench()
    made.wire.to_host = Replies(lambda data: b"QP\x00\r" if data[:2] == b"QP" else data)
    for _ in range(12):
        made.turtle.forward(20)
        made.turtle.finish()
    assert "contradict" in made.notes[-1]
    assert made.notes[-1] == made.notes[0]
    assert made.error_mm < 0.5


def test_w15_a_lost_pen_command_is_noticed(bench: MakeBench) -> None:
    made = bench()
    made.wire.to_robot = Damage(encode(m.PenUp()), {0: b""})
    made.turtle.forward(10)
    made.turtle.pen_up()
    made.turtle.finish()
    assert not made.robot.pen_is_down
    assert made.notes == []


def test_w15_silence_is_an_error_and_a_stop(bench: MakeBench) -> None:
    made = bench()
    made.turtle.forward(20)
    made.wire.to_host = mute
    with pytest.raises(NoReplyError):
        made.turtle.finish()
    with pytest.raises(NoReplyError):
        made.turtle.forward(20)


def test_w15_a_robot_that_answers_again_was_stopped_and_says_where_it_is(bench: MakeBench) -> None:
    made = bench()
    made.turtle.forward(20)
    made.wire.to_host = mute

    def hear_attention(data: bytes) -> bytes:
        if ATTENTION in data:
            made.wire.to_host = bytes
        return data

    made.wire.to_robot = hear_attention
    with pytest.raises(PoseUncertainError, match="Nothing was resumed"):
        made.turtle.finish()
    assert made.error_mm < 0.5
    made.turtle.forward(20)
    error, driven = settled(made)
    assert error < 0.5
    assert driven == 40


def test_a_robot_that_answers_headings_only_is_no_hang(bench: MakeBench) -> None:
    with pytest.raises(NoReplyError, match="cannot be talked to"):
        bench(
            prepare=lambda wire: setattr(
                wire, "to_host", Replies(lambda data: data if data[:2] == b"QH" else b"")
            ),
            boot_s=0.0,
        )


def test_a_robot_that_is_elsewhere_each_time_is_given_up(bench: MakeBench) -> None:
    made = bench()
    rng = random.Random(1)

    def anywhere(data: bytes) -> bytes:
        return encode(m.LocationReply(rng.randrange(999), 0)) if data[:2] == b"QL" else data

    made.turtle.forward(20)
    made.wire.to_host = Replies(anywhere)
    with pytest.raises(PoseUncertainError, match="each time it is asked"):
        made.turtle.finish()


def test_a_question_whose_answer_is_always_lost_is_given_up(bench: MakeBench) -> None:
    made = bench()
    made.wire.to_host = Replies(lambda data: b"" if data[:2] == b"QT" else data)
    with pytest.raises(PoseUncertainError):
        made.turtle.ask(m.QueryTowards(1, 2))
    made.wire.to_host = bytes
    assert made.turtle.ask(m.QueryTowards(200, 0)) == m.TowardsReply(90)


def test_a_robot_that_was_pushed_is_driven_back(bench: MakeBench) -> None:
    made = bench({"noise": 6.0, "seed": 4})
    for _ in range(10):
        made.turtle.forward(100)
        made.turtle.right(36)
    made.turtle.finish()
    reported = made.turtle.reported_pose()
    assert reported.distance_to(*made.turtle.pose[:2]) <= 1.5
    assert made.turtle.statistics.corrections > 0
    assert not [note for note in made.notes if "sent again" in note]


@pytest.mark.parametrize("groups", [frozenset("CQHE"), frozenset()], ids=["full", "basic"])
def test_whoever_is_told_something_may_stop_the_robot_there(bench: MakeBench, groups: frozenset[str]) -> None:
    """What was about to be sent is not: the command ends as any that a stop ends, and the next one goes on."""
    made = bench({"groups": groups})

    def stop(text: str) -> None:
        made.notes.append(text)
        made.turtle.stop()

    made.turtle.forward(20)
    made.turtle.finish()
    wire = made.turtle._robot._wire
    wire.notify = stop
    commands: list[Callable[[], object]] = [made.turtle.finish]
    if groups:
        made.wire.to_robot = Damage(encode(m.Forward(60)), {0: b""})
        made.turtle.forward(30)
    else:
        commands.insert(0, lambda: made.turtle.drive(0.5, 0.0))
    for command in commands:
        with pytest.raises(StoppedError):
            command()
        stood = made.robot.pose
        assert made.wire.bytes_sent.endswith(STOP)
        made.robot.read(made.robot.now + 2.0)
        assert made.robot.pose.distance_to(*stood[:2]) < 0.01
    wire.notify = made.notes.append
    made.turtle.forward(10)
    error, _ = settled(made)
    assert error < 0.5


@pytest.mark.parametrize("learns", [True, False])
def test_w7_a_robot_that_answers_nothing_is_told_more_than_once(bench: MakeBench, learns: bool) -> None:
    made = bench({"groups": frozenset()}, groups=None if learns else frozenset())
    begun = made.wire.bytes_sent.index(b"V")
    assert made.wire.bytes_sent[:begun].endswith(STOP * 2 + ATTENTION + b"1\r\r")
    made.wire.forget()
    made.turtle.stop()
    made.turtle.forward(5)
    assert made.wire.bytes_sent.startswith(STOP * 5 + ATTENTION + b"1\r\r")


class Noise:
    """Loses, adds and flips bytes."""

    def __init__(self, seed: int, rate: float) -> None:
        self._random, self._rate = random.Random(seed), rate

    def __call__(self, data: bytes) -> bytes:
        out = bytearray()
        for byte in data:
            what = self._random.randrange(3) if self._random.random() < self._rate else None
            if what == 0:
                continue
            if what == 1:
                out.append(self._random.randrange(256))
            out.append(byte ^ (1 << self._random.randrange(8)) if what == 2 else byte)
        return bytes(out)


@pytest.mark.parametrize(("rate", "most_errors"), [(0.001, 4), (0.01, 32)])
def test_w15_noise_ends_in_the_right_place_or_in_an_error(
    bench: MakeBench, rate: float, most_errors: int
) -> None:
    outcomes: list[Any] = []
    for seed in range(60):
        try:
            made = bench(prepare=lambda wire: setattr(wire, "to_robot", bytes))
            made.wire.to_robot, made.wire.to_host = Noise(seed, rate), Noise(seed + 1000, rate)
            for i in range(36):
                made.turtle.forward(20.3)
                made.turtle.right(10)
                if i % 9 == 0:
                    made.turtle.pen_up()
                    made.turtle.set_position(i, 10)
                    made.turtle.pen_down()
            made.turtle.finish()
            outcomes.append(made.error_mm <= 2.0)
        except TurtlewireError as error:
            outcomes.append(type(error))
    errors = [outcome for outcome in outcomes if isinstance(outcome, type)]
    assert set(errors) <= {PoseUncertainError, NoReplyError, LimitReachedError}
    assert len(errors) <= most_errors
    assert outcomes.count(False) <= 1


# ---------------------------------------------------------------- watchdog (section 4)


def test_a_heartbeat_feeds_a_watchdog(bench: MakeBench) -> None:
    made = bench({"watchdog_s": 1.0}, heartbeat_s=0.4)
    made.turtle.forward(1000)
    made.turtle.finish()
    assert (made.robot.statistics.watchdog_stops, made.error_mm) == (0, 0.0)
    assert b"\r\r\r" in made.wire.bytes_sent


def test_without_a_heartbeat_the_watchdog_stops_the_robot_and_the_driver_notices(bench: MakeBench) -> None:
    made = bench({"watchdog_s": 1.0})
    made.turtle.forward(150)
    made.turtle.finish()
    assert made.robot.statistics.watchdog_stops >= 1
    assert made.turtle.statistics.corrections >= 1
    assert made.error_mm < 1.0
    assert made.notes


# ---------------------------------------------------------------- calibration, ways out


def test_w14_a_basic_robot_is_paced_by_its_calibration(bench: MakeBench) -> None:
    fast, slow = bench({"groups": frozenset()}), bench({"groups": frozenset()}, mm_per_s_per_unit=0.5)
    turning = bench({"groups": frozenset()}, deg_per_s_per_unit=0.25)
    for made in (fast, slow, turning):
        start = made.robot.now
        made.turtle.forward(200)
        made.turtle.right(100)
        made.turtle.finish()
        made.notes.append(str(made.robot.now - start))
    took = [float(made.notes[-1]) for made in (fast, slow, turning)]
    assert took[0] == pytest.approx(3.2, abs=0.1)  # with the pen at the start
    assert took[1] == pytest.approx(5.2, abs=0.1)
    assert took[2] == pytest.approx(6.2, abs=0.1)


def test_the_end_of_a_with_block_waits_and_then_stops(bench: MakeBench) -> None:
    made = bench()
    with made.turtle as turtle:
        turtle.forward(100)
    assert made.robot.pose.y_mm == pytest.approx(100.0)
    assert made.wire.bytes_sent.endswith(STOP)
    made.turtle.close()
    for use in (made.turtle.finish, lambda: made.turtle.forward(1), made.turtle.stop):
        with pytest.raises(LinkClosedError):
            use()


def test_an_error_in_a_with_block_stops_at_once(bench: MakeBench, settle: Settle) -> None:
    made = bench()

    def fail() -> None:
        with made.turtle as turtle:
            turtle.forward(100)
            settle(made.robot, 0.5)
            turtle.forward(1 / 0)

    with pytest.raises(ZeroDivisionError):
        fail()
    assert made.wire.bytes_sent.endswith(STOP)
    assert 10.0 < settle(made.robot, 10.0).y_mm < 60.0


def test_the_loss_of_the_last_reference_stops(bench: MakeBench) -> None:
    made = bench()
    made.turtle.forward(100)
    made.turtle._finalizer()
    assert made.wire.bytes_sent.endswith(STOP)


def test_a_robot_that_is_moved_each_time_it_has_arrived_is_given_up(bench: MakeBench) -> None:
    made = bench()
    made.turtle.forward(20)
    # Somebody pushes it whenever it is asked for its pen.
    made.wire.to_robot = lambda data: data.replace(b"QP\r", encode(m.Forward(61)) + b"QP\r")
    with pytest.raises(PoseUncertainError, match="each time it is asked"):
        made.turtle.finish()
