"""WALTER driven by hand, in direct control (decisions section 3, W8, W13)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from turtlewire.drive import Drive
from turtlewire.errors import LimitReachedError, LinkClosedError, MessageError, StoppedError, UsageError
from turtlewire.protocols.walter import messages as m
from turtlewire.protocols.walter.codec import Mode
from turtlewire.simulator.world import Wall, World

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.unit.robots.conftest import Bench, MakeBench
    from turtlewire.simulator.walter import SimulatedWalter
    from turtlewire.turtle import Pose

    Settle = Callable[[SimulatedWalter, float], Pose]


def goes_on(made: Bench, seconds: float) -> bool:
    """Let the host do what it does for some time; whether the robot moves then."""
    wire = made.turtle._robot._wire
    made.turtle._runner.run(wire.until(lambda: False, wire.link.now() + seconds))
    return made.robot.is_moving


@pytest.mark.parametrize(
    ("speed", "turn", "keys"),
    [
        (1, 0.5, b"G\xffA"),
        (-0.5, 0, b"G\x80Z"),
        (0.25, 0.5, b"B\x80."),
        (0, -1, b"B\xff,"),
        (0.001, 0, b"G\x01A"),
        (0, 0, b" "),
    ],
)
def test_set_points_are_keys_of_direct_control(
    bench: MakeBench, speed: float, turn: float, keys: bytes
) -> None:
    made = bench()
    made.wire.forget()
    made.turtle.drive(speed, turn)
    # X leaves the pen down: it takes the place of an argument that may be missing.
    assert made.wire.bytes_sent == 3 * m.EMERGENCY_STOP + b"X" + keys
    made.wire.forget()
    made.turtle.pen_up()
    made.turtle.drive(speed, turn)
    assert made.wire.bytes_sent.endswith(m.EMERGENCY_STOP + b"S" + keys)


def test_a_walter_is_a_drive_and_where_it_got_it_is_asked(bench: MakeBench) -> None:
    made = bench()
    assert isinstance(made.turtle, Drive)
    assert made.turtle.features == {"pen", "limits", "horn", "lamp"}
    made.turtle.drive(0.5, 0)
    assert goes_on(made, 1.0)
    made.turtle.drive(0, 0.5)
    assert goes_on(made, 0.5)
    made.turtle.forward(20)
    made.turtle.finish()
    assert made.error_mm < 1.5
    assert made.robot.statistics.distance_mm == pytest.approx(128.0 + 20.0, abs=5.0)
    assert made.turtle.pose.heading_deg == pytest.approx(64.0, abs=3.0)


def test_a_set_point_lives_as_long_as_it_is_valid(bench: MakeBench) -> None:
    made = bench()
    made.turtle.drive(0.5, 0, valid_s=0.3)
    assert goes_on(made, 0.25)
    made.turtle.drive(0.5, 0, valid_s=0.3)
    assert goes_on(made, 0.25)
    assert not goes_on(made, 0.2)
    made.turtle.drive(0.5, 0, valid_s=0.3)
    made.turtle.drive(0.5, 0)
    assert goes_on(made, 2.0)
    made.turtle.drive(0.5, 0, valid_s=0.5)
    made.turtle.forward(100)  # a program is no set-point
    made.turtle.finish()
    assert made.error_mm < 1.5


def test_driving_by_hand_takes_the_robot_from_a_program(bench: MakeBench) -> None:
    made = bench()
    at = made.robot.now + 0.5

    def drive_meanwhile(data: bytes) -> bytes:
        nonlocal at
        if made.robot.now > at:
            at = 1e9
            made.turtle.drive(-0.5, 0)
        return data

    made.wire.to_host = drive_meanwhile

    def go_on() -> None:
        for _ in range(50):
            made.turtle.forward(10)

    with pytest.raises(StoppedError):
        go_on()
    assert goes_on(made, 1.0)
    made.turtle.stop()
    assert not goes_on(made, 0.2)


def test_keys_of_its_own(bench: MakeBench) -> None:
    made = bench()
    made.turtle.press(m.SetMoveSpeed(50), m.RaisePen(), m.StartForward(), m.MoveFaster())
    assert goes_on(made, 0.5)
    assert (made.robot.speed, made.robot.pen_is_down, made.turtle.is_pen_down) == (51, False, False)
    made.turtle.forward(10)
    made.turtle.finish()
    assert (made.robot.speed, made.robot.pen_is_down) == (100, False)
    made.wire.forget()
    with pytest.raises(UsageError):
        made.turtle.press(m.SelectLogo())
    with pytest.raises(MessageError):
        made.turtle.press(m.SetMoveSpeed(256))
    with pytest.raises(MessageError):
        made.turtle.drive(0, 2)
    with pytest.raises(MessageError, match="valid_s"):
        made.turtle.drive(0, 1, valid_s=0)
    assert made.wire.bytes_sent == b""


def test_an_argument_that_was_taken_back_starts_nothing(bench: MakeBench, settle: Settle) -> None:
    made = bench()
    made.turtle.drive(0, 0)
    settle(made.robot, 0.1)
    made.robot.write(b"G")  # and its speed was taken back
    made.turtle.drive(0, 0.5)
    settle(made.robot, 0.2)
    assert made.robot.is_moving
    assert made.robot.statistics.distance_mm == 0.0


def test_w8_keys_neither_cut_a_stop_short_nor_build_a_backlog(bench: MakeBench, settle: Settle) -> None:
    made = bench({"baud": 300}, baud=300)
    made.turtle.forward(500)
    started = made.robot.now
    for n in range(5):
        made.turtle.drive(-1 + n / 10.0, 0)
        assert made.robot.bytes_on_line <= 3 * len(m.EMERGENCY_STOP) + 5
    made.turtle.stop()
    made.turtle.drive(0, 1)
    settle(made.robot, 1.5)
    assert (made.robot.is_moving, made.robot.turn_speed) == (True, 255)
    assert made.robot.now - started < 5.0
    assert made.robot.mode is Mode.DIRECT


def test_w8_keys_do_not_overtake_a_stop_that_has_not_gone_out(bench: MakeBench, settle: Settle) -> None:
    made = bench()
    made.turtle.forward(10)
    made.turtle.finish()
    # As when somebody is cut off who asks the robot where it is, and another one drives at once.
    made.turtle._robot._wire.host.emergency_stop(made.robot.now)
    made.turtle.drive(0.5, 0)
    settle(made.robot, 0.2)
    assert made.robot.is_moving
    assert made.robot.mode is Mode.DIRECT


def test_w13_a_limit_while_driven_by_hand(bench: MakeBench) -> None:
    made = bench({"world": World((Wall(-300, 200, 300, 200),))})
    made.turtle.drive(1, 0)
    with pytest.raises(LimitReachedError, match="front"):
        goes_on(made, 5.0)
    assert made.error_mm <= 0.5
    made.turtle.drive(-0.5, 0)
    assert goes_on(made, 0.5)
    made.turtle.drive(1, 0)
    session = made.turtle._robot._wire.session
    made.turtle._runner.run(session.until(lambda: False, made.robot.now + 2.0))
    assert made.error_mm < 2.0  # it does not go on in the account, though nobody has been told yet


def test_what_it_does_already_is_not_begun_anew(bench: MakeBench) -> None:
    made = bench()
    began: list[str] = []
    made.robot.events = lambda action: began.append(action.what)
    made.turtle.drive(0.4, 0, valid_s=0.2)
    made.wire.forget()
    for _ in range(5):
        assert goes_on(made, 0.15)
        made.turtle.drive(0.4, 0, valid_s=0.2)  # a key that is held: it only lives longer
    assert made.wire.bytes_sent == b""
    made.turtle.drive(0.5, 0)
    assert made.wire.bytes_sent == b"XG\x80"
    assert goes_on(made, 0.2)
    assert made.robot.speed == 128
    assert [what for what in began if "start" in what] == ["started start_forward"]
    made.wire.forget()
    made.turtle.drive(-0.5, 0)
    made.turtle.drive(0, 0)
    made.turtle.drive(0, 0)  # a stop may have got lost
    goes_on(made, 0.1)
    made.turtle.drive(0.5, 0)
    assert made.wire.bytes_sent == b"XG\x80ZX X XG\x80A"
    made.turtle.stop()
    made.wire.forget()
    made.turtle.drive(0.5, 0, valid_s=0.1)
    assert made.wire.bytes_sent == b"XG\x80A"
    assert not goes_on(made, 0.3)
    made.wire.forget()
    made.turtle.drive(0.5, 0)  # it was stopped meanwhile
    assert made.wire.bytes_sent == b"XG\x80A"


@pytest.mark.parametrize("groups", [frozenset("CQHE"), frozenset()], ids=["answers", "answers nothing"])
def test_where_it_gets_by_hand_is_reckoned(bench: MakeBench, groups: frozenset[str]) -> None:
    made = bench({"groups": groups})
    made.turtle.forward(100)
    made.turtle.finish()
    made.turtle.drive(0.5, 0)
    for _ in range(3):
        assert goes_on(made, 0.3)
        assert made.error_mm < 0.5
    made.turtle.drive(0, 0.2)
    assert goes_on(made, 0.5)
    assert made.turtle.pose.heading_deg == pytest.approx(made.robot.pose.heading_deg, abs=0.2)
    keys = (m.MoveFaster(), m.TurnSlower(), m.StartBackward(), m.StartLeft(), m.TurnFaster(), m.MoveSlower())
    for key in keys:
        made.turtle.press(key)
        goes_on(made, 0.25)
        assert made.error_mm < 0.5
        assert made.turtle.pose.heading_deg == pytest.approx(made.robot.pose.heading_deg, abs=0.4)
    made.turtle.press(m.SetMoveSpeed(255), m.MoveFaster(), m.StartForward())
    goes_on(made, 0.5)
    made.turtle.press(m.SetMoveSpeed(0), m.MoveSlower())
    goes_on(made, 0.5)
    made.turtle.press(m.MoveFaster())
    assert goes_on(made, 0.5)
    assert made.error_mm < 0.5
    made.turtle.stop()
    goes_on(made, 0.5)
    assert made.error_mm < 0.5
    made.turtle.drive(-1, 0, valid_s=0.2)
    assert not goes_on(made, 1.0)
    assert made.error_mm < 0.5
    made.turtle.forward(50)
    made.turtle.finish()
    assert made.error_mm < 1.5


def test_a_program_is_interrupted_where_it_was_by_reckoning(bench: MakeBench) -> None:
    made = bench({"groups": frozenset()})
    made.turtle.forward(400)
    goes_on(made, 1.0)
    made.turtle.drive(0, 0.2)
    assert goes_on(made, 0.5)
    assert 50.0 < made.robot.pose.y_mm < 150.0
    assert made.error_mm < 1.0


def test_a_robot_that_answers_nothing_is_somewhere_and_one_is_told(bench: MakeBench) -> None:
    made = bench({"groups": frozenset()})
    assert made.turtle.features == {"pen", "limits"}
    made.turtle.drive(0.5, 0)
    assert "where it gets by hand is reckoned, and not known" in made.notes[-1]


def test_the_end_of_a_with_block_stops_who_drives_by_hand(bench: MakeBench, settle: Settle) -> None:
    made = bench()
    made.turtle.drive(1, 0)
    made.turtle.close(finish=False)
    assert made.wire.bytes_sent.endswith(m.EMERGENCY_STOP)
    settle(made.robot, 0.1)
    assert not made.robot.is_moving
    with pytest.raises(LinkClosedError):
        made.turtle.drive(1, 0)
