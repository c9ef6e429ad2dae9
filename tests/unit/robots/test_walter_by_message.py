"""Messages to a WALTER as somebody wrote them: the driver keeps account of what they do (W8, W10, W11)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from turtlewire.errors import LimitReachedError, MessageError, NotSupportedError, UsageError
from turtlewire.protocols.catalogue import codec
from turtlewire.protocols.walter.codec import encode
from turtlewire.protocols.walter.messages import LowerPen, RaisePen, SelectDirect, SelectLogo, StartForward
from turtlewire.simulator.world import Wall, World

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.unit.robots.conftest import Bench, MakeBench
    from turtlewire.simulator.walter import SimulatedWalter
    from turtlewire.turtle import Pose

    Settle = Callable[[SimulatedWalter, float], Pose]


def send(made: Bench, *texts: str, valid_s: float | None = None) -> None:
    made.turtle.send(*(codec("walter").parse(text) for text in texts), valid_s=valid_s)


def is_pen_down(made: Bench) -> bool:
    return made.turtle.is_pen_down


def goes_on(made: Bench, seconds: float) -> bool:
    wire = made.turtle._robot._wire
    made.turtle._runner.run(wire.until(lambda: False, wire.link.now() + seconds))
    return made.robot.is_moving


def is_where_the_turtle_is(made: Bench) -> bool:
    corrections = made.turtle.statistics.corrections
    made.turtle.finish()
    told = made.turtle.reported_pose()
    assert made.turtle.statistics.corrections == corrections, "the driver was surprised by where it is"
    return made.turtle.pose == pytest.approx(told, abs=0.6) == made.robot.pose


@pytest.mark.parametrize(
    ("text", "raw"),
    [
        ("forward 200", b"F\x00\xc8\r"),
        ("forward 13", b"F\x00\x0d\r"),  # the driver would have made two of it
        ("back 3000", b"B\x0b\xb8\r"),
        ("left 450", b"L\x01\xc2\r"),
        ("right 90", b"R\x00\x5a\r"),
        ("go_to 300 -200", encode(codec("walter").parse("go_to 300 -200"))),  # type: ignore[arg-type]
        ("go_to_x 300", b"CX\x01\x2c\r"),
        ("go_to_y -300", b"CY\xfe\xd4\r"),
        ("turn_to 270", b"CH\x01\x0e\r"),
        ("reset_location", b"CR\r"),
    ],
)
def test_it_goes_out_as_it_stands_and_the_turtle_is_where_it_leads(
    bench: MakeBench, text: str, raw: bytes
) -> None:
    made = bench()
    made.turtle.forward(50.3)
    made.turtle.right(30.4)
    made.turtle.finish()
    made.wire.forget()
    send(made, text)
    assert raw in made.wire.bytes_sent
    assert made.wire.bytes_sent.count(raw[:2]) == 1
    if text != "reset_location":
        assert is_where_the_turtle_is(made)
    made.turtle.forward(100.0)
    made.turtle.finish()
    assert made.error_mm < 1.5
    assert made.notes == []


def test_home_of_the_robot_is_its_own(bench: MakeBench) -> None:
    made = bench()
    made.turtle.forward(120.0)
    made.turtle.right(90.0)
    send(made, "go_home")
    assert is_where_the_turtle_is(made)
    assert made.turtle.pose[:2] == pytest.approx((0.0, 0.0), abs=0.6)


def test_after_the_robot_was_told_that_it_is_at_its_origin_the_turtle_is_where_it_was(
    bench: MakeBench,
) -> None:
    made = bench()
    made.turtle.forward(100.0)
    made.turtle.right(90.0)
    made.turtle.finish()
    before = made.turtle.pose
    send(made, "reset_location")
    assert made.turtle.pose == before
    made.turtle.finish()
    made.turtle.forward(50.0)
    made.turtle.set_position(0.0, 0.0)
    made.turtle.set_heading(0.0)
    made.turtle.finish()
    assert made.turtle.statistics.corrections == 0
    assert made.error_mm < 1.5
    assert made.robot.pose.distance_to(0.0, 0.0) < 1.5


def test_a_message_moves_the_turtle_before_it_is_done_and_a_stop_ends_it(
    bench: MakeBench, settle: Settle
) -> None:
    made = bench()
    send(made, "forward 2000", "right 90")
    assert made.turtle.pose == pytest.approx((0.0, 1000.0, 90.0))
    settle(made.robot, 2.0)
    made.turtle.stop()
    assert not goes_on(made, 0.5)
    made.turtle.finish()
    assert 100.0 < made.robot.pose.y_mm < 400.0
    assert made.error_mm < 1.5


def test_pen_speed_horn_and_lamp_are_known_to_the_driver(bench: MakeBench) -> None:
    made = bench()
    send(made, "pen_up")
    assert is_pen_down(made) is False
    send(made, "forward 100")
    send(made, "pen_down", "set_speed 50", "horn_low", "lamp_on", "empty_line", "forward 200")
    made.turtle.finish()
    assert is_pen_down(made) is True
    assert (made.robot.horn, made.robot.lamp) == ("low", True)
    assert made.turtle._robot._wire.speed == 50
    (stroke,) = made.strokes()
    assert stroke == [pytest.approx((0.0, 50.0)), pytest.approx((0.0, 150.0))]
    made.turtle.stop()
    made.turtle.forward(10.0)  # the speed is sent again, as it was set last
    made.turtle.finish()
    assert b"V\x32\r" in made.wire.bytes_sent.rpartition(b"1\r")[2]


def test_a_query_is_answered_and_says_no_more_than_that(bench: MakeBench) -> None:
    made = bench()
    made.wire.forget()
    send(made, "query_towards 0 100", "query_pen")
    assert b"QT" in made.wire.received
    assert b"QP\x01\r" in made.wire.received
    assert made.turtle.statistics.corrections == 0


def test_a_key_of_direct_control_starts_and_its_time_ends(bench: MakeBench) -> None:
    made = bench()
    send(made, "set_move_speed 100", "start_forward", valid_s=0.5)
    assert goes_on(made, 0.4)
    assert not goes_on(made, 0.3)
    assert 20.0 < made.robot.pose.y_mm < 70.0
    send(made, "start_right")
    assert goes_on(made, 3.0)
    send(made, "stop")
    assert not goes_on(made, 0.2)
    send(made, "raise_pen")
    assert is_pen_down(made) is False
    send(made, "lower_pen")
    assert is_pen_down(made) is True
    made.turtle.forward(10.0)
    made.turtle.finish()
    assert made.error_mm < 2.0


@pytest.mark.parametrize("message", [SelectDirect(), SelectLogo()])
def test_what_changes_the_mode_is_refused(bench: MakeBench, message: SelectDirect | SelectLogo) -> None:
    made = bench()
    made.wire.forget()
    with pytest.raises(UsageError, match="changes between Logo control and direct control by itself"):
        made.turtle.send(StartForward(), message)
    assert made.wire.sent == []


@pytest.mark.parametrize("text", ["x_reply 3", "limit_front", "set_speed 0"])
def test_what_no_host_says_is_refused_before_anything_leaves(bench: MakeBench, text: str) -> None:
    made = bench()
    made.wire.forget()
    with pytest.raises(MessageError):
        send(made, "forward 100", text)
    with pytest.raises(MessageError):
        made.turtle.send(codec("simple").parse("stop"))
    assert made.wire.sent == []


@pytest.mark.parametrize(
    ("lacks", "text"),
    [("H", "horn_low"), ("E", "lamp_on"), ("Q", "query_x"), ("C", "go_home"), ("Q", "go_home")],
)
def test_what_the_robot_lacks_is_refused(bench: MakeBench, lacks: str, text: str) -> None:
    groups = frozenset("CQHE") - {lacks}
    made = bench(robot={"groups": groups}, groups=groups)
    with pytest.raises(NotSupportedError):
        send(made, text)
    send(made, "forward 100", "right 90")
    made.turtle.finish()
    assert made.robot.pose[:2] == pytest.approx((0.0, 50.0), abs=0.6)


def test_a_calibrated_robot_has_coordinates_of_its_own(bench: MakeBench) -> None:
    made = bench(distance_scale=1.1)
    with pytest.raises(NotSupportedError, match="calibrated"):
        send(made, "go_to 100 100")


def test_a_limit_on_the_way_is_told(bench: MakeBench) -> None:
    made = bench(robot={"world": World((Wall(-500.0, 200.0, 500.0, 200.0),))})
    send(made, "forward 2000")
    with pytest.raises(LimitReachedError, match="front"):
        made.turtle.finish()
    made.turtle.back(50.0)
    made.turtle.finish()
    assert made.error_mm < 1.5


def test_the_pen_stays_as_it_is_where_a_key_is_sent(bench: MakeBench) -> None:
    made = bench()
    made.turtle.pen_up()
    made.wire.forget()
    send(made, "start_forward")
    assert encode(RaisePen()) in made.wire.bytes_sent
    assert encode(LowerPen()) not in made.wire.bytes_sent
