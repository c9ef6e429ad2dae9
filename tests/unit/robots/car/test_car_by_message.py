"""Messages to a car as somebody wrote them: the driver keeps account of what they do (S5, S8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from turtlewire.errors import MessageError
from turtlewire.protocols.catalogue import codec

if TYPE_CHECKING:
    from tests.unit.robots.car.conftest import Bench, MakeBench


def send(made: Bench, *texts: str, valid_s: float | None = None) -> None:
    made.turtle.send(*(codec("simple").parse(text) for text in texts), valid_s=valid_s)


def test_messages_go_out_as_they_stand_and_are_accepted(bench: MakeBench) -> None:
    made = bench()
    made.wire.sent.clear()
    send(
        made, "steer_left 100", "headlights 1 0 0 1", "drive_backward 120", "steer_right 7", "drive_forward 0"
    )
    assert b"".join(data for _, data in made.wire.sent) == (b"L100000H100100B120000R007000F000000")
    assert made.robot.lights == (True, False, False, True)


def test_what_it_is_told_is_known_to_the_driver_and_its_time_ends(bench: MakeBench) -> None:
    made = bench()
    send(made, "drive_forward 200", valid_s=0.5)
    assert made.goes_on(0.4)
    assert not made.goes_on(0.6)
    assert made.turtle.pose.y_mm > 30.0
    assert made.off_mm < 10.0
    send(made, "drive_forward 200")
    assert made.goes_on(3.0)
    send(made, "stop")
    assert not made.goes_on(0.5)
    assert made.off_mm < 15.0


def test_a_stop_among_messages_ends_what_goes_before_it(bench: MakeBench) -> None:
    made = bench()
    send(made, "drive_forward 255", "stop", "headlights 1 1 1 1")
    assert not made.goes_on(0.5)
    assert made.robot.lights == (True, True, True, True)


@pytest.mark.parametrize("text", ["accepted", "rejected"])
def test_what_no_host_says_is_refused_before_anything_leaves(bench: MakeBench, text: str) -> None:
    made = bench()
    made.wire.sent.clear()
    with pytest.raises(MessageError, match=text):
        send(made, "drive_forward 100", text)
    with pytest.raises(MessageError):
        made.turtle.send(codec("walter").parse("query_x"))
    with pytest.raises(MessageError, match="valid_s"):
        send(made, "drive_forward 100", valid_s=-1.0)
    assert made.wire.sent == []
